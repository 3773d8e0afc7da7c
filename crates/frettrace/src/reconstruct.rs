//! A measurement file to the inverse and back: types are mapped, nothing is computed.

use crate::results::{Estimate, ModeEstimate, Structure};
use crate::{Progress, StudyError};
use frettrace_beam::{Boundary, ModalModel, ModalOptions, UniformBeam};
use frettrace_fourier::Harmonics;
use frettrace_identify::HALF_INTERVAL95;
use frettrace_inverse::{
    CalibratedStructure, Channel, Finding, Form, ModeTrust, Options, Rig, RunData, RunReconstruction, Sensor,
    Slip,
};
use frettrace_measurement as file;
use frettrace_measurement::{Measurement, Run, SlipKind};
use std::f64::consts::TAU;

pub use frettrace_inverse::FormChoice;

/// Options of a reconstruction.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ReconstructOptions {
    /// Form of the answer.
    pub form: FormChoice,
    /// Smooth the friction force of periodic runs by a periodic spline.
    pub splines: bool,
    /// Keep the structure as it is declared.
    pub as_declared: bool,
}

/// A reconstruction: what goes into the file, and the structure it rests on.
#[derive(Clone, Debug)]
pub struct Reconstruction {
    /// For `REC.h5`.
    pub result: file::Reconstruction,
    /// The calibrated structure.
    pub structure: Structure,
    /// All that the inverse found, for the steps after it.
    pub inverse: frettrace_inverse::Reconstruction,
}

/// Trust in a measured natural frequency whose standard deviation is not stated: a careful modal test.
const FREQUENCY_TRUST: f64 = 1e-3;
/// Trust in a measured damping ratio whose standard deviation is not stated.
const DAMPING_TRUST: f64 = 0.1;
/// Trust in the frequencies of the declared beam, relative.
const DECLARED_FREQUENCY: f64 = 0.01;
/// Trust in the damping of modes nobody measured, as the logarithm of a factor.
const DECLARED_DAMPING: f64 = 0.5;
/// Damping ratio to start from where none is given: bare steel beams have 0.1 to 2 %.
const USUAL_DAMPING: f64 = 5e-3;
/// The same as [`DECLARED_DAMPING`] where no mode was measured at all.
const UNKNOWN_DAMPING: f64 = 1.5;
/// Modes are summed up to this multiple of half the sampling rate; the rest acts by its flexibility.
const SUMMED: f64 = 4.0;
/// Half a wavelength over the thickness from which on the section stays plane and local deformation does not matter; at three
/// shear and rotary inertia take some ten per cent off a natural frequency.
const SLENDER: f64 = 3.0;
/// What lies beyond so many modes is less than half a per cent of the contact's compliance.
const MOST_BEAM_MODES: usize = 80;
/// A pinned support is a spring this many times stiffer than the beam, so that its reaction can be told.
const PINNED: f64 = 1e6;

/// Reconstructs the contact of all runs of a measurement.
///
/// # Errors
/// [`StudyError`] where the declared rig or a run cannot be used.
pub fn reconstruct(
    measurement: &Measurement,
    options: &ReconstructOptions,
    progress: &Progress,
) -> Result<Reconstruction, StudyError> {
    progress.start(1, "reconstructing");
    let rig = rig(measurement)?;
    let runs: Vec<RunData<'_>> = measurement.runs.iter().map(run_data).collect();
    let options = Options { form: options.form, calibrate: !options.as_declared, splines: options.splines };
    let inverse = frettrace_inverse::reconstruct(&rig, &runs, &options)?;
    let runs = inverse
        .runs
        .iter()
        .zip(&measurement.runs)
        .map(|(found, run)| written(found, run, &inverse.findings))
        .collect();
    progress.step();
    let result = file::Reconstruction {
        title: measurement.title.clone(),
        sensor_position: measurement.sensors.position.clone(),
        runs,
    };
    Ok(Reconstruction { result, structure: structure(&inverse.structure), inverse })
}

/// The inverse's view of the declared rig.
///
/// # Errors
/// [`StudyError`] where the beam or its support is out of range.
pub fn rig(measurement: &Measurement) -> Result<Rig, StudyError> {
    let beam = uniform_beam(&measurement.beam);
    let stiffness = told_apart(measurement.support.normal_stiffness, &beam);
    let structure = modal_model(measurement, &beam, stiffness)?;
    let noise = measurement.sensors.noise_std.as_ref();
    let sensors = measurement.sensors.position.iter().enumerate();
    Ok(Rig {
        trust: trust(measurement, &structure),
        structure,
        beam_modes: beam_modes(&measurement.beam),
        slip: match measurement.support.slip {
            SlipKind::Rotation => Slip::Rotation { lever_arm: measurement.support.lever_arm },
            SlipKind::Transverse => Slip::Transverse,
        },
        normal_stiffness: if measurement.support.slip == SlipKind::Rotation { stiffness } else { 0.0 },
        second_support: measurement.second_support.map(|second| second.position),
        exciter: measurement.exciter.position,
        sensors: sensors
            .map(|(s, &position)| Sensor { position, noise_std: noise.and_then(|n| n.get(s).copied()) })
            .collect(),
    })
}

/// Modes whose half wavelength is at least [`SLENDER`] thicknesses.
fn beam_modes(beam: &file::Beam) -> usize {
    ((beam.length / (SLENDER * beam.thickness)) as usize).clamp(1, MOST_BEAM_MODES)
}

/// A beam as a file has it.
pub(crate) fn uniform_beam(beam: &file::Beam) -> UniformBeam {
    let plain = UniformBeam::rectangular(
        beam.length,
        [beam.width, beam.thickness],
        beam.youngs_modulus,
        beam.density,
    );
    UniformBeam {
        bending_stiffness: beam.second_moment.map_or(plain.bending_stiffness, |i| beam.youngs_modulus * i),
        mass_per_length: beam.area.map_or(plain.mass_per_length, |a| beam.density * a),
        ..plain
    }
}

/// A support's stiffness (N/m), finite so that its reaction can be told from its motion.
pub(crate) fn told_apart(stiffness: f64, beam: &UniformBeam) -> f64 {
    if stiffness.is_finite() { stiffness } else { PINNED * beam.bending_stiffness / beam.length.powi(3) }
}

fn modal_model(
    measurement: &Measurement,
    beam: &UniformBeam,
    stiffness: f64,
) -> Result<ModalModel, StudyError> {
    let modes = measurement.modes.as_ref();
    let frequency: Vec<f64> = modes.map_or(Vec::new(), |m| m.frequency.iter().map(|f| TAU * f).collect());
    let damping = modes.map_or(vec![USUAL_DAMPING], |m| m.damping_ratio.clone());
    let options = |modes| ModalOptions {
        modes,
        natural_frequency: frequency.clone(),
        damping_ratio: damping.clone(),
        ..ModalOptions::default()
    };
    let boundary = Boundary::spring(stiffness);
    // Natural frequencies grow as the square of their number: one mode tells how many reach the band's end.
    let first =
        ModalModel::new(beam, &boundary, &options(frequency.len().max(1)))?.shapes()[0].natural_frequency();
    let highest = measurement.runs.iter().map(|run| 0.5 * TAU * run.sampling_rate).fold(0.0, f64::max);
    let count = (1.875 / std::f64::consts::PI * (SUMMED * highest / first).sqrt()).ceil() as usize + 2;
    Ok(ModalModel::new(beam, &boundary, &options(count.clamp(frequency.len().max(12), 80)))?)
}

/// Trust in the measured modes, and in those of the declared beam within the band.
fn trust(measurement: &Measurement, structure: &ModalModel) -> Vec<ModeTrust> {
    let highest = measurement.runs.iter().map(|run| 0.5 * TAU * run.sampling_rate).fold(0.0, f64::max);
    let in_band = structure.natural_frequency().iter().take_while(|w| **w < highest).count();
    let modes = measurement.modes.as_ref();
    let measured = structure.measured_count();
    let relative = |std: Option<&f64>, value: f64, otherwise: f64| match std {
        Some(std) if *std > 0.0 && value > 0.0 => std / value,
        _ => otherwise,
    };
    let damping = if modes.is_some() { DECLARED_DAMPING } else { UNKNOWN_DAMPING };
    (0..in_band.max(measured))
        .map(|n| match modes {
            Some(m) if n < measured => ModeTrust {
                frequency: relative(m.frequency_std.get(n), m.frequency[n], FREQUENCY_TRUST),
                damping: relative(m.damping_ratio_std.get(n), structure.damping_ratio()[n], DAMPING_TRUST),
            },
            _ => ModeTrust { frequency: DECLARED_FREQUENCY, damping },
        })
        .collect()
}

/// The inverse's view of a run.
#[must_use]
pub fn run_data(run: &Run) -> RunData<'_> {
    RunData {
        id: &run.id,
        sampling_rate: run.sampling_rate,
        excitation_frequency: run.excitation_frequency,
        preload: run.preload,
        force: &run.force,
        accelerations: run.acceleration.iter().map(Vec::as_slice).collect(),
    }
}

fn written(found: &RunReconstruction, run: &Run, findings: &[Finding]) -> file::ReconstructedRun {
    let notes: Vec<String> =
        found.notes.iter().cloned().chain(findings.iter().map(Finding::to_string)).collect();
    let balance = found.balance.reduced();
    let mut numbers = vec![
        ("balance_residual".to_owned(), balance),
        ("normal_reaction_unknown".to_owned(), f64::from(u8::from(found.normal_deviates))),
        ("regularised_lines".to_owned(), found.regularised_lines.len() as f64),
    ];
    if let Some((sensor, share)) = found.balance.worst_sensor() {
        numbers.push(("balance_worst_sensor".to_owned(), sensor as f64));
        numbers.push(("balance_worst_sensor_share".to_owned(), share));
    }
    file::ReconstructedRun {
        id: run.id.clone(),
        label: run.label.clone(),
        fundamental_frequency: found.lines.frequency.base / TAU,
        form: match found.lines.form {
            Form::Harmonic => file::Form::Harmonic,
            Form::Subharmonic => file::Form::Subharmonic,
            Form::Aperiodic => file::Form::Aperiodic,
        },
        subharmonic_order: found.lines.subharmonic_order as u32,
        harmonics: found.lines.force.order() as u32,
        acceleration_error: found.acceleration_error,
        noise_floor: found.noise_floor,
        unobservable: found.unobservable.iter().map(|&name| name.to_owned()).collect(),
        note: (!notes.is_empty()).then(|| notes.join("; ")),
        numbers,
        time: found.time.clone(),
        friction_force: estimate(&found.friction_force),
        normal_force: estimate(&found.normal_force),
        slip_displacement: estimate(&found.slip_displacement),
        slip_velocity: estimate(&found.slip_velocity),
        acceleration_fit: found.acceleration_fit.iter().map(estimate).collect(),
        second_support_force: found.second_support_force.as_ref().map(estimate),
        coefficients: coefficients(found),
    }
}

fn estimate(channel: &Channel) -> file::Estimate {
    file::Estimate { values: channel.values.clone(), std: channel.std.clone() }
}

fn coefficients(found: &RunReconstruction) -> file::HarmonicTable {
    let lines = &found.lines.force;
    let mut quantities = vec![table("force", "N", lines)];
    if let Some(contact) = &found.contact {
        quantities.push(table("friction_force", "N", &contact.friction));
        quantities.push(table("slip_displacement", "m", &contact.slip));
        quantities.push(table("slip_velocity", "m/s", &contact.slip_velocity));
        quantities.push(table("normal_force", "N", &contact.normal));
        if let Some(second) = &contact.second_support {
            quantities.push(table("second_support_force", "N", second));
        }
    }
    let frequency = (0..=lines.order()).map(|h| lines.omega(h) / TAU).collect();
    file::HarmonicTable { frequency, quantities }
}

fn table(name: &str, units: &str, harmonics: &Harmonics) -> file::Coefficients {
    file::Coefficients {
        name: name.to_owned(),
        units: units.to_owned(),
        values: harmonics.coefficients.clone(),
        std: harmonics.variance.iter().map(|v| v.sqrt()).collect(),
    }
}

fn structure(calibrated: &CalibratedStructure) -> Structure {
    let modes = (0..calibrated.modes)
        .map(|n| ModeEstimate {
            frequency: normal_estimate(
                calibrated.model.natural_frequency()[n] / TAU,
                calibrated.frequency_std(n),
                "Hz",
            ),
            damping_ratio: normal_estimate(
                calibrated.model.damping_ratio()[n],
                calibrated.damping_std(n),
                "1",
            ),
        })
        .collect();
    Structure { modes }
}

/// An estimate whose logarithm is normal with the given standard deviation.
fn normal_estimate(value: f64, relative_std: f64, unit: &str) -> Estimate {
    let factor = (HALF_INTERVAL95 * relative_std).exp();
    Estimate {
        value,
        std: value * relative_std,
        interval95: [value / factor, value * factor],
        unit: unit.to_owned(),
        identifiable: true,
    }
}
