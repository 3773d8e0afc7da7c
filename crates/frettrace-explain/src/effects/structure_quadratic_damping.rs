//! `structure.quadratic-damping`.
//!
//! *Adds*: a force with the square of velocity, on a mode or at a place.
//!
//! *Shows as*: damping that grows with the level; third harmonics in phase with velocity.
//!
//! *Mistaken for*: `structure.modal-damping`, `friction.viscous`; told apart by free decays from several amplitudes with the contact open: damping rises with the amplitude.

use super::{Effect, EffectPlace, FREE, StructureForm, drag_scale, forces_along, forces_on_modes};
use crate::force_laws::names;
use crate::{Case, Scales, signed};
use frettrace_forward::accelerations::{PortLaw, Quantity, Setting};

pub(super) struct StructureQuadraticDamping;

impl Effect for StructureQuadraticDamping {
    fn id(&self) -> &'static str {
        "structure.quadratic-damping"
    }

    fn place(&self) -> EffectPlace {
        EffectPlace::Structure
    }

    fn rivals(&self) -> &'static [&'static str] {
        &["structure.modal-damping", "friction.viscous"]
    }

    fn experiment(&self) -> &'static str {
        "free decays from several amplitudes with the contact open: damping rises with the amplitude"
    }

    fn structure_forms(&self, case: &Case, setting: &Setting, scales: &Scales) -> Vec<StructureForm> {
        let drag = |port, modal| {
            let scale = drag_scale(case, modal);
            vec![signed(Quantity::Port(port, 3), names(PortLaw::Polynomial, modal)[3], scale, FREE)]
        };
        let mut forms = forces_on_modes(setting, |port| drag(port, true));
        forms.extend(forces_along(setting, scales, |port| drag(port, false)));
        forms
    }
}
