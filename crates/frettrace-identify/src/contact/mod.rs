//! Friction law against motion and force of the contact itself.

mod compare;
mod drive;
mod family;
mod fitted;
mod guess;
mod history;
mod model;
mod noise;
mod record;
mod smooth;
mod steps;
#[cfg(test)]
mod tests;

pub use compare::compare;
pub use family::{Family, LAW_PARAMETERS};
pub use fitted::{ContactFit, StepReport};
pub use guess::Guess;
pub use history::{Closure, ContactHistory, NoiseDraw};
pub use model::{ContactModel, Extras};
pub use record::{FloorSource, PreparedRun, RawRun};
pub use steps::{ContactSettings, identify_contact};
