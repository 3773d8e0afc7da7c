//! The time march: the oracle of the harmonic balance and the engine of the simulator.
//!
//! Specified: a linear structure as modes with residual flexibility ([`Structure`]), one friction contact under any law,
//! memoryless local loads, loads known in time. Unknown at every step: the friction force and the local loads. Equations:
//!
//! ```text
//! q̈_n + 2ζ_nω_n q̇_n + ω_n² q_n = Σ_j φ_jn f_j        f = −F_t at the slip, known loads, local loads
//! ```
//!
//! Each mode is advanced exactly for loads that are linear over the step (first-order hold), so that stiff modes cost no
//! stability and the only error is the loads' curvature, `(ωΔt)²/12` of a harmonic at ω. The loads at the new sample are
//! implicit: each is one scalar equation, monotone for a law that resists motion, bracketed where Newton's secant leaves
//! the bracket; several are swept until they agree. A step in which such a load bends or jumps (a stop is touched, a bristle
//! turns) is taken back and its halves are marched, as often as it takes ([`March::set_refinement`]): no event is looked for, and
//! none costs the order. A step is stable while the contact's presliding stiffness times its compliance within one step
//! ([`March::step_compliance`]) stays below about 1.
//!
//! Friction without a presliding range ([`frettrace_friction::FrictionLaw::at_rest`]) has two states instead of a stiff equation. Held, the
//! structure is linear and its step exact, the force follows from the motion; sliding, the force follows from the law. Halving finds the
//! instants between them. A motion that is held for a whole period is taken to its steady state at once, which is linear too.

mod assembly;
mod engine;
mod held;
mod implicit;
mod propagator;
mod refine;
mod root;
mod settle;
mod stick;
mod structure;

pub use assembly::{Assembly, Characteristic, FrictionContact, LocalLoad, Modulation, Normal};
pub use engine::{March, Moment};
pub(crate) use settle::GRACE;
pub use settle::{SettleOptions, Settling, settle};
pub use structure::{Port, Structure};

#[cfg(test)]
mod tests;
