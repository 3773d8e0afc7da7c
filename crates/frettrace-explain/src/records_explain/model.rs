//! The record's model for the fit: weighted force residuals of all runs with derivatives.

use super::drive::{Shift, first_counted, forces, tangents};
use super::{RecordRun, RecordSetting};
use crate::contact_fit::LANES;
use frettrace_identify::{Model, NoSolution, Parameter};
use nalgebra::DMatrix;
use rayon::prelude::*;

/// Runs with the deviation of every sample.
#[derive(Clone, Debug)]
pub(super) struct Weighted {
    pub run: RecordRun,
    /// First sample that counts.
    pub first: usize,
    /// Standard deviation of measured minus predicted force of a perfect model (N), one a counted sample.
    pub deviation: Vec<f64>,
}

impl Weighted {
    pub fn new(run: RecordRun, std: f64) -> Self {
        let first = first_counted(&run.history.slip).min(run.history.len().saturating_sub(1));
        let deviation = vec![std; run.history.len() - first];
        Self { run, first, deviation }
    }

    pub fn counted(&self) -> usize {
        self.deviation.len()
    }

    /// Every `stride`-th sample.
    pub fn thinned(&self, most: usize) -> Self {
        let stride = self.run.history.len().div_ceil(most).max(1);
        let old = &self.run.history;
        let pick = |x: &[f64]| x.iter().step_by(stride).copied().collect::<Vec<_>>();
        let mut history = old.clone();
        history.time = pick(&old.time);
        history.slip = pick(&old.slip);
        history.velocity = pick(&old.velocity);
        history.acceleration = old.acceleration.as_deref().map(pick);
        history.normal = pick(&old.normal);
        history.force = pick(&old.force);
        history.draws = Vec::new();
        let first = self.first.div_ceil(stride).min(history.len().saturating_sub(1));
        let deviation: Vec<f64> = (first..history.len())
            .map(|k| self.deviation[(k * stride - self.first).min(self.deviation.len() - 1)])
            .collect();
        Self { run: RecordRun { history, ..self.run.clone() }, first, deviation }
    }

    /// Measured minus predicted force of the counted samples (N).
    pub fn residual(&self, setting: &RecordSetting) -> Vec<f64> {
        let predicted = forces(setting, &setting.values(), &self.run, None);
        (self.first..predicted.len()).map(|k| self.run.history.force[k] - predicted[k]).collect()
    }

    /// Adds to the deviations what the noise of the slip does to the prediction.
    pub fn add_motion_noise(&mut self, setting: &RecordSetting) {
        let draws = &self.run.history.draws;
        if draws.is_empty() {
            return;
        }
        let values = setting.values();
        let plain = forces(setting, &values, &self.run, None);
        let mut sum = vec![0.0; self.counted()];
        for draw in draws {
            let shift = Shift { slip: &draw.slip, velocity: &draw.velocity };
            let moved = forces(setting, &values, &self.run, Some(shift));
            for (k, s) in sum.iter_mut().enumerate() {
                *s += (moved[k + self.first] - plain[k + self.first]).powi(2) / draws.len() as f64;
            }
        }
        let mean = sum.iter().sum::<f64>() / sum.len().max(1) as f64;
        for (k, deviation) in self.deviation.iter_mut().enumerate() {
            let window = &sum[k.saturating_sub(3)..(k + 4).min(sum.len())];
            let local = window.iter().sum::<f64>() / window.len() as f64;
            // A tenth of the mean: twelve draws may spare a sample by chance.
            *deviation = (deviation.powi(2) + local.max(0.1 * mean)).sqrt();
        }
    }
}

/// A setting on weighted runs.
pub(super) struct RecordModel<'a> {
    setting: &'a RecordSetting,
    runs: &'a [Weighted],
    parameters: Vec<Parameter>,
}

impl<'a> RecordModel<'a> {
    pub fn new(setting: &'a RecordSetting, runs: &'a [Weighted]) -> Self {
        let parameters = setting.unknowns.iter().map(|u| u.parameter.clone()).collect();
        Self { setting, runs, parameters }
    }

    /// First row of each run.
    fn rows(&self) -> Vec<usize> {
        let mut next = 0;
        self.runs
            .iter()
            .map(|run| {
                next += run.counted();
                next - run.counted()
            })
            .collect()
    }
}

impl Model for RecordModel<'_> {
    type Memory = ();

    fn parameters(&self) -> &[Parameter] {
        &self.parameters
    }

    fn residual_count(&self) -> usize {
        self.runs.iter().map(Weighted::counted).sum()
    }

    fn memory(&self) {}

    fn residual(&self, values: &[f64], _memory: &mut (), residual: &mut [f64]) -> Result<(), NoSolution> {
        let found: Vec<Vec<f64>> =
            self.runs.par_iter().map(|w| forces(self.setting, values, &w.run, None)).collect();
        for ((weighted, predicted), row) in self.runs.iter().zip(&found).zip(self.rows()) {
            for (k, deviation) in weighted.deviation.iter().enumerate() {
                let sample = k + weighted.first;
                residual[row + k] = (predicted[sample] - weighted.run.history.force[sample]) / deviation;
            }
        }
        if residual.iter().all(|r| r.is_finite()) { Ok(()) } else { Err(NoSolution) }
    }

    fn linearise(
        &self,
        values: &[f64],
        _free: &[bool],
        memory: &mut (),
        (residual, jacobian): (&mut [f64], &mut DMatrix<f64>),
    ) -> Result<(), NoSolution> {
        self.residual(values, memory, residual)?;
        let rows = self.rows();
        for block in 0..values.len().div_ceil(LANES) {
            let found: Vec<_> =
                self.runs.par_iter().map(|w| tangents(self.setting, values, &w.run, block)).collect();
            let lanes = LANES.min(values.len() - LANES * block);
            for ((weighted, forces), row) in self.runs.iter().zip(&found).zip(&rows) {
                for (k, deviation) in weighted.deviation.iter().enumerate() {
                    let slopes = &forces[k + weighted.first].slopes;
                    for lane in 0..lanes {
                        let slope = slopes[lane] / deviation;
                        jacobian[(row + k, LANES * block + lane)] =
                            if slope.is_finite() { slope } else { 0.0 };
                    }
                }
            }
        }
        Ok(())
    }
}
