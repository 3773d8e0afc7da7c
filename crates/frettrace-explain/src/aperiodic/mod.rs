//! Runs without a period: what the declared model lacks, told by the contact that was recovered of them.
//!
//! No waveform is predicted, and no such run is forced into lines. The inverse recovers force, slip, velocity and normal force of the contact
//! over the whole spectrum, without a law, and says what it leaves open ([`WholeRun`]). Two questions are asked, one after the other:
//!
//! 1. *Does the balance close without a law?* χ² per degree of freedom of what no contact force explains. Where it does not, the contact is
//!    not asked: structure, excitation or measurement are at fault (`balance.rs`).
//! 2. *Does the declared law answer the recovered motion with the recovered force?* It is fitted to the training runs, effects are tried inside
//!    it, and runs that nothing was fitted to decide (`search.rs`).

mod balance;
mod exhibit;
mod faults;
mod modes;
mod motion;
mod problem;
mod run;
mod search;
#[cfg(test)]
mod tests;
mod tone;
mod wave;

pub use exhibit::WholeExhibit;
pub use faults::with_faults;
pub use modes::beside_declared;
pub use motion::{Motion, WholeRun};
pub use tone::{BaseTone, ToneMotion, base_tone};

use crate::effects::{ALL, EffectPlace, listed};
use crate::split::by_level;
use crate::start;
use crate::verdict::{EVIDENCE, Named, SERIES_OPEN, Tried, Verdict};
use crate::{Case, ExplainError, RunError, RunSamples, Scales, Split, slip_receptance};
use frettrace_friction::effects::ModifiedLaw;
use frettrace_identify::contact::{Closure, ContactHistory};
use num_complex::Complex64;
use run::OpenRun;
use search::{Fitted, Judged, Search};
use std::sync::Arc;

/// Name, unit, value and standard deviation.
pub type Value = (String, String, f64, f64);

/// What the errors of an outcome are errors of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ErrorOf {
    /// The recovered contact force, against the law's answer to the recovered motion.
    Force,
    /// The accelerations, as the balance has them.
    Accelerations,
}

/// What came of an explanation of runs without a period.
#[derive(Clone, Debug)]
pub struct WholeOutcome {
    /// The verdict.
    pub verdict: Verdict,
    /// Named effects.
    pub effects: Vec<Named>,
    /// Where something is missing.
    pub place: Option<EffectPlace>,
    /// Values of the declared law, and of the law with the effects in it.
    pub laws: [Vec<Value>; 2],
    /// All candidates, best first.
    pub tried: Vec<Tried>,
    /// Errors of the training runs, before and after.
    pub error: [RunError; 2],
    /// The same of the held-out runs.
    pub held_out: Option<[RunError; 2]>,
    /// What both are errors of.
    pub error_of: ErrorOf,
    /// Indices of the training and of the held-out runs.
    pub runs: [Vec<usize>; 2],
    /// What is drawn of each run that a law was asked of.
    pub exhibits: Vec<WholeExhibit>,
    /// What a reader must know.
    pub notes: Vec<String>,
}

/// Relative error from which a law takes less than half of the power of the recovered forces: what those hold is not the contact's.
const DROWNED: f64 = std::f64::consts::FRAC_1_SQRT_2;
/// Samples of a record that the first values of the law are read from.
const HISTORY: usize = 1024;

/// Explains a case of which no run is periodic; `whole` holds what was recovered of each run.
///
/// # Errors
/// [`ExplainError`] where no contact was recovered or the rig cannot be modelled.
pub fn explain_whole(
    case: &Case,
    samples: &[RunSamples<'_>],
    whole: &[Option<WholeRun>],
) -> Result<WholeOutcome, ExplainError> {
    let recovered: Vec<(usize, &WholeRun)> =
        whole.iter().enumerate().filter_map(|(k, run)| Some((k, run.as_ref()?))).collect();
    if recovered.is_empty() {
        return Err(ExplainError::NothingRecovered { runs: case.records.len() });
    }
    let runs: Vec<&WholeRun> = recovered.iter().map(|run| run.1).collect();
    if !balance::closed(&runs) {
        return Ok(open(case, balance::open(case, samples, &recovered)?, &recovered));
    }
    let mut search = prepared(case, whole)?;
    let histories: Vec<ContactHistory> = search.training.iter().map(history).collect();
    search.scales = start::scales(case, &histories);
    let law = start::law(case.law, &histories);
    let unknown = || ExplainError::NothingRecovered { runs: case.records.len() };
    search.sight = Some(law);
    search.turn(&law);
    let first = search.declared(law).ok_or_else(unknown)?;
    search.settle_on(&first);
    let baseline = search.further(&first).ok_or_else(unknown)?;
    let model = search.extended(&baseline);
    if [&baseline, &model].iter().all(|fitted| of_training(&search, fitted).relative() > DROWNED) {
        return Err(ExplainError::ContactDrowned { runs: case.records.len() });
    }
    Ok(outcome(search, (baseline, model)))
}

/// Where the balance of some runs without a period, by their indices, is open, and what shows it.
///
/// # Errors
/// [`ExplainError::Model`] where the rig cannot be modelled.
pub fn open_place(
    case: &Case,
    samples: &[RunSamples<'_>],
    runs: &[(usize, WholeRun)],
) -> Result<(EffectPlace, String), ExplainError> {
    let part = Case { records: runs.iter().map(|(k, _)| case.records[*k].clone()).collect(), ..case.clone() };
    let samples: Vec<RunSamples<'_>> = runs.iter().map(|(k, _)| samples[*k]).collect();
    let own: Vec<(usize, &WholeRun)> = runs.iter().map(|(_, run)| run).enumerate().collect();
    let found = balance::open(&part, &samples, &own)?;
    Ok((found.place, found.why))
}

/// An outcome beside a motion of the base that was told before: it is named where the rest is explained, and is the place of what is missing in any
/// case. Errors are those of the accelerations then, as the balance has them without and with it.
#[must_use]
pub fn with_base_motion(
    case: &Case,
    (tone, balances): (&BaseTone, [&[Option<WholeRun>]; 2]),
    mut outcome: WholeOutcome,
) -> WholeOutcome {
    let Some(effect) = listed("excitation.base-motion").map(|effect| ALL[effect]) else {
        return outcome;
    };
    let sizes: Vec<f64> = tone.runs.iter().map(|run| run.base.norm()).collect();
    let mean = sizes.iter().sum::<f64>() / sizes.len().max(1) as f64;
    let scatter = sizes.iter().map(|size| (size - mean).powi(2)).sum::<f64>() / sizes.len().max(1) as f64;
    let hertz = tone.omega / std::f64::consts::TAU;
    let [without, with] = tone.reduced;
    outcome.notes.insert(0, format!(
        "all runs share a motion of the base of {hertz:.4} Hz and {mean:.3} m/s² beside the excitation: with it the balance of its line closes (χ² per degree of freedom {with:.2}, {without:.0} without)"
    ));
    outcome.place = Some(EffectPlace::Excitation);
    outcome.tried.insert(0, Tried { id: effect.id(), error: f64::NAN, evidence: f64::INFINITY });
    if outcome.verdict == Verdict::Unexplained {
        return outcome;
    }
    outcome.verdict = Verdict::Explained;
    outcome.effects.insert(
        0,
        Named {
            id: effect.id(),
            probability: 1.0,
            position: None,
            sensor: None,
            parameters: vec![
                ("base_frequency".into(), "Hz".into(), hertz, f64::NAN),
                ("base_acceleration".into(), "m/s^2".into(), mean, scatter.sqrt()),
            ],
            indistinguishable: Vec::new(),
            experiment: effect.experiment(),
        },
    );
    outcome.of_balances(case, balances);
    outcome
}

impl WholeOutcome {
    /// Errors of the accelerations, as the balances of the runs have them before and after.
    fn of_balances(&mut self, case: &Case, balances: [&[Option<WholeRun>]; 2]) {
        let of = |runs: &[usize]| {
            balances.map(|of| sum(runs.iter().filter_map(|&k| Some(of_balance(case, k, of[k].as_ref()?)))))
        };
        self.error = of(&self.runs[0]);
        self.held_out = self.held_out.map(|_| of(&self.runs[1]));
        self.error_of = ErrorOf::Accelerations;
    }

    /// Something is missing there that has no name.
    fn left_open(&mut self, place: EffectPlace, note: String) {
        self.verdict = Verdict::Unexplained;
        self.effects.clear();
        self.place = Some(place);
        self.notes.push(note);
    }
}

/// Error, floor and power of the accelerations of a run, as its balance has them.
fn of_balance(case: &Case, index: usize, run: &WholeRun) -> [f64; 3] {
    let record = &case.records[index];
    let noise: f64 = record.noise.iter().map(|n| n * n).sum();
    [noise * run.reduced(), noise, record.power.iter().sum::<f64>()]
}

/// The recovered runs ready for comparison, training and held-out ones.
fn prepared<'a>(case: &'a Case, whole: &[Option<WholeRun>]) -> Result<Search<'a>, ExplainError> {
    let mut runs: Vec<OpenRun> = Vec::new();
    let mut gains: Vec<(f64, usize, Arc<Vec<Complex64>>)> = Vec::new();
    for (index, whole) in whole.iter().enumerate() {
        let Some(whole) = whole else { continue };
        let samples = whole.found.force.len();
        let known =
            gains.iter().find(|(dt, n, _)| *dt == whole.dt && *n == samples).map(|known| known.2.clone());
        let gain = match known {
            Some(gain) => gain,
            None => {
                let gain = Arc::new(receptance(case, whole)?);
                gains.push((whole.dt, samples, gain.clone()));
                gain
            }
        };
        let record = &case.records[index];
        let circumstance = record.lines.circumstance();
        let excitation = record.lines.omega * record.subharmonic as f64;
        let run = OpenRun::new(
            index,
            (Arc::new(whole.clone()), gain),
            (circumstance, case.law.is_static(), excitation),
        );
        runs.extend(run);
    }
    if runs.is_empty() {
        return Err(ExplainError::NothingRecovered { runs: case.records.len() });
    }
    let recovered: Vec<usize> = runs.iter().map(|run| run.index).collect();
    let held = Split::First.held_out(&by_level(case, &recovered));
    let (held_out, training) = runs.into_iter().partition(|run| held.contains(&run.index));
    Ok(Search {
        case,
        scales: Scales::default(),
        training,
        held_out,
        sight: None,
        tried: Vec::new(),
        notes: Vec::new(),
    })
}

/// Slip (m/N) that a unit of contact force takes, in every bin of a record.
fn receptance(case: &Case, whole: &WholeRun) -> Result<Vec<Complex64>, ExplainError> {
    let bins = whole.own.len();
    let omega = std::f64::consts::TAU / (whole.dt * whole.found.force.len() as f64);
    let setting = case.setting(ModifiedLaw::dahl(1.0, 1.0));
    let mut gain = slip_receptance(case, &setting, (omega, bins))?;
    gain.resize(bins, Complex64::ZERO);
    // No accelerometer sees the mean.
    gain[0] = Complex64::ZERO;
    Ok(gain)
}

/// The last samples of a run as a history with a beginning and an end, its drift taken for none.
fn history(run: &OpenRun) -> ContactHistory {
    let motion = run.quiet();
    let samples = motion.force.len();
    let from = samples.saturating_sub(HISTORY);
    let peak = motion.force.iter().fold(0.0_f64, |m, f| f.abs().max(m));
    ContactHistory {
        label: format!("run {}", run.index + 1),
        time: (0..samples - from).map(|k| k as f64 * run.whole.dt).collect(),
        slip: motion.slip[from..].to_vec(),
        velocity: motion.velocity[from..].to_vec(),
        acceleration: None,
        normal: motion.normal[from..].to_vec(),
        force: motion.force[from..].to_vec(),
        closure: Closure::Open,
        mean_is_seen: false,
        force_std: (0.02 * peak).max(1e-12),
        draws: Vec::new(),
        first: (samples - from) / 10,
    }
}

/// The outcome where the balance is open: no law was asked. The error is that of the accelerations, as the balance has it.
fn open(case: &Case, found: balance::Open, recovered: &[(usize, &WholeRun)]) -> WholeOutcome {
    let error = sum(recovered.iter().map(|(index, run)| of_balance(case, *index, run)));
    WholeOutcome {
        verdict: Verdict::Unexplained,
        effects: Vec::new(),
        place: Some(found.place),
        laws: Default::default(),
        tried: Vec::new(),
        error: [error; 2],
        error_of: ErrorOf::Accelerations,
        held_out: None,
        runs: [recovered.iter().map(|run| run.0).collect(), Vec::new()],
        exhibits: Vec::new(),
        notes: vec![found.note()],
    }
}

fn outcome(mut search: Search<'_>, (baseline, model): (Fitted, Fitted)) -> WholeOutcome {
    let judged = [&baseline, &model].map(|fitted| search.judged(fitted));
    let sufficient = search.sufficient((&baseline, &model), [&judged[0], &judged[1]]);
    let complete = sufficient || search.complete(&model) && search.foretold(&judged[1]);
    let error = [&baseline, &model].map(|fitted| of_training(&search, fitted));
    let held =
        [(&baseline, &judged[0]), (&model, &judged[1])].map(|(fitted, judged)| of_held_out(fitted, judged));
    let slight = |errors: &RunError| errors.power == 0.0 || errors.relative() < SERIES_OPEN;
    // What nothing explains is not worth a doubt while it is no more than the method may leave.
    let within = model.effects.is_empty() && slight(&error[0]) && slight(&held[0]);
    let verdict = match (complete, model.effects.is_empty()) {
        (true, false) => Verdict::Explained,
        (true, true) => Verdict::NothingMissing,
        (false, _) if within => Verdict::NothingMissing,
        (false, _) => Verdict::Unexplained,
    };
    let place = match verdict {
        Verdict::NothingMissing => None,
        Verdict::Explained => model.effects.first().map(|&effect| ALL[effect].place()),
        Verdict::Unexplained => Some(EffectPlace::Contact),
    };
    let effects = if verdict == Verdict::Explained { named(&search, &model) } else { Vec::new() };
    let model = if verdict == Verdict::Explained { model } else { baseline.clone() };
    let after = usize::from(verdict == Verdict::Explained);
    search.remark(complete, verdict, &error[after]);
    search.tried.sort_by(|a, b| b.1.total_cmp(&a.1));
    WholeOutcome {
        verdict,
        effects,
        place,
        laws: [&baseline, &model].map(|fitted| search.values(fitted)),
        tried: search
            .tried
            .iter()
            .map(|&(effect, evidence)| Tried { id: ALL[effect].id(), error: f64::NAN, evidence })
            .collect(),
        error: [error[0], error[after]],
        error_of: ErrorOf::Force,
        held_out: (!search.held_out.is_empty()).then(|| [held[0], held[after]]),
        runs: [&search.training, &search.held_out].map(|runs| runs.iter().map(|run| run.index).collect()),
        exhibits: exhibits(&search, [(&baseline, &judged[0]), (&model, &judged[after])]),
        notes: search.notes,
    }
}

/// Exhibits of all runs under two laws; a held-out run that either gave no answer to has none.
fn exhibits(search: &Search<'_>, [before, after]: [(&Fitted, &Vec<Judged>); 2]) -> Vec<WholeExhibit> {
    let [first, second] = [before, after].map(|(fitted, _)| search.with_waves(&fitted.waves));
    let training = (0..first.len()).map(|k| {
        let sides = [(&first[k], before.0), (&second[k], after.0)];
        exhibit::exhibit(false, sides.map(|(run, fitted)| (run, &fitted.law, &fitted.open[k].xi)))
    });
    let held_out = before.1.iter().filter_map(|first| {
        let second = after.1.iter().find(|second| second.run.index == first.run.index)?;
        let sides = [(first, before.0), (second, after.0)];
        Some(exhibit::exhibit(
            true,
            sides.map(|(judged, fitted)| (&judged.run, &fitted.law, &judged.open.xi)),
        ))
    });
    let mut all: Vec<WholeExhibit> = training.chain(held_out).collect();
    all.sort_by_key(|exhibit| exhibit.run);
    all
}

fn sum(squares: impl Iterator<Item = [f64; 3]>) -> RunError {
    squares.fold(RunError::default(), |sum, [error, floor, power]| RunError {
        error: sum.error + error,
        floor: sum.floor + floor,
        power: sum.power + power,
        count: sum.count + 1.0,
    })
}

fn of_training(search: &Search<'_>, fitted: &Fitted) -> RunError {
    let runs = search.with_waves(&fitted.waves);
    sum(runs.iter().zip(&fitted.open).map(|(run, open)| run.squares(&fitted.law, &open.xi)))
}

fn of_held_out(fitted: &Fitted, judged: &[Judged]) -> RunError {
    sum(judged.iter().map(|judged| judged.run.squares(&fitted.law, &judged.open.xi)))
}

/// The effects of a model; the last one with those that the data do not rule out in its place.
fn named(search: &Search<'_>, model: &Fitted) -> Vec<Named> {
    let all = search.values(model);
    let best = search.tried.iter().map(|t| t.1).fold(f64::NEG_INFINITY, f64::max);
    model
        .effects
        .iter()
        .enumerate()
        .map(|(k, &effect)| {
            let near = |(other, evidence): &&(usize, f64)| {
                *other != effect && best - evidence < EVIDENCE && model.effects.len() == 1
            };
            let rivals: Vec<&(usize, f64)> = search.tried.iter().filter(near).collect();
            let odds: f64 = rivals.iter().map(|(_, evidence)| (-0.5 * (best - evidence)).exp()).sum();
            Named {
                id: ALL[effect].id(),
                probability: 1.0 / (1.0 + odds),
                position: None,
                sensor: None,
                parameters: parameters(&all, (model, k)),
                indistinguishable: rivals.iter().take(2).map(|(other, _)| ALL[*other].id()).collect(),
                experiment: ALL[effect].experiment(),
            }
        })
        .collect()
}

/// What an effect brought, of all values of a model.
fn parameters(all: &[Value], (model, k): (&Fitted, usize)) -> Vec<Value> {
    let brought = |value: &&Value| model.added[k].iter().any(|unknown| unknown.parameter.name == value.0);
    let mut found: Vec<Value> = all.iter().filter(brought).cloned().collect();
    if let Some(wave) = model.waves.first().filter(|_| ALL[model.effects[k]].id() == search::MODULATION) {
        let hertz = wave.omega / std::f64::consts::TAU;
        found.push(("modulation_frequency".into(), "Hz".into(), hertz, f64::NAN));
    }
    found
}
