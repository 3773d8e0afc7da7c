//! `friction.ageing`.
//!
//! *Adds*: a coefficient that grows with the age of the contact, which slip renews: with its logarithm, with a power, or to an end.
//!
//! *Shows as*: a peak of friction after each reversal that grows with the time spent there.
//!
//! *Mistaken for*: `friction.stribeck`, `friction.lag`; told apart by holds of different length before sliding: the static peak grows with the logarithm of the hold.

use super::{Change, ContactForm, Effect, EffectPlace};
use crate::Scales;
use frettrace_friction::effects::{Hook, ModifiedLaw};

pub(super) struct FrictionAgeing;

impl Effect for FrictionAgeing {
    fn id(&self) -> &'static str {
        "friction.ageing"
    }

    fn place(&self) -> EffectPlace {
        EffectPlace::Contact
    }

    fn rivals(&self) -> &'static [&'static str] {
        &["friction.stribeck", "friction.lag"]
    }

    fn experiment(&self) -> &'static str {
        "holds of different length before sliding: the static peak grows with the logarithm of the hold"
    }

    fn contact_forms(&self, _law: &ModifiedLaw<f64>, scales: &Scales) -> Vec<ContactForm> {
        let mut forms = Vec::new();
        for distance in [0.05, 0.5] {
            let ageing = || {
                vec![
                    Change::linear(Hook::AgeingGain, 0.05, 0.02, (0.0, 2.0)),
                    Change::positive(Hook::AgeingDistance, distance * scales.slip, 1e-3),
                    Change::positive(Hook::AgeingTime, 0.02 * scales.period, 1e-3),
                ]
            };
            let mut ending = ageing();
            ending.push(Change::fixed(Hook::AgeingSaturation, 1.0));
            forms.extend([ContactForm::new(ageing()), ContactForm::new(ending)]);
        }
        forms
    }

    fn shape(&self, _law: &ModifiedLaw<f64>, _scales: &Scales) -> Vec<Change> {
        vec![
            Change::linear(Hook::AgeingSaturation, 0.0, 0.3, (0.0, 1.0)),
            Change::linear(Hook::AgeingPower, 0.0, 0.3, (-3.0, 2.0)),
        ]
    }
}
