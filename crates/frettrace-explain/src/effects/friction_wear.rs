//! `friction.wear`.
//!
//! *Adds*: a friction coefficient that changes from the first run to the last, steadily or ever more slowly, with the number
//! of the run or with the work that friction has done.
//!
//! *Shows as*: a residual that grows from run to run, not with the level.
//!
//! *Mistaken for*: `structure.frequency-drift`; told apart by the first run repeated at the end: worn friction does not come back.

use super::{Change, ContactForm, Effect, EffectPlace};
use crate::Scales;
use frettrace_friction::effects::{Hook, ModifiedLaw};

pub(super) struct FrictionWear;

impl Effect for FrictionWear {
    fn id(&self) -> &'static str {
        "friction.wear"
    }

    fn place(&self) -> EffectPlace {
        EffectPlace::Contact
    }

    fn rivals(&self) -> &'static [&'static str] {
        &["structure.frequency-drift"]
    }

    fn experiment(&self) -> &'static str {
        "the first run repeated at the end: worn friction does not come back"
    }

    fn contact_forms(&self, _law: &ModifiedLaw<f64>, _scales: &Scales) -> Vec<ContactForm> {
        let change = || Change::linear(Hook::Wear, 0.02, 0.05, (-0.9, 5.0));
        let by_work = || Change::fixed(Hook::WearWork, 1.0);
        let settling = || Change::between(Hook::WearSettling, 3.0, (-6.0, 40.0));
        let own = || Change::linear(Hook::WearOwn, 0.5, 0.5, (0.0, 1.0));
        let course = |start| Change::between(Hook::WearExponent, start, (0.1, 12.0));
        vec![
            ContactForm::new(vec![change()]),
            ContactForm::new(vec![change(), course(0.5)]),
            ContactForm::new(vec![change(), course(3.0)]),
            ContactForm::new(vec![change(), Change::between(Hook::WearSettling, 3.0, (-6.0, 12.0))]),
            // With the work that friction has done, steadily and settling …
            ContactForm::new(vec![change(), by_work()]),
            ContactForm::new(vec![change(), by_work(), settling()]),
            // … where the rig ran at a level before its record began, or rested within it.
            ContactForm::new(vec![change(), by_work(), own()]),
            ContactForm::new(vec![change(), by_work(), settling(), own()]),
        ]
    }

    fn shape(&self, _law: &ModifiedLaw<f64>, _scales: &Scales) -> Vec<Change> {
        vec![
            Change::between(Hook::WearExponent, 1.0, (0.1, 12.0)),
            Change::linear(Hook::WearSettling, 0.0, 1.0, (-6.0, 12.0)),
            // From the number of the run to the work that friction has done.
            Change::linear(Hook::WearWork, 0.0, 0.5, (0.0, 1.0)),
        ]
    }
}
