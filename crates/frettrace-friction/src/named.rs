//! Laws by name and values by name: what is not there, missing or out of range is said.

use std::collections::BTreeMap;

use crate::{Error, FrictionModel, Law, Parameter, Scalar};

impl Law {
    /// The law of this name.
    ///
    /// # Errors
    /// [`Error::UnknownLaw`] with the names there are.
    pub fn from_name(name: &str) -> Result<Law, Error> {
        let found = Law::ALL.iter().copied().find(|law| law.name() == name);
        found.ok_or_else(|| Error::UnknownLaw {
            name: name.to_owned(),
            known: join(Law::ALL.iter().map(|l| l.name())),
        })
    }

    /// Values of an ordinary contact (micrometres, tens of mm/s), for examples, benchmarks and as a first guess.
    pub fn example(self) -> Vec<f64> {
        self.parameters().iter().map(|parameter| parameter.example).collect()
    }

    /// Position of a parameter in the list.
    ///
    /// # Errors
    /// [`Error::UnknownParameter`] with the names there are.
    pub fn position(self, parameter: &str) -> Result<usize, Error> {
        let found = self.parameters().iter().position(|candidate| candidate.name == parameter);
        found.ok_or_else(|| Error::UnknownParameter {
            law: self.name(),
            parameter: parameter.to_owned(),
            known: join(self.parameters().iter().map(|p| p.name)),
        })
    }

    /// Whether every value lies in its parameter's range.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] with the first that does not (NaN never does), [`Error::Count`] where their number is wrong.
    pub fn check(self, values: &[f64]) -> Result<(), Error> {
        let parameters = self.parameters();
        self.check_count(values.len())?;
        for (parameter, value) in parameters.iter().zip(values) {
            if !parameter.range.contains(*value) {
                return Err(Error::OutOfRange {
                    law: self.name(),
                    parameter: parameter.name,
                    value: *value,
                    unit: parameter.unit,
                    range: parameter.range,
                });
            }
        }
        Ok(())
    }

    fn check_count(self, found: usize) -> Result<(), Error> {
        let expected = self.parameters().len();
        if found == expected { Ok(()) } else { Err(Error::Count { law: self.name(), expected, found }) }
    }

    /// The law with these values, unchecked but for their number (a fit may step outside a range for a moment).
    ///
    /// # Errors
    /// [`Error::Count`].
    pub fn with_values<T: Scalar>(self, values: &[T]) -> Result<FrictionModel<T>, Error> {
        self.check_count(values.len())?;
        Ok(self.build(|position| values[position]))
    }

    /// The law with values by name, all given, all in range.
    ///
    /// # Errors
    /// [`Error::UnknownParameter`], [`Error::MissingParameter`], [`Error::OutOfRange`].
    pub fn with_named(self, named: &BTreeMap<String, f64>) -> Result<FrictionModel, Error> {
        for name in named.keys() {
            self.position(name)?;
        }
        let value = |parameter: &Parameter| {
            named.get(parameter.name).copied().ok_or(Error::MissingParameter {
                law: self.name(),
                parameter: parameter.name,
                unit: parameter.unit,
                range: parameter.range,
            })
        };
        let values = self.parameters().iter().map(value).collect::<Result<Vec<f64>, Error>>()?;
        self.check(&values)?;
        self.with_values(&values)
    }
}

impl FrictionModel {
    /// Values by name.
    pub fn named(&self) -> BTreeMap<String, f64> {
        let names = self.law().parameters().iter().map(|parameter| parameter.name.to_owned());
        names.zip(self.values()).collect()
    }
}

fn join<'a>(names: impl Iterator<Item = &'a str>) -> String {
    names.collect::<Vec<_>>().join(", ")
}
