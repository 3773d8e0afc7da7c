//! Modes of the declared beam beside the measured ones.

use crate::{StudyError, reconstruct::rig};
use frettrace_measurement::Measurement;
use serde::Serialize;
use std::f64::consts::TAU;

/// One mode.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Mode {
    /// Number from 1.
    pub number: usize,
    /// Natural frequency of the declared beam on its declared support (Hz).
    pub declared_hz: f64,
    /// Measured natural frequency (Hz), where the file gives one.
    pub measured_hz: Option<f64>,
    /// Its standard deviation (Hz), where the file gives one.
    pub measured_std_hz: Option<f64>,
    /// Measured damping ratio, where the file gives one.
    pub damping_ratio: Option<f64>,
    /// Mass-normalised shape at the sensors [kg^-1/2].
    pub shape_at_sensors: Vec<f64>,
}

/// The first modes of a measurement's beam: all measured ones, and those the signals can hold.
///
/// # Errors
/// [`StudyError`] where the declared beam is out of range.
pub fn modes(measurement: &Measurement) -> Result<Vec<Mode>, StudyError> {
    let model = rig(measurement)?.structure;
    let band = measurement.runs.iter().map(|run| 0.5 * run.sampling_rate).fold(0.0, f64::max);
    let measured = measurement.modes.as_ref();
    let count = measured.map_or(0, |modes| modes.frequency.len());
    let one = |(index, shape): (usize, &frettrace_beam::ModeShape)| Mode {
        number: index + 1,
        declared_hz: shape.natural_frequency() / TAU,
        measured_hz: measured.and_then(|modes| modes.frequency.get(index).copied()),
        measured_std_hz: measured.and_then(|modes| modes.frequency_std.get(index).copied()),
        damping_ratio: measured.and_then(|modes| modes.damping_ratio.get(index).copied()),
        shape_at_sensors: measurement.sensors.position.iter().map(|x| shape.derivatives(*x)[0]).collect(),
    };
    let wanted = |mode: &Mode| mode.number <= count || mode.declared_hz < band;
    Ok(model.shapes().iter().enumerate().map(one).take_while(wanted).collect())
}
