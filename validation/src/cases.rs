//! The list of cases: verification first.

mod measured_contacts;
mod verify_beam_modes;
mod verify_friction_loops;
pub mod verify_reconstruction_bands;

use crate::case::Case;

/// All cases in the order of the report.
pub const ALL: &[Case] = &[
    verify_beam_modes::CASE,
    verify_friction_loops::CASE,
    verify_reconstruction_bands::CASE,
    measured_contacts::FRICTION_DAMPER,
    measured_contacts::TRIBOMETER,
    measured_contacts::PISTON_SEALS,
    measured_contacts::MR_DAMPER,
];
