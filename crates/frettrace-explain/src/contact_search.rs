//! What the contact's recovered motion says of the declared law and of each candidate.

use crate::Study;
use crate::contact_fit::{ContactProblem, Contacts, Leeway, Moved, Recovered, mean_force, recover};
use crate::effects::{ALL, ContactForm, Effect, apply};
use crate::law_starts::{scattered, starts};
use crate::study::{as_declared, merge};
use crate::{ExplainError, Unknown};
use frettrace_forward::accelerations::{
    AccelerationError, Beside, FrequencyRatio, Memory, Quantity, Setting,
};
use frettrace_friction::effects::{Hook, ModifiedLaw};
use frettrace_identify::{Model, Status};
use rayon::prelude::*;
use std::sync::Arc;

/// Steps of the fit that every form gets on the recovered contacts from every start of the law, and the starts of a form that get …
const FIRST: usize = 1;
const STARTS_OF_ONE: usize = 2;
/// … so many.
const GLANCE: usize = 2;
/// Forms that are fitted further, the steps after which the hopeless are left, and the most that any gets.
const LOOK: usize = 8;
const PART: usize = 10;
const ALL_STEPS: usize = 30;
/// Forms of one effect among these, and those of every effect that are looked at in any case.
const LOOKS_OF_ONE: usize = 3;
const CERTAIN: usize = 2;
/// Forms tried from other starts of the law where none comes near.
const AGAIN: usize = 4;
/// Steps from each of them, before the best get all.
const BEGIN: usize = 8;
/// Rises of the static friction over the sliding one, as shares of it, that are tried where the contacts do not bound it.
const RISES: [f64; 3] = [0.15, 0.5, 1.5];
/// Other starts of the declared law that get all.
const ENDED: usize = 2;
/// Values from which a law is tried from all about.
const MANY_VALUES: usize = 6;

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

/// Keeps of a ranking the first few forms of each effect, `most` in all, and in any case the first two of every effect and the first
/// of another formula than theirs: one of many forms leaves room for its rivals, where a form has come in a few steps says little of
/// where it ends, and all starts of one formula may come before the right one. `of` tells the effect of a form and its formula.
pub(crate) fn few_of_each<F: PartialEq>(
    order: &mut Vec<(f64, usize)>,
    most: usize,
    of: impl Fn(usize) -> (usize, F),
) {
    let mut certain = vec![Vec::new(); ALL.len()];
    for &(_, k) in &*order {
        let (effect, formula) = of(k);
        let chosen = &mut certain[effect];
        let is_new = || chosen.len() == CERTAIN && chosen.iter().all(|&other| of(other).1 != formula);
        if chosen.len() < CERTAIN || is_new() {
            chosen.push(k);
        }
    }
    let (mut looks, mut kept) = (vec![0; ALL.len()], 0);
    order.retain(|&(_, k)| {
        let (effect, _) = of(k);
        let keep = certain[effect].contains(&k) || looks[effect] < LOOKS_OF_ONE && kept < most;
        looks[effect] += usize::from(keep);
        kept += usize::from(keep);
        keep
    });
}

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
        let series = self.series.iter().filter(|_| as_declared(setting)).map(|(_, contact)| contact.clone());
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
                let (quantity, std) = (unknown.quantity, unknown.parameter.prior?.std);
                let value = setting.get(quantity)?;
                let mut other = setting.clone();
                other.set(quantity, value + std);
                let contacts = self.recovered_runs(&other, &self.training, beside);
                Some(contacts.map(|contacts| Moved { quantity, value, std, contacts }))
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

    /// The law of a setting on the recovered contacts.
    pub(crate) fn contact_base(
        &self,
        recovered: &Contacts,
        setting: &Setting,
        law_unknowns: &[Unknown],
    ) -> Option<ContactCandidate> {
        let plain = ContactForm::new(Vec::new());
        let form = (usize::MAX, &plain);
        let first = self.contact_candidate(recovered, setting, law_unknowns, form, 20)?;
        // Where a rigid contact's force jumps is known to a part of a sample only: χ² does not tell a poor end there.
        let few = law_unknowns.len() < 3;
        if first.meets() && (few || !setting.rigid) {
            return Some(first);
        }
        // A law of many values has several minima, and what a fit of the whole rig that lacks an effect made of one with few may be in none:
        // other starts, where the first end is poor, and the best of them goes on.
        let others = starts(&setting.law, self.fastest(recovered), (recovered, setting.rigid));
        self.better_end(recovered, setting, law_unknowns, (others, first))
    }

    /// The law of a setting on the recovered contacts, from starts all about where that leaves a law of many values poor: what the
    /// declared law comes to decides whether anything is missing.
    pub(crate) fn contact_base_from_many(
        &self,
        recovered: &Contacts,
        setting: &Setting,
        law_unknowns: &[Unknown],
    ) -> Option<ContactCandidate> {
        let first = self.contact_base(recovered, setting, law_unknowns)?;
        if first.meets() {
            return Some(first);
        }
        self.contact_base_from_all_about(recovered, setting, law_unknowns, first)
    }

    /// The law of a setting on the recovered contacts from starts all about, or `first` where none leads further or the law has few
    /// values: a valley may pass there that the whole model tells from the right one.
    pub(crate) fn contact_base_from_all_about(
        &self,
        recovered: &Contacts,
        setting: &Setting,
        law_unknowns: &[Unknown],
        first: ContactCandidate,
    ) -> Option<ContactCandidate> {
        if setting.rigid || law_unknowns.len() < MANY_VALUES {
            return Some(first);
        }
        let fastest = self.fastest(recovered);
        let centres = starts(&setting.law, fastest, (recovered, setting.rigid));
        let sizes = (self.scales.preload, fastest);
        let others = centres.first().map_or_else(Vec::new, |law| scattered(law, law_unknowns, sizes));
        self.better_end(recovered, setting, law_unknowns, (others, first))
    }

    /// Largest slip velocity (m/s), that of the declared structure where none was recovered.
    fn fastest(&self, recovered: &Contacts) -> f64 {
        recovered.fastest().unwrap_or(self.scales.velocity)
    }

    /// Whether the law of a setting misses recovered contacts even where their lines count by their size: a search from it begins there.
    pub(crate) fn is_far(&self, recovered: &Contacts, setting: &Setting, law_unknowns: &[Unknown]) -> bool {
        // Where a rigid contact sticks it takes the recovered force: its χ² is no valley.
        if setting.rigid {
            return false;
        }
        let plain = ContactForm::new(Vec::new());
        let softened = recovered.steady().softened();
        self.contact_steps(&softened, setting, law_unknowns, (usize::MAX, &plain), (None, 0))
            .is_none_or(|left| left.reduced > 1.0)
    }

    /// Where the law of a setting ends on the recovered contacts from the best of some starts, or `first` where that is better.
    fn better_end(
        &self,
        recovered: &Contacts,
        setting: &Setting,
        law_unknowns: &[Unknown],
        (starts, first): (Vec<ModifiedLaw<f64>>, ContactCandidate),
    ) -> Option<ContactCandidate> {
        let plain = ContactForm::new(Vec::new());
        let form = (usize::MAX, &plain);
        let quick = recovered.quick();
        let begin = |law| {
            let setting = Setting { law, ..setting.clone() };
            self.contact_steps(&quick, &setting, law_unknowns, form, (None, BEGIN))
        };
        let end = |begun: &ContactCandidate| {
            let recovered = recovered.around(&begun.law, begun.modulation);
            self.contact_steps(&recovered, setting, law_unknowns, form, (Some(begun), ALL_STEPS))
        };
        let mut begun: Vec<ContactCandidate> = starts.into_par_iter().filter_map(begin).collect();
        begun.sort_by(|a, b| a.criterion.total_cmp(&b.criterion));
        begun.truncate(ENDED);
        let ended: Vec<ContactCandidate> = begun.par_iter().filter_map(end).collect();
        ended.into_iter().chain([first]).min_by(|a, b| a.criterion.total_cmp(&b.criterion))
    }

    /// The law of a setting, fitted already, on the recovered contacts again for each of some static frictions below its own: a
    /// contact without a presliding range shows its friction where it slides, and what it would hold at rest only as far as its
    /// motion is resolved there. Where it is not, the fit may hold any force, and the whole model has no answer with it.
    pub(crate) fn breakaways(
        &self,
        recovered: &Contacts,
        setting: &Setting,
        law_unknowns: &[Unknown],
    ) -> Vec<ModifiedLaw<f64>> {
        let others: Vec<Unknown> = law_unknowns
            .iter()
            .filter(|u| u.quantity != Quantity::Law(Hook::StribeckRise))
            .cloned()
            .collect();
        let plain = ContactForm::new(Vec::new());
        let [rise, sliding] =
            [Hook::StribeckRise, Hook::MuKinetic].map(|h| setting.law.get(h).unwrap_or_default());
        let at = |share: f64| {
            let mut setting = setting.clone();
            setting.law.set(Hook::StribeckRise, share * sliding);
            self.contact_candidate(recovered, &setting, &others, (usize::MAX, &plain), ALL_STEPS)
        };
        let lower = RISES.into_par_iter().filter(|share| share * sliding < rise);
        lower.filter_map(at).map(|found| found.law).collect()
    }

    /// The law of a setting fitted to the recovered contacts, from starts all about where its own leads to a poor end; one without a
    /// presliding range also for each of some static frictions below what it comes to.
    ///
    /// # Errors
    /// [`ExplainError::Model`] where the structure cannot be built.
    pub fn laws_on_contacts(&self, setting: &Setting) -> Result<Vec<ModifiedLaw<f64>>, ExplainError> {
        let (unknowns, _) = Unknown::parted(&self.case.unknowns());
        let recovered = self.recovered(setting)?;
        let Some(base) = self.contact_base_from_many(&recovered, setting, &unknowns) else {
            return Ok(Vec::new());
        };
        let mut laws = vec![base.law];
        if setting.rigid {
            let fitted = Setting { law: base.law, ..setting.clone() };
            laws.extend(self.breakaways(&recovered, &fitted, &unknowns));
        }
        Ok(laws)
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
        let modulated = law.get(Hook::ModulationCosine).is_some() && !form.changes.is_empty();
        let modulation = if modulated { form.modulation } else { setting.modulation };
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
        found.sort_by(|a, b| a.criterion.total_cmp(&b.criterion));
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

    /// The best forms on the recovered contacts, best first: a few steps for every form from every law on what is quick to march, all steps
    /// on everything for the best. The first of these may be on softened lines; what all cost at their end is that of the lines as they are.
    fn looked(
        &self,
        (recovered, softened): (&Contacts, bool),
        setting: &Setting,
        law_unknowns: &[Unknown],
        (laws, forms): (&[ModifiedLaw<f64>], &[(usize, ContactForm)]),
    ) -> Vec<(ContactCandidate, usize)> {
        let further = |recovered: &Contacts, (candidate, k): &(ContactCandidate, usize), most: usize| {
            let (index, form) = &forms[*k];
            let setting = Setting { law: candidate.law, ..setting.clone() };
            let from = Some(candidate);
            self.contact_steps(recovered, &setting, law_unknowns, (*index, form), (from, most))
                .map(|found| (found, *k))
        };
        let at_first = |contacts: Contacts| if softened { contacts.softened() } else { contacts };
        // A bowl leads on for longer than a valley.
        let glance = if softened { BEGIN } else { GLANCE };
        let quick = at_first(recovered.quick());
        let begun = |k: usize| -> Vec<(ContactCandidate, usize)> {
            let (index, form) = &forms[k];
            let from = |law: &ModifiedLaw<f64>| {
                let setting = Setting { law: *law, ..setting.clone() };
                self.contact_steps(&quick, &setting, law_unknowns, (*index, form), (None, FIRST))
            };
            let mut found: Vec<ContactCandidate> = laws.par_iter().filter_map(from).collect();
            found.sort_by(|a, b| a.criterion.total_cmp(&b.criterion));
            found.truncate(STARTS_OF_ONE);
            found.into_iter().filter_map(|one| further(&quick, &(one, k), glance)).collect()
        };
        let glanced: Vec<(ContactCandidate, usize)> =
            (0..forms.len()).into_par_iter().flat_map_iter(begun).collect();
        let mut order: Vec<(f64, usize)> =
            glanced.iter().enumerate().map(|(place, (one, _))| (one.criterion, place)).collect();
        order.sort_by(|a, b| a.0.total_cmp(&b.0));
        few_of_each(&mut order, LOOK, |place| {
            let (effect, form) = &forms[glanced[place].1];
            (*effect, form.changes.iter().map(|change| change.hook).collect::<Vec<_>>())
        });
        // Runs without a period, dear to march, join those that come near; what they cost the others is counted.
        let steady = at_first(recovered.steady());
        let part: Vec<(ContactCandidate, usize)> =
            order.par_iter().filter_map(|&(_, place)| further(&steady, &glanced[place], PART)).collect();
        let best = part.iter().map(|(one, _)| one.criterion).fold(f64::INFINITY, f64::min);
        let apart = softened || steady.series.len() < recovered.series.len();
        let end = |one: (ContactCandidate, usize)| {
            let near = within_reach(one.0.criterion, best);
            match (near && (apart || one.0.open), apart) {
                (true, _) => {
                    let recovered = recovered.around(&one.0.law, one.0.modulation);
                    further(&recovered, &one, ALL_STEPS - PART).unwrap_or(one)
                }
                (false, true) => further(recovered, &one, 0).unwrap_or(one),
                (false, false) => one,
            }
        };
        let mut looked: Vec<(ContactCandidate, usize)> = part.into_par_iter().map(end).collect();
        looked.sort_by(|a, b| a.0.criterion.total_cmp(&b.0.criterion));
        looked
    }

    /// The best forms from other starts of the law: a law of many values that lacked an effect may have been bent too far to
    /// come back with it.
    fn contact_restarts(
        &self,
        (recovered, softened): (&Contacts, bool),
        setting: &Setting,
        law_unknowns: &[Unknown],
        looked: &[(ContactCandidate, usize)],
        forms: &[(usize, ContactForm)],
    ) -> Vec<ContactCandidate> {
        let others = starts(&setting.law, self.fastest(recovered), (recovered, setting.rigid));
        let quick = if softened { recovered.quick().softened() } else { recovered.quick() };
        let steps = |recovered: &Contacts,
                     k: usize,
                     law: ModifiedLaw<f64>,
                     how: (Option<&ContactCandidate>, usize)| {
            let (index, form) = &forms[k];
            let setting = Setting { law, ..setting.clone() };
            self.contact_steps(recovered, &setting, law_unknowns, (*index, form), how)
        };
        let mut begun: Vec<(ContactCandidate, usize)> = looked
            .par_iter()
            .take(AGAIN)
            .flat_map(|(_, k)| others.par_iter().map(|law| (*k, *law)))
            .filter_map(|(k, law)| Some((steps(&quick, k, law, (None, BEGIN))?, k)))
            .collect();
        begun.sort_by(|a, b| a.0.criterion.total_cmp(&b.0.criterion));
        let ended = |(one, k): &(ContactCandidate, usize)| {
            let recovered = recovered.around(&one.law, one.modulation);
            steps(&recovered, *k, one.law, (Some(one), ALL_STEPS))
        };
        begun.par_iter().take(AGAIN).filter_map(ended).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::few_of_each;

    /// Three starts of one formula come first and one of another formula of the same effect last: that one stays whatever else is looked
    /// at. Where no looks are left, an effect keeps its first two and that one.
    #[test]
    fn another_formula_of_an_effect_is_looked_at() {
        let of = |k: usize| [(0, 'a'), (0, 'a'), (0, 'a'), (1, 'a'), (1, 'a'), (0, 'b')][k];
        let ranked = || (0..6).map(|k| (k as f64, k)).collect::<Vec<_>>();
        let kept = |most: usize| {
            let mut order = ranked();
            few_of_each(&mut order, most, of);
            order.into_iter().map(|(_, k)| k).collect::<Vec<_>>()
        };
        assert_eq!(kept(0), [0, 1, 3, 4, 5]);
        assert_eq!(kept(8), [0, 1, 2, 3, 4, 5]);
    }
}
