//! Laboratory formats: each a file of this folder behind one trait, each read into a plain table.

mod delimited;
mod json;
mod lvm;
mod matlab5;
mod matlab73;
mod uff58;

use std::path::Path;

use crate::error::{Error, Problem};

/// A column of numbers as the laboratory's file names it.
#[derive(Clone, Debug, PartialEq)]
pub struct Column {
    /// Its name; its number, from 1, where the file gives none.
    pub name: String,
    /// The unit the file states for it.
    pub unit: Option<String>,
    /// The numbers.
    pub values: Vec<f64>,
}

/// What a laboratory's file holds.
#[derive(Clone, Debug, PartialEq)]
pub struct Table {
    /// Name of the format.
    pub format: &'static str,
    /// The columns.
    pub columns: Vec<Column>,
    /// The sampling interval \[s\], where the file states one.
    pub interval: Option<f64>,
}

impl Table {
    /// The column of a name, or of a number counted from 1.
    pub fn column(&self, wanted: &str) -> Option<&Column> {
        let by_name = self.columns.iter().find(|column| column.name.trim() == wanted.trim());
        by_name.or_else(|| self.columns.get(wanted.trim().parse::<usize>().ok()?.checked_sub(1)?))
    }
}

/// The file in hand.
pub(crate) struct Source<'a> {
    pub(crate) path: &'a Path,
    pub(crate) bytes: &'a [u8],
}

impl Source<'_> {
    pub(crate) fn invalid(&self, place: impl Into<String>, problem: Problem) -> Error {
        Error::Invalid { file: self.path.to_path_buf(), place: place.into(), problem: problem.into() }
    }

    /// The bytes as text: UTF-8, or Latin-1 as older instruments write (`µ`, `²`, `°`).
    pub(crate) fn text(&self) -> String {
        let bytes = self.bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(self.bytes);
        match std::str::from_utf8(bytes) {
            Ok(text) => text.to_string(),
            Err(_) => bytes.iter().map(|&byte| char::from(byte)).collect(),
        }
    }
}

/// A laboratory format.
trait Format: Sync {
    /// Whether a file is of this format, by its beginning.
    fn recognises(&self, source: &Source<'_>) -> bool;
    /// Reads a file.
    fn read(&self, source: &Source<'_>) -> Result<Table, Error>;
}

/// All formats; the first to recognise a file reads it, so the one that takes any text stands last.
const FORMATS: [&dyn Format; 6] =
    [&matlab73::Matlab73, &matlab5::Matlab5, &uff58::Uff58, &lvm::Lvm, &json::Json, &delimited::Delimited];

/// Reads a laboratory's file, whatever its format.
///
/// # Errors
/// One line that says what is wrong, where, and what would mend it.
pub fn read_table(path: impl AsRef<Path>) -> Result<Table, Error> {
    let path = path.as_ref();
    let bytes = std::fs::read(path).map_err(|source| Error::Open { file: path.to_path_buf(), source })?;
    let source = Source { path, bytes: &bytes };
    let format = FORMATS.iter().find(|format| format.recognises(&source));
    let table =
        format.ok_or_else(|| source.invalid("start of the file", Problem::UnknownFormat))?.read(&source)?;
    let empty = table.columns.iter().all(|column| column.values.is_empty());
    if empty { Err(source.invalid("whole file", Problem::NoNumbers)) } else { Ok(table) }
}

/// A name with its unit in brackets, as `Force [kN]` or `Time (s)`, taken apart.
pub(crate) fn name_and_unit(label: &str) -> (String, Option<String>) {
    let label = label.trim().trim_matches('"').trim();
    let brackets = [('[', ']'), ('(', ')')];
    for (open, close) in brackets {
        if let Some((name, rest)) = label.split_once(open)
            && let Some(inside) = rest.trim_end().strip_suffix(close)
            && !name.trim().is_empty()
        {
            return (name.trim().to_string(), Some(inside.trim().to_string()));
        }
    }
    (label.to_string(), None)
}
