//! `frettrace modes`.

use super::Session;
use clap::Args;
use frettrace::hypotheses::{Level, hypotheses};
use frettrace::modes::{Mode, modes};
use frettrace::report::{self, chart::Ink, words::percent};
use frettrace::store;
use serde::Serialize;
use std::path::PathBuf;

/// Modes of the declared beam beside the measured ones, and how well fixed, real and harmonic-balance modes describe
/// the motion at each level
#[derive(Args, Debug)]
#[command(
    after_help = "Examples:\n  frettrace modes rig.h5\n  frettrace modes rig.h5 --plots figures\n  frettrace modes rig.h5 --json"
)]
pub struct Arguments {
    /// Measurement file
    file: PathBuf,
    /// Folder for plots against level, for each frequency, preload and lubrication; made where it is missing
    #[arg(short, long)]
    plots: Option<PathBuf>,
}

#[derive(Serialize)]
struct Answer {
    modes: Vec<Mode>,
    levels: Vec<Level>,
    /// Runs that the hypotheses do not describe.
    left_out: Vec<String>,
}

pub fn run(arguments: &Arguments, session: &Session) -> anyhow::Result<()> {
    let measurement = frettrace_measurement::read_measurement(&arguments.file)?;
    let levels = hypotheses(&measurement, &session.progress)?;
    if let Some(folder) = &arguments.plots {
        store::write_figures(folder, &report::levels::figures(&levels, Ink::File))?;
    }
    let described = |id: &String| levels.iter().any(|level| level.run == *id);
    let left_out = measurement.runs.iter().map(|run| run.id.clone()).filter(|id| !described(id)).collect();
    let found = Answer { modes: modes(&measurement)?, levels, left_out };
    let head = "mode  declared [Hz]  measured [Hz]  std [Hz]  difference  damping\n";
    let text = head.to_owned()
        + &found.modes.iter().map(mode_row).collect::<String>()
        + "\nerror of the accelerations, described by K fixed modes, K real modes of the level, harmonic balance\n"
        + "run      level [m/s²]  frequency [Hz]  preload [N]  lubricated  K        fixed        real  harmonic balance     noise  likeness\n"
        + &found.levels.iter().map(level_row).collect::<String>()
        + &left_out_row(&found.left_out);
    session.answer(&found, &text)
}

/// Why some runs have no row; nothing where all have one.
fn left_out_row(runs: &[String]) -> String {
    if runs.is_empty() {
        return String::new();
    }
    format!("without lines to describe (not periodic, or a single sensor): {}\n", runs.join(", "))
}

fn mode_row(mode: &Mode) -> String {
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

fn level_row(level: &Level) -> String {
    format!(
        "{:8} {:12.4}  {:14.4}  {:11.3}  {:>10}  {}  {:>11}  {:>10}  {:>16}  {:>8}  {:.6} (mode {})\n",
        level.run,
        level.level,
        level.frequency_hz,
        level.preload,
        level.lubricated.map_or("–", |yes| if yes { "yes" } else { "no" }),
        level.modes,
        percent(level.fixed),
        percent(level.real),
        percent(level.harmonic),
        percent(level.noise_floor),
        level.assurance,
        level.resembles + 1,
    )
}
