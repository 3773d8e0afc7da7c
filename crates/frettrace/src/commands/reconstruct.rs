//! `frettrace reconstruct`.

use super::Session;
use clap::{Args, ValueEnum};
use frettrace::reconstruct::{FormChoice, ReconstructOptions, Reconstruction};
use frettrace::report::words::percent;
use serde::Serialize;
use std::path::PathBuf;

/// Inverse harmonic balance: contact forces, slip and displacement, with no friction law
#[derive(Args, Debug)]
#[command(
    after_help = "Examples:\n  frettrace reconstruct rig.h5 -o rec.h5\n  frettrace reconstruct rig.h5 -o rec.h5 --form harmonic"
)]
pub struct Arguments {
    /// Measurement file
    file: PathBuf,
    /// Result file (HDF5)
    #[arg(short, long)]
    output: PathBuf,
    /// Form of the answer
    #[arg(long, value_enum, default_value_t = Form::Auto)]
    form: Form,
    /// Smooth the friction force by a periodic spline with knots where it bends
    #[arg(long)]
    splines: bool,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Form {
    /// By evidence
    Auto,
    /// Lines at multiples of the excitation frequency
    Harmonic,
    /// Lines at multiples of a fraction of the excitation frequency
    Subharmonic,
    /// The whole spectrum, bin by bin: impacts, sweeps, operating records
    Aperiodic,
}

#[derive(Serialize)]
struct Row {
    run: String,
    form: String,
    subharmonic_order: u32,
    fundamental_frequency_hz: f64,
    acceleration_error: f64,
    noise_floor: f64,
    balance_residual: f64,
    note: Option<String>,
}

pub fn run(arguments: &Arguments, session: &Session) -> anyhow::Result<()> {
    let measurement = frettrace_measurement::read_measurement(&arguments.file)?;
    let form = match arguments.form {
        Form::Auto => FormChoice::Auto,
        Form::Harmonic => FormChoice::Harmonic,
        Form::Subharmonic => FormChoice::Subharmonic,
        Form::Aperiodic => FormChoice::Aperiodic,
    };
    let found = frettrace::reconstruct::reconstruct(
        &measurement,
        &ReconstructOptions { form, splines: arguments.splines, as_declared: false },
        &session.progress,
    )?;
    frettrace_measurement::write_reconstruction(&arguments.output, &found.result)?;
    let rows = rows(&found);
    session.answer(&rows, &text(&rows))
}

fn rows(found: &Reconstruction) -> Vec<Row> {
    found
        .result
        .runs
        .iter()
        .zip(&found.inverse.runs)
        .map(|(run, inverse)| Row {
            run: run.id.clone(),
            form: format!("{:?}", run.form).to_lowercase(),
            subharmonic_order: run.subharmonic_order,
            fundamental_frequency_hz: run.fundamental_frequency,
            acceleration_error: run.acceleration_error,
            noise_floor: run.noise_floor,
            balance_residual: inverse.balance.reduced(),
            note: run.note.clone(),
        })
        .collect()
}

fn text(rows: &[Row]) -> String {
    let head = "run     form         order  frequency [Hz]  error     floor     balance residual\n";
    let lines = rows.iter().map(|row| {
        format!(
            "{:7} {:12} {:5} {:15.4}  {:8}  {:8}  {:8.2}  {}\n",
            row.run,
            row.form,
            row.subharmonic_order,
            row.fundamental_frequency_hz,
            percent(row.acceleration_error),
            percent(row.noise_floor),
            row.balance_residual,
            row.note.as_deref().unwrap_or("")
        )
    });
    head.to_owned() + &lines.collect::<String>()
}
