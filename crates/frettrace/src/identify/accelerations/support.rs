//! The force of a declared second support beside the joint fit: its recovery with the calibrated structure, and what its unknown
//! mean leaves in doubt.

use frettrace_explain::support::{mean, set_means};
use frettrace_explain::{Fitted, Study};
use frettrace_forward::accelerations::{Beside, COEFFICIENTS, Port, PortLaw, PortPlace, Setting};

/// Recovers the force of a declared second support with the contact's, without a law, where the structure has been
/// calibrated; whether there is one.
pub(super) fn recover(study: &mut Study<'_>, setting: &Setting) -> bool {
    let Some(position) = study.case.rig.known_support else { return false };
    let port =
        Port { place: PortPlace::At(position), law: PortLaw::Polynomial, coefficients: [0.0; COEFFICIENTS] };
    let beside = Setting { ports: vec![port], ..setting.clone() };
    let runs: Vec<usize> = (0..study.model.runs.len()).collect();
    let Ok(found) = study.model.balance_beside(&beside, &runs, Beside::Ports) else { return false };
    for (run, change) in study.model.runs.iter_mut().zip(&found) {
        let more = change.beside.iter().flatten();
        run.known_force.iter_mut().zip(more).for_each(|(force, more)| *force += more);
    }
    set_means(&mut study.model.runs);
    true
}

/// Largest relative standard deviation that unknown means of the support forces give the normal force of a training run.
pub(super) fn doubt(study: &mut Study<'_>, fitted: &Fitted) -> f64 {
    if study.case.rig.known_support.is_none() {
        return 0.0;
    }
    let normal = |study: &Study<'_>, run: usize| {
        let contact = study.model.contact(&fitted.setting, run, &mut fitted.memory.clone()).ok()?;
        Some(contact.normal.iter().sum::<f64>() / contact.normal.len().max(1) as f64)
    };
    let mut largest = 0.0_f64;
    for run in study.training.clone() {
        let deviation = mean(&study.model.runs[run].known_force).1;
        let plain = normal(study, run);
        let Some(line) = study.model.runs[run].known_force.first_mut() else { continue };
        let held = std::mem::replace(line, *line + deviation);
        let moved = normal(study, run);
        study.model.runs[run].known_force[0] = held;
        if let (Some(plain), Some(moved)) = (plain, moved) {
            largest = largest.max(((moved - plain) / plain).abs());
        }
    }
    largest
}
