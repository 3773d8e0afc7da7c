//! `friction.asymmetry`.
//!
//! *Adds*: a friction coefficient that differs between the two directions, `μ(1 + a·sgn v)`, at once or going over with the velocity;
//! or bristles that are stiffer and stronger to one side.
//!
//! *Shows as*: even harmonics of the force that appear with sliding.
//!
//! *Mistaken for*: `friction.position`; told apart by the contact turned round: the harmonics of even order change sign.

use super::{Change, ContactForm, Effect, EffectPlace};
use crate::Scales;
use frettrace_friction::effects::{Hook, ModifiedLaw};

pub(super) struct FrictionAsymmetry;

impl Effect for FrictionAsymmetry {
    fn id(&self) -> &'static str {
        "friction.asymmetry"
    }

    fn place(&self) -> EffectPlace {
        EffectPlace::Contact
    }

    fn rivals(&self) -> &'static [&'static str] {
        &["friction.position"]
    }

    fn experiment(&self) -> &'static str {
        "the contact turned round: the harmonics of even order change sign"
    }

    fn contact_forms(&self, _law: &ModifiedLaw<f64>, scales: &Scales) -> Vec<ContactForm> {
        let share = || Change::linear(Hook::Asymmetry, 0.02, 0.02, (-0.9, 0.9));
        let mut over = vec![share()];
        over.push(turning(scales));
        // Stiffer and stronger to one side, whichever way it moves.
        let sided = vec![
            Change::linear(Hook::BristleAsymmetry, 0.02, 0.02, (-0.9, 0.9)),
            Change::between(Hook::BristleTurn, 0.2, (0.01, 2.0)),
        ];
        vec![ContactForm::new(vec![share()]), ContactForm::new(over), ContactForm::new(sided)]
    }

    /// Another laboratory's coefficient turns over smoothly with the velocity.
    fn shape(&self, law: &ModifiedLaw<f64>, scales: &Scales) -> Vec<Change> {
        let power = Change::between(Hook::AsymmetryPower, 2.0, (0.5, 8.0));
        if law.get(Hook::BristleAsymmetry).is_some() { vec![power] } else { vec![turning(scales), power] }
    }
}

/// Velocity at which the coefficient goes over from one side to the other.
fn turning(scales: &Scales) -> Change {
    Change::positive(Hook::AsymmetryVelocity, 0.05 * scales.velocity, 1e-3)
}
