//! `structure.modal-damping`.
//!
//! *Adds*: a damping ratio further from its declared value than its standard deviation.
//!
//! *Shows as*: lines near that resonance off in phase at every level.
//!
//! *Mistaken for*: `friction.viscous`, `structure.quadratic-damping`; told apart by a decay test with the contact open.

use super::{Effect, EffectPlace, StructureForm};
use crate::{Case, Scales, signed};
use frettrace_forward::accelerations::{Quantity, Setting};

pub(super) struct StructureModalDamping;

/// A material or a joint that damps otherwise: all damping ratios by the same share.
fn all_of_them(setting: &Setting) -> StructureForm {
    let unknown = signed(Quantity::DampingScale, ("damping_scale", "1"), 0.05, (-0.98, 20.0));
    StructureForm { setting: setting.clone(), unknowns: vec![unknown], sensor: None }
}

impl Effect for StructureModalDamping {
    fn id(&self) -> &'static str {
        "structure.modal-damping"
    }

    fn place(&self) -> EffectPlace {
        EffectPlace::Structure
    }

    fn rivals(&self) -> &'static [&'static str] {
        &["friction.viscous", "structure.quadratic-damping"]
    }

    fn experiment(&self) -> &'static str {
        "a decay test with the contact open"
    }

    fn is_exact(&self) -> bool {
        true
    }

    fn structure_forms(&self, _case: &Case, setting: &Setting, _scales: &Scales) -> Vec<StructureForm> {
        (0..setting.frequency.len())
            .map(|mode| {
                let value = setting.damping[mode];
                let name = format!("damping_{}", mode + 1);
                let unknown = signed(
                    Quantity::ModeDamping(mode),
                    (&name, "1"),
                    0.05 * value,
                    (0.02 * value, 20.0 * value),
                );
                StructureForm { setting: setting.clone(), unknowns: vec![unknown], sensor: None }
            })
            .chain([all_of_them(setting)])
            .collect()
    }
}
