//! MATLAB version 7.3 files and plain HDF5: numeric datasets by path.

use super::matlab5::columns;
use super::{Column, Format, Source, Table};
use crate::error::Error;
use crate::hdf5::{Attribute, DataFile};

/// MATLAB version 7.3, which is HDF5 behind 512 bytes of its own.
pub(super) struct Matlab73;

const SIGNATURE: &[u8] = b"\x89HDF\r\n\x1a\n";

impl Format for Matlab73 {
    fn recognises(&self, source: &Source<'_>) -> bool {
        // The superblock stands at 0, 512, 1024, …: the format's own rule.
        let places = std::iter::successors(Some(512usize), |at| at.checked_mul(2));
        let mut places = std::iter::once(0).chain(places).take_while(|&at| at < source.bytes.len());
        places.any(|at| source.bytes[at..].starts_with(SIGNATURE))
    }

    fn read(&self, source: &Source<'_>) -> Result<Table, Error> {
        let file = DataFile::open(source.path)?;
        let mut found = Vec::new();
        collect(&file, "", &mut found)?;
        Ok(Table { format: "MATLAB version 7.3 (HDF5)", columns: found, interval: None })
    }
}

/// Every numeric dataset below a group; fields of structures are `structure.field`.
fn collect(file: &DataFile, group: &str, found: &mut Vec<Column>) -> Result<(), Error> {
    for name in file.datasets(group) {
        let place = format!("{group}/{name}");
        // Texts, cells and references are not signals.
        let Ok(array) = file.array(&place) else { continue };
        if file.attribute(&place, "MATLAB_empty")?.is_some() {
            continue;
        }
        // MATLAB counts columns first, HDF5 rows first: the shape is reversed, the values are not.
        let size: Vec<usize> = array.shape.iter().rev().copied().collect();
        let label = place.trim_start_matches('/').replace('/', ".");
        let unit = match file.attribute(&place, "units")? {
            Some(Attribute::Text(unit)) => Some(unit),
            _ => None,
        };
        let named = columns(&label, &size, &array.values).into_iter();
        found.extend(named.map(|column| Column { unit: unit.clone(), ..column }));
    }
    for name in file.groups(group).into_iter().filter(|name| !name.starts_with('#')) {
        collect(file, &format!("{group}/{name}"), found)?;
    }
    Ok(())
}
