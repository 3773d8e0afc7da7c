//! A measurement file as the case of an explanation or a joint fit.

use crate::StudyError;
use frettrace_beam::{Boundary, UniformBeam};
use frettrace_explain::{Case, DeclaredModes, RunSamples};
use frettrace_forward::accelerations::Rig;
use frettrace_identify::contact::Family;
use frettrace_measurement::{Measurement, SlipKind};

/// Modes summed; the rest acts through its static flexibility.
const MODES: usize = 40;

/// The case a measurement file declares.
///
/// # Errors
/// [`StudyError::Run`] where the lines of a run cannot be found.
pub fn case(measurement: &Measurement) -> Result<Case, StudyError> {
    let noise = measurement.sensors.noise_std.as_deref();
    let samples: Vec<RunSamples<'_>> = measurement
        .runs
        .iter()
        .map(|run| RunSamples {
            sampling_rate: run.sampling_rate,
            excitation_frequency: run.excitation_frequency,
            preload: run.preload,
            force: &run.force,
            acceleration: &run.acceleration,
        })
        .collect();
    let (records, faults) = frettrace_explain::records(&samples, noise)
        .map_err(|(k, source)| StudyError::Run { run: measurement.runs[k].id.clone(), source })?;
    let law = Family::named(&measurement.support.law).unwrap_or(Family::Dahl);
    let mut case =
        Case { rig: rig(measurement), records, modes: modes(measurement), law, faults, without: Vec::new() };
    case.open_higher_modes()?;
    if let Some(second) = &measurement.second_support {
        case.know_support(second.position)?;
    }
    Ok(case)
}

fn rig(measurement: &Measurement) -> Rig {
    let beam = &measurement.beam;
    let mut uniform = UniformBeam::rectangular(
        beam.length,
        [beam.width, beam.thickness],
        beam.youngs_modulus,
        beam.density,
    );
    if let Some(second_moment) = beam.second_moment {
        uniform.bending_stiffness = beam.youngs_modulus * second_moment;
    }
    if let Some(area) = beam.area {
        uniform.mass_per_length = beam.density * area;
    }
    let support = &measurement.support;
    let turns = support.slip == SlipKind::Rotation;
    Rig {
        boundary: Boundary::spring(support.normal_stiffness),
        beam: uniform,
        exciter: measurement.exciter.position,
        sensors: measurement.sensors.position.clone(),
        lever: turns.then_some(support.lever_arm),
        known_support: None,
        modes: MODES,
    }
}

fn modes(measurement: &Measurement) -> DeclaredModes {
    let tau = std::f64::consts::TAU;
    let scaled = |values: &[f64]| values.iter().map(|f| f * tau).collect();
    measurement.modes.as_ref().map_or_else(DeclaredModes::default, |m| DeclaredModes {
        frequency: scaled(&m.frequency),
        frequency_std: scaled(&m.frequency_std),
        damping: m.damping_ratio.clone(),
        damping_std: m.damping_ratio_std.clone(),
        measured: m.frequency.len(),
    })
}
