//! Least-squares projection of whole records on the lines of a base frequency.

use crate::phasors::Phasors;
use crate::sums::dot;
use crate::{Harmonics, Sampler, noise};
use faer::linalg::triangular_inverse::invert_lower_triangular;
use faer::prelude::Solve;
use faer::{ColRef, Mat, Par, Side};
use num_complex::Complex64;
use std::sync::Arc;

/// Why a record cannot be projected.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ProjectionError {
    /// More unknowns than the record can carry.
    #[error("{samples} samples cannot determine {unknowns} unknowns")]
    TooShort {
        /// Samples of the record.
        samples: usize,
        /// Unknowns asked for.
        unknowns: usize,
    },
    /// Lines lie closer than the record can resolve.
    #[error("the record holds {periods:.2} periods of the base frequency: its lines cannot be told apart")]
    Unresolved {
        /// Periods of the base frequency in the record.
        periods: f64,
    },
    /// A channel has another length than the record.
    #[error("a channel has {given} samples, the record {samples}")]
    Length {
        /// Samples of the channel.
        given: usize,
        /// Samples of the record.
        samples: usize,
    },
}

/// Where lines are to be found in a record of equidistant samples.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lines {
    /// Base angular frequency (rad/s).
    pub base: f64,
    /// Highest line `H`.
    pub order: usize,
    /// Samples of the record.
    pub samples: usize,
    /// Sampling rate (Hz).
    pub sampling_rate: f64,
    /// Degree of the slow drift fitted beside the lines; 0 fits a constant only (line 0).
    pub drift: usize,
}

/// One channel projected on lines.
#[derive(Clone, Debug)]
pub struct Projected {
    /// The lines, with variances from the residual around each line.
    pub harmonics: Harmonics,
    /// Coefficients of the Legendre polynomials `P_1 … P_d` of the drift over the record.
    pub drift: Vec<f64>,
    /// What neither lines nor drift hold (`n`).
    pub residual: Vec<f64>,
    /// Standard deviation of the residual, corrected for the unknowns.
    pub residual_std: f64,
    /// Periodogram `|R_k|²/n` of the residual, bins `0..=n/2`: that of white noise has its variance for a mean.
    pub periodogram: Vec<f64>,
}

/// Projection by least squares: the record need not hold an integer number of periods.
///
/// The normal matrix of `1, cos hΩt, sin hΩt` has entries `½ Re/Im g(h ± k)` of the one sum `g(m) = Σ_j e^{imθj}`, so it
/// is built in closed form and factored once for all channels.
pub struct Projector {
    lines: Lines,
    phasors: Arc<Phasors>,
    polynomials: Vec<Vec<f64>>,
    factor: faer::linalg::solvers::Llt<f64>,
    inverse_diagonal: Vec<f64>,
}

impl Projector {
    /// Factors the normal equations.
    ///
    /// # Errors
    /// [`ProjectionError::TooShort`] when there are fewer samples than unknowns, [`ProjectionError::Unresolved`] when the
    /// normal matrix is numerically singular.
    pub fn new(lines: Lines) -> Result<Self, ProjectionError> {
        let unknowns = 2 * lines.order + 1 + lines.drift;
        if lines.samples <= unknowns {
            return Err(ProjectionError::TooShort { samples: lines.samples, unknowns });
        }
        let theta = lines.base / lines.sampling_rate;
        let phasors = Arc::new(Phasors::new(theta, lines.order, lines.samples));
        let polynomials = legendre(lines.samples, lines.drift);
        let normal = normal_matrix(&lines, theta, &phasors, &polynomials);
        let unresolved =
            || ProjectionError::Unresolved { periods: theta * lines.samples as f64 / std::f64::consts::TAU };
        let factor = normal.llt(Side::Lower).map_err(|_| unresolved())?;
        let inverse_diagonal = inverse_diagonal(&factor);
        // A well-posed line has the variance 2σ²/n; a hundred times that means neighbours are told apart by noise.
        if inverse_diagonal.iter().take(2 * lines.order + 1).any(|v| *v > 200.0 / lines.samples as f64) {
            return Err(unresolved());
        }
        Ok(Self { lines, phasors, polynomials, factor, inverse_diagonal })
    }

    /// The lines it projects on.
    #[must_use]
    pub fn lines(&self) -> &Lines {
        &self.lines
    }

    /// Samples harmonics of its lines at the times of its record, with the tables that it has.
    #[must_use]
    pub fn sampler(&self) -> Sampler {
        Sampler::with_phasors(Arc::clone(&self.phasors), self.lines.samples)
    }

    /// Projects one channel of `n` samples.
    ///
    /// # Errors
    /// [`ProjectionError::Length`] when the channel has another number of samples than the record.
    pub fn project(&self, x: &[f64]) -> Result<Projected, ProjectionError> {
        let solution = self.solve(&[x])?;
        Ok(self.projected(self.fitted(solution.col(0), x)))
    }

    /// Projects channels of `n` samples each: their equations are solved together, which costs less than one after the other.
    ///
    /// # Errors
    /// [`ProjectionError::Length`] when a channel has another number of samples than the record.
    pub fn project_all(&self, channels: &[&[f64]]) -> Result<Vec<Projected>, ProjectionError> {
        Ok(self.fits(channels)?.map(|fit| self.projected(fit)).collect())
    }

    /// A fit with what its residual says of the noise.
    fn projected(&self, fit: Fit) -> Projected {
        let Lines { order, base, .. } = self.lines;
        let residual_std = fit.variance().sqrt();
        let periodogram = noise::periodogram(&fit.residual);
        let floor = noise::line_noise(&periodogram, &self.lines);
        let variance = (0..=order)
            .map(|h| {
                let imaginary = if h == 0 { 0.0 } else { self.inverse_diagonal[order + h] };
                floor[h] * (self.inverse_diagonal[h] + imaginary)
            })
            .collect();
        let Fit { coefficients, drift, residual, .. } = fit;
        let harmonics = Harmonics { base, coefficients, variance };
        Projected { harmonics, drift, residual, residual_std, periodogram }
    }

    /// The fits of channels alone: no word of the noise. Each is made when it is asked for, so that it is used while it is near.
    pub(crate) fn fits(&self, channels: &[&[f64]]) -> Result<impl Iterator<Item = Fit>, ProjectionError> {
        let solution = self.solve(channels)?;
        Ok(channels.iter().enumerate().map(move |(c, x)| self.fitted(solution.col(c), x)))
    }

    /// Solutions of the normal equations, a column each channel.
    fn solve(&self, channels: &[&[f64]]) -> Result<Mat<f64>, ProjectionError> {
        let samples = self.lines.samples;
        if let Some(given) = channels.iter().map(|x| x.len()).find(|given| *given != samples) {
            return Err(ProjectionError::Length { given, samples });
        }
        let mut solution = Mat::zeros(self.inverse_diagonal.len(), channels.len());
        for (column, x) in solution.col_iter_mut().zip(channels) {
            column.iter_mut().zip(self.right_side(x)).for_each(|(to, from)| *to = from);
        }
        self.factor.solve_in_place(&mut solution);
        Ok(solution)
    }

    /// The fit of a channel with its solution.
    fn fitted(&self, solution: ColRef<'_, f64>, x: &[f64]) -> Fit {
        let Lines { order, samples, .. } = self.lines;
        let coefficients: Vec<Complex64> = (0..=order)
            .map(|h| Complex64::new(solution[h], if h == 0 { 0.0 } else { -solution[order + h] }))
            .collect();
        let drift: Vec<f64> = (2 * order + 1..solution.nrows()).map(|i| solution[i]).collect();
        let mut residual = self.synthesise(&coefficients);
        residual.iter_mut().zip(x).for_each(|(fit, x)| *fit = x - *fit);
        for (polynomial, c) in self.polynomials.iter().zip(&drift) {
            residual.iter_mut().zip(polynomial).for_each(|(r, p)| *r -= c * p);
        }
        Fit { coefficients, drift, residual, left: samples - solution.nrows() }
    }

    /// Samples of coefficients on the lines (`n`).
    pub(crate) fn synthesise(&self, coefficients: &[Complex64]) -> Vec<f64> {
        self.phasors.synthesise(coefficients, self.lines.samples)
    }

    /// The drift `Σ c_k P_k` of given coefficients on the samples (`n`).
    #[must_use]
    pub fn drift(&self, coefficients: &[f64]) -> Vec<f64> {
        let mut out = vec![0.0; self.lines.samples];
        for (polynomial, c) in self.polynomials.iter().zip(coefficients) {
            out.iter_mut().zip(polynomial).for_each(|(f, p)| *f += c * p);
        }
        out
    }

    /// Products of `1, cos hθj, sin hθj, P_1 … P_d` with a channel.
    fn right_side(&self, x: &[f64]) -> Vec<f64> {
        let sums = self.phasors.transform(x);
        let (cosines, sines) = (sums.iter().map(|s| s.re), sums.iter().skip(1).map(|s| -s.im));
        cosines.chain(sines).chain(self.polynomials.iter().map(|p| dot(p, x))).collect()
    }
}

/// Coefficients of the lines and of the drift, and what they leave.
pub(crate) struct Fit {
    pub(crate) coefficients: Vec<Complex64>,
    drift: Vec<f64>,
    pub(crate) residual: Vec<f64>,
    /// Degrees of freedom of the residual.
    left: usize,
}

impl Fit {
    /// Variance of the residual, corrected for the unknowns.
    pub(crate) fn variance(&self) -> f64 {
        dot(&self.residual, &self.residual) / self.left as f64
    }
}

/// Diagonal of `(LLᵀ)⁻¹`: squares of the columns of `L⁻¹`.
fn inverse_diagonal(factor: &faer::linalg::solvers::Llt<f64>) -> Vec<f64> {
    let n = factor.L().nrows();
    let mut inverse = Mat::<f64>::zeros(n, n);
    invert_lower_triangular(inverse.as_mut(), factor.L(), Par::Seq);
    let square = |i: usize| (i..n).map(|k| inverse[(k, i)].powi(2)).sum();
    (0..n).map(square).collect()
}

/// Legendre polynomials `P_1 … P_degree` on the samples, by Bonnet's recursion.
fn legendre(samples: usize, degree: usize) -> Vec<Vec<f64>> {
    if degree == 0 {
        return Vec::new();
    }
    let at: Vec<f64> = (0..samples).map(|j| 2.0 * j as f64 / (samples.max(2) - 1) as f64 - 1.0).collect();
    let mut all = vec![vec![1.0; samples], at.clone()];
    for k in 1..degree {
        let k = k as f64;
        let next = (0..samples)
            .map(|j| {
                let (last, before) = (&all[all.len() - 1], &all[all.len() - 2]);
                ((2.0 * k + 1.0) * at[j] * last[j] - k * before[j]) / (k + 1.0)
            })
            .collect();
        all.push(next);
    }
    all.drain(1..).take(degree).collect()
}

/// Normal matrix of `1, cos hθj (h = 1..H), sin hθj (h = 1..H), P_1 … P_d`; the triangle above the diagonal stays empty.
fn normal_matrix(lines: &Lines, theta: f64, phasors: &Phasors, polynomials: &[Vec<f64>]) -> Mat<f64> {
    let order = lines.order;
    let sums: Vec<Complex64> = (0..=2 * order).map(|m| dirichlet(m as f64 * theta, lines.samples)).collect();
    let crossed: Vec<Vec<Complex64>> = polynomials.iter().map(|p| phasors.transform(p)).collect();
    let g = |m: isize| if m < 0 { sums[m.unsigned_abs()].conj() } else { sums[m.unsigned_abs()] };
    let entry = |i: usize, k: usize| {
        let (h, q) = (line_of(i, order), line_of(k, order));
        trigonometric([g(h + q), g(h - q)], [i <= order, k <= order])
    };
    let mixed = |i: usize, d: usize| {
        let z = crossed[d][line_of(i, order).unsigned_abs()];
        if i <= order { z.re } else { -z.im }
    };
    let first = 2 * order + 1;
    let unknowns = first + polynomials.len();
    let mut normal = Mat::zeros(unknowns, unknowns);
    for k in 0..unknowns {
        for i in k..unknowns {
            normal[(i, k)] = match (i < first, k < first) {
                (true, _) => entry(i, k),
                (false, true) => mixed(k, i - first),
                (false, false) => dot(&polynomials[i - first], &polynomials[k - first]),
            };
        }
    }
    normal
}

/// Sum over the samples of two waves of the lines `h` and `q`, cosines or sines, from `g(h + q)` and `g(h − q)`, `g(m) = Σ e^{imθj}`.
pub(crate) fn trigonometric([sum, difference]: [Complex64; 2], cosines: [bool; 2]) -> f64 {
    0.5 * match cosines {
        [true, true] => difference.re + sum.re,
        [false, false] => difference.re - sum.re,
        [false, true] => sum.im + difference.im,
        [true, false] => sum.im - difference.im,
    }
}

fn line_of(unknown: usize, order: usize) -> isize {
    (if unknown <= order { unknown } else { unknown - order }) as isize
}

/// `Σ_{j<n} e^{iφj} = e^{iφ(n−1)/2} sin(nφ/2)/sin(φ/2)`.
fn dirichlet(phi: f64, n: usize) -> Complex64 {
    let half = (0.5 * phi).sin();
    if half.abs() < 1e-12 {
        return Complex64::new(n as f64, 0.0);
    }
    Complex64::cis(0.5 * phi * (n as f64 - 1.0)) * ((0.5 * phi * n as f64).sin() / half)
}

#[cfg(test)]
mod tests;
