//! Synthetic recordings: what a laboratory would hand over, and what only a simulation knows.
//!
//! A [`SimulatedRig`] is marched ([`crate::march`]) to its steady state and recorded on a fine time base; every channel
//! goes through one zero-phase anti-alias filter, then through its own measuring chain ([`Chain`]). The steps of the march
//! follow a tolerance of the accelerations ([`Steps`], [`Marching`]). All randomness comes from the seed.

mod chain;
mod filter;
mod fineness;
mod foreign;
mod record;
mod rig;

pub use chain::{Chain, Distortion, Hum};
pub use fineness::Marching;
pub use foreign::{Bristle, ForeignLaw, Form};
pub use record::{SimulatedRecord, simulate};
pub use rig::{
    Attached, BaseMotion, Beat, CrossTalk, NormalContact, Sampling, SecondForce, SimulatedLaw, SimulatedRig,
    SimulatedRun, SimulatedSensor, Slip, Steps,
};

#[cfg(test)]
mod tests;
