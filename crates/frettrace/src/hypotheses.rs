//! Amplitude-dependent modes of a measurement: three hypotheses at every level.

use crate::reconstruct::{ReconstructOptions, reconstruct, rig};
use crate::{Progress, StudyError};
use frettrace_inverse::compare_modes;
use frettrace_measurement::Measurement;
use serde::Serialize;

/// One run under the three hypotheses (errors are relative root mean squares over all sensors and lines).
#[derive(Clone, Debug, Serialize)]
pub struct Level {
    /// Name of the run.
    pub run: String,
    /// Root mean square of the accelerations, mean over the sensors (m/s²).
    pub level: f64,
    /// Excitation frequency (Hz).
    pub frequency_hz: f64,
    /// Preload (N).
    pub preload: f64,
    /// Whether the contact was lubricated, where stated.
    pub lubricated: Option<bool>,
    /// Number of modes of the first two hypotheses.
    pub modes: usize,
    /// Error of fixed linear modes.
    pub fixed: f64,
    /// Error of real modes of the level.
    pub real: f64,
    /// Error of the harmonic balance.
    pub harmonic: f64,
    /// The same of noise alone.
    pub noise_floor: f64,
    /// First real mode of the level at the sensors, largest entry one.
    pub shape: Vec<f64>,
    /// Modal assurance criterion of that shape with the linear mode most alike.
    pub assurance: f64,
    /// That linear mode, from 0.
    pub resembles: usize,
    /// Root mean square of the first generalised acceleration (m/s²).
    pub coordinate: f64,
}

/// Compares the hypotheses on all runs that have lines.
///
/// # Errors
/// [`StudyError`] where the declared rig or a run cannot be used.
pub fn hypotheses(measurement: &Measurement, progress: &Progress) -> Result<Vec<Level>, StudyError> {
    let declared = rig(measurement)?;
    let found = reconstruct(measurement, &ReconstructOptions::default(), progress)?.inverse;
    let rows = found.runs.iter().zip(&measurement.runs).filter_map(|(run, file)| {
        let compared = compare_modes(&declared, run)?;
        let sensors = run.lines.accelerations.len().max(1) as f64;
        let square: f64 = run.lines.accelerations.iter().map(|a| a.rms().powi(2)).sum();
        Some(Level {
            run: file.id.clone(),
            level: (square / sensors).sqrt(),
            frequency_hz: run.lines.frequency.base * run.lines.subharmonic_order as f64
                / std::f64::consts::TAU,
            preload: file.preload,
            lubricated: file.lubricated,
            modes: compared.modes,
            fixed: compared.fixed,
            real: compared.real,
            harmonic: compared.harmonic,
            noise_floor: compared.noise_floor,
            shape: compared.shape,
            assurance: compared.assurance,
            resembles: compared.resembles,
            coordinate: compared.coordinate,
        })
    });
    Ok(rows.collect())
}
