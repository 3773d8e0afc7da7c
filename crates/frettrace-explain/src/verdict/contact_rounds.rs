//! One effect more in the contact.

use super::{EVIDENCE, FORETOLD, PROXY, Rival, Search, Tried};
use crate::contact_fit::Contacts;
use crate::contact_search::{ContactCandidate, within_reach};
use crate::effects::{ALL, EffectPlace};
use crate::search::{COMPLETE, Explained, excess};
use crate::study::merge;
use crate::{ExplainError, Unknown};
use frettrace_forward::accelerations::Setting;
use frettrace_friction::effects::ModifiedLaw;
use std::sync::Arc;

/// χ² per residual on the recovered contacts from which no whole model with a law may leave a trace: ten times what the method
/// leaves of the right one at the lowest noise.
pub(super) const TRACELESS: f64 = 500.0;

/// Recovered contacts with what the law of a model makes of them.
pub(super) struct Recovered {
    pub(super) contacts: Contacts,
    /// The structure that they were recovered with, and the law fitted to them.
    pub(super) setting: Setting,
    /// What is free in that law.
    pub(super) law: Vec<Unknown>,
    /// `χ² + k ln n` that it leaves there, and χ² per residual.
    pub(super) plain: f64,
    pub(super) reduced: f64,
}

impl Search<'_> {
    /// The same model from the law that the contacts recovered with it show, where that ends nearer: the fit of the whole rig may
    /// have come to rest in another valley, and an effect may not be named for that.
    pub(super) fn restarted(&self, current: &Explained) -> Option<Explained> {
        let unknowns = merge(&self.study.case.unknowns(), &current.added);
        let (law, _) = Unknown::parted(&unknowns);
        if !self.closed(&current.fitted.setting) {
            return None;
        }
        let mut setting = self.unbent(current);
        let recovered = self.study.recovered(&setting).ok()?;
        let mut base = self.study.contact_base(&recovered, &setting, &law)?;
        if current.effects.is_empty() && base.meets() {
            // Every effect would stand in for what the declared law does with other values.
            base = self.study.contact_base_from_all_about(&recovered, &setting, &law, base)?;
        }
        // An effect of another laboratory's formula need not meet the contacts.
        if !base.meets() && current.effects.is_empty() {
            return None;
        }
        setting = base.placed_in(&setting);
        let named = (current.effects.clone(), current.added.clone());
        let mut found = self.study.whole(setting, &unknowns, named, 15).ok()?;
        found.sensors.clone_from(&current.sensors);
        found.counts.clone_from(&current.counts);
        // Where the error of a rigid contact's grid counts among the deviations, a model far from the data has less of a criterion.
        let misled = current.fitted.setting.rigid && found.ratio > current.ratio;
        let nearer = found.criterion + EVIDENCE < current.criterion && !misled;
        nearer.then_some(found)
    }

    /// The structure of a model as it was declared, calibrated on the balance where it is loosely known: what the fit of the whole rig
    /// has bent it to may be what the law lacks. What effects have brought stays.
    fn unbent(&self, model: &Explained) -> Setting {
        let mut setting = model.fitted.setting.clone();
        for Unknown { quantity, parameter } in self.study.case.unknowns() {
            let brought = model.added.iter().any(|u| u.quantity == quantity);
            if let Some(prior) = parameter.prior.filter(|_| !brought) {
                setting.set(quantity, prior.mean);
            }
        }
        let (_, structural) = Unknown::parted(&model.added);
        self.calibrated(setting, &structural)
    }

    /// The contacts recovered with the structure of a model as it was declared, and its law on them.
    pub(super) fn recovered(&self, current: &Explained) -> Result<Arc<Recovered>, ExplainError> {
        // A fit of the whole rig that lacks an effect may have driven the law away from what the contact shows.
        let other = self.law_on_contacts().filter(|_| current.effects.is_empty());
        self.known.recovered(&self.study, (current, other), || self.recovered_with(current, other))
    }

    fn recovered_with(
        &self,
        current: &Explained,
        other: Option<ModifiedLaw<f64>>,
    ) -> Result<Recovered, ExplainError> {
        let unknowns = merge(&self.study.case.unknowns(), &current.added);
        let (law, _) = Unknown::parted(&unknowns);
        let mut setting = self.unbent(current);
        let contacts = self.study.recovered(&setting)?;
        let laws: Vec<ModifiedLaw<f64>> = std::iter::once(setting.law).chain(other).collect();
        let base = self.study.contact_base_from(&contacts, &setting, &law, &laws);
        let [plain, reduced] =
            base.as_ref().map_or([f64::INFINITY; 2], |base| [base.criterion, base.reduced]);
        if let Some(base) = &base {
            setting.law = base.law;
        }
        Ok(Recovered { contacts, setting, law, plain, reduced })
    }

    /// Every effect of the contact on the contacts that were recovered with a model, beside those that it has.
    pub(super) fn candidates_on(
        &self,
        recovered: &Arc<Recovered>,
        softened: bool,
        current: &Explained,
    ) -> Vec<ContactCandidate> {
        let Recovered { contacts, setting, law, reduced, .. } = &**recovered;
        self.known.candidates(recovered, (softened, &self.study.case.without), || {
            let taken = (&current.effects[..], *reduced);
            self.study.contact_candidates((contacts, softened), setting, law, taken)
        })
    }

    /// The best effect of the contact with the whole model, and all that were fitted. The search may begin on softened lines, where the
    /// law misses even those.
    fn contact_round(
        &mut self,
        current: &Explained,
        softened: bool,
    ) -> Result<Option<(Explained, Vec<Explained>)>, ExplainError> {
        let recovered = self.recovered(current)?;
        let Recovered { contacts, setting, law, plain, .. } = &*recovered;
        if softened && !self.study.is_far(contacts, setting, law) {
            return Ok(None);
        }
        let mut candidates = self.candidates_on(&recovered, softened, current);
        self.tried.extend(candidates.iter().map(|c| Tried {
            id: ALL[c.effect].id(),
            error: f64::NAN,
            evidence: plain - c.criterion,
        }));
        if self.most_effects == 1 {
            // In the place of a name that leaves a trace stands one that leaves none, or none does.
            candidates.retain(|candidate| candidate.reduced < TRACELESS);
        }
        let asked = self.study.contact_round(current, &candidates);
        let mut found = self.answered(asked);
        found.sort_by(Explained::by_criterion);
        Ok(self.take_best(current, found.clone()).map(|best| (best, found)))
    }

    /// A round over the contact, fitted to its end; where that does not complete the declared model and its law is far from the contacts, the
    /// same from softened lines, where that completes it or comes nearer by far. With an effect in it a law has come near enough.
    pub(super) fn contact(&mut self, current: &Explained) -> Result<Option<Explained>, ExplainError> {
        let before = current.effects.is_empty().then(|| self.clone());
        let found = self.contact_to_its_end(current, false)?;
        let is_complete = found.as_ref().is_some_and(Explained::complete);
        let Some(mut other) = before.filter(|_| !is_complete) else { return Ok(found) };
        let Some(softened) = other.contact_to_its_end(current, true)? else { return Ok(found) };
        // What leaves a trace, and a tenth of what is left from the lines as they are, is the mechanism, in another formula than here.
        let ahead = || found.as_ref().is_none_or(|found| softened.is_far_ahead(found.excess()));
        if softened.complete() || softened.leaves_a_trace(current) && ahead() {
            *self = other;
            return Ok(Some(softened));
        }
        Ok(found)
    }

    /// The last effect of a model that has most of what was `lacked`, in another of its forms where that does better on the contacts recovered
    /// with it: the forms were tried on a law that missed the contacts by far, and from there the right one may lead nowhere.
    fn reformed(&mut self, from: &Explained, model: Explained, lacked: f64) -> Explained {
        let Some(&effect) = model.effects.last() else { return model };
        let fits = model.complete() && model.left().is_noise() && !self.series_contradicts(&model);
        if fits || model.excess() > PROXY * lacked {
            return model;
        }
        let setting = self.unbent(&model);
        let Ok(recovered) = self.study.recovered(&setting) else { return model };
        let (law, _) = Unknown::parted(&merge(&self.study.case.unknowns(), &from.added));
        let (own, _) = Unknown::parted(model.own(model.effects.len() - 1));
        let forms = self.study.better_forms(&recovered, &setting, &law, (effect, &own));
        let asked = self.study.contact_round(from, &forms);
        let better = self.answered(asked).into_iter().min_by(Explained::by_criterion);
        match better.filter(|better| better.criterion + EVIDENCE < model.criterion) {
            Some(better) => {
                let better = self.further(better, lacked);
                self.shaped(better, lacked)
            }
            None => model,
        }
    }

    /// A single name that follows the fitted runs and misses those held out, in the form that foretells these, of those that follow the fitted
    /// ones as well: a name is no formula, and the fitted runs may not tell one formula from another. Where the name does so in none, one of its rivals
    /// may.
    pub(super) fn in_the_form_that_foretells(&mut self, baseline: &Explained, model: Explained) -> Explained {
        if !model.is_single() {
            return model;
        }
        let (effect, missed) = (model.effects[0], self.held_out_ratio(&model));
        if ALL[effect].place() != EffectPlace::Contact || missed <= FORETOLD {
            return model;
        }
        let setting = self.unbent(&model);
        let Ok(recovered) = self.study.recovered(&setting) else { return model };
        let (law, _) = Unknown::parted(&merge(&self.study.case.unknowns(), &baseline.added));
        let (own, _) = Unknown::parted(model.own(0));
        let bare = self.study.bare(&setting, (effect, &own));
        let follows = |rival: &&Rival| {
            let of_contact = ALL[rival.effect].place() == EffectPlace::Contact;
            of_contact && rival.effect != effect && rival.excess <= excess(COMPLETE)
        };
        let mut names = vec![effect];
        for rival in self.rivals.iter().filter(follows) {
            if !names.contains(&rival.effect) {
                names.push(rival.effect);
            }
        }
        let id = ALL[effect].id();
        let mut nearest = f64::INFINITY;
        for name in names {
            let mut forms = self.study.forms_of(&recovered, &bare, &law, name);
            nearest = forms.iter().map(|form| form.criterion).fold(nearest, f64::min);
            forms.retain(|form| within_reach(form.criterion, nearest));
            let Some(other) = self.that_foretells(baseline, &forms) else { continue };
            if name == effect {
                self.notes.push(format!(
                    "{id} has several formulas that follow the fitted runs, and the one that foretells the runs held out is taken: it was at {missed:.2} times the noise there in another"
                ));
            } else {
                self.notes.push(format!(
                    "{id} follows the fitted runs and is at {missed:.2} times the noise in those held out in all its formulas: {} foretells them",
                    ALL[name].id()
                ));
                // Evidence is that of all runs: the fitted ones do not tell the two apart.
                let behind = self.weight(&model) - self.weight(&other);
                self.rivals.retain(|rival| ![name, effect].contains(&rival.effect));
                self.rivals = Rival::of_one_better_by(behind, (&model, std::mem::take(&mut self.rivals)));
            }
            return other;
        }
        model
    }

    /// The form that foretells the runs held out best, of those that follow the fitted ones with the whole model; `None` where none foretells them.
    fn that_foretells(&mut self, baseline: &Explained, forms: &[ContactCandidate]) -> Option<Explained> {
        let asked = self.study.contact_round(baseline, forms);
        let followed = self.answered(asked).into_iter().filter(Explained::complete);
        let judged = followed.map(|one| (self.held_out_ratio(&one), one));
        let best = judged.min_by(|a, b| a.0.total_cmp(&b.0));
        best.filter(|(ratio, _)| *ratio <= FORETOLD).map(|(_, one)| one)
    }

    fn contact_to_its_end(
        &mut self,
        current: &Explained,
        softened: bool,
    ) -> Result<Option<Explained>, ExplainError> {
        let Some((best, others)) = self.contact_round(current, softened)? else { return Ok(None) };
        let lacked = current.excess();
        let (was, followed) = (best.criterion, best.complete());
        let best = self.further(best, lacked);
        let best = self.shaped(best, lacked);
        let best = self.reformed(current, best, lacked);
        if best.complete() {
            return Ok(Some(if followed { best } else { self.among_the_near(was, best) }));
        }
        // What does better with one formula may be no nearer to another's than what does worse.
        let takes_its_own = |one: &Explained| one.excess() <= PROXY * lacked;
        let others = others.into_iter().filter(|one| one.effects != best.effects && takes_its_own(one));
        let shaped = others.filter_map(|other| {
            let mut search = self.clone();
            let other = search.shaped(other, lacked);
            let other = search.reformed(current, other, lacked);
            other.complete().then_some((search, other))
        });
        let Some((search, found)) = shaped.min_by(|a, b| a.1.by_criterion(&b.1)) else {
            return Ok(Some(best));
        };
        *self = search;
        self.rivals = Rival::of_better(&found, (&best, std::mem::take(&mut self.rivals)));
        self.rivals.retain(|rival| Some(&rival.effect) != found.effects.last());
        Ok(Some(found))
    }
}
