//! Candidate effects and the evidence for them: what the model lacks; file-unaware.

mod fitting;
mod records;

pub use fitting::{AccelerationFit, Unknown};
pub use records::{RunRecord, RunSamples};
