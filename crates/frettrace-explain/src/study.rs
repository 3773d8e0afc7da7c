//! The study: split, fits, errors.

use crate::case::Scales;
use crate::deviation::deviations;
use crate::left::LeftLines;
use crate::search::Explained;
use crate::series_fit::{SeriesContact, asks_the_clock};
use crate::split::{Split, by_level};
use crate::start;
use crate::support::SupportForce;
use crate::{AccelerationFit, Case, RunRecord, Unknown};
use frettrace_forward::accelerations::{
    AccelerationError, AccelerationModel, Memory, Prediction, Quantity, RunLines, SensorSetting, Setting,
};
use frettrace_friction::effects::{Hook, ModifiedLaw};
use frettrace_identify::{Fit, FitSettings, IdentifyError, fit_with_memory};
use num_complex::Complex64;
use std::sync::Arc;

/// Why nothing can be explained.
#[derive(Debug, Clone, thiserror::Error)]
#[non_exhaustive]
pub enum ExplainError {
    /// The model cannot be evaluated.
    #[error(transparent)]
    Model(#[from] AccelerationError),
    /// The model cannot be fitted.
    #[error(transparent)]
    Fit(#[from] IdentifyError),
    /// Too few runs are periodic.
    #[error("{periodic} of {runs} runs are periodic, at least one is needed; record steady vibration")]
    NothingPeriodic {
        /// Periodic runs.
        periodic: usize,
        /// All runs.
        runs: usize,
    },
    /// No run is periodic, and what was recovered of the contact is noise for the most part.
    #[error(
        "none of {runs} runs is periodic, and less than half of the force recovered of the contact follows its motion: noise drowns it; record steady vibration, or with quieter accelerometers"
    )]
    ContactDrowned {
        /// All runs.
        runs: usize,
    },
    /// No run is periodic, and the contact of none could be recovered.
    #[error(
        "none of {runs} runs is periodic, and the contact of none could be recovered; record steady vibration with three sensors or more"
    )]
    NothingRecovered {
        /// All runs.
        runs: usize,
    },
}

/// Periods of the excitation for which a law with partial slip, whose steps are many times as dear as others, is marched
/// along a run that is not periodic.
const PARTIAL_SLIP_PERIODS: f64 = 8.0;

/// Fewest training runs that are fitted where others have no answer yet.
const LEAST_LEFT: usize = 2;

/// A case with its split and its model.
#[derive(Clone)]
pub struct Study<'a> {
    /// The case.
    pub case: &'a Case,
    /// The acceleration-level model of all runs.
    pub model: AccelerationModel,
    /// Runs that are fitted.
    pub training: Vec<usize>,
    /// Runs that nothing is fitted to.
    pub held_out: Vec<usize>,
    /// Sizes of the motion in the contact.
    pub scales: Scales,
    /// Runs that are not periodic, with their indices.
    pub(crate) series: Vec<(usize, Arc<SeriesContact>)>,
    /// What the force of a declared second support takes, once it is known how the declared model answers it.
    pub(crate) support: Option<Arc<SupportForce>>,
}

/// A model fitted to the training runs.
#[derive(Clone)]
pub struct Fitted {
    /// Its values.
    pub setting: Setting,
    /// What was free.
    pub unknowns: Vec<Unknown>,
    /// χ² with priors, χ² of the data, status.
    pub fit: Fit,
    /// Solutions near it.
    pub memory: Memory,
    /// Standard deviations of the values, from the curvature.
    pub deviation: Vec<f64>,
}

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

impl<'a> Study<'a> {
    /// Splits the runs, recovers the contact and chooses the start.
    ///
    /// # Errors
    /// [`ExplainError`] where no run is periodic or the rig cannot be modelled.
    pub fn new(case: &'a Case, split: Split) -> Result<(Self, Setting), ExplainError> {
        let periodic: Vec<usize> = (0..case.records.len()).filter(|&k| case.records[k].periodic).collect();
        if periodic.is_empty() {
            return Err(ExplainError::NothingPeriodic { periodic: 0, runs: case.records.len() });
        }
        let held_out = split.held_out(&by_level(case, &periodic));
        let training: Vec<usize> = periodic.into_iter().filter(|k| !held_out.contains(k)).collect();
        let lines = case.records.iter().map(|r| model_lines(case, r)).collect();
        let mut model = AccelerationModel::new(case.rig.clone(), lines)?;
        let blank = case.setting(ModifiedLaw::dahl(1.0, 1.0));
        let histories = start::histories(case, &model, &blank, &training)?;
        let worked = start::worked(case, &model, &blank, &held_out)?;
        model.runs.iter_mut().zip(&worked).for_each(|(run, worked)| run.worked = *worked);
        let law = start::law(case.law, &histories);
        let scales = start::scales(case, &histories);
        let series = case.records.iter().enumerate().filter(|(_, record)| !record.periodic);
        let series = series.filter_map(|(run, record)| {
            let series = record.series.as_ref()?;
            let most = if law.get(Hook::Breakaway).is_some() {
                (PARTIAL_SLIP_PERIODS * scales.period / series.dt).ceil() as usize
            } else {
                usize::MAX
            };
            let circumstance = model.runs[run].circumstance();
            let contact = SeriesContact::new(series, circumstance, (case.law.is_static(), most))?;
            Some((run, Arc::new(contact)))
        });
        let series = series.collect();
        Ok((Self { case, model, training, held_out, scales, series, support: None }, case.setting(law)))
    }

    /// The least-squares problem of the training runs around `setting`.
    pub(crate) fn training_problem(
        &self,
        setting: Setting,
        unknowns: &[Unknown],
        warm: &Memory,
    ) -> AccelerationFit<'_> {
        let sizes = [self.scales.preload, self.scales.velocity];
        let sized: Vec<Unknown> = unknowns.iter().map(|unknown| unknown.sized(&setting.law, sizes)).collect();
        AccelerationFit::new(&self.model, setting, &sized, self.training.clone(), warm.clone())
            .beside(self.support.as_deref())
    }

    /// Fits `unknowns` around `setting` to the training runs.
    ///
    /// # Errors
    /// [`ExplainError::Fit`] where the model has no solution at the start.
    pub fn fit(
        &self,
        mut setting: Setting,
        unknowns: &[Unknown],
        warm: &Memory,
        most: usize,
    ) -> Result<Fitted, ExplainError> {
        // The stiffness of a rigid contact is no part of the model.
        let idle = |u: &Unknown| setting.holds_rigidly() && u.quantity == Quantity::Law(Hook::Sigma0);
        let unknowns: Vec<Unknown> = unknowns.iter().filter(|u| !idle(u)).cloned().collect();
        let settings = FitSettings {
            max_iterations: most,
            relative_tolerance: 3e-4,
            absolute_tolerance: 0.3,
            ..FitSettings::default()
        };
        let mut problem = self.training_problem(setting.clone(), &unknowns, warm);
        let mut memory = warm.clone();
        self.begin(&setting, &self.training, &mut memory);
        let mut found = fit_with_memory(&problem, &problem.start(), &settings, &mut memory);
        if matches!(found, Err(IdentifyError::NoStart { .. })) {
            if let Err(unsolved) = self.model.approach(&setting, &self.training, &mut memory) {
                // A run whose balance does not close at the start joins once the others have improved the law.
                let others = self.without_run(&unsolved).ok_or(unsolved)?;
                let nearer = others.fit(setting, &unknowns, warm, most)?;
                (setting, memory) = (nearer.setting, nearer.memory);
                problem = self.training_problem(setting.clone(), &unknowns, &memory);
                self.begin(&setting, &self.training, &mut memory);
            }
            found = fit_with_memory(&problem, &problem.start(), &settings, &mut memory);
        }
        let found = found?;
        let setting = problem.at(&found.values);
        // Warm starts for what comes next; a run that does not balance keeps none.
        let _ = self.model.predict(&setting, &self.training, &mut memory);
        let deviation = deviations(&problem, &found, &memory);
        Ok(Fitted { setting, unknowns, fit: found, memory, deviation })
    }

    /// The same study without the training run that has no answer; `None` where too few would be left to tell a law.
    fn without_run(&self, unsolved: &AccelerationError) -> Option<Self> {
        let AccelerationError::NotBalanced { run, .. } = unsolved else { return None };
        let training: Vec<usize> = self.training.iter().copied().filter(|other| other != run).collect();
        (LEAST_LEFT..self.training.len()).contains(&training.len()).then(|| Self { training, ..self.clone() })
    }

    /// The same study on a finer phase grid with twice the lines of contact force: kinks that a law with play, stops or a
    /// steep rise makes need them. `None` where no run can have more.
    ///
    /// # Errors
    /// [`ExplainError::Model`] where the grid cannot carry the lines.
    pub fn refined(&self) -> Result<Option<Self>, ExplainError> {
        let mut runs = self.model.runs.clone();
        let mut finer = false;
        for run in runs.iter_mut().filter(|run| 2 * run.contact_order <= FINEST_LINES) {
            run.contact_order *= 2;
            run.samples = (2 * run.samples).min(FINEST_SAMPLES);
            finer = true;
        }
        let model = self.model.with_runs(runs)?;
        Ok(finer.then(|| self.of_model(model)))
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

    /// Counts the error of the phase grid among the deviations of the lines. Twice the lines of force divide it by about three, so
    /// that this grid leaves half of what parts its predictions from those of the `coarser` one.
    pub fn doubt_grid(&mut self, coarser: &Self, fitted: &Fitted) {
        let all = self.all_runs();
        let [before, now] = [coarser, &*self].map(|study| study.predictions(fitted, &all));
        for ((&run, before), now) in all.iter().zip(before).zip(now) {
            let (Some(before), Some(now)) = (before, now) else { continue };
            let known = &self.case.records[run].lines.deviation;
            let lines = before.iter().zip(&now).zip(known).zip(&mut self.model.runs[run].deviation);
            for (((before, now), known), deviation) in lines {
                for (h, std) in deviation.iter_mut().enumerate() {
                    *std = known[h].hypot((before[h] - now[h]).norm() * GRID_LEFT);
                }
            }
        }
    }

    /// A model fitted further to all runs, those held out among them: `None` where it is not complete on them.
    pub(crate) fn jointly(&self, model: &Explained) -> Option<Explained> {
        let mut all = self.clone();
        all.training.append(&mut all.held_out);
        all.training.sort_unstable();
        all.polished(model).ok().filter(Explained::complete)
    }

    /// Runs that are fitted and runs that nothing is fitted to.
    pub(crate) fn all_runs(&self) -> Vec<usize> {
        self.training.iter().chain(&self.held_out).copied().collect()
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
        }
    }

    /// χ² of the law on the runs that are not periodic. They were recovered with what is declared: where a model has another
    /// structure, excitation or sensor, they tell nothing of its law, and count as a law's would that is right.
    pub(crate) fn series_cost(&self, setting: &Setting) -> f64 {
        if as_declared(setting) {
            self.series.iter().map(|(_, contact)| contact.cost(&setting.law)).sum()
        } else {
            self.series.iter().map(|(_, contact)| contact.count() as f64).sum()
        }
    }

    /// Number of real residuals of the training runs.
    #[must_use]
    pub fn residual_count(&self) -> usize {
        self.residuals_of(&self.training)
    }

    pub(crate) fn residuals_of(&self, runs: &[usize]) -> usize {
        let of_run = |&run: &usize| {
            let lines = &self.model.runs[run];
            let all = 2 * lines.acceleration.len() * lines.acceleration.first().map_or(0, Vec::len);
            all - self.support.as_ref().map_or(0, |support| support.taken(run))
        };
        runs.iter().map(of_run).sum()
    }

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
        let mut memory = fitted.memory.clone();
        self.begin(&fitted.setting, selected, &mut memory);
        selected
            .iter()
            .map(|&run| {
                let mut found = self.model.predict(&fitted.setting, &[run], &mut memory);
                // Nothing was fitted to such a run, so that there is no solution of it to start from.
                if found.is_err() && !self.training.contains(&run) {
                    found = self.model.approach(&fitted.setting, &[run], &mut memory);
                }
                let found = found.ok().and_then(|p| p.into_iter().next())?;
                Some(match &self.support {
                    Some(support) => support.completed(run, &self.model.runs[run], found),
                    None => found,
                })
            })
            .collect()
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
        let chi_squared = |(&run, prediction): (&usize, &Option<Prediction>)| {
            let lines = &self.model.runs[run];
            let measured = lines.acceleration.iter().flatten().zip(lines.deviation.iter().flatten());
            prediction.as_ref().map_or(f64::INFINITY, |predicted| {
                let pairs = measured.zip(predicted.iter().flatten());
                pairs.map(|((at, std), predicted)| ((at - predicted) / std).norm_sqr()).sum()
            })
        };
        let predictions = self.predictions(fitted, runs);
        LeftLines {
            chi_squared: runs.iter().zip(&predictions).map(chi_squared).sum(),
            count: self.residuals_of(runs) as f64,
        }
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

/// Lines of the excitation that the force of a rigid contact gets at least, …
const RIGID_LINES: usize = 64;
/// … and at most.
const MOST_RIGID_LINES: usize = 256;

/// Lines of contact force from which none are added: the factor of a balance takes the cube of them.
const FINEST_LINES: usize = 1536;
/// Lets lines, the mean first, count to a share of themselves and to a tenth of that share of the loudest, beside their deviations.
pub fn soften(deviations: &mut [f64], lines: &[Complex64], share: f64) {
    let peak = lines.iter().skip(1).map(|a| a.norm()).fold(0.0, f64::max);
    for (deviation, line) in deviations.iter_mut().zip(lines) {
        *deviation = deviation.hypot(share * line.norm()).hypot(0.1 * share * peak);
    }
}

/// Share of the difference between the predictions of two grids, one twice as fine as the other, that the finer one leaves.
const GRID_LEFT: f64 = 0.5;
/// χ² per residual by which a grid that cuts the contact's force short may miss a run: a tenth of the variance.
const CUT_SHORT: f64 = 0.1;
/// Most samples of the phase grid.
const FINEST_SAMPLES: usize = 8192;

/// Lines of a run for the model. The force of a contact that is set-valued at rest has kinks however little of them the
/// sensors show: it gets twice the lines of one that yields.
fn model_lines(case: &Case, record: &RunRecord) -> RunLines {
    let mut lines = record.lines.clone();
    if case.law.is_static() {
        let most = (MOST_RIGID_LINES * record.subharmonic).max(lines.contact_order);
        let least = RIGID_LINES * record.subharmonic;
        lines.contact_order = (2 * lines.contact_order).max(least).min(most);
        lines.samples = (8 * lines.contact_order).next_power_of_two().clamp(lines.samples, 4096);
    }
    lines
}

/// Whether nothing but the law differs from what is declared.
pub(crate) fn as_declared(setting: &Setting) -> bool {
    let scales = [setting.frequency_scale, setting.damping_scale];
    let changed = [setting.clamp_compliance, setting.drift, setting.shift]
        .iter()
        .chain(&scales)
        .any(|value| *value != 0.0);
    let sound = setting.sensors.iter().all(|sensor| *sensor == SensorSetting::default());
    let driven = setting.base.is_some() || asks_the_clock(&setting.law);
    setting.ports.is_empty() && setting.mass.is_none() && sound && !changed && !driven
}

/// Replaces or adds unknowns by their quantity.
pub(crate) fn merge(unknowns: &[Unknown], added: &[Unknown]) -> Vec<Unknown> {
    let replaced = |q: Quantity| added.iter().any(|a| a.quantity == q);
    unknowns.iter().filter(|u| !replaced(u.quantity)).chain(added).cloned().collect()
}
