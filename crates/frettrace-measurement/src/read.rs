//! Reading both kinds of file, each rule of the contract checked where the value is read.

mod contact;
mod fields;
mod measured;

use std::path::Path;

use crate::error::{Error, Problem};
use crate::hdf5::DataFile;
use crate::measurement::{ContactRecord, Measurement};

/// The friction laws a file may declare.
pub const LAWS: [&str; 5] = ["coulomb", "stribeck", "dahl", "lugre", "hybrid"];

pub(crate) const MEASUREMENT_FORMAT: &str = "frettrace-measurement";
pub(crate) const CONTACT_FORMAT: &str = "frettrace-contact";
pub(crate) const FORMAT_VERSION: u32 = 1;

/// A file of either kind.
#[derive(Clone, Debug, PartialEq)]
#[expect(clippy::large_enum_variant, reason = "one value a file: its size does not matter")]
pub enum Recording {
    /// Accelerations and force of a beam.
    Measurement(Measurement),
    /// Motion and force in the contact itself.
    Contact(ContactRecord),
}

/// Reads a file of either kind.
///
/// # Errors
/// One line that says what is wrong, where, and what would mend it.
pub fn read(path: impl AsRef<Path>) -> Result<Recording, Error> {
    let file = DataFile::open(path)?;
    let root = fields::Fields::new(&file, "/");
    let formats = [MEASUREMENT_FORMAT, CONTACT_FORMAT];
    let format = root.word("format", &formats)?;
    let version = root.number("format_version")?;
    if version != f64::from(FORMAT_VERSION) {
        return Err(root.invalid(Problem::Version { found: version, supported: FORMAT_VERSION }));
    }
    if format == CONTACT_FORMAT {
        contact::read(&file).map(Recording::Contact)
    } else {
        measured::read(&file).map(Recording::Measurement)
    }
}

/// Reads a measurement file.
///
/// # Errors
/// As [`read`], and where the file is a contact record.
pub fn read_measurement(path: impl AsRef<Path>) -> Result<Measurement, Error> {
    match read(&path)? {
        Recording::Measurement(measurement) => Ok(measurement),
        Recording::Contact(_) => Err(wrong_file(path.as_ref(), "contact record", "measurement file")),
    }
}

/// Reads a contact record.
///
/// # Errors
/// As [`read`], and where the file is a measurement file.
pub fn read_contact_record(path: impl AsRef<Path>) -> Result<ContactRecord, Error> {
    match read(&path)? {
        Recording::Contact(record) => Ok(record),
        Recording::Measurement(_) => Err(wrong_file(path.as_ref(), "measurement file", "contact record")),
    }
}

fn wrong_file(path: &Path, found: &str, expected: &str) -> Error {
    let problem = Problem::WrongFile { found: found.into(), expected: expected.into() };
    Error::Invalid { file: path.to_path_buf(), place: "/".into(), problem: problem.into() }
}
