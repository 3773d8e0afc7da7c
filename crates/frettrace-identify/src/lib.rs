//! Fits any model that gives residual and Jacobian; the contact-level friction fit; beam-unaware.
//!
//! A [`Model`] states its parameters and its whitened residual. [`fit`] minimises, [`fit_from_many`] starts in many
//! places, and [`identify`] turns a [`Fit`] into an [`Identified`]: values, covariance, profile-likelihood intervals,
//! and for each parameter whether the data can tell it at all.

pub mod contact;
mod error;
pub mod evidence;
mod fit;
mod groups;
mod identifiability;
mod identified;
mod model;
mod parameter;
mod profile;
mod systematic;

pub use error::IdentifyError;
pub use fit::{Fit, FitSettings, ManyFits, Status, fit, fit_from_many, fit_with_memory, starts};
pub use groups::{GroupTest, Grouping, test_groups};
pub use identifiability::{Identifiability, IdentifiedParameter};
pub use identified::{HALF_INTERVAL95, Identified, IdentifySettings, ResidualStatistics, identify};
pub use model::{Model, NoSolution};
pub use parameter::{Parameter, Prior, Transform};
pub use systematic::{correct_by, widen_by_groups, widen_by_held, widen_to_accuracy};
