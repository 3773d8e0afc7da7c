//! `frettrace simulate`.

use super::Session;
use clap::Args;
use frettrace::simulate::Simulation;
use frettrace_forward::march::Settling;
use serde::Serialize;
use std::path::PathBuf;

/// A synthetic measurement with its truth, from a rig and the effects it does not declare
#[derive(Args, Debug)]
#[command(
    after_help = "Examples:\n  frettrace simulate data/demo/rig.toml -o rig.h5\n  frettrace inspect rig.h5\n\nThe keys of RIG.toml carry their units; data/demo/rig.toml shows them."
)]
pub struct Arguments {
    /// Rig (TOML)
    rig: PathBuf,
    /// Measurement file made (HDF5)
    #[arg(short, long)]
    output: PathBuf,
    /// Leave out what only the simulation knows (/truth)
    #[arg(long)]
    without_truth: bool,
    /// Seed of noise and phases, in place of the rig's
    #[arg(long)]
    seed: Option<u64>,
}

#[derive(Serialize)]
struct Row {
    run: String,
    force_amplitude: String,
    level: f64,
    largest_slip: f64,
    period_in_excitation_periods: Option<usize>,
    march_rate_hz: f64,
    change_by_last_tightening: Option<f64>,
}

pub fn run(arguments: &Arguments, session: &Session) -> anyhow::Result<()> {
    let mut rig = frettrace::rig::read_rig(&arguments.rig)?;
    rig.seed = arguments.seed.unwrap_or(rig.seed);
    let made = frettrace::simulate::simulate(&rig, &session.progress)?;
    let truth = (!arguments.without_truth).then_some(&made.truth);
    frettrace_measurement::write_measurement(&arguments.output, &made.measurement, truth)?;
    let rows = rows(&made);
    let note = made.truth.words.iter().find(|(name, _)| name == "note");
    let note = note.map_or(String::new(), |(_, note)| format!("\nNote: {note}\n"));
    session.answer(&rows, &(text(&rows) + &note))
}

fn rows(made: &Simulation) -> Vec<Row> {
    let runs = made.measurement.runs.iter().zip(&made.truth.runs).zip(&made.settled).zip(&made.marching);
    runs.map(|(((run, truth), settled), marching)| Row {
        run: run.id.clone(),
        force_amplitude: run.label.clone(),
        level: run.acceleration.iter().map(|channel| root_mean_square(channel)).fold(0.0, f64::max),
        largest_slip: truth.slip_displacement.iter().fold(0.0, |most, u| most.max(u.abs())),
        period_in_excitation_periods: match settled {
            Settling::Periodic { multiple, .. } => Some(*multiple),
            Settling::NotPeriodic { .. } => None,
        },
        march_rate_hz: marching.rate,
        change_by_last_tightening: marching.change,
    })
    .collect()
}

fn root_mean_square(signal: &[f64]) -> f64 {
    (signal.iter().map(|x| x * x).sum::<f64>() / signal.len().max(1) as f64).sqrt()
}

fn text(rows: &[Row]) -> String {
    let head = "run     force       level [m/s²]  largest slip [m]  settled\n";
    let lines = rows.iter().map(|row| {
        let settled = match row.period_in_excitation_periods {
            Some(1) => "periodic".to_owned(),
            Some(order) => format!("periodic over {order} excitation periods"),
            None => "not periodic".to_owned(),
        };
        format!(
            "{:7} {:>8} {:15.3}  {:16.3e}  {settled}\n",
            row.run, row.force_amplitude, row.level, row.largest_slip
        )
    });
    head.to_owned() + &lines.collect::<String>()
}
