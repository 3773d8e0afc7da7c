//! Checked access to the attributes and datasets of one group.

use crate::error::{Error, Problem};
use crate::hdf5::{Array, Attribute, DataFile};
use crate::units::same_units;

/// A group of the file in hand.
pub(super) struct Fields<'a> {
    file: &'a DataFile,
    place: String,
}

impl<'a> Fields<'a> {
    pub(super) fn new(file: &'a DataFile, place: impl Into<String>) -> Self {
        Self { file, place: place.into() }
    }

    /// The group at a place, or the error that it is missing.
    pub(super) fn required(file: &'a DataFile, place: impl Into<String>) -> Result<Self, Error> {
        let fields = Self::new(file, place);
        if file.has_group(&fields.place) { Ok(fields) } else { Err(fields.invalid(Problem::MissingGroup)) }
    }

    pub(super) fn invalid(&self, problem: Problem) -> Error {
        self.invalid_at(&self.place, problem)
    }

    fn invalid_at(&self, place: &str, problem: Problem) -> Error {
        Error::Invalid { file: self.file.path().to_path_buf(), place: place.into(), problem: problem.into() }
    }

    /// The error of a dataset of this group.
    pub(super) fn invalid_in(&self, dataset: &str, problem: Problem) -> Error {
        self.invalid_at(&self.path(dataset), problem)
    }

    fn path(&self, name: &str) -> String {
        if self.place.ends_with('/') {
            format!("{}{name}", self.place)
        } else {
            format!("{}/{name}", self.place)
        }
    }

    /// A number attribute that may be absent.
    pub(super) fn optional_number(&self, name: &str) -> Result<Option<f64>, Error> {
        match self.file.attribute(&self.place, name)? {
            None => Ok(None),
            Some(Attribute::Numbers(values)) if values.len() == 1 => Ok(Some(values[0])),
            Some(Attribute::Numbers(values)) => {
                Err(self.wrong_kind(name, &format!("a list of {} numbers", values.len()), "one number"))
            }
            Some(Attribute::Text(text)) => {
                Err(self.wrong_kind(name, &format!("the text \"{text}\""), "a number"))
            }
        }
    }

    pub(super) fn number(&self, name: &str) -> Result<f64, Error> {
        self.optional_number(name)?.ok_or_else(|| self.missing(name, ""))
    }

    /// A number in `(low, high]`; infinity only where `high` is infinite.
    pub(super) fn positive(&self, name: &str) -> Result<f64, Error> {
        let value = self.number(name)?;
        self.check(name, value, value.is_finite() && value > 0.0, "a number above 0")?;
        Ok(value)
    }

    /// A number attribute that may be absent and else is above 0.
    pub(super) fn optional_positive(&self, name: &str) -> Result<Option<f64>, Error> {
        let value = self.optional_number(name)?;
        if let Some(value) = value {
            self.check(name, value, value.is_finite() && value > 0.0, "a number above 0")?;
        }
        Ok(value)
    }

    pub(super) fn check(&self, name: &str, found: f64, fits: bool, range: &str) -> Result<(), Error> {
        if fits {
            Ok(())
        } else {
            Err(self.invalid(Problem::OutOfRange { name: name.into(), found, range: range.into() }))
        }
    }

    /// A text attribute that may be absent.
    pub(super) fn optional_text(&self, name: &str) -> Result<Option<String>, Error> {
        match self.file.attribute(&self.place, name)? {
            None => Ok(None),
            Some(Attribute::Text(text)) => Ok(Some(text)),
            Some(Attribute::Numbers(_)) => Err(self.wrong_kind(name, "a number", "a text")),
        }
    }

    /// A text attribute that is one of a list.
    pub(super) fn word(&self, name: &str, allowed: &[&str]) -> Result<String, Error> {
        let remedy = format!("one of {}", allowed.join(", "));
        let found = self.optional_text(name)?.ok_or_else(|| self.missing(name, &remedy))?;
        if allowed.contains(&found.as_str()) {
            return Ok(found);
        }
        let allowed = allowed.iter().map(ToString::to_string).collect();
        Err(self.invalid(Problem::UnknownWord { name: name.into(), found, allowed }))
    }

    pub(super) fn missing(&self, name: &str, remedy: &str) -> Error {
        self.invalid(Problem::MissingAttribute { name: name.into(), remedy: remedy.into() })
    }

    fn wrong_kind(&self, name: &str, found: &str, expected: &str) -> Error {
        let what = format!("the attribute `{name}`");
        self.invalid(Problem::WrongKind { what, found: found.into(), expected: expected.into() })
    }

    /// A dataset with its units checked, `None` where it is absent.
    pub(super) fn optional_array(&self, name: &str, units: &str) -> Result<Option<Array>, Error> {
        let place = self.path(name);
        if !self.file.has_dataset(&place) {
            return if self.file.has_group(&place) {
                let problem = Problem::WrongKind {
                    what: name.into(),
                    found: "a group".into(),
                    expected: "a dataset".into(),
                };
                Err(self.invalid_at(&place, problem))
            } else if self.file.datasets(&self.place).iter().any(|other| other == name) {
                // Listed and not to be opened: the library's own reason says why.
                self.file.array(&place).map(Some)
            } else {
                Ok(None)
            };
        }
        let array = self.file.array(&place)?;
        match self.file.attribute(&place, "units")? {
            Some(Attribute::Text(found)) if same_units(&found, units) => Ok(Some(array)),
            Some(Attribute::Text(found)) => {
                Err(self.invalid_at(&place, Problem::WrongUnits { found, expected: units.into() }))
            }
            _ => Err(self.invalid_at(&place, Problem::MissingUnits { expected: units.into() })),
        }
    }

    pub(super) fn array(&self, name: &str, units: &str) -> Result<Array, Error> {
        self.optional_array(name, units)?
            .ok_or_else(|| self.invalid_in(name, Problem::MissingDataset { units: units.into() }))
    }

    /// A list of finite numbers, of a given length where one is given.
    pub(super) fn optional_list(
        &self,
        name: &str,
        units: &str,
        length: Option<usize>,
    ) -> Result<Option<Vec<f64>>, Error> {
        let Some(array) = self.optional_array(name, units)? else { return Ok(None) };
        let fits = array.shape.len() == 1 && length.is_none_or(|length| array.shape[0] == length);
        if !fits {
            let expected = length.map_or_else(|| "a list, (n)".to_string(), |length| format!("({length})"));
            return Err(self.invalid_in(name, Problem::WrongShape { found: array.shape, expected }));
        }
        self.finite(name, &array)?;
        Ok(Some(array.values))
    }

    pub(super) fn list(&self, name: &str, units: &str, length: Option<usize>) -> Result<Vec<f64>, Error> {
        self.optional_list(name, units, length)?
            .ok_or_else(|| self.invalid_in(name, Problem::MissingDataset { units: units.into() }))
    }

    /// Every entry of a list within a range.
    pub(super) fn entries(
        &self,
        name: &str,
        values: &[f64],
        range: &str,
        fits: impl Fn(f64) -> bool,
    ) -> Result<(), Error> {
        match values.iter().position(|&value| !fits(value)) {
            None => Ok(()),
            Some(index) => {
                let problem = Problem::EntryOutOfRange { index, found: values[index], range: range.into() };
                Err(self.invalid_in(name, problem))
            }
        }
    }

    /// Every number of an array finite.
    pub(super) fn finite(&self, name: &str, array: &Array) -> Result<(), Error> {
        match array.values.iter().position(|value| !value.is_finite()) {
            None => Ok(()),
            Some(index) => {
                let width = array.shape.get(1).copied().unwrap_or(1).max(1);
                let problem = Problem::NotFinite {
                    sample: index / width,
                    column: index % width,
                    found: array.values[index],
                };
                Err(self.invalid_in(name, problem))
            }
        }
    }

    pub(super) fn texts(&self, name: &str) -> Result<Option<Vec<String>>, Error> {
        let place = self.path(name);
        if self.file.has_dataset(&place) { self.file.texts(&place).map(Some) } else { Ok(None) }
    }
}

/// The runs' groups in the order of their names, numbers by size.
pub(super) fn run_names(file: &DataFile) -> Result<Vec<String>, Error> {
    let runs = Fields::required(file, "/runs")?;
    let mut names = file.groups("/runs");
    if names.is_empty() {
        return Err(runs
            .invalid(Problem::WrongShape { found: vec![0], expected: "at least one group, `0001`".into() }));
    }
    names.sort_by_key(|name| (name.parse::<u64>().unwrap_or(u64::MAX), name.clone()));
    Ok(names)
}
