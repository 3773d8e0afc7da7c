//! `excitation.base-motion`.
//!
//! *Adds*: a motion of the clamp in proportion to the excitation force.
//!
//! *Shows as*: all sensors share a motion that no force on the beam gives.
//!
//! *Mistaken for*: `structure.clamp-compliance`, `measurement.gain`; told apart by an accelerometer on the clamp.

use super::{Effect, EffectPlace, FREE, StructureForm, spring_scale};
use crate::{Case, Scales, signed};
use frettrace_forward::accelerations::{Quantity, Setting};

pub(super) struct ExcitationBaseMotion;

impl Effect for ExcitationBaseMotion {
    fn id(&self) -> &'static str {
        "excitation.base-motion"
    }

    fn place(&self) -> EffectPlace {
        EffectPlace::Excitation
    }

    fn rivals(&self) -> &'static [&'static str] {
        &["structure.clamp-compliance", "measurement.gain"]
    }

    fn experiment(&self) -> &'static str {
        "an accelerometer on the clamp"
    }

    fn structure_forms(&self, case: &Case, setting: &Setting, _scales: &Scales) -> Vec<StructureForm> {
        let mut setting = setting.clone();
        setting.base = Some([0.0, 0.0]);
        let scale = 1e-3 / spring_scale(case);
        let unknowns = vec![
            signed(Quantity::BaseReal, ("base_motion_real", "m/N"), scale, FREE),
            signed(Quantity::BaseImaginary, ("base_motion_imaginary", "m/N"), scale, FREE),
        ];
        vec![StructureForm { setting, unknowns, sensor: None }]
    }
}
