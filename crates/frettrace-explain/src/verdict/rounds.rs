//! One effect more: rounds over the contact and over everything outside it.

use super::outcome::helps;
use super::{BALANCE_CALIBRATED, BALANCE_CLOSED, EASED, EVIDENCE, FINER, NEAR, PROXY, Rival, Search, Tried};
use crate::balance_fit::BalanceCandidate;
use crate::effects::{ALL, Reach, Simpler};
use crate::search::Explained;
use crate::study::merge;
use crate::{ExplainError, Study, Unknown};
use frettrace_forward::accelerations::{Quantity, Setting};
use frettrace_friction::effects::Hook;
use rayon::prelude::*;

/// Excess over the best one's up to which a model that is not fitted to its end may still overtake it.
const CLOSE: f64 = 4.0;
/// χ² per residual on the recovered contacts below which a law is one that the contact may have.
const FITS: f64 = 4.0;

/// Share of a mode's range from its end within which it parks there, …
const AT_BOUND: f64 = 1e-3;
/// … and the χ² that its release must take: a prior of five deviations is worth 25 by itself, and so is one of two modes.
const RELEASED: f64 = 100.0;

/// Effects outside the contact that are re-fitted with the whole model, and how many where more of them close the balance.
const REFITTED: usize = 4;
const MOST_REFITTED: usize = 7;

impl Search<'_> {
    /// The same model from the law that the contacts recovered with it show, where that ends nearer: the fit of the whole rig may
    /// have come to rest in another valley, and an effect may not be named for that.
    pub(super) fn restarted(&self, current: &Explained) -> Option<Explained> {
        let unknowns = merge(&self.study.case.unknowns(), &current.added);
        let (law, _) = Unknown::parted(&unknowns);
        let mut setting = current.fitted.setting.clone();
        if !self.closed(&setting) {
            return None;
        }
        let recovered = self.study.recovered(&setting).ok()?;
        let base = self.study.contact_base(&recovered, &setting, &law).filter(|base| base.reduced < FITS)?;
        setting.law = base.law;
        let named = (current.effects.clone(), current.added.clone());
        let mut found = self.study.whole(setting, &unknowns, named, 15).ok()?;
        found.sensors.clone_from(&current.sensors);
        found.counts.clone_from(&current.counts);
        (found.criterion + EVIDENCE < current.criterion).then_some(found)
    }

    fn contact_round(&mut self, current: &Explained) -> Result<Option<Explained>, ExplainError> {
        let unknowns = merge(&self.study.case.unknowns(), &current.added);
        let (law, _) = Unknown::parted(&unknowns);
        let mut setting = current.fitted.setting.clone();
        let recovered = self.study.recovered(&setting)?;
        // A fit of the whole rig that lacks an effect may have driven the law away from what the contact shows.
        let other = self.recovered_law.filter(|_| current.effects.is_empty());
        let base = [Some(setting.law), other]
            .into_iter()
            .flatten()
            .filter_map(|start| {
                self.study.contact_base(&recovered, &Setting { law: start, ..setting.clone() }, &law)
            })
            .min_by(|a, b| a.criterion.total_cmp(&b.criterion));
        let plain = base.as_ref().map_or(f64::INFINITY, |b| b.criterion);
        if let Some(base) = &base {
            setting.law = base.law;
        }
        let reduced = base.as_ref().map_or(f64::INFINITY, |base| base.reduced);
        let taken = (&current.effects[..], reduced);
        let candidates = self.study.contact_candidates(&recovered, &setting, &law, taken);
        self.tried.extend(candidates.iter().map(|c| Tried {
            id: ALL[c.effect].id(),
            error: f64::NAN,
            evidence: plain - c.criterion,
        }));
        let found = self.study.contact_round(current, &candidates);
        Ok(self.take_best(current, found))
    }

    /// The declared model with the compliance of the contact that is declared, where a large one was fitted. The balance does not
    /// see it, and it eases a law that lacks an effect: what is recovered with it hides what the law lacks.
    fn stiffened(&self, current: &Explained) -> Option<Explained> {
        let mut stiff = current.clone();
        let setting = &mut stiff.fitted.setting;
        let compliance = |of: &Setting| of.get(Quantity::ContactCompliance).unwrap_or_default();
        let declared = compliance(&self.study.case.setting(setting.law));
        let preload = self.study.model.runs.iter().map(|run| run.preload).fold(0.0, f64::max);
        let own = setting.law.get(Hook::Sigma0).map_or(0.0, |sigma0| sigma0 * preload);
        let eased = (compliance(setting) - declared).abs() * own > EASED;
        setting.set(Quantity::ContactCompliance, declared);
        (eased && current.effects.is_empty()).then_some(stiff)
    }

    /// A round over the contact, fitted to its end; another one on contacts recovered with the declared compliance, where that
    /// leaves something.
    pub(super) fn contact(&mut self, current: &Explained) -> Result<Option<Explained>, ExplainError> {
        let found = self.contact_round(current)?.map(|found| self.further(found, current.excess()));
        let found = found.map(|found| self.shaped(found, current.excess()));
        if found.as_ref().is_some_and(Explained::complete) {
            return Ok(found);
        }
        let Some(stiff) = self.stiffened(current) else { return Ok(found) };
        let rivals = std::mem::take(&mut self.rivals);
        let other = self.contact_round(&stiff)?.map(|found| self.further(found, stiff.excess()));
        let least = found.as_ref().map_or(f64::INFINITY, |found| found.criterion);
        if other.as_ref().is_some_and(|other| other.criterion < least) {
            return Ok(other);
        }
        self.rivals = rivals;
        Ok(found)
    }

    /// Records what was tried and keeps the best.
    fn take_best(&mut self, current: &Explained, mut found: Vec<Explained>) -> Option<Explained> {
        found.iter_mut().for_each(|one| one.book(current));
        let by_criterion = |a: &Explained, b: &Explained| a.criterion.total_cmp(&b.criterion);
        found.sort_by(by_criterion);
        self.settle_close(&mut found);
        found.sort_by(by_criterion);
        for one in self.simplified(current, &found) {
            let same = found.iter().position(|other| other.effects == one.effects);
            match same.map(|place| &mut found[place]) {
                Some(other) if one.criterion < other.criterion => *other = one,
                Some(_) => {}
                None => found.push(one),
            }
        }
        found.sort_by(by_criterion);
        for one in &found {
            let Some(&effect) = one.effects.last() else { continue };
            let error = self.study.error(&one.fitted, &self.study.training).relative();
            let evidence = current.criterion - one.criterion;
            let id = ALL[effect].id();
            self.tried.retain(|t| t.id != id);
            self.tried.push(Tried { id, error, evidence });
        }
        self.settle_simpler(&mut found);
        let (weights, mut found) = self.weighed(found);
        let best = *weights.first()?;
        // A richer effect that contains a simpler one must earn its name against it.
        let simpler = found.iter().zip(&weights).position(|(one, weight)| {
            (*weight < best + EVIDENCE || self.is_idle(&found[0]))
                && one.complete() == found[0].complete()
                && one.effects.last().is_some_and(|&e| contained(found[0].effects.last(), e))
        });
        let chosen = simpler.unwrap_or(0);
        // What a richer effect has of its own, idle, makes it the chosen one under another name, and no rival.
        self.rivals = found
            .iter()
            .zip(&weights)
            .filter(|(one, _)| !self.is_renamed(one, &found[chosen]))
            .filter_map(|(one, weight)| {
                let behind = weight - weights[chosen];
                one.effects.last().map(|&effect| Rival { effect, behind, excess: one.excess() })
            })
            .collect();
        Some(found.swap_remove(chosen))
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

    /// Whether the last effect of a model is one that another, simpler one, would be too.
    fn is_idle(&self, model: &Explained) -> bool {
        let runs = self.study.training.iter().map(|&run| &self.study.model.runs[run]);
        let step = runs.map(|run| std::f64::consts::TAU / run.omega / run.samples as f64);
        let reach = Reach { step: step.fold(f64::INFINITY, f64::min), stroke: 2.0 * self.study.scales.slip };
        model.effects.last().is_some_and(|&effect| ALL[effect].is_idle(&model.fitted.setting.law, reach))
    }

    /// Whether the last effect of `richer` is that of `simpler` by another name: it contains it, and has nothing of its own beside.
    pub(super) fn is_renamed(&self, richer: &Explained, simpler: &Explained) -> bool {
        self.is_idle(richer) && simpler.effects.last().is_some_and(|&e| contained(richer.effects.last(), e))
    }

    /// Simpler effects than the best model's last from where that one has come to, where they have not come as far themselves.
    fn simplified(&self, current: &Explained, found: &[Explained]) -> Vec<Explained> {
        let Some((best, &effect)) = found.first().and_then(|best| Some((best, best.effects.last()?))) else {
            return Vec::new();
        };
        let behind = |id: &str| {
            let own = found.iter().find(|one| one.effects.last().is_some_and(|&e| ALL[e].id() == id));
            own.is_none_or(|own| !own.complete() && own.criterion > best.criterion + EVIDENCE)
        };
        let simpler = ALL[effect].simpler(&best.fitted.setting.law);
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
            found.extend(
                better.map(|(one, longer)| if longer.criterion < one.criterion { longer } else { one }),
            );
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
            if let Ok(better) = self.study.polished(one)
                && better.criterion < one.criterion
            {
                *one = better;
            }
        }
    }

    /// Where structure effects start from: what was declared, or the model that already holds effects. A base fit of a law to
    /// an open balance bends the structure to what is missing.
    fn structural_start(&self, current: &Explained) -> Setting {
        if current.effects.is_empty() { self.declared_start(current) } else { current.fitted.setting.clone() }
    }

    /// The declared structure, calibrated on the balance where it is only loosely known, with a model's law.
    pub(super) fn declared_start(&self, model: &Explained) -> Setting {
        let declared = self.study.case.setting(model.fitted.setting.law);
        if !self.study.case.loosely_known() {
            return declared;
        }
        let calibrated = self.study.balance_base(&declared, &[]);
        if calibrated.reduced.is_finite() { calibrated.setting } else { declared }
    }

    /// A structure effect where the balance is closed by what is usual, yet not by what the noise allows.
    pub(super) fn slight_round(&mut self, current: &Explained) -> Result<Option<Explained>, ExplainError> {
        let (reduced, _) = self.study.balance_reduced(&current.fitted.setting);
        if reduced <= BALANCE_CALIBRATED {
            return Ok(None);
        }
        let found = self.structure_round(current, 0.5 * (1.0 + reduced))?;
        Ok(found.filter(|better| better.excess() < PROXY * current.excess()))
    }

    /// An effect outside the contact where the balance is closed but none of the contact completes the model: a recovered force
    /// takes most of what another force at a beam does, and what is left of it may be within what is usual.
    pub(super) fn hidden_round(
        &mut self,
        current: &Explained,
        contact: Option<Explained>,
    ) -> Result<Option<Explained>, ExplainError> {
        if contact.as_ref().is_some_and(Explained::complete) {
            return Ok(contact);
        }
        let rivals = std::mem::take(&mut self.rivals);
        let candidates = if current.fitted.setting.ports.is_empty() {
            self.coarse.as_ref().map_or(&self.study, |(study, _)| study).tangent_candidates(current)
        } else {
            Vec::new()
        };
        let plain = current.criterion;
        self.tried.extend(candidates.iter().map(|c| Tried {
            id: ALL[c.effect].id(),
            error: f64::NAN,
            evidence: plain - c.criterion,
        }));
        let worth = |c: &&BalanceCandidate| c.criterion + EVIDENCE < plain;
        let worthy: Vec<&BalanceCandidate> = candidates.iter().filter(worth).collect();
        let found = worthy.par_iter().filter_map(|c| self.with_structure(current, c).ok()).collect();
        let found = self.take_best(current, found).map(|found| self.further(found, current.excess()));
        // A force that the balance does not show must leave nothing else to be explained.
        let ahead = |found: &Explained| {
            found.complete()
                && contact.as_ref().is_none_or(|contact| found.criterion + EVIDENCE < contact.criterion)
        };
        match found {
            Some(found) if ahead(&found) => {
                // Those of the contact stood behind its best one, which is a rival itself now.
                if let Some(contact) = &contact {
                    let behind = contact.criterion - found.criterion;
                    let best = contact.effects.last().map(|&effect| Rival {
                        effect,
                        behind: 0.0,
                        excess: contact.excess(),
                    });
                    let moved = |rival: Rival| Rival { behind: rival.behind + behind, ..rival };
                    self.rivals.extend(rivals.into_iter().chain(best).map(moved));
                }
                Ok(Some(found))
            }
            _ => {
                self.rivals = rivals;
                Ok(contact)
            }
        }
    }

    /// A model that is complete with a mode at the end of what was declared of it, with that mode released: law and modes together may
    /// have taken up what one of them lacks. Where that is so and the name is not asked for, the structure is strained.
    pub(super) fn released(&mut self, current: &Explained) -> Option<Explained> {
        let fitted = &current.fitted;
        let strained = fitted.unknowns.iter().filter(|unknown| {
            let (low, high) = unknown.parameter.bounds;
            let value = fitted.setting.get(unknown.quantity).unwrap_or_default();
            unknown.parameter.prior.is_some() && (value - low).min(high - value) < AT_BOUND * (high - low)
        });
        let candidates: Vec<BalanceCandidate> =
            strained.filter_map(|unknown| self.release(current, unknown.quantity)).collect();
        let found = candidates.par_iter().filter_map(|c| self.with_structure(current, c).ok()).collect();
        let found = self.take_best(current, found)?;
        let held_out = &self.study.held_out;
        let error = |of: &Explained| self.study.error(&of.fitted, held_out).ratio();
        let told = found.complete() && found.criterion + RELEASED < current.criterion;
        // What only the fitted runs ask for is an error of theirs, or of the model.
        let foretold = told
            && !held_out.is_empty()
            && helps(
                self.study.improvement(&current.fitted, &found.fitted, held_out),
                [error(current), error(&found)],
            );
        let allowed = found.effects.last().is_some_and(|&e| self.study.case.allows(ALL[e].id()));
        self.strained = foretold && !allowed;
        self.tried.retain(|t| self.study.case.allows(t.id));
        if foretold && allowed {
            return Some(found);
        }
        self.rivals.clear();
        None
    }

    /// The effect of a mode with another frequency or damping than declared.
    fn release(&self, current: &Explained, quantity: Quantity) -> Option<BalanceCandidate> {
        let id = match quantity {
            Quantity::ModeFrequency(_) => "structure.modal-frequency",
            Quantity::ModeDamping(_) => "structure.modal-damping",
            _ => return None,
        };
        let effect = ALL.iter().position(|e| e.id() == id)?;
        let (case, setting) = (self.study.case, &current.fitted.setting);
        let forms = ALL[effect].structure_forms(case, setting, &self.study.scales);
        let form = forms.into_iter().find(|form| form.unknowns[0].quantity == quantity)?;
        Some(BalanceCandidate {
            effect,
            sensor: None,
            setting: form.setting,
            unknowns: form.unknowns,
            criterion: current.criterion,
            reduced: f64::NAN,
        })
    }

    /// Effects outside the contact that bring χ² per degree of freedom of the balance below `limit`.
    pub(super) fn structure_round(
        &mut self,
        current: &Explained,
        limit: f64,
    ) -> Result<Option<Explained>, ExplainError> {
        let (_, structural) = Unknown::parted(&current.added);
        let setting = self.structural_start(current);
        let plain = self.study.balance_base(&setting, &structural);
        let mut candidates = self.study.balance_candidates(&setting, &structural, &current.effects);
        if setting.ports.is_empty() {
            candidates.extend(self.study.force_candidates(&setting, plain.criterion));
            candidates.extend(self.study.base_candidate(&setting, plain.criterion));
        }
        candidates.sort_by(|a, b| a.criterion.total_cmp(&b.criterion));
        // One form of each effect is re-fitted, of the best effect two: on recovered forces close forms change places.
        let leader = candidates.first().map(|c| c.effect);
        let mut seen = Vec::new();
        candidates.retain(|c| {
            let before = seen.iter().filter(|effect| **effect == c.effect).count();
            seen.push(c.effect);
            before < if Some(c.effect) == leader { 2 } else { 1 }
        });
        self.tried.extend(candidates.iter().map(|c| Tried {
            id: ALL[c.effect].id(),
            error: f64::NAN,
            evidence: plain.criterion - c.criterion,
        }));
        let best = candidates.first().map_or(f64::INFINITY, |c| c.criterion);
        // Laws of a further force are judged on what was recovered of it, where a weak force agrees with any: what closes the balance by a
        // value or two is asked however many of them stand before it.
        let worthy = |place: usize, c: &BalanceCandidate| place < REFITTED || c.reduced < BALANCE_CLOSED;
        let found = candidates
            .par_iter()
            .take(MOST_REFITTED)
            .enumerate()
            .filter(|(place, c)| worthy(*place, c) && c.criterion < 3.0 * best && c.reduced < limit)
            .filter_map(|(_, candidate)| self.with_structure(current, candidate).ok())
            .collect();
        Ok(self.take_best(current, found))
    }

    /// The whole model with a structure effect: the law anew on contacts recovered with it, then everything.
    fn with_structure(
        &self,
        current: &Explained,
        candidate: &BalanceCandidate,
    ) -> Result<Explained, ExplainError> {
        let own = candidate.unknowns.iter().filter(|u| !current.fitted.unknowns.contains(u));
        let declared = self.study.case.unknowns();
        let brought: Vec<Unknown> = own.filter(|u| !declared.contains(u)).cloned().collect();
        let added = merge(&current.added, &brought);
        let unknowns = merge(&declared, &added);
        let (law, _) = Unknown::parted(&unknowns);
        let mut setting = candidate.setting.clone();
        let recovered = self.study.recovered(&setting)?;
        if let Some(base) = self.study.contact_base(&recovered, &setting, &law) {
            setting.law = base.law;
        }
        let mut effects = current.effects.clone();
        effects.push(candidate.effect);
        let mut found = self.study.whole(setting, &unknowns, (effects, added), 12)?;
        found.sensors = current.sensors.iter().copied().chain([candidate.sensor]).collect();
        Ok(found)
    }
}

/// Whether the effect `of` becomes the effect `simpler` at some value of its parameters.
fn contained(of: Option<&usize>, simpler: usize) -> bool {
    let of = of.map_or("", |&e| ALL[e].id());
    CONTAINED.iter().any(|(rich, plain)| *rich == of && *plain == ALL[simpler].id())
}

/// Effects that contain others: a lag of no time is the curve it lags behind, and so on.
const CONTAINED: [(&str, &str); 7] = [
    ("friction.lag", "friction.stribeck"),
    ("friction.film", "friction.stribeck"),
    ("friction.film", "friction.lag"),
    ("friction.ageing", "friction.stribeck"),
    ("friction.presliding-damping", "friction.viscous"),
    ("structure.second-support", "structure.cubic-stiffness"),
    ("friction.position-periodic", "friction.position"),
];
