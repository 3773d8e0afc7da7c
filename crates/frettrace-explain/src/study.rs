//! The study: split and fits.

use crate::case::Scales;
use crate::search::Explained;
use crate::series_fit::{SeriesContact, asks_the_clock};
use crate::split::{Split, by_level};
use crate::start;
use crate::support::SupportForce;
use crate::{AccelerationFit, Case, Unknown};
use frettrace_forward::accelerations::{
    AccelerationError, AccelerationModel, Memory, Quantity, SensorSetting, Setting,
};
use frettrace_friction::effects::{Hook, ModifiedLaw};
use frettrace_identify::{Fit, FitSettings, IdentifyError, fit_with_memory};
use num_complex::Complex64;
use rayon::prelude::*;
use std::sync::Arc;

mod creep;
mod errors;
mod grids;
mod predicted;

pub(crate) use creep::breaks_away;
pub use errors::RunError;
pub(crate) use grids::FINEST_DOUBLINGS;
use grids::model_lines;
pub(crate) use predicted::Predicted;

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
    /// The model on the finest grid, where predictions are corrected to those on it.
    pub(crate) fine: Option<Arc<AccelerationModel>>,
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
    /// Standard deviations of the values, from the curvature: of a model that came out of a search, and none of those on its way.
    pub deviation: Vec<f64>,
    /// What it predicts, as far as that was asked.
    pub(crate) predicted: Predicted,
}

impl<'a> Study<'a> {
    /// Splits the runs, recovers the contact and chooses the start.
    ///
    /// # Errors
    /// [`ExplainError`] where no run is periodic or the rig cannot be modelled.
    pub fn new(case: &'a Case, split: Split) -> Result<(Self, Setting), ExplainError> {
        let taken = |run: &usize| case.records[*run].periodic && !case.aside.contains(run);
        let periodic: Vec<usize> = (0..case.records.len()).filter(taken).collect();
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
        Ok((
            Self { case, model, training, held_out, scales, series, support: None, fine: None },
            case.setting(law),
        ))
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
        setting: Setting,
        unknowns: &[Unknown],
        warm: &Memory,
        most: usize,
    ) -> Result<Fitted, ExplainError> {
        let mut fitted = self.fitted(setting, unknowns, warm, most)?;
        fitted.deviation = self.deviations(&fitted);
        Ok(fitted)
    }

    /// The same without the deviations of the values, which cost as much as a step and are asked of few models.
    pub(crate) fn fitted(
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
                let nearer = others.fitted(setting, &unknowns, warm, most)?;
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
        let (deviation, predicted) = (Vec::new(), Predicted::default());
        Ok(Fitted { setting, unknowns, fit: found, memory, deviation, predicted })
    }

    /// The same study without the training run that has no answer; `None` where too few would be left to tell a law.
    fn without_run(&self, unsolved: &AccelerationError) -> Option<Self> {
        let AccelerationError::NotBalanced { run, .. } = unsolved else { return None };
        let training: Vec<usize> = self.training.iter().copied().filter(|other| other != run).collect();
        (LEAST_LEFT..self.training.len()).contains(&training.len()).then(|| Self { training, ..self.clone() })
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

    /// χ² of the law on the runs that are not periodic. They were recovered with what is declared: where a model has another
    /// structure, excitation or sensor, they tell nothing of its law, and count as the declared one's did, which is no more than a right one's.
    pub(crate) fn series_cost(&self, setting: &Setting) -> f64 {
        if as_declared(setting) {
            self.series.iter().map(|(_, contact)| contact.cost(&setting.law)).sum()
        } else {
            self.series.iter().map(|(_, contact)| contact.silent_cost()).sum()
        }
    }

    /// From here on the runs that are not periodic count for a model which they do not judge as they do for the declared `law`.
    pub(crate) fn silence(&mut self, law: &ModifiedLaw<f64>) {
        self.series.par_iter_mut().for_each(|(_, contact)| Arc::make_mut(contact).silence(law));
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
}

/// Lets lines, the mean first, count to a share of themselves and to a tenth of that share of the loudest, beside their deviations.
pub fn soften(deviations: &mut [f64], lines: &[Complex64], share: f64) {
    let peak = lines.iter().skip(1).map(|a| a.norm()).fold(0.0, f64::max);
    for (deviation, line) in deviations.iter_mut().zip(lines) {
        *deviation = deviation.hypot(share * line.norm()).hypot(0.1 * share * peak);
    }
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
