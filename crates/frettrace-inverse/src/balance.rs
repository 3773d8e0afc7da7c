//! The balance of one line: the unknown contact forces by weighted least squares over the sensors.

use crate::dynamics::{LineReceptances, Load};
use num_complex::Complex64;

/// A column whose part outside the others is smaller than this share of itself is not determined.
const INDEPENDENT: f64 = 1e-7;

/// Measured values of one line.
#[derive(Clone, Debug)]
pub struct LineData {
    /// Line of the excitation force (N).
    pub force: Complex64,
    /// Its variance (N²).
    pub force_variance: f64,
    /// Lines of the accelerations (m/s²).
    pub accelerations: Vec<Complex64>,
    /// Their variances `E|ε|²` (m/s² squared).
    pub variances: Vec<f64>,
}

/// Solution of one line: `W^{1/2}(a − H_e F_e) = W^{1/2} H_u f + r` by an orthogonal factorisation `QR` of the columns.
#[derive(Clone, Debug, Default)]
pub struct LineBalance {
    /// Unknown forces (N), in the order asked for.
    pub forces: Vec<Complex64>,
    /// Whitened residual, one entry a sensor: what no contact force at the stated places can make.
    pub residual: Vec<Complex64>,
    /// Whether a force could not be told from the others or is not seen by any sensor.
    pub degenerate: bool,
    columns: Vec<Vec<Complex64>>,
    upper: Vec<Vec<Complex64>>,
    weights: Vec<f64>,
    sensors: usize,
}

impl LineBalance {
    /// Solves a line for `loads`, with the prior variances `E|f|²` (N²) of the forces (infinite: none).
    #[must_use]
    pub fn solve(line: &LineReceptances, data: &LineData, loads: &[Load], prior: &[f64]) -> Self {
        let sensors = data.accelerations.len();
        let weights: Vec<f64> =
            data.variances.iter().map(|v| if *v > 0.0 { v.sqrt().recip() } else { 0.0 }).collect();
        let measured = (0..sensors)
            .map(|s| weights[s] * (data.accelerations[s] - line.acceleration(s, Load::Exciter) * data.force));
        let residual = measured.chain(loads.iter().map(|_| Complex64::ZERO)).collect();
        let mut balance = Self { residual, weights, sensors, ..Self::default() };
        for (u, load) in loads.iter().enumerate() {
            let column = (0..sensors).map(|s| balance.weights[s] * line.acceleration(s, *load));
            let pinned =
                (0..loads.len()).map(|i| Complex64::from(if i == u { prior[u].sqrt().recip() } else { 0.0 }));
            let column = column.chain(pinned).collect();
            balance.append(column);
        }
        balance.back_substitute();
        balance
    }

    /// Gram-Schmidt, twice: enough for orthogonality to rounding.
    fn append(&mut self, mut column: Vec<Complex64>) {
        let length = norm(&column);
        let mut row = vec![Complex64::ZERO; self.columns.len()];
        for _ in 0..2 {
            for (q, r) in self.columns.iter().zip(&mut row) {
                let along = inner(q, &column);
                *r += along;
                column.iter_mut().zip(q).for_each(|(c, q)| *c -= along * q);
            }
        }
        let left = norm(&column);
        let independent = left > INDEPENDENT * length && left > 0.0;
        self.degenerate |= !independent;
        let scale = if independent { left.recip() } else { 0.0 };
        column.iter_mut().for_each(|c| *c *= scale);
        row.push(Complex64::from(if independent { left } else { 0.0 }));
        self.upper.push(row);
        self.columns.push(column);
    }

    fn back_substitute(&mut self) {
        let mut right = Vec::with_capacity(self.columns.len());
        for q in &self.columns {
            let along = inner(q, &self.residual);
            right.push(along);
            self.residual.iter_mut().zip(q).for_each(|(r, q)| *r -= along * q);
        }
        self.forces = self.solve_upper(right);
        self.residual.truncate(self.sensors);
    }

    /// `R x = right`; undetermined entries are zero.
    fn solve_upper(&self, mut right: Vec<Complex64>) -> Vec<Complex64> {
        for u in (0..right.len()).rev() {
            let pivot = self.upper[u][u];
            right[u] = if pivot.re > 0.0 { right[u] / pivot } else { Complex64::ZERO };
            let value = right[u];
            for (i, entry) in right.iter_mut().enumerate().take(u) {
                *entry -= self.upper[u][i] * value;
            }
        }
        right
    }

    /// Degrees of freedom of the residual (real): twice the sensors with weight less the determined forces.
    #[must_use]
    pub fn freedom(&self) -> usize {
        let determined = self.upper.iter().enumerate().filter(|(u, row)| row[*u].re > 0.0).count();
        let seen = self.weights.iter().filter(|w| **w > 0.0).count();
        2 * seen.saturating_sub(determined)
    }

    /// Chi-square of the residual: `2 Σ|r_s|²` (each whitened residual has `E|r|² = 1`).
    #[must_use]
    pub fn chi_square(&self) -> f64 {
        2.0 * self.residual.iter().map(Complex64::norm_sqr).sum::<f64>()
    }

    /// Change of the forces when the accelerations change by `change` (`S`): `R⁻¹Qᴴ W^{1/2} δ`.
    #[must_use]
    pub fn response(&self, change: &[Complex64]) -> Vec<Complex64> {
        let right = self
            .columns
            .iter()
            .map(|q| {
                q.iter()
                    .zip(change)
                    .zip(&self.weights)
                    .map(|((q, d), w)| q.conj() * d * *w)
                    .sum::<Complex64>()
            })
            .collect();
        self.solve_upper(right)
    }

    /// The part of a change of the accelerations that the forces cannot take up: `(I − QQᴴ) W^{1/2} δ`.
    pub fn leave(&self, change: &mut [Complex64]) {
        change.iter_mut().zip(&self.weights).for_each(|(d, w)| *d *= *w);
        for q in &self.columns {
            let along = inner(&q[..change.len()], change);
            change.iter_mut().zip(q).for_each(|(d, q)| *d -= along * q);
        }
    }

    /// What forces within their prior leave of accelerations, prior rows included: `‖·‖²` is `aᴴ(W⁻¹ + H P Hᴴ)⁻¹a`.
    #[must_use]
    pub fn remainder(&self, accelerations: &[Complex64]) -> Vec<Complex64> {
        let mut left = vec![Complex64::ZERO; self.columns.first().map_or(self.sensors, Vec::len)];
        left.iter_mut().zip(accelerations).zip(&self.weights).for_each(|((l, a), w)| *l = a * *w);
        for q in &self.columns {
            let along = inner(q, &left);
            left.iter_mut().zip(q).for_each(|(l, q)| *l -= along * q);
        }
        left
    }

    /// Covariance of the forces from sensor noise and prior, row-major: `R⁻¹R⁻ᴴ`.
    #[must_use]
    pub fn covariance(&self) -> Vec<Complex64> {
        let n = self.columns.len();
        let inverse: Vec<Vec<Complex64>> = (0..n)
            .map(|i| self.solve_upper((0..n).map(|k| Complex64::from(f64::from(u8::from(i == k)))).collect()))
            .collect();
        let entry = |i: usize, k: usize| inverse.iter().map(|c| c[i] * c[k].conj()).sum::<Complex64>();
        (0..n * n).map(|e| entry(e / n, e % n)).collect()
    }
}

fn norm(x: &[Complex64]) -> f64 {
    x.iter().map(Complex64::norm_sqr).sum::<f64>().sqrt()
}

fn inner(q: &[Complex64], x: &[Complex64]) -> Complex64 {
    q.iter().zip(x).map(|(q, x)| q.conj() * x).sum()
}
