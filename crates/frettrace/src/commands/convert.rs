//! `frettrace convert`.

use super::Session;
use clap::Args;
use serde::Serialize;
use std::path::PathBuf;

/// Laboratory files (UFF 58, MATLAB, CSV, LVM, JSON) and a small TOML to a measurement file or contact record
#[derive(Args, Debug)]
#[command(after_help = "Examples:\n  frettrace convert run1.csv --guess > rig.toml\n  \
    frettrace convert run1.csv run2.csv --rig rig.toml -o rig.h5")]
pub struct Arguments {
    /// Laboratory files
    #[arg(required = true)]
    files: Vec<PathBuf>,
    /// What the columns are, with units and signs
    #[arg(long, required_unless_present = "guess")]
    rig: Option<PathBuf>,
    /// File to write
    #[arg(short, long, required_unless_present = "guess")]
    output: Option<PathBuf>,
    /// Print a TOML to start from instead
    #[arg(long, conflicts_with_all = ["rig", "output"])]
    guess: bool,
}

#[derive(Serialize)]
struct Guess {
    toml: String,
}

#[derive(Serialize)]
struct Answer<'a> {
    file: &'a PathBuf,
    remarks: &'a [String],
}

pub fn run(arguments: &Arguments, session: &Session) -> anyhow::Result<()> {
    let (Some(rig), Some(output)) = (&arguments.rig, &arguments.output) else {
        let guesses = arguments.files.iter().map(frettrace_measurement::guess);
        let toml = guesses.collect::<Result<Vec<_>, _>>()?.join("\n");
        return session.answer(&Guess { toml: toml.clone() }, &toml);
    };
    let converted = frettrace_measurement::convert(&arguments.files, rig)?;
    converted.write(output)?;
    for remark in &converted.remarks {
        session.log(remark);
    }
    let answer = Answer { file: output, remarks: &converted.remarks };
    session.answer(&answer, &format!("written: {}", output.display()))
}
