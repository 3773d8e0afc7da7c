//! What a contact force makes of its own slip.

use crate::{Case, ExplainError};
use frettrace_forward::accelerations::{AccelerationModel, RunLines, Setting};
use num_complex::Complex64;

/// Slip (m/N) that a unit of contact force takes on the lines `0 ..` of a base frequency (rad/s), so many of them.
///
/// # Errors
/// [`ExplainError::Model`] where the rig cannot be modelled.
pub fn slip_receptance(
    case: &Case,
    setting: &Setting,
    (omega, count): (f64, usize),
) -> Result<Vec<Complex64>, ExplainError> {
    let sensors = case.rig.sensors.len();
    let lines = RunLines {
        omega,
        preload: 1.0,
        progress: 0.5,
        worked: [0.5; 2],
        force: vec![Complex64::ZERO; count],
        acceleration: vec![vec![Complex64::ZERO; count]; sensors],
        deviation: vec![vec![1.0; count]; sensors],
        base_phase: 0.0,
        known_force: Vec::new(),
        contact_order: count.saturating_sub(1),
        samples: (4 * count).next_power_of_two(),
    };
    let model = AccelerationModel::new(case.rig.clone(), vec![lines])?;
    let found = model.balance(setting, &[0])?;
    Ok(found.into_iter().next().map(|balance| balance.slip_gain).unwrap_or_default())
}
