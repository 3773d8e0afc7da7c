//! Forward problem: harmonic balance and time march of a beam with frictional contacts; knows no measurement.

pub mod accelerations;
mod error;
pub mod hb;
pub mod march;
pub mod memory;
pub mod simulate;

pub use error::ForwardError;
