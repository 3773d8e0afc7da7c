//! `friction.presliding-damping`.
//!
//! *Adds*: a force `N·σ1·ż` on the bristles, which may fade with the velocity, or `N·σ1·v(1 − |r|)`, which damps what sticks alike before and after a reversal.
//!
//! *Shows as*: dissipation in the small loops, gone where the contact slides.
//!
//! *Mistaken for*: `friction.viscous`, `structure.modal-damping`; told apart by small loops at two frequencies: presliding damping grows with frequency, hysteresis does not.

use super::{Change, ContactForm, Effect, EffectPlace, known};
use crate::Scales;
use frettrace_friction::effects::{Hook, ModifiedLaw};

/// Velocity in which damping that did not fade begins to, over the largest of a run: beside that it is as it was.
const BEYOND: f64 = 3.0;

pub(super) struct FrictionPreslidingDamping;

impl Effect for FrictionPreslidingDamping {
    fn id(&self) -> &'static str {
        "friction.presliding-damping"
    }

    fn place(&self) -> EffectPlace {
        EffectPlace::Contact
    }

    fn rivals(&self) -> &'static [&'static str] {
        &["friction.viscous", "structure.modal-damping"]
    }

    fn experiment(&self) -> &'static str {
        "small loops at two frequencies: presliding damping grows with frequency, hysteresis does not"
    }

    fn contact_forms(&self, law: &ModifiedLaw<f64>, scales: &Scales) -> Vec<ContactForm> {
        if known(law, &[Hook::Sigma1]) {
            return Vec::new();
        }
        let size = 0.05 * law.get(Hook::MuKinetic).unwrap_or(0.3) / scales.velocity;
        vec![
            ContactForm::new(vec![Change::from_zero(Hook::Sigma1, size)]),
            ContactForm::new(vec![
                Change::from_zero(Hook::Sigma1, 3.0 * size),
                Change::positive(Hook::DampingVelocity, 0.3 * scales.velocity, 1e-3),
            ]),
            ContactForm::new(vec![
                Change::from_zero(Hook::Sigma1, 3.0 * size),
                Change::positive(Hook::DampingVelocity, 0.3 * scales.velocity, 1e-3),
                Change::fixed(Hook::DampingRational, 1.0),
            ]),
            // What sticks damps, alike before and after a reversal.
            ContactForm::new(vec![
                Change::from_zero(Hook::Sigma1, size),
                Change::fixed(Hook::DampingStuck, 1.0),
            ]),
        ]
    }

    fn shape(&self, law: &ModifiedLaw<f64>, scales: &Scales) -> Vec<Change> {
        let rational = Change::linear(Hook::DampingRational, 0.0, 0.3, (0.0, 1.0));
        let stuck = Change::linear(Hook::DampingStuck, 0.0, 0.3, (0.0, 1.0));
        let power = Change::between(Hook::DampingPower, 2.0, (0.5, 6.0));
        if known(law, &[Hook::DampingVelocity]) {
            vec![rational, power, stuck]
        } else {
            vec![stuck, Change::positive(Hook::DampingVelocity, BEYOND * scales.velocity, 1e-3)]
        }
    }
}
