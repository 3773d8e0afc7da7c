//! Two effects at once.
//!
//! Effects are found one after the other, each by what the whole model leaves with it. Where two act and none of them is small, that says little: with
//! either one alone the model is as far off as the other one makes it. The balance knows of no law and is a least-squares problem in both: the best
//! of its single effects are each asked which second one takes what they leave, and what does is fitted as a whole, both effects from the start.
//! A pair that leaves more than the noise has other laboratories' formulas, where that is a trace of what was missing and no other pair comes near.
//!
//! Where one of the two acts in the contact, the other one alone closes the balance, and leaves the whole model as far off as the contact's makes it:
//! what it leaves there says nothing against it.
//!
//! Where both act in the contact, what is said of the balance is said of the recovered contacts: they know of no other run and no structure.
//!
//! Where no two do, a single effect of the contact is asked in a shape that could stand in for others.

use super::contact_rounds::Recovered;
use super::{BALANCE_CLOSED, EVIDENCE, FORETOLD, Rival, Search, Tried, least_excess};
use crate::balance_fit::BalanceCandidate;
use crate::contact_search::{ContactCandidate, within_reach};
use crate::effects::ALL;
use crate::search::{DOMINANT, Explained};
use crate::{ExplainError, Unknown};
use frettrace_forward::accelerations::Setting;
use rayon::prelude::*;

/// Single effects that a second one is asked beside.
const FIRSTS: usize = 4;
/// Share of what the declared law leaves on the recovered contacts that the nearest of two effects in it leaves at most: unless the two nearly undo
/// each other, the larger one takes the better part. Of two whose traces are `θ` apart it takes `sin² θ/2` at least, a quarter at 60°.
const MOST_OF_ONE: f64 = 0.75;
/// Second effects of the contact beside each of them.
const SECONDS: usize = 2;
/// Pairs of the balance whose values are free together, …
const FREED: usize = 8;
/// … pairs that are fitted as a whole, …
const FITTED: usize = 3;
/// … where they leave no more than this share of what the best single effect does: what is left is of their formulas.
const TAKEN: f64 = 0.05;

fn closes(candidate: &BalanceCandidate) -> bool {
    candidate.reduced < BALANCE_CLOSED
}

/// Whether two names explain all that the declared model misses, or leave a thousandth of it within a fifth of the noise: that is of their formulas.
fn fills(pair: &Explained, declared: &Explained) -> bool {
    pair.complete() || pair.sufficient(declared) && pair.excess() <= DOMINANT * declared.excess()
}

/// Whether a single name leaves so little, and all others so much more, that it stands in another formula.
fn is_dominant(declared: &Explained, single: Option<&(Explained, Vec<Rival>)>) -> bool {
    single.is_some_and(|(one, rivals)| one.dominant(declared, least_excess(one, rivals)))
}

impl Search<'_> {
    /// The declared model with two effects at once, or with one in a shape that is asked last; `None` where none explain all that is missing.
    /// `single` is the best model with one effect, and its rivals.
    pub(super) fn at_last(
        &mut self,
        declared: &Explained,
        single: Option<&(Explained, Vec<Rival>)>,
    ) -> Result<Option<Explained>, ExplainError> {
        let stands = is_dominant(declared, single);
        match self.told_by_the_balance(declared, stands)? {
            None => {}
            found => return Ok(found),
        }
        if !stands
            && let Some(found) = self.or_as_before(|search| search.beside_a_hidden_one(declared, single))?
        {
            return Ok(Some(found));
        }
        if self.is_open(declared) {
            return Ok(None);
        }
        let recovered = self.recovered(declared)?;
        let singles = self.candidates_on(&recovered, false, declared);
        let known = (&*recovered, &singles[..]);
        if !stands
            && let Some(found) = self.or_as_before(|search| Ok(search.in_the_contact(declared, known)))?
        {
            return Ok(Some(found));
        }
        self.or_as_before(|search| Ok(search.in_another_shape(declared, known)))
    }

    /// A single effect in a shape that could stand in for others, where it is all that explains, of those on the recovered contacts.
    fn in_another_shape(
        &mut self,
        declared: &Explained,
        (recovered, singles): (&Recovered, &[ContactCandidate]),
    ) -> Option<Explained> {
        let study = &self.study;
        let reshaped = |from| study.in_its_other_shape(&recovered.contacts, &recovered.setting, from);
        let forms: Vec<ContactCandidate> = singles.par_iter().filter_map(reshaped).collect();
        let asked = forms
            .par_iter()
            .flat_map_iter(|form| study.contact_round(declared, std::slice::from_ref(form)))
            .collect();
        let found = self.answered(asked);
        let best = self.take_best(declared, found)?;
        let best = self.further(best, declared.excess());
        Some(best).filter(|best| best.complete() && self.held_out_ratio(best) <= FORETOLD)
    }

    /// What is found; where nothing is, the search is as it was before.
    fn or_as_before(
        &mut self,
        ask: impl FnOnce(&mut Self) -> Result<Option<Explained>, ExplainError>,
    ) -> Result<Option<Explained>, ExplainError> {
        let before = self.clone();
        let found = ask(self)?;
        if found.is_none() {
            *self = before;
        }
        Ok(found)
    }

    /// Both effects outside the contact, or the one that closes the balance with one in it: the latter not where a single name `stands`.
    fn told_by_the_balance(
        &mut self,
        declared: &Explained,
        stands: bool,
    ) -> Result<Option<Explained>, ExplainError> {
        let start = self.declared_start(declared);
        if closes(&self.study.balance_base(&start, &[])) {
            return Ok(None);
        }
        let (_, singles) = self.structure_candidates(&start, &[], &[]);
        let Some(first) = singles.first() else { return Ok(None) };
        if !closes(first) {
            return Ok(self.outside_the_contact(declared, &start, singles));
        }
        let rival = singles.iter().find(|other| other.effect != first.effect);
        if stands || rival.is_some_and(|rival| rival.criterion <= first.criterion + EVIDENCE) {
            return Ok(None);
        }
        let first = self.with_first(declared, first);
        self.or_as_before(|search| search.beside_the_contact(declared, &first))
    }

    /// What hides in the contact's force, where it explains more than the best single effect, with one in the contact.
    fn beside_a_hidden_one(
        &mut self,
        declared: &Explained,
        single: Option<&(Explained, Vec<Rival>)>,
    ) -> Result<Option<Explained>, ExplainError> {
        // What is left of a first effect that takes all but a trace is of its formula, and says of no second one.
        let nearer = |first: &Explained| {
            single.is_none_or(|(one, _)| first.criterion + EVIDENCE < one.criterion)
                && first.excess() > DOMINANT * declared.excess()
        };
        match self.hidden(declared).filter(nearer) {
            Some(first) => self.beside_the_contact(declared, &first),
            None => Ok(None),
        }
    }

    /// A model with one effect outside the contact, and one in it.
    fn beside_the_contact(
        &mut self,
        declared: &Explained,
        first: &Explained,
    ) -> Result<Option<Explained>, ExplainError> {
        let Some(pair) = self.contact(first)? else { return Ok(None) };
        // Where runs rest was told with the declared law.
        let pair = if fills(&pair, declared) { pair } else { self.rested(pair, declared.excess()) };
        // Where a formula is in doubt another name may be it.
        let alone = pair.complete() || pair.is_far_ahead(least_excess(&pair, &self.rivals));
        Ok(Some(pair).filter(|_| alone).and_then(|pair| self.counted(declared, pair)))
    }

    /// Two effects in the contact: the best single ones on the recovered contacts are each asked which second one takes what they leave there, and
    /// the pairs that follow these are fitted as a whole.
    fn in_the_contact(
        &mut self,
        declared: &Explained,
        (recovered, firsts): (&Recovered, &[ContactCandidate]),
    ) -> Option<Explained> {
        let Recovered { contacts, setting, plain, .. } = recovered;
        let nearest = firsts.first()?.criterion;
        if nearest > MOST_OF_ONE * plain {
            return None;
        }
        let most = TAKEN * nearest;
        let worth = |candidate: &ContactCandidate| candidate.meets() || candidate.criterion < most;
        let pair = |first: &ContactCandidate| {
            let with = first.placed_in(setting);
            let taken = [first.effect];
            let seconds = self.study.contact_candidates(
                (contacts, false),
                &with,
                &first.unknowns,
                (&taken, first.reduced),
            );
            let first = self.with(declared, with, (first.effect, None, &first.unknowns));
            seconds.into_iter().filter(worth).take(SECONDS).map(move |second| (first.clone(), second))
        };
        let firsts = firsts.iter().filter(|first| within_reach(first.criterion, nearest));
        let mut pairs: Vec<(Explained, ContactCandidate)> = firsts.take(FIRSTS).flat_map(pair).collect();
        pairs.sort_by(|(_, a), (_, b)| a.by_criterion(b));
        let mut seen: Vec<[usize; 2]> = Vec::new();
        pairs.retain(|(with, second)| {
            let [a, b] = [with.effects[0], second.effect];
            let known = seen.iter().any(|pair| pair.contains(&a) && pair.contains(&b));
            seen.push([a, b]);
            !known
        });
        pairs.truncate(FITTED);
        let asked = pairs
            .par_iter()
            .flat_map_iter(|(with, second)| self.study.contact_round(with, std::slice::from_ref(second)))
            .collect();
        let mut found = self.answered(asked);
        found.sort_by(Explained::by_criterion);
        let best = found.first().cloned()?;
        let lacked = declared.excess();
        let best = self.further(best, lacked);
        let best = self.shaped(best, lacked);
        self.only(declared, best, found)
    }

    /// A pair that fills the model, with the others that complete it as its rivals; `None` where another one explains as well.
    fn only(&mut self, declared: &Explained, best: Explained, found: Vec<Explained>) -> Option<Explained> {
        let other = |one: &Explained| one.effects.iter().any(|effect| !best.effects.contains(effect));
        let rivals: Vec<Rival> = found
            .into_iter()
            .filter(|one| (one.complete() || !best.is_far_ahead(one.excess())) && other(one))
            .filter_map(|one| Rival::of(&one, one.criterion - best.criterion))
            .collect();
        // Two pairs that explain alike are no answer, and evidence between other laboratories' formulas says nothing of the names.
        let alike = |rival: &Rival| !best.complete() || rival.behind <= EVIDENCE;
        if rivals.iter().any(alike) {
            return None;
        }
        let best = self.counted(declared, best)?;
        self.rivals = rivals;
        Some(best)
    }

    /// The two effects that close the balance together, where no single one does.
    fn outside_the_contact(
        &mut self,
        declared: &Explained,
        start: &Setting,
        singles: Vec<BalanceCandidate>,
    ) -> Option<Explained> {
        let most = TAKEN * singles.first()?.criterion;
        let worth = |candidate: &BalanceCandidate| closes(candidate) || candidate.criterion < most;
        let mut firsts: Vec<BalanceCandidate> = Vec::new();
        for single in singles {
            if firsts.len() < FIRSTS && firsts.iter().all(|first| first.effect != single.effect) {
                firsts.push(single);
            }
        }
        let mut pairs: Vec<(Explained, BalanceCandidate)> = firsts
            .par_iter()
            .flat_map_iter(|first| {
                let with = self.with_first(declared, first);
                let setting = Setting {
                    frequency: start.frequency.clone(),
                    damping: start.damping.clone(),
                    ..first.setting.clone()
                };
                let (_, seconds) = self.structure_candidates(&setting, &with.added, &with.effects);
                seconds.into_iter().map(move |second| (with.clone(), second)).collect::<Vec<_>>()
            })
            .collect();
        let nearest = |pairs: &mut Vec<(Explained, BalanceCandidate)>| {
            pairs.sort_by(|(_, a), (_, b)| a.by_criterion(b));
        };
        nearest(&mut pairs);
        pairs.truncate(FREED);
        // The second one was located while the first one's values were held where they took what they could of both.
        pairs.par_iter_mut().filter(|(_, second)| !closes(second)).for_each(|(with, second)| {
            let together = self.study.balance_together(second, &with.added);
            if together.criterion < second.criterion {
                *second = together;
            }
        });
        pairs.retain(|(_, second)| worth(second));
        nearest(&mut pairs);
        pairs.truncate(FITTED);
        let asked = pairs.par_iter().map(|(with, second)| self.asked(with, second)).collect();
        let mut found: Vec<Explained> =
            self.answered(asked).into_iter().filter(Explained::complete).collect();
        for one in &mut found {
            // What the second effect brought comes after what the first one did.
            let first = pairs.iter().find(|(with, _)| with.effects[0] == one.effects[0])?;
            one.book(&first.0);
        }
        found.sort_by(Explained::by_criterion);
        let best = found.first()?.clone();
        self.only(declared, best, found)
    }

    /// A pair that fills the model, both of its effects counted among those that were tried with the evidence that they have together over the
    /// declared one; `None` where it does not, or one of the two explains everything: that has been asked already, and was not what its name says.
    fn counted(&mut self, declared: &Explained, pair: Explained) -> Option<Explained> {
        let best = Some(pair).filter(|pair| fills(pair, declared)).map(|pair| self.pruned(pair))?;
        if best.effects.len() < 2 {
            return None;
        }
        let error = self.study.error(&best.fitted, &self.study.training).relative();
        let evidence = declared.criterion - best.criterion;
        let named = |tried: &Tried| best.effects.iter().any(|&effect| ALL[effect].id() == tried.id);
        self.tried.retain(|tried| !named(tried));
        self.tried.extend(best.effects.iter().map(|&effect| Tried { id: ALL[effect].id(), error, evidence }));
        Some(best)
    }

    /// The declared model with an effect as the balance has it, which was not fitted as a whole.
    fn with_first(&self, declared: &Explained, first: &BalanceCandidate) -> Explained {
        self.with(declared, first.setting.clone(), (first.effect, first.sensor, &first.unknowns))
    }

    /// The declared model at a setting with an effect that brought some of the unknowns there.
    fn with(
        &self,
        declared: &Explained,
        setting: Setting,
        (effect, sensor, unknowns): (usize, Option<usize>, &[Unknown]),
    ) -> Explained {
        let mut with = declared.clone();
        let known = self.study.case.unknowns();
        let brought: Vec<Unknown> =
            unknowns.iter().filter(|unknown| !known.contains(unknown)).cloned().collect();
        with.fitted.setting = setting;
        with.effects.push(effect);
        with.sensors.push(sensor);
        with.counts.push(brought.len());
        with.added.extend(brought);
        with
    }
}
