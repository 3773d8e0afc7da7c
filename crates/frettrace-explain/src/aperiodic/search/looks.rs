//! Effects inside a law: looked at on few runs, fitted to their end on all.

use super::{
    ALL_STEPS, COARSE, ENDED, FINE, Fitted, GLANCE, LOOKED, MANY_VALUES, MODULATION, PART, QUICK_RUNS,
    SECOND_RUNS, Search,
};
use crate::aperiodic::run::{OpenRun, Wave};
use crate::aperiodic::wave;
use crate::contact_search::{POOR, few_of_each};
use crate::effects::{ALL, ContactForm, Effect, Reach, apply};
use crate::law_starts::beside;
use crate::study::merge;
use frettrace_friction::effects::{Hook, ModifiedLaw};
use rayon::prelude::*;

impl Search<'_> {
    /// Every effect that a law along a history can carry, its best form each: all forms on few runs, the best on more, the best effects on all.
    pub(super) fn candidates(&self, current: &Fitted) -> Vec<Fitted> {
        let waves = wave::candidates(&self.training, current);
        let mut begun: Vec<Fitted> = Vec::new();
        for law in self.laws(current) {
            let from = Fitted { law, ..current.clone() };
            for (effect, form) in &self.forms(&from) {
                if ALL[*effect].id() == MODULATION {
                    begun.extend(waves.iter().map(|waves| with_form(&from, (*effect, form), waves)));
                } else {
                    begun.push(with_form(&from, (*effect, form), &[]));
                }
            }
        }
        let looked = self.looked(&begun, (&self.some(QUICK_RUNS), COARSE, GLANCE));
        let mut order: Vec<(f64, usize)> =
            looked.iter().enumerate().map(|(place, one)| (one.rank(), place)).collect();
        order.sort_by(|a, b| a.0.total_cmp(&b.0));
        let of = |place: usize| (looked[place].effects.last().copied().unwrap_or_default(), ());
        few_of_each(&mut order, LOOKED, of);
        // Where a form has come in two steps says little of where it ends.
        let near: Vec<Fitted> = order.into_iter().map(|(_, place)| looked[place].clone()).collect();
        let mut near = self.looked(&near, (&self.some(QUICK_RUNS), COARSE, PART));
        near.sort_by(|a, b| a.rank().total_cmp(&b.rank()));
        near.truncate(LOOKED);
        let second = best_of_each(self.looked(&near, (&self.some(SECOND_RUNS), FINE, PART)));
        let ended = |one: &Fitted| self.fitted(&self.with_waves(&one.waves), one, (ALL_STEPS, false));
        let used = |one: &Fitted| !self.is_idle(one);
        second.iter().take(ENDED).filter_map(ended).filter(used).collect()
    }

    /// Laws that forms begin from: the fitted one, and where that misses the runs by far, so that it may be bent too much to show what it
    /// lacks, others as the histories show them.
    fn laws(&self, current: &Fitted) -> Vec<ModifiedLaw<f64>> {
        let far = current.effects.is_empty() && current.cost > POOR * self.count();
        let many = current.unknowns.len() >= MANY_VALUES;
        let others = self.sight.filter(|_| far && many);
        let others = others.into_iter().flat_map(|law| beside(&law, self.scales.velocity));
        std::iter::once(current.law).chain(others).collect()
    }

    /// Whether the last effect of a model has nothing that the runs could tell: a memory shorter than a sample, a wave longer than the stroke.
    fn is_idle(&self, one: &Fitted) -> bool {
        let step = self.training.iter().map(|run| run.whole.dt).fold(f64::INFINITY, f64::min);
        let reach = Reach { step, stroke: 2.0 * self.scales.slip };
        if one.law.get(Hook::ForceLag).is_some_and(|time| time < step) {
            return true;
        }
        one.effects.last().is_some_and(|&effect| ALL[effect].is_idle(&one.law, reach))
    }

    /// Models fitted in a few steps to some runs, the law marched in so many steps a sample.
    fn looked(&self, begun: &[Fitted], (some, fine, steps): (&[usize], usize, usize)) -> Vec<Fitted> {
        let one = |from: &Fitted| {
            let all = self.with_waves(&from.waves);
            let runs: Vec<OpenRun> = some.iter().map(|&k| all[k].refined(fine)).collect();
            let open = some.iter().map(|&k| from.open[k].clone()).collect();
            let found = self.fitted(&runs, &Fitted { open, ..from.clone() }, (steps, true))?;
            Some(Fitted { open: from.open.clone(), ..found })
        };
        begun.par_iter().filter_map(one).collect()
    }

    fn forms(&self, current: &Fitted) -> Vec<(usize, ContactForm)> {
        let allowed = |(index, effect): &(usize, &&dyn Effect)| {
            !current.effects.contains(index) && self.case.allows(effect.id())
        };
        ALL.iter()
            .enumerate()
            .filter(allowed)
            .flat_map(|(index, effect)| {
                let mut forms = effect.contact_forms(&current.law, &self.scales);
                if effect.id() == MODULATION {
                    // Its frequency is told by the runs, not by the excitation's: the sine, and the steeper wave.
                    forms.truncate(2);
                }
                forms.into_iter().map(move |form| (index, form))
            })
            .collect()
    }
}

/// The best form of each effect, the best first.
fn best_of_each(mut found: Vec<Fitted>) -> Vec<Fitted> {
    found.sort_by(|a, b| a.rank().total_cmp(&b.rank()));
    let mut best: Vec<Fitted> = Vec::new();
    for one in found {
        if best.iter().all(|other| other.effects != one.effects) {
            best.push(one);
        }
    }
    best
}

/// A fitted law with one more effect, at the values it starts from.
fn with_form(current: &Fitted, (effect, form): (usize, &ContactForm), waves: &[Wave]) -> Fitted {
    let mut next = current.clone();
    let added = apply(&form.changes, &mut next.law);
    next.unknowns = merge(&current.unknowns, &added);
    next.effects.push(effect);
    next.added.push(added);
    if !waves.is_empty() {
        next.waves = waves.to_vec();
    }
    next
}
