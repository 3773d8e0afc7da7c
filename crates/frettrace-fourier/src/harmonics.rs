//! A periodic signal as its complex half spectrum.

use crate::Sampler;
use num_complex::Complex64;

/// Complex half spectrum of a real periodic signal, `x(t) = Re Σ_{h=0..H} x̂_h e^{ihΩt}`, with the variance of each line.
#[derive(Clone, Debug, PartialEq)]
pub struct Harmonics {
    /// Base angular frequency `Ω` (rad/s).
    pub base: f64,
    /// Coefficients `x̂_0 … x̂_H` (`H + 1`), in the unit of the signal; `x̂_0` is real.
    pub coefficients: Vec<Complex64>,
    /// Variance `E|ε_h|²` of each coefficient (`H + 1`), in the unit of the signal squared; half of it lies in the
    /// real and half in the imaginary part.
    pub variance: Vec<f64>,
}

impl Harmonics {
    /// Harmonics without uncertainty.
    #[must_use]
    pub fn exact(base: f64, coefficients: Vec<Complex64>) -> Self {
        let variance = vec![0.0; coefficients.len()];
        Self { base, coefficients, variance }
    }

    /// Highest line `H`.
    #[must_use]
    pub fn order(&self) -> usize {
        self.coefficients.len().saturating_sub(1)
    }

    /// Angular frequency `hΩ` of line `h` (rad/s).
    #[must_use]
    pub fn omega(&self, line: usize) -> f64 {
        self.base * line as f64
    }

    /// Value at the time `t` (s).
    #[must_use]
    pub fn at(&self, t: f64) -> f64 {
        let turn = Complex64::cis(self.base * t);
        self.coefficients.iter().rev().fold(Complex64::ZERO, |sum, x| sum * turn + x).re
    }

    /// Values at `samples` equidistant times `j/sampling_rate`, `j = 0, 1, …`.
    #[must_use]
    pub fn sample(&self, sampling_rate: f64, samples: usize) -> Vec<f64> {
        Sampler::new(self.base, self.order(), (sampling_rate, samples)).sample(&self.coefficients)
    }

    /// Time derivative: line `h` times `ihΩ`, its variance times `(hΩ)²`.
    #[must_use]
    pub fn derivative(&self) -> Self {
        let coefficients = self
            .coefficients
            .iter()
            .enumerate()
            .map(|(h, x)| x * Complex64::new(0.0, self.omega(h)))
            .collect();
        let variance = self.variance.iter().enumerate().map(|(h, v)| v * self.omega(h).powi(2)).collect();
        Self { base: self.base, coefficients, variance }
    }

    /// Root mean square of the lines `h ≥ 1`: `√(Σ|x̂_h|²/2)`.
    #[must_use]
    pub fn rms(&self) -> f64 {
        (0.5 * self.coefficients.iter().skip(1).map(Complex64::norm_sqr).sum::<f64>()).sqrt()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn given() -> Harmonics {
        let coefficients =
            (0..6).map(|h| Complex64::new(1.0 / (1 + h) as f64, 0.2 * h as f64)).collect::<Vec<_>>();
        Harmonics::exact(7.3, coefficients)
    }

    /// Sampling and pointwise evaluation are the same sum; 1e-13 is a hundred times the rounding of 6 terms.
    #[test]
    fn sampling_agrees_with_evaluation() {
        let x = given();
        for (j, value) in x.sample(91.0, 333).iter().enumerate() {
            assert!((value - x.at(j as f64 / 91.0)).abs() < 1e-13, "sample {j}");
        }
        let rate = 7.3 * 64.0 / std::f64::consts::TAU;
        for (j, value) in x.sample(rate, 64).iter().enumerate() {
            assert!((value - x.at(j as f64 / rate)).abs() < 1e-13, "sample {j} of one period");
        }
    }

    /// The derivative against a central difference of step 1e-5: its error is (hΩ)³·1e-10/6 < 1e-5.
    #[test]
    fn derivative_agrees_with_difference() {
        let x = given();
        let slope = x.derivative();
        for t in [0.0, 0.1, 0.77] {
            let difference = (x.at(t + 1e-5) - x.at(t - 1e-5)) / 2e-5;
            assert!((slope.at(t) - difference).abs() < 1e-5);
        }
    }

    /// cos has the rms 1/√2.
    #[test]
    fn rms_of_a_cosine() {
        let x = Harmonics::exact(1.0, vec![Complex64::new(5.0, 0.0), Complex64::ONE]);
        assert!((x.rms() - std::f64::consts::FRAC_1_SQRT_2).abs() < 1e-15);
    }
}
