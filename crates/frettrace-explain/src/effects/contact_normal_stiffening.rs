//! `contact.normal-stiffening`.
//!
//! *Adds*: a support spring that stiffens, `k₂w² + k₃w³` beside its linear part, up to `k₅w⁵` where the data ask for it.
//!
//! *Shows as*: even and third harmonics at all sensors that grow with the square and cube of the motion of the end.
//!
//! *Mistaken for*: `contact.lift-off`, `friction.normal-dependence`; told apart by a load cell under the support, or two preloads.

use super::{Effect, EffectPlace, FREE, StructureForm, with_port};
use crate::{Case, Scales, signed};
use frettrace_forward::accelerations::{COEFFICIENTS, Port, PortLaw, PortPlace, Quantity, Setting};

pub(super) struct ContactNormalStiffening;

impl Effect for ContactNormalStiffening {
    fn id(&self) -> &'static str {
        "contact.normal-stiffening"
    }

    fn place(&self) -> EffectPlace {
        EffectPlace::Contact
    }

    fn rivals(&self) -> &'static [&'static str] {
        &["contact.lift-off", "friction.normal-dependence"]
    }

    fn experiment(&self) -> &'static str {
        "a load cell under the support, or two preloads"
    }

    fn structure_forms(&self, case: &Case, setting: &Setting, scales: &Scales) -> Vec<StructureForm> {
        let stiffness = case.rig.boundary.support_stiffness;
        if !(stiffness > 0.0 && stiffness.is_finite()) {
            return Vec::new();
        }
        let port =
            Port { place: PortPlace::Support, law: PortLaw::Stiffening, coefficients: [0.0; COEFFICIENTS] };
        let (setting, index) = with_port(setting, port);
        let depth = scales.preload / stiffness;
        let coefficient = |k: usize| {
            let degree = k as i32 + 2;
            let size = 0.1 * stiffness * depth.powi(1 - degree);
            signed(Quantity::Port(index, k), NAMES[k], size, FREE)
        };
        // Two terms say what most supports do; four carry other curves.
        [2, 4]
            .map(|terms| StructureForm {
                setting: setting.clone(),
                unknowns: (0..terms).map(coefficient).collect(),
                sensor: None,
            })
            .into()
    }
}

/// Coefficients of the second to the fifth power of the displacement.
const NAMES: [(&str, &str); COEFFICIENTS] = [
    ("support_square", "N/m^2"),
    ("support_cube", "N/m^3"),
    ("support_quartic", "N/m^4"),
    ("support_quintic", "N/m^5"),
];
