//! Phase grid: `N` samples of one period and the transforms between samples and harmonics.

use crate::plans;
use num_complex::Complex64;
use realfft::{ComplexToReal, RealToComplex};
use std::sync::Arc;

/// Why a grid cannot be made.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum GridError {
    /// The grid would alias the highest harmonic.
    #[error("{samples} samples a period alias harmonic {order}: at least {} are needed", 2 * order + 1)]
    Aliased {
        /// Highest harmonic asked for.
        order: usize,
        /// Samples a period asked for.
        samples: usize,
    },
}

/// `N` equidistant samples of the phase `τ = Ωt ∈ [0, 2π)`, and the transforms for harmonics `0..=H`, `N > 2H`.
#[derive(Clone)]
pub struct Grid {
    order: usize,
    samples: usize,
    forward: Arc<dyn RealToComplex<f64>>,
    inverse: Arc<dyn ComplexToReal<f64>>,
}

/// Scratch of a [`Grid`], so that its transforms allocate nothing.
#[derive(Clone, Debug)]
pub struct GridScratch {
    spectrum: Vec<Complex64>,
    signal: Vec<f64>,
    work: Vec<Complex64>,
}

impl Grid {
    /// A grid for harmonics `0..=order` with `samples` samples a period.
    ///
    /// # Errors
    /// [`GridError::Aliased`] unless `samples > 2·order`.
    pub fn new(order: usize, samples: usize) -> Result<Self, GridError> {
        if samples <= 2 * order {
            return Err(GridError::Aliased { order, samples });
        }
        Ok(Self { order, samples, forward: plans::forward(samples), inverse: plans::inverse(samples) })
    }

    /// Highest harmonic `H`.
    #[must_use]
    pub fn order(&self) -> usize {
        self.order
    }

    /// Samples a period `N`.
    #[must_use]
    pub fn samples(&self) -> usize {
        self.samples
    }

    /// Working memory for [`Self::project`] and [`Self::evaluate`].
    #[must_use]
    pub fn scratch(&self) -> GridScratch {
        let work = self.forward.get_scratch_len().max(self.inverse.get_scratch_len());
        GridScratch {
            spectrum: vec![Complex64::ZERO; self.samples / 2 + 1],
            signal: vec![0.0; self.samples],
            work: vec![Complex64::ZERO; work],
        }
    }

    /// Samples (`N`) to harmonics (`H + 1`): `x̂_h = (2 − δ_{h0})/N Σ_k x_k e^{−ihτ_k}`.
    ///
    /// Slices of other lengths are cut to the shorter of what is given and what is needed.
    pub fn project(&self, samples: &[f64], harmonics: &mut [Complex64], scratch: &mut GridScratch) {
        self.transform(samples, scratch);
        let scale = 1.0 / self.samples as f64;
        for (h, (out, bin)) in harmonics.iter_mut().zip(&scratch.spectrum[..=self.order]).enumerate() {
            *out = bin * if h == 0 { scale } else { 2.0 * scale };
        }
    }

    fn transform(&self, samples: &[f64], scratch: &mut GridScratch) {
        scratch.signal.fill(0.0);
        let n = samples.len().min(self.samples);
        scratch.signal[..n].copy_from_slice(&samples[..n]);
        let done =
            self.forward.process_with_scratch(&mut scratch.signal, &mut scratch.spectrum, &mut scratch.work);
        debug_assert!(done.is_ok(), "the scratch belongs to another grid");
    }

    /// Samples (`N`) to all their bins (`⌊N/2⌋ + 1`), whatever the highest harmonic: `X_q = 1/N Σ_k x_k e^{−iqτ_k}`.
    pub fn bins(&self, samples: &[f64], scratch: &mut GridScratch) -> Vec<Complex64> {
        self.transform(samples, scratch);
        let scale = 1.0 / self.samples as f64;
        scratch.spectrum.iter().map(|bin| bin * scale).collect()
    }

    /// Harmonics (`H + 1`) to samples (`N`): `x_k = Re Σ_h x̂_h e^{ihτ_k}`.
    pub fn evaluate(&self, harmonics: &[Complex64], samples: &mut [f64], scratch: &mut GridScratch) {
        scratch.spectrum.fill(Complex64::ZERO);
        for (h, (bin, value)) in scratch.spectrum.iter_mut().zip(harmonics).take(self.order + 1).enumerate() {
            *bin = if h == 0 { Complex64::new(value.re, 0.0) } else { value * 0.5 };
        }
        let done =
            self.inverse.process_with_scratch(&mut scratch.spectrum, &mut scratch.signal, &mut scratch.work);
        debug_assert!(done.is_ok(), "the scratch belongs to another grid");
        let n = samples.len().min(self.samples);
        samples[..n].copy_from_slice(&scratch.signal[..n]);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Projection undoes evaluation, for even and odd grids at the alias limit and above it.
    #[test]
    fn projection_inverts_evaluation() {
        for (order, n) in [(1, 3), (4, 9), (4, 16), (7, 128)] {
            let grid = Grid::new(order, n).unwrap();
            let mut scratch = grid.scratch();
            let given: Vec<_> = (0..=order)
                .map(|h| Complex64::new(1.0 / (h + 1) as f64, if h == 0 { 0.0 } else { 0.3 * h as f64 }))
                .collect();
            let (mut samples, mut back) = (vec![0.0; n], vec![Complex64::ZERO; order + 1]);
            grid.evaluate(&given, &mut samples, &mut scratch);
            grid.project(&samples, &mut back, &mut scratch);
            for (a, b) in given.iter().zip(&back) {
                assert!((a - b).norm() < 1e-14 * n as f64, "{a} {b}");
            }
        }
    }

    /// `cos τ` has `x̂_1 = 1`; `sin τ` has `x̂_1 = −i`: Re(−i e^{iτ}) = sin τ.
    #[test]
    fn convention_of_cosine_and_sine() {
        let grid = Grid::new(2, 8).unwrap();
        let mut scratch = grid.scratch();
        let mut x = vec![Complex64::ZERO; 3];
        let tau = |k: usize| std::f64::consts::TAU * k as f64 / 8.0;
        grid.project(&(0..8).map(|k| tau(k).cos()).collect::<Vec<_>>(), &mut x, &mut scratch);
        assert!((x[1] - Complex64::ONE).norm() < 1e-15);
        grid.project(&(0..8).map(|k| tau(k).sin()).collect::<Vec<_>>(), &mut x, &mut scratch);
        assert!((x[1] + Complex64::I).norm() < 1e-15);
    }

    /// The bins of a wave above the grid's highest harmonic: `0.6 cos(3τ) − 0.8 sin(3τ)` has `X_3 = (0.6 + 0.8i)/2`, whatever the order.
    #[test]
    fn bins_reach_to_half_the_samples() {
        let grid = Grid::new(1, 8).unwrap();
        let tau = |k: usize| std::f64::consts::TAU * k as f64 / 8.0;
        let wave: Vec<f64> =
            (0..8).map(|k| 0.6 * (3.0 * tau(k)).cos() - 0.8 * (3.0 * tau(k)).sin()).collect();
        let bins = grid.bins(&wave, &mut grid.scratch());
        assert_eq!(bins.len(), 5);
        for (q, bin) in bins.iter().enumerate() {
            let expected = if q == 3 { Complex64::new(0.3, 0.4) } else { Complex64::ZERO };
            assert!((bin - expected).norm() < 1e-15, "{q}: {bin}");
        }
    }

    #[test]
    fn aliased_grid_is_refused() {
        assert_eq!(Grid::new(4, 8).err(), Some(GridError::Aliased { order: 4, samples: 8 }));
    }
}
