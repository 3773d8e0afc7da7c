//! A contact record: what the declared law lacks, told by motion and force of the contact itself.

mod figures;
mod maps;
#[cfg(test)]
mod tests;

use super::{ExplainOptions, place, verdict};
use crate::identify::contact_record::{PARTS, SEED, held_out, in_newtons, published, raw};
use crate::identify::estimates::estimate;
use crate::results::{
    BeforeAfter, Candidate, Effect, ErrorSummary, Estimate, Explanation, HeldOut, Identification,
    NoiseFloorSource, Provenance, Verdict,
};
use crate::{Progress, StudyError};
use frettrace_explain::records_explain::{
    MovingMass, RecordCase, RecordEffect, RecordFit, RecordOutcome, RecordRun, explain_record,
};
use frettrace_identify::contact::{Family, FloorSource, PreparedRun};
use frettrace_measurement::{ContactRecord, SlipUnit};
use rayon::prelude::*;
use std::collections::BTreeMap;

/// Fewer samples hold no stroke.
const LEAST_SAMPLES: usize = 8;

/// Held-out runs within this factor of their floor are as good as explained: what scatter of the values may add.
const ACCEPTED: f64 = 1.2;

/// A record as the explanation needs it, with the names of its parts.
struct Parts {
    case: RecordCase,
    training: Vec<Part>,
    held_out: Vec<Part>,
}

/// Where a part comes from.
struct Part {
    id: String,
    label: String,
}

/// Explains a contact record.
pub(super) fn explain(
    record: &ContactRecord,
    options: &ExplainOptions,
    progress: &Progress,
) -> Result<Explanation, StudyError> {
    progress.start(2, "motion");
    let parts = parts(record, options)?;
    progress.step();
    let outcome = explain_record(&parts.case)?;
    progress.finish();
    Ok(Explanation {
        exhibits: figures::exhibits(record, &parts, &outcome),
        ..explanation(record, options, (&parts, &outcome))
    })
}

fn parts(record: &ContactRecord, options: &ExplainOptions) -> Result<Parts, StudyError> {
    let Some(law) = Family::named(&record.law) else {
        return Err(StudyError::UnknownLaw { name: record.law.clone() });
    };
    let newtons = in_newtons(record);
    let runs = record.runs.par_iter().enumerate();
    let prepared: Vec<PreparedRun> =
        runs.map(|(k, run)| PreparedRun::new(&raw(run, newtons), SEED + k as u64)).collect();
    let held = held_out(&prepared);
    let by_cycles = held.iter().all(|held| !held);
    let mass = match record.moving_mass {
        None => MovingMass::None,
        Some(mass) if mass.is_finite() => MovingMass::Known(mass),
        Some(_) => MovingMass::Wanted,
    };
    let mut parts = Parts {
        case: RecordCase {
            law,
            training: Vec::new(),
            held_out: Vec::new(),
            mass,
            without: options.without.clone(),
        },
        training: Vec::new(),
        held_out: Vec::new(),
    };
    for (k, (run, given)) in prepared.iter().zip(&record.runs).enumerate() {
        let samples = run.history.len();
        let (fitted, kept) = match (by_cycles, held[k]) {
            (true, _) => run.split(),
            (false, true) => (0..0, 0..samples),
            (false, false) => (0..samples, 0..0),
        };
        let place = |sample: usize| (k as f64 + sample as f64 / samples as f64) / prepared.len() as f64;
        for (side, range) in [fitted, kept].into_iter().enumerate() {
            if range.len() < LEAST_SAMPLES {
                continue;
            }
            let part = RecordRun {
                history: run.part(range.clone()),
                progress: [place(range.start), place(range.end)],
                stated: given.force_noise_std,
            };
            let id = if by_cycles { format!("{} ({})", given.id, PARTS[side]) } else { given.id.clone() };
            let (runs, names) = if side == 0 {
                (&mut parts.case.training, &mut parts.training)
            } else {
                (&mut parts.case.held_out, &mut parts.held_out)
            };
            runs.push(part);
            names.push(Part { id, label: given.label.clone() });
        }
    }
    let moves = |run: &RecordRun| run.history.amplitude() > 0.0;
    if parts.case.training.iter().any(moves) {
        Ok(parts)
    } else {
        Err(StudyError::NoStroke { least: LEAST_SAMPLES })
    }
}

fn explanation(
    record: &ContactRecord,
    options: &ExplainOptions,
    (parts, outcome): (&Parts, &RecordOutcome),
) -> Explanation {
    let names = |parts: &[Part]| parts.iter().map(|part| part.id.clone()).collect::<Vec<_>>();
    let error = errors(&parts.case.training, (outcome, 0), names(&parts.training));
    let kept = errors(&parts.case.held_out, (outcome, 1), names(&parts.held_out));
    let held_out = Some(kept).filter(|_| !parts.held_out.is_empty());
    let provenance = Provenance {
        version: env!("CARGO_PKG_VERSION").to_owned(),
        seed: options.seed,
        training_runs: names(&parts.training),
    };
    let side = |fit: &RecordFit, pick: fn(&BeforeAfter) -> f64| Identification {
        law: record.law.clone(),
        parameters: parameters(record, fit),
        error: summary(&error, pick),
        held_out: held_out
            .as_ref()
            .map(|kept| HeldOut { error: summary(kept, pick), runs: kept.runs.clone() }),
        provenance: provenance.clone(),
        ..Identification::default()
    };
    Explanation {
        verdict: verdict(outcome.verdict),
        effects: outcome.effects.iter().map(|found| effect(record, outcome, found)).collect(),
        place: outcome.place.map(place),
        candidates: outcome
            .tried
            .iter()
            .map(|t| Candidate { id: t.id.to_owned(), error: t.error, evidence: t.evidence })
            .collect(),
        baseline: side(&outcome.baseline, |error| error.before),
        model: side(&outcome.model, |error| error.after),
        provenance: provenance.clone(),
        notes: notes(record, outcome, (&error, held_out.as_ref())),
        error: error.clone(),
        held_out: held_out.clone(),
        ..Explanation::default()
    }
}

/// Relative RMS of measured minus predicted force over the samples that count.
fn errors(runs: &[RecordRun], (outcome, side): (&RecordOutcome, usize), names: Vec<String>) -> BeforeAfter {
    let [before, after] =
        [&outcome.baseline, &outcome.model].map(|fit| if side == 0 { &fit.training } else { &fit.held_out });
    let size = quadratic(runs.iter().zip(before).flat_map(|(run, residual)| {
        let force = &run.history.force;
        force[force.len() - residual.len()..].iter()
    }));
    let relative = |value: f64| value / size.max(f64::MIN_POSITIVE);
    BeforeAfter {
        before: relative(quadratic(before.iter().flatten())),
        after: relative(quadratic(after.iter().flatten())),
        noise_floor: relative(outcome.floor[side]),
        noise_floor_source: source(outcome.source),
        runs: names,
    }
}

fn quadratic<'a>(values: impl Iterator<Item = &'a f64>) -> f64 {
    let (sum, count) = values.fold((0.0, 0.0), |(sum, count), x| (sum + x * x, count + 1.0));
    (sum / f64::max(count, 1.0)).sqrt()
}

fn source(found: FloorSource) -> NoiseFloorSource {
    match found {
        FloorSource::Given => NoiseFloorSource::Given,
        FloorSource::Repeats => NoiseFloorSource::Repeats,
        FloorSource::Estimated => NoiseFloorSource::Estimated,
    }
}

fn summary(error: &BeforeAfter, pick: fn(&BeforeAfter) -> f64) -> ErrorSummary {
    ErrorSummary {
        force: Some(pick(error)),
        acceleration: None,
        noise_floor: error.noise_floor,
        noise_floor_source: error.noise_floor_source,
    }
}

/// All values of a fit, under the names and units of the record.
fn parameters(record: &ContactRecord, fit: &RecordFit) -> BTreeMap<String, Estimate> {
    let naming = (in_newtons(record), record.slip_unit);
    let values = fit.setting.unknowns.iter().enumerate().map(|(k, unknown)| {
        let judged = fit.identified.as_ref().and_then(|identified| identified.parameters.get(k));
        let (name, unit) = named(&unknown.parameter.name, &unknown.parameter.unit, naming);
        let open = Estimate {
            value: unknown.value,
            std: f64::INFINITY,
            interval95: [f64::NEG_INFINITY, f64::INFINITY],
            unit: String::new(),
            identifiable: false,
        };
        (name, Estimate { unit, ..judged.map_or(open, estimate) })
    });
    values.collect()
}

fn named(name: &str, unit: &str, naming: (bool, SlipUnit)) -> (String, String) {
    match (name, naming.0) {
        ("mu_rise", true) => ("friction_rise".to_owned(), "N".to_owned()),
        _ => published(name, unit, naming),
    }
}

fn effect(record: &ContactRecord, outcome: &RecordOutcome, found: &RecordEffect) -> Effect {
    let naming = (in_newtons(record), record.slip_unit);
    let all = parameters(record, &outcome.model);
    let names = found.unknowns.iter().map(|u| named(&u.parameter.name, &u.parameter.unit, naming).0);
    Effect {
        id: found.id.to_owned(),
        probability: found.probability,
        position_m: None,
        sensor: None,
        parameters: names.filter_map(|name| Some((name.clone(), all.get(&name)?.clone()))).collect(),
        indistinguishable_from: found.indistinguishable.iter().map(|id| (*id).to_owned()).collect(),
        separating_experiment: Some(found.experiment.to_owned()),
    }
}

/// What a reader must know.
fn notes(
    record: &ContactRecord,
    outcome: &RecordOutcome,
    (error, held_out): (&BeforeAfter, Option<&BeforeAfter>),
) -> Vec<String> {
    let mut notes = outcome.notes.clone();
    if in_newtons(record) {
        notes.push("the normal force is not known: friction levels and stiffness are in newtons".to_owned());
    }
    if outcome.source == FloorSource::Estimated {
        notes.push(
            "nothing repeats and no noise is stated: the floor is the scatter of neighbouring samples, a low one"
                .to_owned(),
        );
    }
    if let Some(kept) = held_out.filter(|_| verdict(outcome.verdict) != Verdict::Unexplained) {
        let times = kept.after / kept.noise_floor.max(f64::MIN_POSITIVE);
        if times > ACCEPTED {
            notes.push(format!(
                "fitted runs are explained to their floor, held-out ones only to {times:.1} times theirs: the law's \
                 values do not carry over wholly"
            ));
        }
    }
    if verdict(outcome.verdict) == Verdict::Unexplained {
        let times = error.after / error.noise_floor.max(f64::MIN_POSITIVE);
        let follows: Vec<String> =
            outcome.follows.iter().map(|f| format!("{} {:.2}", f.input, f.share)).collect();
        notes.push(format!(
            "the verdict stays open: {times:.1} times the floor is left; share of that which follows an input \
             linearly: {}",
            follows.join(", ")
        ));
    }
    notes
}
