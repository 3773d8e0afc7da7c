//! `friction.lag`.
//!
//! *Adds*: a friction coefficient (or force) that follows the motion as a lag of first order, at a bounded rate, or with a delay.
//!
//! *Shows as*: loops whose sliding branches differ between rising and falling speed.
//!
//! *Mistaken for*: `friction.film`, `friction.stribeck`; told apart by the same level at two excitation frequencies: the loop opens with frequency where friction lags.

use super::{Change, ContactForm, Effect, EffectPlace, known};
use crate::Scales;
use frettrace_friction::effects::{Hook, ModifiedLaw};

pub(super) struct FrictionLag;

impl Effect for FrictionLag {
    fn id(&self) -> &'static str {
        "friction.lag"
    }

    fn place(&self) -> EffectPlace {
        EffectPlace::Contact
    }

    fn rivals(&self) -> &'static [&'static str] {
        &["friction.film", "friction.stribeck"]
    }

    fn experiment(&self) -> &'static str {
        "the same level at two excitation frequencies: the loop opens with frequency where friction lags"
    }

    fn contact_forms(&self, law: &ModifiedLaw<f64>, scales: &Scales) -> Vec<ContactForm> {
        let mu = law.get(Hook::MuKinetic).unwrap_or(0.3);
        let mut forms = Vec::new();
        for share in [0.01, 0.05] {
            for hook in [Hook::LagTime, Hook::SpeedLag, Hook::VelocityLag] {
                let mut changes = vec![Change::positive(hook, share * scales.period, 1e-4)];
                if !known(law, &[Hook::StribeckRise]) {
                    changes.push(Change::positive(Hook::StribeckRise, 0.3 * mu, 1e-3));
                    changes.push(Change::positive(Hook::StribeckVelocity, 0.2 * scales.velocity, 1e-3));
                }
                forms.push(ContactForm::new(changes.clone()));
                if hook == Hook::VelocityLag {
                    // A velocity that is delayed: half of the time, twice.
                    let delayed = changes.iter().cloned().chain([Change::fixed(Hook::LagDelay, 1.0)]);
                    forms.push(ContactForm::new(delayed.collect()));
                }
                // A friction that follows no faster than it can.
                changes.push(Change::linear(Hook::LagSaturation, 1.0, 1.0, (0.0, 50.0)));
                forms.push(ContactForm::new(changes));
            }
            let time = Change::positive(Hook::ForceLag, 0.3 * share * scales.period, 1e-4);
            forms.push(ContactForm::new(vec![time]));
        }
        forms
    }

    /// From a lag of first order to a delay, and from one that follows at any rate to one of a bounded rate.
    fn shape(&self, law: &ModifiedLaw<f64>, _scales: &Scales) -> Vec<Change> {
        if !known(law, &[Hook::LagTime, Hook::SpeedLag, Hook::VelocityLag]) {
            return Vec::new();
        }
        vec![
            Change::linear(Hook::LagDelay, 0.0, 0.3, (-0.9, 1.5)),
            Change::linear(Hook::LagSaturation, 0.5, 1.0, (0.0, 50.0)),
            Change::between(Hook::LagPower, 2.0, (0.5, 20.0)),
        ]
    }

    fn memories(&self) -> &'static [Hook] {
        &[Hook::LagTime, Hook::SpeedLag, Hook::VelocityLag]
    }
}
