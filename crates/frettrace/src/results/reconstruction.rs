//! What a reconstruction comes to, run by run; the signals themselves are in `REC.h5`.

use super::{Structure, number};
use serde::{Deserialize, Serialize};

/// A reconstruction in figures.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ReconstructionSummary {
    /// The runs.
    pub runs: Vec<RunSummary>,
    /// The calibrated structure.
    pub structure: Structure,
}

/// One run.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct RunSummary {
    /// Name of the run's group.
    pub run: String,
    /// `harmonic`, `subharmonic` or `aperiodic`.
    pub form: String,
    /// Periods of the excitation in one period of the motion.
    pub subharmonic_order: u32,
    /// Base frequency of the motion [Hz].
    #[serde(with = "number::scalar")]
    pub fundamental_frequency: f64,
    /// Harmonics kept.
    pub harmonics: u32,
    /// Relative RMS of measured minus fitted acceleration.
    #[serde(with = "number::scalar")]
    pub acceleration_error: f64,
    /// The same measure for a perfect model.
    #[serde(with = "number::scalar")]
    pub noise_floor: f64,
    /// Largest friction force [N], its mean left out.
    #[serde(with = "number::scalar")]
    pub friction_peak: f64,
    /// Largest slip [m], its mean left out.
    #[serde(with = "number::scalar")]
    pub slip_peak: f64,
    /// What to mind.
    pub note: Option<String>,
}

impl From<&frettrace_measurement::ReconstructedRun> for RunSummary {
    fn from(run: &frettrace_measurement::ReconstructedRun) -> Self {
        let peak = |values: &[f64]| values.iter().fold(0.0, |peak: f64, value| peak.max(value.abs()));
        Self {
            run: run.id.clone(),
            form: format!("{:?}", run.form).to_lowercase(),
            subharmonic_order: run.subharmonic_order,
            fundamental_frequency: run.fundamental_frequency,
            harmonics: run.harmonics,
            acceleration_error: run.acceleration_error,
            noise_floor: run.noise_floor,
            friction_peak: peak(&run.friction_force.values),
            slip_peak: peak(&run.slip_displacement.values),
            note: run.note.clone(),
        }
    }
}
