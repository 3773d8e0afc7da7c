//! Records that are not periodic: the same balance at every bin of the whole spectrum.
//!
//! On a finite record the response is the periodic response to the periodically continued forces plus a free decay of
//! every mode, `Σ_n φ_n Re(c_n e^{λ_n t})`: the states at the ends of the record enter as one complex unknown a mode, common
//! to all bins, and no steady state is needed. Without more, a free decay and an impulse at the record's ends could not be
//! told apart; a prior on the contact force does it, whose power at each bin is drawn from the record (tapered at first,
//! then the estimate itself: empirical Bayes).
//!
//! A force that is continued periodically jumps at the ends of the record, and modes above the band answer the jump. What the
//! lines of the excitation hold ([`Known`]) is therefore taken off first, with its response at its own frequencies, where
//! nothing jumps; only what is left is balanced bin by bin, and its prior is the smaller the nearer a run is to a period. The
//! contact force that is left may be continued as it likes, for its straight line and parabola make no acceleration.
//!
//! A drift of contact force and slip that is slower than the record leaves accelerations below the noise. It is taken out
//! as a polynomial and named unobservable; the bands hold what the prior gives it.

mod drift;
mod known;
mod outcome;
mod transient;

use crate::balance::{LineBalance, LineData};
use crate::contact::{RunBalance, Setting};
use crate::dynamics::{LineReceptances, Load};
use crate::{RunData, RunLines};
use faer::prelude::Solve;
use faer::{Col, Mat, Side};
use frettrace_fourier::{spectrum, tapered_spectrum};
pub(crate) use known::Known;
use num_complex::Complex64;
use rayon::prelude::*;
use std::f64::consts::TAU;
use transient::Transients;

/// Rounds of empirical Bayes; the estimate settles in two or three.
const ROUNDS: usize = 4;
/// Half width, in bins, of the average that makes the prior.
const SMOOTHING: usize = 4;
/// Bins whose normal equations are added up together.
const PART: usize = 64;

/// One bin.
struct Bin {
    line: LineReceptances,
    data: LineData,
    /// Variance (N²) of each force without prior.
    variances: Vec<f64>,
}

/// The balance of a run over its whole spectrum.
pub(crate) struct Whole<'a> {
    setting: &'a Setting<'a>,
    loads: &'a [Load],
    known: &'a Known,
    bins: Vec<Bin>,
    transients: Transients,
    base: f64,
    samples: usize,
}

/// What one round knows: prior powers of the forces (one vector a load), the balance of each bin under them, the amplitudes
/// of the free decays and the forces.
struct Round {
    priors: Vec<Vec<f64>>,
    balances: Vec<LineBalance>,
    amplitudes: Vec<f64>,
    covariance: Mat<f64>,
    forces: Vec<Vec<Complex64>>,
}

/// Solves a run without assuming a period; `known` is what is taken off first and put back at the end.
pub(crate) fn solve(
    setting: &Setting<'_>,
    run: &RunData<'_>,
    (lines, known): (&RunLines, &Known),
    loads: &[Load],
) -> RunBalance {
    let left = known.taken_off(run);
    let whole = Whole::new(setting, &left, (lines, known), loads);
    let mut round = whole.round(whole.tapered_priors(&left));
    for _ in 1..ROUNDS {
        let priors = whole.updated_priors(&round);
        round = whole.round(priors);
    }
    whole.outcome(&round)
}

/// Samples of a run: force, then accelerations.
pub(super) struct Left {
    force: Vec<f64>,
    accelerations: Vec<Vec<f64>>,
    rate: f64,
}

impl<'a> Whole<'a> {
    fn new(
        setting: &'a Setting<'a>,
        left: &Left,
        (lines, known): (&RunLines, &'a Known),
        loads: &'a [Load],
    ) -> Self {
        let samples = left.force.len();
        let base = TAU * left.rate / samples as f64;
        let order = (samples - 1) / 2;
        let scale = 2.0 / samples as f64;
        let force = spectrum(&left.force);
        let accelerations: Vec<_> = left.accelerations.iter().map(|a| spectrum(a)).collect();
        let variances: Vec<f64> = lines.noise_std.iter().map(|s| 2.0 * scale * s * s).collect();
        let free = vec![f64::INFINITY; loads.len()];
        let bins = (1..=order)
            .into_par_iter()
            .map(|k| {
                let mut line = LineReceptances::default();
                setting.dynamics.fill(&setting.structure.model, base * k as f64, &mut line);
                let data = LineData {
                    force: force[k] * scale,
                    force_variance: 0.0,
                    accelerations: accelerations.iter().map(|a| a[k] * scale).collect(),
                    variances: variances.clone(),
                };
                let plain = LineBalance::solve(&line, &data, loads, &free);
                Bin { variances: diagonal(&plain), line, data }
            })
            .collect();
        let transients = Transients::new(&setting.structure.model, left.rate, samples, order);
        Self { setting, loads, known, bins, transients, base, samples }
    }

    /// Powers of the contact forces of the tapered record: a taper forgets the states at the ends.
    fn tapered_priors(&self, left: &Left) -> Vec<Vec<f64>> {
        let force = tapered_spectrum(&left.force);
        let accelerations: Vec<_> = left.accelerations.iter().map(|a| tapered_spectrum(a)).collect();
        let free = vec![f64::INFINITY; self.loads.len()];
        let found: Vec<Vec<f64>> = self
            .bins
            .par_iter()
            .enumerate()
            .map(|(k, bin)| {
                let data = LineData {
                    force: force[k + 1],
                    accelerations: accelerations.iter().map(|a| a[k + 1]).collect(),
                    ..bin.data.clone()
                };
                let forces = LineBalance::solve(&bin.line, &data, self.loads, &free).forces;
                forces.iter().zip(&bin.variances).map(|(f, v)| (f.norm_sqr() - v).max(0.0)).collect()
            })
            .collect();
        self.smoothed(&found)
    }

    /// Powers of the estimate: its square and its variance.
    fn updated_priors(&self, round: &Round) -> Vec<Vec<f64>> {
        let found: Vec<Vec<f64>> = round
            .balances
            .par_iter()
            .zip(&round.forces)
            .map(|(balance, forces)| {
                forces.iter().zip(diagonal(balance)).map(|(f, posterior)| f.norm_sqr() + posterior).collect()
            })
            .collect();
        self.smoothed(&found)
    }

    /// Averages of powers (one vector a bin) over neighbouring bins, weighted by what the sensors know of each.
    fn smoothed(&self, powers: &[Vec<f64>]) -> Vec<Vec<f64>> {
        let count = self.bins.len();
        let weight = |v: f64| if v > 0.0 { v.recip() } else { 0.0 };
        (0..self.loads.len())
            .map(|u| {
                (0..count)
                    .map(|k| {
                        let near = k.saturating_sub(SMOOTHING)..(k + SMOOTHING + 1).min(count);
                        let (sum, total) = near.fold((0.0, 0.0), |(sum, total), i| {
                            let w = weight(self.bins[i].variances[u]);
                            (sum + w * powers[i][u], total + w)
                        });
                        (sum / total.max(f64::MIN_POSITIVE)).max(f64::MIN_POSITIVE)
                    })
                    .collect()
            })
            .collect()
    }

    /// The free decays by least squares over all bins, the contact forces eliminated; then the forces.
    fn round(&self, priors: Vec<Vec<f64>>) -> Round {
        let unknowns = self.transients.count();
        let balances: Vec<LineBalance> =
            self.bins.par_iter().enumerate().map(|(k, bin)| self.balance(k, bin, &priors)).collect();
        let (matrix, right) = self.normal_equations(&balances);
        let normal = Mat::from_fn(unknowns, unknowns, |i, k| {
            // Rounding of the largest entries may leave a decay that no sensor sees without curvature.
            matrix[i.min(k) * unknowns + i.max(k)] * if i == k { 1.0 + 1e-12 } else { 1.0 }
        });
        let (amplitudes, covariance) = match normal.llt(Side::Lower) {
            Ok(factor) => {
                let solved = factor.solve(Col::from_fn(unknowns, |i| right[i]));
                let inverse = factor.solve(Mat::<f64>::identity(unknowns, unknowns));
                ((0..unknowns).map(|i| solved[i]).collect(), inverse)
            }
            Err(_) => (vec![0.0; unknowns], Mat::zeros(unknowns, unknowns)),
        };
        let forces = balances
            .par_iter()
            .enumerate()
            .map(|(k, balance)| balance.response(&self.unexplained(k, &amplitudes)))
            .collect();
        Round { priors, balances, amplitudes, covariance, forces }
    }

    /// Normal matrix (upper triangle, row-major) and right side of the free decays.
    fn normal_equations(&self, balances: &[LineBalance]) -> (Vec<f64>, Vec<f64>) {
        let unknowns = self.transients.count();
        let zero = || (vec![0.0; unknowns * unknowns], vec![0.0; unknowns]);
        let add = |mut a: (Vec<f64>, Vec<f64>), b: (Vec<f64>, Vec<f64>)| {
            a.0.iter_mut().zip(&b.0).for_each(|(x, y)| *x += y);
            a.1.iter_mut().zip(&b.1).for_each(|(x, y)| *x += y);
            a
        };
        // Parts of one size, added in order: the sum is the same to the last digit however the work is shared out.
        let parts: Vec<_> = balances
            .par_chunks(PART)
            .enumerate()
            .map(|(part, balances)| {
                let mut sums = zero();
                for (k, balance) in balances.iter().enumerate() {
                    self.accumulate(part * PART + k, balance, &mut sums);
                }
                sums
            })
            .collect();
        parts.into_iter().fold(zero(), add)
    }

    fn balance(&self, k: usize, bin: &Bin, priors: &[Vec<f64>]) -> LineBalance {
        let prior: Vec<f64> = priors.iter().map(|p| p[k]).collect();
        LineBalance::solve(&bin.line, &bin.data, self.loads, &prior)
    }

    /// Accelerations of a bin without exciter and free decays.
    fn unexplained(&self, k: usize, amplitudes: &[f64]) -> Vec<Complex64> {
        let bin = &self.bins[k];
        let motion = self.modal(k, amplitudes);
        let decays = |s: usize| -> Complex64 {
            motion.iter().enumerate().map(|(n, a)| a * self.setting.dynamics.sensor_shape(n, s)).sum()
        };
        (0..bin.data.accelerations.len())
            .map(|s| {
                let exciter = bin.line.acceleration(s, Load::Exciter) * bin.data.force;
                bin.data.accelerations[s] - exciter - decays(s)
            })
            .collect()
    }

    /// Modal accelerations of the free decays in bin `k`; none where there are no amplitudes.
    fn modal(&self, k: usize, amplitudes: &[f64]) -> Vec<Complex64> {
        let pairs = amplitudes.chunks_exact(2).enumerate();
        pairs
            .map(|(n, c)| {
                self.transients.acceleration(2 * n, k) * c[0]
                    + self.transients.acceleration(2 * n + 1, k) * c[1]
            })
            .collect()
    }

    /// Shape of a mode at the sensors.
    fn shape(&self, mode: usize) -> Vec<Complex64> {
        let dynamics = self.setting.dynamics;
        (0..dynamics.sensors()).map(|s| Complex64::from(dynamics.sensor_shape(mode, s))).collect()
    }

    /// Adds one bin to the normal equations (upper triangle) of the free decays. Both decays of a mode have its shape, so
    /// that products are formed of shapes, and scaled.
    fn accumulate(&self, k: usize, balance: &LineBalance, (matrix, right): &mut (Vec<f64>, Vec<f64>)) {
        let unknowns = right.len();
        let target = balance.remainder(&self.unexplained(k, &[]));
        let shapes: Vec<Vec<Complex64>> =
            (0..unknowns / 2).map(|mode| balance.remainder(&self.shape(mode))).collect();
        let product =
            |a: &[Complex64], b: &[Complex64]| a.iter().zip(b).map(|(x, y)| x.conj() * y).sum::<Complex64>();
        // Twice: a bin's real and imaginary parts have half the variance each.
        let amplitude = |unknown: usize| self.transients.acceleration(unknown, k) * std::f64::consts::SQRT_2;
        let twice = std::f64::consts::SQRT_2;
        for (n, shape) in shapes.iter().enumerate() {
            let along = product(shape, &target) * twice;
            for i in [2 * n, 2 * n + 1] {
                right[i] += (amplitude(i).conj() * along).re;
            }
            for (q, other) in shapes.iter().enumerate().skip(n) {
                let common = product(shape, other);
                for i in [2 * n, 2 * n + 1] {
                    let scaled = amplitude(i).conj() * common;
                    for j in [2 * q, 2 * q + 1] {
                        matrix[i * unknowns + j] += (scaled * amplitude(j)).re;
                    }
                }
            }
        }
    }
}

/// Variance of each force.
fn diagonal(balance: &LineBalance) -> Vec<f64> {
    let n = balance.forces.len();
    let covariance = balance.covariance();
    (0..n).map(|u| covariance[u * n + u].re).collect()
}
