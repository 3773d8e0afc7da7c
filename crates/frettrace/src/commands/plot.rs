//! `frettrace plot`.

use super::Session;
use clap::{Args, builder::PossibleValuesParser};
use frettrace::{
    StudyError,
    report::{self, Figure, Kind, chart::Ink},
    results::{Explanation, Identification},
    store,
};
use frettrace_measurement::{
    Attribute, ContactRecord, DataFile, Measurement, Recording, read, read_measurement,
};
use serde::{Serialize, de::Error};
use std::path::{Path, PathBuf};

/// Figures of a measurement, a reconstruction, frequency responses, an identified law or an explanation, as SVG and PNG files
#[derive(Args, Debug)]
#[command(
    after_help = "Examples:\n  frettrace plot rig.h5 -o figures --png\n  frettrace plot rec.h5 -o figures --measured rig.h5\n  \
        frettrace plot rig.h5 -o figures --only spectra,modes\n  \
        frettrace plot explain.json -o figures --report report.html"
)]
pub struct Arguments {
    /// Measurement file, contact record, reconstruction, frequency responses (HDF5), or result of `identify` or `explain` (JSON)
    result: PathBuf,
    /// Folder for the figures; made where it is missing
    #[arg(short, long)]
    output: PathBuf,
    /// PNG files besides, which need no fonts where they are shown
    #[arg(long)]
    png: bool,
    /// Kinds of figures that are drawn; without it all that the file holds
    #[arg(long, value_name = "KIND", value_delimiter = ',', value_parser = PossibleValuesParser::new(Kind::ALL.map(Kind::name)))]
    only: Vec<String>,
    /// Measurement file that a reconstruction was made from: accelerations measured and rebuilt, and what is left over
    #[arg(long, value_name = "FILE")]
    measured: Option<PathBuf>,
    /// The report besides, as `explain --report` writes it
    #[arg(long)]
    report: Option<PathBuf>,
}

#[derive(Serialize)]
struct Answer {
    files: Vec<PathBuf>,
}

pub fn run(arguments: &Arguments, session: &Session) -> anyhow::Result<()> {
    let source = Source::open(&arguments.result)?;
    source.check(arguments)?;
    let figures = wanted(source.figures(arguments)?, arguments, source.name())?;
    let report = match (&arguments.report, &source) {
        (Some(path), Source::Explanation(found)) => {
            Some((path, report::html(&arguments.result.display().to_string(), found)))
        }
        _ => None,
    };
    let mut files = store::write_figures(&arguments.output, &figures)?;
    if let Some((path, page)) = report {
        store::write_text(path, &page)?;
        files.push(path.clone());
    }
    let text: Vec<_> = files.iter().map(|path| path.display().to_string()).collect();
    session.answer(&Answer { files }, &text.join("\n"))
}

/// What is drawn from.
enum Source {
    Measurement(Box<Measurement>),
    Contact(Box<ContactRecord>),
    Reconstruction(DataFile),
    Response(DataFile),
    Identification(Box<Identification>),
    Explanation(Box<Explanation>),
}

impl Source {
    /// What the file is shows in its first bytes, as JSON begins with a brace, and in its format.
    fn open(path: &Path) -> anyhow::Result<Self> {
        if store::is_json(path)? {
            return Ok(Self::result(path)?);
        }
        let file = DataFile::open(path)?;
        Ok(match file.attribute("/", "format")? {
            Some(Attribute::Text(format)) if format == "frettrace-response" => Self::Response(file),
            Some(Attribute::Text(format)) if format == "frettrace-reconstruction" => {
                Self::Reconstruction(file)
            }
            _ => match read(path)? {
                Recording::Measurement(measurement) => Self::Measurement(Box::new(measurement)),
                Recording::Contact(record) => Self::Contact(Box::new(record)),
            },
        })
    }

    fn result(path: &Path) -> Result<Self, StudyError> {
        let found: serde_json::Value = store::read_json(path)?;
        if found.get("verdict").is_some() {
            Ok(Self::Explanation(Box::new(store::read_json(path)?)))
        } else if found.get("law").is_some() {
            Ok(Self::Identification(Box::new(store::read_json(path)?)))
        } else {
            let source = serde_json::Error::custom("it has neither a verdict nor a law");
            Err(StudyError::Json { path: path.to_owned(), source })
        }
    }

    fn name(&self) -> &'static str {
        match self {
            Self::Measurement(_) => "a measurement file",
            Self::Contact(_) => "a contact record",
            Self::Reconstruction(_) => "a reconstruction",
            Self::Response(_) => "a file of frequency responses",
            Self::Identification(_) => "an identified law",
            Self::Explanation(_) => "an explanation",
        }
    }

    /// Options that this file has no use for are refused before anything is drawn.
    fn check(&self, arguments: &Arguments) -> Result<(), StudyError> {
        let (path, what) = (arguments.result.clone(), self.name());
        if arguments.report.is_some() && !matches!(self, Self::Explanation(_)) {
            return Err(StudyError::NoReport { path, what });
        }
        if arguments.measured.is_some() && !matches!(self, Self::Reconstruction(_)) {
            return Err(StudyError::NotCompared { path, what });
        }
        Ok(())
    }

    fn figures(&self, arguments: &Arguments) -> anyhow::Result<Vec<Figure>> {
        let ink = if arguments.png { Ink::FileAndPng } else { Ink::File };
        Ok(match self {
            Self::Measurement(measurement) => report::signals::measurement(measurement, ink)?,
            Self::Contact(record) => report::signals::contact(record, ink),
            Self::Reconstruction(file) => {
                let measured = arguments.measured.as_ref().map(read_measurement).transpose()?;
                report::recovered::figures(file, measured.as_ref(), ink)?
            }
            Self::Response(file) => report::responses::figures(file, ink)?,
            Self::Identification(found) => report::identification(found, ink),
            Self::Explanation(found) => report::figures(found, ink),
        })
    }
}

/// The figures of the kinds asked for: all of them without such, one line where there are none.
fn wanted(
    figures: Vec<Figure>,
    arguments: &Arguments,
    what: &'static str,
) -> Result<Vec<Figure>, StudyError> {
    let offered = |kind: &Kind| figures.iter().any(|figure| figure.kind == *kind);
    let names = |kinds: Vec<Kind>| kinds.iter().map(|kind| kind.name()).collect::<Vec<_>>().join(", ");
    let held = Kind::ALL.into_iter().filter(offered).collect::<Vec<_>>();
    let asked = |kind: &Kind| arguments.only.iter().any(|name| name == kind.name());
    let lacking: Vec<Kind> =
        Kind::ALL.into_iter().filter(|kind| asked(kind) && !held.contains(kind)).collect();
    if !lacking.is_empty() {
        let path = arguments.result.clone();
        return Err(StudyError::NoFigures { path, what, wanted: names(lacking), offered: names(held) });
    }
    let kept = |figure: &Figure| arguments.only.is_empty() || asked(&figure.kind);
    Ok(figures.into_iter().filter(kept).collect())
}
