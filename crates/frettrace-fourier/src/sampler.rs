//! Samples of many harmonics of one base frequency.

use crate::Grid;
use crate::phasors::Phasors;
use num_complex::Complex64;
use std::sync::Arc;

/// Samples harmonics of one base frequency at equidistant times `j/sampling_rate`: what they need is computed once.
#[derive(Clone)]
pub struct Sampler {
    samples: usize,
    way: Way,
}

#[derive(Clone)]
enum Way {
    /// The lines are the bins of the record: one Fourier transform.
    Bins(Grid),
    /// They lie anywhere.
    Phasors(Arc<Phasors>),
}

impl std::fmt::Debug for Sampler {
    fn fmt(&self, out: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        out.debug_struct("Sampler").field("samples", &self.samples).finish_non_exhaustive()
    }
}

impl Sampler {
    /// For lines `0..=order` of a base angular frequency (rad/s), and records of a sampling rate (Hz) and so many samples.
    #[must_use]
    pub fn new(base: f64, order: usize, (sampling_rate, samples): (f64, usize)) -> Self {
        let periods = base * samples as f64 / (sampling_rate * std::f64::consts::TAU);
        let bins = if (periods - 1.0).abs() > 1e-12 { None } else { Grid::new(order, samples).ok() };
        let phasors = || Way::Phasors(Arc::new(Phasors::new(base / sampling_rate, order, samples)));
        Self { samples, way: bins.map_or_else(phasors, Way::Bins) }
    }

    /// With phasors that are there already.
    pub(crate) fn with_phasors(phasors: Arc<Phasors>, samples: usize) -> Self {
        Self { samples, way: Way::Phasors(phasors) }
    }

    /// Samples `x_j = Re Σ_h x̂_h e^{ihΩj/f_s}` of coefficients `x̂_0 …`; those beyond the order are left out.
    #[must_use]
    pub fn sample(&self, coefficients: &[Complex64]) -> Vec<f64> {
        match &self.way {
            Way::Phasors(phasors) => phasors.synthesise(coefficients, self.samples),
            Way::Bins(grid) => {
                let mut values = vec![0.0; self.samples];
                grid.evaluate(coefficients, &mut values, &mut grid.scratch());
                values
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::TAU;

    /// Both ways against the definition: bins of the record, and a base frequency that is none.
    #[test]
    fn samples_are_those_of_the_definition() {
        let coefficients: Vec<Complex64> =
            (0..5).map(|h| Complex64::new(1.0 / (1 + h) as f64, 0.2 * f64::from(h))).collect();
        let (rate, samples) = (256.0, 100);
        for base in [TAU * rate / samples as f64, 17.3] {
            let found = Sampler::new(base, 4, (rate, samples)).sample(&coefficients);
            for (j, value) in found.iter().enumerate() {
                let turn = |h: usize| Complex64::cis(base * (h * j) as f64 / rate);
                let real = |h: usize, x: &Complex64| if h == 0 { Complex64::from(x.re) } else { x * turn(h) };
                let plain: Complex64 = coefficients.iter().enumerate().map(|(h, x)| real(h, x)).sum();
                assert!((value - plain.re).abs() < 1e-12, "{base} {j}");
            }
        }
    }
}
