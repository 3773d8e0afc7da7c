//! One effect more outside the contact.

use super::asked_again::LEFT;
use super::contact_rounds::TRACELESS;
use super::finer::MOST_TAKEN;
use super::{BALANCE_CALIBRATED, BALANCE_CLOSED, EVIDENCE, PROXY, Rival, Search, Tried};
use crate::balance_fit::BalanceCandidate;
use crate::contact_search::ContactCandidate;
use crate::effects::{ALL, ContactForm, EffectPlace, StructureForm, apply, few_places, listed};
use crate::force_laws::{CUBIC_BELOW, thresholds};
use crate::search::{Asked, Explained, NEAR};
use crate::study::merge;
use crate::{ExplainError, Unknown};
use frettrace_forward::accelerations::{Beside, Memory, Port, PortLaw, PortPlace, Quantity, Setting};
use rayon::prelude::*;

/// Effects outside the contact that are re-fitted with the whole model, and how many where more of them close the balance.
const REFITTED: usize = 4;
const MOST_REFITTED: usize = 7;

/// Steps of a fit of law and structure together.
const TOGETHER: usize = 60;

/// Displacement at which a cubic spring yields, over the largest on the beam: the least, where a fit starts, and the most. One that yields below
/// half the motion is a linear one.
const YIELDS: [f64; 3] = [0.5, 1.5, CUBIC_BELOW];

/// Effects of the contact whose force is that of a spring or a dashpot: recovered with what is declared of the structure, to its deviations, the contacts
/// take it for another frequency or damping, while the lines of the whole model near a resonance are off by many times their noise.
const LIKE_A_STRUCTURE: [&str; 2] = ["contact.tangential-stiffness", "friction.viscous"];

/// Share of the largest motion over which a corner is rounded where a fit of it starts.
const CORNER: f64 = 0.2;

/// Turns in which a fit and where its runs rest agree.
const REST_ROUNDS: usize = 3;

impl Search<'_> {
    /// Where structure effects start from: what was declared, or the model that already holds effects. A base fit of a law to
    /// an open balance bends the structure to what is missing.
    fn structural_start(&self, current: &Explained) -> Setting {
        if current.effects.is_empty() { self.declared_start(current) } else { current.fitted.setting.clone() }
    }

    /// The declared structure, calibrated on the balance where it is only loosely known, with a model's law.
    pub(super) fn declared_start(&self, model: &Explained) -> Setting {
        self.calibrated(self.study.case.setting(model.fitted.setting.law), &[])
    }

    /// A structure calibrated on the balance, with what else is free in it, where it is only loosely known.
    pub(super) fn calibrated(&self, setting: Setting, structural: &[Unknown]) -> Setting {
        if !self.study.case.loosely_known() {
            return setting;
        }
        let calibrated = self.study.balance_base(&setting, structural);
        if calibrated.reduced.is_finite() { calibrated.setting } else { setting }
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
        // Of a weak effect, or where the declared model is within the noise of the samples itself, that it is so with an effect says little.
        let done = |one: &Explained| one.complete() && one.left().is_noise();
        if contact.as_ref().is_some_and(done) {
            return Ok(contact);
        }
        let rivals = std::mem::take(&mut self.rivals);
        let found = self.in_hiding(current);
        let found = self.hopeful(current, found);
        let found = self.take_best(current, found).map(|found| self.with_formula(found));
        let found = found.map(|found| self.further(found, current.excess()));
        // A force that the balance does not show must leave nothing else to be explained.
        let ahead = |found: &Explained| {
            found.complete()
                && contact.as_ref().is_none_or(|contact| found.criterion + EVIDENCE < contact.criterion)
        };
        match found {
            Some(found) if ahead(&found) => {
                // Those of the contact stood behind its best one, which is a rival itself now.
                if let Some(contact) = &contact {
                    self.rivals.extend(Rival::of_better(&found, (contact, rivals)));
                }
                Ok(Some(found))
            }
            _ => {
                self.rivals = rivals;
                Ok(contact)
            }
        }
    }

    /// The best effect outside the contact of those whose tangents promise enough, or the balance where a contact has none, and of those of the contact that
    /// may hide in the structure, with the whole model.
    pub(super) fn hidden(&mut self, current: &Explained) -> Option<Explained> {
        let found = self.in_hiding(current);
        self.take_best(current, found)
    }

    /// All of these.
    fn in_hiding(&mut self, current: &Explained) -> Vec<Explained> {
        let (plain, candidates) = if current.fitted.setting.holds_rigidly() {
            self.shown_by_the_balance(current)
        } else {
            let study = self.coarse.as_ref().map_or(&self.study, |(study, _)| study);
            (current.criterion, study.tangent_candidates(current))
        };
        self.tried.extend(candidates.iter().map(|c| Tried {
            id: ALL[c.effect].id(),
            error: f64::NAN,
            evidence: plain - c.criterion,
        }));
        let worth = |c: &&BalanceCandidate| c.criterion + EVIDENCE < plain;
        let worthy: Vec<&BalanceCandidate> = candidates.iter().filter(worth).collect();
        let outside = worthy.par_iter().map(|c| self.asked(current, c));
        let of_contact = self.like_a_structure(current);
        let of_contact = of_contact.par_iter().map(|(effect, form)| {
            let mut begins = current.fitted.setting.clone();
            let unknowns = apply(&form.changes, &mut begins.law);
            self.known.asked(&self.study, current, (*effect, &begins, &unknowns), || {
                let start = current.fitted.setting.clone();
                self.study.with_changes(current, start, (*effect, &form.changes))
            })
        });
        let asked = outside.chain(of_contact).collect();
        self.answered(asked)
    }

    /// Effects outside a contact that has no tangents, of those that the balance has evidence for though it is closed within the noise, and what it costs
    /// without any: the recovered force takes most of what another one on the beam does, not all.
    fn shown_by_the_balance(&self, current: &Explained) -> (f64, Vec<BalanceCandidate>) {
        let setting = self.structural_start(current);
        let (plain, mut candidates) = self.structure_candidates(&setting, &current.added, &current.effects);
        BalanceCandidate::leave_one_of_each_kind(&mut candidates);
        candidates.retain(|candidate| candidate.criterion + EVIDENCE < plain.criterion);
        candidates.truncate(REFITTED);
        (plain.criterion, candidates)
    }

    /// Forms of the effects of the contact that may hide in the structure, of those that no whole model was fitted with yet: of an effect that was, the recovered
    /// contacts chose the form, and where it hides from them they choose any; a spring beside a rigid contact has no stiffness of that to hide in. None does
    /// where no contact force closes the balance, nor where the law misses the recovered contacts by far, which were recovered with what the structure
    /// leaves open: these show then what is missing. Those of a rigid contact do not tell.
    fn like_a_structure(&self, current: &Explained) -> Vec<(usize, ContactForm)> {
        let setting = &current.fitted.setting;
        let shown = || !setting.rigid && self.recovered(current).is_ok_and(|on| on.reduced > TRACELESS);
        if !self.closed(setting) || shown() {
            return Vec::new();
        }
        let may_hide =
            |effect: &usize| !current.effects.contains(effect) && self.study.case.allows(ALL[*effect].id());
        let effects = LIKE_A_STRUCTURE.iter().filter_map(|id| listed(id)).filter(may_hide);
        let is_new = |(effect, form): &(usize, ContactForm)| {
            let formula: Vec<Quantity> = form.formula().into_iter().map(Quantity::Law).collect();
            let has_it = |brought: &[Quantity]| formula.iter().all(|quantity| brought.contains(quantity));
            // Beside a rigid contact one form speaks for all.
            let was_asked = |(fitted, brought): &(usize, Vec<Quantity>)| {
                fitted == effect && (setting.rigid || has_it(brought))
            };
            !self.fitted_with.iter().any(was_asked)
        };
        let forms = |effect: usize| {
            let forms = ALL[effect].contact_forms(&setting.law, &self.study.scales);
            forms.into_iter().map(move |form| (effect, form))
        };
        effects.flat_map(forms).filter(is_new).collect()
    }

    /// Damping of a place by the square of the velocity with any power about it, and a cubic spring there with a yield, where that explains
    /// better: a tangent at rest knows the square and the cube only, and a laboratory's formula may be another.
    fn with_formula(&self, found: Explained) -> Explained {
        let Some((setting, port)) = without_last_port(&found) else { return found };
        let at_place = matches!(port.place, PortPlace::At(_)) && port.law == PortLaw::Polynomial;
        if !at_place || found.left().is_noise() {
            return found;
        }
        let [largest, fastest] = self.study.largest_motion();
        let (law, coefficients, range) = match port.coefficients {
            [0.0, 0.0, 0.0, square] => {
                let range = thresholds(&[], PortLaw::Power);
                (PortLaw::Power, [square * fastest * fastest, 2.0, fastest, 0.0], range)
            }
            [0.0, 0.0, cube, 0.0] => {
                let range = (YIELDS[0] * largest, YIELDS[2] * largest);
                (PortLaw::Yielding, [cube, YIELDS[1] * largest, 0.0, 0.0], Some(range))
            }
            _ => return found,
        };
        let other = (Port { law, coefficients, ..port }, range);
        self.in_other_laws(&found, &setting, vec![other]).unwrap_or(found)
    }

    /// A model whose last port, which `setting` is without, follows the best of other laws, each with the range of its threshold; `None` where none of
    /// them explains better.
    fn in_other_laws(
        &self,
        found: &Explained,
        setting: &Setting,
        ports: Vec<(Port, Option<(f64, f64)>)>,
    ) -> Option<Explained> {
        let fitted = ports.into_par_iter().filter_map(|(port, range)| {
            let free = if port.law.has_corner() { &[0, 1, 2, 3][..] } else { &[0, 1] };
            self.study.polished(&in_form(found, self.study.form(setting, port, (free, range)))).ok()
        });
        let best = fitted.min_by(Explained::by_criterion)?;
        (best.criterion + EVIDENCE < found.criterion).then_some(best)
    }

    /// A single complete name of the contact that leaves more than the noise, or what it is known to be mistaken for outside the contact, where that explains
    /// better: the balance, which no law takes part in, may not tell the two apart, so that nobody has asked.
    pub(super) fn against_outsiders(&mut self, baseline: &Explained, model: Explained) -> Explained {
        if !model.is_single() || ALL[model.effects[0]].place() != EffectPlace::Contact {
            return model;
        }
        let alike = ALL[model.effects[0]].acts_like_one_outside(&model.fitted.setting.law);
        let leaves_noise = || model.left().is_noise() && model.ratio <= LEFT;
        // What the grid of a rigid contact may be wrong by is nothing that a name leaves.
        if !alike && (leaves_noise() || self.is_of_grid(&model)) {
            return model;
        }
        let (case, setting) = (self.study.case, self.declared_start(baseline));
        let outside = |&effect: &usize| {
            let (id, place) = (ALL[effect].id(), ALL[effect].place());
            place != EffectPlace::Contact && case.allows(id) && self.tried.iter().all(|tried| tried.id != id)
        };
        let rivals: Vec<usize> =
            ALL[model.effects[0]].rivals().iter().filter_map(|id| listed(id)).filter(outside).collect();
        let mut candidates: Vec<BalanceCandidate> = Vec::new();
        let mut formless: Vec<usize> = Vec::new();
        for effect in rivals {
            let mut forms = ALL[effect].structure_forms(case, &setting, &self.study.scales);
            // A contact that holds rigidly has no tangents to locate a force by.
            if self.study.locates() && !setting.holds_rigidly() {
                forms.retain(|form| !form.adds_a_force(&setting));
            }
            if forms.is_empty() {
                formless.push(effect);
            }
            let unfitted = |form| BalanceCandidate::unfitted(effect, form, baseline.criterion);
            candidates.extend(few_places(forms).into_iter().map(unfitted));
        }
        // What the balance of many sensors locates is asked without a law.
        if !formless.is_empty() {
            let located = self.study.tangent_candidates(baseline).into_iter();
            candidates.extend(located.filter(|candidate| formless.contains(&candidate.effect)));
        }
        let asked = candidates.par_iter().map(|candidate| self.asked(baseline, candidate)).collect();
        let found = self.answered(asked).into_iter().filter(Explained::complete);
        let Some(mut other) = found.min_by(Explained::by_criterion) else { return model };
        other.book(baseline);
        // Neither may be named for a longer fit than the other's.
        other = self.with_formula(self.study.polished_or_as_it_is(other));
        let behind = other.criterion - model.criterion;
        let error = self.study.error(&other.fitted, &self.study.training).relative();
        // That over the declared model as it was when the contact was asked.
        let evidence = self.evidence_of_one_better_by(-behind, model.effects[0]);
        let evidence = evidence.unwrap_or(baseline.criterion - other.criterion);
        self.tried.push(Tried { id: ALL[other.effects[0]].id(), error, evidence });
        if behind + EVIDENCE < 0.0 {
            self.rivals = Rival::of_better(&other, (&model, std::mem::take(&mut self.rivals)));
            return other;
        }
        self.rivals.extend(Rival::of(&other, behind));
        model
    }

    /// Effects outside the contact on the balance, best first, and what it costs without any: around a setting, beside what effects that are taken
    /// already have added.
    pub(super) fn structure_candidates(
        &self,
        setting: &Setting,
        added: &[Unknown],
        taken: &[usize],
    ) -> (BalanceCandidate, Vec<BalanceCandidate>) {
        let (_, structural) = Unknown::parted(added);
        let plain = self.study.balance_base(setting, &structural);
        let located = match self.study.locates_beside(setting) {
            true => self.study.force_candidates(setting, plain.criterion),
            false => Vec::new(),
        };
        let by_law = located.is_empty() && self.study.asks_forces_by_law(setting, plain.reduced);
        let mut candidates = self.study.balance_candidates(setting, &structural, (taken, by_law));
        candidates.extend(located);
        if setting.ports.is_empty() {
            candidates.extend(self.study.base_candidate(setting, plain.criterion));
        }
        candidates.sort_by(BalanceCandidate::by_criterion);
        (plain, candidates)
    }

    /// Effects outside the contact that bring χ² per degree of freedom of the balance below `limit`.
    pub(super) fn structure_round(
        &mut self,
        current: &Explained,
        limit: f64,
    ) -> Result<Option<Explained>, ExplainError> {
        let setting = self.structural_start(current);
        let (plain, mut candidates) = self.structure_candidates(&setting, &current.added, &current.effects);
        // One form of each effect is re-fitted, of the best effect two: on recovered forces close forms change places.
        let leader = candidates.first().map(|c| c.effect);
        let mut seen = Vec::new();
        candidates.retain(|c| {
            let before = seen.iter().filter(|kind| **kind == c.kind()).count();
            seen.push(c.kind());
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
        // A place is an effect's, whatever the number of its forms.
        let mut effects = Vec::new();
        let placed: Vec<(usize, &BalanceCandidate)> = candidates
            .iter()
            .map(|candidate| {
                if !effects.contains(&candidate.effect) {
                    effects.push(candidate.effect);
                }
                (effects.len() - 1, candidate)
            })
            .collect();
        let asked = placed
            .par_iter()
            .filter(|(place, _)| *place < MOST_REFITTED)
            .filter(|(place, c)| worthy(*place, c) && c.criterion < 3.0 * best && c.reduced < limit)
            .map(|(_, candidate)| self.asked(current, candidate))
            .collect();
        let found = self.answered(asked);
        let Some(best) = self.take_best(current, found) else { return Ok(None) };
        let other = self.with_corner(&best).unwrap_or_else(|| self.with_formula(best.clone()));
        let nearer = best.criterion - other.criterion;
        self.rivals.iter_mut().for_each(|rival| rival.behind += nearer);
        Ok(Some(other))
    }

    /// A stop or a play along the beam with a corner of some length, where that explains better: what touches first is rough, or held softly.
    fn with_corner(&self, found: &Explained) -> Option<Explained> {
        let (mut setting, mut port) = without_last_port(found)?;
        // Where runs rest was read off with a corner of no length.
        setting.rests.1.clear();
        let [stiffness, gap, _, side] = port.coefficients;
        if !matches!(port.place, PortPlace::At(_)) || found.left().is_noise() {
            return None;
        }
        let [largest, _] = self.study.largest_motion();
        match port.law {
            PortLaw::Gap => port.coefficients[3] = CORNER * largest,
            PortLaw::Stop => port.coefficients[3] = (CORNER * largest).copysign(side),
            PortLaw::Round => {
                // The tangent where it is pressed furthest, and where that begins.
                let depth = (largest - gap).max(CORNER * largest);
                let tangent = 1.5 * stiffness * depth.sqrt();
                port.law = PortLaw::Stop;
                port.coefficients = [tangent, gap + depth / 3.0, 0.0, (CORNER * largest).copysign(side)];
            }
            _ => return None,
        }
        let mut ports = vec![(port, thresholds(&[], port.law))];
        if port.law == PortLaw::Stop {
            port.law = PortLaw::Rough;
            ports.push((port, thresholds(&[], port.law)));
        }
        self.in_other_laws(found, &setting, ports)
    }

    /// A model with a stop in which runs rest elsewhere, these and everything else in turns; `lacked` is the excess before it.
    pub(super) fn rested(&self, mut found: Explained, lacked: f64) -> Explained {
        // Far from the data it is not where runs rest that the model misses.
        let far = found.ratio > NEAR && found.excess() > MOST_TAKEN * lacked;
        if found.fitted.setting.rests.1.is_empty() || far {
            return found;
        }
        for _ in 0..REST_ROUNDS {
            let Some(rests) = self.study.rests(&found.fitted.setting) else { break };
            let mut other = found.clone();
            other.fitted.setting.rests.1 = rests;
            match self.study.polished(&other) {
                Ok(better) if better.criterion + EVIDENCE < found.criterion => found = better,
                _ => break,
            }
        }
        if found.complete() {
            return found;
        }
        self.of_own_mean(&found).filter(|own| own.criterion < found.criterion).unwrap_or(found)
    }

    /// The same with the mean that the law itself gives every run, and the gap free: where runs rest was read off forces recovered beside a
    /// contact, and a fit holds to it.
    fn of_own_mean(&self, found: &Explained) -> Option<Explained> {
        let mut other = found.clone();
        let setting = &mut other.fitted.setting;
        setting.rests.1.clear();
        let port = setting.ports.pop()?;
        let form = self.study.form(setting, port, (&[1], thresholds(&[], port.law)));
        setting.ports.push(port);
        other.added.extend(form.unknowns.into_iter().filter(|u| matches!(u.quantity, Quantity::Port(..))));
        self.study.polished(&other).ok()
    }

    pub(super) fn asked(&self, current: &Explained, candidate: &BalanceCandidate) -> Asked {
        let BalanceCandidate { effect, setting, unknowns, .. } = candidate;
        let by = (*effect, setting, &unknowns[..]);
        self.known.asked(&self.study, current, by, || self.with_structure(current, candidate))
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
        let mut base = self.study.contact_base(&self.study.recovered(&setting)?, &setting, &law);
        // A force on the beam whose law is only near the right one bends the contact that is recovered beside it: its lines are freed.
        let acts = setting.ports.last().is_some_and(|port| matches!(port.place, PortPlace::At(_)));
        if acts && !base.as_ref().is_some_and(ContactCandidate::meets) {
            let free = self.study.recovered_beside(&setting, Beside::Ports)?;
            let other = self.study.contact_base(&free, &setting, &law);
            base = base.into_iter().chain(other).min_by(|a, b| a.reduced.total_cmp(&b.reduced));
        }
        let met = base.as_ref().is_some_and(ContactCandidate::meets);
        if let Some(base) = base {
            setting = base.placed_in(&setting);
        }
        let mut effects = current.effects.clone();
        effects.push(candidate.effect);
        let together = |setting: Setting, memory: &Memory| {
            let fitted = self.study.fitted(setting, &unknowns, memory, TOGETHER).ok()?;
            Some(self.study.judged(fitted, effects.clone(), added.clone()))
        };
        let cold = self.study.whole(setting.clone(), &unknowns, (effects.clone(), added.clone()), 12);
        // Where a run of a rigid contact has no answer from rest, it may have one beside that of the model without the effect.
        let mut found = cold.or_else(|unsolved| {
            let Setting { rigid, law, .. } = current.fitted.setting;
            let laws = [setting.law, law].into_iter().filter(|_| rigid);
            let mut warm = laws.map(|law| Setting { law, ..setting.clone() });
            warm.find_map(|setting| together(setting, &current.fitted.memory)).ok_or(unsolved)
        })?;
        // Where the balance closes and a law meets its contacts, a fit that ends far from the data has bent the law to what a resonance makes of
        // the rest of the structure's error: law and structure go together from the start.
        if met
            && candidate.reduced < BALANCE_CLOSED
            && found.ratio > NEAR
            && let Some(other) = together(setting, &self.study.model.memory())
            && other.criterion < found.criterion
        {
            found = other;
        }
        let found = self.rested(found, current.excess());
        let mut found = if found.complete() { found } else { self.study.with_shape(&found).unwrap_or(found) };
        found.sensors = current.sensors.iter().copied().chain([candidate.sensor]).collect();
        Ok(found)
    }
}

/// The setting of a model without the port that its last effect has brought, and that port; `None` where it has brought none.
fn without_last_port(found: &Explained) -> Option<(Setting, Port)> {
    let mut setting = found.fitted.setting.clone();
    let port = setting.ports.pop()?;
    let is_of_port = |u: &Unknown| matches!(u.quantity, Quantity::Port(k, _) if k == setting.ports.len());
    let own = found.own(found.effects.len().checked_sub(1)?);
    own.iter().any(is_of_port).then_some((setting, port))
}

/// A model with its last effect in another form.
fn in_form(found: &Explained, form: StructureForm) -> Explained {
    let mut other = found.clone();
    other.fitted.setting = form.setting;
    if let Some(count) = other.counts.last_mut() {
        other.added.truncate(found.added.len() - *count);
        *count = form.unknowns.len();
    }
    other.added.extend(form.unknowns);
    other
}
