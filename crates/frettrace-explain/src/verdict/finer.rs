//! Fits to their end: further steps, finer phase grids, the further values of a shape.

use super::{BORNE_OUT, CONTRADICTED, EVIDENCE, FORETOLD, Search};
use crate::effects::{ALL, shaped};
use crate::left::LeftLines;
use crate::search::{Explained, NEAR, excess};
use crate::study::FINEST_DOUBLINGS;
use crate::{Study, Unknown};
use frettrace_forward::accelerations::{AccelerationModel, Quantity, Setting};
use std::sync::Arc;

/// A model near the data is fitted further, and on a finer grid, before it is judged, and so is one that leaves no more than this share of the excess
/// before it.
pub(super) const MOST_TAKEN: f64 = 0.05;
/// Finer grids, each twice as fine as the one before, that a model may get, and that one with a rigid contact may.
const MOST_REFINED: usize = 2;
const MOST_REFINED_RIGID: usize = 3;
/// Times what its grid may be wrong by that a model misses runs by where nothing of that is the grid's: what a grid is wrong by at values that were bent to
/// it may be a part of what it is at the right ones.
const BEYOND_GRID: f64 = 10.0;
/// Rounds in which the predictions of a rigid contact are corrected to those on a fine grid, each of which may leave a tenth of the error before it.
const CORRECTIONS: usize = 5;
/// Steps of a fit that begins anew on a finer grid.
const ANEW: usize = 30;
/// Share of the excess that a finer grid must take it to, to be kept, …
pub(super) const FINER: f64 = 0.7;
/// … and the one from which the fit came to rest elsewhere: twice the lines divide the error of a grid by three, its power by nine.
const AT_REST: f64 = 0.25;
/// Error over amplitude up to which the balance of a rigid contact is not known to be right itself: twice what separates it from
/// the march in time (9e-5 to 1.2e-4 in the validation).
pub(super) const RIGID_ACCURACY: f64 = 2e-4;

impl<'a> Search<'a> {
    /// A longer fit; then, where that is near the noise but not within it, or has most of what was `lacked` (an excess), one on a
    /// finer grid.
    pub(super) fn further(&mut self, mut current: Explained, lacked: f64) -> Explained {
        if current.complete() {
            return self.study.unsettled_contacts(current);
        }
        current = self.study.polished_or_as_it_is(current);
        // What no contact force takes at all, no finer grid takes, and no deflection of the contact.
        let outside = current.effects.is_empty() && self.study.share_of_balance(&current) > FINER;
        if !outside {
            current = self.study.unsettled_contacts(current);
        }
        let kinked = is_kinked(&current);
        if kinked && let Some(doubted) = self.beyond_all_grids(&current) {
            return doubted;
        }
        let near = current.ratio <= NEAR
            || current.excess() <= MOST_TAKEN * lacked
            || kinked && !self.is_beyond_grid(&current);
        let most = most_refined(&current);
        // What a finer grid may leave is no reason for another one.
        let by_contacts = |search: &Self, current: &Explained| {
            current.effects.is_empty() && !search.told_by_contacts(current).is_empty()
        };
        let told = |search: &Self, current: &Explained| {
            current.complete()
                || kinked && search.refined > 0 && search.tells_all_it_can(current)
                || search.refined >= MOST_REFINED && by_contacts(search, current)
        };
        let worth = near && !outside && !told(self, &current);
        let mut corrects = current.fitted.setting.rigid;
        while worth && !told(self, &current) {
            if corrects && current.ratio <= NEAR {
                corrects = false;
                let correct = || self.corrected(&current);
                if let Some((study, better)) = self.known.corrected(&self.study, &current, correct) {
                    return self.moved_to(study, better);
                }
            }
            if self.refined >= most {
                break;
            }
            let finer = if kinked { self.study.refined() } else { self.study.resolved(&current.fitted) };
            let Ok(Some(study)) = finer else { break };
            let nearer = |better: &Explained| better.excess() < FINER * current.excess();
            let Some(better) = on_finer(&study, &current).filter(nearer) else { break };
            let better = self.moved_to(study, better);
            self.refined += 1;
            let elsewhere = better.ratio > NEAR && better.excess() > AT_REST * current.excess();
            current = better;
            // What is far from the data and falls more slowly than the error of a grid is something else.
            if elsewhere {
                break;
            }
        }
        current
    }

    /// A model of a rigid contact corrected to a finer grid, the finest where the one before does not do: that one costs an eighth, and is enough where
    /// nothing but noise is left on the lines, and runs held out are followed.
    fn corrected(&self, current: &Explained) -> Option<(Study<'a>, Explained)> {
        let finer_by = |doublings: u32| self.study.finer_by(doublings).ok().map(Arc::new);
        let (before, finest) = (finer_by(FINEST_DOUBLINGS - 1)?, finer_by(FINEST_DOUBLINGS)?);
        let mut runs = before.runs.iter().zip(&finest.runs);
        if runs.all(|(before, finest)| before.contact_order == finest.contact_order) {
            return on_corrected(&self.study, (current, current), &finest);
        }
        let found = on_corrected(&self.study, (current, current), &before);
        let follows = |(study, better): &(Study<'_>, Explained)| {
            let noise_alone = better.complete() && better.left().is_noise();
            noise_alone && study.held_out_ratio(&better.fitted) <= CONTRADICTED
        };
        if found.as_ref().is_some_and(follows) {
            return found;
        }
        let begun = found.as_ref().map_or(current, |(_, better)| better);
        on_corrected(&self.study, (current, begun), &finest)
    }

    /// Whether a model far from the data misses every run by far more than its phase grid may be wrong by: no finer one mends that. Where the coarser grid
    /// has no balance nothing is known.
    fn is_beyond_grid(&self, model: &Explained) -> bool {
        let doubts = self.study.grid_doubts(&model.fitted);
        let beyond = |(run, doubt): (usize, f64)| {
            self.study.error(&model.fitted, &[run]).ratio() > BEYOND_GRID * doubt.max(NEAR)
        };
        !doubts.is_empty() && doubts.into_iter().all(beyond)
    }

    /// A declared model of a rigid contact with the error of its phase grid among the deviations of the lines, where no grid that a balance gets resolves any
    /// of its runs and it leaves no more than that: what finer grids would cost tells nothing.
    fn beyond_all_grids(&mut self, model: &Explained) -> Option<Explained> {
        let study = self.study.beyond_all_grids(&model.fitted)?;
        let as_it_is = study.judged(model.fitted.clone(), Vec::new(), Vec::new());
        let fitted = study.polished(&as_it_is).ok().into_iter().chain([as_it_is]);
        let within = fitted.filter(|one| one.left().is_noise()).min_by(|a, b| a.ratio.total_cmp(&b.ratio))?;
        (self.study, self.unresolved) = (study, true);
        Some(within)
    }

    /// Goes on with another grid's study and the model fitted there; a declared model of a rigid contact is fitted with the doubt of that grid.
    fn moved_to(&mut self, mut study: Study<'a>, mut model: Explained) -> Explained {
        if is_kinked(&model)
            && let Some(doubted) = doubting(&mut study, &model)
        {
            model = doubted;
        }
        let coarser = (std::mem::replace(&mut self.study, study), self.refined);
        self.coarse.get_or_insert(coarser);
        model
    }

    /// A model that `stands`, on finer grids until its lines hold no more than is `enough`: what the kinks of the contact send beyond the
    /// lines of a grid comes back to all of them, and is nothing that the model leaves.
    pub(super) fn sharpened(
        &mut self,
        mut current: Explained,
        enough: impl Fn(LeftLines) -> bool,
        stands: impl Fn(&Self, &Explained) -> bool,
    ) -> Explained {
        if enough(current.left()) {
            return current;
        }
        let mut finer = (self.study.clone(), current.clone(), self.refined);
        while finer.2 < most_refined(&current) && !enough(finer.1.left()) {
            let Ok(Some(study)) = finer.0.resolved(&finer.1.fitted) else { break };
            let left = FINER * finer.1.left().excess();
            let Some(sharper) = on_finer(&study, &finer.1).filter(|s| s.left().excess() < left) else {
                break;
            };
            finer = (study, sharper, finer.2 + 1);
            // On the way there a run may stand out that the coarser grid was bent to.
            if stands(self, &finer.1) {
                (self.study, current, self.refined) = finer.clone();
            }
        }
        current
    }

    /// The same with the further values of its last effect's shape, where it leaves more than the noise of what was `lacked`, in all
    /// samples or on the lines: the form that did best on the recovered contacts may be another laboratory's.
    pub(super) fn shaped(&mut self, current: Explained, lacked: f64) -> Explained {
        let fits = current.complete() && current.left().is_noise();
        let better = if fits { None } else { self.study.with_shape(&current) };
        better.map_or(current, |better| self.further(better, lacked))
    }

    /// A model without its last name, on a finer grid, where that takes all that the name says to nothing and the model follows the runs there without it: what a
    /// coarse grid leaves is bent to something by any effect that has a value to bend.
    pub(super) fn without_the_grids_name(
        &mut self,
        baseline: &Explained,
        model: &Explained,
    ) -> Option<Explained> {
        let last = model.effects.len().checked_sub(1)?;
        if self.refined >= most_refined(model) || !self.study.is_nothing(model, last) {
            return None;
        }
        let finer = self.study.refined().ok()??;
        // The declared model from where the name has led to as well: it may have come to rest in another valley.
        let reduced = finer.polished(model).ok().and_then(|sharper| finer.without(&sharper, last));
        let declared = if last == 0 { on_finer(&finer, baseline) } else { None };
        let follows =
            |one: &Explained| one.left().is_near_noise() && (one.complete() || self.traces_a_curve(one));
        let plain = reduced.into_iter().chain(declared).filter(follows);
        let plain = plain.min_by(Explained::by_criterion)?;
        let id = ALL[model.effects[last]].id();
        self.notes
            .push(format!("{id} is what a coarser phase grid left: on a finer one nothing asks for it"));
        self.study = finer;
        self.refined += 1;
        self.rivals.clear();
        Some(plain)
    }

    /// Whether what a model with a rigid contact leaves beside the noise is no more than its balance may be wrong by.
    pub(super) fn within_method(&self, model: &Explained) -> bool {
        let training = &self.study.training;
        let slight = model.ratio <= BORNE_OUT || model.ratio <= NEAR && self.is_accurate(model, training);
        slight && self.by_method(model, training) || self.is_beyond_all_grids(model)
    }

    /// Whether what a declared model leaves is no more than its phase grid may be wrong by, and no grid that a balance gets resolves any of its runs.
    pub(super) fn is_beyond_all_grids(&self, model: &Explained) -> bool {
        self.unresolved && is_kinked(model) && model.left().is_noise()
    }

    /// Whether a model with a rigid contact foretells runs that nothing was fitted to within the noise, and leaves in those that it was fitted to no more than
    /// their phase grid may be wrong by.
    pub(super) fn foretells_within_grid(&self, model: &Explained) -> bool {
        let foretold = !self.study.held_out.is_empty() && self.held_out_ratio(model) <= FORETOLD;
        foretold && model.ratio <= BORNE_OUT && self.is_of_grid(model)
    }

    /// Whether what a model with a rigid contact leaves is no more than its balance may be wrong by in the runs held out too: what a finer grid takes
    /// from those is no reason to stay with a coarser one.
    fn tells_all_it_can(&self, model: &Explained) -> bool {
        let held_out = &self.study.held_out;
        let borne_out =
            || held_out.is_empty() || self.study.error(&model.fitted, held_out).ratio() <= BORNE_OUT;
        self.within_method(model) && (borne_out() || self.by_method(model, held_out))
    }

    /// A named model of a rigid contact, fitted with the error of its phase grid among the deviations of the lines; `None` where it leaves
    /// more than that may be. Its rivals are compared by the deviations of the noise alone, which stay.
    pub(super) fn within_grid(&self, model: &Explained) -> Option<Explained> {
        if !model.fitted.setting.rigid || model.effects.is_empty() || model.ratio > NEAR {
            return None;
        }
        let mut other = self.clone();
        let found = doubting(&mut other.study, model)?;
        (found.complete() || other.within_method(&found)).then_some(found)
    }

    /// Whether what a model with a rigid contact leaves in some runs is no more than its balance may be wrong by: its accuracy in all
    /// samples, or, among the deviations of the lines, the error of the phase grid ([`Study::doubt_grid`]).
    pub(super) fn by_method(&self, model: &Explained, runs: &[usize]) -> bool {
        let accurate = || self.is_accurate(model, runs);
        model.fitted.setting.rigid && (accurate() || self.study.left_in(&model.fitted, runs).is_noise())
    }

    /// Whether what a model leaves beside the noise is within the accuracy of a rigid contact's balance.
    fn is_accurate(&self, model: &Explained, runs: &[usize]) -> bool {
        let error = self.study.error(&model.fitted, runs);
        let excess = excess(error.ratio());
        error.relative() * (excess / (1.0 + excess)).sqrt() <= RIGID_ACCURACY
    }

    /// Back to the plain grid, where a model on the finer one is not kept.
    pub(super) fn coarsened(&mut self) {
        if let Some(coarse) = self.coarse.take() {
            (self.study, self.refined) = coarse;
        }
    }
}

impl Study<'_> {
    /// A model with the further values of its last effect's shape, and, where it is not complete, of the effects before that: alone these were given the form
    /// that did best without it. `None` where they explain nothing.
    pub(super) fn with_shape(&self, current: &Explained) -> Option<Explained> {
        let last = current.effects.len().checked_sub(1)?;
        let mut best = self.with_shape_of(current, last);
        // Those of a model that is not booked yet are not known.
        let earlier = if current.counts.len() > last { last } else { 0 };
        for place in (0..earlier).rev() {
            let model = best.as_ref().unwrap_or(current);
            if model.complete() {
                break;
            }
            best = self.with_shape_of(model, place).or(best);
        }
        best
    }

    /// A complete model without the further values of its effects' shapes, where it is complete without them and they cost more than they explain: they may have
    /// been given before the other effects were there, or in their forms. A single effect's were given beside all that there is.
    pub(super) fn without_shapes(&self, mut model: Explained) -> Explained {
        if model.effects.len() < 2 {
            return model;
        }
        for place in 0..model.effects.len() {
            let plain = self.without_shape_of(&model, place);
            let stands = |plain: &Explained| plain.complete() && plain.criterion < model.criterion;
            if let Some(plain) = plain.filter(stands) {
                model = plain;
            }
        }
        model
    }

    fn without_shape_of(&self, model: &Explained, place: usize) -> Option<Explained> {
        let changes = ALL[model.effects[place]].shape(&model.fitted.setting.law, &self.scales);
        let is_further = |u: &Unknown| changes.iter().any(|change| u.quantity == Quantity::Law(change.hook));
        let plain = model.giving_back(place, is_further, &self.case.unknowns())?;
        let left = plain.own(place).len();
        if left == 0 || left == model.own(place).len() {
            return None;
        }
        self.polished(&plain).ok()
    }

    /// A model with the further values of the shape of its effect of the given place in the list.
    fn with_shape_of(&self, current: &Explained, place: usize) -> Option<Explained> {
        let effect = current.effects[place];
        let mut richer = current.clone();
        let setting = &mut richer.fitted.setting;
        let is_new = |unknown: &Unknown| current.added.iter().all(|u| u.quantity != unknown.quantity);
        let is_last = place + 1 == current.effects.len();
        let terms =
            if is_last { ALL[effect].further_terms(self.case, setting, &self.scales) } else { Vec::new() };
        let mut brought = shaped(effect, &mut setting.law, &current.added, &self.scales);
        brought.extend(terms.into_iter().filter(is_new));
        if brought.is_empty() {
            return None;
        }
        richer.bring(place, brought);
        self.polished(&richer).ok().filter(|better| better.criterion + EVIDENCE < current.criterion)
    }
}

/// Whether a model may be far from the noise for nothing but its grid: kinks of the contact send their force to every line, whose error falls with each
/// finer grid, and a declared rigid contact has no other corners than these.
fn is_kinked(model: &Explained) -> bool {
    model.fitted.setting.rigid && model.effects.is_empty()
}

/// Finer grids that a model may get.
fn most_refined(model: &Explained) -> usize {
    if model.fitted.setting.rigid { MOST_REFINED_RIGID } else { MOST_REFINED }
}

/// A model fitted anew on a finer grid. A rigid contact's law and structure were bent to what the coarser grid had cut short, and a fit
/// may not find back from there: the declared law begins from the declared structure and from its recovered contacts as well.
fn on_finer(study: &Study<'_>, current: &Explained) -> Option<Explained> {
    let mut best = study.polished(current).ok();
    let setting = &current.fitted.setting;
    let done = |best: Option<&Explained>| {
        best.is_some_and(|best| best.complete() || best.excess() < AT_REST * current.excess())
    };
    // One that is all but within the noise is where the data are.
    if !setting.rigid || current.ratio <= BORNE_OUT || done(best.as_ref()) {
        return best;
    }
    // From the recovered forces a rigid contact may come to another motion than the one that it had on the coarser grid.
    let lesser =
        |a: Option<Explained>, b: Option<Explained>| a.into_iter().chain(b).min_by(Explained::by_criterion);
    best = lesser(best, study.polished_on_lines(current).ok());
    if !current.effects.is_empty() {
        return best;
    }
    let declared = study.case.setting(setting.law);
    // The contacts may tell no more than the law that they were asked from.
    let recovered = || study.laws_on_contacts(&declared).unwrap_or_default();
    let others = std::iter::once_with(recovered).flatten().filter(|law| *law != setting.law);
    for law in std::iter::once(setting.law).chain(others) {
        if done(best.as_ref()) {
            break;
        }
        let setting = Setting { law, ..declared.clone() };
        let anew = study.whole(setting, &study.case.unknowns(), (Vec::new(), Vec::new()), ANEW).ok();
        best = lesser(best, anew);
    }
    best
}

/// A model of a rigid contact fitted with the error of the phase grid among the deviations of the lines: the structure is no longer bent to
/// what the grid cuts short. `None`, and nothing doubted, where that leads away from the data: far from the right law the two grids
/// are apart for other reasons.
fn doubting(study: &mut Study<'_>, model: &Explained) -> Option<Explained> {
    let known: Vec<_> = study.model.runs.iter().map(|run| run.deviation.clone()).collect();
    let doubted = study.doubt_grid(&model.fitted);
    let found = doubted.and_then(|_| study.polished(model)).ok();
    // One that is complete on this grid is cut short by nothing, and one that is far from the noise of all samples does not bear it out.
    let borne_out = |found: &Explained| found.ratio <= BORNE_OUT && found.left().is_noise();
    let meets = |found: &Explained| found.complete() || !model.complete() && borne_out(found);
    let found = found.filter(|found| meets(found) || found.excess() < model.excess());
    if found.is_none() {
        study.model.runs.iter_mut().zip(known).for_each(|(run, known)| run.deviation = known);
    }
    found
}

/// A model of a rigid contact with its predictions corrected to those on a fine grid, fitted to them in some rounds that begin from another one; `None` where that
/// is not complete and takes less than a third of what was left of the fitted runs.
fn on_corrected<'a>(
    plain: &Study<'a>,
    (current, begun): (&Explained, &Explained),
    fine: &Arc<AccelerationModel>,
) -> Option<(Study<'a>, Explained)> {
    let (mut at, mut left) = (begun.clone(), f64::INFINITY);
    // Balances on the fine grid cost as much as all else: each round has the factors of the last one. Their solutions are found anew, since a rigid
    // contact may have several, and the accelerations show which.
    let mut known = current.fitted.memory.clone();
    let mut best = None;
    for _ in 0..CORRECTIONS {
        let study = plain.corrected(fine, (&at.fitted, &mut known)).ok()?;
        known = known.factors();
        // Where the correction was found the error is that on the fine grid itself.
        let now = excess(study.error(&at.fitted, &study.training).ratio());
        let settled = now >= AT_REST.sqrt() * left || now == 0.0;
        let better = study.polished(&at).ok()?;
        let leaves = better.excess();
        if now < left {
            left = now;
            at = better.clone();
            best = Some((study, better));
        }
        // What a fit to the corrected predictions leaves is what the next round finds on the fine grid, but for what the fit has moved:
        // where that is too much, the round is spared.
        if settled || leaves > FINER * current.excess() {
            break;
        }
    }
    best.filter(|(_, better)| better.complete() || left < FINER * current.excess())
}
