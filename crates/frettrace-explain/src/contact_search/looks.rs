//! Forms of all effects on recovered contacts: a glance at each, a look at some, and the best to their end.

use super::{ALL_STEPS, BEGIN, ContactCandidate, within_reach};
use crate::contact_fit::Contacts;
use crate::effects::{ALL, ContactForm};
use crate::law_starts::starts;
use crate::{Study, Unknown};
use frettrace_forward::accelerations::Setting;
use frettrace_friction::effects::ModifiedLaw;
use rayon::prelude::*;
use std::collections::HashSet;

/// Steps of the fit that a form gets on the recovered contacts from a start of the law, and the starts of a form that get …
const FIRST: usize = 1;
const STARTS_OF_ONE: usize = 2;
/// … so many.
const GLANCE: usize = 2;
/// Forms that are fitted further, and the steps after which the hopeless are left.
const LOOK: usize = 8;
const PART: usize = 10;
/// … unless they are still on their way, and no farther than so many times from the best: a memory of its own needs more steps to come to its rate
/// than a film that stands in for it.
const FAR: f64 = 10.0;
/// Forms of one effect among these, and those of every effect that are looked at in any case.
const LOOKS_OF_ONE: usize = 3;
const CERTAIN: usize = 2;
/// Forms tried from other starts of the law where none comes near.
const AGAIN: usize = 4;

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

/// Contacts on which a search begins.
fn at_first(contacts: Contacts, softened: bool) -> Contacts {
    if softened { contacts.softened() } else { contacts }
}

impl Study<'_> {
    /// The best forms on the recovered contacts, best first: a few steps on what is quick to march for every form from the first law, and for the
    /// nearest of each formula from the others (the law that comes nearest without a form may lead nowhere with it), all steps on everything for the
    /// best. The first of these may be on softened lines; what all cost at their end is that of the lines as they are.
    pub(super) fn looked(
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
        // A bowl leads on for longer than a valley.
        let glance = if softened { BEGIN } else { GLANCE };
        let quick = at_first(recovered.quick(), softened);
        let from = |(k, law): (usize, &ModifiedLaw<f64>)| {
            let (index, form) = &forms[k];
            let setting = Setting { law: *law, ..setting.clone() };
            let found = self.contact_steps(&quick, &setting, law_unknowns, (*index, form), (None, FIRST))?;
            Some((found, k))
        };
        let [own, others @ ..] = laws else { return Vec::new() };
        let mut begun: Vec<(ContactCandidate, usize)> =
            (0..forms.len()).into_par_iter().filter_map(|k| from((k, own))).collect();
        begun.sort_by(|a, b| a.0.by_criterion(&b.0));
        // From the other laws the form of each formula that comes nearest.
        let mut formulas = HashSet::new();
        let of_formula =
            |&&(_, k): &&(ContactCandidate, usize)| formulas.insert((forms[k].0, forms[k].1.formula()));
        let nearest: Vec<usize> = begun.iter().filter(of_formula).map(|(_, k)| *k).collect();
        let pairs: Vec<_> =
            nearest.into_iter().flat_map(|k| others.iter().map(move |law| (k, law))).collect();
        begun.extend(pairs.into_par_iter().filter_map(from).collect::<Vec<_>>());
        begun.sort_by(|a, b| a.0.by_criterion(&b.0));
        let mut starts = vec![0; forms.len()];
        begun.retain(|&(_, k)| {
            starts[k] += 1;
            starts[k] <= STARTS_OF_ONE
        });
        let glanced: Vec<(ContactCandidate, usize)> =
            begun.par_iter().filter_map(|one| further(&quick, one, glance)).collect();
        let mut order: Vec<(f64, usize)> =
            glanced.iter().enumerate().map(|(place, (one, _))| (one.criterion, place)).collect();
        order.sort_by(|a, b| a.0.total_cmp(&b.0));
        few_of_each(&mut order, LOOK, |place| {
            let (effect, form) = &forms[glanced[place].1];
            (*effect, form.formula())
        });
        // Runs without a period, dear to march, join those that come near; what they cost the others is counted.
        let steady = at_first(recovered.steady(), softened);
        let part: Vec<(ContactCandidate, usize)> =
            order.par_iter().filter_map(|&(_, place)| further(&steady, &glanced[place], PART)).collect();
        let best = part.iter().map(|(one, _)| one.criterion).fold(f64::INFINITY, f64::min);
        let apart = softened || steady.series.len() < recovered.series.len();
        let end = |one: (ContactCandidate, usize)| {
            let near = within_reach(one.0.criterion, best) || one.0.open && one.0.criterion < FAR * best;
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
        looked.sort_by(|a, b| a.0.by_criterion(&b.0));
        looked
    }

    /// The best forms from other starts of the law: a law of many values that lacked an effect may have been bent too far to
    /// come back with it.
    pub(super) fn contact_restarts(
        &self,
        (recovered, softened): (&Contacts, bool),
        setting: &Setting,
        law_unknowns: &[Unknown],
        looked: &[(ContactCandidate, usize)],
        forms: &[(usize, ContactForm)],
    ) -> Vec<ContactCandidate> {
        let others = starts(&setting.law, self.fastest(recovered), (recovered, setting.rigid));
        let quick = at_first(recovered.quick(), softened);
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
        begun.sort_by(|a, b| a.0.by_criterion(&b.0));
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
