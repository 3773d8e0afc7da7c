//! `friction.position-periodic`.
//!
//! *Adds*: a friction coefficient periodic in slip, `μ(1 + Σ_k c_k cos kqu + s_k sin kqu)`, up to the third harmonic where the data ask for it.
//!
//! *Shows as*: ripples of the sliding branches at fixed positions.
//!
//! *Mistaken for*: `friction.position`; told apart by strokes of several lengths over the same track: the wave length stays, the harmonics move.

use super::{Change, ContactForm, Effect, EffectPlace};
use crate::Scales;
use frettrace_friction::effects::{Hook, ModifiedLaw};

pub(super) struct FrictionPositionPeriodic;

impl Effect for FrictionPositionPeriodic {
    fn id(&self) -> &'static str {
        "friction.position-periodic"
    }

    fn place(&self) -> EffectPlace {
        EffectPlace::Contact
    }

    fn rivals(&self) -> &'static [&'static str] {
        &["friction.position"]
    }

    fn experiment(&self) -> &'static str {
        "strokes of several lengths over the same track: the wave length stays, the harmonics move"
    }

    fn contact_forms(&self, _law: &ModifiedLaw<f64>, scales: &Scales) -> Vec<ContactForm> {
        // Waves in the largest slip: neighbours are half a wave apart there, so that one of them is in the valley of the right one.
        [0.3, 0.6, 1.0, 1.5, 2.0, 2.5, 3.0, 3.5, 4.0]
            .map(|waves| {
                ContactForm::new(vec![
                    Change::linear(Hook::PeriodicCosine, 0.03, 0.05, (-0.9, 0.9)),
                    Change::linear(Hook::PeriodicSine, 0.03, 0.05, (-0.9, 0.9)),
                    Change::positive(Hook::PeriodicNumber, std::f64::consts::TAU * waves / scales.slip, 0.02),
                ])
            })
            .into()
    }

    fn shape(&self, _scales: &Scales) -> Vec<Change> {
        [Hook::PeriodicCosine2, Hook::PeriodicSine2, Hook::PeriodicCosine3, Hook::PeriodicSine3]
            .map(|hook| Change::linear(hook, 0.0, 0.05, (-0.9, 0.9)))
            .into()
    }
}
