//! Records that are not periodic: the same balance at every bin of the whole spectrum.
//!
//! On a finite record the response is the periodic response to the periodically continued forces plus a free decay of
//! every mode, `Σ_n φ_n Re(c_n e^{λ_n t})`: the states at the ends of the record enter as one complex unknown a mode, common
//! to all bins, and no steady state is needed. Without more, a free decay and an impulse at the record's ends could not be
//! told apart; a prior on the contact force does it, whose power at each bin is drawn from the record (tapered at first,
//! then the estimate itself: empirical Bayes).
//!
//! A drift of contact force and slip that is slower than the record leaves accelerations below the noise. It is taken out
//! as a polynomial and named unobservable.

mod outcome;
mod transient;

use crate::balance::{LineBalance, LineData};
use crate::contact::{RunBalance, Setting};
use crate::dynamics::{LineReceptances, Load};
use crate::{RunData, RunLines};
use faer::prelude::Solve;
use faer::{Col, Mat, Side};
use frettrace_fourier::spectrum;
use num_complex::Complex64;
use rayon::prelude::*;
use std::f64::consts::TAU;
use transient::Transients;

/// Rounds of empirical Bayes; the estimate settles in two or three.
const ROUNDS: usize = 4;
/// Half width, in bins, of the average that makes the prior.
const SMOOTHING: usize = 4;
/// Bins are used up to this share of half the sampling rate: above, anti-alias filters take all.
const BAND: f64 = 0.95;

/// One bin.
struct Bin {
    line: LineReceptances,
    data: LineData,
}

/// The balance of a run over its whole spectrum.
pub(crate) struct Whole<'a> {
    setting: &'a Setting<'a>,
    loads: &'a [Load],
    bins: Vec<Bin>,
    transients: Transients,
    base: f64,
    samples: usize,
}

/// What one round knows: prior powers of the forces (one vector a load) and the amplitudes of the free decays.
struct Round {
    priors: Vec<Vec<f64>>,
    amplitudes: Vec<f64>,
    covariance: Mat<f64>,
    forces: Vec<Vec<Complex64>>,
}

/// Solves a run without assuming a period.
pub(crate) fn solve(
    setting: &Setting<'_>,
    run: &RunData<'_>,
    lines: &RunLines,
    loads: &[Load],
) -> RunBalance {
    let whole = Whole::new(setting, run, lines, loads);
    let mut priors = whole.tapered_priors(run);
    let mut round = whole.round(priors);
    for _ in 1..ROUNDS {
        priors = whole.updated_priors(&round);
        round = whole.round(priors);
    }
    whole.outcome(&round)
}

impl<'a> Whole<'a> {
    fn new(setting: &'a Setting<'a>, run: &RunData<'_>, lines: &RunLines, loads: &'a [Load]) -> Self {
        let samples = run.force.len();
        let base = TAU * run.sampling_rate / samples as f64;
        let order = (BAND * 0.5 * samples as f64) as usize;
        let scale = 2.0 / samples as f64;
        let force = spectrum(run.force);
        let accelerations: Vec<_> = run.accelerations.iter().map(|a| spectrum(a)).collect();
        let variances: Vec<f64> = lines.noise_std.iter().map(|s| 2.0 * scale * s * s).collect();
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
                Bin { line, data }
            })
            .collect();
        let transients = Transients::new(&setting.structure.model, run.sampling_rate, samples, order);
        Self { setting, loads, bins, transients, base, samples }
    }

    /// Powers of the contact forces of the tapered record: a taper forgets the states at the ends.
    fn tapered_priors(&self, run: &RunData<'_>) -> Vec<Vec<f64>> {
        let taper = |x: &[f64]| -> Vec<Complex64> {
            let n = x.len() as f64;
            let mean = x.iter().sum::<f64>() / n;
            // Hann's window with the mean square one.
            let window = |j: usize| (8.0_f64 / 3.0).sqrt() * 0.5 * (1.0 - (TAU * j as f64 / n).cos());
            let tapered: Vec<f64> = x.iter().enumerate().map(|(j, v)| (v - mean) * window(j)).collect();
            spectrum(&tapered).iter().map(|z| z * (2.0 / n)).collect()
        };
        let force = taper(run.force);
        let accelerations: Vec<_> = run.accelerations.iter().map(|a| taper(a)).collect();
        let free = vec![f64::INFINITY; self.loads.len()];
        let found: Vec<Vec<(f64, f64)>> = self
            .bins
            .par_iter()
            .enumerate()
            .map(|(k, bin)| {
                let data = LineData {
                    force: force[k + 1],
                    accelerations: accelerations.iter().map(|a| a[k + 1]).collect(),
                    ..bin.data.clone()
                };
                let balance = LineBalance::solve(&bin.line, &data, self.loads, &free);
                powers(&balance, &balance.forces)
            })
            .collect();
        self.smoothed(&found, |power, variance| (power - variance).max(0.0))
    }

    /// Powers of the estimate: its square and its variance.
    fn updated_priors(&self, round: &Round) -> Vec<Vec<f64>> {
        let found: Vec<Vec<(f64, f64)>> = self
            .bins
            .par_iter()
            .enumerate()
            .map(|(k, bin)| {
                let prior: Vec<f64> = round.priors.iter().map(|p| p[k]).collect();
                let posterior = LineBalance::solve(&bin.line, &bin.data, self.loads, &prior).covariance();
                let free = vec![f64::INFINITY; self.loads.len()];
                let plain = LineBalance::solve(&bin.line, &bin.data, self.loads, &free);
                let n = self.loads.len();
                powers(&plain, &round.forces[k])
                    .into_iter()
                    .enumerate()
                    .map(|(u, (power, variance))| (power + posterior[u * n + u].re, variance))
                    .collect()
            })
            .collect();
        self.smoothed(&found, |power, _| power)
    }

    /// Averages over neighbouring bins, weighted by what the sensors know of each.
    fn smoothed(&self, found: &[Vec<(f64, f64)>], value: impl Fn(f64, f64) -> f64) -> Vec<Vec<f64>> {
        (0..self.loads.len())
            .map(|u| {
                (0..found.len())
                    .map(|k| {
                        let near = &found[k.saturating_sub(SMOOTHING)..(k + SMOOTHING + 1).min(found.len())];
                        let weight = |v: f64| if v > 0.0 { v.recip() } else { 0.0 };
                        let total: f64 = near.iter().map(|n| weight(n[u].1)).sum();
                        let sum: f64 = near.iter().map(|n| weight(n[u].1) * value(n[u].0, n[u].1)).sum();
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
        Round { priors, amplitudes, covariance, forces }
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
        let parts = balances.par_iter().enumerate().fold(zero, |mut sums, (k, balance)| {
            self.accumulate(k, balance, &mut sums);
            sums
        });
        parts.reduce(zero, add)
    }

    fn balance(&self, k: usize, bin: &Bin, priors: &[Vec<f64>]) -> LineBalance {
        let prior: Vec<f64> = priors.iter().map(|p| p[k]).collect();
        LineBalance::solve(&bin.line, &bin.data, self.loads, &prior)
    }

    /// Accelerations of a bin without exciter and free decays.
    fn unexplained(&self, k: usize, amplitudes: &[f64]) -> Vec<Complex64> {
        let bin = &self.bins[k];
        (0..bin.data.accelerations.len())
            .map(|s| {
                let decays: Complex64 =
                    amplitudes.iter().enumerate().map(|(m, c)| self.decay(k, m, s) * *c).sum();
                bin.data.accelerations[s] - bin.line.acceleration(s, Load::Exciter) * bin.data.force - decays
            })
            .collect()
    }

    /// Acceleration of sensor `s` in bin `k` per unit of the free decay `m`.
    fn decay(&self, k: usize, m: usize, s: usize) -> Complex64 {
        let shape = self.setting.dynamics.sensor_shape(self.transients.mode(m), s);
        self.transients.acceleration(m, k) * shape
    }

    /// Adds one bin to the normal equations (upper triangle) of the free decays.
    fn accumulate(&self, k: usize, balance: &LineBalance, (matrix, right): &mut (Vec<f64>, Vec<f64>)) {
        let unknowns = right.len();
        let none = vec![0.0; unknowns];
        let target = balance.remainder(&self.unexplained(k, &none));
        let sensors = self.bins[k].data.accelerations.len();
        let columns: Vec<Vec<Complex64>> = (0..unknowns)
            .map(|m| balance.remainder(&(0..sensors).map(|s| self.decay(k, m, s)).collect::<Vec<_>>()))
            .collect();
        // Twice: a bin's real and imaginary parts have half the variance each.
        let product = |a: &[Complex64], b: &[Complex64]| -> f64 {
            2.0 * a.iter().zip(b).map(|(x, y)| x.re * y.re + x.im * y.im).sum::<f64>()
        };
        for (i, column) in columns.iter().enumerate() {
            right[i] += product(column, &target);
            for (j, other) in columns.iter().enumerate().skip(i) {
                matrix[i * unknowns + j] += product(column, other);
            }
        }
    }
}

/// Square and variance of each force.
fn powers(balance: &LineBalance, forces: &[Complex64]) -> Vec<(f64, f64)> {
    let n = forces.len();
    let covariance = balance.covariance();
    (0..n).map(|u| (forces[u].norm_sqr(), covariance[u * n + u].re)).collect()
}
