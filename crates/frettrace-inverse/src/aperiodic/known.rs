//! What is known of a run as lines, and moves the structure at its own frequencies.

use super::Left;
use crate::contact::Setting;
use crate::dynamics::{LineReceptances, Load};
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
    /// The steady response to the lines of the exciter alone.
    pub(crate) fn excited(setting: &Setting<'_>, lines: &RunLines) -> Self {
        let sensors = setting.dynamics.sensors();
        let mut motions = vec![vec![Complex64::ZERO]; sensors + 2];
        let mut line = LineReceptances::default();
        for (h, force) in lines.force.coefficients.iter().enumerate().skip(1) {
            setting.dynamics.fill(&setting.structure.model, lines.force.omega(h), &mut line);
            let gains = (0..sensors)
                .map(|s| line.acceleration(s, Load::Exciter))
                .chain([line.slip(Load::Exciter), line.end(Load::Exciter)]);
            motions.iter_mut().zip(gains).for_each(|(motion, gain)| motion.push(gain * force));
        }
        let mut series = motions.into_iter().map(|c| Harmonics::exact(lines.force.base, c));
        let accelerations = series.by_ref().take(sensors).map(|a| sampled(&a, lines)).collect();
        let mut next = || series.next().unwrap_or_else(|| Harmonics::exact(0.0, Vec::new()));
        let (slip, end) = (next(), next());
        let normal = sampled(&end, lines).iter().map(|w| -w * setting.normal_stiffness).collect();
        Self {
            exciter: alternating(&lines.force, lines),
            accelerations,
            contact: [
                vec![0.0; lines.samples],
                sampled(&slip, lines),
                sampled(&slip.derivative(), lines),
                normal,
                vec![0.0; lines.samples],
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

fn sampled(harmonics: &Harmonics, lines: &RunLines) -> Vec<f64> {
    harmonics.sample(lines.sampling_rate, lines.samples)
}

/// Samples without the mean, to which the structure's answer is no acceleration.
fn alternating(harmonics: &Harmonics, lines: &RunLines) -> Vec<f64> {
    let mut coefficients = harmonics.coefficients.clone();
    if let Some(mean) = coefficients.first_mut() {
        *mean = Complex64::ZERO;
    }
    sampled(&Harmonics::exact(harmonics.base, coefficients), lines)
}
