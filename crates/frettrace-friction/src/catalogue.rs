//! The list of laws a user sees: names, parameters, and the only match on laws.

use std::collections::BTreeMap;

use crate::laws::{self, Coulomb, Dahl, Hybrid, Lugre, Stribeck};
use crate::{Error, FrictionLaw, Parameter, Scalar};

/// A law by name, without its parameters.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
#[non_exhaustive]
pub enum Law {
    /// [`Coulomb`].
    Coulomb,
    /// [`Stribeck`].
    Stribeck,
    /// [`Dahl`].
    Dahl,
    /// [`Lugre`].
    Lugre,
    /// [`Hybrid`].
    Hybrid,
}

/// A law with its parameters over the scalar `T`.
#[derive(Clone, Copy, Debug)]
#[non_exhaustive]
pub enum FrictionModel<T = f64> {
    /// `coulomb`.
    Coulomb(Coulomb<T>),
    /// `stribeck`.
    Stribeck(Stribeck<T>),
    /// `dahl`.
    Dahl(Dahl<T>),
    /// `lugre`.
    Lugre(Lugre<T>),
    /// `hybrid`.
    Hybrid(Hybrid<T>),
}

/// Something to be done with a law whose type is known: dispatch once for a period, not for every sample.
pub trait Visitor<T: Scalar> {
    /// What comes of it.
    type Output;

    /// Called with the law itself.
    fn visit<L: FrictionLaw<T>>(self, law: &L) -> Self::Output;
}

impl Law {
    /// Every law of the catalogue.
    pub const ALL: &'static [Law] = &[Law::Coulomb, Law::Stribeck, Law::Dahl, Law::Lugre, Law::Hybrid];

    /// Name in files, results and on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Law::Coulomb => "coulomb",
            Law::Stribeck => "stribeck",
            Law::Dahl => "dahl",
            Law::Lugre => "lugre",
            Law::Hybrid => "hybrid",
        }
    }

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

    /// The parameters, in the order in which values are given.
    pub fn parameters(self) -> &'static [Parameter] {
        match self {
            Law::Coulomb => laws::coulomb::PARAMETERS,
            Law::Stribeck => laws::stribeck::PARAMETERS,
            Law::Dahl => laws::dahl::PARAMETERS,
            Law::Lugre => laws::lugre::PARAMETERS,
            Law::Hybrid => laws::hybrid::PARAMETERS,
        }
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
        let model = match self {
            Law::Coulomb => array(values).map(Coulomb::from_values).map(FrictionModel::Coulomb),
            Law::Stribeck => array(values).map(Stribeck::from_values).map(FrictionModel::Stribeck),
            Law::Dahl => array(values).map(Dahl::from_values).map(FrictionModel::Dahl),
            Law::Lugre => array(values).map(Lugre::from_values).map(FrictionModel::Lugre),
            Law::Hybrid => array(values).map(Hybrid::from_values).map(FrictionModel::Hybrid),
        };
        let expected = self.parameters().len();
        model.ok_or(Error::Count { law: self.name(), expected, found: values.len() })
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

impl<T: Scalar> FrictionModel<T> {
    /// Which law it is.
    pub fn law(&self) -> Law {
        match self {
            FrictionModel::Coulomb(_) => Law::Coulomb,
            FrictionModel::Stribeck(_) => Law::Stribeck,
            FrictionModel::Dahl(_) => Law::Dahl,
            FrictionModel::Lugre(_) => Law::Lugre,
            FrictionModel::Hybrid(_) => Law::Hybrid,
        }
    }

    /// The values, in the order of [`Law::parameters`].
    pub fn values(&self) -> Vec<T> {
        match self {
            FrictionModel::Coulomb(law) => law.values().to_vec(),
            FrictionModel::Stribeck(law) => law.values().to_vec(),
            FrictionModel::Dahl(law) => law.values().to_vec(),
            FrictionModel::Lugre(law) => law.values().to_vec(),
            FrictionModel::Hybrid(law) => law.values().to_vec(),
        }
    }

    /// Does something with the law itself. The bristle laws are handed over as [`crate::Bristle`], so that their
    /// parameters are not put together anew for every sample.
    pub fn visit<V: Visitor<T>>(&self, visitor: V) -> V::Output {
        match self {
            FrictionModel::Coulomb(law) => visitor.visit(law),
            FrictionModel::Stribeck(law) => visitor.visit(law),
            FrictionModel::Dahl(law) => visitor.visit(&law.bristle()),
            FrictionModel::Lugre(law) => visitor.visit(&law.bristle()),
            FrictionModel::Hybrid(law) => visitor.visit(&law.bristle()),
        }
    }
}

impl FrictionModel {
    /// Values by name.
    pub fn named(&self) -> BTreeMap<String, f64> {
        let names = self.law().parameters().iter().map(|parameter| parameter.name.to_owned());
        names.zip(self.values()).collect()
    }

    /// The same law over another scalar.
    ///
    /// # Errors
    /// None in practice: the number of values is the law's own.
    pub fn over<T: Scalar>(&self) -> Result<FrictionModel<T>, Error> {
        let values: Vec<T> = self.values().into_iter().map(T::from).collect();
        self.law().with_values(&values)
    }
}

fn array<T: Copy, const N: usize>(values: &[T]) -> Option<[T; N]> {
    values.try_into().ok()
}

fn join<'a>(names: impl Iterator<Item = &'a str>) -> String {
    names.collect::<Vec<_>>().join(", ")
}
