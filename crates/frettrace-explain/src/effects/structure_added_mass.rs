//! `structure.added-mass`.
//!
//! *Adds*: a mass at a place of the beam.
//!
//! *Shows as*: lines near the upper resonances off at every level, in proportion to the acceleration at one place.
//!
//! *Mistaken for*: `structure.modal-frequency`, `structure.second-support`; told apart by modes measured with the friction removed: a mass lowers those that move at its place.

use super::{Effect, EffectPlace, StructureForm, along, place};
use crate::{Case, Scales, signed};
use frettrace_forward::accelerations::{Quantity, Setting};

pub(super) struct StructureAddedMass;

impl Effect for StructureAddedMass {
    fn id(&self) -> &'static str {
        "structure.added-mass"
    }

    fn place(&self) -> EffectPlace {
        EffectPlace::Structure
    }

    fn rivals(&self) -> &'static [&'static str] {
        &["structure.modal-frequency", "structure.second-support"]
    }

    fn experiment(&self) -> &'static str {
        "modes measured with the friction removed: a mass lowers those that move at its place"
    }

    fn structure_forms(&self, _case: &Case, setting: &Setting, scales: &Scales) -> Vec<StructureForm> {
        along(scales)
            .map(|at| {
                let mut setting = setting.clone();
                setting.mass = Some([0.0, at]);
                let mass = signed(
                    Quantity::AddedMass,
                    ("added_mass", "kg"),
                    0.005 * scales.mass,
                    (-0.02 * scales.mass, scales.mass),
                );
                let unknowns = vec![mass, place(Quantity::MassPosition, scales)];
                StructureForm { setting, unknowns, sensor: None }
            })
            .collect()
    }
}
