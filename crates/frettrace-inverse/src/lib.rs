//! Inverse harmonic balance: accelerations to contact forces and slip; friction-law-free.
//!
//! Every line of a (sub)harmonic steady state obeys one linear relation,
//! `a_s = H_se F_e − H_st F_t (+ H_sn N' + H_sg F_g)`, with the accelerances `H` of the beam and no friction law. The
//! contact forces follow by weighted least squares over the sensors; slip and normal force follow from the same
//! receptances. What no contact force can explain is the *balance residual*: it judges the structure and the sensors, and
//! the structure is calibrated on it.
//!
//! | type | role |
//! |---|---|
//! | [`Rig`], [`RunData`] | what is declared and measured |
//! | [`RunLines`] | a run as lines: base frequency, form, harmonics with variances |
//! | [`CalibratedStructure`] | the modes after calibration, with covariance |
//! | [`ContactHarmonics`] | what was recovered in the contact |
//! | [`BalanceResidual`] | what was not |
//! | [`PeriodicSpline`] | a periodic smoothing spline through lines |
//! | [`Finding`] | what is wrong with the channels |
//! | [`ModeComparison`] | three hypotheses about the motion, compared |
//! | [`Reconstruction`] | all of it, as time series too: [`reconstruct`] |

mod analysis;
mod aperiodic;
mod balance;
mod calibration;
mod contact;
mod doubt;
mod dynamics;
mod error;
mod findings;
mod modes;
mod reconstruction;
mod rig;
mod splines;

pub use analysis::{Form, RunLines, analyse};
pub use balance::{LineBalance, LineData};
pub use calibration::CalibratedStructure;
pub use contact::{BalanceResidual, ContactHarmonics, SharedErrors};
pub use dynamics::{Dynamics, LineReceptances, Load};
pub use error::InverseError;
pub use findings::Finding;
pub use modes::{ModeComparison, compare_modes};
pub use reconstruction::{Channel, Reconstruction, RunReconstruction, reconstruct};
pub use rig::{FormChoice, ModeTrust, Options, Rig, RunData, Sensor, Slip};
pub use splines::PeriodicSpline;
