//! One file for each law, all under the same eight headings.

pub(crate) mod coulomb;
pub(crate) mod dahl;
pub(crate) mod hybrid;
pub(crate) mod lugre;
pub(crate) mod stribeck;

pub use coulomb::Coulomb;
pub use dahl::Dahl;
pub use hybrid::Hybrid;
pub use lugre::Lugre;
pub use stribeck::Stribeck;
