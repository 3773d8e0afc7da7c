use super::{Fit, FitSettings, fit};
use crate::{IdentifyError, Model, Parameter};
use rayon::prelude::*;

/// Fits from many starts, best first.
#[derive(Clone, Debug, PartialEq)]
pub struct ManyFits {
    /// The fits that could be made, by rising cost.
    pub fits: Vec<Fit>,
    /// Starts where the model had no solution.
    pub failed: usize,
}

impl ManyFits {
    /// The best fit.
    #[must_use]
    pub fn best(&self) -> &Fit {
        &self.fits[0]
    }

    /// Share of the fits that found the best minimum (χ² within 1 of it): low means a rugged problem.
    #[must_use]
    pub fn agreement(&self) -> f64 {
        let near = self.fits.iter().filter(|f| f.cost <= self.fits[0].cost + 1.0).count();
        near as f64 / (self.fits.len() + self.failed) as f64
    }
}

/// Fits from every start in parallel.
///
/// # Errors
/// [`IdentifyError::NoStart`] where no start has a solution; the error of the first start where none suits the model.
pub fn fit_from_many<M: Model>(
    model: &M,
    starts: &[Vec<f64>],
    settings: &FitSettings,
) -> Result<ManyFits, IdentifyError> {
    let results: Vec<_> = starts.par_iter().map(|start| fit(model, start, settings)).collect();
    let mut failed = 0;
    let mut fits = Vec::with_capacity(results.len());
    for result in results {
        match result {
            Ok(fit) => fits.push(fit),
            Err(IdentifyError::NoStart { .. }) => failed += 1,
            Err(error) => return Err(error),
        }
    }
    if fits.is_empty() {
        return Err(IdentifyError::NoStart { starts: failed });
    }
    fits.sort_by(|a, b| a.cost.total_cmp(&b.cost));
    Ok(ManyFits { fits, failed })
}

/// `count` starts: the given one and points of a quasi-random sequence around it.
///
/// `spread` is the half-width in the coordinate of each parameter (1 for a logarithm: from 1/e to e times; 0: fixed).
/// The sequence is the additive recurrence with the powers of the generalised golden ratio (Roberts' R_d), so equal
/// calls give equal starts.
#[must_use]
pub fn starts(parameters: &[Parameter], centre: &[f64], spread: &[f64], count: usize) -> Vec<Vec<f64>> {
    let ratio = golden_ratio(parameters.len());
    (0..count)
        .map(|k| {
            let place = |j: usize| {
                let parameter = &parameters[j];
                let (low, high) = parameter.coordinate_bounds();
                let unit = (0.5 + k as f64 * ratio.powi(-(j as i32 + 1))).fract();
                let c = parameter.transform.coordinate(centre[j]) + spread[j] * (2.0 * unit - 1.0);
                parameter.transform.value(c.clamp(low, high))
            };
            (0..parameters.len()).map(place).collect()
        })
        .collect()
}

/// Positive root of `x^{d+1} = x + 1`.
fn golden_ratio(dimension: usize) -> f64 {
    let mut x = 1.5_f64;
    for _ in 0..60 {
        x = (1.0 + x).powf(1.0 / (dimension as f64 + 1.0));
    }
    x
}
