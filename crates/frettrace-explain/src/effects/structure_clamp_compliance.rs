//! `structure.clamp-compliance`.
//!
//! *Adds*: a clamp that turns by `M/k_c`.
//!
//! *Shows as*: all sensors off in proportion to their distance from the clamp, at every level.
//!
//! *Mistaken for*: `structure.modal-frequency`, `structure.added-mass`; told apart by modes measured with the friction removed, before and after the campaign.

use super::{Effect, EffectPlace, StructureForm};
use crate::{Case, Scales, signed};
use frettrace_forward::accelerations::{Quantity, Setting};

pub(super) struct StructureClampCompliance;

impl Effect for StructureClampCompliance {
    fn id(&self) -> &'static str {
        "structure.clamp-compliance"
    }

    fn place(&self) -> EffectPlace {
        EffectPlace::Structure
    }

    fn rivals(&self) -> &'static [&'static str] {
        &["structure.modal-frequency", "structure.added-mass"]
    }

    fn experiment(&self) -> &'static str {
        "modes measured with the friction removed, before and after the campaign"
    }

    fn structure_forms(&self, _case: &Case, setting: &Setting, _scales: &Scales) -> Vec<StructureForm> {
        let mut setting = setting.clone();
        setting.clamp_compliance = 1e-6;
        let unknown = signed(Quantity::ClampCompliance, ("clamp_compliance", "1"), 0.003, (0.0, 0.5));
        vec![StructureForm { setting, unknowns: vec![unknown], sensor: None }]
    }
}
