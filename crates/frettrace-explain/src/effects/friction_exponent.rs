//! `friction.exponent`.
//!
//! *Adds*: the exponent of the bristle law, `|1 − r|^i`; after a breakaway `|1 − α(r) r|^i`, or the loading `r|r|^{n−1}` in it.
//!
//! *Shows as*: the bend between presliding and sliding is sharper or rounder.
//!
//! *Mistaken for*: `friction.breakaway`, `contact.tangential-stiffness`; told apart by small loops at finely stepped levels: the power of dissipation against amplitude is the exponent.

use super::{Change, ContactForm, Effect, EffectPlace, known};
use crate::Scales;
use frettrace_friction::effects::{Hook, ModifiedLaw};

pub(super) struct FrictionExponent;

impl Effect for FrictionExponent {
    fn id(&self) -> &'static str {
        "friction.exponent"
    }

    fn place(&self) -> EffectPlace {
        EffectPlace::Contact
    }

    fn rivals(&self) -> &'static [&'static str] {
        &["friction.breakaway", "contact.tangential-stiffness"]
    }

    fn experiment(&self) -> &'static str {
        "small loops at finely stepped levels: the power of dissipation against amplitude is the exponent"
    }

    fn contact_forms(&self, law: &ModifiedLaw<f64>, _scales: &Scales) -> Vec<ContactForm> {
        if known(law, &[Hook::Exponent]) {
            return Vec::new();
        }
        vec![
            // After a breakaway it bends the flow `1 − α(r) r` as a whole …
            ContactForm::new(vec![Change::between(Hook::Exponent, 0.8, (0.02, 8.0))]),
            ContactForm::new(vec![Change::between(Hook::Exponent, 1.3, (0.02, 8.0))]),
            // The exponent on the loading itself, as hysteresis models of Bouc's kind have it.
            ContactForm::new(vec![Change::between(Hook::FlowPower, 0.7, (0.1, 12.0))]),
            ContactForm::new(vec![Change::between(Hook::FlowPower, 1.6, (0.1, 12.0))]),
        ]
    }
}
