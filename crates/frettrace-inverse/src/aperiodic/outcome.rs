//! From the solved bins to the contact: force, slip, normal force and fit, without the drift nobody can see.

use super::{Round, Whole, drift};
use crate::balance::LineBalance;
use crate::contact::{BalanceResidual, ContactHarmonics, RunBalance, SharedErrors};
use crate::dynamics::Load;
use faer::Mat;
use frettrace_fourier::{Harmonics, spectrum};
use num_complex::Complex64;
use rayon::prelude::*;

/// Outputs of one bin.
struct Row {
    values: Vec<Complex64>,
    /// Variances of the outputs; what the free decays make of those before the sensors is not in it.
    variances: Vec<f64>,
    /// Change of each output before the sensors per unit of each free decay.
    gains: Vec<Vec<Complex64>>,
}

/// Outputs before the sensors: friction, slip, slip velocity, normal, second support.
const FIRST_SENSOR: usize = 5;

impl Whole<'_> {
    pub(super) fn outcome(&self, round: &Round) -> RunBalance {
        let sensors = self.setting.dynamics.sensors();
        let line = spectrum(&self.known.contact[0]);
        let scale = 2.0 / self.samples as f64;
        let solved: Vec<(Row, Vec<Complex64>, bool)> = round
            .balances
            .par_iter()
            .enumerate()
            .map(|(k, balance)| {
                let left = balance.remainder(&self.unexplained(k, &round.amplitudes));
                // A bin is known where its variance is less than half of its power, that of the lines included.
                let power = round.priors[0][k] + (line[k + 1] * scale).norm_sqr();
                let led_by_prior = balance.covariance()[0].re > 0.5 * power;
                (self.row(k, balance, round), left, led_by_prior)
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
        RunBalance { contact: self.contact(&rows, round), residual, regularised }
    }

    /// Variances of the outputs that a force makes whose drift is as strong as what the record shows of the first bins, its own
    /// drift left out.
    fn adrift(&self, round: &Round) -> Vec<f64> {
        let level = |u: usize| {
            let zero = std::iter::once(Complex64::ZERO);
            let still = self.still(zero.chain(round.forces.iter().map(|f| f[u])).collect(), drift::DEGREE);
            let first = still.iter().skip(1).take(drift::LEVEL);
            first.map(Complex64::norm_sqr).sum::<f64>() / drift::LEVEL as f64
        };
        let forces: Vec<Complex64> =
            (0..self.loads.len()).map(|u| Complex64::from(level(u).sqrt())).collect();
        self.outputs(0, Complex64::ZERO, &forces).iter().map(Complex64::norm_sqr).collect()
    }

    fn row(&self, k: usize, balance: &LineBalance, round: &Round) -> Row {
        let mut values = self.outputs(k, self.bins[k].data.force, &round.forces[k]);
        for (m, amplitude) in round.amplitudes.iter().enumerate() {
            self.add_decay((k, m), *amplitude, &mut values);
        }
        let loads = self.loads.len();
        let covariance = balance.covariance();
        let mut variances = vec![0.0; values.len()];
        for u in 0..loads {
            // Correlations between two unknown forces matter for their difference only, which is no output.
            let mut unit = vec![Complex64::ZERO; loads];
            unit[u] = Complex64::from(covariance[u * loads + u].re.sqrt());
            let change = self.outputs(k, Complex64::ZERO, &unit);
            variances.iter_mut().zip(change).for_each(|(v, c)| *v += c.norm_sqr());
        }
        let mut gains = self.gains(k, balance, round);
        for (variance, gain) in variances.iter_mut().zip(&gains).skip(FIRST_SENSOR) {
            *variance += made(gain, &round.covariance);
        }
        gains.truncate(FIRST_SENSOR);
        Row { values, variances, gains }
    }

    /// Change of each output per unit of each free decay, the measurements being given.
    fn gains(&self, k: usize, balance: &LineBalance, round: &Round) -> Vec<Vec<Complex64>> {
        let count = round.amplitudes.len();
        let mut gains = vec![Vec::with_capacity(count); FIRST_SENSOR + self.setting.dynamics.sensors()];
        for mode in 0..count / 2 {
            let forces = balance.response(&self.shape(mode));
            for m in [2 * mode, 2 * mode + 1] {
                let taken: Vec<Complex64> =
                    forces.iter().map(|f| -f * self.transients.acceleration(m, k)).collect();
                let mut change = self.outputs(k, Complex64::ZERO, &taken);
                self.add_decay((k, m), 1.0, &mut change);
                gains.iter_mut().zip(change).for_each(|(gain, c)| gain.push(c));
            }
        }
        gains
    }

    /// All outputs of a bin for given forces; they are linear in them.
    fn outputs(&self, k: usize, exciter: Complex64, forces: &[Complex64]) -> Vec<Complex64> {
        let line = &self.bins[k].line;
        let dynamics = self.setting.dynamics;
        let sum = |response: &dyn Fn(Load) -> Complex64| {
            response(Load::Exciter) * exciter
                + self.loads.iter().zip(forces).map(|(l, f)| response(*l) * f).sum::<Complex64>()
        };
        let own = |wanted: Load| {
            self.loads.iter().zip(forces).find(|(l, _)| **l == wanted).map_or(Complex64::ZERO, |(_, f)| *f)
        };
        let (slip, end) = (sum(&|l| line.slip(l)), sum(&|l| line.end(l)));
        let velocity = slip * Complex64::new(0.0, line.omega());
        let normal = own(Load::NormalDeviation) - end * self.setting.normal_stiffness;
        let mut outputs = vec![own(Load::Friction), slip, velocity, normal, own(Load::SecondSupport)];
        outputs.extend((0..dynamics.sensors()).map(|s| sum(&|l| line.acceleration(s, l))));
        outputs
    }

    /// Adds the motion of the free decay `m` in bin `k` to the outputs. A decay ends elsewhere than it began: its velocity is a
    /// spectrum of its own, not iω times its displacement.
    fn add_decay(&self, (k, m): (usize, usize), amplitude: f64, outputs: &mut [Complex64]) {
        let dynamics = self.setting.dynamics;
        let mode = self.transients.mode(m);
        let [slip_shape, end_shape] = dynamics.contact_shape(mode);
        let motion = self.transients.displacement(m, k) * amplitude;
        outputs[1] += motion * slip_shape;
        outputs[2] += self.transients.velocity(m, k) * (amplitude * slip_shape);
        outputs[3] -= motion * (end_shape * self.setting.normal_stiffness);
        let acceleration = self.transients.acceleration(m, k) * amplitude;
        for (s, output) in outputs[FIRST_SENSOR..].iter_mut().enumerate() {
            *output += acceleration * dynamics.sensor_shape(mode, s);
        }
    }

    /// Harmonics of all outputs, what was known put back; contact force, slip and normal force without their drift.
    fn contact(&self, rows: &[Row], round: &Round) -> ContactHarmonics {
        let adrift = self.adrift(round);
        let harmonics = |o: usize| {
            let zero = std::iter::once(Complex64::ZERO);
            let coefficients = zero.chain(rows.iter().map(|r| r.values[o])).collect();
            let variance = std::iter::once(0.0).chain(rows.iter().map(|r| r.variances[o])).collect();
            Harmonics { base: self.base, coefficients, variance }
        };
        let still = |o: usize, degree: usize| {
            let mut found = harmonics(o);
            found.coefficients = self.still(found.coefficients, degree);
            self.add_decays(rows, (o, degree), &round.covariance, &mut found.variance);
            found.variance.iter_mut().skip(1).take(degree / 2).for_each(|v| *v = adrift[o]);
            self.with(found, &self.known.contact[o])
        };
        ContactHarmonics {
            friction: still(0, drift::DEGREE),
            slip: still(1, drift::DEGREE),
            slip_velocity: still(2, drift::DEGREE - 1),
            normal: still(3, drift::DEGREE),
            second_support: self.loads.contains(&Load::SecondSupport).then(|| still(4, drift::DEGREE)),
            acceleration_fit: (0..self.setting.dynamics.sensors())
                .map(|s| self.with(harmonics(FIRST_SENSOR + s), &self.known.accelerations[s]))
                .collect(),
            shared: SharedErrors::default(),
        }
    }

    /// Adds what the uncertain free decays make of an output, its drift left out: that is the largest part of it, for a decay is
    /// hard to tell from a force whose second derivative is one.
    fn add_decays(
        &self,
        rows: &[Row],
        (o, degree): (usize, usize),
        covariance: &Mat<f64>,
        variance: &mut [f64],
    ) {
        let series: Vec<Vec<Complex64>> = (0..covariance.nrows())
            .into_par_iter()
            .map(|m| {
                let zero = std::iter::once(Complex64::ZERO);
                self.still(zero.chain(rows.iter().map(|row| row.gains[o][m])).collect(), degree)
            })
            .collect();
        for (k, variance) in variance.iter_mut().enumerate().skip(1) {
            let gain: Vec<Complex64> = series.iter().map(|s| s[k]).collect();
            *variance += made(&gain, covariance);
        }
    }

    /// Adds samples, their mean left out.
    fn with(&self, mut harmonics: Harmonics, samples: &[f64]) -> Harmonics {
        let scale = 2.0 / self.samples as f64;
        let bins = spectrum(samples);
        harmonics.coefficients.iter_mut().zip(&bins).skip(1).for_each(|(c, bin)| *c += bin * scale);
        harmonics
    }
}

/// Variance that uncertain amplitudes make with given gains: `Σ g_mᴴ C_mq g_q`.
fn made(gain: &[Complex64], covariance: &Mat<f64>) -> f64 {
    let mut sum = 0.0;
    for (m, g) in gain.iter().enumerate() {
        let others = gain.iter().enumerate().skip(m + 1);
        let along: f64 = others.map(|(q, o)| covariance[(m, q)] * (g.re * o.re + g.im * o.im)).sum();
        sum += covariance[(m, m)] * g.norm_sqr() + 2.0 * along;
    }
    sum.max(0.0)
}
