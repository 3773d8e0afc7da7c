//! `structure.second-support`.
//!
//! *Adds*: a further contact along the beam: spring, dashpot, friction, or a stop or play whose corner may be round or rough.
//!
//! *Shows as*: a force at one place that the one contact cannot give.
//!
//! *Mistaken for*: `structure.added-mass`, `structure.cubic-stiffness`; told apart by a stethoscope, or a feeler gauge along the beam.

use super::{Effect, EffectPlace, FREE, StructureForm, along, place, spring_scale, with_port};
use crate::{Case, Scales, signed};
use frettrace_forward::accelerations::{COEFFICIENTS, Port, PortLaw, PortPlace, Quantity, Setting};

pub(super) struct StructureSecondSupport;

impl Effect for StructureSecondSupport {
    fn id(&self) -> &'static str {
        "structure.second-support"
    }

    fn place(&self) -> EffectPlace {
        EffectPlace::Structure
    }

    fn rivals(&self) -> &'static [&'static str] {
        &["structure.added-mass", "structure.cubic-stiffness"]
    }

    fn experiment(&self) -> &'static str {
        "a stethoscope, or a feeler gauge along the beam"
    }

    fn structure_forms(&self, case: &Case, setting: &Setting, scales: &Scales) -> Vec<StructureForm> {
        if case.rig.sensors.len() > 2 {
            // The force is located without its law, and the law read off it.
            return Vec::new();
        }
        let port = |place| Port { place, law: PortLaw::Polynomial, coefficients: [0.0; COEFFICIENTS] };
        along(scales)
            .map(|at| {
                let (setting, index) = with_port(setting, port(PortPlace::At(at)));
                let unknowns = vec![
                    signed(Quantity::Port(index, 0), ("support_stiffness", "N/m"), spring_scale(case), FREE),
                    signed(
                        Quantity::Port(index, 1),
                        ("support_damping", "N·s/m"),
                        spring_scale(case) * scales.period,
                        FREE,
                    ),
                    place(Quantity::PortPosition(index), scales),
                ];
                StructureForm { setting, unknowns, sensor: None }
            })
            .collect()
    }
}
