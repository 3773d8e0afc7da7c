//! The list of cases: verification first.

mod cantilever;
mod compare_balance_codes;
mod compare_friction_velocity;
mod compare_haptic_pulls;
mod compare_loop_area;
mod compare_practice_rigs;
pub mod compare_splines;
mod compare_two_bodies;
mod explained_contacts;
mod measured_contacts;
mod roller_beam;
mod validate_finite_element_rig;
mod verify_beam_modes;
mod verify_coverage;
mod verify_explained_rigs;
mod verify_friction_loops;
mod verify_harmonic_balance;
mod verify_memory_equation;
pub mod verify_mode_hypotheses;
pub mod verify_reconstruction_bands;
mod verify_sweep;
mod verify_wedge_damper;

use crate::case::Case;
use crate::sweep::{self, Finished};
use std::path::Path;

/// All cases in the order of the report.
pub const ALL: &[Case] = &[
    verify_beam_modes::CASE,
    verify_friction_loops::CASE,
    verify_harmonic_balance::CASE,
    verify_wedge_damper::CASE,
    verify_memory_equation::CASE,
    verify_mode_hypotheses::CASE,
    verify_reconstruction_bands::CASE,
    verify_explained_rigs::CASE,
    verify_sweep::CASE,
    verify_coverage::CASE,
    compare_balance_codes::CASE,
    compare_practice_rigs::CASE,
    compare_splines::CASE,
    validate_finite_element_rig::CASE,
    compare_loop_area::CASE,
    compare_two_bodies::CASE,
    compare_friction_velocity::CASE,
    compare_haptic_pulls::CASE,
    measured_contacts::FRICTION_DAMPER,
    measured_contacts::TRIBOMETER,
    measured_contacts::PISTON_SEALS,
    measured_contacts::MR_DAMPER,
    cantilever::CASE,
    roller_beam::CASE,
];

/// Finished sets of a sweep that is kept beside its case.
fn stored<T: Finished>(file: &str) -> anyhow::Result<Vec<T>> {
    sweep::read(&Path::new(env!("CARGO_MANIFEST_DIR")).join("cases").join(file))
}
