//! `friction.stribeck`.
//!
//! *Adds*: a friction coefficient that falls with speed, `μ(v) = μ_k + Δμ·w(|v|/v_s)`, `w` exponential with a free exponent, rational, or any curve
//! between these and beyond, down to one that ends at a speed.
//!
//! *Shows as*: friction missing near the reversals, in every loop of every level; odd harmonics of the force.
//!
//! *Mistaken for*: `friction.lag`, `friction.film`; told apart by runs whose slip speed stays below and far above the Stribeck velocity, at two frequencies: a lag moves with frequency, the curve does not.

use super::{Change, ContactForm, Effect, EffectPlace, known};
use crate::Scales;
use frettrace_friction::effects::{Hook, ModifiedLaw};

pub(super) struct FrictionStribeck;

impl Effect for FrictionStribeck {
    fn id(&self) -> &'static str {
        "friction.stribeck"
    }

    fn place(&self) -> EffectPlace {
        EffectPlace::Contact
    }

    fn rivals(&self) -> &'static [&'static str] {
        &["friction.lag", "friction.film"]
    }

    fn experiment(&self) -> &'static str {
        "runs whose slip speed stays below and far above the Stribeck velocity, at two frequencies: a lag moves with frequency, the curve does not"
    }

    fn contact_forms(&self, law: &ModifiedLaw<f64>, scales: &Scales) -> Vec<ContactForm> {
        if known(law, &[Hook::StribeckRise]) {
            return Vec::new();
        }
        let mu = law.get(Hook::MuKinetic).unwrap_or(0.3);
        let mut forms = Vec::new();
        for share in [0.04, 0.15, 0.5] {
            for rational in [false, true] {
                let mut changes = vec![
                    Change::positive(Hook::StribeckRise, 0.3 * mu, 1e-3),
                    Change::positive(Hook::StribeckVelocity, share * scales.velocity, 1e-3),
                    Change::between(Hook::StribeckExponent, 1.5, (0.4, 6.0)),
                ];
                if rational {
                    changes.push(Change::fixed(Hook::RationalShare, 1.0));
                }
                forms.push(ContactForm::new(changes));
            }
            forms.push(ContactForm::new(vec![
                Change::positive(Hook::StribeckRise, 0.3 * mu, 1e-3),
                Change::positive(Hook::StribeckVelocity, share * scales.velocity, 1e-3),
                Change::between(Hook::StribeckExponent, 1.5, (0.4, 6.0)),
                Change::between(Hook::RationalShare, 0.5, (0.0, 1.0)),
            ]));
        }
        forms
    }

    /// Between and beyond the exponential and the rational curve: one that ends at a speed, or falls for longer.
    fn shape(&self, law: &ModifiedLaw<f64>, _scales: &Scales) -> Vec<Change> {
        if !known(law, &[Hook::StribeckRise]) {
            return Vec::new();
        }
        let start = 1.0 + law.get(Hook::RationalShare).unwrap_or(0.0);
        vec![Change::linear(Hook::StribeckBend, start, 0.3, (-1.0, 5.0))]
    }
}
