//! Modes and receptances of the clamped beam on its support.
//!
//! One Euler-Bernoulli beam along `x`, clamped at `x = 0` (rigidly or through a rotational spring) and supported at
//! `x = L` by springs that may be absent, finite or infinite. Three independent descriptions give the same receptances and
//! check each other: the modal sum with its static residual ([`ModalModel`]), the closed form ([`ExactBeam`]) and Hermite
//! finite elements ([`FiniteElements`]). Point masses, springs and dashpots are low-rank updates ([`Modified`]).
//!
//! ```
//! use frettrace_beam::{Boundary, Dof, ModalModel, ModalOptions, Receptance, UniformBeam};
//!
//! let beam = UniformBeam { length: 1.0, bending_stiffness: 1.0, mass_per_length: 1.0 };
//! let model = ModalModel::new(&beam, &Boundary::pinned(), &ModalOptions::default())?;
//! let end = Dof::rotation(1.0);
//! // A moment at the pinned end turns it by M·L/(4EI).
//! assert!((model.receptance(end, end, 0.0).re - 0.25).abs() < 1e-12);
//! # Ok::<(), frettrace_beam::BeamError>(())
//! ```

mod beam;
mod characteristic;
mod dof;
mod error;
mod exact;
mod finite_elements;
mod modal;
mod modification;
mod probe;
mod shape;
mod statics;

pub use beam::{Boundary, UniformBeam};
pub use dof::{Dof, Freedom, Receptance};
pub use error::BeamError;
pub use exact::ExactBeam;
pub use finite_elements::{EigenModes, FiniteElements};
pub use modal::{ModalModel, ModalOptions};
pub use modification::{Attachment, Element, Modified};
pub use probe::Probe;
pub use shape::{ModeShape, mode_shapes};
pub use statics::static_flexibility;
