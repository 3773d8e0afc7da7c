//! Why a study could not be done.

use std::path::PathBuf;

/// Why a study could not be done: the data or a file is at fault.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum StudyError {
    /// The file is not what it should be.
    #[error(transparent)]
    File(#[from] frettrace_measurement::Error),
    /// The lines of a run cannot be found.
    #[error("run {run}: {source}; a longer record would mend it")]
    Run {
        /// Name of the run.
        run: String,
        /// What is wrong.
        source: frettrace_fourier::ProjectionError,
    },
    /// The law could not be fitted.
    #[error(transparent)]
    Identify(#[from] frettrace_identify::IdentifyError),
    /// A law that is not in the catalogue was asked for.
    #[error("no law is called {name}; coulomb, stribeck, dahl, lugre, hybrid and auto are known")]
    UnknownLaw {
        /// The name.
        name: String,
    },
    /// The declared beam or its support is out of range.
    #[error(transparent)]
    Beam(#[from] frettrace_beam::BeamError),
    /// The inverse could not be tried.
    #[error(transparent)]
    Inverse(#[from] frettrace_inverse::InverseError),
    /// Nothing can be explained.
    #[error(transparent)]
    Explain(#[from] frettrace_explain::ExplainError),
    /// A march that did not come to a motion.
    #[error(
        "run {run}: the march of the beam has no finite accelerations; smaller steps ([sampling] rate_hz) or softer effects would mend it"
    )]
    NoMotion {
        /// Name of the run.
        run: String,
    },
    /// Controls of a contact record.
    #[error("controls draw beams anew, and a contact record has none; leave --controls out")]
    ControlsOfRecord,
    /// Controls of a file without a periodic run.
    #[error("controls draw periodic runs anew, and the file has none; leave --controls out")]
    ControlsWithoutPeriod,
    /// A contact record without a motion.
    #[error("no run of the contact record holds {least} samples of a motion; record at least one stroke")]
    NoStroke {
        /// Fewest samples of a run that is used.
        least: usize,
    },
    /// A file cannot be written.
    #[error("{}: cannot be written: {source}; choose a folder that exists and may be written to", path.display())]
    Write {
        /// The file.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// A file cannot be read.
    #[error("{}: cannot be read: {source}; check the path and its permissions", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// A result file is not the JSON it should be.
    #[error("{}: not a result of identify or explain: {source}; give the JSON file written with -o", path.display())]
    Json {
        /// The file.
        path: PathBuf,
        /// What is wrong with it.
        source: serde_json::Error,
    },
    /// Figures of a kind that a file does not hold.
    #[error("{}: {what} has no {wanted}; it has {offered}", path.display())]
    NoFigures {
        /// The file.
        path: PathBuf,
        /// What it is.
        what: &'static str,
        /// The kinds asked for.
        wanted: String,
        /// The kinds there are.
        offered: String,
    },
    /// A file from which no report can be made.
    #[error("{}: {what} has no report; give the result of `frettrace explain`", path.display())]
    NoReport {
        /// The file.
        path: PathBuf,
        /// What it is.
        what: &'static str,
    },
    /// A measurement beside a file that is not compared with one.
    #[error("{}: {what} is not compared with a measurement; leave --measured out", path.display())]
    NotCompared {
        /// The file.
        path: PathBuf,
        /// What it is.
        what: &'static str,
    },
    /// A reconstruction of another measurement.
    #[error(
        "{}: run {run} is not in the measurement with as many samples and sensors; give the file it was reconstructed from",
        path.display()
    )]
    Unlike {
        /// The file.
        path: PathBuf,
        /// Name of the run.
        run: String,
    },
    /// A rig with an unknown key, a missing one or a bare mistake.
    #[error("{}: line {line}: {message}", path.display())]
    RigSyntax {
        /// The file.
        path: PathBuf,
        /// The line, from 1.
        line: usize,
        /// What is wrong.
        message: String,
    },
    /// A value of a rig out of its range.
    #[error("{}: {place} is {found}; allowed: {allowed}", path.display())]
    RigValue {
        /// The file.
        path: PathBuf,
        /// Table and key.
        place: String,
        /// The value.
        found: String,
        /// The allowed range.
        allowed: String,
    },
    /// The forward problem cannot be tried.
    #[error(transparent)]
    Forward(#[from] frettrace_forward::ForwardError),
    /// Effects of the contact whose formulas cannot stand together.
    #[error(
        "effect {effect} cannot act beside an effect of the contact in another formula; leave one of them out"
    )]
    MixedFormulas {
        /// The effect's id.
        effect: &'static str,
    },
    /// An effect that the declared law cannot carry.
    #[error("effect {effect} needs one of the laws dahl, lugre, hybrid; the rig declares {law}")]
    EffectOnLaw {
        /// The effect's id.
        effect: &'static str,
        /// The declared law.
        law: String,
    },
}
