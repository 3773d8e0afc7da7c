//! How far fitted values may be from the right ones.
//!
//! Noise: with the Jacobian `J` of the whitened residuals `r` (n × m) and the precisions `Λ` of the priors (m × m, diagonal), the
//! covariance of the values is `C = (JᵀJ + Λ)⁻¹`, times `max(1, χ²/n)` where the model leaves more than the noise.
//!
//! The phase grid: what it cuts short bends the values with all runs in one direction, which no χ² near the noise shows. A residual that
//! changes by `δ` on a grid with twice the lines moves them by `−C Jᵀδ` to first order. Twice the lines divide the error by about
//! three, so that all finer grids together move them by half as much again.

use crate::search::Explained;
use crate::study::Fitted;
use crate::{Study, Unknown};
use frettrace_identify::{Fit, HALF_INTERVAL95, Model};
use nalgebra::{Cholesky, DMatrix, DVector, Dyn};

/// How far all finer grids move a value, over what the next one does: `1/(1 − 1/3)`.
const ALL_FINER: f64 = 1.5;

/// The fit near its end: residuals and their scaled normal equations.
struct Curvature {
    residual: DVector<f64>,
    jacobian: DMatrix<f64>,
    /// Roots of the diagonal of `JᵀJ + Λ`, which the factor is scaled with.
    scale: Vec<f64>,
    factor: Cholesky<f64, Dyn>,
}

impl Curvature {
    /// `None` where the model has no answer or the normal equations are singular.
    fn of<M: Model>(problem: &M, values: &[f64], memory: &M::Memory) -> Option<Self> {
        let (rows, width) = (problem.residual_count(), values.len());
        let mut residual = DVector::zeros(rows);
        let mut jacobian = DMatrix::zeros(rows, width);
        let free = vec![true; width];
        let mut memory = memory.clone();
        problem.linearise(values, &free, &mut memory, (residual.as_mut_slice(), &mut jacobian)).ok()?;
        let mut normal = jacobian.tr_mul(&jacobian);
        for (k, parameter) in problem.parameters().iter().enumerate() {
            if let Some(prior) = parameter.prior {
                normal[(k, k)] += prior.std.powi(-2);
            }
        }
        // A value that moves nothing, such as the course of a drift at the rate zero, says nothing of the others.
        normal.set_diagonal(&normal.diagonal().map(|d| d.max(f64::MIN_POSITIVE)));
        let scale: Vec<f64> = (0..width).map(|k| normal[(k, k)].sqrt()).collect();
        let scaled = DMatrix::from_fn(width, width, |i, j| normal[(i, j)] / (scale[i] * scale[j]));
        Some(Self { residual, jacobian, scale, factor: scaled.cholesky()? })
    }

    /// Roots of the diagonal of `C`; infinite for a value that moves nothing.
    fn deviations(&self) -> Vec<f64> {
        let inverse = self.factor.inverse();
        let deviation = |(k, &scale): (usize, &f64)| {
            let moves = scale > f64::MIN_POSITIVE.sqrt();
            if moves { inverse[(k, k)].sqrt() / scale } else { f64::INFINITY }
        };
        self.scale.iter().enumerate().map(deviation).collect()
    }

    /// `C Jᵀδ`, by which the values follow a change `δ` of the residuals.
    fn follow(&self, change: &DVector<f64>) -> Vec<f64> {
        let pull = self.jacobian.tr_mul(change);
        let scaled = DVector::from_fn(self.scale.len(), |k, _| pull[k] / self.scale[k]);
        self.factor.solve(&scaled).iter().zip(&self.scale).map(|(value, scale)| value / scale).collect()
    }
}

/// Standard deviations of fitted values from the curvature of the fit and its priors; NaN where it is singular.
pub(crate) fn deviations<M: Model>(problem: &M, found: &Fit, memory: &M::Memory) -> Vec<f64> {
    by_curvature(found, Curvature::of(problem, &found.values, memory).as_ref())
}

/// The same where the curvature is known.
fn by_curvature(found: &Fit, curvature: Option<&Curvature>) -> Vec<f64> {
    let by_noise = |curvature: &Curvature| {
        let inflation = (found.cost / curvature.residual.len() as f64).max(1.0).sqrt();
        curvature.deviations().iter().map(|std| std * inflation).collect()
    };
    curvature.map_or_else(|| vec![f64::NAN; found.values.len()], by_noise)
}

impl Study<'_> {
    /// Standard deviations of the values of a fitted model from the noise and the priors; NaN where the normal equations are singular.
    pub(crate) fn deviations(&self, fitted: &Fitted) -> Vec<f64> {
        by_curvature(&fitted.fit, self.curvature(fitted).as_ref())
    }

    /// A model with the deviations of its values, which may be known already.
    pub(crate) fn with_deviations(&self, model: &Explained) -> Explained {
        let mut told = model.clone();
        if told.fitted.deviation.is_empty() {
            told.fitted.deviation = self.deviations(&model.fitted);
        }
        told
    }

    /// Tells the deviations of a model's values with what the phase grid bends. Nothing is counted for that where no run can have a finer
    /// grid, or where the model has no answer there.
    pub(crate) fn doubt_values(&self, model: &mut Explained) {
        let curvature = self.curvature(&model.fitted);
        let mut spread = by_curvature(&model.fitted.fit, curvature.as_ref());
        let bent = curvature.and_then(|curvature| self.bent(&model.fitted, &curvature));
        for (std, bent) in spread.iter_mut().zip(bent.unwrap_or_default()) {
            *std = std.hypot(bent);
        }
        model.fitted.deviation = spread;
    }

    /// A model with these deviations.
    pub(crate) fn doubted(&self, model: &Explained) -> Explained {
        let mut doubted = model.clone();
        self.doubt_values(&mut doubted);
        doubted
    }

    /// Whether what an effect of a model has brought is nothing within these deviations, all of it.
    pub(crate) fn is_nothing(&self, model: &Explained, place: usize) -> bool {
        let doubted = self.doubted(model);
        let within = |unknown: &Unknown| {
            let deviation = doubted.deviation(unknown.quantity);
            let value = model.fitted.setting.get(unknown.quantity);
            value.is_some_and(|value| value.abs() <= HALF_INTERVAL95 * deviation)
        };
        let own = model.own(place);
        !own.is_empty() && own.iter().all(within)
    }

    fn curvature(&self, Fitted { setting, unknowns, memory, fit, .. }: &Fitted) -> Option<Curvature> {
        Curvature::of(&self.training_problem(setting.clone(), unknowns, memory), &fit.values, memory)
    }

    /// How far the phase grid bends each of the unknowns.
    fn bent(&self, fitted: &Fitted, curvature: &Curvature) -> Option<Vec<f64>> {
        let Fitted { setting, unknowns, memory, fit, .. } = fitted;
        let finer = self.refined().ok()??;
        let fine = finer.training_problem(setting.clone(), unknowns, memory);
        let mut residual = DVector::zeros(fine.residual_count());
        fine.residual(&fit.values, &mut memory.clone(), residual.as_mut_slice()).ok()?;
        let bent = curvature.follow(&(residual - &curvature.residual));
        Some(bent.into_iter().map(|value| ALL_FINER * value.abs()).collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use frettrace_identify::{NoSolution, Parameter, Prior, Status};

    /// `r = y − A x` with `A = [1 0; 1 1; 0 2]`, and a prior of unit deviation for the second value; further values move nothing.
    struct Straight(Vec<Parameter>);

    impl Model for Straight {
        type Memory = ();

        fn parameters(&self) -> &[Parameter] {
            &self.0
        }

        fn residual_count(&self) -> usize {
            3
        }

        fn memory(&self) {}

        fn residual(&self, x: &[f64], _memory: &mut (), residual: &mut [f64]) -> Result<(), NoSolution> {
            residual.copy_from_slice(&[-x[0], -x[0] - x[1], -2.0 * x[1]]);
            Ok(())
        }

        fn linearise(
            &self,
            x: &[f64],
            _free: &[bool],
            memory: &mut (),
            (residual, jacobian): (&mut [f64], &mut DMatrix<f64>),
        ) -> Result<(), NoSolution> {
            jacobian.fill(0.0);
            jacobian.columns_mut(0, 2).copy_from(&DMatrix::from_row_slice(
                3,
                2,
                &[-1.0, 0.0, -1.0, -1.0, 0.0, -2.0],
            ));
            self.residual(x, memory, residual)
        }
    }

    /// `AᵀA + Λ = [2 1; 1 6]` has the inverse `[6 −1; −1 2]/11`; χ² of 12 in three residuals doubles its roots. Residuals that change by
    /// `(1, 0, 0)` pull with `(−1, 0)`.
    #[test]
    fn values_are_as_uncertain_as_normal_equations_say() -> Result<(), NoSolution> {
        let second = Parameter::declared("second", "1", Prior { mean: 0.0, std: 1.0 });
        let first = Parameter { prior: None, ..second.clone() };
        let problem = Straight(vec![first, second]);
        let found = Fit {
            values: vec![0.0; 2],
            cost: 12.0,
            data_cost: 12.0,
            iterations: 0,
            status: Status::Converged,
            free: vec![true; 2],
            at_bound: vec![false; 2],
        };
        let near = |found: &[f64], expected: [f64; 2]| {
            for (found, expected) in found.iter().zip(expected) {
                assert!((found - expected).abs() < 1e-14, "{found} instead of {expected}");
            }
        };
        near(
            &deviations(&problem, &found, &()),
            [2.0 * (6.0_f64 / 11.0).sqrt(), 2.0 * (2.0_f64 / 11.0).sqrt()],
        );
        let curvature = Curvature::of(&problem, &found.values, &()).ok_or(NoSolution)?;
        let follow = |curvature: &Curvature| curvature.follow(&DVector::from_vec(vec![1.0, 0.0, 0.0]));
        near(&follow(&curvature), [-6.0 / 11.0, 1.0 / 11.0]);
        let idle = Parameter { prior: None, ..problem.0[1].clone() };
        let with_idle = Straight([&problem.0[..], &[idle]].concat());
        let curvature = Curvature::of(&with_idle, &[0.0; 3], &()).ok_or(NoSolution)?;
        near(&curvature.deviations()[..2], [(6.0_f64 / 11.0).sqrt(), (2.0_f64 / 11.0).sqrt()]);
        assert_eq!(curvature.deviations()[2], f64::INFINITY);
        assert_eq!(follow(&curvature)[2], 0.0);
        Ok(())
    }
}
