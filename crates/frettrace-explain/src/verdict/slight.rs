//! Models that follow the samples while their lines, or a mode, say that they lack something.
//!
//! Lines hold a small part of the noise of all samples: the values of a law and of a structure may be bent until the error is within that.

use super::rules::helps;
use super::{EVIDENCE, Rival, Search};
use crate::balance_fit::BalanceCandidate;
use crate::effects::{ALL, listed};
use crate::left::LeftLines;
use crate::search::Explained;
use crate::{Study, Unknown};
use frettrace_forward::accelerations::{Quantity, Setting};
use frettrace_identify::HALF_INTERVAL95;
use rayon::prelude::*;

/// Share of a mode's range from its end within which it parks there, …
const AT_BOUND: f64 = 1e-3;
/// … and the χ² that its release must take: a prior of five deviations is worth 25 by itself, and so is one of two modes.
const RELEASED: f64 = 100.0;

/// Deviations, its own and the declared one together, from which a natural frequency is another than declared: chance brings that to one of 800
/// rigs with twenty modes, and right models of simulated rigs come to 3.3.
pub(crate) const DEVIATES: f64 = 4.0;

/// Frequencies and dampings of a model that park at the end of what was declared of them.
fn strained(model: &Explained) -> impl Iterator<Item = &Unknown> {
    let fitted = &model.fitted;
    let modal = |q: Quantity| matches!(q, Quantity::ModeFrequency(_) | Quantity::ModeDamping(_));
    fitted.unknowns.iter().filter(move |unknown| modal(unknown.quantity)).filter(|unknown| {
        let (low, high) = unknown.parameter.bounds;
        let value = fitted.setting.get(unknown.quantity).unwrap_or_default();
        unknown.parameter.prior.is_some() && (value - low).min(high - value) < AT_BOUND * (high - low)
    })
}

/// The natural frequency of a model that is farthest from what was declared of it, by deviations, where that is more than chance brings.
fn farthest_off(told: &Explained) -> Option<Quantity> {
    let fitted = &told.fitted;
    let declared = fitted.unknowns.iter().filter(|u| matches!(u.quantity, Quantity::ModeFrequency(_)));
    let off = |unknown: &Unknown| {
        let (value, prior) = (fitted.setting.get(unknown.quantity)?, unknown.parameter.prior?);
        let spread = prior.std.hypot(told.deviation(unknown.quantity));
        Some((unknown.quantity, (value - prior.mean).abs() / spread))
    };
    let farthest = declared.filter_map(off).max_by(|a, b| a.1.total_cmp(&b.1));
    farthest.filter(|(_, off)| *off > DEVIATES).map(|(quantity, _)| quantity)
}

impl Search<'_> {
    /// Whether the lines of a model that is complete hold more than their noise, which is a small part of that of all samples. With a rigid contact
    /// they do so on a coarse grid: there they must hold more than that may be wrong by, or a mode must be at the end of what was declared of it,
    /// strained to take it up.
    pub(super) fn holds_more(&self, model: &Explained) -> bool {
        let yields = !model.fitted.setting.rigid;
        let beyond_grid = || self.study.within_doubt(model) == Some(false);
        !model.left().is_noise() && (yields || strained(model).next().is_some() || beyond_grid())
    }

    /// Whether what a model with a rigid contact leaves beside the noise is what its phase grid may be wrong by.
    pub(super) fn is_of_grid(&self, model: &Explained) -> bool {
        model.fitted.setting.rigid && self.study.within_doubt(model) == Some(true)
    }

    /// The declared model that ended with a mode at the end of what was declared of it, from where it ends when no mode is known that well: between
    /// narrow bounds a fit may come to rest in a valley of the law that has its way out beyond them. `None` where that does not explain better.
    pub(super) fn by_loose_modes(&self, declared: &Explained, start: Setting) -> Option<Explained> {
        strained(declared).next()?;
        let case = self.study.case.loosened();
        // Where no mode is known that well, that is what was fitted.
        if case.unknowns() == self.study.case.unknowns() {
            return None;
        }
        let mut loose = Search::new(Study { case: &case, ..self.study.clone() });
        // What no mode closes is none.
        if loose.is_open(declared) {
            return None;
        }
        let begun = loose.baseline(start).ok()?;
        let ended = if begun.complete() { begun } else { loose.restarted(&begun).unwrap_or(begun) };
        let found = self.study.polished(&ended).ok()?;
        (found.criterion + EVIDENCE < declared.criterion).then_some(found)
    }

    /// A model that is complete with a mode at the end of what was declared of it, with that mode released: law and modes together may
    /// have taken up what one of them lacks. Where that is so and the name is not asked for, the structure is strained.
    pub(super) fn released(&mut self, current: &Explained) -> Option<Explained> {
        let candidates: Vec<BalanceCandidate> =
            strained(current).filter_map(|unknown| self.release(current, unknown.quantity)).collect();
        let asked = candidates.par_iter().map(|c| self.asked(current, c)).collect();
        let found = self.answered(asked);
        let found = self.take_best(current, found)?;
        let told = found.complete()
            && found.criterion + RELEASED < current.criterion
            && self.takes_all(current, &found)
            && self.leaves_declared(&found);
        let foretold = told && self.foretells(current, &found);
        let allowed = self.may_be_named(&found);
        self.strained = foretold && !allowed;
        self.tried.retain(|t| self.study.case.allows(t.id));
        if foretold && allowed {
            return Some(found);
        }
        self.rivals.clear();
        None
    }

    /// A complete model whose lines hold noise, with a natural frequency farther from what was declared than its deviation lets it be by chance,
    /// with that frequency free, or with a force on the beam that explains it better: no error shows it, and it says so itself.
    pub(super) fn deviating(&mut self, current: &Explained) -> Option<Explained> {
        if !current.left().is_noise() {
            return None;
        }
        // What the phase grid bends only adds to the deviations: it is asked where these alone do not tell.
        farthest_off(&self.study.with_deviations(current))?;
        let quantity = farthest_off(&self.study.doubted(current))?;
        let candidate = self.release(current, quantity)?;
        let asked = self.asked(current, &candidate);
        let mut found = self.answered(vec![asked]).pop()?;
        found.book(current);
        if !found.complete() || !found.left().is_noise() || found.gain(current) < EVIDENCE {
            return None;
        }
        // A force on the beam moves its frequencies, too, and may say the same with more right.
        if let Ok(Some(force)) = self.hidden_round(current, None) {
            if force.left().is_noise() && force.criterion + EVIDENCE < found.criterion {
                self.rivals.extend(Rival::of(&found, found.criterion - force.criterion));
                self.deviates = true;
                return Some(force);
            }
            let behind = std::mem::take(&mut self.rivals);
            self.rivals = Rival::of_better(&found, (&force, behind));
        }
        let allowed = self.may_be_named(&found);
        self.strained = !allowed;
        self.deviates = allowed;
        allowed.then_some(found)
    }

    /// Whether a value that the last effect of a model frees leaves what is declared of it by more than it is uncertain, by what the phase grid bends it
    /// to, too.
    fn leaves_declared(&self, model: &Explained) -> bool {
        let doubted = self.study.doubted(model);
        let declared = self.study.case.unknowns();
        let leaves = |unknown: &Unknown| {
            let prior = declared.iter().find(|d| d.quantity == unknown.quantity)?.parameter.prior?;
            let value = model.fitted.setting.get(unknown.quantity)?;
            let spread = prior.std.hypot(doubted.deviation(unknown.quantity));
            Some((value - prior.mean).abs() > HALF_INTERVAL95 * spread)
        };
        model.own(model.effects.len() - 1).iter().any(|unknown| leaves(unknown).unwrap_or(true))
    }

    /// Whether a model with names has all that the lines of one without hold beside the noise, and beside what the grid of a rigid contact may be
    /// wrong by, and foretells runs better. A last name that is nothing within its deviation has led to where the declared law follows as well.
    fn has_it_all(&self, without: &Explained, model: &Explained) -> bool {
        let meets = || model.left().is_noise() || self.is_of_grid(model);
        let says_something = || !self.study.is_nothing(model, model.effects.len() - 1);
        model.complete() && meets() && self.foretells(without, model) && says_something()
    }

    /// A declared model that follows the samples, and a named one that has all that the lines of the declared one hold beside the noise, on a finer grid
    /// where it takes one: the values of a law and of a structure were bent until the error was within the noise of all samples, and the name
    /// stays. `None` where it is not needed, or there is none.
    pub(super) fn still_lacking(
        &mut self,
        plain: &Explained,
        named: &Explained,
    ) -> Option<(Explained, Explained)> {
        if named.effects.is_empty() || !self.holds_more(plain) {
            return None;
        }
        let mut other = self.clone();
        let named = other.sharpened(named.clone(), LeftLines::is_noise, |_, one| one.complete());
        let finer = other.refined > self.refined;
        let plain = if finer { other.study.polished(plain).ok()? } else { plain.clone() };
        other.has_it_all(&plain, &named).then(|| {
            *self = other;
            (plain, named)
        })
    }

    /// Whether the last effect of a model may be asked for by its name.
    fn may_be_named(&self, model: &Explained) -> bool {
        model.effects.last().is_some_and(|&effect| self.study.case.allows(ALL[effect].id()))
    }

    /// Whether runs held out ask for a model too: what only the fitted ones ask for is an error of theirs, or of the model.
    fn foretells(&self, before: &Explained, model: &Explained) -> bool {
        let held_out = &self.study.held_out;
        let error = |of: &Explained| self.study.error(&of.fitted, held_out).ratio();
        let improved = || self.study.improvement(&before.fitted, &model.fitted, held_out);
        !held_out.is_empty() && helps(improved(), [error(before), error(model)])
    }

    /// The effect of a mode with another frequency or damping than declared.
    fn release(&self, current: &Explained, quantity: Quantity) -> Option<BalanceCandidate> {
        let id = match quantity {
            Quantity::ModeFrequency(_) => "structure.modal-frequency",
            Quantity::ModeDamping(_) => "structure.modal-damping",
            _ => return None,
        };
        let effect = listed(id)?;
        let (case, setting) = (self.study.case, &current.fitted.setting);
        let forms = ALL[effect].structure_forms(case, setting, &self.study.scales);
        let form = forms.into_iter().find(|form| form.unknowns[0].quantity == quantity)?;
        Some(BalanceCandidate::unfitted(effect, form, current.criterion))
    }
}
