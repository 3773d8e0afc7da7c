//! `contact.lift-off`.
//!
//! *Adds*: a support that cannot pull: its force, a spring's or a spring's and a damper's, ends at zero.
//!
//! *Shows as*: from a certain level on, harmonics of all orders and sensors near the support.
//!
//! *Mistaken for*: `contact.normal-stiffening`; told apart by the preload raised by half: lift-off goes away, stiffening stays.

use super::{Effect, EffectPlace, StructureForm, with_port};
use crate::{Case, Scales, Unknown, signed};
use frettrace_forward::accelerations::{Port, PortLaw, PortPlace, Quantity, Setting};
use frettrace_identify::{Parameter, Prior};

pub(super) struct ContactLiftOff;

impl Effect for ContactLiftOff {
    fn id(&self) -> &'static str {
        "contact.lift-off"
    }

    fn place(&self) -> EffectPlace {
        EffectPlace::Contact
    }

    fn rivals(&self) -> &'static [&'static str] {
        &["contact.normal-stiffening"]
    }

    fn experiment(&self) -> &'static str {
        "the preload raised by half: lift-off goes away, stiffening stays"
    }

    fn structure_forms(&self, case: &Case, setting: &Setting, scales: &Scales) -> Vec<StructureForm> {
        let stiffness = case.rig.boundary.support_stiffness;
        if stiffness <= 0.0 {
            return Vec::new();
        }
        let port = Port {
            place: PortPlace::Support,
            law: PortLaw::LiftOff,
            coefficients: [stiffness, scales.preload, 0.0, 0.0],
        };
        let (setting, index) = with_port(setting, port);
        let prior = Prior { mean: scales.preload, std: 0.02 * scales.preload };
        let preload = Unknown {
            quantity: Quantity::Port(index, 1),
            parameter: Parameter::declared("lift_off_preload", "N", prior),
        };
        let plain = StructureForm { setting, unknowns: vec![preload], sensor: None };
        // A damper that lets go with the spring, a hundredth of what the spring takes in a period.
        let size = 0.01 * stiffness * scales.period / std::f64::consts::TAU;
        let damper = (Quantity::Port(index, 2), ("lift_off_damping", "N·s/m"));
        let mut damped = plain.clone();
        damped.unknowns.push(signed(damper.0, damper.1, size, (0.0, f64::INFINITY)));
        damped.setting.set(damper.0, size);
        vec![plain, damped]
    }
}
