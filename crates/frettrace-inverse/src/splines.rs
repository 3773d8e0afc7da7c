//! Periodic smoothing splines: time histories with kinks, and amplitudes against level.
//!
//! A cut Fourier series ripples beside a kink. [`PeriodicSpline::from_lines`] fits a periodic cubic spline to *lines with
//! their variances* instead of cutting them: badly known lines weigh little, and the curvature penalty fills them in.
//! Knots are placed where the signal bends; the penalty is chosen by generalised cross-validation.

use faer::prelude::Solve;
use faer::{Col, Mat, Side};
use frettrace_fourier::{Grid, Harmonics};
use num_complex::Complex64;
use std::f64::consts::TAU;

/// A periodic cubic spline over the phase `[0, 2π)`.
#[derive(Clone, Debug, PartialEq)]
pub struct PeriodicSpline {
    knots: Vec<f64>,
    coefficients: Vec<f64>,
}

/// Strengths of the penalty that are tried, relative to the data's own weight.
const PENALTIES: [f64; 9] = [1e-12, 1e-10, 1e-8, 1e-7, 1e-6, 1e-5, 1e-4, 1e-3, 1e-2];
/// Fewest knots of a fit.
const FEWEST_KNOTS: usize = 12;

impl PeriodicSpline {
    /// Fits lines `1..=H`, each weighted by its variance. The mean is zero.
    ///
    /// `None` where there are no lines, or the normal equations cannot be solved.
    #[must_use]
    pub fn from_lines(lines: &Harmonics) -> Option<Self> {
        let order = lines.order();
        let known = lines.variance.iter().skip(1).any(|v| *v > 0.0);
        if order == 0 || !known {
            return None;
        }
        let samples = (8 * order).max(64).next_power_of_two();
        let knots = place_knots(lines, (2 * order).clamp(FEWEST_KNOTS, 96), samples)?;
        let system = LineSystem::new(&knots, lines, samples)?;
        let best = PENALTIES
            .iter()
            .filter_map(|penalty| system.solve(*penalty))
            .min_by(|a, b| a.score.total_cmp(&b.score))?;
        Some(Self { knots, coefficients: best.coefficients })
    }

    /// Value at a phase (rad).
    #[must_use]
    pub fn at(&self, phase: f64) -> f64 {
        let n = self.knots.len();
        let (interval, values) = basis(&self.knots, phase);
        values.iter().enumerate().map(|(i, b)| b * self.coefficients[(interval + i) % n]).sum()
    }

    /// Its lines `0..=order`, of base frequency `base` (rad/s).
    #[must_use]
    pub fn lines(&self, order: usize, base: f64) -> Option<Harmonics> {
        let samples = (8 * order).max(64).next_power_of_two();
        let grid = Grid::new(order, samples).ok()?;
        let values: Vec<f64> = (0..samples).map(|j| self.at(TAU * j as f64 / samples as f64)).collect();
        let mut coefficients = vec![Complex64::ZERO; order + 1];
        grid.project(&values, &mut coefficients, &mut grid.scratch());
        Some(Harmonics::exact(base, coefficients))
    }

    /// The knots (rad), rising within `[0, 2π)`.
    #[must_use]
    pub fn knots(&self) -> &[f64] {
        &self.knots
    }
}

/// Knots with equal shares of `|x''|^{2/5}` (the error of a cubic between knots), half of it spread evenly.
fn place_knots(lines: &Harmonics, count: usize, samples: usize) -> Option<Vec<f64>> {
    let grid = Grid::new(lines.order(), samples).ok()?;
    // Lines below three standard deviations would place knots on noise.
    let bend: Vec<Complex64> = lines
        .coefficients
        .iter()
        .zip(&lines.variance)
        .enumerate()
        .map(|(h, (x, v))| if x.norm_sqr() > 9.0 * v { x * -((h * h) as f64) } else { Complex64::ZERO })
        .collect();
    let mut curvature = vec![0.0; samples];
    grid.evaluate(&bend, &mut curvature, &mut grid.scratch());
    let density: Vec<f64> = curvature.iter().map(|c| c.abs().powf(0.4)).collect();
    let mean = density.iter().sum::<f64>() / samples as f64;
    let mut sum = 0.0;
    let cumulative: Vec<f64> = density
        .iter()
        .map(|d| {
            let here = sum;
            sum += if mean > 0.0 { 0.5 + 0.5 * d / mean } else { 1.0 };
            here
        })
        .collect();
    let knots = (0..count)
        .map(|i| {
            let wanted = sum * i as f64 / count as f64;
            let after = cumulative.partition_point(|c| *c <= wanted).max(1);
            let width = cumulative.get(after).copied().unwrap_or(sum) - cumulative[after - 1];
            TAU * (after as f64 - 1.0 + (wanted - cumulative[after - 1]) / width) / samples as f64
        })
        .collect();
    Some(knots)
}

/// Interval of a phase and the four cubic B-splines that live there (de Boor's recursion on wrapped knots).
fn basis(knots: &[f64], phase: f64) -> (usize, [f64; 4]) {
    let n = knots.len();
    let phase = phase.rem_euclid(TAU);
    // Phases before the first knot belong to the last interval, one turn later.
    let place = knots.partition_point(|k| *k <= phase);
    let (interval, phase) = if place == 0 { (n - 1, phase + TAU) } else { (place - 1, phase) };
    let knot = |i: isize| {
        let turns = (interval as isize + i).div_euclid(n as isize);
        knots[(interval as isize + i).rem_euclid(n as isize) as usize] + TAU * turns as f64
    };
    let mut values = [1.0, 0.0, 0.0, 0.0];
    for degree in 1..=3 {
        let mut saved = 0.0;
        for (r, value) in values.iter_mut().enumerate().take(degree) {
            let (right, left) = (knot(r as isize + 1), knot(r as isize + 1 - degree as isize));
            let part = *value / (right - left);
            *value = saved + (right - phase) * part;
            saved = (phase - left) * part;
        }
        values[degree] = saved;
    }
    (interval, values)
}

/// Least squares of lines in the coefficients of a spline.
struct LineSystem {
    normal: Mat<f64>,
    right: Col<f64>,
    penalty: Mat<f64>,
    power: f64,
    data: usize,
}

struct Solved {
    coefficients: Vec<f64>,
    score: f64,
}

impl LineSystem {
    fn new(knots: &[f64], lines: &Harmonics, samples: usize) -> Option<Self> {
        let (n, order) = (knots.len(), lines.order());
        let grid = Grid::new(order, samples).ok()?;
        let mut scratch = grid.scratch();
        let places: Vec<_> = (0..samples).map(|j| basis(knots, TAU * j as f64 / samples as f64)).collect();
        let columns: Vec<Vec<f64>> = (0..n)
            .map(|i| {
                let own = |(interval, values): &(usize, [f64; 4])| {
                    let offset = (i + n - interval % n) % n;
                    values.get(offset).copied().unwrap_or(0.0)
                };
                places.iter().map(own).collect()
            })
            .collect();
        let mut spectra = vec![vec![Complex64::ZERO; order + 1]; n];
        for (column, spectrum) in columns.iter().zip(&mut spectra) {
            grid.project(column, spectrum, &mut scratch);
        }
        let weight = |h: usize| if lines.variance[h] > 0.0 { 2.0 / lines.variance[h] } else { 0.0 };
        let inner = |a: &[Complex64], b: &[Complex64]| -> f64 {
            (1..=order).map(|h| weight(h) * (a[h].re * b[h].re + a[h].im * b[h].im)).sum()
        };
        let target = &lines.coefficients;
        let normal = Mat::from_fn(n, n, |i, k| inner(&spectra[i], &spectra[k]));
        let right = Col::from_fn(n, |i| inner(&spectra[i], target));
        let data = 2 * (1..=order).filter(|h| weight(*h) > 0.0).count();
        let penalty = roughness(&columns, &spectra);
        Some(Self { normal, right, penalty, power: inner(target, target), data })
    }

    /// Coefficients and generalised cross-validation score `RSS/(N − tr)²` for a penalty.
    fn solve(&self, strength: f64) -> Option<Solved> {
        let n = self.right.nrows();
        let trace = |m: &Mat<f64>| (0..n).map(|i| m[(i, i)]).sum::<f64>();
        let scale = strength * trace(&self.normal) / trace(&self.penalty);
        let total = Mat::from_fn(n, n, |i, k| self.normal[(i, k)] + scale * self.penalty[(i, k)]);
        let factor = total.llt(Side::Lower).ok()?;
        let coefficients = factor.solve(&self.right);
        let hat = factor.solve(&self.normal);
        let used = trace(&hat);
        let fitted: f64 = (0..n).map(|i| coefficients[i] * self.right[i]).sum();
        let quadratic = &self.normal * &coefficients;
        let squared: f64 = (0..n).map(|i| coefficients[i] * quadratic[i]).sum();
        let residual = (self.power - 2.0 * fitted + squared).max(0.0);
        let left = self.data as f64 - used;
        let score = if left > 0.0 { residual / (left * left) } else { f64::INFINITY };
        Some(Solved { coefficients: (0..n).map(|i| coefficients[i]).collect(), score })
    }
}

/// `∫ s''²` by second differences on the fine grid, and `(mean s)²` so that the mean, which no line sees, is zero.
fn roughness(columns: &[Vec<f64>], spectra: &[Vec<Complex64>]) -> Mat<f64> {
    let bends: Vec<Vec<f64>> = columns
        .iter()
        .map(|c| {
            let m = c.len();
            (0..m).map(|j| c[(j + 1) % m] - 2.0 * c[j] + c[(j + m - 1) % m]).collect()
        })
        .collect();
    let size = bends.iter().map(|b| b.iter().map(|v| v * v).sum::<f64>()).fold(0.0, f64::max);
    Mat::from_fn(columns.len(), columns.len(), |i, k| {
        let bend: f64 = bends[i].iter().zip(&bends[k]).map(|(a, b)| a * b).sum();
        bend + size * spectra[i][0].re * spectra[k][0].re
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The four splines of an interval add up to one, wherever the phase lies on uneven knots.
    #[test]
    fn basis_is_a_partition_of_one() {
        let knots = [0.3, 0.5, 1.4, 2.0, 3.3, 4.0, 5.9];
        for j in 0..50 {
            let (_, values) = basis(&knots, 0.13 * f64::from(j));
            assert!((values.iter().sum::<f64>() - 1.0).abs() < 1e-13);
            assert!(values.iter().all(|v| *v > -1e-13));
        }
    }

    /// A triangle wave (kinks, lines as 1/h²) cut at line 15, with lines above 9 known badly: the spline is closer to the
    /// wave than the cut series of the same noisy lines.
    #[test]
    fn spline_beats_the_cut_series_beside_kinks() {
        use rand::SeedableRng;
        use rand_distr::Distribution;
        let mut random = rand_pcg::Pcg64::seed_from_u64(4);
        let normal = rand_distr::Normal::new(0.0, 1.0).unwrap();
        let wave = |phase: f64| 1.0 - 2.0 * (phase.rem_euclid(TAU) / std::f64::consts::PI - 1.0).abs();
        let mut lines = Harmonics::exact(1.0, vec![Complex64::ZERO; 16]);
        for h in 1..16_usize {
            let std = if h > 9 { 0.02 } else { 1e-4 };
            let size =
                if h.is_multiple_of(2) { 0.0 } else { -8.0 / (std::f64::consts::PI * h as f64).powi(2) };
            lines.coefficients[h] =
                Complex64::new(size + std * normal.sample(&mut random), std * normal.sample(&mut random));
            lines.variance[h] = 2.0 * std * std;
        }
        let spline = PeriodicSpline::from_lines(&lines).unwrap();
        let error = |value: &dyn Fn(f64) -> f64| -> f64 {
            (0..1000).map(|j| TAU * f64::from(j) / 1000.0).map(|p| (value(p) - wave(p)).powi(2)).sum::<f64>()
        };
        let (with, without) = (error(&|p| spline.at(p)), error(&|p| lines.at(p)));
        assert!(with < 0.5 * without, "{with} {without}");
    }
}
