//! `friction.normal-dependence`.
//!
//! *Adds*: a friction coefficient that depends on the normal force, `μ ∝ (N/N₀)^(−n)`, or by another power, `1 − n((N/N₀)^q − 1)/q`, where the data ask for it;
//! of the friction's limit, or of the whole force of the bristles.
//!
//! *Shows as*: friction that does not follow the normal force in proportion: even harmonics at the higher levels.
//!
//! *Mistaken for*: `contact.normal-stiffening`, `excitation.preload-modulation`; told apart by two preloads at the same level: the coefficient itself changes.

use super::{Change, ContactForm, Effect, EffectPlace};
use crate::Scales;
use frettrace_friction::effects::{Hook, ModifiedLaw};

pub(super) struct FrictionNormalDependence;

impl Effect for FrictionNormalDependence {
    fn id(&self) -> &'static str {
        "friction.normal-dependence"
    }

    fn place(&self) -> EffectPlace {
        EffectPlace::Contact
    }

    fn rivals(&self) -> &'static [&'static str] {
        &["contact.normal-stiffening", "excitation.preload-modulation"]
    }

    fn experiment(&self) -> &'static str {
        "two preloads at the same level: the coefficient itself changes"
    }

    fn contact_forms(&self, _law: &ModifiedLaw<f64>, scales: &Scales) -> Vec<ContactForm> {
        let power = || {
            vec![
                Change::linear(Hook::NormalExponent, 0.05, 0.1, (-2.0, 2.0)),
                // One reference for all runs: the coefficient changes from preload to preload too.
                Change::fixed(Hook::NormalReference, scales.preload),
            ]
        };
        let mut powered = power();
        powered.push(Change::linear(Hook::NormalPower, 0.5, 0.2, (-3.0, 4.0)));
        let own = vec![Change::linear(Hook::NormalExponent, 0.05, 0.1, (-2.0, 2.0))];
        // The stiffness of the bristles changes with their strength.
        let whole: Vec<Change> =
            powered.iter().cloned().chain([Change::fixed(Hook::NormalWhole, 1.0)]).collect();
        [own, power(), powered, whole].map(ContactForm::new).into()
    }
}
