//! `structure.frequency-drift`.
//!
//! *Adds*: natural frequencies that change from the first run to the last, steadily or ever more slowly.
//!
//! *Shows as*: a residual that grows from run to run at all sensors.
//!
//! *Mistaken for*: `friction.wear`, `structure.modal-frequency`; told apart by the first run repeated at the end.

use super::{Effect, EffectPlace, StructureForm};
use crate::{Case, Scales, Unknown, signed};
use frettrace_forward::accelerations::{Quantity, Setting};

/// Rate and slowing that a settling drift is begun with: more than half of it in the first quarter of the runs.
const SETTLING: [f64; 2] = [3.0, 0.5];

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
        let drift = signed(Quantity::Drift, ("drift", "1"), 1e-4, (-0.2, 0.2));
        let rate = signed(Quantity::DriftRate, ("drift_rate", "1"), 1.0, (0.0, 50.0));
        let slowing = signed(Quantity::DriftSlowing, ("drift_slowing", "1"), 0.5, (0.0, 20.0));
        let form = |drift_course: [f64; 2], unknowns: Vec<Unknown>| StructureForm {
            setting: Setting { drift_course, ..setting.clone() },
            unknowns,
            sensor: None,
        };
        vec![form([0.0; 2], vec![drift.clone()]), form(SETTLING, vec![drift, rate, slowing])]
    }
}
