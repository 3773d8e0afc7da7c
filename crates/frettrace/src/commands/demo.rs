//! `frettrace demo`.

use super::{Session, tables};
use clap::Args;
use frettrace::{
    Progress,
    explain::ExplainOptions,
    inspect::{Inspection, inspect},
    reconstruct::{ReconstructOptions, reconstruct},
    report::words::verdict,
};
use frettrace_measurement::{Recording, read};

/// The whole loop on a measurement of the repository, whose file keeps silent about one effect
#[derive(Args, Debug)]
#[command(after_help = "Example:\n  frettrace demo")]
pub struct Arguments {}

/// Made by `frettrace simulate data/demo/rig.toml -o data/demo/rig.h5`; part of the program, so that it runs anywhere.
const MEASUREMENT: &[u8] = include_bytes!("../../../../data/demo/rig.h5");

pub fn run(session: &Session) -> anyhow::Result<()> {
    let folder = tempfile::tempdir()?;
    let path = folder.path().join("rig.h5");
    std::fs::write(&path, MEASUREMENT)?;
    let recording = read(&path)?;
    let steps = [held(&recording, &session.progress)?, recovered(&recording, &session.progress)?];
    let found = frettrace::explain::explain(&recording, &ExplainOptions::default(), &session.progress)?;
    let mut text = format!("{}\n\n{}\n\n", steps.join("\n"), verdict(&found));
    text += &tables::before_after("fitted runs", &found.error);
    if let Some(error) = &found.held_out {
        text += &tables::before_after("held-out runs", error);
    }
    session.answer(&found, &text)
}

fn held(recording: &Recording, progress: &Progress) -> anyhow::Result<String> {
    let Inspection::Measurement { title, runs, .. } = inspect(recording, progress)? else {
        return Ok(String::new());
    };
    let levels = runs.iter().map(|run| run.level);
    let (low, high) =
        levels.fold((f64::INFINITY, 0.0_f64), |(low, high), level| (low.min(level), high.max(level)));
    Ok(format!("measured      {title}: {} runs, {low:.1} to {high:.1} m/s²", runs.len()))
}

fn recovered(recording: &Recording, progress: &Progress) -> anyhow::Result<String> {
    let Recording::Measurement(measurement) = recording else {
        return Ok(String::new());
    };
    let found = reconstruct(measurement, &ReconstructOptions::default(), progress)?;
    let worst =
        found.result.runs.iter().map(|run| run.acceleration_error / run.noise_floor).fold(0.0, f64::max);
    Ok(format!(
        "recovered     contact force and slip without a law: accelerations met within {worst:.2} of the noise"
    ))
}
