//! `contact.normal-stiffening`.
//!
//! *Adds*: a support spring that stiffens, `k₂w² + k₃w³` beside its linear part, up to `k₅w⁵` where the data ask for it.
//!
//! *Shows as*: even and third harmonics at all sensors that grow with the square and cube of the motion of the end.
//!
//! *Mistaken for*: `contact.lift-off`, `friction.normal-dependence`; told apart by a load cell under the support, or two preloads.

use super::{Effect, EffectPlace, FREE, StructureForm, with_port};
use crate::{Case, Scales, Unknown, signed};
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
        let Some(stiffness) = stiffness(case) else { return Vec::new() };
        let port =
            Port { place: PortPlace::Support, law: PortLaw::Stiffening, coefficients: [0.0; COEFFICIENTS] };
        let (setting, index) = with_port(setting, port);
        // Two terms say what most supports do; four carry other curves.
        [2, 4]
            .map(|terms| StructureForm {
                setting: setting.clone(),
                unknowns: coefficients(stiffness, index, scales).take(terms).collect(),
                sensor: None,
            })
            .into()
    }

    fn further_terms(&self, case: &Case, setting: &Setting, scales: &Scales) -> Vec<Unknown> {
        let index = setting.ports.iter().rposition(|port| port.law == PortLaw::Stiffening);
        let Some((index, stiffness)) = index.zip(stiffness(case)) else { return Vec::new() };
        coefficients(stiffness, index, scales).collect()
    }
}

/// Stiffness of the support (N/m) where it is one that can stiffen.
fn stiffness(case: &Case) -> Option<f64> {
    Some(case.rig.boundary.support_stiffness).filter(|stiffness| *stiffness > 0.0)
}

/// The coefficients of a stiffening port, each of the size that changes the support's force at the preload by a tenth.
fn coefficients(stiffness: f64, index: usize, scales: &Scales) -> impl Iterator<Item = Unknown> + use<> {
    let depth = scales.preload / stiffness;
    NAMES.into_iter().enumerate().map(move |(k, name)| {
        let size = 0.1 * stiffness * depth.powi(-1 - k as i32);
        signed(Quantity::Port(index, k), name, size, FREE)
    })
}

/// Coefficients of the second to the fifth power of the displacement.
const NAMES: [(&str, &str); COEFFICIENTS] = [
    ("support_square", "N/m^2"),
    ("support_cube", "N/m^3"),
    ("support_quartic", "N/m^4"),
    ("support_quintic", "N/m^5"),
];

#[cfg(test)]
mod tests {
    use super::*;
    use frettrace_identify::Transform;

    /// A term whose coefficient has its size changes the force at the depth that the preload presses the support to, `P/k`, by `P/10`: the force of
    /// `c dⁿ` is linear in `c`.
    #[test]
    fn a_term_of_its_size_changes_the_preload_by_a_tenth() {
        let (stiffness, preload) = (2.0e4, 40.0);
        let scales = Scales { preload, ..Scales::default() };
        let depth = preload / stiffness;
        for (k, unknown) in coefficients(stiffness, 0, &scales).enumerate() {
            let Transform::Linear { scale } = unknown.parameter.transform else { panic!("a signed value") };
            let mut coefficients = [0.0; COEFFICIENTS];
            coefficients[k] = scale;
            let force = PortLaw::Stiffening.force(&coefficients, depth, 0.0).force;
            assert!((force / (0.1 * preload) - 1.0).abs() < 1e-12, "term {k}: {force}");
        }
    }
}
