//! Reading: groups, attributes and arrays by path, every failure with the file and the place.

use std::fs::File;
use std::path::{Path, PathBuf};

use rust_hdf5::{ByteOrder, DatatypeMessage, H5Dataset, H5File, H5Group, Hdf5Error};

use super::attributes::{AttributeTable, read_attributes};
use crate::error::Error;

/// The value of an attribute.
#[derive(Clone, Debug, PartialEq)]
pub enum Attribute {
    /// Numbers (one for a scalar).
    Numbers(Vec<f64>),
    /// A text.
    Text(String),
}

/// A numeric dataset in row-major order.
#[derive(Clone, Debug, PartialEq)]
pub struct Array {
    /// Length of every axis; empty for a scalar.
    pub shape: Vec<usize>,
    /// The numbers, the last axis running fastest.
    pub values: Vec<f64>,
}

impl Array {
    /// The columns of an array of two axes (or the one column of an array of one axis).
    pub fn columns(&self) -> Vec<Vec<f64>> {
        let width = if self.shape.len() > 1 { self.shape[1..].iter().product::<usize>() } else { 1 };
        (0..width).map(|column| self.values.iter().skip(column).step_by(width).copied().collect()).collect()
    }
}

/// An HDF5 file open for reading: a small reader for what this project's files hold.
pub struct DataFile {
    path: PathBuf,
    file: H5File,
    attributes: AttributeTable,
    length: u64,
}

impl std::fmt::Debug for DataFile {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        formatter.debug_struct("DataFile").field("path", &self.path).finish_non_exhaustive()
    }
}

/// Deflate, the densest of the filters, stores at best a byte for 1032 (zlib's technical details): more is a damaged size.
const MOST_EXPANSION: u64 = 1100;

impl DataFile {
    /// Opens a file.
    ///
    /// # Errors
    /// [`Error::Open`], [`Error::NotHdf5`] or [`Error::Damaged`].
    pub fn open(path: impl AsRef<Path>) -> Result<Self, Error> {
        let path = path.as_ref().to_path_buf();
        let handle = File::open(&path).map_err(|source| Error::Open { file: path.clone(), source })?;
        let metadata = handle.metadata().map_err(|source| Error::Open { file: path.clone(), source })?;
        if !metadata.is_file() {
            let source = std::io::Error::other("not a file");
            return Err(Error::Open { file: path, source });
        }
        let damaged = |reason: String| Error::Damaged { file: path.clone(), place: "/".into(), reason };
        let file = match H5File::options().best_effort_locking().open(&path) {
            Ok(file) => file,
            Err(error) if is_other_format(&error) => return Err(Error::NotHdf5 { file: path }),
            Err(error) => return Err(damaged(error.to_string())),
        };
        let table =
            read_attributes(handle, file.userblock_size()).map_err(|error| damaged(error.to_string()))?;
        Ok(Self { file, attributes: table, length: metadata.len(), path })
    }

    /// The file's path.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Whether there is a group at `place` (`/runs/0001`).
    pub fn has_group(&self, place: &str) -> bool {
        self.group(place).is_some()
    }

    /// Whether there is a dataset at `place`.
    pub fn has_dataset(&self, place: &str) -> bool {
        self.file.dataset(place.trim_start_matches('/')).is_ok()
    }

    /// Names of the groups in a group, sorted, linked ones included; none where there is no such group.
    pub fn groups(&self, place: &str) -> Vec<String> {
        self.children(place, |group, name| group.group(name).is_ok())
    }

    /// Names of the datasets in a group, sorted; none where there is no such group.
    pub fn datasets(&self, place: &str) -> Vec<String> {
        self.children(place, |group, name| group.group(name).is_err())
    }

    fn children(&self, place: &str, wanted: impl Fn(&H5Group, &str) -> bool) -> Vec<String> {
        let Some(group) = self.group(place) else { return Vec::new() };
        let mut names = group.link_names().unwrap_or_default();
        names.retain(|name| wanted(&group, name));
        names
    }

    /// An attribute of a group or dataset, `None` where there is none of that name.
    ///
    /// # Errors
    /// [`Error::Damaged`] where the attribute is there and cannot be decoded.
    pub fn attribute(&self, place: &str, name: &str) -> Result<Option<Attribute>, Error> {
        let found = match self.group(place) {
            Some(group) => self.group_attribute(&group, name),
            None => self.dataset_attribute(place, name),
        };
        found.map_err(|reason| self.damaged(&format!("{place}, attribute `{name}`"), reason))
    }

    fn group_attribute(&self, group: &H5Group, name: &str) -> Result<Option<Attribute>, String> {
        let all = self.attributes.get(group.name().trim_start_matches('/'));
        let Some(entry) = all.and_then(|all| all.iter().find(|entry| entry.name() == name)) else {
            return Ok(None);
        };
        let message = entry.decoded()?;
        value(&message.datatype, &message.data, || group.attr_string(name)).map(Some)
    }

    fn dataset_attribute(&self, place: &str, name: &str) -> Result<Option<Attribute>, String> {
        let attribute =
            self.file.dataset(place.trim_start_matches('/')).and_then(|dataset| dataset.attr(name));
        let Ok(attribute) = attribute else { return Ok(None) };
        let read = |error: Hdf5Error| error.to_string();
        let (datatype, bytes) = (attribute.datatype().map_err(read)?, attribute.read_raw().map_err(read)?);
        value(&datatype, &bytes, || attribute.read_string()).map(Some)
    }

    /// A numeric dataset, whatever its number type, chunks and compression.
    ///
    /// # Errors
    /// [`Error::Damaged`] where it is missing, not numeric, or damaged.
    pub fn array(&self, place: &str) -> Result<Array, Error> {
        let dataset = self.dataset(place)?;
        let damaged = |error: Hdf5Error| self.damaged(place, error.to_string());
        let values = match dataset.datatype().map_err(damaged)? {
            DatatypeMessage::FloatingPoint { .. } => dataset.read_numeric_as::<f64>().map_err(damaged)?,
            DatatypeMessage::Enum { base, .. } => {
                bytes_to_numbers(&base, &dataset.read_raw_bytes().map_err(damaged)?)
                    .ok_or_else(|| self.damaged(place, "the values are not numbers".into()))?
            }
            _ => {
                let integers = dataset.read_numeric_as::<i64>().map_err(damaged)?;
                // Integers beyond 2^53 lose their last digits; no instrument has them.
                integers.into_iter().map(|value| value as f64).collect()
            }
        };
        Ok(Array { shape: dataset.shape(), values })
    }

    /// A dataset of texts.
    ///
    /// # Errors
    /// [`Error::Damaged`] where it is missing, not of texts, or damaged.
    pub fn texts(&self, place: &str) -> Result<Vec<String>, Error> {
        let dataset = self.dataset(place)?;
        dataset.read_strings_lossy().map_err(|error| self.damaged(place, error.to_string()))
    }

    /// A complex dataset (h5py's compound of two doubles): real and imaginary parts.
    ///
    /// # Errors
    /// [`Error::Damaged`] where it is missing, not complex, or damaged.
    pub fn complex(&self, place: &str) -> Result<(Array, Array), Error> {
        let dataset = self.dataset(place)?;
        let damaged = |error: Hdf5Error| self.damaged(place, error.to_string());
        let parts = match dataset.datatype().map_err(damaged)? {
            DatatypeMessage::Compound { size: 16, members } if members.len() == 2 => {
                let bytes = dataset.read_raw_bytes().map_err(damaged)?;
                bytes_to_numbers(&members[0].datatype, &bytes)
            }
            _ => None,
        };
        let values = parts.ok_or_else(|| self.damaged(place, "the values are not complex doubles".into()))?;
        let part = |start: usize| Array {
            shape: dataset.shape(),
            values: values.iter().skip(start).step_by(2).copied().collect(),
        };
        Ok((part(0), part(1)))
    }

    fn group(&self, place: &str) -> Option<H5Group> {
        let root = self.file.root_group();
        let path = place.trim_matches('/');
        if path.is_empty() { Some(root) } else { root.group(path).ok() }
    }

    fn dataset(&self, place: &str) -> Result<H5Dataset, Error> {
        let found = self.file.dataset(place.trim_start_matches('/'));
        let dataset = found.map_err(|error| self.damaged(place, error.to_string()))?;
        let most = self.length.saturating_mul(MOST_EXPANSION);
        for shape in [dataset.shape(), dataset.chunk_dims().unwrap_or_default()] {
            let bytes = shape.iter().try_fold(dataset.element_size().max(1), |all, &n| all.checked_mul(n));
            if bytes.is_none_or(|bytes| bytes as u64 > most) {
                let reason = format!("it declares a shape of {shape:?}, more than the file can hold");
                return Err(self.damaged(place, reason));
            }
        }
        Ok(dataset)
    }

    fn damaged(&self, place: &str, reason: String) -> Error {
        Error::Damaged { file: self.path.clone(), place: place.to_string(), reason }
    }
}

fn is_other_format(error: &Hdf5Error) -> bool {
    matches!(error, Hdf5Error::Format(rust_hdf5::format::FormatError::InvalidSignature))
        || error.to_string().contains("invalid HDF5 signature")
}

/// The value of an attribute; its text, where it is one, comes from the library.
fn value(
    datatype: &DatatypeMessage,
    bytes: &[u8],
    text: impl FnOnce() -> Result<String, Hdf5Error>,
) -> Result<Attribute, String> {
    match datatype {
        DatatypeMessage::VarLenString { .. } | DatatypeMessage::FixedString { .. } => {
            text().map(Attribute::Text).map_err(|error| error.to_string())
        }
        DatatypeMessage::Enum { base, .. } => numbers(base, bytes),
        other => numbers(other, bytes),
    }
}

fn numbers(datatype: &DatatypeMessage, bytes: &[u8]) -> Result<Attribute, String> {
    let values = bytes_to_numbers(datatype, bytes).map(Attribute::Numbers);
    values.ok_or_else(|| format!("datatype {datatype} is neither a number nor a text"))
}

fn bytes_to_numbers(kind: &DatatypeMessage, bytes: &[u8]) -> Option<Vec<f64>> {
    let (width, order, decode): (usize, ByteOrder, fn(u64, usize) -> f64) = match *kind {
        DatatypeMessage::FloatingPoint { size: 8, byte_order, .. } => {
            (8, byte_order, |bits, _| f64::from_bits(bits))
        }
        DatatypeMessage::FloatingPoint { size: 4, byte_order, .. } => {
            (4, byte_order, |bits, _| f64::from(f32::from_bits(bits as u32)))
        }
        DatatypeMessage::FixedPoint { size, byte_order, signed: false, .. } if (1..=8).contains(&size) => {
            (size as usize, byte_order, |bits, _| bits as f64)
        }
        DatatypeMessage::FixedPoint { size, byte_order, signed: true, .. } if (1..=8).contains(&size) => {
            (size as usize, byte_order, |bits, width| {
                let unused = 64 - 8 * width;
                (((bits << unused) as i64) >> unused) as f64
            })
        }
        _ => return None,
    };
    let number = |element: &[u8]| {
        let join = |value: u64, &byte: &u8| (value << 8) | u64::from(byte);
        let bits = match order {
            ByteOrder::LittleEndian => element.iter().rev().fold(0, join),
            ByteOrder::BigEndian => element.iter().fold(0, join),
        };
        decode(bits, width)
    };
    Some(bytes.chunks_exact(width).map(number).collect())
}
