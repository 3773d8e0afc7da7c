//! The bristle family with hooks: what an unmodelled effect does to a friction law, inside its state equation.
//!
//! One law, [`ModifiedLaw`], contains the declared laws and every contact effect; a [`Hook`] that is not active costs
//! nothing, one that is active with the value zero changes nothing. So the tangent at zero of an effect is the
//! derivative of the law with its hook active at zero.

mod coefficient;
mod hooks;
mod kernel;
mod memory;
mod modified;
mod rigid;

pub use hooks::{HOOKS, Hook};
pub use modified::{Circumstance, ModifiedLaw, ModifiedState};

#[cfg(test)]
mod tests;
