//! The search: the whole model for the few candidates that stand out on the recovered contacts or on the balance.

use crate::contact_search::{ContactCandidate, within_reach};
use crate::effects::{ALL, Change, Simpler, apply, listed, set_by_forms};
use crate::left::LeftLines;
use crate::study::{Predicted, as_declared, breaks_away, merge};
use crate::{ExplainError, Fitted, Study, Unknown};
use frettrace_forward::accelerations::{Memory, Port, PortLaw, PortPlace, Quantity, Setting};
use frettrace_identify::{Fit, Status};
use rayon::prelude::*;
use std::cmp::Ordering;

/// Effects re-fitted with the whole model in each round, …
const BEST: usize = 3;
/// … and those where none meets the recovered contacts, χ² per residual of the best above this, for whom χ² is within this factor of it.
const MORE: usize = 6;
const UNMET: f64 = 1.5;
const BESIDE: f64 = 1.5;
/// Effects re-fitted where the recovered force tells none from another: that of a rigid contact is known to where its jumps lie, and a law that
/// meets it leaves less than one a residual.
const ALL_ABOUT: usize = 10;
/// A model is complete where its error stays within this factor of the noise, over all training runs …
pub(crate) const COMPLETE: f64 = 1.05;
/// … and in every run.
const COMPLETE_RUN: f64 = 1.12;
/// Error over noise up to which a model is near the data: farther away its values are bent to what it lacks.
pub(crate) const NEAR: f64 = 6.0;

/// Steps of a longer fit, …
const STEPS: usize = 30;
/// … and of its beginning, after which a model that stays behind another one's criterion by the factor will not come before it.
const FIRST_STEPS: usize = 6;
const BEHIND: f64 = 1.5;

/// Standard deviations that the stiffness of a support must be from nothing.
const CARRIES: f64 = 5.0;

/// A model explains where its error stays within this factor of the noise in every training run …
pub(crate) const SUFFICIENT: f64 = 1.2;
/// … and no more than this share of the declared model's excess is left: model errors of other rigs are of that size.
pub(crate) const REST: f64 = 0.01;

/// Error over noise of every training run up to which a name may stand where the formula differs, …
pub(crate) const OTHER_FORMULA: f64 = 3.0;
/// … the share of the declared model's excess that may be left then, …
pub(crate) const DOMINANT: f64 = 1e-3;
/// … and the factor by which rivals must leave more.
pub(crate) const RIVALS: f64 = 10.0;

/// A model of the whole rig with named effects in it.
#[derive(Clone)]
pub struct Explained {
    /// Indices of the effects in the list.
    pub(crate) effects: Vec<usize>,
    /// Sensor of each effect that has one.
    pub(crate) sensors: Vec<Option<usize>>,
    /// The fit.
    pub fitted: Fitted,
    /// Unknowns that the effects brought, effect by effect.
    pub added: Vec<Unknown>,
    /// How many of them each effect brought.
    pub(crate) counts: Vec<usize>,
    /// `χ² + k ln n` over the training runs, with χ² of the runs without a period.
    pub criterion: f64,
    /// What the runs without a period have in that.
    pub(crate) series: f64,
    /// Error over noise on the training runs.
    pub ratio: f64,
    /// Largest error over noise of any training run.
    pub worst: f64,
    /// Number of real residuals of the training runs.
    pub(crate) residuals: usize,
}

/// An effect that the whole model was fitted with.
pub(crate) struct Asked {
    /// Its index in the list.
    pub effect: usize,
    /// The model, or why it has no answer.
    pub answer: Result<Explained, ExplainError>,
}

impl Explained {
    /// The order of two by what they cost, the nearer one first.
    pub(crate) fn by_criterion(&self, other: &Self) -> Ordering {
        self.criterion.total_cmp(&other.criterion)
    }

    /// Standard deviation of a quantity from the curvature at the fit; NaN where it was not free.
    #[must_use]
    pub fn deviation(&self, quantity: Quantity) -> f64 {
        let place = self.fitted.unknowns.iter().position(|u| u.quantity == quantity);
        place.and_then(|k| self.fitted.deviation.get(k).copied()).unwrap_or(f64::NAN)
    }

    /// What the error holds beside the noise, as a share of the noise's power.
    pub(crate) fn excess(&self) -> f64 {
        excess(self.ratio)
    }

    /// The unknowns that the effect of the given place in the list brought.
    pub(crate) fn own(&self, place: usize) -> &[Unknown] {
        let first: usize = self.counts.iter().take(place).sum();
        let count = self.counts.get(place).copied().unwrap_or_default();
        self.added.get(first..first + count).unwrap_or_default()
    }

    /// Adds unknowns to those that the effect of the given place in the list brought; to the last one's where they are not booked yet.
    pub(crate) fn bring(&mut self, place: usize, unknowns: Vec<Unknown>) {
        let mut end = self.added.len();
        if let Some(count) = self.counts.get_mut(place) {
            *count += unknowns.len();
            end = self.counts.iter().take(place + 1).sum::<usize>() - unknowns.len();
        }
        self.added.splice(end..end, unknowns);
    }

    /// The model, not fitted again, without some of the unknowns that the effect of the given place in the list brought: their values are taken out
    /// of the setting where no other effect and none of `declared` has them. `None` where one of them cannot be.
    pub(crate) fn giving_back(
        &self,
        place: usize,
        is_taken: impl Fn(&Unknown) -> bool,
        declared: &[Unknown],
    ) -> Option<Self> {
        let mut reduced = self.clone();
        let (taken, kept): (Vec<_>, Vec<_>) = self.own(place).iter().cloned().partition(is_taken);
        let first: usize = self.counts.iter().take(place).sum();
        *reduced.counts.get_mut(place)? = kept.len();
        reduced.added.splice(first..first + taken.len() + kept.len(), kept);
        // A port is known by its place among the ports: the last ones go first.
        for Unknown { quantity, .. } in taken.iter().rev() {
            let remains = reduced.added.iter().chain(declared).any(|u| u.quantity == *quantity);
            if !remains && !reduced.fitted.setting.clear(*quantity) {
                return None;
            }
        }
        Some(reduced)
    }

    /// By how much its criterion is below that of another model. Runs without a period that do not judge it, because it has more than a law
    /// that differs, are no evidence for it.
    pub(crate) fn gain(&self, over: &Self) -> f64 {
        let silent = if as_declared(&self.fitted.setting) { 0.0 } else { over.series - self.series };
        over.criterion - self.criterion - silent
    }

    /// Books what `self` has added to `before` as brought by its last effect.
    pub(crate) fn book(&mut self, before: &Self) {
        self.counts = before.counts.clone();
        self.counts.push(self.added.len().saturating_sub(before.added.len()));
    }

    /// Whether a single name leaves nothing to explain.
    pub(crate) fn is_single(&self) -> bool {
        self.effects.len() == 1 && self.complete()
    }

    /// Whether so little is left of what `baseline` missed that no further mechanism can be told in it: a hundredth of its
    /// excess, and an error within a fifth of the noise. What an effect with one formula leaves is another mechanism.
    pub(crate) fn sufficient(&self, baseline: &Self) -> bool {
        self.worst <= SUFFICIENT && self.leaves_a_trace(baseline) && !self.has_exact()
    }

    /// Whether what is left is a hundredth of what `baseline` missed.
    pub(crate) fn leaves_a_trace(&self, baseline: &Self) -> bool {
        self.excess() <= REST * baseline.excess()
    }

    /// Whether one of the effects has no other formula.
    fn has_exact(&self) -> bool {
        self.effects.iter().any(|&effect| ALL[effect].is_exact())
    }

    /// Whether one mechanism takes so much away that its name is out of doubt though its formula is not this one: a thousandth
    /// of the excess of `baseline` is left, an error within three times the noise, and `rivals` leave ten times as much.
    pub(crate) fn dominant(&self, baseline: &Self, rivals: f64) -> bool {
        self.worst <= OTHER_FORMULA
            && self.excess() <= DOMINANT * baseline.excess()
            && self.is_far_ahead(rivals)
            && !self.has_exact()
    }

    /// Whether a rival's excess, or the least of several, is ten times what is left: what two formulas leave tells their names apart then.
    pub(crate) fn is_far_ahead(&self, rivals: f64) -> bool {
        self.excess() * RIVALS <= rivals
    }

    /// What is left on the lines of the training runs.
    pub(crate) fn left(&self) -> LeftLines {
        LeftLines { chi_squared: self.fitted.fit.data_cost, count: self.residuals as f64 }
    }

    /// Whether what it puts on the beam may be there: a mass that is more than nothing, a spring at rest that pushes back and a damper by the square of the
    /// velocity that takes energy.
    pub(crate) fn is_passive(&self) -> bool {
        let Setting { mass, ports, .. } = &self.fitted.setting;
        let pushes = |port: &Port| {
            let [spring, _, _, square] = port.coefficients;
            port.law != PortLaw::Polynomial || spring >= 0.0 && square >= 0.0
        };
        mass.is_none_or(|[mass, _]| mass > 0.0) && ports.iter().all(pushes)
    }

    /// Whether nothing is left to explain.
    #[must_use]
    pub fn complete(&self) -> bool {
        self.ratio <= COMPLETE && self.worst <= COMPLETE_RUN
    }
}

/// What an error over the noise holds beside it, as a share of the noise's power.
pub(crate) fn excess(ratio: f64) -> f64 {
    (ratio * ratio - 1.0).max(0.0)
}

impl Study<'_> {
    /// Whether a second support along the beam carries: a spring and a dashpot whose stiffness is nothing within five of its deviations are the
    /// damping, or the cube, of something else.
    pub(crate) fn carries(&self, model: &Explained) -> bool {
        let ports = &model.fitted.setting.ports;
        let has_support = model.effects.iter().any(|&e| ALL[e].id() == "structure.second-support");
        let along = ports.iter().rposition(|port| matches!(port.place, PortPlace::At(_)));
        match along.filter(|&index| has_support && ports[index].law == PortLaw::Polynomial) {
            Some(index) => {
                let deviation = self.with_deviations(model).deviation(Quantity::Port(index, 0));
                deviation.is_nan() || ports[index].coefficients[0] > CARRIES * deviation
            }
            None => true,
        }
    }

    /// Fits a model of the whole rig: the law first, then everything where the law comes near.
    pub(crate) fn whole(
        &self,
        setting: Setting,
        unknowns: &[Unknown],
        (effects, added): (Vec<usize>, Vec<Unknown>),
        iterations: usize,
    ) -> Result<Explained, ExplainError> {
        let structural = |q: Quantity| {
            matches!(q, Quantity::ModeFrequency(_) | Quantity::ModeDamping(_) | Quantity::ContactCompliance)
                && !added.iter().any(|a| a.quantity == q)
        };
        let few: Vec<Unknown> = unknowns.iter().filter(|u| !structural(u.quantity)).cloned().collect();
        let first = self.fitted(setting, &few, &self.model.memory(), iterations.min(6))?;
        // Far from the data the structure would only be bent to the law's faults, unless it is known loosely itself.
        let near = self.error(&first, &self.training).ratio() < NEAR || self.case.loosely_known();
        let fitted = if near {
            self.fitted(first.setting.clone(), unknowns, &first.memory, iterations)?
        } else {
            first
        };
        Ok(self.judged(fitted, effects, added))
    }

    /// The same model fitted further, with everything free. Where friction depends on the contact's place, each run is placed anew:
    /// the law may have come from where another wave answered better.
    pub(crate) fn polished(&self, from: &Explained) -> Result<Explained, ExplainError> {
        if from.fitted.setting.law.depends_on_place() {
            self.fitted_on(from, (&self.model.memory(), STEPS))
        } else {
            self.fitted_on(from, (&from.fitted.memory, STEPS))
        }
    }

    /// A model fitted further, where that explains better.
    pub(crate) fn polished_or_as_it_is(&self, model: Explained) -> Explained {
        match self.polished(&model) {
            Ok(better) if better.criterion < model.criterion => better,
            _ => model,
        }
    }

    /// The same model fitted further from its motions on other lines.
    pub(crate) fn polished_on_lines(&self, from: &Explained) -> Result<Explained, ExplainError> {
        let Fitted { setting, memory, .. } = &from.fitted;
        self.fitted_on(from, (&self.model.on_lines(memory, setting.ports.len()), STEPS))
    }

    /// The same model fitted further, with everything free, from the motions that are remembered.
    fn fitted_on(
        &self,
        from: &Explained,
        (memory, most): (&Memory, usize),
    ) -> Result<Explained, ExplainError> {
        let unknowns = merge(&self.case.unknowns(), &from.added);
        let fitted = self.fitted(from.fitted.setting.clone(), &unknowns, memory, most)?;
        let mut found = self.judged(fitted, from.effects.clone(), from.added.clone());
        found.sensors.clone_from(&from.sensors);
        found.counts.clone_from(&from.counts);
        Ok(found)
    }

    /// The same model without its effect of the given place in the list, fitted again: what the effect freed is held to what is
    /// declared of it. `None` where what it brought cannot be taken out of the model.
    pub(crate) fn without(&self, from: &Explained, place: usize) -> Option<Explained> {
        // The motions are those of a model that is near: a run may have several.
        self.fitted_on(&self.taken_out(from, place)?, (&from.fitted.memory, STEPS)).ok()
    }

    /// A model without its effect of the given place in the list and with all else as it is; `None` where what it brought cannot be taken out,
    /// or where a run has no answer then from the motions of the fitted model.
    pub(crate) fn emptied(&self, from: &Explained, place: usize) -> Option<Explained> {
        let mut reduced = self.taken_out(from, place)?;
        let Fitted { setting, memory, .. } = &mut reduced.fitted;
        self.begin(setting, &self.training, memory);
        self.model.predict(setting, &self.training, memory).ok()?;
        Some(reduced)
    }

    /// A model fitted from where it is; `None` where a few steps leave it far behind another one's criterion, or behind it and far from the data.
    pub(crate) fn fitted_if_near(&self, from: &Explained, criterion: f64) -> Option<Explained> {
        let begun = self.fitted_on(from, (&from.fitted.memory, FIRST_STEPS)).ok()?;
        let far = begun.ratio > NEAR && begun.criterion > criterion;
        if far || begun.criterion > BEHIND * criterion {
            return None;
        }
        let ended = begun.fitted.fit.status != Status::IterationLimit;
        if ended { Some(begun) } else { self.fitted_on(&begun, (&begun.fitted.memory, STEPS)).ok() }
    }

    /// A model that was not fitted again without its effect of the given place in the list.
    fn taken_out(&self, from: &Explained, place: usize) -> Option<Explained> {
        let mut reduced = from.giving_back(place, |_| true, &self.case.unknowns())?;
        let law = &mut reduced.fitted.setting.law;
        set_by_forms(from.effects[place], &law.clone(), &self.scales).for_each(|hook| law.clear(hook));
        if breaks_away(&reduced.fitted.setting).is_none() {
            reduced.fitted.setting.deflections.clear();
        }
        reduced.effects.remove(place);
        reduced.sensors.remove(place);
        reduced.counts.remove(place);
        Some(reduced)
    }

    /// A model that was not fitted: the declared values as they are.
    pub(crate) fn blank(&self, setting: Setting, unknowns: &[Unknown]) -> Result<Explained, ExplainError> {
        let values = unknowns.iter().map(|u| setting.get(u.quantity).unwrap_or_default()).collect();
        let fit = Fit {
            values,
            cost: f64::MAX,
            data_cost: f64::MAX,
            iterations: 0,
            status: Status::Stalled,
            free: vec![true; unknowns.len()],
            at_bound: vec![false; unknowns.len()],
        };
        let fitted = Fitted {
            setting,
            unknowns: unknowns.to_vec(),
            fit,
            memory: self.model.memory(),
            deviation: Vec::new(),
            predicted: Predicted::default(),
        };
        Ok(self.judged(fitted, Vec::new(), Vec::new()))
    }

    pub(crate) fn judged(&self, fitted: Fitted, effects: Vec<usize>, added: Vec<Unknown>) -> Explained {
        let residuals = self.residual_count();
        let count = residuals as f64;
        // Runs without a period judge the law by what was recovered of them.
        let series = self.series_cost(&fitted.setting);
        // Where a stop lets runs rest is a value of each.
        let rests = fitted.setting.rests.1.iter().filter(|rest| **rest != 0.0).count();
        // So is the deflection of a contact that has not settled, of each run that is fitted.
        let has_own = |run: &&usize| fitted.setting.deflections.get(**run).is_some_and(Option::is_some);
        let own = rests + self.training.iter().filter(has_own).count();
        let criterion = fitted.fit.cost + series + (fitted.unknowns.len() + own) as f64 * count.ln();
        let worst = self.training.iter().map(|&run| self.error(&fitted, &[run]).ratio()).fold(0.0, f64::max);
        let ratio = self.error(&fitted, &self.training).ratio();
        let sensors = vec![None; effects.len()];
        Explained {
            effects,
            sensors,
            fitted,
            counts: Vec::new(),
            added,
            criterion,
            series,
            ratio,
            worst,
            residuals,
        }
    }

    /// A simpler effect in the place of the last one of a fitted model, with the whole model.
    pub(crate) fn simpler(
        &self,
        from: &Explained,
        richer: &Explained,
        simpler: &Simpler,
    ) -> Option<Explained> {
        let effect = listed(simpler.id)?;
        let setting = Setting { law: simpler.law, ..richer.fitted.setting.clone() };
        // It is asked from where a richer one has come to: an answer there is a gift, and none says nothing of the effect.
        self.with_changes(from, setting, (effect, &simpler.changes)).ok()
    }

    /// One effect of the contact more in a model, with the whole of it, from a setting and the values with which the effect begins.
    pub(crate) fn with_changes(
        &self,
        from: &Explained,
        mut setting: Setting,
        (effect, changes): (usize, &[Change]),
    ) -> Result<Explained, ExplainError> {
        let brought = apply(changes, &mut setting.law);
        let unknowns = merge(&merge(&self.case.unknowns(), &from.added), &brought);
        self.with_effect(from, setting, (effect, &unknowns), STEPS)
    }

    /// One effect more in a model, with the whole of it.
    fn with_effect(
        &self,
        from: &Explained,
        setting: Setting,
        (effect, unknowns): (usize, &[Unknown]),
        iterations: usize,
    ) -> Result<Explained, ExplainError> {
        let declared = merge(&self.case.unknowns(), &from.added);
        let brought = unknowns.iter().filter(|u| declared.iter().all(|d| d.quantity != u.quantity)).cloned();
        let added = from.added.iter().cloned().chain(brought).collect();
        let effects = from.effects.iter().copied().chain([effect]).collect();
        let mut found = self.whole(setting, unknowns, (effects, added), iterations)?;
        found.sensors = from.sensors.iter().copied().chain([None]).collect();
        found.book(from);
        Ok(found)
    }

    /// The best contact effects with the whole model.
    pub(crate) fn contact_round(&self, from: &Explained, candidates: &[ContactCandidate]) -> Vec<Asked> {
        let declared = merge(&self.case.unknowns(), &from.added);
        let structure: Vec<Unknown> =
            declared.iter().filter(|u| !matches!(u.quantity, Quantity::Law(_))).cloned().collect();
        let best = candidates.first().map_or(0.0, |c| c.criterion);
        let unmet = candidates.first().is_some_and(|c| c.reduced > UNMET);
        let blurred = from.fitted.setting.rigid && candidates.first().is_some_and(|c| c.reduced < 1.0);
        let is_taken = |place: usize, one: &ContactCandidate| {
            let most = if blurred { ALL_ABOUT } else { MORE };
            place < BEST || place < most && (blurred || unmet && one.criterion < BESIDE * best)
        };
        let taken = candidates.iter().enumerate().filter(|(place, one)| is_taken(*place, one));
        let taken: Vec<&ContactCandidate> = taken.map(|(_, one)| one).collect();
        taken
            .into_par_iter()
            .filter(|candidate| within_reach(candidate.criterion, best))
            .map(|candidate| {
                let setting = candidate.placed_in(&from.fitted.setting);
                let unknowns = merge(&structure, &candidate.unknowns);
                Asked {
                    effect: candidate.effect,
                    answer: self.with_effect(from, setting, (candidate.effect, &unknowns), 15),
                }
            })
            .collect()
    }
}
