//! Friction laws: slip in, force out.
//!
//! A law is `Copy` parameters over a scalar `T`; history is a value passed in and out. The same `step` serves time
//! marching, the alternating frequency-time method and fitting; derivatives come from dual numbers through the
//! hysteresis.

pub mod bristle;
mod catalogue;
mod claims;
#[cfg(test)]
mod conformance;
mod decay;
pub mod effects;
mod error;
pub mod film;
mod gradient;
mod law;
pub mod laws;
mod lift;
mod march;
pub mod masing;
mod model;
mod named;
pub mod parameter;

pub use bristle::{Bristle, Instant, Saturation, Steady};
pub use catalogue::{FrictionModel, Law, Visitor};
pub use claims::Claims;
pub use error::Error;
pub use gradient::Gradient;
pub use law::{FrictionLaw, Scalar, Step, Stretch, Stroke};
pub use lift::{lift, positive_part, sign};
pub use march::{Closed, Closing, Period, close_loop};
pub use model::ModelState;
pub use parameter::{Parameter, Range};
