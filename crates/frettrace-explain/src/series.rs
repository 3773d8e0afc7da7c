//! What was recovered of a run that is not periodic, and the force of a law along it.

use frettrace_fourier::tapered_spectrum;
use frettrace_friction::effects::{Circumstance, ModifiedLaw, Reached};
use frettrace_friction::{Scalar, Step};
use num_complex::Complex64;

/// What was recovered of a run without a law and without a period, one value a sample.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Series {
    /// Duration between two samples (s).
    pub dt: f64,
    /// Slip (m).
    pub slip: Vec<f64>,
    /// Slip velocity (m/s).
    pub velocity: Vec<f64>,
    /// Normal force (N).
    pub normal: Vec<f64>,
    /// Friction force (N).
    pub force: Vec<f64>,
    /// Standard deviation of real and imaginary part of the force in each bin of the record (N); infinite where the
    /// sensors know nothing of it.
    pub deviation: Vec<f64>,
    /// Share of the time in which the normal force, an unknown of its own, stays at zero; 0 where the support holds.
    pub open_share: f64,
}

impl Series {
    /// Power (W) that the contact takes, the mean of force times slip velocity.
    pub(crate) fn dissipated(&self) -> f64 {
        let sum: f64 = self.force.iter().zip(&self.velocity).map(|(force, velocity)| force * velocity).sum();
        sum / self.force.len().max(1) as f64
    }

    /// Samples at the start of a record that only settle the law's state: the first tenth of them, and so many more that a
    /// transform of the rest is quick (a number of factors 2, 3 and 5).
    #[must_use]
    pub fn settling(samples: usize) -> usize {
        let smooth = |n: usize| {
            let rest = [2, 3, 5].iter().fold(n, |mut n, p| {
                while n % p == 0 {
                    n /= p;
                }
                n
            });
            rest == 1
        };
        let most = samples - samples / 10;
        samples - (1..=most).rev().find(|n| smooth(*n)).unwrap_or(most)
    }

    /// RMS of the slip about its mean (m).
    pub(crate) fn stroke(&self) -> f64 {
        let count = self.slip.len().max(1) as f64;
        let mean = self.slip.iter().sum::<f64>() / count;
        (self.slip.iter().map(|u| (u - mean).powi(2)).sum::<f64>() / count).sqrt().max(f64::MIN_POSITIVE)
    }

    /// Its last samples; the deviations stay those of the bins of the whole record.
    pub(crate) fn last(&self, most: usize) -> Self {
        let part = |x: &[f64]| x[x.len().saturating_sub(most)..].to_vec();
        Self {
            dt: self.dt,
            slip: part(&self.slip),
            velocity: part(&self.velocity),
            normal: part(&self.normal),
            force: part(&self.force),
            deviation: self.deviation.clone(),
            open_share: self.open_share,
        }
    }

    /// Force (N) of a law along the recovered motion, from rest, one value a sample. A rigid contact takes the force `trial`
    /// as long as it holds; `None` where the contact yields.
    #[must_use]
    pub fn answer<T: Scalar>(
        &self,
        law: &ModifiedLaw<T>,
        circumstance: &Circumstance,
        trial: Option<&[f64]>,
    ) -> Vec<T> {
        let mut state = law.rest_at(T::from(self.slip.first().copied().unwrap_or_default()));
        let mut reached = Reached::default();
        let mut force = vec![T::from(0.0); self.slip.len()];
        for (k, force) in force.iter_mut().enumerate().skip(1) {
            let ends = |series: &[f64]| [T::from(series[k - 1]), T::from(series[k])];
            let step = Step {
                slip: ends(&self.slip),
                velocity: ends(&self.velocity),
                normal: ends(&self.normal),
                dt: self.dt,
            };
            let (next, answered) = match trial {
                Some(trial) => law.advance_rigid(state, &step, (T::from(trial[k]), circumstance)),
                None => law.advance_on(state, &step, (circumstance, &mut reached)),
            };
            state = next;
            *force = answered;
        }
        force
    }

    /// Force (N) that a rigid contact takes as long as it holds: `F + R v`, with the resistance `R` that makes errors of force and
    /// velocity count by the same share of what they are errors of.
    pub(crate) fn trial(&self) -> Vec<f64> {
        let resistance = resistance(&self.force, &self.velocity);
        self.force.iter().zip(&self.velocity).map(|(force, v)| force + resistance * v).collect()
    }

    /// Amplitudes of a signal of the series in the bins of what is kept of it, tapered: its first [`Self::settling`] samples are
    /// left out.
    #[must_use]
    pub fn amplitudes(signal: &[f64]) -> Vec<Complex64> {
        tapered_spectrum(&signal[Self::settling(signal.len())..])
    }

    /// Standard deviation of the force (N) in a bin of what is kept of the last `samples` of the record: bins of a part lie farther
    /// apart than those of the record, and noise is larger in them.
    #[must_use]
    pub fn deviation_of(&self, bin: usize, samples: usize) -> f64 {
        let record = 2 * self.deviation.len().saturating_sub(1);
        let kept = samples - Self::settling(samples);
        let of_record = (bin as f64 * record as f64 / kept.max(1) as f64).round() as usize;
        let share = samples as f64 / record.max(1) as f64;
        self.deviation.get(of_record).map_or(f64::INFINITY, |d| d / share.sqrt())
    }
}

/// Resistance (N·s/m) that makes errors of force and velocity count by the same share of what they are errors of.
pub(crate) fn resistance(force: &[f64], velocity: &[f64]) -> f64 {
    let size = |x: &[f64]| x.iter().map(|x| x * x).sum::<f64>();
    (size(force) / size(velocity).max(f64::MIN_POSITIVE)).sqrt()
}
