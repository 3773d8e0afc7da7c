//! `structure.cubic-stiffness`.
//!
//! *Adds*: a restoring force with the cube of the motion of a mode, or at a place.
//!
//! *Shows as*: resonance that shifts with the level; third harmonics in the shape of the mode.
//!
//! *Mistaken for*: `contact.normal-stiffening`, `structure.second-support`; told apart by free decays from several amplitudes with the contact open: frequency rises with the square of the amplitude.

use super::{Effect, EffectPlace, FREE, StructureForm, cube_scale, forces_along, forces_on_modes};
use crate::force_laws::names;
use crate::{Case, Scales, signed};
use frettrace_forward::accelerations::{PortLaw, Quantity, Setting};

pub(super) struct StructureCubicStiffness;

impl Effect for StructureCubicStiffness {
    fn id(&self) -> &'static str {
        "structure.cubic-stiffness"
    }

    fn place(&self) -> EffectPlace {
        EffectPlace::Structure
    }

    fn rivals(&self) -> &'static [&'static str] {
        &["contact.normal-stiffening", "structure.second-support"]
    }

    fn experiment(&self) -> &'static str {
        "free decays from several amplitudes with the contact open: frequency rises with the square of the amplitude"
    }

    fn structure_forms(&self, case: &Case, setting: &Setting, scales: &Scales) -> Vec<StructureForm> {
        let cube = |port, modal| {
            let scale = cube_scale(case, scales, modal);
            vec![signed(Quantity::Port(port, 2), names(PortLaw::Polynomial, modal)[2], scale, FREE)]
        };
        let mut forms = forces_on_modes(setting, |port| cube(port, true));
        forms.extend(forces_along(setting, scales, |port| cube(port, false)));
        forms
    }
}
