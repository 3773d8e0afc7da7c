//! Noise in slip as well as in force: weights and covariance by draws of the true noise.

use super::ContactModel;
use super::drive::Shift;
use crate::Model;
use crate::fit::stacked;
use nalgebra::{DMatrix, DVector};

/// Samples on each side over which the variance of the draws is averaged: few enough to keep the loop's shape.
const NEIGHBOURS: usize = 3;

/// `1/s` of every sample, `s²` being the variance of predicted minus measured force under the noise of both.
pub(super) fn weights(model: &ContactModel<'_>, values: &[f64]) -> Vec<Vec<f64>> {
    (0..model.histories().len())
        .map(|index| {
            let history = model.histories()[index];
            let variance = variance(model, index, values);
            let n = variance.len();
            let mean = variance.iter().sum::<f64>() / n as f64;
            (0..n)
                .map(|k| {
                    let window = (0..=2 * NEIGHBOURS).map(|d| variance[(k + n + d - NEIGHBOURS) % n]);
                    let local = window.sum::<f64>() / (2 * NEIGHBOURS + 1) as f64;
                    // A tenth of the mean keeps a sample that few draws happen to spare from ruling the fit.
                    1.0 / local
                        .max(0.1 * mean)
                        .max(0.01 * history.force_std.powi(2))
                        .max(f64::MIN_POSITIVE)
                        .sqrt()
                })
                .collect()
        })
        .collect()
}

fn variance(model: &ContactModel<'_>, index: usize, values: &[f64]) -> Vec<f64> {
    let history = model.histories()[index];
    if history.draws.is_empty() {
        return vec![history.force_std.powi(2); history.len()];
    }
    let mut sum = vec![0.0; history.len()];
    for error in misses(model, index, values) {
        for (s, e) in sum.iter_mut().zip(&error) {
            *s += e * e;
        }
    }
    let share = 1.0 / history.draws.len() as f64;
    sum.iter().map(|s| s * share).collect()
}

/// For each draw, how far it moves predicted minus measured force (N).
fn misses<'m>(
    model: &'m ContactModel<'_>,
    index: usize,
    values: &'m [f64],
) -> impl Iterator<Item = Vec<f64>> + 'm {
    let history = model.histories()[index];
    let mut plain = vec![0.0; history.len()];
    model.predict(index, values, None, &mut plain);
    history.draws.iter().map(move |draw| {
        let mut moved = vec![0.0; history.len()];
        let shift = Shift { slip: &draw.slip, velocity: &draw.velocity };
        model.predict(index, values, Some(&shift), &mut moved);
        moved.iter().zip(&plain).zip(&draw.force).map(|((m, p), f)| m - p - f).collect()
    })
}

/// Covariance of the free coordinates under the draws: `A⁻¹ (Σ_d g_d g_dᵀ/D) A⁻¹`, `g_d = Jᵀ ε_d`, `A = JᵀJ`.
///
/// Unlike `A⁻¹` it knows that an error of the slip moves the forces of a whole loop together.
pub(super) fn covariance(model: &ContactModel<'_>, values: &[f64], free: &[bool]) -> Option<DMatrix<f64>> {
    let draws = model.histories().iter().map(|h| h.draws.len()).min().unwrap_or(0);
    if draws < 2 {
        return None;
    }
    let rows = model.residual_count();
    let mut residual = vec![0.0; rows];
    let mut jacobian = DMatrix::zeros(rows, values.len());
    let mut memory = model.memory();
    model.linearise(values, free, &mut memory, (&mut residual, &mut jacobian)).ok()?;
    let (tall, _) = stacked(model, values, free, (&jacobian, &residual));
    let solver = tall.tr_mul(&tall).cholesky()?;
    let mut gradients = vec![DVector::zeros(tall.ncols()); draws];
    let mut row = 0;
    for (index, history) in model.histories().iter().enumerate() {
        let counted = history.counted();
        for (gradient, error) in gradients.iter_mut().zip(misses(model, index, values)) {
            for (offset, k) in counted.clone().enumerate() {
                let whitened = error[k] * model.weights()[index][k];
                *gradient += tall.row(row + offset).transpose() * whitened;
            }
        }
        row += counted.len();
    }
    let mut sum = DMatrix::zeros(tall.ncols(), tall.ncols());
    for gradient in &gradients {
        let shift = solver.solve(gradient);
        sum += &shift * shift.transpose();
    }
    Some(sum / draws as f64)
}
