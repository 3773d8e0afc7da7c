//! A joint fit as it stands in the result file.

use super::super::estimates::{estimate, remark};
use super::Joint;
use super::aperiodic::ACCURACY;
use crate::StudyError;
use crate::results::{
    ErrorSummary, Estimate, HeldOut, Identification, ModeEstimate, NoiseFloorSource, Provenance, Step,
    Structure,
};
use frettrace_explain::Study;
use frettrace_forward::accelerations::Quantity;
use frettrace_friction::effects::Hook;
use frettrace_identify::contact::ContactFit;
use frettrace_identify::{IdentifiedParameter, IdentifySettings, Parameter};
use frettrace_measurement::Measurement;
use std::collections::BTreeMap;

/// The result file of a joint fit.
pub(super) fn described((measurement, study): (&Measurement, &Study<'_>), joint: &Joint) -> Identification {
    let names = |runs: &[usize]| runs.iter().map(|k| measurement.runs[*k].id.clone()).collect::<Vec<_>>();
    let stated = measurement.sensors.noise_std.is_some();
    let summary = |runs: &[usize]| {
        let error = study.error(&joint.fitted, runs);
        ErrorSummary {
            force: None,
            acceleration: Some(error.relative()),
            noise_floor: error.relative_floor(),
            noise_floor_source: if stated { NoiseFloorSource::Given } else { NoiseFloorSource::Estimated },
        }
    };
    let mut notes = Vec::new();
    let mut parameters = BTreeMap::new();
    for parameter in published(joint) {
        notes.extend(remark(&parameter.name, &parameter));
        parameters.insert(parameter.name.clone(), estimate(&parameter));
    }
    let fitted = [&study.training[..], &study.held_out[..], &joint.aperiodic].concat();
    if !joint.aperiodic.is_empty() {
        notes.push(format!(
            "runs that are not periodic take part by the force and slip recovered of them, each force known to {} % as a whole: {}",
            100.0 * ACCURACY,
            names(&joint.aperiodic).join(", ")
        ));
    }
    let left_out: Vec<usize> = (0..measurement.runs.len()).filter(|k| !fitted.contains(k)).collect();
    if !left_out.is_empty() {
        notes.push(format!(
            "runs that could not be recovered or have no balanced solution take no part: {}",
            names(&left_out).join(", ")
        ));
    }
    let held_out = HeldOut { error: summary(&study.held_out), runs: names(&study.held_out) };
    Identification {
        law: joint.family.name().to_owned(),
        parameters,
        structure: structure(joint),
        steps: joint.steps.clone(),
        error: summary(&study.training),
        held_out: (!study.held_out.is_empty()).then_some(held_out),
        provenance: Provenance {
            version: env!("CARGO_PKG_VERSION").to_owned(),
            seed: 0,
            training_runs: names(&study.training),
        },
        notes,
        ..Identification::default()
    }
}

/// The result of the steps on the recovered loops where law and structure together have no solution.
pub(super) fn from_loops_alone(
    loops: &ContactFit,
    error: &StudyError,
    mut notes: Vec<String>,
) -> Identification {
    let parameters = loops.identified.parameters.iter();
    notes.push(format!(
        "law and structure together could not be fitted to the accelerations ({error}); the parameters are those of the \
         recovered force and slip, whose errors are correlated"
    ));
    notes.extend(parameters.clone().filter_map(|p| remark(&p.name, p)));
    let steps = loops.steps.iter().map(|s| Step {
        name: s.name.clone(),
        parameters: s.parameters.clone(),
        error: s.error,
    });
    Identification {
        law: loops.family.name().to_owned(),
        parameters: parameters.map(|p| (p.name.clone(), estimate(p))).collect(),
        steps: steps.collect(),
        error: ErrorSummary { force: Some(loops.error), ..ErrorSummary::default() },
        notes,
        ..Identification::default()
    }
}

/// The law's parameters by the names of the contract: `mu_s` instead of its rise over `mu_k`, and no bristle where the
/// law has none.
fn published(joint: &Joint) -> Vec<IdentifiedParameter> {
    let unknowns = &joint.fitted.unknowns;
    let place = |hook: Hook| unknowns.iter().position(|u| u.quantity == Quantity::Law(hook));
    let described: Vec<Parameter> = unknowns.iter().map(|u| u.parameter.clone()).collect();
    unknowns
        .iter()
        .zip(&joint.identified.parameters)
        .filter_map(|(unknown, parameter)| match unknown.quantity {
            Quantity::Law(Hook::Sigma0) if joint.family.is_static() => None,
            Quantity::Law(Hook::StribeckRise) => {
                let both = (place(Hook::MuKinetic)?, place(Hook::StribeckRise)?);
                let sum = joint.identified.sum(both, &described, IdentifySettings::default().widest);
                Some(IdentifiedParameter { name: "mu_s".to_owned(), ..sum })
            }
            Quantity::Law(_) => Some(parameter.clone()),
            _ => None,
        })
        .collect()
}

fn structure(joint: &Joint) -> Structure {
    let find = |quantity: Quantity| -> Option<Estimate> {
        let place = joint.fitted.unknowns.iter().position(|u| u.quantity == quantity)?;
        Some(estimate(&joint.identified.parameters[place]))
    };
    let modes = (0..joint.fitted.setting.frequency.len()).filter_map(|n| {
        let frequency = hertz(find(Quantity::ModeFrequency(n))?);
        Some(ModeEstimate { frequency, damping_ratio: find(Quantity::ModeDamping(n))? })
    });
    Structure { modes: modes.collect() }
}

fn hertz(mut value: Estimate) -> Estimate {
    let turn = std::f64::consts::TAU;
    value.value /= turn;
    value.std /= turn;
    value.interval95 = value.interval95.map(|end| end / turn);
    "Hz".clone_into(&mut value.unit);
    value
}
