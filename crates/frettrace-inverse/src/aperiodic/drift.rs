//! What is slower than the record: a straight line and a parabola in the force.
//!
//! Neither makes an acceleration that could be told from noise: what the balance says of them, `m` with the covariance `Λ`, is weighed
//! against what a random walk through the next bins would do, `R`. The part `S = Λ(Λ + R)⁻¹` of it is taken out again, and `Λ − SΛ`
//! is how well the drift is then known.

use super::power::{FROM_FEW, smoothed};
use faer::linalg::solvers::Solve;
use faer::{Mat, Side};
use frettrace_fourier::{spectrum, tapered_spectrum};
use num_complex::Complex64;

/// Polynomials of the drift: `p_1 = t`, `p_2 = t² − ⟨t²⟩`, `t ∈ (−1, 1)`.
pub(super) const DEGREE: usize = 2;
/// Bins that a drift holds: its level is drawn from those above.
const OWN: usize = 2;

/// One polynomial of the drift, orthogonal to the others under the weight `w = cos(πt/2)`, so that strong lines do not leak into it
/// from the ends of the record.
pub(super) struct Polynomial {
    /// Its amplitudes in the bins from 1.
    pub(super) bins: Vec<Complex64>,
    /// Those of its derivative (1/s).
    pub(super) slope: Vec<Complex64>,
    /// Spectrum of `w p/Σ w p²`: the content of a series with amplitudes `f_k` is `Re Σ f_k s̄_k`.
    content: Vec<Complex64>,
    /// Variance of its content in a random walk over the power of that in the first bin.
    walk: f64,
}

impl Polynomial {
    /// The polynomials of a record.
    pub(super) fn all(rate: f64, samples: usize) -> [Self; DEGREE] {
        let at: Vec<f64> = (0..samples).map(|j| (2.0 * j as f64 + 1.0) / samples as f64 - 1.0).collect();
        let weight: Vec<f64> = at.iter().map(|t| (std::f64::consts::FRAC_PI_2 * t).cos()).collect();
        let mean = at.iter().zip(&weight).map(|(t, w)| w * t * t).sum::<f64>() / weight.iter().sum::<f64>();
        let pace = 2.0 * rate / samples as f64;
        let value = |degree: usize, t: f64| if degree == 0 { t } else { t * t - mean };
        let slope = |degree: usize, t: f64| pace * if degree == 0 { 1.0 } else { 2.0 * t };
        std::array::from_fn(|degree| {
            let values: Vec<f64> = at.iter().map(|t| value(degree, *t)).collect();
            let slopes: Vec<f64> = at.iter().map(|t| slope(degree, *t)).collect();
            let norm: f64 = values.iter().zip(&weight).map(|(p, w)| w * p * p).sum();
            let told: Vec<f64> = values.iter().zip(&weight).map(|(p, w)| w * p / norm).collect();
            // A walk by steps of variance s² is s² Σ_m (Σ_{j≥m} told_j)² here, and n s²/(πk)² in bin k.
            let mut tail = 0.0;
            let squares = told.iter().rev().map(|x| {
                tail += x;
                tail * tail
            });
            let walk = std::f64::consts::PI.powi(2) / samples as f64 * squares.sum::<f64>();
            let order = (samples - 1) / 2;
            let bins = |series: &[f64], scale: f64| -> Vec<Complex64> {
                spectrum(series)[1..=order].iter().map(|z| z * scale).collect()
            };
            let amplitude = 2.0 / samples as f64;
            Self {
                bins: bins(&values, amplitude),
                slope: bins(&slopes, amplitude),
                content: bins(&told, 1.0),
                walk,
            }
        })
    }

    /// Its content in a series of amplitudes.
    pub(super) fn of(&self, amplitudes: &[Complex64]) -> f64 {
        amplitudes.iter().zip(&self.content).map(|(f, s)| f.re * s.re + f.im * s.im).sum()
    }

    /// Variance of its content in amplitudes of independent bins, each of the variance given.
    pub(super) fn of_independent(&self, variances: impl Iterator<Item = f64>) -> f64 {
        variances.zip(&self.content).map(|(v, s)| 0.5 * v * s.norm_sqr()).sum()
    }

    /// Variance of its content in a force that walks as its bins say.
    fn level(&self, force: &Seen) -> f64 {
        let tapered = tapered_spectrum(&force.still);
        let powers: Vec<f64> = tapered[1..].iter().zip(&force.left).map(|(z, v)| z.norm_sqr() + v).collect();
        FROM_FEW * self.walk * smoothed(&powers, &force.free, (2, OWN)).first().copied().unwrap_or(0.0)
    }
}

/// What is seen of a force.
pub(super) struct Seen {
    /// Samples without drift (N).
    pub(super) still: Vec<f64>,
    /// Variance of each bin that is left (N²), and what it would be without prior.
    pub(super) left: Vec<f64>,
    pub(super) free: Vec<f64>,
}

/// What is done about one polynomial in the forces of a run.
pub(super) struct Weighed {
    /// The part `S` that is taken out, a row each load.
    pub(super) share: Mat<f64>,
    /// Root of the covariance that is left: a column each source.
    pub(super) root: Mat<f64>,
}

impl Weighed {
    /// Weighs the covariance `Λ` against the levels of the loads.
    pub(super) fn new(known: &Mat<f64>, levels: &[f64]) -> Self {
        let n = levels.len();
        let total = Mat::from_fn(n, n, |i, k| known[(i, k)] + if i == k { levels[i] } else { 0.0 });
        let zero = || Mat::zeros(n, n);
        let Ok(factor) = total.llt(Side::Lower) else { return Self { share: zero(), root: zero() } };
        // S = Λ(Λ + R)⁻¹ is the transpose of (Λ + R)⁻¹Λ, both being symmetric.
        let share = factor.solve(known).transpose().to_owned();
        let left = known - &share * known;
        let root = left.llt(Side::Lower).map_or_else(|_| zero(), |factor| factor.L().to_owned());
        Self { share, root }
    }
}

/// Levels of a polynomial in the forces of the loads.
pub(super) fn levels(polynomial: &Polynomial, forces: &[Seen]) -> Vec<f64> {
    forces.iter().map(|force| polynomial.level(force)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The content of a parabola with a straight line is found exactly; a fast sine of 64 periods leaves less than 1e-3.
    #[test]
    fn polynomials_are_told_apart() {
        let samples = 1001;
        let all = Polynomial::all(1.0, samples);
        let at = |j: usize| (2.0 * j as f64 + 1.0) / samples as f64 - 1.0;
        let series = |f: &dyn Fn(usize) -> f64| -> Vec<Complex64> {
            let values: Vec<f64> = (0..samples).map(f).collect();
            spectrum(&values)[1..=500].iter().map(|z| z * (2.0 / samples as f64)).collect()
        };
        let drift = series(&|j| 3.0 - at(j) + 2.0 * at(j).powi(2));
        assert!((all[0].of(&drift) + 1.0).abs() < 1e-11 && (all[1].of(&drift) - 2.0).abs() < 1e-11);
        let fast = series(&|j| (0.4 * j as f64).sin());
        assert!(all.iter().all(|p| p.of(&fast).abs() < 2e-3));
        // The slope of t is one over half the record.
        assert!(all[0].slope.iter().all(|z| z.norm() < 1e-12));
    }

    /// Two loads, nothing known of the first and all of the second: the one is taken out and left at its level, the other stays.
    #[test]
    fn drift_is_weighed() {
        let known = Mat::from_fn(2, 2, |i, k| {
            if i != k {
                0.0
            } else if i == 0 {
                1e6
            } else {
                1e-6
            }
        });
        let weighed = Weighed::new(&known, &[4.0, 4.0]);
        assert!((weighed.share[(0, 0)] - 1.0).abs() < 1e-5 && weighed.share[(1, 1)] < 1e-6);
        assert!((weighed.root[(0, 0)] - 2.0).abs() < 1e-5 && (weighed.root[(1, 1)] - 1e-3).abs() < 1e-8);
    }

    /// Random walks: the variance of a content is what the level of the bins says, within the scatter of 400 records (7 % for a
    /// variance, three of that).
    #[test]
    fn a_level_is_that_of_a_walk() {
        use rand::SeedableRng;
        use rand_distr::Distribution;
        let mut random = rand_pcg::Pcg64::seed_from_u64(8);
        let normal = rand_distr::Normal::new(0.0, 1.0).unwrap();
        let samples = 256;
        for polynomial in Polynomial::all(1.0, samples) {
            let variance: f64 = (0..400)
                .map(|_| {
                    let mut at = 0.0;
                    let walk: Vec<f64> = (0..samples)
                        .map(|_| {
                            at += normal.sample(&mut random);
                            at
                        })
                        .collect();
                    let bins: Vec<Complex64> =
                        spectrum(&walk)[1..=127].iter().map(|z| z * (2.0 / 256.0)).collect();
                    polynomial.of(&bins).powi(2) / 400.0
                })
                .sum();
            let first = samples as f64 / std::f64::consts::PI.powi(2);
            assert!((variance / (polynomial.walk * first) - 1.0).abs() < 0.2, "{variance}");
        }
    }
}
