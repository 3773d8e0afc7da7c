//! Which law the data speak for.

use super::{ContactFit, ContactModel, Family};
use crate::evidence::{Candidate, Ranking, rank};

/// Ranks laws fitted to the same histories by `n_eff ln(RSS/n) + k ln n_eff`, the Bayesian information criterion where
/// the size of the residual is not known beforehand; `floor` (N) bounds the residual from below, since what is less
/// than noise is no merit.
#[must_use]
pub fn compare(fits: &[(ContactFit, ContactModel<'_>)], held_out: &[f64], floor: f64) -> Ranking<Family> {
    let effective = fits
        .iter()
        .map(|(fit, _)| fit.identified.statistics.effective_count)
        .fold(f64::INFINITY, f64::min)
        .max(2.0);
    let candidates = fits
        .iter()
        .zip(held_out)
        .map(|((fit, model), held_out)| {
            let values = fit.identified.values();
            let (sum, count) = (0..model.histories().len())
                .flat_map(|index| model.force_residual(index, &values))
                .fold((0.0, 0.0), |(sum, count), r| (sum + r * r, count + 1.0));
            let square = (sum / f64::max(count, 1.0)).max(floor * floor).max(f64::MIN_POSITIVE);
            Candidate {
                name: fit.family,
                criterion: effective * square.ln() + fit.identified.statistics.rank as f64 * effective.ln(),
                held_out: *held_out,
            }
        })
        .collect();
    rank(candidates)
}
