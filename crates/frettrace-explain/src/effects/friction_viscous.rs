//! `friction.viscous`.
//!
//! *Adds*: a force `σ2·v` beside the bristles; where the data ask for it `σ2·v + σ2'·v|v|`, `σ2·v·|v/v₀|^{p−1}`, a
//! straight line near rest that turns into such a power at speed, or `c·N·v`.
//!
//! *Shows as*: a force in phase with the slip velocity that grows with the level.
//!
//! *Mistaken for*: `structure.modal-damping`; told apart by a decay test with the contact open: damping of the structure stays, viscous friction of the contact goes.

use super::{Change, ContactForm, Effect, EffectPlace, known};
use crate::Scales;
use frettrace_friction::effects::{Hook, ModifiedLaw};

pub(super) struct FrictionViscous;

/// Powers of a viscous force at speed: all but constant to thickening.
const POWERS: (f64, f64) = (0.02, 4.0);

impl Effect for FrictionViscous {
    fn id(&self) -> &'static str {
        "friction.viscous"
    }

    fn place(&self) -> EffectPlace {
        EffectPlace::Contact
    }

    fn rivals(&self) -> &'static [&'static str] {
        &["structure.modal-damping"]
    }

    fn experiment(&self) -> &'static str {
        "a decay test with the contact open: damping of the structure stays, viscous friction of the contact goes"
    }

    fn contact_forms(&self, law: &ModifiedLaw<f64>, scales: &Scales) -> Vec<ContactForm> {
        if known(law, &[Hook::Viscous]) {
            return Vec::new();
        }
        let size = 0.05 * law.get(Hook::MuKinetic).unwrap_or(0.3) * scales.preload / scales.velocity;
        vec![
            ContactForm::new(vec![Change::from_zero(Hook::Viscous, size)]),
            // Another lubricant's curve: thinning or thickening with speed.
            ContactForm::new(vec![
                Change::from_zero(Hook::Viscous, size),
                Change::signed(Hook::ViscousSquare, 0.3 * size / scales.velocity),
            ]),
            ContactForm::new(vec![
                Change::from_zero(Hook::Viscous, size),
                Change::between(Hook::ViscousPower, 1.0, POWERS),
                Change::fixed(Hook::ViscousReference, scales.velocity),
            ]),
            // A film that is sheared where the contact presses it.
            ContactForm::new(vec![Change::from_zero(Hook::ViscousNormal, size / scales.preload)]),
        ]
    }

    /// Where a straight line near rest turns into a power, and how sharply: a film that thins with the rate of shear, or saturates.
    fn shape(&self, law: &ModifiedLaw<f64>, scales: &Scales) -> Vec<Change> {
        if !known(law, &[Hook::Viscous]) {
            return Vec::new();
        }
        vec![
            Change::between(Hook::ViscousPower, 0.7, POWERS),
            Change::fixed(Hook::ViscousReference, scales.velocity),
            Change::positive(Hook::ViscousCore, 0.3, 1e-2),
            Change::between(Hook::ViscousTurn, 2.0, (0.5, 10.0)),
        ]
    }
}
