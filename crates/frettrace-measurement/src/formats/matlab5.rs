//! MATLAB files up to version 7.2 (`-v5`, `-v7`): numeric arrays, read with `matfile`.

use matfile::{Array, MatFile, NumericData};

use super::{Column, Format, Source, Table};
use crate::error::{Error, Problem};

/// MATLAB version 5.
pub(super) struct Matlab5;

impl Format for Matlab5 {
    fn recognises(&self, source: &Source<'_>) -> bool {
        let mark = source.bytes.get(124..128);
        mark.is_some_and(|mark| mark == [0, 1, b'I', b'M'] || mark == [1, 0, b'M', b'I'])
    }

    fn read(&self, source: &Source<'_>) -> Result<Table, Error> {
        let malformed = |reason: String| source.invalid("whole file", Problem::Malformed { reason });
        if !is_whole(source.bytes) {
            return Err(malformed("an array is cut short".into()));
        }
        let file = MatFile::parse(source.bytes).map_err(|error| malformed(format!("{error:?}")))?;
        let columns =
            file.arrays().iter().flat_map(|array| columns(array.name(), array.size(), &real(array)));
        Ok(Table { format: "MATLAB version 5", columns: columns.collect(), interval: None })
    }
}

/// Whether the elements of the file end where the file does: `matfile` leaves out a cut one without a word.
fn is_whole(bytes: &[u8]) -> bool {
    let mut rest = bytes.get(128..).unwrap_or_default();
    let little = bytes.get(126) == Some(&b'I');
    while !rest.is_empty() {
        let Some(size) = rest.get(4..8).and_then(|size| <[u8; 4]>::try_from(size).ok()) else { return false };
        let size = if little { u32::from_le_bytes(size) } else { u32::from_be_bytes(size) };
        match rest.get(8 + size as usize..) {
            Some(after) => rest = after,
            None => return false,
        }
    }
    true
}

/// A variable as columns: a vector is one, a matrix one a column, named `x(:,2)`; scalars and empties are left out.
pub(super) fn columns(name: &str, size: &[usize], values: &[f64]) -> Vec<Column> {
    let column = |name: String, values: &[f64]| Column { name, unit: None, values: values.to_vec() };
    let rows = size.first().copied().unwrap_or(0);
    if values.len() < 2 || size.iter().product::<usize>() != values.len() {
        return Vec::new();
    }
    if rows == values.len() || rows == 1 {
        return vec![column(name.to_string(), values)];
    }
    let numbered = values.chunks_exact(rows).enumerate();
    numbered.map(|(index, chunk)| column(format!("{name}(:,{})", index + 1), chunk)).collect()
}

/// The real parts of a numeric array.
fn real(array: &Array) -> Vec<f64> {
    fn wide<T: Copy>(values: &[T], widen: impl Fn(T) -> f64) -> Vec<f64> {
        values.iter().map(|&value| widen(value)).collect()
    }
    match array.data() {
        NumericData::Int8 { real, .. } => wide(real, f64::from),
        NumericData::UInt8 { real, .. } => wide(real, f64::from),
        NumericData::Int16 { real, .. } => wide(real, f64::from),
        NumericData::UInt16 { real, .. } => wide(real, f64::from),
        NumericData::Int32 { real, .. } => wide(real, f64::from),
        NumericData::UInt32 { real, .. } => wide(real, f64::from),
        NumericData::Int64 { real, .. } => wide(real, |value| value as f64),
        NumericData::UInt64 { real, .. } => wide(real, |value| value as f64),
        NumericData::Single { real, .. } => wide(real, f64::from),
        NumericData::Double { real, .. } => real.clone(),
    }
}
