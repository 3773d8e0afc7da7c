//! What the contact's recovered motion says of the declared law and of each candidate.

use crate::Study;
use crate::case::Scales;
use crate::contact_fit::{ContactProblem, Contacts, Recovered, mean_force, recover};
use crate::effects::{ALL, ContactForm, Effect};
use crate::study::{as_declared, merge};
use crate::{ExplainError, Unknown};
use frettrace_forward::accelerations::{AccelerationError, Memory, Quantity, Setting};
use frettrace_friction::effects::{Hook, ModifiedLaw};
use frettrace_identify::{Model, Parameter};
use rayon::prelude::*;

/// Steps of the fit that every form gets on the recovered contacts, and forms that get all of them.
const GLANCE: usize = 3;
const LOOK: usize = 8;
/// Forms of one effect among these.
const LOOKS_OF_ONE: usize = 3;
/// Forms tried from other starts of the law where none comes near.
const AGAIN: usize = 4;
/// Steps from each of them, before the best get all.
const BEGIN: usize = 8;
/// Other starts of the declared law that get all.
const ENDED: usize = 2;

/// A law on recovered contacts, with what it costs.
#[derive(Clone)]
pub(crate) struct ContactCandidate {
    pub effect: usize,
    pub law: ModifiedLaw<f64>,
    pub modulation: usize,
    pub unknowns: Vec<Unknown>,
    /// `χ² + k ln n` on the recovered contacts.
    pub criterion: f64,
    /// χ² per residual.
    pub reduced: f64,
    /// Whether a value that the effect brought lies on its bound: there the effect, or a part of its form, is not used.
    pub bound: bool,
}

/// χ² per residual on the recovered contacts from which other starts of the declared law are tried.
const POOR: f64 = 4.0;

/// Keeps of a ranking the first few forms of each effect, `most` in all, and the first of every effect: one of many forms leaves
/// room for its rivals, and where an effect has come in a few steps says little of where it ends.
pub(crate) fn few_of_each(order: &mut Vec<(f64, usize)>, most: usize, effect: impl Fn(usize) -> usize) {
    let (mut looks, mut kept) = (vec![0; ALL.len()], 0);
    order.retain(|&(_, k)| {
        let count = &mut looks[effect(k)];
        *count += 1;
        let keep = *count == 1 || *count <= LOOKS_OF_ONE && kept < most;
        kept += usize::from(keep);
        keep
    });
}

/// Other starts of a law: Stribeck velocities, breakaways and dampings of other sizes. Friction coefficient and stiffness are
/// those that the recovered contacts show: a law that ended poorly may have any.
fn starts(
    law: &ModifiedLaw<f64>,
    scales: &Scales,
    (recovered, rigid): (&Contacts, bool),
) -> Vec<ModifiedLaw<f64>> {
    let own = [Hook::MuKinetic, Hook::Sigma0].map(|hook| law.get(hook).unwrap_or(0.3));
    let [mu, sigma0] = recovered.sizes().unwrap_or(own);
    let mut law = *law;
    law.set(Hook::MuKinetic, mu);
    if !rigid {
        law.set(Hook::Sigma0, sigma0);
    }
    let mut out = Vec::new();
    for speed in [0.1, 0.4] {
        for breakaway in [0.15, 0.6] {
            let mut other = law;
            let sizes = [
                (Hook::StribeckVelocity, speed * scales.velocity),
                (Hook::DampingVelocity, speed * scales.velocity),
                (Hook::StribeckRise, 0.3 * mu),
                (Hook::StribeckExponent, 1.5),
                (Hook::Sigma1, 0.05 * mu / scales.velocity),
                (Hook::Viscous, 0.0),
                (Hook::Breakaway, breakaway),
            ];
            for (hook, value) in sizes {
                if law.get(hook).is_some() {
                    other.set(hook, value);
                }
            }
            if law.get(Hook::Breakaway).is_some() || breakaway < 0.5 {
                out.push(other);
            }
        }
    }
    out
}

impl Study<'_> {
    /// Recovered contacts of the training runs, and of those that are not periodic.
    pub(crate) fn recovered(&self, setting: &Setting) -> Result<Contacts, ExplainError> {
        let periodic = self.recovered_runs(setting, &self.training)?;
        let series = self.series.iter().filter(|_| as_declared(setting)).map(|(_, contact)| contact.clone());
        Ok(Contacts { periodic, series: series.collect() })
    }

    fn recovered_runs(&self, setting: &Setting, runs: &[usize]) -> Result<Vec<Recovered>, AccelerationError> {
        let selected: Vec<(usize, usize)> =
            runs.iter().map(|&run| (run, self.case.records[run].subharmonic)).collect();
        recover(&self.model, setting, &selected)
    }

    /// Where the balance of the runs begins with the law of a setting: where friction depends on the contact's place, at the place
    /// that their recovered contacts show, as far as the memory does not know it.
    pub(crate) fn begin(&self, setting: &Setting, runs: &[usize], memory: &mut Memory) {
        if !setting.law.depends_on_place() {
            return;
        }
        let new: Vec<usize> = runs.iter().copied().filter(|&run| !memory.knows(run)).collect();
        let Ok(recovered) = self.recovered_runs(setting, &new) else { return };
        let law = (setting.law, setting.modulation);
        let means: Vec<Option<f64>> =
            recovered.into_par_iter().map(|contact| mean_force(contact, law)).collect();
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
        let form = ContactForm::new(Vec::new());
        let fitted = |recovered: &Contacts, setting: &Setting, most: usize| {
            self.contact_candidate(recovered, setting, law_unknowns, (usize::MAX, &form), most)
        };
        let first = fitted(recovered, setting, 20)?;
        // Where a rigid contact's force jumps is known to a part of a sample only: χ² does not tell a poor end there.
        let good = first.reduced < POOR && !setting.rigid;
        if good || law_unknowns.len() < 3 {
            return Some(first);
        }
        // A law of many values has several minima: other starts, where the first end is poor, and the best of them goes on.
        let quick = recovered.quick();
        let mut begun: Vec<ContactCandidate> = starts(&setting.law, &self.scales, (recovered, setting.rigid))
            .into_par_iter()
            .filter_map(|law| fitted(&quick, &Setting { law, ..setting.clone() }, BEGIN))
            .collect();
        begun.sort_by(|a, b| a.criterion.total_cmp(&b.criterion));
        begun.truncate(ENDED);
        let ended = begun
            .into_par_iter()
            .filter_map(|c| fitted(recovered, &Setting { law: c.law, ..setting.clone() }, 30));
        let ended: Vec<ContactCandidate> = ended.collect();
        ended.into_iter().chain([first]).min_by(|a, b| a.criterion.total_cmp(&b.criterion))
    }

    /// A form of an effect on the recovered contacts, fitted to its end: on what is quick to march first, where that is not all.
    fn contact_candidate(
        &self,
        recovered: &Contacts,
        setting: &Setting,
        law_unknowns: &[Unknown],
        form: (usize, &ContactForm),
        most: usize,
    ) -> Option<ContactCandidate> {
        let quick = recovered.quick();
        let first = self.contact_steps(&quick, setting, law_unknowns, form, (None, most));
        if quick.series.len() == recovered.series.len() {
            return first;
        }
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
        let mut added = Vec::new();
        for change in &form.changes {
            law.set(change.hook, change.start);
            if let Some(parameter) = &change.parameter {
                let quantity = Quantity::Law(change.hook);
                added.push(Unknown { quantity, parameter: parameter.clone() });
            }
        }
        let unknowns = merge(law_unknowns, &added);
        let rigid = setting.rigid && !law.yields();
        let (hooks, parameters): (Vec<Hook>, Vec<Parameter>) = unknowns
            .iter()
            .filter_map(|u| match u.quantity {
                Quantity::Law(hook) if !(rigid && hook == Hook::Sigma0) => Some((hook, u.parameter.clone())),
                _ => None,
            })
            .unzip();
        let modulated = law.get(Hook::ModulationCosine).is_some() && !form.changes.is_empty();
        let modulation = if modulated { form.modulation } else { setting.modulation };
        let law = from.map_or(law, |begun| begun.law);
        let problem = ContactProblem::new(recovered, (law, modulation), (hooks, parameters));
        let fit = problem.solve(most, 0.0).ok()?;
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
            unknowns,
        })
    }

    /// Every effect of the contact on the recovered contacts, best first, one form each; `reduced` is the χ² per residual that the
    /// law of the setting leaves there.
    pub(crate) fn contact_candidates(
        &self,
        recovered: &Contacts,
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
        let tried = |recovered: &Contacts,
                     (index, form): &(usize, ContactForm),
                     (law, most): (ModifiedLaw<f64>, usize)| {
            let setting = Setting { law, ..setting.clone() };
            self.contact_candidate(recovered, &setting, law_unknowns, (*index, form), most)
        };
        // A few steps for every form on what is quick to march, all steps on everything for the best. A law that misses the
        // contacts by far may be bent too much to show what it lacks: others stand beside it.
        let quick = recovered.quick();
        let mut laws = vec![setting.law];
        if reduced > POOR && law_unknowns.len() > 2 {
            laws.extend(starts(&setting.law, &self.scales, (recovered, setting.rigid)));
        }
        let pairs: Vec<(usize, ModifiedLaw<f64>)> =
            laws.iter().flat_map(|law| (0..forms.len()).map(|k| (k, *law))).collect();
        let mut order: Vec<(f64, usize)> = pairs
            .par_iter()
            .enumerate()
            .filter_map(|(pair, &(k, law))| Some((tried(&quick, &forms[k], (law, GLANCE))?.criterion, pair)))
            .collect();
        order.sort_by(|a, b| a.0.total_cmp(&b.0));
        few_of_each(&mut order, LOOK, |pair| forms[pairs[pair].0].0);
        let mut looked: Vec<(ContactCandidate, usize)> = order
            .par_iter()
            .filter_map(|&(_, pair)| {
                let (k, law) = pairs[pair];
                Some((tried(recovered, &forms[k], (law, 30))?, k))
            })
            .collect();
        looked.sort_by(|a, b| a.0.criterion.total_cmp(&b.0.criterion));
        let again = if looked.first().is_some_and(|(c, _)| c.reduced > POOR) && law_unknowns.len() > 2 {
            self.contact_restarts(recovered, setting, law_unknowns, &looked, &forms)
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

    /// The best forms from other starts of the law: a law of many values that lacked an effect may have been bent too far to
    /// come back with it.
    fn contact_restarts(
        &self,
        recovered: &Contacts,
        setting: &Setting,
        law_unknowns: &[Unknown],
        looked: &[(ContactCandidate, usize)],
        forms: &[(usize, ContactForm)],
    ) -> Vec<ContactCandidate> {
        let others = starts(&setting.law, &self.scales, (recovered, setting.rigid));
        let candidate = |recovered: &Contacts, k: usize, law: ModifiedLaw<f64>, most: usize| {
            let (index, form) = &forms[k];
            let setting = Setting { law, ..setting.clone() };
            self.contact_candidate(recovered, &setting, law_unknowns, (*index, form), most)
        };
        let quick = recovered.quick();
        let mut begun: Vec<(f64, usize, ModifiedLaw<f64>)> = looked
            .par_iter()
            .take(AGAIN)
            .flat_map(|(_, k)| others.par_iter().map(|law| (*k, *law)))
            .filter_map(|(k, law)| candidate(&quick, k, law, BEGIN).map(|c| (c.criterion, k, law)))
            .collect();
        begun.sort_by(|a, b| a.0.total_cmp(&b.0));
        begun.par_iter().take(AGAIN).filter_map(|&(_, k, law)| candidate(recovered, k, law, 30)).collect()
    }
}
