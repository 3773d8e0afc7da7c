//! The list of laws a user sees: names, parameters, claims, and the only matches on laws.

use std::array::from_fn;

use crate::laws::{self, Shape};
use crate::{Claims, FrictionLaw, Parameter, Scalar};

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

    /// What the law promises; the conformance tests hold it to it.
    pub fn claims(self) -> Claims {
        match self {
            Law::Coulomb => laws::coulomb::CLAIMS,
            Law::Stribeck => laws::stribeck::CLAIMS,
            Law::Dahl => laws::dahl::CLAIMS,
            Law::Lugre => laws::lugre::CLAIMS,
            Law::Hybrid => laws::hybrid::CLAIMS,
            Law::RegularisedCoulomb(_) => laws::regularised_coulomb::CLAIMS,
            Law::Jenkins => laws::jenkins::CLAIMS,
            Law::Iwan => laws::iwan::CLAIMS,
            Law::MaxwellSlip => laws::maxwell_slip::CLAIMS,
            Law::Gms => laws::gms::CLAIMS,
            Law::ElastoPlastic => laws::elasto_plastic::CLAIMS,
            Law::BoucWen => laws::bouc_wen::CLAIMS,
            Law::CattaneoMindlin => laws::cattaneo_mindlin::CLAIMS,
            Law::Vlfm => laws::vlfm::CLAIMS,
            Law::Sdfm => laws::sdfm::CLAIMS,
            Law::Fbfm => laws::fbfm::CLAIMS,
            Law::FilmStribeck => laws::film_stribeck::CLAIMS,
            Law::FilmLugre => laws::film_lugre::CLAIMS,
        }
    }

    /// The law over values by their position in [`Law::parameters`].
    pub(crate) fn build<T: Scalar>(self, value: impl FnMut(usize) -> T) -> FrictionModel<T> {
        use FrictionModel as Model;
        match self {
            Law::Coulomb => Model::Coulomb(laws::Coulomb::from_values(from_fn(value))),
            Law::Stribeck => Model::Stribeck(laws::Stribeck::from_values(from_fn(value))),
            Law::Dahl => Model::Dahl(laws::Dahl::from_values(from_fn(value))),
            Law::Lugre => Model::Lugre(laws::Lugre::from_values(from_fn(value))),
            Law::Hybrid => Model::Hybrid(laws::Hybrid::from_values(from_fn(value))),
            Law::RegularisedCoulomb(shape) => {
                Model::RegularisedCoulomb(laws::RegularisedCoulomb::from_values(from_fn(value), shape))
            }
            Law::Jenkins => Model::Jenkins(laws::Jenkins::from_values(from_fn(value))),
            Law::Iwan => Model::Iwan(laws::Iwan::from_values(from_fn(value))),
            Law::MaxwellSlip => Model::MaxwellSlip(laws::MaxwellSlip::from_values(from_fn(value))),
            Law::Gms => Model::Gms(laws::Gms::from_values(from_fn(value))),
            Law::ElastoPlastic => Model::ElastoPlastic(laws::ElastoPlastic::from_values(from_fn(value))),
            Law::BoucWen => Model::BoucWen(laws::BoucWen::from_values(from_fn(value))),
            Law::CattaneoMindlin => {
                Model::CattaneoMindlin(laws::CattaneoMindlin::from_values(from_fn(value)))
            }
            Law::Vlfm => Model::Vlfm(laws::Vlfm::from_values(from_fn(value))),
            Law::Sdfm => Model::Sdfm(laws::Sdfm::from_values(from_fn(value))),
            Law::Fbfm => Model::Fbfm(laws::Fbfm::from_values(from_fn(value))),
            Law::FilmStribeck => Model::FilmStribeck(laws::FilmStribeck::from_values(from_fn(value))),
            Law::FilmLugre => Model::FilmLugre(laws::FilmLugre::from_values(from_fn(value))),
        }
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
