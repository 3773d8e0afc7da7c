//! `friction.breakaway`.
//!
//! *Adds*: bristles that are elastic up to a share of their steady deflection.
//!
//! *Shows as*: loops of the middle levels too slender: no dissipation before breakaway.
//!
//! *Mistaken for*: `friction.exponent`, `contact.tangential-stiffness`; told apart by small loops just below full slip: without breakaway they dissipate, with it they do not.

use super::{Change, ContactForm, Effect, EffectPlace, known};
use crate::Scales;
use frettrace_friction::effects::{Hook, ModifiedLaw};

pub(super) struct FrictionBreakaway;

impl Effect for FrictionBreakaway {
    fn id(&self) -> &'static str {
        "friction.breakaway"
    }

    fn place(&self) -> EffectPlace {
        EffectPlace::Contact
    }

    fn rivals(&self) -> &'static [&'static str] {
        &["friction.exponent", "contact.tangential-stiffness"]
    }

    fn experiment(&self) -> &'static str {
        "small loops just below full slip: without breakaway they dissipate, with it they do not"
    }

    fn contact_forms(&self, law: &ModifiedLaw<f64>, _scales: &Scales) -> Vec<ContactForm> {
        if known(law, &[Hook::Breakaway]) {
            return Vec::new();
        }
        let share = || Change::between(Hook::Breakaway, 0.3, (0.0, 0.95));
        let shape = Change::linear(Hook::BreakawayShape, 0.3, 0.3, (-0.5, 1.5));
        vec![ContactForm::new(vec![share()]), ContactForm::new(vec![share(), shape])]
    }
}
