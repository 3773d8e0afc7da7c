//! What the declared model lacks: the wiring of an explanation.

mod aperiodic;
mod contact_record;
mod open_runs;

use crate::results::{
    BeforeAfter, Candidate, Control, Effect, ErrorSummary, Estimate, Explanation, HeldOut, Identification,
    ModeEstimate, NoiseFloorSource, Place, Provenance, Question, Structure, Verdict,
};
use crate::{Progress, StudyError, case};
use frettrace_explain::{Case, Explained, Named, Outcome, RunError, Tried};
use frettrace_forward::accelerations::Quantity;
use frettrace_identify::HALF_INTERVAL95;
use frettrace_inverse::RunReconstruction;
use frettrace_measurement::{MeasuredModes, Measurement, Recording};
use std::collections::BTreeMap;

/// How to explain.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct ExplainOptions {
    /// Seed of every random draw.
    pub seed: u64,
    /// Ids of effects that are not looked for: known to be absent, or left out to see what takes their place.
    pub without: Vec<String>,
    /// Surrogates to be explained as a control, beside the other controls; none where this is 0.
    pub controls: usize,
}

/// Explains a recording.
///
/// # Errors
/// [`StudyError`] where lines cannot be found or the model cannot be evaluated at all.
pub fn explain(
    recording: &Recording,
    options: &ExplainOptions,
    progress: &Progress,
) -> Result<Explanation, StudyError> {
    let measurement = match recording {
        Recording::Measurement(measurement) => measurement,
        Recording::Contact(_) if options.controls > 0 => return Err(StudyError::ControlsOfRecord),
        Recording::Contact(record) => return contact_record::explain(record, options, progress),
    };
    progress.start(if options.controls > 0 { 3 } else { 2 }, "lines");
    let mut case = case::case(measurement)?;
    case.without.clone_from(&options.without);
    let declared = case.modes.clone();
    let mut recovered = case::recover_aperiodic(&mut case, measurement)?;
    progress.step();
    if case::is_told_by_contacts(&case) {
        return aperiodic::explain(measurement, options, (&case, &declared, &recovered), progress);
    }
    let mut outcome = frettrace_explain::explain(&case)?;
    if let Some(beside) = beside_unanswered(measurement, &case, &outcome) {
        (case, recovered, outcome) = beside;
    }
    let shown = frettrace_explain::exhibits(&case, &outcome)?;
    progress.step();
    let controls = if options.controls > 0 {
        frettrace_explain::controls(&case, &outcome, options.controls, options.seed)?
    } else {
        Vec::new()
    };
    // Controls draw periodic runs: they ask for what these say.
    open_runs::ask(measurement, (&case, &recovered), &mut outcome)?;
    progress.finish();
    let exhibits = crate::exhibits::exhibits(measurement, &shown, &outcome.runs[1]);
    let controls = controls.iter().map(control).collect();
    Ok(Explanation { exhibits, controls, ..explanation(measurement, options, &outcome) })
}

/// The same where the contact lacks something without a name and the declared law comes to another motion than was measured in some runs, which
/// then bend it: a contact that sticks and slips snaps faster than any line that a balance can have, however well its accelerations repeat. Those
/// runs enter as the ones without a period do, by the force and slip recovered of them, while enough others are left to be predicted; `None` where
/// something is missing then, too, or nothing can be said: what was found stands.
fn beside_unanswered(
    measurement: &Measurement,
    case: &Case,
    outcome: &Outcome,
) -> Option<(Case, Vec<RunReconstruction>, Outcome)> {
    if outcome.unanswered.is_empty() {
        return None;
    }
    let mut case = case.clone();
    outcome.unanswered.iter().for_each(|&run| case.records[run].periodic = false);
    if case::is_told_by_contacts(&case) {
        return None;
    }
    let recovered = case::recover_aperiodic(&mut case, measurement).ok()?;
    let mut found = frettrace_explain::explain(&case).ok()?;
    // A name would stand on what the runs that tell most of it were not asked.
    if found.verdict != frettrace_explain::Verdict::NothingMissing {
        return None;
    }
    let ids: Vec<&str> = outcome.unanswered.iter().map(|&run| measurement.runs[run].id.as_str()).collect();
    found.notes.push(format!(
        "no balance of the declared law comes to the motion in runs {}: they count among those without a period",
        ids.join(", ")
    ));
    Some((case, recovered, found))
}

fn control(asked: &frettrace_explain::Control) -> Control {
    let (question, share) = match asked.question {
        frettrace_explain::Question::Surrogate => (Question::Surrogate, None),
        frettrace_explain::Question::LeftOut => (Question::LeftOut, None),
        frettrace_explain::Question::Injection(share) => (Question::Injection, Some(share)),
    };
    Control {
        question,
        share,
        verdict: verdict(asked.verdict),
        named: asked.named.iter().map(|id| (*id).to_owned()).collect(),
        place: asked.place.map(place),
        right: asked.right,
    }
}

/// What both ways of explaining find, as far as it is told alike.
struct Found<'a> {
    verdict: frettrace_explain::Verdict,
    effects: &'a [Named],
    place: Option<frettrace_explain::Place>,
    error: &'a [RunError; 2],
    held_out: Option<&'a [RunError; 2]>,
    runs: &'a [Vec<usize>; 2],
    tried: &'a [Tried],
    notes: &'a [String],
}

impl Found<'_> {
    /// The explanation with the identifications of the declared model and of the one with effects, to which errors and provenance
    /// are put.
    fn explanation(
        &self,
        (measurement, options): (&Measurement, &ExplainOptions),
        summary: fn(&RunError, NoiseFloorSource) -> ErrorSummary,
        sides: [Identification; 2],
    ) -> Explanation {
        let names = |runs: &[usize]| runs.iter().map(|&k| measurement.runs[k].id.clone()).collect::<Vec<_>>();
        let [training, held_out] = self.runs;
        let source = floor_source(measurement);
        let errors = |[before, after]: &[RunError; 2], runs: &[usize]| BeforeAfter {
            before: before.relative(),
            after: after.relative(),
            noise_floor: after.relative_floor(),
            noise_floor_source: source,
            runs: names(runs),
        };
        let provenance = Provenance {
            version: env!("CARGO_PKG_VERSION").to_owned(),
            seed: options.seed,
            training_runs: names(training),
        };
        let judged = |side: Identification, k: usize| Identification {
            error: summary(&self.error[k], source),
            held_out: self
                .held_out
                .map(|errors| HeldOut { error: summary(&errors[k], source), runs: names(held_out) }),
            provenance: provenance.clone(),
            ..side
        };
        let [baseline, model] = sides;
        let candidate = |tried: &Tried| Candidate {
            id: tried.id.to_owned(),
            error: tried.error,
            evidence: tried.evidence,
        };
        Explanation {
            verdict: verdict(self.verdict),
            effects: self.effects.iter().map(effect).collect(),
            place: self.place.map(place),
            error: errors(self.error, training),
            held_out: self.held_out.map(|found| errors(found, held_out)),
            candidates: self.tried.iter().map(candidate).collect(),
            baseline: judged(baseline, 0),
            model: judged(model, 1),
            notes: self.notes.to_vec(),
            provenance,
            ..Explanation::default()
        }
    }
}

fn explanation(measurement: &Measurement, options: &ExplainOptions, outcome: &Outcome) -> Explanation {
    let mut notes = outcome.notes.clone();
    if !outcome.aside.is_empty() {
        let aside: Vec<&str> = outcome.aside.iter().map(|&run| measurement.runs[run].id.as_str()).collect();
        notes.push(format!(
            "runs {} are neither fitted nor held out: no balance keeps to the motion of the beam there",
            aside.join(", ")
        ));
    }
    let found = Found {
        verdict: outcome.verdict,
        effects: &outcome.effects,
        place: outcome.place,
        error: &outcome.error,
        held_out: outcome.held_out.as_ref(),
        runs: &outcome.runs,
        tried: &outcome.tried,
        notes: &notes,
    };
    let law = &measurement.support.law;
    let sides = [&outcome.baseline, &outcome.model].map(|model| identification(measurement, law, model));
    found.explanation((measurement, options), summary, sides)
}

fn floor_source(measurement: &Measurement) -> NoiseFloorSource {
    if measurement.sensors.noise_std.is_some() {
        NoiseFloorSource::Given
    } else {
        NoiseFloorSource::Estimated
    }
}

fn summary(error: &RunError, source: NoiseFloorSource) -> ErrorSummary {
    ErrorSummary {
        force: None,
        acceleration: Some(error.relative()),
        noise_floor: error.relative_floor(),
        noise_floor_source: source,
    }
}

fn verdict(found: frettrace_explain::Verdict) -> Verdict {
    match found {
        frettrace_explain::Verdict::NothingMissing => Verdict::NothingMissing,
        frettrace_explain::Verdict::Explained => Verdict::Explained,
        frettrace_explain::Verdict::Unexplained => Verdict::Unexplained,
    }
}

fn place(found: frettrace_explain::Place) -> Place {
    match found {
        frettrace_explain::Place::Contact => Place::Contact,
        frettrace_explain::Place::Structure => Place::Structure,
        frettrace_explain::Place::Excitation => Place::Excitation,
        frettrace_explain::Place::Measurement => Place::Measurement,
    }
}

fn effect(named: &frettrace_explain::Named) -> Effect {
    Effect {
        id: named.id.to_owned(),
        probability: named.probability,
        position_m: named.position,
        sensor: named.sensor,
        parameters: estimates(&named.parameters),
        indistinguishable_from: named.indistinguishable.iter().map(|id| (*id).to_owned()).collect(),
        separating_experiment: Some(named.experiment.to_owned()),
    }
}

/// Values by their names: name, unit, value, standard deviation.
fn estimates(values: &[(String, String, f64, f64)]) -> BTreeMap<String, Estimate> {
    values.iter().map(|(name, unit, value, std)| (name.clone(), estimate(*value, *std, unit))).collect()
}

fn estimate(value: f64, std: f64, unit: &str) -> Estimate {
    let known = std.is_finite();
    let reach = if known { HALF_INTERVAL95 * std } else { f64::INFINITY };
    Estimate {
        value,
        std: if known { std } else { f64::INFINITY },
        interval95: [value - reach, value + reach],
        unit: unit.to_owned(),
        identifiable: known && std < 0.5 * value.abs(),
    }
}

fn identification(measurement: &Measurement, law: &str, model: &Explained) -> Identification {
    let mut parameters = BTreeMap::new();
    let mut structure = Structure::default();
    let setting = &model.fitted.setting;
    for unknown in &model.fitted.unknowns {
        let Some(value) = setting.get(unknown.quantity) else { continue };
        let modal = matches!(unknown.quantity, Quantity::ModeFrequency(_) | Quantity::ModeDamping(_));
        if !modal {
            let std = model.deviation(unknown.quantity);
            let found = estimate(value, std, &unknown.parameter.unit);
            parameters.insert(unknown.parameter.name.clone(), found);
        }
    }
    // A mode that was not fitted is as uncertain as it was declared.
    let declared = |std: fn(&MeasuredModes) -> &Vec<f64>, mode: usize| {
        measurement.modes.as_ref().and_then(|modes| std(modes).get(mode).copied()).unwrap_or(f64::NAN)
    };
    let known = |fitted: f64, declared: f64| if fitted.is_finite() { fitted } else { declared };
    for (mode, (&frequency, &damping)) in setting.frequency.iter().zip(&setting.damping).enumerate() {
        let tau = std::f64::consts::TAU;
        let scaled = |own: Quantity, value: f64, scale: Quantity| {
            let by_all = value * model.deviation(scale);
            let own = model.deviation(own);
            let std = if by_all.is_finite() { own.hypot(by_all) } else { own };
            (value * (1.0 + setting.get(scale).unwrap_or_default()), std)
        };
        let (frequency, frequency_std) =
            scaled(Quantity::ModeFrequency(mode), frequency, Quantity::FrequencyScale);
        let (frequency, frequency_std) = (frequency / tau, frequency_std / tau);
        let (damping, damping_std) = scaled(Quantity::ModeDamping(mode), damping, Quantity::DampingScale);
        structure.modes.push(ModeEstimate {
            frequency: estimate(
                frequency,
                known(frequency_std, declared(|modes| &modes.frequency_std, mode)),
                "Hz",
            ),
            damping_ratio: estimate(
                damping,
                known(damping_std, declared(|modes| &modes.damping_ratio_std, mode)),
                "1",
            ),
        });
    }
    Identification { law: law.to_owned(), parameters, structure, ..Identification::default() }
}
