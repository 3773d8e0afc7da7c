//! `frettrace plot`.

use super::Session;
use clap::Args;
use frettrace::{
    report::{self, Figure, chart::Ink},
    results::Explanation,
    store,
};
use frettrace_measurement::{Attribute, DataFile};
use serde::Serialize;
use std::path::PathBuf;

/// Figures of a measurement, a reconstruction, frequency responses or an explanation as SVG files
#[derive(Args, Debug)]
#[command(
    after_help = "Examples:\n  frettrace plot rig.h5 -o figures\n  frettrace plot rec.h5 -o figures\n  \
        frettrace plot explain.json -o figures --report report.html"
)]
pub struct Arguments {
    /// Measurement file, contact record, reconstruction, frequency responses (HDF5), or result of `explain` (JSON)
    result: PathBuf,
    /// Folder for the figures; made where it is missing
    #[arg(short, long)]
    output: PathBuf,
    /// The report besides, as `explain --report` writes it
    #[arg(long)]
    report: Option<PathBuf>,
}

#[derive(Serialize)]
struct Answer {
    files: Vec<PathBuf>,
}

pub fn run(arguments: &Arguments, session: &Session) -> anyhow::Result<()> {
    let figures = figures(arguments)?;
    store::make_folder(&arguments.output)?;
    let mut files = Vec::new();
    for figure in figures {
        let path = arguments.output.join(figure.name).with_extension("svg");
        store::write_text(&path, &figure.svg)?;
        files.push(path);
    }
    if let Some(path) = &arguments.report {
        let title = arguments.result.display().to_string();
        store::write_text(path, &report::html(&title, &store::read_json(&arguments.result)?))?;
        files.push(path.clone());
    }
    let text: Vec<_> = files.iter().map(|path| path.display().to_string()).collect();
    session.answer(&Answer { files }, &text.join("\n"))
}

/// What the file is shows in its first bytes: JSON begins with a brace.
fn figures(arguments: &Arguments) -> anyhow::Result<Vec<Figure>> {
    let path = &arguments.result;
    if store::is_json(path)? {
        return Ok(report::figures(&store::read_json::<Explanation>(path)?, Ink::File));
    }
    let file = DataFile::open(path)?;
    let format = file.attribute("/", "format")?;
    if format == Some(Attribute::Text("frettrace-response".into())) {
        return Ok(report::responses::figures(&file, Ink::File)?);
    }
    if format == Some(Attribute::Text("frettrace-reconstruction".into())) {
        return Ok(report::signals::reconstruction(&file, Ink::File)?);
    }
    Ok(report::signals::recording(&frettrace_measurement::read(path)?, Ink::File))
}
