//! The choice among models with one effect more: fits to their end, simpler names, what they foretell.

use super::finer::FINER;
use super::{EVIDENCE, Rival, Search, Tried};
use crate::Study;
use crate::effects::{ALL, Reach, Simpler};
use crate::left::LeftLines;
use crate::search::{Explained, NEAR};
use frettrace_forward::accelerations::Quantity;
use frettrace_friction::effects::Hook;
use frettrace_identify::HALF_INTERVAL95;
use rayon::prelude::*;

/// Excess over the best one's up to which a model that is not fitted to its end may still overtake it.
const CLOSE: f64 = 4.0;
/// Models beside a chosen one that are kept, to be asked on a finer grid.
const RUNNERS_UP: usize = 3;
/// Share of what was missing (χ²) that a richer effect must take beyond a simpler one that it contains, where both are complete: 0.3 % of the
/// amplitude, to which neither laboratory's formula nor its rig is known.
const EARNED: f64 = 1e-5;

impl Search<'_> {
    /// Records what was tried and keeps the best.
    pub(super) fn take_best(&mut self, current: &Explained, mut found: Vec<Explained>) -> Option<Explained> {
        found.iter_mut().for_each(|one| one.book(current));
        found.sort_by(Explained::by_criterion);
        self.settle_close(&mut found);
        found.sort_by(Explained::by_criterion);
        for one in self.simplified(current, &found) {
            let same = found.iter().position(|other| other.effects == one.effects);
            match same.map(|place| &mut found[place]) {
                Some(other) if one.criterion < other.criterion => *other = one,
                Some(_) => {}
                None => found.push(one),
            }
        }
        found.sort_by(Explained::by_criterion);
        self.record(current, &found);
        self.settle_simpler(&mut found);
        let (weights, mut found) = self.weighed(found);
        let best = *weights.first()?;
        // A richer effect that contains a simpler one must earn its name against it.
        let earned = EVIDENCE.max(EARNED * (current.criterion - found[0].criterion));
        let simpler = |rich: &Explained| {
            found.iter().zip(&weights).position(|(one, weight)| {
                one.complete() == rich.complete()
                    && one.effects.last().is_some_and(|&e| contained(rich.effects.last(), e))
                    && (*weight < best + earned || self.is_idle(rich))
            })
        };
        let mut chosen = 0;
        while let Some(next) = simpler(&found[chosen]) {
            chosen = next;
        }
        // What a richer effect has of its own, idle, makes it the chosen one under another name, and no rival.
        self.rivals = found
            .iter()
            .zip(&weights)
            .filter(|(one, _)| !self.is_renamed(one, &found[chosen]))
            .filter_map(|(one, weight)| Rival::of(one, weight - weights[chosen]))
            .collect();
        let chosen = found.swap_remove(chosen);
        // Each round leaves its own; one that asks for a further name begins anew.
        self.runners_up.retain(|one| one.effects.len() == chosen.effects.len());
        // Where the chosen one does not explain all yet, those as near may come as far by its longer way.
        let reach = if chosen.complete() { 0.0 } else { CLOSE * chosen.excess() };
        self.runners_up.extend(found.into_iter().filter(|one| one.complete() || one.excess() < reach));
        self.runners_up.sort_by(Explained::by_criterion);
        self.runners_up.truncate(RUNNERS_UP);
        Some(chosen)
    }

    /// Writes down what models with one effect more, the nearest first, have come to: of an effect with several forms the nearest.
    fn record(&mut self, current: &Explained, found: &[Explained]) {
        for one in found.iter().rev() {
            let Some(&effect) = one.effects.last() else { continue };
            let error = self.study.error(&one.fitted, &self.study.training).relative();
            let evidence = current.criterion - one.criterion;
            let id = ALL[effect].id();
            let brought = one.added.iter().skip(current.added.len()).map(|unknown| unknown.quantity);
            self.fitted_with.push((effect, brought.collect()));
            self.tried.retain(|t| t.id != id);
            self.tried.push(Tried { id, error, evidence });
        }
    }

    /// Those of some models that may come to explain all: where the nearest one is far from the data with the structure free too, it alone. The balance has
    /// calibrated the structure before, and what it does not take of the nearest one it does not take of those behind.
    pub(super) fn hopeful(&mut self, current: &Explained, mut found: Vec<Explained>) -> Vec<Explained> {
        found.sort_by(|a, b| a.excess().total_cmp(&b.excess()));
        let Some(nearest) = found.first_mut().filter(|nearest| nearest.ratio > NEAR) else { return found };
        *nearest = self.study.polished_or_as_it_is(nearest.clone());
        if nearest.ratio > NEAR {
            self.record(current, &found[1..]);
            found.truncate(1);
        }
        found
    }

    /// A named model on finer grids until its lines hold no more than is `enough`, and those that came nearer to it than the finer grid has brought it, on
    /// that grid, too: what a coarse grid leaves in each is more than what parts them, and they may change places.
    pub(super) fn sharpened_among(
        &mut self,
        named: Explained,
        enough: impl Fn(LeftLines) -> bool,
    ) -> Explained {
        let (grid, was) = (self.refined, named.criterion);
        let sharper = self.sharpened(named, enough, |_, one| one.complete());
        if self.refined > grid { self.among_the_near(was, sharper) } else { sharper }
    }

    /// A complete model, or of those that came nearer to what it `was` (a criterion) than its longer way has brought it, one that is better by the same
    /// way: on its grid, with contacts that had not settled.
    pub(super) fn among_the_near(&mut self, was: f64, sharper: Explained) -> Explained {
        let Some((&name, before)) = sharper.effects.split_last() else { return sharper };
        let near = |one: &&Explained| {
            let beside = one.effects.split_last().is_some_and(|(last, rest)| *last != name && rest == before);
            beside && one.criterion - was < was - sharper.criterion
        };
        let near: Vec<&Explained> = self.runners_up.iter().filter(near).collect();
        let asked = near.into_par_iter().filter_map(|one| self.study.polished(one).ok());
        let asked = asked.map(|one| self.study.unsettled_contacts(one));
        let asked = asked.filter(Explained::complete).map(|one| (self.weight(&one), one));
        let Some((weight, other)) = asked.min_by(|a, b| a.0.total_cmp(&b.0)) else { return sharper };
        let behind = self.weight(&sharper) - weight;
        let effect = other.effects[before.len()];
        self.rivals.retain(|rival| rival.effect != effect);
        let least = if contained(Some(&name), effect) { -EVIDENCE } else { 0.0 };
        if behind < least {
            self.rivals.extend(Rival::of(&other, -behind));
            return sharper;
        }
        let evidence = self.evidence_of_one_better_by(behind, name);
        if let Some(tried) = self.tried.iter_mut().find(|tried| tried.id == ALL[effect].id()) {
            tried.evidence = evidence.unwrap_or(tried.evidence + behind);
        }
        self.rivals = Rival::of_one_better_by(behind, (&sharper, std::mem::take(&mut self.rivals)));
        other
    }

    /// Evidence of a name that explains better by so much than one that was asked, as over the model which that one was asked beside, on the grid where
    /// that was; `None` where it was not asked.
    pub(super) fn evidence_of_one_better_by(&self, better: f64, than: usize) -> Option<f64> {
        let known = self.tried.iter().find(|tried| tried.id == ALL[than].id())?;
        Some(known.evidence + better)
    }

    /// What each model costs, the least first. Where several are complete they may differ by little on the runs that they were
    /// fitted to: among those, what they foretell of the others counts as much.
    fn weighed(&self, found: Vec<Explained>) -> (Vec<f64>, Vec<Explained>) {
        let some = found.first().is_some_and(Explained::complete);
        let weight = |one: &Explained| match (some, one.complete()) {
            (true, true) => self.weight(one),
            (true, false) => f64::INFINITY,
            (false, _) => one.criterion,
        };
        let mut all: Vec<(f64, Explained)> = found.into_iter().map(|one| (weight(&one), one)).collect();
        all.sort_by(|a, b| a.0.total_cmp(&b.0));
        all.into_iter().unzip()
    }

    /// `χ² + k ln n` of the fitted runs and χ² of those held out.
    pub(super) fn weight(&self, one: &Explained) -> f64 {
        one.criterion + self.study.foretold(&one.fitted)
    }

    /// Whether the last effect of a model is one that another, simpler one, would be too: nothing of its own could be seen, or all of its memory is
    /// nothing within its deviation.
    fn is_idle(&self, model: &Explained) -> bool {
        let (law, reach) = (&model.fitted.setting.law, self.reach());
        let forgotten = |effect: usize| {
            let known = |hook: &&Hook| law.get(**hook).is_some();
            let mut times = ALL[effect].memories().iter().filter(known).peekable();
            // The deviations of a model that misses the data say nothing.
            if times.peek().is_none() || !model.complete() {
                return false;
            }
            let doubted = self.study.doubted(model);
            let deviation = |&hook: &Hook| doubted.deviation(Quantity::Law(hook));
            times.all(|hook| law.get(*hook).is_some_and(|time| time <= HALF_INTERVAL95 * deviation(hook)))
        };
        model.effects.last().is_some_and(|&effect| ALL[effect].is_idle(law, reach) || forgotten(effect))
    }

    /// What the fitted runs reach.
    pub(super) fn reach(&self) -> Reach {
        let runs = self.study.training.iter().map(|&run| &self.study.model.runs[run]);
        let step = runs.map(|run| std::f64::consts::TAU / run.omega / run.samples as f64);
        Reach { step: step.fold(f64::INFINITY, f64::min), stroke: 2.0 * self.study.scales.slip }
    }

    /// Whether the last effect of `richer` is that of `simpler` by another name: it contains it, and has nothing of its own beside.
    pub(super) fn is_renamed(&self, richer: &Explained, simpler: &Explained) -> bool {
        simpler.effects.last().is_some_and(|&e| contained(richer.effects.last(), e)) && self.is_idle(richer)
    }

    /// Simpler effects than the best model's last from where that one has come to, where they have not come as far themselves: one may be complete
    /// with a form that the richer effect only mends.
    fn simplified(&self, current: &Explained, found: &[Explained]) -> Vec<Explained> {
        let Some((best, &effect)) = found.first().and_then(|best| Some((best, best.effects.last()?))) else {
            return Vec::new();
        };
        let behind = |id: &str| {
            let own = found.iter().find(|one| one.effects.last().is_some_and(|&e| ALL[e].id() == id));
            own.is_none_or(|own| own.criterion > best.criterion + EVIDENCE)
        };
        let simpler = ALL[effect].simpler(&best.fitted.setting.law, &self.study.scales);
        let wanted = simpler.into_iter().filter(|one| self.study.case.allows(one.id) && behind(one.id));
        let wanted: Vec<Simpler> = wanted.collect();
        wanted.par_iter().filter_map(|one| self.study.simpler(current, best, one)).collect()
    }

    /// Fits all that come near the best to their end: who is ahead halfway need not win. Where none is complete the finer grid is
    /// tried too, if that is what they lack.
    fn settle_close(&mut self, found: &mut Vec<Explained>) {
        let Some(first) = found.first() else { return };
        let ended = |study: &Study<'_>, found: &[Explained]| -> Vec<Explained> {
            found.par_iter().map(|one| study.polished(one).unwrap_or_else(|_| one.clone())).collect()
        };
        if first.complete() {
            // Those that are complete too were no longer told apart by where their fits had come to.
            let (complete, others): (Vec<_>, Vec<_>) = found.drain(..).partition(Explained::complete);
            let polished = if complete.len() > 1 { ended(&self.study, &complete) } else { complete.clone() };
            let better = complete.into_iter().zip(polished);
            let better: Vec<Explained> = better
                .map(|(one, longer)| if longer.criterion < one.criterion { longer } else { one })
                .collect();
            // Nor may one be ahead of another for its laboratory's formula.
            let least = better.iter().map(|one| one.criterion).fold(f64::INFINITY, f64::min);
            let shaped = |one: Explained| {
                let other = if one.criterion > least + EVIDENCE { self.study.with_shape(&one) } else { None };
                other.unwrap_or(one)
            };
            found.extend(better.into_par_iter().map(shaped).collect::<Vec<_>>());
            found.extend(others);
            return;
        }
        let reach = CLOSE * first.excess();
        let close = found.iter().filter(|one| one.excess() < reach).count();
        if close < 2 {
            return;
        }
        found.sort_by(|a, b| a.excess().total_cmp(&b.excess()));
        // The others are asked where the best one's longer way does not end at the noise.
        for part in [0..1, 1..close] {
            let polished = ended(&self.study, &found[part.clone()]);
            for (one, better) in found[part].iter_mut().zip(polished) {
                if better.criterion < one.criterion {
                    *one = better;
                }
            }
            if found[0].complete() {
                return;
            }
        }
        let least = |of: &[Explained]| of.iter().map(Explained::excess).fold(f64::INFINITY, f64::min);
        if self.refined == 0
            && !found.iter().any(Explained::complete)
            && least(found) < NEAR * NEAR
            && let Ok(Some(study)) = self.study.refined()
        {
            let finer = ended(&study, &found[..close]);
            if least(&finer) < FINER * least(found) {
                self.coarse = Some((std::mem::replace(&mut self.study, study), 0));
                self.refined = 1;
                *found = finer;
            }
        }
    }

    /// Fits a simpler effect to its end where a richer one that contains it is complete and ahead: it may be so by its longer way.
    fn settle_simpler(&self, found: &mut [Explained]) {
        let Some(first) = found.first().filter(|first| first.complete()) else { return };
        let (rich, best) = (first.effects.last().copied(), first.criterion);
        for one in found.iter_mut().skip(1) {
            let simpler = one.effects.last().is_some_and(|&e| contained(rich.as_ref(), e));
            if !simpler || !one.complete() || one.criterion < best + EVIDENCE {
                continue;
            }
            *one = self.study.polished_or_as_it_is(one.clone());
        }
    }
}

/// Whether the effect `of` becomes the effect `simpler` at some value of its parameters.
pub(super) fn contained(of: Option<&usize>, simpler: usize) -> bool {
    let of = of.map_or("", |&e| ALL[e].id());
    CONTAINED.iter().any(|(rich, plain)| *rich == of && *plain == ALL[simpler].id())
}

/// Effects that contain others: a lag of no time is the curve it lags behind, and so on.
const CONTAINED: [(&str, &str); 8] = [
    ("friction.lag", "friction.stribeck"),
    ("friction.film", "friction.stribeck"),
    ("friction.film", "friction.lag"),
    ("friction.ageing", "friction.stribeck"),
    ("friction.presliding-damping", "friction.viscous"),
    ("structure.second-support", "structure.cubic-stiffness"),
    ("friction.position-periodic", "friction.position"),
    ("friction.position-periodic", "contact.tangential-stiffness"),
];
