//! What the contact's recovered motion says of the declared law and of each candidate.

use crate::Study;
use crate::contact_fit::{ContactProblem, Contacts, Leeway, Moved, Recovered, mean_force, recover};
use crate::effects::{ALL, Change, ContactForm, Effect, apply, freed, set_by_forms};
use crate::law_starts::starts;
use crate::study::{as_declared, merge};
use crate::verdict::EVIDENCE;
use crate::{ExplainError, Unknown};
use frettrace_forward::accelerations::{
    AccelerationError, Beside, FrequencyRatio, Memory, Quantity, Setting,
};
use frettrace_friction::effects::{Hook, ModifiedLaw};
use frettrace_identify::{Model, Status};
use rayon::prelude::*;
use std::cmp::Ordering;
use std::collections::HashSet;
use std::sync::Arc;

mod base;
mod looks;

pub(crate) use looks::few_of_each;

/// Steps from a start, before the best get …
const BEGIN: usize = 8;
/// … the most that any gets.
const ALL_STEPS: usize = 30;

/// Effects that get the further values of their shape where none meets the contacts.
const SHAPED: usize = 3;

/// A law on recovered contacts, with what it costs.
#[derive(Clone)]
pub(crate) struct ContactCandidate {
    pub effect: usize,
    pub law: ModifiedLaw<f64>,
    pub modulation: FrequencyRatio,
    pub unknowns: Vec<Unknown>,
    /// `χ² + k ln n` on the recovered contacts.
    pub criterion: f64,
    /// χ² per residual.
    pub reduced: f64,
    /// Whether a value that the effect brought lies on its bound: there the effect, or a part of its form, is not used.
    pub bound: bool,
    /// Values of the structure that go with the law, where it leaves any open.
    pub structure: Vec<(Quantity, f64)>,
    /// Mean slips (m) of the recovered contacts where friction depends on the place, each with the index of its run.
    means: Vec<(usize, f64)>,
    /// Whether more steps promise more.
    open: bool,
}

impl ContactCandidate {
    /// The order of two by what they cost, the nearer one first.
    pub fn by_criterion(&self, other: &Self) -> Ordering {
        self.criterion.total_cmp(&other.criterion)
    }

    /// Whether its law is one that the contact may have.
    pub fn meets(&self) -> bool {
        self.reduced < POOR
    }

    /// A setting with the law, and with the structure that goes with it: that of a law which misses the contacts may be any.
    pub fn placed_in(&self, setting: &Setting) -> Setting {
        let mut setting = Setting { law: self.law, modulation: self.modulation, ..setting.clone() };
        if self.meets() {
            self.structure.iter().for_each(|&(quantity, value)| setting.set(quantity, value));
        }
        setting
    }
}

/// Whether a candidate is so near the best one that the whole model may be fitted with it.
pub(crate) fn within_reach(criterion: f64, best: f64) -> bool {
    criterion < 3.0 * best + 500.0
}

/// χ² per residual on the recovered contacts from which a law misses them, and other starts of it are tried.
pub(crate) const POOR: f64 = 4.0;

impl Study<'_> {
    /// Recovered contacts of the training runs, and of those that are not periodic.
    pub(crate) fn recovered(&self, setting: &Setting) -> Result<Contacts, ExplainError> {
        self.recovered_beside(setting, Beside::Nothing)
    }

    /// The same with something free beside the contact force.
    pub(crate) fn recovered_beside(
        &self,
        setting: &Setting,
        beside: Beside,
    ) -> Result<Contacts, ExplainError> {
        let periodic = self.recovered_runs(setting, &self.training, beside)?;
        let series = self.series.iter().filter(|_| as_declared(setting)).cloned();
        let leeway = self.leeway(setting, &periodic, beside)?.map(Arc::new);
        Ok(Contacts { periodic, series: series.collect(), leeway })
    }

    /// What values that are declared of the structure, to their deviations, leave open in the recovered contacts of the training runs.
    fn leeway(
        &self,
        setting: &Setting,
        plain: &[Recovered],
        beside: Beside,
    ) -> Result<Option<Leeway>, AccelerationError> {
        let declared = self.case.unknowns();
        let moved: Result<Vec<Moved>, AccelerationError> = declared
            .par_iter()
            .filter_map(|unknown| {
                let (quantity, bounds) = (unknown.quantity, unknown.parameter.bounds);
                let std = unknown.parameter.prior?.std;
                let value = setting.get(quantity)?;
                let mut other = setting.clone();
                other.set(quantity, value + std);
                let contacts = self.recovered_runs(&other, &self.training, beside);
                Some(contacts.map(|contacts| Moved { quantity, value, std, bounds, contacts }))
            })
            .collect();
        Ok(Leeway::new(plain.to_vec(), moved?, (&setting.law, setting.modulation)))
    }

    fn recovered_runs(
        &self,
        setting: &Setting,
        runs: &[usize],
        beside: Beside,
    ) -> Result<Vec<Recovered>, AccelerationError> {
        let selected: Vec<(usize, usize)> =
            runs.iter().map(|&run| (run, self.case.records[run].subharmonic)).collect();
        recover(&self.model, setting, (&selected, beside))
    }

    /// Where the balance of the runs begins with the law of a setting: where friction depends on the contact's place, at the place
    /// that their recovered contacts show, as far as the memory does not know it.
    pub(crate) fn begin(&self, setting: &Setting, runs: &[usize], memory: &mut Memory) {
        if !setting.law.depends_on_place() {
            return;
        }
        let new: Vec<usize> = runs.iter().copied().filter(|&run| !memory.knows(run)).collect();
        let Ok(recovered) = self.recovered_runs(setting, &new, Beside::Nothing) else { return };
        let law = (setting.law, setting.modulation);
        let means: Vec<Option<f64>> = recovered.par_iter().map(|contact| mean_force(contact, law)).collect();
        for (&run, mean) in new.iter().zip(means) {
            if let Some(mean) = mean {
                memory.begin_from(run, mean);
            }
        }
    }

    /// A form of an effect on the recovered contacts, fitted to its end: on what is quick to march first.
    fn contact_candidate(
        &self,
        recovered: &Contacts,
        setting: &Setting,
        law_unknowns: &[Unknown],
        form: (usize, &ContactForm),
        most: usize,
    ) -> Option<ContactCandidate> {
        let first = self.contact_steps(&recovered.quick(), setting, law_unknowns, form, (None, most));
        let around = first.as_ref().map(|found| recovered.around(&found.law, found.modulation));
        let recovered = around.as_ref().unwrap_or(recovered);
        self.contact_steps(recovered, setting, law_unknowns, form, (first.as_ref(), most))
    }

    /// A few steps of the fit of a form on the recovered contacts, from the values of one fitted before, if any.
    fn contact_steps(
        &self,
        recovered: &Contacts,
        setting: &Setting,
        law_unknowns: &[Unknown],
        (effect, form): (usize, &ContactForm),
        (from, most): (Option<&ContactCandidate>, usize),
    ) -> Option<ContactCandidate> {
        let mut law = setting.law;
        let added = apply(&form.changes, &mut law);
        let unknowns = merge(law_unknowns, &added);
        let sizes = [self.scales.preload, self.fastest(recovered)];
        let (hooks, parameters) = Unknown::hooks(&unknowns, (&law, setting.rigid), sizes);
        let modulation = form.modulation.unwrap_or(setting.modulation);
        let law = from.map_or(law, |begun| begun.law);
        let problem = ContactProblem::new(recovered, (law, modulation), (hooks, parameters));
        let means = from.map_or_else(Vec::new, |begun| problem.means_from(&begun.means));
        let fit = problem.solve(most, &means).ok()?;
        let count = problem.residual_count() as f64;
        let brought = |hook: &Hook| added.iter().any(|u| u.quantity == Quantity::Law(*hook));
        let bound = problem.is_bound(&fit, brought);
        Some(ContactCandidate {
            reduced: fit.cost / count,
            bound,
            effect,
            law: problem.at(&fit.values),
            modulation,
            criterion: fit.cost + fit.values.len() as f64 * count.ln(),
            structure: problem.structure(&fit.values),
            means: problem.mean_slips(&fit.values),
            open: fit.status == Status::IterationLimit,
            unknowns,
        })
    }

    /// A candidate with the further values of its effect's shape, from the values it has come to; `None` where these explain nothing.
    fn contact_shape(
        &self,
        recovered: &Contacts,
        setting: &Setting,
        from: &ContactCandidate,
    ) -> Option<ContactCandidate> {
        self.contact_with(recovered, setting, from, ALL[from.effect].shape(&from.law, &self.scales))
    }

    /// A candidate in the other shape of its effect, from the values it has come to without its first one; `None` where it has no other, or that explains
    /// no more.
    pub(crate) fn in_its_other_shape(
        &self,
        recovered: &Contacts,
        setting: &Setting,
        from: &ContactCandidate,
    ) -> Option<ContactCandidate> {
        let mut plain = from.clone();
        for change in ALL[from.effect].shape(&from.law, &self.scales) {
            plain.law.clear(change.hook);
            plain.unknowns.retain(|unknown| unknown.quantity != Quantity::Law(change.hook));
        }
        self.contact_with(recovered, setting, &plain, ALL[from.effect].other_shape(&plain.law, &self.scales))
    }

    /// A candidate with further values of a law.
    fn contact_with(
        &self,
        recovered: &Contacts,
        setting: &Setting,
        from: &ContactCandidate,
        changes: Vec<Change>,
    ) -> Option<ContactCandidate> {
        let mut begun = from.clone();
        let brought = freed(changes, &mut begun.law, &from.unknowns);
        if brought.is_empty() {
            return None;
        }
        let setting = Setting { law: begun.law, modulation: from.modulation, ..setting.clone() };
        let unknowns = merge(&from.unknowns, &brought);
        let form = (from.effect, &ContactForm::new(Vec::new()));
        let found = self.contact_steps(recovered, &setting, &unknowns, form, (Some(&begun), ALL_STEPS))?;
        (found.criterion + EVIDENCE < from.criterion).then_some(found)
    }

    /// The forms of an effect on the recovered contacts, each from the law that the effect was found with and without its `own` values, best
    /// first: the form that this law has where that does better anew, and others that are not ruled out there. What the nearest form leaves
    /// beside the noise is what the contacts were recovered with, and evidence counts by it.
    pub(crate) fn better_forms(
        &self,
        recovered: &Contacts,
        setting: &Setting,
        law_unknowns: &[Unknown],
        (effect, own): (usize, &[Unknown]),
    ) -> Vec<ContactCandidate> {
        let as_it_is = ContactForm::new(Vec::new());
        let known = merge(law_unknowns, own);
        let current = self.contact_candidate(recovered, setting, &known, (effect, &as_it_is), ALL_STEPS);
        let Some(current) = current else { return Vec::new() };
        let bare = self.bare(setting, (effect, own));
        let mut found = self.forms_of(recovered, &bare, law_unknowns, effect);
        let chance = EVIDENCE * current.reduced.max(1.0);
        let is_same = |one: &ContactCandidate| {
            let is_known = |u: &Unknown| known.iter().any(|k| k.quantity == u.quantity);
            one.unknowns.len() == known.len() && one.unknowns.iter().all(is_known)
        };
        found.retain(|one| {
            let margin = if is_same(one) { -EVIDENCE } else { chance };
            one.criterion < current.criterion + margin
        });
        found
    }

    /// A setting whose law is without an effect of its own values.
    pub(crate) fn bare(&self, setting: &Setting, (effect, own): (usize, &[Unknown])) -> Setting {
        let mut bare = setting.clone();
        own.iter().for_each(|unknown| {
            bare.clear(unknown.quantity);
        });
        set_by_forms(effect, &setting.law, &self.scales).for_each(|hook| bare.law.clear(hook));
        bare
    }

    /// All forms of an effect from a law without it, one start of each.
    pub(crate) fn forms_of(
        &self,
        recovered: &Contacts,
        bare: &Setting,
        law_unknowns: &[Unknown],
        effect: usize,
    ) -> Vec<ContactCandidate> {
        let forms = ALL[effect].contact_forms(&bare.law, &self.scales);
        let quick = recovered.quick();
        let glance = |form| {
            let begun = self.contact_steps(&quick, bare, law_unknowns, (effect, form), (None, BEGIN))?;
            Some((begun.criterion, form))
        };
        let mut begun: Vec<(f64, &ContactForm)> = forms.par_iter().filter_map(glance).collect();
        begun.sort_by(|a, b| a.0.total_cmp(&b.0));
        // One start of each formula goes on.
        let mut formulas = HashSet::new();
        begun.retain(|(_, form)| formulas.insert(form.formula()));
        let fitted = begun.par_iter().filter_map(|(_, form)| {
            let plain = self.contact_candidate(recovered, bare, law_unknowns, (effect, form), ALL_STEPS)?;
            Some(self.contact_shape(recovered, bare, &plain).unwrap_or(plain))
        });
        let mut found: Vec<ContactCandidate> = fitted.collect();
        found.sort_by(ContactCandidate::by_criterion);
        found
    }

    /// Every effect of the contact on the recovered contacts, best first, one form each; `reduced` is the χ² per residual that the
    /// law of the setting leaves there. The search may begin on softened lines.
    pub(crate) fn contact_candidates(
        &self,
        (recovered, softened): (&Contacts, bool),
        setting: &Setting,
        law_unknowns: &[Unknown],
        (taken, reduced): (&[usize], f64),
    ) -> Vec<ContactCandidate> {
        let forms: Vec<(usize, ContactForm)> = ALL
            .iter()
            .enumerate()
            .filter(|(index, effect)| !taken.contains(index) && self.case.allows(effect.id()))
            .flat_map(|(index, effect): (usize, &&dyn Effect)| {
                effect.contact_forms(&setting.law, &self.scales).into_iter().map(move |form| (index, form))
            })
            .collect();
        // A law that misses the contacts by far may be bent too much to show what it lacks: others stand beside it.
        let mut laws = vec![setting.law];
        if reduced > POOR && law_unknowns.len() > 2 {
            laws.extend(starts(&setting.law, self.fastest(recovered), (recovered, setting.rigid)));
        }
        let looked = self.looked((recovered, softened), setting, law_unknowns, (&laws, &forms));
        let again = if looked.first().is_some_and(|(c, _)| !c.meets()) && law_unknowns.len() > 2 {
            self.contact_restarts((recovered, softened), setting, law_unknowns, &looked, &forms)
        } else {
            Vec::new()
        };
        let mut found: Vec<ContactCandidate> = looked.into_iter().map(|(c, _)| c).chain(again).collect();
        found.sort_by(ContactCandidate::by_criterion);
        // Where none meets the contacts the nearest may be near with another laboratory's formula.
        if found.first().is_some_and(|first| !first.meets()) {
            let mut nearest: Vec<&ContactCandidate> = Vec::new();
            for candidate in &found {
                if nearest.len() < SHAPED && nearest.iter().all(|near| near.effect != candidate.effect) {
                    nearest.push(candidate);
                }
            }
            let shaped = nearest.par_iter().filter_map(|c| self.contact_shape(recovered, setting, c));
            let shaped: Vec<ContactCandidate> = shaped.collect();
            found.extend(shaped);
            found.sort_by(ContactCandidate::by_criterion);
        }
        let mut best: Vec<ContactCandidate> = Vec::new();
        for candidate in found {
            match best.iter_mut().find(|b| b.effect == candidate.effect) {
                None => best.push(candidate),
                // A form that uses all it has, about as well, is the better description of the same effect.
                Some(other)
                    if other.bound && !candidate.bound && candidate.criterion < 1.2 * other.criterion =>
                {
                    *other = candidate;
                }
                Some(_) => {}
            }
        }
        best
    }
}
