//! `structure.cubic-stiffness`.
//!
//! *Adds*: a restoring force with the cube of the motion of a mode, or at a place.
//!
//! *Shows as*: resonance that shifts with the level; third harmonics in the shape of the mode.
//!
//! *Mistaken for*: `contact.normal-stiffening`, `structure.second-support`; told apart by free decays from several amplitudes with the contact open: frequency rises with the square of the amplitude.

use super::{Effect, EffectPlace, FREE, StructureForm, along, cube_scale, place, with_port};
use crate::{Case, Scales, signed};
use frettrace_forward::accelerations::{COEFFICIENTS, Port, PortLaw, PortPlace, Quantity, Setting};

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
                Quantity::Port(index, 2),
                ("modal_cube", "N/m^3"),
                cube_scale(case, scales, true),
                FREE,
            );
            forms.push(StructureForm { setting, unknowns: vec![unknown], sensor: None });
        }
        for at in along(scales) {
            let (setting, index) = with_port(setting, port(PortPlace::At(at)));
            let unknown = signed(
                Quantity::Port(index, 2),
                ("local_cube", "N/m^3"),
                cube_scale(case, scales, false),
                FREE,
            );
            let position = place(Quantity::PortPosition(index), scales);
            forms.push(StructureForm { setting, unknowns: vec![unknown, position], sensor: None });
        }
        forms
    }
}
