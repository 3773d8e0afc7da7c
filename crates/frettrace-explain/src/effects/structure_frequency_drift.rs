//! `structure.frequency-drift`.
//!
//! *Adds*: natural frequencies that change steadily from the first run to the last.
//!
//! *Shows as*: a residual that grows from run to run at all sensors.
//!
//! *Mistaken for*: `friction.wear`, `structure.modal-frequency`; told apart by the first run repeated at the end.

use super::{Effect, EffectPlace, StructureForm};
use crate::{Case, Scales, signed};
use frettrace_forward::accelerations::{Quantity, Setting};

pub(super) struct StructureFrequencyDrift;

impl Effect for StructureFrequencyDrift {
    fn id(&self) -> &'static str {
        "structure.frequency-drift"
    }

    fn place(&self) -> EffectPlace {
        EffectPlace::Structure
    }

    fn rivals(&self) -> &'static [&'static str] {
        &["friction.wear", "structure.modal-frequency"]
    }

    fn experiment(&self) -> &'static str {
        "the first run repeated at the end"
    }

    fn structure_forms(&self, _case: &Case, setting: &Setting, _scales: &Scales) -> Vec<StructureForm> {
        let unknown = signed(Quantity::Drift, ("drift", "1"), 1e-4, (-0.2, 0.2));
        vec![StructureForm { setting: setting.clone(), unknowns: vec![unknown], sensor: None }]
    }
}
