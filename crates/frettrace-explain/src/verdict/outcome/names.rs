//! The named effects: what they brought, how sure they are, and what the data cannot tell from them.

use super::super::rules::may_be;
use super::super::{EVIDENCE, FORETOLD, Rival, Search};
use super::Named;
use crate::ChannelFault;
use crate::effects::{ALL, EffectPlace, listed};
use crate::search::Explained;

impl Search<'_> {
    /// Effects that these data do not rule out in one place of a model: the one whose formula stands there under the name of the simpler one that
    /// it shows. In the last place also those near in evidence; where the formula is in doubt, known rivals that leave little more; and known rivals that were not asked
    /// for, or followed other fitted runs: where runs disagree about a name, a fit that ends elsewhere does not rule it out.
    fn not_ruled_out(&self, model: &Explained, place: usize) -> Vec<usize> {
        let effect = model.effects[place];
        let renamed = self.renamed.iter().filter(|(at, _)| *at == place).map(|(_, other)| *other);
        if place + 1 < model.effects.len() {
            return renamed.collect();
        }
        let known = |other: usize| ALL[effect].rivals().contains(&ALL[other].id());
        let held_out = &self.study.held_out;
        let foretold = held_out.is_empty() || self.study.error(&model.fitted, held_out).ratio() <= FORETOLD;
        let near = |r: &&Rival| {
            let other = r.effect != effect;
            other && (r.behind < EVIDENCE || known(r.effect) && may_be(r.left, model.left(), foretold))
        };
        let unasked =
            (0..ALL.len()).filter(|&other| known(other) && !self.study.case.allows(ALL[other].id()));
        let elsewhere = self.told_by_others.iter().copied().filter(|&other| other != effect && known(other));
        let near = self.rivals.iter().filter(near).map(|r| r.effect);
        let mut found: Vec<usize> = near.chain(unasked).chain(elsewhere).chain(renamed).collect();
        found.sort_unstable();
        found.dedup();
        found
    }

    pub(super) fn named(&self, model: &Explained) -> Vec<Named> {
        let close = |effect: usize| {
            let other = move |r: &&Rival| r.effect != effect && r.behind < EVIDENCE;
            self.rivals.iter().filter(other)
        };
        model
            .effects
            .iter()
            .zip(&model.sensors)
            .enumerate()
            .map(|(k, (&effect, &sensor))| {
                let last = k + 1 == model.effects.len();
                let odds: f64 = if last { close(effect).map(|r| (-0.5 * r.behind).exp()).sum() } else { 0.0 };
                Named {
                    id: ALL[effect].id(),
                    probability: 1.0 / (1.0 + odds),
                    position: position(model, effect),
                    sensor,
                    parameters: parameters(model, k),
                    indistinguishable: at_most_two(effect, self.not_ruled_out(model, k)),
                    experiment: ALL[effect].experiment(),
                }
            })
            .collect()
    }
}

/// A fault of a channel as a named effect: it was seen in the samples themselves.
pub(crate) fn faulty(fault: &ChannelFault) -> Named {
    let effect = listed(fault.id).map(|effect| ALL[effect]);
    Named {
        id: fault.id,
        probability: 1.0,
        position: None,
        sensor: Some(fault.sensor),
        parameters: fault.parameters.clone(),
        indistinguishable: Vec::new(),
        experiment: effect.map_or("", |e| e.experiment()),
    }
}

/// At most two of the effects that the data cannot rule out, those known to look like `effect` first.
fn at_most_two(effect: usize, left: Vec<usize>) -> Vec<&'static str> {
    let mut ids: Vec<_> = left.into_iter().map(|other| ALL[other].id()).collect();
    ids.sort_by_key(|id| !ALL[effect].rivals().contains(id));
    ids.truncate(2);
    ids
}

/// Position of an effect along the beam, where it has one.
fn position(model: &Explained, effect: usize) -> Option<f64> {
    if ALL[effect].place() != EffectPlace::Structure {
        return None;
    }
    model.added.iter().find(|u| u.quantity.is_place()).and_then(|u| model.fitted.setting.get(u.quantity))
}

/// What the effect at a place of the list brought.
fn parameters(model: &Explained, place: usize) -> Vec<(String, String, f64, f64)> {
    model
        .own(place)
        .iter()
        .filter_map(|u| {
            let value = model.fitted.setting.get(u.quantity)?;
            let std = model.deviation(u.quantity);
            Some((u.parameter.name.clone(), u.parameter.unit.clone(), value, std))
        })
        .collect()
}
