//! Standard deviations of recovered less answered force, bin by bin.

use super::{DRAWS, JUMP, NEAR, OpenRun};
use crate::aperiodic::motion::Motion;
use crate::series::Series;
use crate::series_fit::ACCURACY;
use frettrace_friction::effects::ModifiedLaw;
use nalgebra::DVector;
use num_complex::Complex64;
use rand_distr::{Distribution, StandardNormal};
use rand_pcg::Pcg64;
use std::f64::consts::TAU;

impl OpenRun {
    /// Adds the accuracy of the method to the deviations: that of a recovered force, and where a rigid contact's force jumps as the slip turns, what
    /// a shift by [`JUMP`] of a step, `δ`, makes of each bin, `2πfδ` of its amplitude.
    pub(super) fn blur(&mut self, measured: &[Complex64]) {
        let size: f64 = self.bins.iter().map(|&k| measured[k].norm_sqr()).sum();
        let known = ACCURACY * (0.5 * size / self.bins.len().max(1) as f64).sqrt();
        let steps = (2 * self.fine * measured.len()) as f64;
        let shift = if self.rigid { JUMP * TAU / steps } else { 0.0 };
        for (deviation, &k) in self.deviation.iter_mut().zip(&self.bins) {
            *deviation = deviation.hypot(known).hypot(shift * k as f64 * measured[k].norm());
        }
    }

    /// Weighs the bins by what the errors of each bin of its own make of the difference between recovered and answered force: a force that is
    /// off by `e` has a slip that is off by `−R e`, and a law answers to that.
    pub fn weigh(&mut self, law: &ModifiedLaw<f64>, xi: &DVector<f64>) {
        let measured = Series::amplitudes(&self.moved(xi).force);
        self.deviation = self.deviations(&|motion: &Motion| self.answer(law, motion, self.waved(xi)), xi);
        self.blur(&measured);
    }

    /// Standard deviations of recovered less answered force in the bins compared.
    pub(super) fn deviations(&self, answer: &dyn Fn(&Motion) -> Vec<f64>, xi: &DVector<f64>) -> Vec<f64> {
        let plain = self.moved(xi);
        let base = answer(&plain);
        let mut random = Pcg64::new(self.index as u128, 0x5eed);
        let mut power = vec![0.0; self.bins.len()];
        for _ in 0..DRAWS {
            let error = self.drawn(&mut random);
            let mut moved = plain.clone();
            moved.add(&error, 1.0);
            let answered: Vec<f64> =
                answer(&moved).iter().zip(&base).map(|(moved, base)| moved - base).collect();
            let (force, answered) = (Series::amplitudes(&error.force), self.amplitudes(&answered));
            let change = |k: usize| force[k] - answered[k];
            power.iter_mut().zip(&self.bins).for_each(|(sum, &k)| *sum += 0.5 * change(k).norm_sqr());
        }
        (0..power.len())
            .map(|b| {
                let near = &power[b.saturating_sub(NEAR)..(b + NEAR + 1).min(power.len())];
                (near.iter().sum::<f64>() / (DRAWS * near.len()) as f64).sqrt()
            })
            .collect()
    }

    /// Errors that each bin has of its own.
    fn drawn(&self, random: &mut Pcg64) -> Motion {
        let samples = self.whole.found.force.len();
        let rate = self.whole.dt.recip();
        let base = TAU * rate / samples as f64;
        let mut normal = |deviation: f64| {
            let [re, im]: [f64; 2] = std::array::from_fn(|_| StandardNormal.sample(random));
            Complex64::new(re, im) * deviation
        };
        let force: Vec<Complex64> = self.whole.own.iter().map(|d| normal(*d)).collect();
        let load: Vec<Complex64> = self.whole.own_normal.iter().map(|d| normal(*d)).collect();
        let slip: Vec<Complex64> = force.iter().zip(self.gain.iter()).map(|(f, gain)| -f * gain).collect();
        let speed = slip
            .iter()
            .enumerate()
            .map(|(k, u)| u * Complex64::new(0.0, base * k as f64))
            .collect::<Vec<_>>();
        let sampled =
            |bins: Vec<Complex64>| frettrace_fourier::Harmonics::exact(base, bins).sample(rate, samples);
        Motion { force: sampled(force), slip: sampled(slip), velocity: sampled(speed), normal: sampled(load) }
    }
}
