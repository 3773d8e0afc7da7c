//! Whether a parameter is the same in all groups of runs.

use crate::fit::stacked;
use crate::{Fit, Identified, Model, Parameter};
use nalgebra::{DMatrix, DVector};

/// Runs in groups.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Grouping<'a> {
    /// Numbers of consecutive residuals of the runs.
    pub sizes: &'a [usize],
    /// Group of each run, counted from 0.
    pub group: &'a [usize],
}

/// A parameter with a value of its own in each group.
#[derive(Clone, Debug, PartialEq)]
pub struct GroupTest {
    /// Index of the parameter.
    pub parameter: usize,
    /// By how much its Bayesian information criterion is better than that of one shared value: above 10 the groups
    /// differ, below −10 they share it, between the data do not tell.
    pub evidence: f64,
    /// Value and standard deviation in each group.
    pub values: Vec<(f64, f64)>,
}

/// Tests for each of `tested` whether its value differs between the groups, one parameter at a time, all others shared and
/// free.
///
/// The model is linear about the fit, so that a group whose value would lie further away than one step of a fit may go ends the
/// test of a parameter. The parameter's column is split by groups, `min ‖J_G δ + r‖²`, and the evidence is
/// `(χ² − χ²_G)/s − (G − 1) ln n` with `s` what `χ²_G` per degree of freedom exceeds 1 and the effective number `n` of
/// the residuals.
#[must_use]
pub fn test_groups<M: Model>(
    model: &M,
    (fit, identified): (&Fit, &Identified),
    grouping: Grouping<'_>,
    tested: &[usize],
) -> Vec<GroupTest> {
    let rows = model.residual_count();
    let mut residual = vec![0.0; rows];
    let mut jacobian = DMatrix::zeros(rows, fit.values.len());
    let target = (&mut residual[..], &mut jacobian);
    if model.linearise(&fit.values, &fit.free, &mut model.memory(), target).is_err() {
        return Vec::new();
    }
    let (tall, right) = stacked(model, &fit.values, &fit.free, (&jacobian, &residual));
    let Some((_, shared, _)) = least_squares(&tall, &right) else { return Vec::new() };
    let columns: Vec<usize> = (0..fit.free.len()).filter(|j| fit.free[*j]).collect();
    let statistics = &identified.statistics;
    let count = 1 + grouping.group.iter().copied().max().unwrap_or(0);
    let penalty = (count - 1) as f64 * statistics.effective_count.ln();
    tested
        .iter()
        .filter_map(|j| {
            let column = columns.iter().position(|c| c == j)?;
            let (shift, left, inverse) = least_squares(&split(&tall, column, &grouping), &right)?;
            let described = &model.parameters()[*j];
            // Where no group is near the common value, the model is not linear that far and says nothing of them.
            if (0..count).any(|g| shift[g].abs() > described.transform.longest_step()) {
                return None;
            }
            let freedom = (statistics.count as f64 - inverse.ncols() as f64).max(1.0);
            let scale = (left / freedom).max(1.0) * statistics.count as f64 / statistics.effective_count;
            let value = |g: usize| physical(described, fit.values[*j], (shift[g], scale * inverse[(g, g)]));
            Some(GroupTest {
                parameter: *j,
                evidence: (shared - left) / scale - penalty,
                values: (0..count).map(value).collect(),
            })
        })
        .collect()
}

/// Value and standard deviation after a step of the coordinate.
fn physical(described: &Parameter, value: f64, (shift, variance): (f64, f64)) -> (f64, f64) {
    let transform = described.transform;
    let moved = transform.value(transform.coordinate(value) + shift);
    (moved, variance.sqrt() * transform.slope(moved).abs())
}

/// One column of a matrix in as many as there are groups, which come first; rows below the runs (priors) stay with none.
fn split(tall: &DMatrix<f64>, column: usize, grouping: &Grouping<'_>) -> DMatrix<f64> {
    let count = 1 + grouping.group.iter().copied().max().unwrap_or(0);
    let mut out = DMatrix::zeros(tall.nrows(), tall.ncols() - 1 + count);
    let mut row = 0;
    for (size, group) in grouping.sizes.iter().zip(grouping.group) {
        out.view_mut((row, *group), (*size, 1)).copy_from(&tall.view((row, column), (*size, 1)));
        row += size;
    }
    for (place, j) in (0..tall.ncols()).filter(|j| *j != column).enumerate() {
        out.set_column(count + place, &tall.column(j));
    }
    out
}

/// Step, sum of squares that it leaves, and inverse of the normal matrix; `None` where columns are dependent.
fn least_squares(tall: &DMatrix<f64>, right: &DVector<f64>) -> Option<(DVector<f64>, f64, DMatrix<f64>)> {
    let width = tall.ncols();
    let decomposition = tall.clone().qr();
    let triangle = decomposition.r();
    let mut turned = -right;
    decomposition.q_tr_mul(&mut turned);
    let step = triangle.solve_upper_triangular(&turned.rows(0, width).into_owned())?;
    let root = triangle.solve_upper_triangular(&DMatrix::identity(width, width))?;
    let finite = step.iter().chain(root.iter()).all(|x| x.is_finite());
    let left = turned.rows(width, turned.len() - width).norm_squared();
    finite.then(|| (step, left, &root * root.transpose()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{FitSettings, IdentifySettings, NoSolution, fit, identify};

    /// Straight lines `y = p x + q` of two runs of ten points with unit noise; the second run has a slope of its own.
    struct Lines {
        parameters: Vec<Parameter>,
        second: f64,
    }

    impl Lines {
        fn new(second: f64) -> Self {
            let parameter = |name: &str| Parameter::positive(name, "1", (1e-6, 1e6));
            Self { parameters: vec![parameter("slope"), parameter("offset")], second }
        }
    }

    impl Model for Lines {
        type Memory = ();
        fn parameters(&self) -> &[Parameter] {
            &self.parameters
        }
        fn residual_count(&self) -> usize {
            20
        }
        fn memory(&self) {}
        fn residual(&self, values: &[f64], (): &mut (), residual: &mut [f64]) -> Result<(), NoSolution> {
            for (k, r) in residual.iter_mut().enumerate() {
                let slope = if k < 10 { 3.0 } else { self.second };
                // Errors of unit size that alternate, so that neither slope nor offset follows them.
                let error = if k % 2 == 0 { 1.0 } else { -1.0 };
                *r = slope * (k % 10) as f64 + 5.0 + error - values[0] * (k % 10) as f64 - values[1];
            }
            Ok(())
        }
        fn linearise(
            &self,
            values: &[f64],
            _free: &[bool],
            memory: &mut (),
            (residual, jacobian): (&mut [f64], &mut DMatrix<f64>),
        ) -> Result<(), NoSolution> {
            for k in 0..20 {
                jacobian[(k, 0)] = -((k % 10) as f64);
                jacobian[(k, 1)] = -1.0;
            }
            self.residual(values, memory, residual)
        }
    }

    fn evidence(second: f64) -> GroupTest {
        let model = Lines::new(second);
        let found = fit(&model, &[2.0, 2.0], &FitSettings::default()).unwrap();
        let identified = identify(&model, &found, &IdentifySettings::default()).unwrap();
        let grouping = Grouping { sizes: &[10, 10], group: &[0, 1] };
        test_groups(&model, (&found, &identified), grouping, &[0]).remove(0)
    }

    /// Ten points with x² adding to 285 and unit noise: a slope is known to about 0.06, so 3 and 6 differ and 3 and 3
    /// do not; what is left of equal lines costs ln 20 = 3.0.
    #[test]
    fn a_slope_of_its_own_is_told_from_a_shared_one() {
        let apart = evidence(6.0);
        assert!(apart.evidence > 10.0, "{apart:?}");
        assert!(apart.values[1].0 > 1.5 * apart.values[0].0, "{apart:?}");
        let same = evidence(3.0);
        assert!((same.evidence + 20.0_f64.ln()).abs() < 0.1, "{same:?}");
    }

    /// Forty times as steep as the lines that were fitted: no straight line leads there.
    #[test]
    fn groups_too_far_apart_for_a_linear_model_are_not_tested() {
        let (alike, apart) = (Lines::new(3.0), Lines::new(120.0));
        let found = fit(&alike, &[2.0, 2.0], &FitSettings::default()).unwrap();
        let identified = identify(&alike, &found, &IdentifySettings::default()).unwrap();
        let grouping = Grouping { sizes: &[10, 10], group: &[0, 1] };
        assert!(test_groups(&apart, (&found, &identified), grouping, &[0]).is_empty());
    }
}
