//! `excitation.base-motion`.
//!
//! *Adds*: a motion of the base, clamp and support together, in proportion to the excitation force, or of its own size on one line.
//!
//! *Shows as*: all sensors share a motion that no force on the beam gives.
//!
//! *Mistaken for*: `structure.clamp-compliance`, `measurement.gain`; told apart by an accelerometer on the clamp.

use super::{Effect, EffectPlace, FREE, StructureForm, spring_scale};
use crate::{Case, Scales, signed};
use frettrace_forward::accelerations::{FrequencyRatio, Quantity, Setting};

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
        // In proportion to the excitation, or with an acceleration of its own on the excitation's line or its double.
        [
            (None, "m/N", 1e-3 / spring_scale(case)),
            (Some(FrequencyRatio::ONE), "m/s^2", 0.1),
            (Some(FrequencyRatio::TWO), "m/s^2", 0.1),
        ]
        .map(|(line, unit, scale)| {
            let setting = Setting { base: Some([0.0, 0.0]), base_line: line, ..setting.clone() };
            let unknowns = vec![
                signed(Quantity::BaseReal, ("base_motion_real", unit), scale, FREE),
                signed(Quantity::BaseImaginary, ("base_motion_imaginary", unit), scale, FREE),
            ];
            StructureForm { setting, unknowns, sensor: None }
        })
        .into()
    }
}
