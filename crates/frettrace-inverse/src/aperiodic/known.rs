//! What is known of a run as lines, and moves the structure at its own frequencies.

use super::sources::OUTPUTS;
use crate::analysis::bands::{self, Band};
use crate::contact::ContactHarmonics;
use crate::{RunData, RunLines};
use frettrace_fourier::{Harmonics, spectrum};
use num_complex::Complex64;

/// Share of an output's variance below which an error that its lines have in common is not followed through the record.
const NEGLIGIBLE: f64 = 1e-3;

/// Samples of a run that are to be balanced.
#[derive(Clone, Debug)]
pub(crate) struct Left {
    /// Excitation force (N).
    pub(crate) force: Vec<f64>,
    /// Accelerations (m/s²).
    pub(crate) accelerations: Vec<Vec<f64>>,
    /// Noise of each sensor (m/s²).
    pub(crate) noise_std: Vec<f64>,
    /// Sampling rate (Hz).
    pub(crate) rate: f64,
}

impl Left {
    /// Excess of the accelerations, less a fit where there is one, over their noise, octave by octave.
    pub(crate) fn excesses(&self, fit: &[Vec<f64>]) -> Vec<Band> {
        let samples = self.force.len();
        let power = |(s, a): (usize, &Vec<f64>)| -> Vec<f64> {
            let fitted = |j: usize| fit.get(s).map_or(0.0, |fit| fit[j]);
            let left: Vec<f64> = a.iter().enumerate().map(|(j, a)| a - fitted(j)).collect();
            spectrum(&left).iter().map(|z| z.norm_sqr() / samples as f64).collect()
        };
        let powers: Vec<Vec<f64>> = self.accelerations.iter().enumerate().map(power).collect();
        bands::excesses(&powers.iter().map(Vec::as_slice).collect::<Vec<_>>(), &self.noise_std)
    }

    /// Mean square of the accelerations over that of their noise.
    pub(crate) fn power(&self) -> f64 {
        let square = |(a, noise): (&Vec<f64>, &f64)| {
            let sum: f64 = a.iter().map(|a| a * a).sum();
            sum / (a.len().max(1) as f64 * noise * noise).max(f64::MIN_POSITIVE)
        };
        let sum: f64 = self.accelerations.iter().zip(&self.noise_std).map(square).sum();
        sum / self.accelerations.len().max(1) as f64
    }
}

/// Samples of forces and motions that lines make.
#[derive(Clone, Debug, Default)]
pub(crate) struct Known {
    exciter: Vec<f64>,
    pub(super) accelerations: Vec<Vec<f64>>,
    /// Friction, slip, slip velocity, normal force less the preload, second support; empty for none.
    pub(super) contact: [Vec<f64>; OUTPUTS],
    /// Errors that the lines of an output have in common, a row each source; empty where they are negligible.
    pub(super) shared: Vec<[Vec<f64>; OUTPUTS]>,
}

impl Known {
    /// All that the lines of a solved run hold.
    pub(crate) fn solved(lines: &RunLines, contact: &ContactHarmonics) -> Self {
        let sampled = |harmonics: &Harmonics| harmonics.sample(lines.sampling_rate, lines.samples);
        let nothing = Harmonics::exact(contact.friction.base, Vec::new());
        let second = contact.second_support.as_ref().unwrap_or(&nothing);
        let outputs = [&contact.friction, &contact.slip, &contact.slip_velocity, &contact.normal, second];
        let errors = &contact.shared;
        let errors =
            [&errors.friction, &errors.slip, &errors.slip_velocity, &errors.normal, &errors.second_support];
        let error = |o: usize, p: usize| -> Vec<f64> {
            let total = 0.5 * outputs[o].variance.iter().sum::<f64>();
            let source = errors[o].get(p).cloned().unwrap_or_default();
            let power = 0.5 * source.iter().map(Complex64::norm_sqr).sum::<f64>();
            if power > NEGLIGIBLE * total {
                sampled(&Harmonics::exact(outputs[o].base, source))
            } else {
                Vec::new()
            }
        };
        Self {
            exciter: sampled(&alternating(&lines.force)),
            accelerations: contact.acceleration_fit.iter().map(sampled).collect(),
            contact: outputs.map(sampled),
            shared: (0..errors[0].len()).map(|p| std::array::from_fn(|o| error(o, p))).collect(),
        }
    }

    /// The exciter's lines with the accelerations that they make.
    pub(super) fn of_force(lines: &RunLines, accelerations: Vec<Vec<f64>>) -> Self {
        let exciter = alternating(&lines.force).sample(lines.sampling_rate, lines.samples);
        Self { exciter, accelerations, ..Self::default() }
    }

    /// What a run holds besides.
    pub(crate) fn taken_off(&self, run: &RunData<'_>, noise_std: &[f64]) -> Left {
        let less = |x: &[f64], known: &[f64]| x.iter().zip(known).map(|(x, k)| x - k).collect();
        let pairs = run.accelerations.iter().zip(&self.accelerations);
        Left {
            force: less(run.force, &self.exciter),
            accelerations: pairs.map(|(a, k)| less(a, k)).collect(),
            noise_std: noise_std.to_vec(),
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
