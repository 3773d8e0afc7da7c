//! `friction.position`.
//!
//! *Adds*: a friction coefficient that changes along the slip path, `μ(1 + p·u + q·u²)`, or ever less from the middle outwards.
//!
//! *Shows as*: friction that differs at the two ends of the stroke.
//!
//! *Mistaken for*: `friction.asymmetry`, `friction.position-periodic`, `contact.tangential-stiffness`; told apart by the mean position moved by a known step: the change of friction moves with it.

use super::{Change, ContactForm, Effect, EffectPlace};
use crate::Scales;
use frettrace_friction::effects::{Hook, ModifiedLaw};

pub(super) struct FrictionPosition;

impl Effect for FrictionPosition {
    fn id(&self) -> &'static str {
        "friction.position"
    }

    fn place(&self) -> EffectPlace {
        EffectPlace::Contact
    }

    fn rivals(&self) -> &'static [&'static str] {
        &["friction.asymmetry", "friction.position-periodic", "contact.tangential-stiffness"]
    }

    fn experiment(&self) -> &'static str {
        "the mean position moved by a known step: the change of friction moves with it"
    }

    fn contact_forms(&self, _law: &ModifiedLaw<f64>, scales: &Scales) -> Vec<ContactForm> {
        let size = 0.05 / scales.slip;
        vec![
            ContactForm::new(vec![Change::signed(Hook::Position, size)]),
            ContactForm::new(vec![
                Change::signed(Hook::Position, 2.0 * size),
                Change::positive(Hook::PositionScale, 0.7 * scales.slip, 0.02),
            ]),
            ContactForm::new(vec![
                Change::signed(Hook::Position, size),
                Change::signed(Hook::PositionSquare, size / scales.slip),
            ]),
            ContactForm::new(vec![
                Change::signed(Hook::Position, size),
                Change::signed(Hook::PositionSquare, size / scales.slip),
                Change::signed(Hook::PositionCube, size / scales.slip.powi(2)),
            ]),
        ]
    }
    /// Another laboratory's change along the path ends in another way.
    fn shape(&self, _law: &ModifiedLaw<f64>, scales: &Scales) -> Vec<Change> {
        vec![
            Change::positive(Hook::PositionScale, 10.0 * scales.slip, 0.02),
            Change::between(Hook::PositionPower, 2.0, (0.5, 8.0)),
        ]
    }
}
