//! Everything that is compared, as one least-squares problem: lines of the accelerations (or what of them no force of a second
//! support explains), then bins of the forces recovered of runs that are not periodic.

use super::aperiodic::Aperiodic;
use frettrace_explain::support::SupportForce;
use frettrace_explain::{AccelerationFit, Fitted, Study, Unknown};
use frettrace_forward::accelerations::Quantity;
use frettrace_identify::{Model, NoSolution, Parameter};
use nalgebra::DMatrix;

/// What is compared beside plain lines.
#[derive(Clone, Copy, Default)]
pub(super) struct Beside<'a> {
    /// What the force of a second support takes.
    pub(super) support: Option<&'a SupportForce>,
    /// Runs that are not periodic.
    pub(super) aperiodic: Option<&'a Aperiodic>,
}

/// The training runs as a least-squares problem around a fit.
pub(super) struct Problem<'a> {
    pub(super) accelerations: AccelerationFit<'a>,
    quantities: Vec<Quantity>,
    aperiodic: Option<&'a Aperiodic>,
}

impl<'a> Problem<'a> {
    pub(super) fn new(
        study: &'a Study<'_>,
        fitted: &Fitted,
        (unknowns, beside): (&[Unknown], Beside<'a>),
    ) -> Self {
        let (setting, runs) = (fitted.setting.clone(), study.training.clone());
        let warm = fitted.memory.clone();
        Self {
            accelerations: AccelerationFit::new(&study.model, setting, unknowns, runs, warm)
                .beside(beside.support),
            quantities: unknowns.iter().map(|u| u.quantity).collect(),
            aperiodic: beside.aperiodic,
        }
    }

    /// Residuals of each run: the periodic ones, then the others.
    pub(super) fn sizes(&self) -> Vec<usize> {
        let mut sizes = self.accelerations.sizes();
        sizes.extend(self.aperiodic.map(Aperiodic::sizes).unwrap_or_default());
        sizes
    }

    /// A change of the whitened prediction of the lines as a change of the residuals.
    pub(super) fn change(&self, of_lines: Vec<f64>) -> Vec<f64> {
        let rest = self.accelerations.rest(DMatrix::from_column_slice(of_lines.len(), 1, &of_lines));
        let mut all = rest.as_slice().to_vec();
        all.resize(self.residual_count(), 0.0);
        all
    }
}

impl<'a> Model for Problem<'a> {
    type Memory = <AccelerationFit<'a> as Model>::Memory;

    fn parameters(&self) -> &[Parameter] {
        self.accelerations.parameters()
    }

    fn residual_count(&self) -> usize {
        self.sizes().iter().sum()
    }

    fn memory(&self) -> Self::Memory {
        self.accelerations.memory()
    }

    fn residual(
        &self,
        values: &[f64],
        memory: &mut Self::Memory,
        residual: &mut [f64],
    ) -> Result<(), NoSolution> {
        let (head, tail) = residual.split_at_mut(self.accelerations.residual_count());
        self.accelerations.residual(values, memory, head)?;
        match self.aperiodic {
            Some(aperiodic) => aperiodic.residual(&self.accelerations.at(values), tail),
            None => Ok(()),
        }
    }

    fn linearise(
        &self,
        values: &[f64],
        free: &[bool],
        memory: &mut Self::Memory,
        (residual, jacobian): (&mut [f64], &mut DMatrix<f64>),
    ) -> Result<(), NoSolution> {
        let count = self.accelerations.residual_count();
        let (head, tail) = residual.split_at_mut(count);
        let mut columns = DMatrix::zeros(count, values.len());
        self.accelerations.linearise(values, free, memory, (head, &mut columns))?;
        jacobian.rows_mut(0, count).copy_from(&columns);
        let Some(aperiodic) = self.aperiodic else { return Ok(()) };
        let setting = self.accelerations.at(values);
        aperiodic.residual(&setting, tail)?;
        for j in (0..values.len()).filter(|j| free[*j]) {
            let of = (self.quantities[j], &self.parameters()[j]);
            let column = aperiodic.derivative((&setting, tail), of)?;
            jacobian.view_mut((count, j), (tail.len(), 1)).copy_from_slice(&column);
        }
        Ok(())
    }
}
