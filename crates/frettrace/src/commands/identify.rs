//! `frettrace identify`.

use super::Session;
use clap::Args;
use frettrace::identify::{IdentifyOptions, identify};
use frettrace::report::words::percent;
use frettrace::results::Identification;
use std::fmt::Write;
use std::path::PathBuf;

/// Multi-step identification of a friction law, with intervals and what cannot be known
#[derive(Args, Debug)]
#[command(
    after_help = "Examples:\n  frettrace identify rig.h5 -o ID.json\n  frettrace identify damper.h5 -o ID.json --law auto"
)]
pub struct Arguments {
    /// Measurement file or contact record
    file: PathBuf,
    /// Where the result goes
    #[arg(short, long)]
    output: Option<PathBuf>,
    /// coulomb, stribeck, dahl, lugre, hybrid, or auto for the one the data speak for; without it the declared law
    #[arg(long)]
    law: Option<String>,
}

pub fn run(arguments: &Arguments, session: &Session) -> anyhow::Result<()> {
    let recording = frettrace_measurement::read(&arguments.file)?;
    let options = IdentifyOptions { law: arguments.law.clone() };
    let found = identify(&recording, &options, &session.progress)?;
    if let Some(path) = &arguments.output {
        let json = frettrace::store::to_json(path, &found)?;
        frettrace::store::write_text(path, &json)?;
    }
    session.answer(&found, &text(&found))
}

fn text(found: &Identification) -> String {
    let mut out = format!("law {}\n", found.law);
    for (name, value) in &found.parameters {
        let [low, high] = value.interval95;
        let known = if value.identifiable {
            format!("95 % in {low:.5e} … {high:.5e}")
        } else {
            "not identifiable".to_owned()
        };
        // Writing to a string cannot fail.
        let _ = writeln!(out, "  {name:22} {:13.6e} {:8} {known}", value.value, value.unit);
    }
    for step in &found.steps {
        let _ = writeln!(
            out,
            "  step: {} ({}): error {}",
            step.name,
            step.parameters.join(", "),
            percent(step.error)
        );
    }
    let error = found.error.acceleration.or(found.error.force);
    let floor = found.error.noise_floor;
    let _ = writeln!(out, "error {}, noise floor {}", error.map_or("-".into(), percent), percent(floor));
    if let Some(held) = &found.held_out {
        let error = held.error.acceleration.or(held.error.force);
        let _ = writeln!(
            out,
            "held out: error {}, noise floor {}",
            error.map_or("-".into(), percent),
            percent(held.error.noise_floor)
        );
    }
    for note in &found.notes {
        let _ = writeln!(out, "note: {note}");
    }
    out
}
