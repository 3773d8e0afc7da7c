//! Channels: columns in SI units, with their sign, sensitivity and offset.

use std::path::Path;

use super::Job;
use super::description::{Channel, ColumnName};
use crate::error::{Error, Problem};
use crate::formats::{Column, Table};
use crate::units::{Dimension, Unit, quantity, same_units, si_name, unit};

/// Where a channel is read from and what for.
#[derive(Clone, Copy)]
pub(super) struct Place<'a> {
    pub(super) file: &'a Path,
    pub(super) table: &'a Table,
    /// Name of the channel (`force`).
    pub(super) name: &'a str,
    pub(super) dimension: Dimension,
}

impl Job<'_> {
    /// The samples of a channel in SI units, not yet cut.
    pub(super) fn channel(&mut self, place: Place<'_>, channel: &Channel) -> Result<Vec<f64>, Error> {
        let column = self.column(place, &channel.column)?;
        let scale = self.scale(place, channel)?;
        self.compare_units(place, column, &channel.unit);
        let sign = f64::from(channel.sign.unwrap_or(1));
        if sign.abs() != 1.0 {
            let problem =
                Problem::WrongQuantity { found: sign.to_string(), expected: "sign = 1 or sign = -1".into() };
            return Err(self.origin.invalid(&entry(place.name, "sign"), problem));
        }
        let mut values: Vec<f64> = column.values.iter().map(|value| sign * scale * value).collect();
        for term in &channel.add {
            let wrong = |text: &str| Problem::WrongQuantity {
                found: text.into(),
                expected: si_name(place.dimension).into(),
            };
            let unit = unit(&term.unit).ok_or_else(|| self.wrong_unit(place, &term.unit))?;
            let factor = quantity(&term.factor).filter(|(_, by)| sum(*by, unit.dimension) == place.dimension);
            let (factor, _) =
                factor.ok_or_else(|| self.origin.invalid(&entry(place.name, "add"), wrong(&term.factor)))?;
            let column = self.column(place, &term.column)?;
            values
                .iter_mut()
                .zip(&column.values)
                .for_each(|(value, add)| *value += factor * unit.factor * add);
        }
        Ok(values)
    }

    /// Subtracts a channel's offset from the samples of a run.
    pub(super) fn offset(
        &self,
        place: Place<'_>,
        channel: &Channel,
        values: &mut [f64],
    ) -> Result<(), Error> {
        let offset = match channel.offset.as_deref() {
            None => return Ok(()),
            Some("mean") => values.iter().sum::<f64>() / values.len().max(1) as f64,
            Some(text) => self.origin.quantity(&entry(place.name, "offset"), text, place.dimension)?,
        };
        values.iter_mut().for_each(|value| *value -= offset);
        Ok(())
    }

    fn column<'t>(&self, place: Place<'t>, name: &ColumnName) -> Result<&'t Column, Error> {
        let found = match name {
            ColumnName::Number(number) => {
                number.checked_sub(1).and_then(|index| place.table.columns.get(index))
            }
            ColumnName::Name(name) => place.table.column(name),
        };
        found.ok_or_else(|| {
            let names: Vec<&str> = place.table.columns.iter().map(|column| column.name.as_str()).collect();
            let problem = Problem::MissingColumn { wanted: name.to_string(), found: names.join(", ") };
            Error::Invalid {
                file: place.file.to_path_buf(),
                place: format!("channel `{}`", place.name),
                problem: problem.into(),
            }
        })
    }

    /// SI value of one of the column's units.
    fn scale(&self, place: Place<'_>, channel: &Channel) -> Result<f64, Error> {
        let of_column = unit(&channel.unit).ok_or_else(|| self.wrong_unit(place, &channel.unit))?;
        let Some(text) = &channel.sensitivity else {
            return if of_column.dimension == place.dimension {
                Ok(of_column.factor)
            } else {
                Err(self.wrong_unit(place, &channel.unit))
            };
        };
        // A sensitivity is output over input: 100 mV/g.
        let fits =
            |&(value, by): &(f64, Dimension)| value != 0.0 && sum(by, place.dimension) == of_column.dimension;
        let sensitivity = quantity(text).filter(fits);
        let expected = format!("the column's unit over that of {}", si_name(place.dimension));
        let problem = Problem::WrongQuantity { found: text.clone(), expected };
        let (value, _) =
            sensitivity.ok_or_else(|| self.origin.invalid(&entry(place.name, "sensitivity"), problem))?;
        Ok(of_column.factor / value)
    }

    fn wrong_unit(&self, place: Place<'_>, found: &str) -> Error {
        let problem =
            Problem::WrongQuantity { found: found.into(), expected: si_name(place.dimension).into() };
        self.origin.invalid(&entry(place.name, "unit"), problem)
    }

    /// The file may state a unit of its own: two that differ are worth a remark.
    fn compare_units(&mut self, place: Place<'_>, column: &Column, declared: &str) {
        let Some(stated) = column.unit.as_deref() else { return };
        let same = match (unit(stated), unit(declared)) {
            (Some(Unit { factor: a, dimension: da }), Some(Unit { factor: b, dimension: db })) => {
                (a / b - 1.0).abs() < 1e-6 && da == db
            }
            (None, _) => true,
            _ => same_units(stated, declared),
        };
        if !same {
            let name = file_name(place.file);
            self.remark(format!(
                "{name}: the file gives column \"{}\" in {stated}, the description reads it as {declared}: one of them is wrong",
                column.name
            ));
        }
    }
}

fn sum(a: Dimension, b: Dimension) -> Dimension {
    std::array::from_fn(|index| a[index] + b[index])
}

fn entry(channel: &str, key: &str) -> String {
    format!("[channels] {channel}, `{key}`")
}

pub(super) fn file_name(path: &Path) -> String {
    path.file_name().map_or_else(|| path.display().to_string(), |name| name.to_string_lossy().into_owned())
}
