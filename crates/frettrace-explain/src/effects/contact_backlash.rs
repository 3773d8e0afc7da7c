//! `contact.backlash`.
//!
//! *Adds*: play between the beam and the contact: after a reversal nothing moves the bristles until it is taken up; or a
//! clearance beside the contact with a spring behind it at either end.
//!
//! *Shows as*: a delay of the contact force after every reversal, the same length at every level.
//!
//! *Mistaken for*: `contact.tangential-stiffness`, `friction.breakaway`, `structure.cubic-stiffness`; told apart by quasi-static loops: with play the force rests on a plateau after each reversal.

use super::{Change, ContactForm, Effect, EffectPlace, known};
use crate::Scales;
use frettrace_friction::effects::{Hook, ModifiedLaw};

pub(super) struct ContactBacklash;

impl Effect for ContactBacklash {
    fn id(&self) -> &'static str {
        "contact.backlash"
    }

    fn place(&self) -> EffectPlace {
        EffectPlace::Contact
    }

    fn rivals(&self) -> &'static [&'static str] {
        &["contact.tangential-stiffness", "friction.breakaway", "structure.cubic-stiffness"]
    }

    fn experiment(&self) -> &'static str {
        "quasi-static loops: with play the force rests on a plateau after each reversal"
    }

    fn contact_forms(&self, law: &ModifiedLaw<f64>, scales: &Scales) -> Vec<ContactForm> {
        let play =
            |share| ContactForm::new(vec![Change::positive(Hook::Backlash, share * scales.slip, 1e-4)]);
        // A clearance beside the contact that closes onto a spring at either end.
        let stiffness = 0.2 * law.get(Hook::MuKinetic).unwrap_or(0.3) * scales.preload / scales.slip;
        let shoulders = |share: f64| {
            ContactForm::new(vec![
                Change::from_zero(Hook::ShoulderStiffness, stiffness),
                Change::between(
                    Hook::ShoulderGap,
                    share * scales.slip,
                    (0.02 * scales.slip, 0.98 * scales.slip),
                ),
            ])
        };
        vec![play(0.03), play(0.15), shoulders(0.35), shoulders(0.7)]
    }

    /// Springs behind a clearance harden, as a cubic one on the beam does.
    fn acts_like_one_outside(&self, law: &ModifiedLaw<f64>) -> bool {
        known(law, &[Hook::ShoulderStiffness])
    }

    fn shape(&self, law: &ModifiedLaw<f64>, _scales: &Scales) -> Vec<Change> {
        let power = Change::between(Hook::BacklashPower, 5.0, (1.0, 60.0));
        if known(law, &[Hook::Backlash]) { vec![power] } else { Vec::new() }
    }
}
