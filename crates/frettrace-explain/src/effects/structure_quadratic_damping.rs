//! `structure.quadratic-damping`.
//!
//! *Adds*: a force with the square of velocity, on a mode or at a place.
//!
//! *Shows as*: damping that grows with the level; third harmonics in phase with velocity.
//!
//! *Mistaken for*: `structure.modal-damping`, `friction.viscous`; told apart by free decays from several amplitudes with the contact open: damping rises with the amplitude.

use super::{Effect, EffectPlace, FREE, StructureForm, along, drag_scale, place, with_port};
use crate::{Case, Scales, signed};
use frettrace_forward::accelerations::{COEFFICIENTS, Port, PortLaw, PortPlace, Quantity, Setting};

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
        if case.rig.sensors.len() > 2 {
            // The force is located without its law, and the law read off it.
            return Vec::new();
        }
        let modes = setting.frequency.len().min(2);
        let port = |place| Port { place, law: PortLaw::Polynomial, coefficients: [0.0; COEFFICIENTS] };
        let mut forms: Vec<StructureForm> = Vec::new();
        for mode in 0..modes {
            let (setting, index) = with_port(setting, port(PortPlace::Mode(mode)));
            let unknown = signed(
                Quantity::Port(index, 3),
                ("modal_square_damping", "N·s^2/m^2"),
                drag_scale(case, true),
                FREE,
            );
            forms.push(StructureForm { setting, unknowns: vec![unknown], sensor: None });
        }
        for at in along(scales) {
            let (setting, index) = with_port(setting, port(PortPlace::At(at)));
            let unknown = signed(
                Quantity::Port(index, 3),
                ("local_square_damping", "N·s^2/m^2"),
                drag_scale(case, false),
                FREE,
            );
            let position = place(Quantity::PortPosition(index), scales);
            forms.push(StructureForm { setting, unknowns: vec![unknown, position], sensor: None });
        }
        forms
    }
}
