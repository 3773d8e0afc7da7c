//! A law with free values against recovered runs, the errors of each at where they go with the law.

use super::run::{Open, OpenRun};
use crate::contact_fit::LANES;
use crate::fitting::to_rank;
use frettrace_friction::Gradient;
use frettrace_friction::effects::{Hook, ModifiedLaw};
use frettrace_identify::{Fit, IdentifyError, Model, NoSolution, Parameter, fit_with_memory};
use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

/// Residuals are, run by run, what the law leaves in the bins compared and the errors that go with it, all in standard deviations.
pub(super) struct OpenProblem<'a> {
    pub runs: &'a [OpenRun],
    pub law: ModifiedLaw<f64>,
    pub hooks: Vec<Hook>,
    pub parameters: Vec<Parameter>,
    /// Whether the directions of the errors stay those it begins with.
    pub held: bool,
}

impl OpenProblem<'_> {
    /// The law with values.
    pub fn at(&self, values: &[f64]) -> ModifiedLaw<f64> {
        let mut law = self.law;
        self.hooks.iter().zip(values).for_each(|(&hook, &value)| law.set(hook, value));
        law
    }

    /// Fits it in at most so many steps, from errors of the runs that go with a law near it.
    pub fn solve(&self, most: usize, memory: &mut Vec<Open>) -> Result<Fit, IdentifyError> {
        let start: Vec<f64> = self.hooks.iter().map(|h| self.law.get(*h).unwrap_or_default()).collect();
        let settings = to_rank(most);
        fit_with_memory(self, &start, &settings, memory)
    }

    /// Rows of each run, in their order.
    fn rows(&self) -> Vec<usize> {
        let mut next = 0;
        let of = |run: &OpenRun| {
            next += run.count() + run.errors();
            next - run.count() - run.errors()
        };
        self.runs.iter().map(of).collect()
    }
}

impl Model for OpenProblem<'_> {
    type Memory = Vec<Open>;

    fn parameters(&self) -> &[Parameter] {
        &self.parameters
    }

    fn residual_count(&self) -> usize {
        self.runs.iter().map(|run| run.count() + run.errors()).sum()
    }

    fn memory(&self) -> Vec<Open> {
        Vec::new()
    }

    fn residual(
        &self,
        values: &[f64],
        memory: &mut Vec<Open>,
        residual: &mut [f64],
    ) -> Result<(), NoSolution> {
        let law = self.at(values);
        if memory.len() != self.runs.len() {
            let begun: Option<Vec<Open>> = self.runs.par_iter().map(|run| run.begin(&law)).collect();
            *memory = begun.ok_or(NoSolution)?;
        }
        let left: Vec<DVector<f64>> = self
            .runs
            .par_iter()
            .zip(memory.par_iter_mut())
            .map(|(run, open)| run.settle(&law, open).0)
            .collect();
        for (((run, open), left), row) in self.runs.iter().zip(memory.iter()).zip(&left).zip(self.rows()) {
            residual[row..row + run.count()].copy_from_slice(left.as_slice());
            let errors = row + run.count()..row + run.count() + run.errors();
            residual[errors].copy_from_slice(open.xi.as_slice());
        }
        if residual.iter().all(|r| r.is_finite()) { Ok(()) } else { Err(NoSolution) }
    }

    fn linearise(
        &self,
        values: &[f64],
        free: &[bool],
        memory: &mut Vec<Open>,
        (residual, jacobian): (&mut [f64], &mut DMatrix<f64>),
    ) -> Result<(), NoSolution> {
        let law = self.at(values);
        if !self.held && memory.len() == self.runs.len() {
            let opened: Option<Vec<Open>> = self
                .runs
                .par_iter()
                .zip(memory.par_iter())
                .map(|(run, open)| run.open(&law, open.xi.clone()))
                .collect();
            *memory = opened.ok_or(NoSolution)?;
        }
        self.residual(values, memory, residual)?;
        let hooks: Vec<(usize, Hook)> =
            self.hooks.iter().copied().enumerate().filter(|(j, _)| free[*j]).collect();
        let rows = self.rows();
        for block in hooks.chunks(LANES) {
            let seeded = law.lift(|hook, value| match block.iter().position(|(_, own)| *own == hook) {
                Some(lane) => Gradient::variable(value, lane),
                None => Gradient::constant(value),
            });
            let slopes = |(run, open): (&OpenRun, &Open)| run.slopes(&seeded, block.len(), &open.xi);
            let found: Vec<Vec<DVector<f64>>> =
                self.runs.par_iter().zip(memory.par_iter()).map(slopes).collect();
            for (((run, open), slopes), &row) in self.runs.iter().zip(memory.iter()).zip(&found).zip(&rows) {
                for (slope, (column, _)) in slopes.iter().zip(block) {
                    let follows = open.follow(slope);
                    let whole = slope + &*open.directions * &follows;
                    let mut target = jacobian.view_mut((row, *column), (run.count() + run.errors(), 1));
                    target.rows_mut(0, run.count()).copy_from(&whole);
                    target.rows_mut(run.count(), run.errors()).copy_from(&follows);
                }
            }
        }
        let finite = residual.iter().chain(jacobian.iter()).all(|value| value.is_finite());
        if finite { Ok(()) } else { Err(NoSolution) }
    }
}
