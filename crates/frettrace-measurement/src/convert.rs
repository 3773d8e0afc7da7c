//! From a laboratory's files to the project's: columns named, units and signs made right, pieces cut, sampling made even.

mod build;
mod channels;
mod description;
mod guess;
mod plausibility;
mod sampling;

use std::path::{Path, PathBuf};

use self::description::{Description, Kind, Origin, Run};
use crate::error::{Error, Problem};
use crate::formats::{Table, read_table};
use crate::read::{Recording, read};
use crate::write::{write_contact_record, write_measurement};

pub use self::guess::guess;

/// A conversion: what is written, and what a person should look at.
#[derive(Clone, Debug, PartialEq)]
pub struct Converted {
    /// The recording.
    pub recording: Recording,
    /// What was done to the data and what looks doubtful, one sentence each.
    pub remarks: Vec<String>,
}

impl Converted {
    /// Writes the file.
    ///
    /// # Errors
    /// [`Error::Write`].
    pub fn write(&self, path: impl AsRef<Path>) -> Result<(), Error> {
        match &self.recording {
            Recording::Measurement(measurement) => write_measurement(path, measurement, None),
            Recording::Contact(record) => write_contact_record(path, record),
        }
    }
}

/// Converts laboratory files by a description (a TOML file).
///
/// `inputs` are files, or folders in which the files of `[[runs]]` lie. Without `[[runs]]` every input is a run.
///
/// ```toml
/// kind = "contact"                 # or "measurement"
/// title = "Friction damper"
/// law = "dahl"                     # the declared law
/// slip_unit = "m"                  # or "rad"
/// sampling_rate = "1024 Hz"        # only where there is no column of times
/// # resample = { rate = "100 Hz", method = "linear" }   # or "pchip"; uneven times are kept without it
///
/// [channels]                       # column: its number from 1, or its name
/// time = { column = 1, unit = "s" }
/// force = { column = 3, unit = "kip", sign = -1 }
/// slip_displacement = { column = 2, unit = "in", offset = "mean" }
/// # normal_force, slip_velocity, slip_acceleration; `sensitivity = "100 mV/g"` for a column in volts;
/// # add = [{ column = 6, unit = "bar", factor = "-491 mm^2" }] adds another column times a factor
///
/// [[runs]]
/// file = "run1.json"
/// label = "0.5 Hz, 20 lb"
/// from = "6 s"                     # a piece of the file
/// to = "16 s"
/// preload = "20 lbf"
/// ```
///
/// A measurement file has `[[channels.acceleration]]` with `column`, `unit`, `position` (and `name`, `noise_std`,
/// `sensitivity`, `sign`, `offset`), and the rig in `[beam]` (`length`, `width`, `thickness`, `youngs_modulus`,
/// `density`), `[modes]` (`frequency_hz`, `damping_ratio`), `[support]` (`position`, `slip`, `lever_arm`,
/// `normal_stiffness`), `[exciter]` and `[second_support]` (`position`); its runs have `excitation_frequency`.
///
/// # Errors
/// One line that says what is wrong, where, and what would mend it.
pub fn convert(inputs: &[PathBuf], description: impl AsRef<Path>) -> Result<Converted, Error> {
    let path = description.as_ref();
    let description = description::read(path)?;
    let mut job = Job { origin: Origin(path), description: &description, remarks: Vec::new() };
    let recording = match description.kind {
        Kind::Contact => Recording::Contact(build::contact_record(&mut job, inputs)?),
        Kind::Measurement => Recording::Measurement(build::measurement(&mut job, inputs)?),
    };
    job.remarks.extend(plausibility::remarks(&recording));
    let converted = Converted { recording, remarks: job.remarks };
    verify(&converted, path)?;
    Ok(converted)
}

/// The reader's own rules hold for what is converted too: written aside once and read back.
fn verify(converted: &Converted, description: &Path) -> Result<(), Error> {
    let failed =
        |error: std::io::Error| Error::Write { file: std::env::temp_dir(), reason: error.to_string() };
    let folder = tempfile::tempdir().map_err(failed)?;
    let aside = folder.path().join("converted.h5");
    converted.write(&aside)?;
    match read(&aside) {
        Err(Error::Invalid { place, problem, .. }) => {
            let place = format!("what it makes of the files, {place}");
            Err(Error::Invalid { file: description.to_path_buf(), place, problem })
        }
        other => other.map(drop),
    }
}

/// A conversion under way.
struct Job<'a> {
    origin: Origin<'a>,
    description: &'a Description,
    remarks: Vec<String>,
}

/// A run's description with its file, read once however many runs it holds.
struct Piece {
    run: Run,
    file: PathBuf,
    /// `0001`, …
    id: String,
}

impl Job<'_> {
    fn remark(&mut self, sentence: String) {
        if !self.remarks.contains(&sentence) {
            self.remarks.push(sentence);
        }
    }

    /// The runs with their files.
    fn pieces(&self, inputs: &[PathBuf]) -> Result<Vec<Piece>, Error> {
        let runs: Vec<(Run, PathBuf)> = if self.description.runs.is_empty() {
            inputs.iter().map(|file| (Run::default(), file.clone())).collect()
        } else {
            let located =
                self.description.runs.iter().map(|run| Ok((run.clone(), self.locate(run, inputs)?)));
            located.collect::<Result<_, Error>>()?
        };
        let numbered = runs.into_iter().enumerate();
        Ok(numbered
            .map(|(index, (run, file))| Piece { run, file, id: format!("{:04}", index + 1) })
            .collect())
    }

    /// The file of a run among the inputs: by its name, or in a folder given.
    fn locate(&self, run: &Run, inputs: &[PathBuf]) -> Result<PathBuf, Error> {
        let missing =
            |file: &str| self.origin.invalid("[[runs]]", Problem::MissingInput { file: file.into() });
        let Some(file) = &run.file else {
            return match inputs {
                [only] if !only.is_dir() => Ok(only.clone()),
                _ => Err(missing("")),
            };
        };
        let given =
            inputs.iter().find(|input| !input.is_dir() && input.file_name() == Path::new(file).file_name());
        let inside = inputs.iter().map(|folder| folder.join(file)).find(|path| path.is_file());
        given.cloned().or(inside).ok_or_else(|| missing(file))
    }
}

/// Tables by file, each read once.
#[derive(Default)]
struct Tables(Vec<(PathBuf, Table)>);

impl Tables {
    fn get(&mut self, file: &Path) -> Result<&Table, Error> {
        let index = match self.0.iter().position(|(path, _)| path == file) {
            Some(index) => index,
            None => {
                self.0.push((file.to_path_buf(), read_table(file)?));
                self.0.len() - 1
            }
        };
        Ok(&self.0[index].1)
    }
}
