//! Candidates of a round by their evidence.

use super::super::candidates::{Candidate, Form};
use super::super::evidence::evidence;
use super::super::{RecordQuantity, RecordSetting};
use super::{RecordEffect, RecordFit, STRONG, Search, Trial};
use rayon::prelude::*;

/// Ids that are fitted to the end in a round.
const PROMISING: usize = 8;

impl Search<'_> {
    /// Candidates with their best form, by evidence: all after a few steps, the promising ones fitted to the end.
    pub(super) fn ranked<'c>(&self, base: &Trial, list: &'c [Candidate]) -> Vec<Tried<'c>> {
        let pairs: Vec<(&Candidate, &Form)> =
            list.iter().flat_map(|c| c.forms.iter().map(move |form| (c, form))).collect();
        let mut quick: Vec<_> = pairs
            .par_iter()
            .filter_map(|(c, form)| {
                let trial = self.fitted(&with(&base.setting, form), 8).ok()?;
                Some((*c, *form, trial, 0.0))
            })
            .collect();
        weigh(base, &mut quick);
        let mut best: Vec<Tried<'c>> = Vec::new();
        for entry in quick {
            if !best.iter().any(|b| b.0.id == entry.0.id) {
                best.push(entry);
            }
        }
        best.par_iter_mut().take(PROMISING).for_each(|entry| {
            if let Ok(trial) = self.fitted(&entry.2.setting, 40) {
                entry.2 = trial;
            }
        });
        weigh(base, &mut best);
        best
    }
}

impl Trial {
    /// Whether something that the form brought lies on its bound, or it drove the offset there, which was free before:
    /// an offset that makes up for an effect.
    fn on_bound(&self, form: &Form, base: &Self) -> bool {
        let brought = |quantity| form.unknowns.iter().any(|u| u.quantity == quantity);
        let drove = |quantity| {
            let place = base.setting.unknowns.iter().position(|u| u.quantity == quantity);
            quantity == RecordQuantity::Offset && place.is_some_and(|place| !base.at_bound[place])
        };
        let bounds = self.setting.unknowns.iter().zip(&self.at_bound);
        bounds.filter(|(_, bound)| **bound).any(|(u, _)| brought(u.quantity) || drove(u.quantity))
    }
}

/// The setting with a form in it.
fn with(setting: &RecordSetting, form: &Form) -> RecordSetting {
    let mut setting = setting.clone();
    form.unknowns.iter().for_each(|u| setting.put(u.clone()));
    form.held.iter().for_each(|(hook, value)| setting.law.set(*hook, *value));
    setting
}

/// A candidate in one of its forms, tried, with its evidence.
pub(super) type Tried<'c> = (&'c Candidate, &'c Form, Trial, f64);

/// Evidence of all trials against the base, best first: counted by the samples that the best of them leaves
/// independent, the same for all, since each has seen the same data.
fn weigh(base: &Trial, tried: &mut [Tried<'_>]) {
    let best = tried.iter().map(|t| &t.2).min_by(|a, b| a.square.total_cmp(&b.square));
    let Some(effective) = best.map(|trial| trial.effective) else { return };
    let count = |setting: &RecordSetting| {
        setting.unknowns.iter().filter(|u| u.parameter.prior.is_none()).count() as f64
    };
    for (_, form, trial, gain) in tried.iter_mut() {
        let added = (count(&trial.setting) - count(&base.setting)).max(1.0);
        let value = evidence([base.square, trial.square], added, effective);
        *gain = if value.is_finite() { value } else { f64::NEG_INFINITY };
        // A value driven to its bound means that the mechanism is not the one.
        if trial.on_bound(form, base) {
            *gain = gain.min(0.0);
        }
    }
    tried.sort_by(|a, b| b.3.total_cmp(&a.3));
}

/// The effect with its values, its probability and those that fit as well.
pub(super) fn named_effect(
    candidate: &Candidate,
    form: &Form,
    fit: &RecordFit,
    rivals: &[(&'static str, f64)],
) -> RecordEffect {
    let close = rivals.iter().filter(|(_, behind)| *behind < STRONG);
    let weight: f64 = rivals.iter().map(|(_, behind)| (-0.5 * behind).exp()).sum();
    let brought = form.unknowns.iter().map(|u| u.quantity);
    RecordEffect {
        id: candidate.id,
        place: candidate.place,
        probability: 1.0 / (1.0 + weight),
        unknowns: brought
            .filter_map(|quantity| fit.setting.unknowns.iter().find(|u| u.quantity == quantity).cloned())
            .collect(),
        indistinguishable: close.map(|(id, _)| *id).take(2).collect(),
        experiment: candidate.experiment,
    }
}
