//! Acceleration-level model: structure, friction law, effects and measurement chain in one prediction.
//!
//! Every run is one harmonic balance whose only unknowns are the forces in the contacts: with the receptances `R` of the
//! structure, motions are `d = R_e F_e − R f`, the laws answer `f = Φ(d)`, and the accelerations are
//! `a = −(hΩ)²(R_se F_e − R_sf f)` on each line `h`. Derivatives by every [`Quantity`] follow from the implicit function
//! theorem, through the hysteresis: `df = (I − ∂Φ/∂f)⁻¹ ∂Φ/∂p`.

mod balance;
mod contact;
mod differentiation;
mod factor;
mod krylov;
mod least_squares;
mod linear;
mod model;
mod momentary;
mod phase;
mod ports;
mod response;
mod run;
mod setting;
mod solve;
mod stability;
mod structure;

pub use balance::{Balance, Beside, settled_mean};
pub use model::{
    AccelerationError, AccelerationModel, ContactHistory, Linearised, Memory, OnGrids, Prediction,
};
pub use phase::FrequencyRatio;
pub use ports::{COEFFICIENTS, PortForce, PortLaw, SHARP};
pub use run::RunLines;
pub use setting::{Port, PortPlace, Quantity, Rig, SensorSetting, Setting};
pub use solve::RunMemory;
