//! From the solved bins to the contact: force, slip, normal force and fit, without the drift nobody can see.

use super::{Round, Whole};
use crate::balance::LineBalance;
use crate::contact::{BalanceResidual, ContactHarmonics, RunBalance, SharedErrors};
use crate::dynamics::Load;
use frettrace_fourier::{Harmonics, spectrum};
use num_complex::Complex64;
use rayon::prelude::*;

/// Degree of the drift that is taken out. Two is what a force or slip can do over a record with an acceleration that does
/// not change; what is faster is seen.
const DRIFT: usize = 2;

/// Outputs of one bin.
struct Row {
    values: Vec<Complex64>,
    variances: Vec<f64>,
}

/// Outputs before the sensors: friction, slip, slip velocity, normal, second support.
const FIRST_SENSOR: usize = 5;

impl Whole<'_> {
    pub(super) fn outcome(&self, round: &Round) -> RunBalance {
        let sensors = self.setting.dynamics.sensors();
        let solved: Vec<(Row, Vec<Complex64>, bool)> = self
            .bins
            .par_iter()
            .enumerate()
            .map(|(k, bin)| {
                let balance = self.balance(k, bin, &round.priors);
                let left = balance.remainder(&self.unexplained(k, &round.amplitudes));
                let led_by_prior = balance.covariance()[0].re > 0.5 * round.priors[0][k];
                (self.row(k, &balance, round), left, led_by_prior)
            })
            .collect();
        let mut residual = BalanceResidual::default();
        let mut regularised = Vec::new();
        let mut rows = Vec::with_capacity(solved.len());
        for (k, (row, left, led_by_prior)) in solved.into_iter().enumerate() {
            residual.chi_square.push(2.0 * left.iter().map(Complex64::norm_sqr).sum::<f64>());
            residual.freedom.push(2 * sensors);
            residual.whitened.push(left[..sensors].to_vec());
            regularised.extend(led_by_prior.then_some(k + 1));
            rows.push(row);
        }
        RunBalance { contact: self.contact(&rows), residual, regularised }
    }

    fn row(&self, k: usize, balance: &LineBalance, round: &Round) -> Row {
        let exciter = self.bins[k].data.force;
        let values = self.outputs(k, exciter, &round.forces[k], &round.amplitudes);
        let loads = self.loads.len();
        let covariance = balance.covariance();
        let none = vec![0.0; round.amplitudes.len()];
        let mut variances = vec![0.0; values.len()];
        for u in 0..loads {
            // Correlations between two unknown forces matter for their difference only, which is no output.
            let mut unit = vec![Complex64::ZERO; loads];
            unit[u] = Complex64::from(covariance[u * loads + u].re.sqrt());
            let change = self.outputs(k, Complex64::ZERO, &unit, &none);
            variances.iter_mut().zip(change).for_each(|(v, c)| *v += c.norm_sqr());
        }
        self.add_decays(k, balance, round, &mut variances);
        Row { values, variances }
    }

    /// Adds what the uncertain free decays make of the outputs; correlations between decays included.
    fn add_decays(&self, k: usize, balance: &LineBalance, round: &Round, variances: &mut [f64]) {
        let count = round.amplitudes.len();
        let sensors = self.setting.dynamics.sensors();
        let gains: Vec<Vec<Complex64>> = (0..count)
            .map(|m| {
                let change: Vec<Complex64> = (0..sensors).map(|s| -self.decay(k, m, s)).collect();
                let mut amplitudes = vec![0.0; count];
                amplitudes[m] = 1.0;
                self.outputs(k, Complex64::ZERO, &balance.response(&change), &amplitudes)
            })
            .collect();
        for (o, variance) in variances.iter_mut().enumerate() {
            for (m, gain) in gains.iter().enumerate() {
                let along: Complex64 =
                    gains.iter().enumerate().map(|(q, g)| g[o] * round.covariance[(m, q)]).sum();
                *variance += (gain[o].conj() * along).re;
            }
        }
    }

    /// All outputs of a bin for given forces and free decays.
    fn outputs(&self, k: usize, exciter: Complex64, forces: &[Complex64], decays: &[f64]) -> Vec<Complex64> {
        let line = &self.bins[k].line;
        let dynamics = self.setting.dynamics;
        let sum = |response: &dyn Fn(Load) -> Complex64| {
            response(Load::Exciter) * exciter
                + self.loads.iter().zip(forces).map(|(l, f)| response(*l) * f).sum::<Complex64>()
        };
        let own = |wanted: Load| {
            self.loads.iter().zip(forces).find(|(l, _)| **l == wanted).map_or(Complex64::ZERO, |(_, f)| *f)
        };
        let (mut slip, mut end) = (sum(&|l| line.slip(l)), sum(&|l| line.end(l)));
        // A decay ends elsewhere than it began: its velocity is a spectrum of its own, not iω times its displacement.
        let mut velocity = slip * Complex64::new(0.0, line.omega());
        for (m, amplitude) in decays.iter().enumerate().filter(|(_, a)| **a != 0.0) {
            let motion = self.transients.displacement(m, k) * *amplitude;
            let [slip_shape, end_shape] = dynamics.contact_shape(self.transients.mode(m));
            slip += motion * slip_shape;
            velocity += self.transients.velocity(m, k) * (amplitude * slip_shape);
            end += motion * end_shape;
        }
        let normal = own(Load::NormalDeviation) - end * self.setting.normal_stiffness;
        let mut outputs = vec![own(Load::Friction), slip, velocity, normal, own(Load::SecondSupport)];
        outputs.extend((0..dynamics.sensors()).map(|s| {
            let free: Complex64 = decays.iter().enumerate().map(|(m, c)| self.decay(k, m, s) * *c).sum();
            sum(&|l| line.acceleration(s, l)) + free
        }));
        outputs
    }

    /// Harmonics of all outputs; contact force, slip and normal force without their drift.
    fn contact(&self, rows: &[Row]) -> ContactHarmonics {
        let harmonics = |o: usize| {
            let zero = std::iter::once(Complex64::ZERO);
            let coefficients = zero.chain(rows.iter().map(|r| r.values[o])).collect();
            let variance = std::iter::once(0.0).chain(rows.iter().map(|r| r.variances[o])).collect();
            Harmonics { base: self.base, coefficients, variance }
        };
        let still = |o: usize, degree: usize| self.without_drift(harmonics(o), degree);
        ContactHarmonics {
            friction: still(0, DRIFT),
            slip: still(1, DRIFT),
            slip_velocity: still(2, DRIFT - 1),
            normal: still(3, DRIFT),
            second_support: self.loads.contains(&Load::SecondSupport).then(|| still(4, DRIFT)),
            acceleration_fit: (0..self.setting.dynamics.sensors())
                .map(|s| harmonics(FIRST_SENSOR + s))
                .collect(),
            shared: SharedErrors::default(),
        }
    }

    /// Takes the polynomial of a degree out of a series, and the bins it covers out of its variance.
    fn without_drift(&self, mut harmonics: Harmonics, degree: usize) -> Harmonics {
        let rate = self.base * self.samples as f64 / std::f64::consts::TAU;
        let mut series = harmonics.sample(rate, self.samples);
        remove_polynomial(&mut series, degree);
        let bins = spectrum(&series);
        let scale = 2.0 / self.samples as f64;
        for (coefficient, bin) in harmonics.coefficients.iter_mut().zip(&bins).skip(1) {
            *coefficient = bin * scale;
        }
        harmonics.variance.iter_mut().take(1 + degree / 2).for_each(|v| *v = 0.0);
        harmonics
    }
}

/// Takes a polynomial out of equidistant samples, fitted with the weight `cos(πt/2)`, `t ∈ (−1, 1)`, so that strong lines
/// do not leak into it from the ends; orthogonal polynomials by Stieltjes' recursion.
fn remove_polynomial(series: &mut [f64], degree: usize) {
    let n = series.len();
    let at = |j: usize| (2.0 * j as f64 + 1.0) / n as f64 - 1.0;
    let weight: Vec<f64> = (0..n).map(|j| (std::f64::consts::FRAC_PI_2 * at(j)).cos()).collect();
    let inner =
        |a: &[f64], b: &[f64]| -> f64 { a.iter().zip(b).zip(&weight).map(|((x, y), w)| w * x * y).sum() };
    let (mut before, mut now) = (vec![0.0; n], vec![1.0; n]);
    let mut before_norm = 1.0;
    for _ in 0..=degree {
        let norm = inner(&now, &now);
        let along = inner(series, &now) / norm;
        series.iter_mut().zip(&now).for_each(|(x, p)| *x -= along * p);
        // The weight is even, so p_{i+1} = t p_i − (‖p_i‖²/‖p_{i−1}‖²) p_{i−1}.
        let next = (0..n).map(|j| at(j) * now[j] - norm / before_norm * before[j]).collect();
        before = now;
        before_norm = norm;
        now = next;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A parabola vanishes altogether; a fast sine stays: 64 periods leak less than 1e-3 into a weighted parabola.
    #[test]
    fn polynomials_are_taken_out() {
        let parabola = |j: usize| {
            let t = j as f64 / 500.0 - 1.0;
            3.0 - t + 2.0 * t * t
        };
        let mut series: Vec<f64> = (0..1001).map(parabola).collect();
        remove_polynomial(&mut series, 2);
        assert!(series.iter().all(|v| v.abs() < 1e-11));
        let sine = |j: usize| (0.4 * j as f64).sin();
        let mut series: Vec<f64> = (0..1001).map(|j| parabola(j) + sine(j)).collect();
        remove_polynomial(&mut series, 2);
        assert!(series.iter().enumerate().all(|(j, v)| (v - sine(j)).abs() < 1e-3));
    }
}
