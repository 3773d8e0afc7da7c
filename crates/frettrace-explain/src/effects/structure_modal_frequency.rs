//! `structure.modal-frequency`.
//!
//! *Adds*: a natural frequency further from its declared value than its standard deviation, or all of them by the same share.
//!
//! *Shows as*: lines near that resonance off at every level.
//!
//! *Mistaken for*: `structure.added-mass`, `structure.clamp-compliance`; told apart by modes measured with the friction removed, repeated.

use super::{Effect, EffectPlace, StructureForm};
use crate::{Case, Scales, signed};
use frettrace_forward::accelerations::{Quantity, Setting};

pub(super) struct StructureModalFrequency;

/// Another temperature or modulus: all natural frequencies by the same share.
fn all_of_them(setting: &Setting) -> StructureForm {
    let unknown = signed(Quantity::FrequencyScale, ("frequency_scale", "1"), 1e-3, (-0.3, 0.3));
    StructureForm { setting: setting.clone(), unknowns: vec![unknown], sensor: None }
}

impl Effect for StructureModalFrequency {
    fn id(&self) -> &'static str {
        "structure.modal-frequency"
    }

    fn place(&self) -> EffectPlace {
        EffectPlace::Structure
    }

    fn rivals(&self) -> &'static [&'static str] {
        &["structure.added-mass", "structure.clamp-compliance"]
    }

    fn experiment(&self) -> &'static str {
        "modes measured with the friction removed, repeated"
    }

    fn is_exact(&self) -> bool {
        true
    }

    fn structure_forms(&self, _case: &Case, setting: &Setting, _scales: &Scales) -> Vec<StructureForm> {
        (0..setting.frequency.len())
            .map(|mode| {
                let value = setting.frequency[mode];
                let name = format!("frequency_{}", mode + 1);
                let unknown = signed(
                    Quantity::ModeFrequency(mode),
                    (&name, "rad/s"),
                    1e-3 * value,
                    (0.5 * value, 1.5 * value),
                );
                StructureForm { setting: setting.clone(), unknowns: vec![unknown], sensor: None }
            })
            .chain([all_of_them(setting)])
            .collect()
    }
}
