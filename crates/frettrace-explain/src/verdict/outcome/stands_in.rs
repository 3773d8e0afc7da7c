//! Names that show nothing of what they say, and stand in for what has none.

use super::super::Search;
use super::super::choice::contained;
use super::super::rules::stays_with_sensor;
use crate::effects::{ALL, Simpler, listed};
use crate::search::Explained;
use frettrace_forward::accelerations::Quantity;
use frettrace_friction::effects::Hook;
use rayon::prelude::*;

/// Share of what is missing without an effect that the simpler one it becomes may leave, in the best of its own forms: what is left is of a formula.
const BECOMES: f64 = 0.1;

impl Search<'_> {
    /// What an effect of the model is that shows nothing of what its name says: of a wave along the path less than one is travelled. It is the
    /// simpler one that it becomes then, under that one's name (`Ok`), if that takes most of what is missing in a form of its own; where there is none
    /// in the list, it stands in for what has no name. `None` where it shows what it says.
    fn idle(&self, model: &Explained, place: usize) -> Option<Result<usize, &'static str>> {
        let (law, effect) = (&model.fitted.setting.law, model.effects[place]);
        if !ALL[effect].is_idle(law, self.reach()) {
            return None;
        }
        // What brought its own curve with a memory is the curve without one.
        let has_curve = model.own(place).iter().any(|u| u.quantity == Quantity::Law(Hook::StribeckRise));
        let curve = has_curve.then_some("friction.stribeck");
        let own = ALL[effect].simpler(law, &self.study.scales);
        let ids = own.iter().map(|simpler| simpler.id).chain(curve);
        let mut named = ids.filter(|id| self.study.case.allows(id)).filter_map(listed);
        let becomes =
            |&other: &usize| contained(Some(&effect), other) && self.becomes(model, place, (other, &own));
        Some(named.find(becomes).ok_or(ALL[effect].id()))
    }

    /// Whether a simpler effect takes most of what is missing without the one of a model that would become it, in one of the `forms` that it would have
    /// then; one that has none of these is the same law.
    fn becomes(&self, model: &Explained, place: usize, (other, forms): (usize, &[Simpler])) -> bool {
        let mut forms = forms.iter().filter(|form| form.id == ALL[other].id()).peekable();
        if forms.peek().is_none() {
            return true;
        }
        let Some(without) = self.study.without(model, place) else { return true };
        let forms: Vec<&Simpler> = forms.collect();
        let asked = forms.par_iter().filter_map(|form| self.study.simpler(&without, model, form));
        asked.any(|own| own.complete() || own.excess() <= BECOMES * without.excess())
    }

    /// Whether an effect of the model stands in for what has no name.
    pub(in crate::verdict) fn shows_nothing(&self, model: &Explained) -> bool {
        (0..model.effects.len()).any(|place| matches!(self.idle(model, place), Some(Err(_))))
    }

    /// The same, with what is only the simpler one that it becomes under that one's name.
    pub(super) fn stands_in(&mut self, model: &mut Explained) -> bool {
        let mut nameless = None;
        for place in 0..model.effects.len() {
            match self.idle(model, place) {
                Some(Ok(other)) => {
                    self.renamed.push((place, std::mem::replace(&mut model.effects[place], other)))
                }
                Some(Err(id)) => nameless = Some(id),
                None => {}
            }
        }
        if let Some(id) = nameless {
            self.notes.push(format!(
                "{id} takes what is missing, but shows nothing of what it says: it stands in for what is in no list"
            ));
        }
        nameless.is_some()
    }

    /// Whether a sensor that has a named fault with one formula only is still the one that the model misses: it has another fault.
    pub(super) fn misread(&mut self, model: &Explained) -> bool {
        let exact = model.effects.iter().zip(&model.sensors).filter(|(effect, _)| ALL[**effect].is_exact());
        // A slow sensor's filter need not be of first order.
        let slow = |sensor: &usize| model.added.iter().any(|u| u.quantity == Quantity::Lag(*sensor));
        let sensors: Vec<usize> = exact.filter_map(|(_, sensor)| *sensor).filter(|s| !slow(s)).collect();
        let left = |sensor: usize| self.study.left_at(&model.fitted, sensor);
        let misread = sensors.into_iter().find(|&sensor| stays_with_sensor(left(sensor)));
        if let Some(sensor) = misread {
            self.notes.push(format!("sensor {sensor} is still read wrong beyond the noise, and no other is"));
        }
        misread.is_some()
    }
}
