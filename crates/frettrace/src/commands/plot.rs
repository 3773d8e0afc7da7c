//! `frettrace plot`.

use super::Session;
use clap::Args;
use frettrace::{
    report::{chart::Ink, figures, html},
    results::Explanation,
    store,
};
use serde::Serialize;
use std::path::PathBuf;

/// Draw a result as SVG files
#[derive(Args, Debug)]
#[command(
    after_help = "Example:\n  frettrace explain rig.h5 -o explain.json\n  frettrace plot explain.json -o figures"
)]
pub struct Arguments {
    /// Result of `explain`
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
    let found: Explanation = store::read_json(&arguments.result)?;
    store::make_folder(&arguments.output)?;
    let mut files = Vec::new();
    for figure in figures(&found, Ink::File) {
        let path = arguments.output.join(figure.name).with_extension("svg");
        store::write_text(&path, &figure.svg)?;
        files.push(path);
    }
    if let Some(path) = &arguments.report {
        let title = arguments.result.display().to_string();
        store::write_text(path, &html(&title, &found))?;
        files.push(path.clone());
    }
    let text: Vec<_> = files.iter().map(|path| path.display().to_string()).collect();
    session.answer(&Answer { files }, &text.join("\n"))
}
