//! One file for each law, all under the same eight headings.

pub(crate) mod bouc_wen;
pub(crate) mod cattaneo_mindlin;
pub(crate) mod coulomb;
pub(crate) mod dahl;
pub(crate) mod elasto_plastic;
pub(crate) mod fbfm;
pub(crate) mod film_lugre;
pub(crate) mod film_stribeck;
pub(crate) mod gms;
pub(crate) mod hybrid;
pub(crate) mod iwan;
pub(crate) mod jenkins;
pub(crate) mod lugre;
pub(crate) mod maxwell_slip;
pub(crate) mod regularised_coulomb;
pub(crate) mod sdfm;
pub(crate) mod stribeck;
pub(crate) mod vlfm;

pub use bouc_wen::BoucWen;
pub use cattaneo_mindlin::CattaneoMindlin;
pub use coulomb::Coulomb;
pub use dahl::Dahl;
pub use elasto_plastic::ElastoPlastic;
pub use fbfm::Fbfm;
pub use film_lugre::FilmLugre;
pub use film_stribeck::FilmStribeck;
pub use gms::Gms;
pub use hybrid::Hybrid;
pub use iwan::Iwan;
pub use jenkins::Jenkins;
pub use lugre::Lugre;
pub use maxwell_slip::MaxwellSlip;
pub use regularised_coulomb::{RegularisedCoulomb, Shape};
pub use sdfm::Sdfm;
pub use stribeck::Stribeck;
pub use vlfm::Vlfm;
