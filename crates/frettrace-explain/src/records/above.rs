//! Lines above those that are compared with a model, in a channel that clips.
//!
//! What a rig does near half the sampling rate, and above the lines of a model, is in no error ([`super::RunRecord`]). A channel that is
//! read as it is projects it out with its lines. One that clips has none: there the lines `x` above the compared ones are those
//! that leave least of what was read less what is predicted, `r(t)`, at the samples where nothing is cut,
//!
//! `min_x Σ_open (r(t) − Σ_h Re x_h e^{ihΩt})²`,
//!
//! with normal equations from the one sum `g(m) = Σ_open e^{imΩt}`, `½ Re/Im g(h ± k)`. They are added to what is predicted before it is cut.

use faer::Side;
use faer::linalg::solvers::{Llt, Solve};
use faer::{Col, Mat};
use num_complex::Complex64;
use std::sync::Arc;

/// Samples that nothing cuts, for each unknown.
const OPEN: usize = 3;

/// The normal equations of the lines `first …` of a run in the samples of a channel that nothing cuts.
#[derive(Clone, Debug)]
pub(crate) struct Above {
    first: usize,
    angle: f64,
    open: Arc<[bool]>,
    factor: Arc<Llt<f64>>,
}

impl Above {
    /// Lines `first ..= last` of a base of `angle` radians a sample; `None` where there are none, or too few samples are open.
    pub(crate) fn new((first, last): (usize, usize), angle: f64, open: Vec<bool>) -> Option<Self> {
        let count = (last + 1).checked_sub(first).filter(|count| *count > 0)?;
        if open.iter().filter(|open| **open).count() < OPEN * 2 * count {
            return None;
        }
        let mut sums = vec![Complex64::ZERO; 2 * last + 1];
        for (k, _) in open.iter().enumerate().filter(|(_, open)| **open) {
            let turn = Complex64::from_polar(1.0, angle * k as f64);
            sums.iter_mut().fold(Complex64::ONE, |power, sum| {
                *sum += power;
                power * turn
            });
        }
        let normal = Mat::from_fn(2 * count, 2 * count, |i, j| {
            let (h, k) = (first + i % count, first + j % count);
            let (sum, difference) = (sums[h + k], sums[h.abs_diff(k)]);
            // Sine of h less k, whatever the order of both.
            let sine = if h >= k { difference.im } else { -difference.im };
            0.5 * match (i < count, j < count) {
                (true, true) => difference.re + sum.re,
                (false, false) => difference.re - sum.re,
                (true, false) => sum.im - sine,
                (false, true) => sum.im + sine,
            }
        });
        let factor = Arc::new(normal.llt(Side::Lower).ok()?);
        Some(Self { first, angle, open: open.into(), factor })
    }

    /// Samples of the lines that leave least of `rest` where nothing is cut.
    pub(crate) fn of(&self, rest: &[f64]) -> Vec<f64> {
        let count = self.factor.L().nrows() / 2;
        let mut right = Col::<f64>::zeros(2 * count);
        for ((rest, open), phasors) in rest.iter().zip(self.open.iter()).zip(self.phasors()) {
            if *open {
                for (i, phasor) in phasors.enumerate() {
                    right[i] += rest * phasor.re;
                    right[count + i] += rest * phasor.im;
                }
            }
        }
        let found = self.factor.solve(&right);
        let sample = |phasors: &mut dyn Iterator<Item = Complex64>| {
            phasors.enumerate().map(|(i, p)| found[i] * p.re + found[count + i] * p.im).sum()
        };
        rest.iter().zip(self.phasors()).map(|(_, mut phasors)| sample(&mut phasors)).collect()
    }

    /// `e^{ihΩt}` of all lines, sample by sample.
    fn phasors(&self) -> impl Iterator<Item = impl Iterator<Item = Complex64>> {
        let count = self.factor.L().nrows() / 2;
        (0..).map(move |k: usize| {
            let turn = Complex64::from_polar(1.0, self.angle * k as f64);
            let from = Complex64::from_polar(1.0, self.angle * (k * self.first) as f64);
            std::iter::successors(Some(from), move |p| Some(p * turn)).take(count)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::Above;

    /// A wave of the 7th and 9th line, cut off in a fifth of the samples: known exactly from the rest.
    #[test]
    fn lines_are_known_from_the_samples_that_are_open() {
        let angle = 0.0613;
        let open: Vec<bool> = (0..700).map(|k| (angle * k as f64).cos() < 0.8).collect();
        let wave = |k: usize| {
            let t = angle * k as f64;
            0.3 * (7.0 * t).cos() - 0.2 * (9.0 * t + 0.4).sin()
        };
        let rest: Vec<f64> = (0..700).map(|k| if open[k] { wave(k) } else { -55.0 }).collect();
        let above = Above::new((7, 9), angle, open).unwrap();
        for (k, found) in above.of(&rest).into_iter().enumerate() {
            assert!((found - wave(k)).abs() < 1e-12, "{k}: {found}");
        }
    }

    /// Forty lines are not known from a tenth of 700 samples, and none above the last are asked for.
    #[test]
    fn too_few_open_samples_tell_nothing() {
        let open: Vec<bool> = (0..700).map(|k| k % 10 == 0).collect();
        assert!(Above::new((7, 46), 0.0613, open.clone()).is_none());
        assert!(Above::new((7, 6), 0.0613, open).is_none());
    }
}
