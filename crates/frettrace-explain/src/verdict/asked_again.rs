//! What was found, asked again: on runs that nothing was fitted to, and without the name that was found.
//!
//! A model may follow the runs it was fitted to and miss others: the declared law was bent to what it lacks. Then those runs are
//! among the fitted ones and others are held out. A name may leave little, yet more than the noise: a mechanism that is there
//! leaves nothing. Then the search is made again without that name, and what explains better stands.

use super::choice::contained;
use super::outcome::Outcome;
use super::rules::is_followed;
use super::{CONTRADICTED, EVIDENCE, FORETOLD, Rival, Search, least_excess};
use crate::effects::ALL;
use crate::left::LeftLines;
use crate::search::{COMPLETE, Explained, NEAR, excess};
use crate::{Case, ExplainError, Fitted, Split, Study};

/// Times what a phase grid may be wrong by, or the noise, that a model may miss a run by where nothing but the grid is at fault.
const BY_GRID: f64 = 3.0;
/// Growth of the error from fitted runs to those held out from which what is lacking lies in these.
const OVERTAKEN: f64 = 2.0;
/// Error over noise from which a name leaves more than the noise in the runs it was fitted to.
pub(super) const LEFT: f64 = 1.005;

/// The declared model as it was fitted, before any effect is looked for.
#[derive(Clone)]
pub(super) struct Begun<'a> {
    search: Search<'a>,
    baseline: Explained,
    by_contacts: Vec<usize>,
}

/// A search that is over.
struct Found<'a> {
    /// What it began with.
    begun: Begun<'a>,
    search: Search<'a>,
    /// The declared model.
    baseline: Explained,
    /// The model that was come to.
    model: Explained,
}

/// What comes of a case, and the study that it came of.
pub(super) fn answer(case: &Case) -> Result<(Outcome, Study<'_>), ExplainError> {
    answer_from(case, Begun::new(case, Split::First)?)
}

/// The same from the declared model as it was fitted with the first split.
pub(super) fn answer_from<'a>(
    case: &'a Case,
    begun: Begun<'a>,
) -> Result<(Outcome, Study<'a>), ExplainError> {
    let without;
    let mut split = Split::First;
    let mut found = begun.searched(split)?;
    let mut missed = Vec::new();
    for next in [Split::Second, Split::One] {
        let again = found.contradicted() || split == Split::First && found.overtaken();
        if !again {
            break;
        }
        // A name may not be sought for what other values of the declared law do.
        if next == Split::One && found.is_of_one_law() {
            found.search.of_one_law = true;
            break;
        }
        split = next;
        missed.push(format!(
            "the model of the fitted runs missed the {} held out by {:.2} times the noise: these are among the fitted ones now, and others are held out",
            found.search.study.held_out.len(),
            found.held_out_ratio()
        ));
        let told = found.told();
        found = Found::by(case, split)?;
        found.search.told_by_others.extend(told);
    }
    if split == Split::First && found.is_ambiguous() {
        let ratio = found.held_out_ratio();
        if let Ok(other) = Found::by(case, Split::Second)
            && other.model.is_single()
            && other.held_out_ratio() <= ratio.min(FORETOLD)
        {
            missed.push(format!(
                "{} missed the runs held out by {ratio:.2} times the noise, and others follow the fitted ones as well: these are among the fitted ones now, and others are held out",
                ALL[found.model.effects[0]].id()
            ));
            (found, split) = (other, Split::Second);
        }
    }
    found = found.sharpened();
    if let Some(name) = found.doubtful() {
        let mut other = case.clone();
        other.without.push(name.to_owned());
        without = other;
        // Where nothing can be said without the name, it stands.
        if let Ok(other) = found.begun.clone().asking(&without).searched(split) {
            found = found.against(other);
        }
    }
    found.search.notes.extend(missed);
    let study = Study { case, ..found.search.study.clone() };
    Ok((found.search.outcome(found.baseline, found.model), study))
}

impl<'a> Begun<'a> {
    pub(super) fn new(case: &'a Case, split: Split) -> Result<Self, ExplainError> {
        let (study, setting) = Study::new(case, split)?;
        let mut search = Search::new(study);
        let declared = search.baseline(setting.clone())?;
        let mut baseline = search.beside_support(declared);
        if !baseline.complete() && (baseline.ratio < NEAR || baseline.fitted.setting.rigid) {
            let lacked = baseline.excess();
            baseline = search.further(baseline, lacked);
            search.coarse = None;
        }
        let mut told = baseline.complete() || search.is_beyond_all_grids(&baseline);
        let by_method = || search.within_method(&baseline) || search.foretells_within_grid(&baseline);
        let by_contacts = if told || by_method() { Vec::new() } else { search.told_by_contacts(&baseline) };
        told |= !by_contacts.is_empty();
        if !told && let Some(better) = search.restarted(&baseline) {
            baseline = better;
        }
        if !told
            && !baseline.complete()
            && search.study.support.is_none()
            && let Some(better) = search.by_loose_modes(&baseline, setting)
        {
            baseline = better;
        }
        // What a coarse grid bent to the fitted runs misses the others.
        if baseline.complete() && search.held_out_ratio(&baseline) > most_missed(&baseline) {
            let yields = !baseline.fitted.setting.rigid;
            let enough = |left: LeftLines| if yields { left.is_noise() } else { left.is_near_noise() };
            baseline = search.sharpened(baseline, enough, |_, one| one.complete());
        }
        search.study.silence(&baseline.fitted.setting.law);
        search.before = search.errors_as_read(&baseline);
        search.within_method = !baseline.complete()
            && (search.within_method(&baseline) || search.foretells_within_grid(&baseline));
        let baseline = search.study.with_deviations(&baseline);
        Ok(Self { search, baseline, by_contacts })
    }

    /// Runs that no balance answers with the law that their contacts show, which meets these, where the declared model follows all others.
    pub(super) fn told_by_contacts(&self) -> &[usize] {
        &self.by_contacts
    }

    /// Runs of which waveforms are predicted.
    pub(super) fn runs(&self) -> usize {
        self.search.study.all_runs().len()
    }

    /// Whether the declared model follows the runs that it was fitted to.
    pub(super) fn follows_fitted(&self) -> bool {
        self.baseline.complete()
    }

    /// Runs whose phase grid cuts the motion of a rigid contact short by far more than the noise, so that no law can be told in them: what the grid
    /// may be wrong by is more than [`NEAR`] times the noise of their lines.
    pub(super) fn unresolved(&self) -> Vec<usize> {
        let (study, fitted) = (&self.search.study, &self.baseline.fitted);
        let follows = self.baseline.complete() && self.search.held_out_ratio(&self.baseline) <= CONTRADICTED;
        if !fitted.setting.rigid || follows {
            return Vec::new();
        }
        unresolved(study, fitted)
    }

    /// Whether the finest grid resolves some runs.
    pub(super) fn are_resolved_by_the_finest(&self, runs: &[usize]) -> bool {
        let finest = self.search.study.by_finest();
        finest.is_ok_and(|finest| {
            !unresolved(&finest, &self.baseline.fitted).iter().any(|run| runs.contains(run))
        })
    }

    /// Whether a model of the other runs misses some runs by far more than their phase grid may be wrong by, with that model: they show what the
    /// others do not.
    pub(super) fn shows_more(&self, fitted: &Fitted, runs: &[usize]) -> bool {
        let study = &self.search.study;
        let doubts = study.grid_doubts(fitted);
        let misses =
            |&(run, doubt): &(usize, f64)| study.error(fitted, &[run]).ratio() > BY_GRID * doubt.max(1.0);
        doubts.iter().filter(|(run, _)| runs.contains(run)).any(misses)
    }

    /// The same where a case asks for other names: for a single one, in the place of a single one.
    fn asking(mut self, case: &'a Case) -> Self {
        self.search.study.case = case;
        self.search.most_effects = 1;
        self
    }

    fn searched(self, split: Split) -> Result<Found<'a>, ExplainError> {
        let begun = self.clone();
        let Self { mut search, mut baseline, .. } = self;
        let followed = baseline.complete() || search.within_method;
        // Where both other splits contradicted it, the declared model lacks something however little shows where it is fitted.
        let settled = followed && !search.series_open(&baseline) && split != Split::One;
        // So it does where no contact force closes the balance, however little of that shows among the noise of all samples.
        let done = settled && !search.is_open(&baseline);
        let mut model = if done { baseline.clone() } else { search.close(&baseline)? };
        // The values of a law and of a structure may be bent until the error is within the noise of all samples. What is named for what lines still
        // hold must take all of it, and help where nothing was fitted: lines hold more than the noise where a grid is coarse, too.
        if done && !baseline.left().is_noise() {
            let mut other = search.clone();
            let finer = other.sharpened(baseline.clone(), LeftLines::is_noise, |_, one| one.complete());
            if other.holds_more(&finer) {
                let named = other.close(&finer)?;
                if let Some(pair) = other.still_lacking(&finer, &named) {
                    search = other;
                    (baseline, model) = pair;
                    search.before = search.errors_as_read(&baseline);
                }
            }
        }
        if settled && model.effects.is_empty() {
            model = search.released(&model).unwrap_or(model);
        }
        if settled && model.effects.is_empty() && !search.strained {
            model = search.deviating(&model).unwrap_or(model);
        }
        if let Some(mut better) = search.rebased(&baseline, &model) {
            // One that misses the runs held out follows the others because it was bent to them.
            let follows = better.complete() && search.held_out_ratio(&better) <= CONTRADICTED;
            // Evidence is that over the declared model as it is now.
            let nearer = baseline.criterion - better.criterion;
            search.tried.iter_mut().filter(|t| t.error.is_finite()).for_each(|t| t.evidence -= nearer);
            if follows && !search.is_open(&better) {
                // Beside the declared model that has come to the same, a name that shows nothing of what it says is none.
                let lacking =
                    if search.shows_nothing(&model) { None } else { search.still_lacking(&better, &model) };
                match lacking {
                    Some(pair) => (better, model) = pair,
                    None => {
                        model = better.clone();
                        search.rivals.clear();
                    }
                }
            }
            baseline = better;
            search.before = search.errors_as_read(&baseline);
        }
        let model = search.in_the_form_that_foretells(&baseline, model);
        let mut model = search.against_outsiders(&baseline, model);
        if let Some(plain) = search.without_the_grids_name(&baseline, &model) {
            model = plain;
            if model.effects.is_empty() {
                baseline = model.clone();
                search.before = search.errors_as_read(&baseline);
            }
        }
        let model = search.with_lift_off(model);
        let baseline = search.study.with_deviations(&baseline);
        Ok(Found { begun, search, baseline, model })
    }
}

impl Search<'_> {
    /// Error over noise of the runs held out; 1 where there are none.
    pub(super) fn held_out_ratio(&self, model: &Explained) -> f64 {
        self.study.held_out_ratio(&model.fitted)
    }
}

impl<'a> Found<'a> {
    fn by(case: &'a Case, split: Split) -> Result<Self, ExplainError> {
        Begun::new(case, split)?.searched(split)
    }

    /// The single name that the fitted runs told.
    fn told(&self) -> Option<usize> {
        Some(&self.model).filter(|model| model.is_single() && model.complete()).map(|model| model.effects[0])
    }

    /// Error over noise of the runs held out; 1 where there are none.
    fn held_out_ratio(&self) -> f64 {
        self.search.held_out_ratio(&self.model)
    }

    /// Whether the declared model, or one in which no error but a natural frequency itself says that it is another, follows the runs it was fitted
    /// to and misses those held out.
    fn contradicted(&self) -> bool {
        let declared = self.model.effects.is_empty() || self.search.deviates;
        declared && self.model.complete() && self.held_out_ratio() > most_missed(&self.model)
    }

    /// Whether one set of values of the declared law follows all runs: those it was fitted to did not tell them well enough to foretell
    /// the others, and that is all.
    fn is_of_one_law(&self) -> bool {
        let joint = || self.search.study.jointly(&self.model);
        self.contradicted() && joint().is_some_and(|joint| joint.left().is_noise())
    }

    /// Whether the runs held out hold more of what is lacking than those that were searched: far more where nothing was found, or something whose
    /// formula they would have had to tell.
    fn overtaken(&self) -> bool {
        let after = self.held_out_ratio();
        if self.model.effects.is_empty() {
            return after > OVERTAKEN * self.model.ratio;
        }
        self.model.complete() && after > CONTRADICTED && !self.is_followed()
    }

    /// Whether the runs held out do not contradict a name.
    fn is_followed(&self) -> bool {
        let before = self.search.study.error(&self.baseline.fitted, &self.search.study.held_out).ratio();
        is_followed(before, self.held_out_ratio())
    }

    /// Whether runs held out hold more than the noise beside a single name, and a rival of it follows the fitted runs as well; or more than runs do that
    /// were fitted, and a rival follows those better.
    fn is_ambiguous(&self) -> bool {
        let (held_out, own) = (self.held_out_ratio(), self.model.left());
        let nearer = |rival: &Rival| (own.excess() - rival.left) * own.count > EVIDENCE;
        let follows = |rival: &Rival| {
            rival.excess <= excess(COMPLETE) && (held_out > FORETOLD || held_out > LEFT && nearer(rival))
        };
        self.model.is_single() && self.search.rivals.iter().any(follows)
    }

    /// The only name of a model that leaves more than the noise. One that every rival leaves ten times as much as is in no doubt, where what it leaves is a
    /// trace of what was missing; what it contains is no other name for what it takes.
    fn doubtful(&self) -> Option<&'static str> {
        let [effect] = self.model.effects[..] else { return None };
        let left = self.model.ratio > LEFT || self.held_out_ratio() > FORETOLD;
        let mut others = self.search.rivals.clone();
        others.retain(|rival| !contained(Some(&effect), rival.effect));
        let dominates = || self.model.dominant(&self.baseline, least_excess(&self.model, &others));
        let stands = self.model.complete() && dominates() && self.is_followed();
        (left && !stands && !self.search.lifts_off && !self.search.other_formula).then(|| ALL[effect].id())
    }

    /// The same with a single name that leaves more than the noise on a finer grid, where that takes it: what a coarse grid leaves is no reason to doubt
    /// a name. That of a rigid contact has other means.
    fn sharpened(mut self) -> Self {
        if self.doubtful().is_some() && self.model.complete() && !self.model.fitted.setting.rigid {
            self.model = self.search.sharpened_among(self.model, LeftLines::is_noise);
        }
        self
    }

    /// The same on the grid of another search, where that is finer.
    fn on_grid_of(mut self, other: &Self) -> Self {
        if self.search.refined < other.search.refined
            && let Ok(finer) = other.search.study.polished(&self.model)
            && finer.ratio <= self.model.ratio
        {
            let case = self.search.study.case;
            self.search.study = Study { case, ..other.search.study.clone() };
            (self.search.refined, self.model) = (other.search.refined, finer);
        }
        self
    }

    /// What explains better: `self`, or what was found without its name. The other one is its rival.
    fn against(self, other: Self) -> Self {
        let (own, other) = (self.on_grid_of(&other), other);
        let other = other.on_grid_of(&own);
        own.weighed_against(other)
    }

    /// The same on one grid.
    fn weighed_against(self, other: Self) -> Self {
        let weight = |found: &Self| found.search.weight(&found.model);
        let behind = weight(&other) - weight(&self);
        let explains = other.model.effects.len() == 1
            && (other.model.complete() || !self.model.complete() && other.model.sufficient(&other.baseline));
        // An effect that the other one contains, and has nothing of its own beside, is it by another name.
        let same = self.model.complete() && other.search.is_renamed(&other.model, &self.model);
        let explains = explains && !same;
        let better = explains && behind + EVIDENCE < 0.0;
        let (mut chosen, other) = if better { (other, self) } else { (self, other) };
        if explains {
            chosen.search.rivals.extend(Rival::of(&other.model, behind.abs()));
        }
        let known = |id: &str| chosen.search.tried.iter().any(|t| t.id == id);
        let news: Vec<_> = other.search.tried.iter().filter(|t| !known(t.id)).copied().collect();
        chosen.search.tried.extend(news);
        chosen.search.refused.extend(other.search.refused);
        chosen
    }
}

/// Error over noise of runs held out up to which a complete model foretells them. The balance of a rigid contact may be wrong by more than the noise in
/// runs that it was not bent to.
fn most_missed(model: &Explained) -> f64 {
    if model.fitted.setting.rigid { CONTRADICTED } else { FORETOLD }
}

/// Runs of which a model's grid may be wrong by more than [`NEAR`] times the noise.
fn unresolved(study: &Study<'_>, fitted: &Fitted) -> Vec<usize> {
    study.grid_doubts(fitted).into_iter().filter(|(_, doubt)| *doubt > NEAR).map(|(run, _)| run).collect()
}
