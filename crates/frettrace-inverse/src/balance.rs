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
    /// The columns of `Q` one after the other, and those of `R`, of as many entries as there are forces.
    columns: Vec<Complex64>,
    upper: Vec<Complex64>,
    weights: Vec<f64>,
    loads: usize,
    sensors: usize,
}

impl LineBalance {
    /// Solves a line for `loads`, with the prior variances `E|f|²` (N²) of the forces (infinite: none).
    #[must_use]
    pub fn solve(line: &LineReceptances, data: &LineData, loads: &[Load], prior: &[f64]) -> Self {
        let mut balance = Self::default();
        balance.renew(line, data, loads, prior);
        balance
    }

    /// Solves another line in the memory of this one.
    pub(crate) fn renew(&mut self, line: &LineReceptances, data: &LineData, loads: &[Load], prior: &[f64]) {
        (self.loads, self.sensors, self.degenerate) = (loads.len(), data.accelerations.len(), false);
        self.weights.clear();
        self.weights.extend(data.variances.iter().map(|v| if *v > 0.0 { v.sqrt().recip() } else { 0.0 }));
        let rows = self.sensors + self.loads;
        self.residual.clear();
        let measured = self.weights.iter().zip(&data.accelerations).enumerate();
        self.residual
            .extend(measured.map(|(s, (w, a))| w * (a - line.acceleration(s, Load::Exciter) * data.force)));
        self.residual.resize(rows, Complex64::ZERO);
        self.upper.clear();
        self.upper.resize(self.loads * self.loads, Complex64::ZERO);
        self.columns.clear();
        for (u, load) in loads.iter().enumerate() {
            let column = self.weights.iter().enumerate().map(|(s, w)| w * line.acceleration(s, *load));
            self.columns.extend(column);
            self.columns.resize(rows * (u + 1), Complex64::ZERO);
            self.columns[rows * u + self.sensors + u] = Complex64::from(prior[u].sqrt().recip());
            self.orthogonalise(u);
        }
        self.back_substitute();
    }

    /// Column `u` of `Q`.
    fn column(&self, u: usize) -> &[Complex64] {
        let rows = self.sensors + self.loads;
        &self.columns[rows * u..rows * (u + 1)]
    }

    /// Gram-Schmidt of the last column, twice: enough for orthogonality to rounding.
    fn orthogonalise(&mut self, u: usize) {
        let rows = self.sensors + self.loads;
        let (before, column) = self.columns.split_at_mut(rows * u);
        let length = norm(column);
        let row = &mut self.upper[u * self.loads..(u + 1) * self.loads];
        for _ in 0..2 {
            for (q, r) in before.chunks_exact(rows).zip(row.iter_mut()) {
                let along = inner(q, column);
                *r += along;
                column.iter_mut().zip(q).for_each(|(c, q)| *c -= along * q);
            }
        }
        let left = norm(column);
        let independent = left > INDEPENDENT * length && left > 0.0;
        self.degenerate |= !independent;
        let scale = if independent { left.recip() } else { 0.0 };
        column.iter_mut().for_each(|c| *c *= scale);
        row[u] = Complex64::from(if independent { left } else { 0.0 });
    }

    fn back_substitute(&mut self) {
        let rows = self.sensors + self.loads;
        let mut right = std::mem::take(&mut self.forces);
        right.clear();
        for q in self.columns.chunks_exact(rows) {
            let along = inner(q, &self.residual);
            right.push(along);
            self.residual.iter_mut().zip(q).for_each(|(r, q)| *r -= along * q);
        }
        self.solve_upper(&mut right);
        self.forces = right;
        self.residual.truncate(self.sensors);
    }

    /// `R x = right`, in place; undetermined entries are zero.
    fn solve_upper(&self, right: &mut [Complex64]) {
        for u in (0..right.len()).rev() {
            let row = &self.upper[u * self.loads..(u + 1) * self.loads];
            right[u] = if row[u].re > 0.0 { right[u] / row[u].re } else { Complex64::ZERO };
            let value = right[u];
            for (entry, r) in right.iter_mut().zip(row).take(u) {
                *entry -= r * value;
            }
        }
    }

    /// Degrees of freedom of the residual (real): twice the sensors with weight less the determined forces.
    #[must_use]
    pub fn freedom(&self) -> usize {
        let determined = (0..self.loads).filter(|u| self.upper[u * (self.loads + 1)].re > 0.0).count();
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
        let along = |u: usize| -> Complex64 {
            let terms = self.column(u).iter().zip(change).zip(&self.weights);
            terms.map(|((q, d), w)| q.conj() * d * *w).sum()
        };
        let mut right: Vec<Complex64> = (0..self.loads).map(along).collect();
        self.solve_upper(&mut right);
        right
    }

    /// Coordinates `Qᴴ x` of a real whitened vector `x = W^{1/2} φ` at the sensors along the columns of the forces: the part of it
    /// that they take up.
    pub(crate) fn taken_up(&self, whitened: &[f64], into: &mut [Complex64]) {
        for (u, entry) in into.iter_mut().enumerate() {
            *entry = self.column(u).iter().zip(whitened).map(|(q, x)| q.conj() * x).sum();
        }
    }

    /// Weights `W^{1/2}` of the sensors.
    pub(crate) fn weights(&self) -> &[f64] {
        &self.weights
    }

    /// What forces within their prior leave of accelerations, prior rows included: `‖·‖²` is `aᴴ(W⁻¹ + H P Hᴴ)⁻¹a`.
    #[must_use]
    pub fn remainder(&self, accelerations: &[Complex64]) -> Vec<Complex64> {
        let mut left = vec![Complex64::ZERO; self.sensors + self.loads];
        left.iter_mut().zip(accelerations).zip(&self.weights).for_each(|((l, a), w)| *l = a * *w);
        for u in 0..self.loads {
            let along = inner(self.column(u), &left);
            left.iter_mut().zip(self.column(u)).for_each(|(l, q)| *l -= along * q);
        }
        left
    }

    /// Covariance of the forces from sensor noise and prior, row-major: `R⁻¹R⁻ᴴ`.
    #[must_use]
    pub fn covariance(&self) -> Vec<Complex64> {
        let n = self.loads;
        let mut inverse = vec![Complex64::ZERO; n * n];
        for (i, column) in inverse.chunks_exact_mut(n.max(1)).enumerate() {
            column[i] = Complex64::ONE;
            self.solve_upper(column);
        }
        let columns = || inverse.chunks_exact(n.max(1));
        let entry = |i: usize, k: usize| columns().map(|c| c[i] * c[k].conj()).sum::<Complex64>();
        (0..n * n).map(|e| entry(e / n, e % n)).collect()
    }
}

fn norm(x: &[Complex64]) -> f64 {
    x.iter().map(Complex64::norm_sqr).sum::<f64>().sqrt()
}

fn inner(q: &[Complex64], x: &[Complex64]) -> Complex64 {
    q.iter().zip(x).map(|(q, x)| q.conj() * x).sum()
}
