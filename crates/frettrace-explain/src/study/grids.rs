//! Phase grids of a study: as fine as the contact's force asks for.

use super::{ExplainError, Fitted, Study};
use crate::search::{Explained, NEAR};
use crate::{Case, RunRecord};
use frettrace_forward::accelerations::{AccelerationModel, Memory, RunLines};
use std::sync::Arc;

/// Lines of the excitation that the force of a rigid contact gets at least, …
const RIGID_LINES: usize = 64;
/// … and at most.
const MOST_RIGID_LINES: usize = 256;

/// Lines of contact force from which none are added: the factor of a balance takes the cube of them.
const FINEST_LINES: usize = 1536;
/// Doublings of the lines of contact force to the grid that predictions are corrected to.
pub(crate) const FINEST_DOUBLINGS: u32 = 3;
/// By what twice the lines divide the error of a grid.
const DIVIDED: f64 = 3.0;
/// Share of the difference between the predictions of two grids, one twice as fine as the other, that the finer one leaves.
const GRID_LEFT: f64 = 1.0 / (DIVIDED - 1.0);
/// χ² per residual by which a grid that cuts the contact's force short may miss a run: a tenth of the variance.
const CUT_SHORT: f64 = 0.1;
/// Most samples of the phase grid.
const FINEST_SAMPLES: usize = 8192;

/// Lines of a run for the model. The force of a contact that is set-valued at rest has kinks however little of them the
/// sensors show: it gets twice the lines of one that yields.
pub(super) fn model_lines(case: &Case, record: &RunRecord) -> RunLines {
    let mut lines = record.lines.clone();
    if case.law.is_static() {
        let most = (MOST_RIGID_LINES * record.subharmonic).max(lines.contact_order);
        let least = RIGID_LINES * record.subharmonic;
        lines.contact_order = (2 * lines.contact_order).max(least).min(most);
        lines.samples = (8 * lines.contact_order).next_power_of_two().clamp(lines.samples, 4096);
    }
    lines
}

/// Whether the finest grids leave more than [`NEAR`] times the noise in every run: what its grid may be wrong by over the noise, and the doublings of
/// its lines that it may still get. Where the coarser grids have no balance nothing is known, and there is no run.
fn are_beyond_all(doubts: &[(f64, u32)]) -> bool {
    let left = |&(doubt, doublings): &(f64, u32)| doubt / DIVIDED.powi(doublings as i32);
    !doubts.is_empty() && doubts.iter().all(|run| left(run) > NEAR)
}

impl Study<'_> {
    /// The same study on a finer phase grid with twice the lines of contact force: kinks that a law with play, stops or a
    /// steep rise makes need them. `None` where no run can have more, or the predictions are those of a finer grid already.
    ///
    /// # Errors
    /// [`ExplainError::Model`] where the grid cannot carry the lines.
    pub fn refined(&self) -> Result<Option<Self>, ExplainError> {
        let mut runs = self.model.runs.clone();
        let coarse: Vec<usize> = (0..runs.len()).filter(|run| self.doublings(*run) > 0).collect();
        if coarse.is_empty() {
            return Ok(None);
        }
        for run in coarse {
            let run = &mut runs[run];
            run.contact_order *= 2;
            run.samples = (2 * run.samples).min(FINEST_SAMPLES);
        }
        Ok(Some(self.of_model(self.model.with_runs(runs)?)))
    }

    /// The same with twice the lines of contact force in the runs alone whose predictions on such a grid differ by more than a tenth
    /// of the variance of their lines; `None` where there is no such run.
    ///
    /// # Errors
    /// [`ExplainError::Model`] where the grid cannot carry the lines.
    pub fn resolved(&self, fitted: &Fitted) -> Result<Option<Self>, ExplainError> {
        let Some(finer) = self.refined()? else { return Ok(None) };
        let all = self.all_runs();
        let [coarse, fine] = [self, &finer].map(|study| study.predictions(fitted, &all));
        let mut runs = self.model.runs.clone();
        let mut cut_short = false;
        for ((&run, coarse), fine) in all.iter().zip(&coarse).zip(&fine) {
            let (Some(coarse), Some(fine)) = (coarse, fine) else { continue };
            let lines = coarse.iter().flatten().zip(fine.iter().flatten());
            let deviations = runs[run].deviation.iter().flatten();
            let parts = lines.zip(deviations).map(|((coarse, fine), std)| ((coarse - fine) / std).norm_sqr());
            if parts.sum::<f64>() > CUT_SHORT * self.residuals_of(&[run]) as f64 {
                runs[run] = finer.model.runs[run].clone();
                cut_short = true;
            }
        }
        let model = self.model.with_runs(runs)?;
        Ok(cut_short.then(|| self.of_model(model)))
    }

    /// The model on a grid with so many doublings of the lines of contact force, or as many lines as a balance gets.
    ///
    /// # Errors
    /// [`ExplainError::Model`] where the grid cannot carry the lines.
    pub(crate) fn finer_by(&self, doublings: u32) -> Result<AccelerationModel, ExplainError> {
        let mut finest = self.plain()?;
        for _ in 0..doublings {
            let Some(finer) = finest.refined()? else { break };
            finest = finer;
        }
        Ok(finest.model)
    }

    /// The same study without corrections.
    fn plain(&self) -> Result<Self, ExplainError> {
        // On the same grid, so that what was predicted on it is known.
        if self.fine.is_none() {
            return Ok(self.clone());
        }
        Ok(self.of_model(self.model.with_runs(self.model.runs.clone())?))
    }

    /// The same study whose predictions are corrected to those on a `fine` grid, as they are at a fitted model ([`AccelerationModel::corrected`]), from what
    /// is known of its solutions there, and to them. A run that has no balance on one of the grids keeps its own.
    ///
    /// # Errors
    /// [`ExplainError::Model`] where the grid cannot carry the lines.
    pub(crate) fn corrected(
        &self,
        fine: &Arc<AccelerationModel>,
        (fitted, known): (&Fitted, &mut Memory),
    ) -> Result<Self, ExplainError> {
        let (plain, finest) = (self.plain()?, self.of_model((**fine).clone()));
        let all = self.all_runs();
        let fine_lines = finest.predictions_from(fitted, &all, known);
        let lines = plain.predictions(fitted, &all);
        let mut corrections = vec![None; plain.model.runs.len()];
        for ((&run, fine), lines) in all.iter().zip(fine_lines).zip(lines) {
            let (Some(mut fine), Some(lines)) = (fine, lines) else { continue };
            fine.iter_mut().flatten().zip(lines.iter().flatten()).for_each(|(fine, line)| *fine -= line);
            corrections[run] = Some(fine);
        }
        let model = plain.model.corrected(corrections)?;
        Ok(Self { fine: Some(fine.clone()), ..self.of_model(model) })
    }

    /// Counts the error of the phase grid among the deviations of the lines. Twice the lines of force divide it by about three, so
    /// that a grid leaves half of what parts its predictions from those on one with half of its lines. The runs of which that is told: where the
    /// coarser grid has no balance, nothing is.
    ///
    /// # Errors
    /// [`ExplainError::Model`] where the coarser grid cannot carry the lines.
    pub fn doubt_grid(&mut self, fitted: &Fitted) -> Result<Vec<usize>, ExplainError> {
        let all = self.all_runs();
        let mut told = Vec::new();
        let finest = match &self.fine {
            Some(fine) => self.of_model((**fine).clone()),
            None => self.clone(),
        };
        let coarser = finest.halved()?;
        let [before, now] = [&coarser, &finest].map(|study| study.predictions(fitted, &all));
        for ((&run, before), now) in all.iter().zip(before).zip(now) {
            let (Some(before), Some(now)) = (before, now) else { continue };
            let known = &self.case.records[run].lines.deviation;
            let lines = before.iter().zip(&now).zip(known).zip(&mut self.model.runs[run].deviation);
            for (((before, now), known), deviation) in lines {
                for (h, std) in deviation.iter_mut().enumerate() {
                    *std = known[h].hypot((before[h] - now[h]).norm() * GRID_LEFT);
                }
            }
            told.push(run);
        }
        Ok(told)
    }

    /// Whether what a model leaves on the lines that it was fitted to is no more than their noise and what the phase grid may be wrong by; `None`
    /// where a coarser grid does not tell.
    pub(crate) fn within_doubt(&self, model: &Explained) -> Option<bool> {
        let mut doubted = self.clone();
        doubted.doubt_grid(&model.fitted).ok()?;
        Some(doubted.left_in(&model.fitted, &self.training).is_noise())
    }

    /// The same study, whose doubts are those of the finest grid.
    ///
    /// # Errors
    /// [`ExplainError::Model`] where the grid cannot carry the lines.
    pub(crate) fn by_finest(&self) -> Result<Self, ExplainError> {
        Ok(Self { fine: Some(Arc::new(self.finer_by(FINEST_DOUBLINGS)?)), ..self.clone() })
    }

    /// What the phase grid of each run may be wrong by, over the noise, in the root mean square of its lines; none where the coarser grid has
    /// no balance, which tells nothing.
    pub(crate) fn grid_doubts(&self, fitted: &Fitted) -> Vec<(usize, f64)> {
        let mut doubted = self.clone();
        let told = doubted.doubt_grid(fitted).unwrap_or_default();
        told.into_iter().map(|run| (run, doubted.doubt(run))).collect()
    }

    /// The same study with the error of its phase grid among the deviations of the lines, where what the finest grid that a balance gets may be wrong by is
    /// more than [`NEAR`] times the noise in every run: no law can be told in any of them.
    pub(crate) fn beyond_all_grids(&self, fitted: &Fitted) -> Option<Self> {
        let mut doubted = self.clone();
        let told = doubted.doubt_grid(fitted).ok()?;
        let doubts: Vec<_> = told.into_iter().map(|run| (doubted.doubt(run), self.doublings(run))).collect();
        are_beyond_all(&doubts).then_some(doubted)
    }

    /// By how much the deviations of a run's lines are beyond the noise, in units of it, in their root mean square.
    fn doubt(&self, run: usize) -> f64 {
        let known = self.case.records[run].lines.deviation.iter().flatten();
        let parts = self.model.runs[run].deviation.iter().flatten().zip(known);
        let (sum, count) = parts.fold((0.0, 0_usize), |(sum, count), (std, known)| {
            (sum + (std / known).powi(2) - 1.0, count + 1)
        });
        (sum / count.max(1) as f64).sqrt()
    }

    /// Doublings of the lines of contact force that a run may still get: none where the predictions are those of a finer grid already.
    fn doublings(&self, run: usize) -> u32 {
        let most = FINEST_LINES / self.model.runs[run].contact_order.max(1);
        if self.fine.is_some() { 0 } else { most.max(1).ilog2().min(FINEST_DOUBLINGS) }
    }

    /// The same study with half the lines of contact force in every run that keeps as many as were measured of it: a run that has the
    /// most lines that a balance gets is on the grid it was on before the others were refined.
    fn halved(&self) -> Result<Self, ExplainError> {
        let mut runs = self.model.runs.clone();
        for run in runs.iter_mut().filter(|run| run.contact_order / 2 >= run.order()) {
            run.contact_order /= 2;
            run.samples /= 2;
        }
        Ok(self.of_model(self.model.with_runs(runs)?))
    }

    fn of_model(&self, model: AccelerationModel) -> Self {
        Self {
            case: self.case,
            model,
            training: self.training.clone(),
            held_out: self.held_out.clone(),
            scales: self.scales,
            series: self.series.clone(),
            support: self.support.clone(),
            fine: None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::are_beyond_all;

    /// Three runs of a simulated rig whose rigid contact rings on 290 to 494 lines: the first two may get twice the lines, which leave a third of what
    /// their grids may be wrong by, and the last one none. With three doublings it would be resolved: 35.8/27 is near the noise.
    #[test]
    fn a_rig_is_beyond_all_grids_where_the_finest_resolves_no_run() {
        assert!(are_beyond_all(&[(28.5, 1), (33.9, 1), (35.8, 0)]));
        assert!(!are_beyond_all(&[(28.5, 1), (33.9, 1), (35.8, 3)]));
        assert!(!are_beyond_all(&[]));
    }
}
