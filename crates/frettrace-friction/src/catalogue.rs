//! The list of laws a user sees: names, parameters, and the only match on laws.

use std::collections::BTreeMap;

use crate::laws::{self, Shape};
use crate::{Error, FrictionLaw, Parameter, Scalar};

/// A law by name, without its parameters.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
#[non_exhaustive]
pub enum Law {
    /// [`laws::Coulomb`].
    Coulomb,
    /// [`laws::Stribeck`].
    Stribeck,
    /// [`laws::Dahl`].
    Dahl,
    /// [`laws::Lugre`].
    Lugre,
    /// [`laws::Hybrid`].
    Hybrid,
    /// [`laws::RegularisedCoulomb`] with this curve.
    RegularisedCoulomb(Shape),
    /// [`laws::Jenkins`].
    Jenkins,
    /// [`laws::Iwan`].
    Iwan,
    /// [`laws::MaxwellSlip`].
    MaxwellSlip,
    /// [`laws::Gms`].
    Gms,
    /// [`laws::ElastoPlastic`].
    ElastoPlastic,
    /// [`laws::BoucWen`].
    BoucWen,
    /// [`laws::CattaneoMindlin`].
    CattaneoMindlin,
    /// [`laws::Vlfm`].
    Vlfm,
    /// [`laws::Sdfm`].
    Sdfm,
    /// [`laws::Fbfm`].
    Fbfm,
    /// [`laws::FilmStribeck`].
    FilmStribeck,
    /// [`laws::FilmLugre`].
    FilmLugre,
}

/// A law with its parameters over the scalar `T`.
#[derive(Clone, Copy, Debug)]
#[non_exhaustive]
pub enum FrictionModel<T = f64> {
    /// `coulomb`.
    Coulomb(laws::Coulomb<T>),
    /// `stribeck`.
    Stribeck(laws::Stribeck<T>),
    /// `dahl`.
    Dahl(laws::Dahl<T>),
    /// `lugre`.
    Lugre(laws::Lugre<T>),
    /// `hybrid`.
    Hybrid(laws::Hybrid<T>),
    /// `coulomb-tanh`, `coulomb-arctan`, `coulomb-algebraic`, `coulomb-linear`.
    RegularisedCoulomb(laws::RegularisedCoulomb<T>),
    /// `jenkins`.
    Jenkins(laws::Jenkins<T>),
    /// `iwan`.
    Iwan(laws::Iwan<T>),
    /// `maxwell-slip`.
    MaxwellSlip(laws::MaxwellSlip<T>),
    /// `gms`.
    Gms(laws::Gms<T>),
    /// `elasto-plastic`.
    ElastoPlastic(laws::ElastoPlastic<T>),
    /// `bouc-wen`.
    BoucWen(laws::BoucWen<T>),
    /// `cattaneo-mindlin`.
    CattaneoMindlin(laws::CattaneoMindlin<T>),
    /// `vlfm`.
    Vlfm(laws::Vlfm<T>),
    /// `sdfm`.
    Sdfm(laws::Sdfm<T>),
    /// `fbfm`.
    Fbfm(laws::Fbfm<T>),
    /// `film-stribeck`.
    FilmStribeck(laws::FilmStribeck<T>),
    /// `film-lugre`.
    FilmLugre(laws::FilmLugre<T>),
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
    pub const ALL: &'static [Law] = &[
        Law::Coulomb,
        Law::Stribeck,
        Law::Dahl,
        Law::Lugre,
        Law::Hybrid,
        Law::RegularisedCoulomb(Shape::Tanh),
        Law::RegularisedCoulomb(Shape::Arctan),
        Law::RegularisedCoulomb(Shape::Algebraic),
        Law::RegularisedCoulomb(Shape::Linear),
        Law::Jenkins,
        Law::Iwan,
        Law::MaxwellSlip,
        Law::Gms,
        Law::ElastoPlastic,
        Law::BoucWen,
        Law::CattaneoMindlin,
        Law::Vlfm,
        Law::Sdfm,
        Law::Fbfm,
        Law::FilmStribeck,
        Law::FilmLugre,
    ];

    /// Name in files, results and on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Law::Coulomb => "coulomb",
            Law::Stribeck => "stribeck",
            Law::Dahl => "dahl",
            Law::Lugre => "lugre",
            Law::Hybrid => "hybrid",
            Law::RegularisedCoulomb(Shape::Tanh) => "coulomb-tanh",
            Law::RegularisedCoulomb(Shape::Arctan) => "coulomb-arctan",
            Law::RegularisedCoulomb(Shape::Algebraic) => "coulomb-algebraic",
            Law::RegularisedCoulomb(Shape::Linear) => "coulomb-linear",
            Law::Jenkins => "jenkins",
            Law::Iwan => "iwan",
            Law::MaxwellSlip => "maxwell-slip",
            Law::Gms => "gms",
            Law::ElastoPlastic => "elasto-plastic",
            Law::BoucWen => "bouc-wen",
            Law::CattaneoMindlin => "cattaneo-mindlin",
            Law::Vlfm => "vlfm",
            Law::Sdfm => "sdfm",
            Law::Fbfm => "fbfm",
            Law::FilmStribeck => "film-stribeck",
            Law::FilmLugre => "film-lugre",
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

    /// Values of an ordinary contact (micrometres, tens of mm/s), for examples, benchmarks and as a first guess.
    pub fn example(self) -> Vec<f64> {
        self.parameters().iter().map(|parameter| parameter.example).collect()
    }

    /// The parameters, in the order in which values are given.
    pub fn parameters(self) -> &'static [Parameter] {
        match self {
            Law::Coulomb => laws::coulomb::PARAMETERS,
            Law::Stribeck => laws::stribeck::PARAMETERS,
            Law::Dahl => laws::dahl::PARAMETERS,
            Law::Lugre => laws::lugre::PARAMETERS,
            Law::Hybrid => laws::hybrid::PARAMETERS,
            Law::RegularisedCoulomb(_) => laws::regularised_coulomb::PARAMETERS,
            Law::Jenkins => laws::jenkins::PARAMETERS,
            Law::Iwan => laws::iwan::PARAMETERS,
            Law::MaxwellSlip => laws::maxwell_slip::PARAMETERS,
            Law::Gms => laws::gms::PARAMETERS,
            Law::ElastoPlastic => laws::elasto_plastic::PARAMETERS,
            Law::BoucWen => laws::bouc_wen::PARAMETERS,
            Law::CattaneoMindlin => laws::cattaneo_mindlin::PARAMETERS,
            Law::Vlfm => laws::vlfm::PARAMETERS,
            Law::Sdfm => laws::sdfm::PARAMETERS,
            Law::Fbfm => laws::fbfm::PARAMETERS,
            Law::FilmStribeck => laws::film_stribeck::PARAMETERS,
            Law::FilmLugre => laws::film_lugre::PARAMETERS,
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
            Law::Coulomb => array(values).map(laws::Coulomb::from_values).map(FrictionModel::Coulomb),
            Law::Stribeck => array(values).map(laws::Stribeck::from_values).map(FrictionModel::Stribeck),
            Law::Dahl => array(values).map(laws::Dahl::from_values).map(FrictionModel::Dahl),
            Law::Lugre => array(values).map(laws::Lugre::from_values).map(FrictionModel::Lugre),
            Law::Hybrid => array(values).map(laws::Hybrid::from_values).map(FrictionModel::Hybrid),
            Law::RegularisedCoulomb(shape) => array(values).map(|pair| {
                FrictionModel::RegularisedCoulomb(laws::RegularisedCoulomb::from_values(pair, shape))
            }),
            Law::Jenkins => array(values).map(laws::Jenkins::from_values).map(FrictionModel::Jenkins),
            Law::Iwan => array(values).map(laws::Iwan::from_values).map(FrictionModel::Iwan),
            Law::MaxwellSlip => {
                array(values).map(laws::MaxwellSlip::from_values).map(FrictionModel::MaxwellSlip)
            }
            Law::Gms => array(values).map(laws::Gms::from_values).map(FrictionModel::Gms),
            Law::ElastoPlastic => {
                array(values).map(laws::ElastoPlastic::from_values).map(FrictionModel::ElastoPlastic)
            }
            Law::BoucWen => array(values).map(laws::BoucWen::from_values).map(FrictionModel::BoucWen),
            Law::CattaneoMindlin => {
                array(values).map(laws::CattaneoMindlin::from_values).map(FrictionModel::CattaneoMindlin)
            }
            Law::Vlfm => array(values).map(laws::Vlfm::from_values).map(FrictionModel::Vlfm),
            Law::Sdfm => array(values).map(laws::Sdfm::from_values).map(FrictionModel::Sdfm),
            Law::Fbfm => array(values).map(laws::Fbfm::from_values).map(FrictionModel::Fbfm),
            Law::FilmStribeck => {
                array(values).map(laws::FilmStribeck::from_values).map(FrictionModel::FilmStribeck)
            }
            Law::FilmLugre => array(values).map(laws::FilmLugre::from_values).map(FrictionModel::FilmLugre),
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
            FrictionModel::RegularisedCoulomb(law) => Law::RegularisedCoulomb(law.shape),
            FrictionModel::Jenkins(_) => Law::Jenkins,
            FrictionModel::Iwan(_) => Law::Iwan,
            FrictionModel::MaxwellSlip(_) => Law::MaxwellSlip,
            FrictionModel::Gms(_) => Law::Gms,
            FrictionModel::ElastoPlastic(_) => Law::ElastoPlastic,
            FrictionModel::BoucWen(_) => Law::BoucWen,
            FrictionModel::CattaneoMindlin(_) => Law::CattaneoMindlin,
            FrictionModel::Vlfm(_) => Law::Vlfm,
            FrictionModel::Sdfm(_) => Law::Sdfm,
            FrictionModel::Fbfm(_) => Law::Fbfm,
            FrictionModel::FilmStribeck(_) => Law::FilmStribeck,
            FrictionModel::FilmLugre(_) => Law::FilmLugre,
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
            FrictionModel::RegularisedCoulomb(law) => law.values().to_vec(),
            FrictionModel::Jenkins(law) => law.values().to_vec(),
            FrictionModel::Iwan(law) => law.values().to_vec(),
            FrictionModel::MaxwellSlip(law) => law.values().to_vec(),
            FrictionModel::Gms(law) => law.values().to_vec(),
            FrictionModel::ElastoPlastic(law) => law.values().to_vec(),
            FrictionModel::BoucWen(law) => law.values().to_vec(),
            FrictionModel::CattaneoMindlin(law) => law.values().to_vec(),
            FrictionModel::Vlfm(law) => law.values().to_vec(),
            FrictionModel::Sdfm(law) => law.values().to_vec(),
            FrictionModel::Fbfm(law) => law.values().to_vec(),
            FrictionModel::FilmStribeck(law) => law.values().to_vec(),
            FrictionModel::FilmLugre(law) => law.values().to_vec(),
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
            FrictionModel::RegularisedCoulomb(law) => visitor.visit(law),
            FrictionModel::Jenkins(law) => visitor.visit(law),
            FrictionModel::Iwan(law) => visitor.visit(law),
            FrictionModel::MaxwellSlip(law) => visitor.visit(law),
            FrictionModel::Gms(law) => visitor.visit(law),
            FrictionModel::ElastoPlastic(law) => visitor.visit(&law.bristle()),
            FrictionModel::BoucWen(law) => visitor.visit(law),
            FrictionModel::CattaneoMindlin(law) => visitor.visit(law),
            FrictionModel::Vlfm(law) => visitor.visit(law),
            FrictionModel::Sdfm(law) => visitor.visit(law),
            FrictionModel::Fbfm(law) => visitor.visit(law),
            FrictionModel::FilmStribeck(law) => visitor.visit(law),
            FrictionModel::FilmLugre(law) => visitor.visit(law),
        }
    }
}

impl FrictionModel {
    /// Values by name.
    pub fn named(&self) -> BTreeMap<String, f64> {
        let names = self.law().parameters().iter().map(|parameter| parameter.name.to_owned());
        names.zip(self.values()).collect()
    }
}

fn array<T: Copy, const N: usize>(values: &[T]) -> Option<[T; N]> {
    values.try_into().ok()
}

fn join<'a>(names: impl Iterator<Item = &'a str>) -> String {
    names.collect::<Vec<_>>().join(", ")
}
