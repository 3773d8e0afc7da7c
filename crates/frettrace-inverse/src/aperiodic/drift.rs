//! What is slower than the record.

use super::Whole;
use frettrace_fourier::{Harmonics, spectrum};
use num_complex::Complex64;

/// Degree of the drift that is taken out. Two is what a force or slip can do over a record with an acceleration that does
/// not change; what is faster is seen.
pub(super) const DEGREE: usize = 2;
/// Bins beside the drift whose mean power is taken for that of the drift: as many as a single one hardly sways, few enough to
/// be slow.
pub(super) const LEVEL: usize = 4;

impl Whole<'_> {
    /// Bins (from 0) of a series without its polynomial of a degree.
    pub(super) fn still(&self, coefficients: Vec<Complex64>, degree: usize) -> Vec<Complex64> {
        let rate = self.base * self.samples as f64 / std::f64::consts::TAU;
        let mut harmonics = Harmonics::exact(self.base, coefficients);
        let mut series = harmonics.sample(rate, self.samples);
        remove_polynomial(&mut series, degree);
        let scale = 2.0 / self.samples as f64;
        let bins = spectrum(&series);
        harmonics.coefficients.iter_mut().zip(&bins).skip(1).for_each(|(c, bin)| *c = bin * scale);
        harmonics.coefficients
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
