//! The list of cases: verification first.

mod verify_beam_modes;
mod verify_friction_loops;

use crate::case::Case;

/// All cases in the order of the report.
pub const ALL: &[Case] = &[verify_beam_modes::CASE, verify_friction_loops::CASE];
