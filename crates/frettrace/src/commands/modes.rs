//! `frettrace modes`.

use super::Session;
use clap::Args;
use frettrace::modes::{Mode, modes};
use std::path::PathBuf;

/// Modes of the declared beam beside the measured ones: is the beam what the file says?
#[derive(Args, Debug)]
#[command(after_help = "Example:\n  frettrace modes rig.h5")]
pub struct Arguments {
    /// Measurement file
    file: PathBuf,
}

pub fn run(arguments: &Arguments, session: &Session) -> anyhow::Result<()> {
    let measurement = frettrace_measurement::read_measurement(&arguments.file)?;
    let found = modes(&measurement)?;
    let head = "mode  declared [Hz]  measured [Hz]  std [Hz]  difference  damping\n".to_owned();
    session.answer(&found, &(head + &found.iter().map(row).collect::<String>()))
}

fn row(mode: &Mode) -> String {
    let shown = |value: Option<f64>, decimals: usize, unit: &str| {
        value.map_or("–".to_owned(), |value| format!("{value:.decimals$}{unit}"))
    };
    let difference = mode.measured_hz.map(|measured| 100.0 * (measured / mode.declared_hz - 1.0));
    format!(
        "{:4}  {:13.4}  {:>13}  {:>8}  {:>10}  {:>7}\n",
        mode.number,
        mode.declared_hz,
        shown(mode.measured_hz, 4, ""),
        shown(mode.measured_std_hz, 4, ""),
        shown(difference, 3, " %"),
        shown(mode.damping_ratio.map(|ratio| 100.0 * ratio), 3, " %"),
    )
}
