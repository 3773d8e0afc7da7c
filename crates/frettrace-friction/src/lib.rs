//! Friction laws: slip in, force out.
//!
//! A law is `Copy` parameters over a scalar `T`; history is a value passed in and out. The same `step` serves time
//! marching, the alternating frequency-time method and fitting; derivatives come from dual numbers through the
//! hysteresis.

pub mod effects;
mod law;

pub use law::{FrictionLaw, Scalar, Step};
