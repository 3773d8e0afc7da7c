//! `structure.second-support`.
//!
//! *Adds*: a further contact along the beam: spring, dashpot, friction, or a stop or play whose corner may be round or rough.
//!
//! *Shows as*: a force at one place that the one contact cannot give.
//!
//! *Mistaken for*: `structure.added-mass`, `structure.cubic-stiffness`; told apart by a stethoscope, or a feeler gauge along the beam.

use super::{Effect, EffectPlace, FREE, StructureForm, forces_along, spring_scale};
use crate::force_laws::names;
use crate::{Case, Scales, signed};
use frettrace_forward::accelerations::{PortLaw, Quantity, Setting};

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
        let [stiffness, damping] = [spring_scale(case), spring_scale(case) * scales.period];
        let [spring, dashpot, ..] = names(PortLaw::Polynomial, false);
        forces_along(setting, scales, |port| {
            vec![
                signed(Quantity::Port(port, 0), spring, stiffness, FREE),
                signed(Quantity::Port(port, 1), dashpot, damping, FREE),
            ]
        })
    }
}
