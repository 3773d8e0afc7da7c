//! The greedy search: one effect after the other, as long as residual, evidence and held-out runs ask for it.

mod begin;
mod rank;

use super::candidates::candidates;
use super::evidence::{effective_count, improvement};
use super::floor::{Floor, floor, scatter};
use super::model::{RecordModel, Weighted};
use super::{Follows, RecordCase, RecordScales, RecordSetting, RecordUnknown, floor_source, follows};
use crate::{Place, Verdict};
use frettrace_identify::contact::FloorSource;
use frettrace_identify::{Fit, FitSettings, Identified, IdentifyError, IdentifySettings, fit, identify};
use rank::named_effect;
use rayon::prelude::*;

/// Most effects named together.
const MOST_EFFECTS: usize = 5;
/// Evidence from which a preference is strong (Kass and Raftery 1995).
const STRONG: f64 = 10.0;
/// Standard errors by which held-out runs must improve.
const IMPROVED: f64 = 2.5;
/// A residual within this factor of the floor is complete.
const COMPLETE: f64 = 1.05;
/// Samples of a run that a search uses: more only repeat what their neighbours say.
const SEARCHED: usize = 1500;
/// First effects whose stories are told to the end.
const BEGUN: usize = 3;

/// A setting fitted to the training runs.
#[derive(Clone, Debug)]
pub struct RecordFit {
    /// The setting with its values.
    pub setting: RecordSetting,
    /// What may be said of the values.
    pub identified: Option<Identified>,
    /// Measured minus predicted force of the training runs (N), from the first sample that counts.
    pub training: Vec<Vec<f64>>,
    /// The same of the held-out runs.
    pub held_out: Vec<Vec<f64>>,
}

/// A named effect.
#[derive(Clone, Debug)]
pub struct RecordEffect {
    /// Its id.
    pub id: &'static str,
    /// Where it lives.
    pub place: Place,
    /// Probability against its rivals and against nothing.
    pub probability: f64,
    /// What it brought.
    pub unknowns: Vec<RecordUnknown>,
    /// Ids the data cannot tell from it.
    pub indistinguishable: Vec<&'static str>,
    /// The experiment that would.
    pub experiment: &'static str,
}

/// A candidate that was tried beside the declared law alone.
#[derive(Clone, Copy, Debug)]
pub struct RecordTried {
    /// Its id.
    pub id: &'static str,
    /// Relative RMS error with it on the training runs.
    pub error: f64,
    /// Difference of the criterion to the model without it, positive for it.
    pub evidence: f64,
}

/// What came of it.
#[derive(Clone, Debug)]
pub struct RecordOutcome {
    /// The verdict.
    pub verdict: Verdict,
    /// Effects in the order they were found.
    pub effects: Vec<RecordEffect>,
    /// Where something is missing.
    pub place: Option<Place>,
    /// The declared law.
    pub baseline: RecordFit,
    /// The law with the effects in it.
    pub model: RecordFit,
    /// Candidates beside the declared law, best first.
    pub tried: Vec<RecordTried>,
    /// Force error of a perfect model (N): training and held-out runs.
    pub floor: [f64; 2],
    /// Where the floor comes from.
    pub source: FloorSource,
    /// What the last residual follows, most first.
    pub follows: Vec<Follows>,
    /// What a reader must know.
    pub notes: Vec<String>,
}

/// Data of a search and its measures.
struct Search<'a> {
    case: &'a RecordCase,
    scales: RecordScales,
    training: Vec<Weighted>,
    held_out: Vec<Weighted>,
    thinned: Vec<Weighted>,
    /// Largest mean square, in units of the floor, of a complete model.
    limit: f64,
}

/// A setting tried on the thinned runs.
#[derive(Clone)]
struct Trial {
    setting: RecordSetting,
    /// Mean square in units of the noise.
    square: f64,
    effective: f64,
    at_bound: Vec<bool>,
}

/// Explains a contact record.
///
/// # Errors
/// [`IdentifyError`] where the declared law cannot be fitted at all.
pub fn explain_record(case: &RecordCase) -> Result<RecordOutcome, IdentifyError> {
    let repeated = floor(&case.training);
    let source = floor_source(&case.training, repeated.as_ref());
    let mut search = Search::new(case, repeated, source);
    let baseline = search.baseline()?;
    if source != FloorSource::Repeats {
        // Repeats hold the noise of the motion already.
        search
            .training
            .iter_mut()
            .chain(&mut search.held_out)
            .for_each(|w| w.add_motion_noise(&baseline.setting));
        search.thin();
    }
    let baseline = search.settled(&baseline.setting)?;
    let declared = Story::new(search.judged(&baseline));
    Ok(search.outcome(search.best_story(declared), source))
}

/// What was found so far.
#[derive(Clone)]
struct Story {
    baseline: RecordFit,
    model: RecordFit,
    effects: Vec<RecordEffect>,
    tried: Vec<RecordTried>,
    notes: Vec<String>,
}

impl Story {
    fn new(baseline: RecordFit) -> Self {
        Self { model: baseline.clone(), baseline, effects: Vec::new(), tried: Vec::new(), notes: Vec::new() }
    }
}

impl Story {
    /// Says once that held-out runs spoke against an effect.
    fn refuse(&mut self, id: &'static str, gain: f64) {
        let said = format!("{id} lowers the residual of the fitted runs");
        if !self.notes.iter().any(|note| note.starts_with(&said)) {
            self.notes
                .push(format!("{said} (evidence {gain:.0}) but not that of the held-out ones: not named"));
        }
    }
}

impl<'a> Search<'a> {
    fn new(case: &'a RecordCase, repeated: Option<Floor>, source: FloorSource) -> Self {
        let common = repeated.map_or_else(|| scatter(&case.training), |floor| floor.std);
        let weigh = |run: &super::RecordRun| {
            let std = if source == FloorSource::Given { run.stated.unwrap_or(common) } else { common };
            Weighted::new(run.clone(), std.max(f64::MIN_POSITIVE))
        };
        let count = repeated.filter(|_| source == FloorSource::Repeats).map_or(f64::INFINITY, |f| f.count);
        // A measured floor is itself uncertain by 1/√(2·count); 1.645 of that is its upper end.
        let limit = COMPLETE * (1.0 + 1.645 / (2.0 * count).sqrt());
        let mut search = Self {
            case,
            scales: RecordScales::of(&case.training),
            training: case.training.iter().map(weigh).collect(),
            held_out: case.held_out.iter().map(weigh).collect(),
            thinned: Vec::new(),
            limit: limit * limit,
        };
        search.thin();
        search
    }

    fn thin(&mut self) {
        self.thinned = self.training.iter().map(|w| w.thinned(SEARCHED)).collect();
    }

    fn trial(&self, setting: &RecordSetting, found: &Fit) -> Trial {
        let setting = setting.with_values(&found.values);
        let residuals: Vec<Vec<f64>> =
            self.thinned.iter().map(|w| whitened(w, &w.residual(&setting))).collect();
        let parts: Vec<&[f64]> = residuals.iter().map(Vec::as_slice).collect();
        Trial {
            square: mean_square(&residuals),
            effective: effective_count(&parts),
            at_bound: found.at_bound.clone(),
            setting,
        }
    }

    fn fitted(&self, setting: &RecordSetting, most: usize) -> Result<Trial, IdentifyError> {
        let settings =
            FitSettings { max_iterations: most, relative_tolerance: 1e-6, ..FitSettings::default() };
        let found = fit(&RecordModel::new(setting, &self.thinned), &setting.values(), &settings)?;
        Ok(self.trial(setting, &found))
    }

    fn settled(&self, setting: &RecordSetting) -> Result<Trial, IdentifyError> {
        self.fitted(setting, 60)
    }

    /// Residuals of all runs, and what may be said of the values.
    fn judged(&self, trial: &Trial) -> RecordFit {
        let setting = &trial.setting;
        let model = RecordModel::new(setting, &self.thinned);
        let settings = FitSettings { max_iterations: 1, ..FitSettings::default() };
        let judge = IdentifySettings {
            fit: settings.clone(),
            profiled: vec![false; setting.unknowns.len()],
            effective_count: Some(trial.effective),
            ..IdentifySettings::default()
        };
        let identified =
            fit(&model, &setting.values(), &settings).and_then(|found| identify(&model, &found, &judge));
        let of = |runs: &[Weighted]| runs.par_iter().map(|w| w.residual(setting)).collect();
        RecordFit {
            setting: setting.clone(),
            identified: identified.ok(),
            training: of(&self.training),
            held_out: of(&self.held_out),
        }
    }

    /// Mean square of training residuals in units of the floor.
    fn square(&self, residuals: &[Vec<f64>]) -> f64 {
        let whitened: Vec<_> = self.training.iter().zip(residuals).map(|(w, r)| whitened(w, r)).collect();
        mean_square(&whitened)
    }

    /// The story whose model the data speak for most, among those that begin with each of the best first effects: the
    /// best single effect is not always one of the best two.
    fn best_story(&self, mut declared: Story) -> Story {
        if self.square(&declared.model.training) <= self.limit {
            return declared;
        }
        let begun = self.round(&mut declared, BEGUN);
        let told: Vec<Story> = begun.into_iter().map(|story| self.told_on(story)).collect();
        let Some(least) = told.iter().map(|story| self.square(&story.model.training)).reduce(f64::min) else {
            return declared;
        };
        let effective = told
            .iter()
            .map(|story| {
                let parts: Vec<&[f64]> = story.model.training.iter().map(Vec::as_slice).collect();
                effective_count(&parts)
            })
            .fold(f64::INFINITY, f64::min);
        let criterion = |story: &Story| {
            let square = self.square(&story.model.training).max(1.0);
            effective * (square / least.max(1.0)).ln()
                + story.model.setting.unknowns.len() as f64 * effective.ln()
        };
        told.into_iter().min_by(|a, b| criterion(a).total_cmp(&criterion(b))).unwrap_or(declared)
    }

    /// One effect after the other.
    fn told_on(&self, mut story: Story) -> Story {
        while story.effects.len() < MOST_EFFECTS && self.square(&story.model.training) > self.limit {
            let Some(next) = self.round(&mut story, 1).pop() else { break };
            story = next;
        }
        story
    }

    /// One round: the story with each of the best effects that held-out runs confirm, at most so many.
    fn round(&self, story: &mut Story, most: usize) -> Vec<Story> {
        let Ok(base) = self.fitted(&story.model.setting, 20) else { return Vec::new() };
        let named: Vec<_> = story.effects.iter().map(|e| e.id).collect();
        let mut list = candidates(self.case, &base.setting, &self.scales);
        list.retain(|c| !named.contains(&c.id) && self.case.without.iter().all(|id| id != c.id));
        let ranked = self.ranked(&base, &list);
        if story.tried.is_empty() {
            story.tried = ranked.iter().map(|(c, _, trial, gain)| self.told(c.id, trial, *gain)).collect();
        }
        let mut next = Vec::new();
        for (place, (candidate, form, trial, gain)) in ranked.iter().enumerate() {
            if *gain < STRONG || next.len() == most {
                break;
            }
            let added = self.judged(trial);
            if !self.confirmed(&story.model, &added) {
                story.refuse(candidate.id, *gain);
                continue;
            }
            let others = ranked.iter().enumerate().filter(|(k, _)| *k > place);
            let rivals: Vec<_> = others.map(|(_, (c, _, _, g))| (c.id, gain - g)).collect();
            let mut longer = story.clone();
            longer.notes.retain(|note| !note.starts_with(candidate.id));
            longer.effects.push(named_effect(candidate, form, &added, &rivals));
            longer.model = added;
            next.push(longer);
        }
        next
    }

    fn told(&self, id: &'static str, trial: &Trial, evidence: f64) -> RecordTried {
        let fitted = &self.thinned;
        let (mut miss, mut size) = (0.0, 0.0);
        for weighted in fitted {
            let residual = weighted.residual(&trial.setting);
            miss += residual.iter().map(|r| r * r).sum::<f64>();
            size += weighted.run.history.force[weighted.first..].iter().map(|f| f * f).sum::<f64>();
        }
        RecordTried { id, error: (miss / f64::max(size, f64::MIN_POSITIVE)).sqrt(), evidence }
    }

    /// Whether held-out runs agree; without any, the evidence stands alone.
    fn confirmed(&self, before: &RecordFit, after: &RecordFit) -> bool {
        self.held_out.is_empty() || improvement(&before.held_out, &after.held_out) > IMPROVED
    }

    fn outcome(&self, story: Story, source: FloorSource) -> RecordOutcome {
        let complete = self.square(&story.model.training) <= self.limit;
        let verdict = match (complete, story.effects.is_empty()) {
            (true, true) => Verdict::NothingMissing,
            (true, false) => Verdict::Explained,
            _ => Verdict::Unexplained,
        };
        let place = match (verdict, story.effects.first()) {
            (Verdict::NothingMissing, _) => None,
            (_, Some(effect)) => Some(effect.place),
            (_, None) => Some(Place::Contact),
        };
        let follows = if complete { Vec::new() } else { self.follows(&story.model) };
        RecordOutcome {
            verdict,
            place,
            floor: [&self.training, &self.held_out].map(|runs| root_mean_square(runs)),
            source,
            follows,
            effects: story.effects,
            baseline: story.baseline,
            model: story.model,
            tried: story.tried,
            notes: story.notes,
        }
    }

    /// Filters found on the fitted runs, judged on the others where there are any.
    fn follows(&self, model: &RecordFit) -> Vec<Follows> {
        let fitted = (&self.case.training[..], &model.training[..]);
        let others = (&self.case.held_out[..], &model.held_out[..]);
        follows(fitted, if self.held_out.is_empty() { fitted } else { others })
    }
}

fn whitened(weighted: &Weighted, residual: &[f64]) -> Vec<f64> {
    residual.iter().zip(&weighted.deviation).map(|(r, d)| r / d).collect()
}

fn mean_square(parts: &[Vec<f64>]) -> f64 {
    let (sum, count) = parts.iter().flatten().fold((0.0, 0.0), |(sum, count), r| (sum + r * r, count + 1.0));
    sum / f64::max(count, 1.0)
}

/// Root mean square of the deviations of all samples (N).
fn root_mean_square(runs: &[Weighted]) -> f64 {
    let parts: Vec<Vec<f64>> = runs.iter().map(|w| w.deviation.clone()).collect();
    mean_square(&parts).sqrt()
}
