//! The bristle family with hooks: what an unmodelled effect does to a friction law, inside its state equation.
//!
//! One law, [`ModifiedLaw`], contains the declared laws and every contact effect; a [`Hook`] that is not active costs
//! nothing, one that is active with the value zero changes nothing. So the tangent at zero of an effect is the
//! derivative of the law with its hook active at zero.

mod coefficient;
mod hooks;
mod kernel;
mod leg;
mod memory;
mod modified;
mod monodromy;
mod periodic;
mod rigid;

pub use hooks::{HOOKS, Hook};
pub use modified::{Circumstance, ModifiedLaw, ModifiedState, Reached};
pub use monodromy::{Monodromy, STATES};
pub use periodic::Periodic;

#[cfg(test)]
mod tests;
