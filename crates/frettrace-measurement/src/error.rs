//! What can be wrong with a file: one line that says where, what, and what would mend it.

use std::path::PathBuf;

/// A file that cannot be read, written or converted.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// The operating system refuses the file.
    #[error("{}: cannot be opened ({source}); give the path of an existing, readable file", file.display())]
    Open {
        /// The file.
        file: PathBuf,
        /// The reason.
        source: std::io::Error,
    },
    /// The file is not HDF5 at all.
    #[error("{}: is not an HDF5 file; laboratory formats are brought in with `frettrace convert`", file.display())]
    NotHdf5 {
        /// The file.
        file: PathBuf,
    },
    /// The file is HDF5, but damaged or of a kind that cannot be read.
    #[error("{}: {}: cannot be read ({}); copy the file again or write it anew with h5py", file.display(), plain(place), plain(reason))]
    Damaged {
        /// The file.
        file: PathBuf,
        /// The place in the file.
        place: String,
        /// What the reader met.
        reason: String,
    },
    /// The file does not follow the contract.
    #[error("{}: {}: {problem}", file.display(), plain(place))]
    Invalid {
        /// The file.
        file: PathBuf,
        /// The place in the file.
        place: String,
        /// What is wrong and what would mend it.
        problem: Box<Problem>,
    },
    /// The file cannot be written.
    #[error("{}: cannot be written ({reason}); check the folder and the space left", file.display())]
    Write {
        /// The file.
        file: PathBuf,
        /// The reason.
        reason: String,
    },
}

/// What is wrong at a place of a file, and what would mend it.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Problem {
    /// A group is missing.
    #[error("the group is missing; add it as the file format says")]
    MissingGroup,
    /// A dataset is missing.
    #[error("the dataset is missing; add it, in {units}")]
    MissingDataset {
        /// The units it should have.
        units: String,
    },
    /// An attribute is missing.
    #[error("the attribute `{name}` is missing; add it{}", hint(remedy))]
    MissingAttribute {
        /// Its name.
        name: String,
        /// What to write.
        remedy: String,
    },
    /// An attribute or dataset is of the wrong kind.
    #[error("{what} is {}; write {expected}", plain(found))]
    WrongKind {
        /// Attribute or dataset.
        what: String,
        /// What it is.
        found: String,
        /// What it should be.
        expected: String,
    },
    /// A word that is not in the list.
    #[error("`{name}` is \"{}\"; write one of {}", plain(found), allowed.join(", "))]
    UnknownWord {
        /// The attribute's name.
        name: String,
        /// The word found.
        found: String,
        /// The words allowed.
        allowed: Vec<String>,
    },
    /// A number outside its range.
    #[error("`{name}` is {found}; it must be {range}")]
    OutOfRange {
        /// The attribute's name.
        name: String,
        /// The number found.
        found: f64,
        /// What it may be.
        range: String,
    },
    /// An entry of a dataset outside its range.
    #[error("entry {index} is {found}; it must be {range}")]
    EntryOutOfRange {
        /// The entry, from 0.
        index: usize,
        /// The number found.
        found: f64,
        /// What it may be.
        range: String,
    },
    /// A sample that is not a number.
    #[error("sample {sample} of column {column} is {found}; cut the run before it or repair the channel")]
    NotFinite {
        /// The sample, from 0.
        sample: usize,
        /// The column, from 0.
        column: usize,
        /// What stands there.
        found: f64,
    },
    /// A shape that does not fit.
    #[error("the shape is {found:?}; it must be {expected}")]
    WrongShape {
        /// The shape found.
        found: Vec<usize>,
        /// The shape expected, in words.
        expected: String,
    },
    /// Missing units.
    #[error("the attribute `units` is missing; write units = \"{expected}\"")]
    MissingUnits {
        /// The units expected.
        expected: String,
    },
    /// Other units than the contract's.
    #[error("the units are \"{}\"; convert the values and write units = \"{expected}\"", plain(found))]
    WrongUnits {
        /// The units found.
        found: String,
        /// The units expected.
        expected: String,
    },
    /// Two entries that must differ are equal.
    #[error("entries {first} and {second} are both {value}; give every sensor its own position")]
    Duplicate {
        /// The first entry, from 0.
        first: usize,
        /// The second entry.
        second: usize,
        /// Their value.
        value: f64,
    },
    /// A file of another format or version.
    #[error("`format_version` is {found}; this program reads version {supported}: convert the file")]
    Version {
        /// The version found.
        found: f64,
        /// The version read.
        supported: u32,
    },
    /// A laboratory's file of no known format.
    #[error("the format is not known; export CSV, UFF 58, MATLAB, LVM or JSON")]
    UnknownFormat,
    /// A laboratory's file without numbers.
    #[error("there are no numbers in it; export the channels as columns of numbers")]
    NoNumbers,
    /// A row of another width than the rows before it.
    #[error("the row has {found} fields where the others have {expected}; complete or remove it")]
    Ragged {
        /// Fields found.
        found: usize,
        /// Fields of the other rows.
        expected: usize,
    },
    /// Text where a number should stand.
    #[error("`{}` is not a number; mend or remove the row", plain(found))]
    BadNumber {
        /// What stands there.
        found: String,
    },
    /// The file breaks the rules of its format.
    #[error("the file breaks the rules of its format ({}); export it again", plain(reason))]
    Malformed {
        /// How.
        reason: String,
    },
    /// A file that ends too early.
    #[error("the file ends after {found} of {expected} values; export or copy it again")]
    CutShort {
        /// Values found.
        found: usize,
        /// Values announced.
        expected: usize,
    },
    /// The description of a conversion cannot be understood.
    #[error("{reason}; `frettrace convert FILE --guess` proposes one to start from")]
    BadDescription {
        /// The parser's reason.
        reason: String,
    },
    /// An entry the description needs.
    #[error("the entry is missing; add it to the description")]
    MissingEntry,
    /// A quantity or unit of the wrong kind.
    #[error("\"{}\" does not fit; write {expected}", plain(found))]
    WrongQuantity {
        /// What stands there.
        found: String,
        /// What is expected.
        expected: String,
    },
    /// A column that is not in the file.
    #[error("there is no column `{}`; the file has {}", plain(wanted), plain(found))]
    MissingColumn {
        /// The column wanted.
        wanted: String,
        /// The columns there are.
        found: String,
    },
    /// A file of the description that was not given.
    #[error("the file `{file}` is not among the inputs; give it, or the folder it lies in")]
    MissingInput {
        /// The file.
        file: String,
    },
    /// Channels of one run that differ in length.
    #[error("a channel has {found} samples and another {expected}; take channels of one recording")]
    UnequalChannels {
        /// Samples of the shorter.
        found: usize,
        /// Samples of the longer.
        expected: usize,
    },
    /// A piece of a file without samples.
    #[error("the piece holds {samples} samples; take a longer one")]
    EmptyPiece {
        /// Samples in the piece.
        samples: usize,
    },
    /// Uneven sampling where even is needed.
    #[error(
        "sampling is uneven; add resample = {{ rate = \"… Hz\", method = \"linear\" }} to the description"
    )]
    Uneven,
    /// The other kind of file was asked for.
    #[error("the file is a {found}; give a {expected} here")]
    WrongFile {
        /// What it is.
        found: String,
        /// What was asked for.
        expected: String,
    },
}

/// Longest text of a file quoted in a message.
const LONGEST: usize = 300;

/// A text out of a file, fit for one line: control characters as blanks, and cut where it is long.
fn plain(text: &str) -> String {
    let visible = |letter: char| if letter.is_control() { ' ' } else { letter };
    let mut line: String = text.chars().take(LONGEST).map(visible).collect();
    if line.len() < text.len() && text.chars().count() > LONGEST {
        line.push('…');
    }
    line
}

fn hint(remedy: &str) -> String {
    if remedy.is_empty() { String::new() } else { format!(": {remedy}") }
}
