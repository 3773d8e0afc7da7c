//! `contact.tangential-stiffness`.
//!
//! *Adds*: a spring beside the contact, straight or cubic, or a compliance in series with it.
//!
//! *Shows as*: a force in phase with slip that does not saturate with the level.
//!
//! *Mistaken for*: `friction.exponent`, `friction.breakaway`, `structure.cubic-stiffness`; told apart by loops far below sliding: a spring beside the contact stays when friction is taken away.

use super::{Change, ContactForm, Effect, EffectPlace, known};
use crate::Scales;
use frettrace_friction::effects::{Hook, ModifiedLaw};

pub(super) struct ContactTangentialStiffness;

impl Effect for ContactTangentialStiffness {
    fn id(&self) -> &'static str {
        "contact.tangential-stiffness"
    }

    fn place(&self) -> EffectPlace {
        EffectPlace::Contact
    }

    fn rivals(&self) -> &'static [&'static str] {
        &["friction.exponent", "friction.breakaway", "structure.cubic-stiffness"]
    }

    fn experiment(&self) -> &'static str {
        "loops far below sliding: a spring beside the contact stays when friction is taken away"
    }

    fn contact_forms(&self, law: &ModifiedLaw<f64>, scales: &Scales) -> Vec<ContactForm> {
        let size = 0.02 * law.get(Hook::MuKinetic).unwrap_or(0.3) * scales.preload / scales.slip;
        let sigma0 = law.get(Hook::Sigma0).unwrap_or(1e5);
        vec![
            // A spring that pushes further what has moved is none: what looks like one is a mode that is lower than declared.
            ContactForm::new(vec![Change::from_zero(Hook::ParallelStiffness, size)]),
            ContactForm::new(vec![Change::from_zero(
                Hook::SeriesCompliance,
                0.1 / (sigma0 * scales.preload),
            )]),
            ContactForm::new(vec![Change::signed(Hook::ParallelCubic, size / (scales.slip * scales.slip))]),
        ]
    }

    /// A cubic spring beside the contact does nearly what one at the beam does.
    fn acts_like_one_outside(&self, law: &ModifiedLaw<f64>) -> bool {
        known(law, &[Hook::ParallelCubic])
    }

    /// A spring beside the contact that hardens or softens, and pulls back at rest.
    fn shape(&self, _law: &ModifiedLaw<f64>, scales: &Scales) -> Vec<Change> {
        let size = 0.02 * scales.preload / scales.slip;
        let cubic = Change::signed(Hook::ParallelCubic, size / (scales.slip * scales.slip));
        [Change::from_zero(Hook::ParallelStiffness, size), cubic]
            .map(|change| Change { start: 0.0, ..change })
            .into()
    }
}
