//! What a fixed value that is not quite known does to the fitted ones.

use crate::fit::stacked;
use crate::{Fit, Identified, Model};
use nalgebra::{DMatrix, DVector};

/// Widens the intervals of `identified` by parameters of the model that were held though they are not exactly known, each to a standard
/// deviation (index, std): `C += Σ_s d dᵀ`, `d = −(JᵀJ)⁻¹Jᵀ ∂r/∂p_s · std_s`.
///
/// A calibration of a sensor, say, is the same for all lines of all runs: no number of residuals averages it out.
pub fn widen_by_held<M: Model>(model: &M, fit: &Fit, identified: &mut Identified, held: &[(usize, f64)]) {
    if let Some(covariance) = covariance(model, fit, held) {
        identified.add_covariance(&covariance, model.parameters());
    }
}

/// Widens the intervals to the covariance that the scatter between groups of residuals shows, where that is larger:
/// `A⁻¹ (Σ_g s_g s_gᵀ) A⁻¹ · G/(G − 1)`, `s_g = J_gᵀ r_g`, `A = JᵀJ` (the sandwich of Huber and White by clusters).
///
/// Errors of a model pull the runs in different directions; noise alone pulls each of them by its own share of `A`.
/// `sizes` are the numbers of consecutive residuals of the groups; fewer than three say nothing.
pub fn widen_by_groups<M: Model>(model: &M, fit: &Fit, identified: &mut Identified, sizes: &[usize]) {
    if sizes.len() < 3 {
        return;
    }
    if let Some(covariance) = by_groups(model, fit, sizes) {
        identified.widen(&covariance, model.parameters());
    }
}

/// Covariance of the free coordinates by groups.
fn by_groups<M: Model>(model: &M, fit: &Fit, sizes: &[usize]) -> Option<DMatrix<f64>> {
    let rows = model.residual_count();
    let mut residual = vec![0.0; rows];
    let mut jacobian = DMatrix::zeros(rows, fit.values.len());
    model.linearise(&fit.values, &fit.free, &mut model.memory(), (&mut residual, &mut jacobian)).ok()?;
    let (tall, right) = stacked(model, &fit.values, &fit.free, (&jacobian, &residual));
    let triangle = tall.clone().qr().r();
    let mut sum = DMatrix::zeros(tall.ncols(), tall.ncols());
    let mut row = 0;
    for size in sizes {
        let score = tall.rows(row, *size).tr_mul(&right.rows(row, *size));
        let half = triangle.transpose().solve_lower_triangular(&score)?;
        let shift = triangle.solve_upper_triangular(&half)?;
        sum += &shift * shift.transpose();
        row += size;
    }
    let count = sizes.len() as f64;
    Some(sum * (count / (count - 1.0)))
}

/// Moves the estimates by what a better prediction makes of them, `δ = (JᵀJ)⁻¹JᵀΔ`, and widens their intervals by that
/// much: `C += δδᵀ`.
///
/// `change` is the better whitened prediction minus that of the model (longer series, finer grids), one value a
/// residual. What it corrects is the truncation error to first order; the size of the correction bounds what is left.
pub fn correct_by<M: Model>(model: &M, fit: &Fit, identified: &mut Identified, change: &[f64]) {
    let rows = model.residual_count();
    let mut residual = vec![0.0; rows];
    let mut jacobian = DMatrix::zeros(rows, fit.values.len());
    let target = (&mut residual[..], &mut jacobian);
    if model.linearise(&fit.values, &fit.free, &mut model.memory(), target).is_err() {
        return;
    }
    let (tall, _) = stacked(model, &fit.values, &fit.free, (&jacobian, &residual));
    let triangle = tall.clone().qr().r();
    let pull = tall.rows(0, rows).tr_mul(&DVector::from_column_slice(change));
    let shift = triangle
        .transpose()
        .solve_lower_triangular(&pull)
        .and_then(|half| triangle.solve_upper_triangular(&half))
        .filter(|shift| shift.iter().all(|x| x.is_finite()));
    let Some(shift) = shift else { return };
    let columns: Vec<usize> = (0..fit.free.len()).filter(|j| fit.free[*j]).collect();
    let mut covariance = DMatrix::zeros(fit.values.len(), fit.values.len());
    for (a, i) in columns.iter().enumerate() {
        for (b, j) in columns.iter().enumerate() {
            covariance[(*i, *j)] = shift[a] * shift[b];
        }
        identified.move_by(*i, shift[a], &model.parameters()[*i]);
    }
    identified.add_covariance(&covariance, model.parameters());
}

/// Widens the intervals of all free parameters without a prior by a relative accuracy of the model itself, `C_jj += σ_j²` with
/// `σ_j = accuracy · p_j / p_j′(c_j)`.
///
/// What those of `together` miss is one factor that they have in common, `C_jk += σ_j σ_k`: coefficients of friction and of stiffness
/// per normal force are all off by what the load cell is, and so is their sum.
pub fn widen_to_accuracy<M: Model>(
    model: &M,
    identified: &mut Identified,
    accuracy: f64,
    together: &[usize],
) {
    let sizes: Vec<f64> = model
        .parameters()
        .iter()
        .enumerate()
        .map(|(j, parameter)| {
            let is_free = parameter.prior.is_none() && identified.covariance[(j, j)] > 0.0;
            let value = identified.parameters[j].value;
            if is_free { accuracy * value / parameter.transform.slope(value) } else { 0.0 }
        })
        .collect();
    let covariance = DMatrix::from_fn(sizes.len(), sizes.len(), |j, k| {
        let is_shared = j == k || together.contains(&j) && together.contains(&k);
        if is_shared { sizes[j] * sizes[k] } else { 0.0 }
    });
    identified.add_covariance(&covariance, model.parameters());
}

fn covariance<M: Model>(model: &M, fit: &Fit, held: &[(usize, f64)]) -> Option<DMatrix<f64>> {
    let rows = model.residual_count();
    let mut residual = vec![0.0; rows];
    let mut jacobian = DMatrix::zeros(rows, fit.values.len());
    let mut wanted = fit.free.clone();
    for (index, _) in held {
        *wanted.get_mut(*index)? = true;
    }
    let mut memory = model.memory();
    model.linearise(&fit.values, &wanted, &mut memory, (&mut residual, &mut jacobian)).ok()?;
    let (tall, _) = stacked(model, &fit.values, &fit.free, (&jacobian, &residual));
    let columns: Vec<usize> = (0..fit.free.len()).filter(|j| fit.free[*j]).collect();
    let triangle = tall.clone().qr().r();
    let mut sum = DMatrix::zeros(fit.values.len(), fit.values.len());
    for (index, std) in held {
        let error = jacobian.column(*index) * *std;
        let half = triangle.transpose().solve_lower_triangular(&tall.rows(0, rows).tr_mul(&error))?;
        let shift = triangle.solve_upper_triangular(&half)?;
        for (a, i) in columns.iter().enumerate() {
            for (b, j) in columns.iter().enumerate() {
                sum[(*i, *j)] += shift[a] * shift[b];
            }
        }
    }
    sum.iter().all(|x: &f64| x.is_finite()).then_some(sum)
}
