//! What a fitted model leaves: errors of runs and of their sensors, χ² of their lines.

use super::predicted::By;
use super::{Fitted, Study};
use crate::left::LeftLines;
use frettrace_forward::accelerations::{Memory, Prediction, Setting};

/// Error over noise of a run that repeats after several periods of the excitation from which a model has another motion in it.
const UNANSWERED: f64 = 10.0;

/// Error of some runs.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RunError {
    /// Sum over samples and sensors of (measured − predicted)².
    pub error: f64,
    /// The same for a perfect model.
    pub floor: f64,
    /// Sum over samples and sensors of measured².
    pub power: f64,
    /// Number of samples in all sensors.
    pub count: f64,
}

impl RunError {
    /// Relative RMS error.
    #[must_use]
    pub fn relative(&self) -> f64 {
        (self.error / self.power).sqrt()
    }

    /// Relative RMS of the noise.
    #[must_use]
    pub fn relative_floor(&self) -> f64 {
        (self.floor / self.power).sqrt()
    }

    /// Error over floor.
    #[must_use]
    pub fn ratio(&self) -> f64 {
        (self.error / self.floor).sqrt()
    }
}

impl Study<'_> {
    /// χ² of the runs held out: how well a model foretells them.
    pub(crate) fn foretold(&self, fitted: &Fitted) -> f64 {
        if self.held_out.is_empty() {
            return 0.0;
        }
        self.residuals_of(&self.held_out) as f64 * self.error(fitted, &self.held_out).ratio().powi(2)
    }

    /// Predictions of the selected runs, with the force of a declared second support where it leaves least; `None` where a run's
    /// balance does not close.
    #[must_use]
    pub fn predictions(&self, fitted: &Fitted, selected: &[usize]) -> Vec<Option<Prediction>> {
        self.predictions_from(fitted, selected, &mut fitted.memory.clone())
    }

    /// The same from solutions near it on these grids, and to them.
    pub(super) fn predictions_from(
        &self,
        fitted: &Fitted,
        selected: &[usize],
        memory: &mut Memory,
    ) -> Vec<Option<Prediction>> {
        let by = |run: usize| By {
            run,
            grids: self.model.on_grids(),
            setting: fitted.setting.clone(),
            // Nothing was fitted to such a run, so that there is no solution of it to start from.
            approached: !self.training.contains(&run),
        };
        let mut known: Vec<Option<Option<Prediction>>> =
            selected.iter().map(|&run| fitted.predicted.of(&by(run))).collect();
        let new: Vec<usize> = (0..known.len()).filter(|&k| known[k].is_none()).collect();
        if !new.is_empty() {
            let runs: Vec<usize> = new.iter().map(|&k| selected[k]).collect();
            for (&k, found) in new.iter().zip(self.predicted(&fitted.setting, &runs, memory)) {
                fitted.predicted.keep(by(selected[k]), found.clone());
                known[k] = Some(found);
            }
        }
        let found = selected.iter().zip(known);
        found.map(|(&run, found)| found.flatten().map(|found| self.completed(run, found))).collect()
    }

    /// A prediction with the force of a declared second support where it leaves least.
    fn completed(&self, run: usize, found: Prediction) -> Prediction {
        match &self.support {
            Some(support) => support.completed(run, &self.model.runs[run], found),
            None => found,
        }
    }

    /// The same of the model alone, from nothing but its memory.
    fn predicted(
        &self,
        setting: &Setting,
        selected: &[usize],
        memory: &mut Memory,
    ) -> Vec<Option<Prediction>> {
        self.begin(setting, selected, memory);
        let Ok(found) = self.model.predict_each(setting, selected, memory) else {
            return vec![None; selected.len()];
        };
        let mut found: Vec<Option<Prediction>> = found.into_iter().map(Result::ok).collect();
        let far = |k: &usize| found[*k].is_none() && !self.training.contains(&selected[*k]);
        let far: Vec<usize> = (0..found.len()).filter(far).collect();
        if far.is_empty() {
            return found;
        }
        let runs: Vec<usize> = far.iter().map(|&k| selected[k]).collect();
        if let Ok(approached) = self.model.approach_each(setting, &runs, memory) {
            far.iter().zip(approached).for_each(|(&k, one)| found[k] = one.ok());
        }
        found
    }

    /// Runs whose motion the balance of a model does not have: none at all, or none near one that repeats after several periods of the
    /// excitation.
    pub(crate) fn unanswered(&self, fitted: &Fitted) -> Vec<usize> {
        let runs = self.all_runs();
        let found = self.predictions(fitted, &runs);
        let divided = |run: usize| self.case.records[run].subharmonic > 1;
        let missed = |run: usize| self.error(fitted, &[run]).ratio() > UNANSWERED;
        let is_one = |(run, found): (usize, Option<Prediction>)| {
            (found.is_none() || divided(run) && missed(run)).then_some(run)
        };
        runs.into_iter().zip(found).filter_map(is_one).collect()
    }

    /// Error of a run, sensor by sensor, with the faults of its channels in the model; a run that cannot be predicted is missed
    /// entirely.
    #[must_use]
    pub fn sensor_errors(&self, run: usize, prediction: Option<&Prediction>) -> Vec<RunError> {
        let record = &self.case.records[run];
        let samples = record.samples as f64;
        let taken = self.support.as_ref().map(|support| support.noise_taken(run, &self.model.runs[run]));
        (0..record.power.len())
            .map(|s| {
                let missed = prediction.map_or(record.power[s], |p| {
                    record.clipped_error(s, &p[s]).unwrap_or_else(|| record.line_error(s, &p[s]))
                });
                let taken = taken.as_ref().map_or(0.0, |taken| taken[s]);
                RunError {
                    error: missed * samples,
                    floor: (record.noise[s].powi(2) - taken).max(0.0) * samples,
                    power: record.power[s] * samples,
                    count: samples,
                }
            })
            .collect()
    }

    /// Error of the selected runs as they were read: the faults of the channels are no part of the model.
    #[must_use]
    pub fn error_as_read(&self, fitted: &Fitted, selected: &[usize]) -> RunError {
        let mut sum = self.error(fitted, selected);
        let predictions = self.predictions(fitted, selected);
        for (&run, prediction) in selected.iter().zip(&predictions) {
            let record = &self.case.records[run];
            let samples = record.samples as f64;
            sum.error += record.excess.iter().sum::<f64>() * samples;
            let Some(prediction) = prediction else { continue };
            for (s, predicted) in prediction.iter().enumerate() {
                let pair = record.unclipped_error(s, predicted).zip(record.clipped_error(s, predicted));
                sum.error += pair.map_or(0.0, |(free, clipped)| free - clipped) * samples;
            }
        }
        sum
    }

    /// Improvement of `after` over `before` on the selected runs, in standard errors; infinite where `before` has no answer.
    ///
    /// With `δ` the whitened difference of both predictions, `Δχ²` scatters by `2|δ|` under the noise of the lines, the more so
    /// by what `after` leaves above it.
    #[must_use]
    pub fn improvement(&self, before: &Fitted, after: &Fitted, selected: &[usize]) -> f64 {
        let pairs = self.predictions(before, selected).into_iter().zip(self.predictions(after, selected));
        let (mut gain, mut moved, mut left, mut count) = (0.0, 0.0, 0.0, 0.0);
        for (&run, pair) in selected.iter().zip(pairs) {
            let (Some(old), Some(new)) = pair else {
                return if pair.1.is_some() { f64::INFINITY } else { 0.0 };
            };
            let lines = &self.model.runs[run];
            for (s, deviation) in lines.deviation.iter().enumerate() {
                for (h, std) in deviation.iter().enumerate().skip(1) {
                    let measured = lines.acceleration[s][h];
                    let remains = ((measured - new[s][h]) / std).norm_sqr();
                    gain += ((measured - old[s][h]) / std).norm_sqr() - remains;
                    moved += ((old[s][h] - new[s][h]) / std).norm_sqr();
                    left += remains;
                    count += 2.0;
                }
            }
        }
        let inflation = (left / f64::max(count, 1.0)).max(1.0);
        gain / (2.0 * (moved * inflation).sqrt()).max(f64::MIN_POSITIVE)
    }

    /// What a model leaves in the training runs at one sensor, and at the others together; runs that it cannot predict are left out.
    pub(crate) fn left_at(&self, fitted: &Fitted, sensor: usize) -> [LeftLines; 2] {
        let mut left = [LeftLines::default(); 2];
        for (&run, prediction) in self.training.iter().zip(self.predictions(fitted, &self.training)) {
            let Some(predicted) = prediction else { continue };
            let lines = &self.model.runs[run];
            for (s, deviation) in lines.deviation.iter().enumerate() {
                let left = &mut left[usize::from(s != sensor)];
                for (h, std) in deviation.iter().enumerate().skip(1) {
                    left.chi_squared += ((lines.acceleration[s][h] - predicted[s][h]) / std).norm_sqr();
                    left.count += 2.0;
                }
            }
        }
        left
    }

    /// What a model leaves on the lines of some runs; without bound where it cannot predict one.
    pub(crate) fn left_in(&self, fitted: &Fitted, runs: &[usize]) -> LeftLines {
        LeftLines {
            chi_squared: self.chi_squared(fitted, runs).iter().sum(),
            count: self.residuals_of(runs) as f64,
        }
    }

    /// χ² of the lines of each of some runs; without bound where a model cannot predict one.
    pub(super) fn chi_squared(&self, fitted: &Fitted, runs: &[usize]) -> Vec<f64> {
        self.chi_squared_of(runs, &self.predictions(fitted, runs))
    }

    /// The same with other values, from motions near those that they make; without bound where that finds none.
    pub(super) fn chi_squared_near(&self, setting: &Setting, runs: &[usize], near: &Memory) -> Vec<f64> {
        let found = self.model.predict_each(setting, runs, &mut near.clone());
        let Ok(found) = found else { return vec![f64::INFINITY; runs.len()] };
        let found = runs.iter().zip(found);
        let found: Vec<Option<Prediction>> =
            found.map(|(&run, found)| Some(self.completed(run, found.ok()?))).collect();
        self.chi_squared_of(runs, &found)
    }

    fn chi_squared_of(&self, runs: &[usize], predictions: &[Option<Prediction>]) -> Vec<f64> {
        let of_run = |(&run, prediction): (&usize, &Option<Prediction>)| {
            let lines = &self.model.runs[run];
            let measured = lines.acceleration.iter().flatten().zip(lines.deviation.iter().flatten());
            prediction.as_ref().map_or(f64::INFINITY, |predicted| {
                let pairs = measured.zip(predicted.iter().flatten());
                pairs.map(|((at, std), predicted)| ((at - predicted) / std).norm_sqr()).sum()
            })
        };
        runs.iter().zip(predictions).map(of_run).collect()
    }

    /// Error over noise of the runs held out; 1 where there are none.
    pub(crate) fn held_out_ratio(&self, fitted: &Fitted) -> f64 {
        if self.held_out.is_empty() { 1.0 } else { self.error(fitted, &self.held_out).ratio() }
    }

    /// Error of the selected runs together.
    #[must_use]
    pub fn error(&self, fitted: &Fitted, selected: &[usize]) -> RunError {
        let predictions = self.predictions(fitted, selected);
        let all = selected.iter().zip(&predictions).flat_map(|(&run, p)| self.sensor_errors(run, p.as_ref()));
        all.fold(RunError::default(), |sum, e| RunError {
            error: sum.error + e.error,
            floor: sum.floor + e.floor,
            power: sum.power + e.power,
            count: sum.count + e.count,
        })
    }
}
