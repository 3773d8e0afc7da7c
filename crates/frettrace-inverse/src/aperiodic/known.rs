//! What is known of a run as lines, and moves the structure at its own frequencies.

use super::Left;
use crate::contact::ContactHarmonics;
use crate::{RunData, RunLines};
use frettrace_fourier::Harmonics;
use num_complex::Complex64;

/// Samples of forces and motions that lines make.
#[derive(Clone, Debug, Default)]
pub(crate) struct Known {
    pub(super) exciter: Vec<f64>,
    pub(super) accelerations: Vec<Vec<f64>>,
    /// Friction, slip, slip velocity, normal force less the preload, second support.
    pub(super) contact: [Vec<f64>; 5],
}

impl Known {
    /// All that the lines of a solved run hold.
    pub(crate) fn solved(lines: &RunLines, contact: &ContactHarmonics) -> Self {
        let sampled = |harmonics: &Harmonics| harmonics.sample(lines.sampling_rate, lines.samples);
        let second = contact.second_support.as_ref().map(sampled);
        Self {
            exciter: sampled(&alternating(&lines.force)),
            accelerations: contact.acceleration_fit.iter().map(sampled).collect(),
            contact: [
                sampled(&contact.friction),
                sampled(&contact.slip),
                sampled(&contact.slip_velocity),
                sampled(&contact.normal),
                second.unwrap_or_else(|| vec![0.0; lines.samples]),
            ],
        }
    }

    /// What a run holds besides.
    pub(super) fn taken_off(&self, run: &RunData<'_>) -> Left {
        let less = |x: &[f64], known: &[f64]| x.iter().zip(known).map(|(x, k)| x - k).collect();
        Left {
            force: less(run.force, &self.exciter),
            accelerations: run
                .accelerations
                .iter()
                .zip(&self.accelerations)
                .map(|(a, k)| less(a, k))
                .collect(),
            rate: run.sampling_rate,
        }
    }
}

/// The same without the mean, to which the structure's answer is no acceleration.
fn alternating(harmonics: &Harmonics) -> Harmonics {
    let mut coefficients = harmonics.coefficients.clone();
    if let Some(mean) = coefficients.first_mut() {
        *mean = Complex64::ZERO;
    }
    Harmonics::exact(harmonics.base, coefficients)
}
