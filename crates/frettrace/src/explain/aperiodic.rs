//! Files of which no run is periodic, or next to none: the contact recovered over the whole spectrum is judged.

use super::{ExplainOptions, Found, estimates, summary};
use crate::exhibits::whole_exhibits;
use crate::reconstruct::FormChoice;
use crate::results::{ErrorSummary, Explanation, Identification, NoiseFloorSource};
use crate::{Progress, StudyError, case};
use frettrace_explain::aperiodic::{
    BaseTone, ErrorOf, Motion, Value, WholeOutcome, WholeRun, base_tone, beside_declared, explain_whole,
    with_base_motion, with_faults,
};
use frettrace_explain::{Case, ChannelFault, DeclaredModes, RunError};
use frettrace_fourier::Harmonics;
use frettrace_inverse::{Form, RunReconstruction};
use frettrace_measurement::Measurement;
use num_complex::Complex64;

/// Explains a measurement by what was recovered of its runs.
pub(super) fn explain(
    measurement: &Measurement,
    options: &ExplainOptions,
    (case, declared, recovered): (&Case, &DeclaredModes, &[RunReconstruction]),
    progress: &Progress,
) -> Result<Explanation, StudyError> {
    if options.controls > 0 {
        return Err(StudyError::ControlsWithoutPeriod);
    }
    let runs: Vec<Option<WholeRun>> = recovered.iter().map(whole).collect();
    let mut outcome = match base_tone(case, &runs)? {
        Some(tone) => beside_base(measurement, (case, &runs), &tone)?,
        None => explain_whole(case, &case::samples(measurement), &runs)?,
    };
    if case.faults.iter().any(ChannelFault::breaks_off) {
        let all: Vec<Option<WholeRun>> =
            case::runs(measurement, FormChoice::Aperiodic)?.iter().map(whole).collect();
        outcome = with_faults(case, [&all, &runs], outcome);
    }
    outcome = beside_declared(case, declared, outcome);
    outcome.notes.push(errors(outcome.error_of).to_owned());
    progress.step();
    progress.finish();
    Ok(explanation(measurement, options, &outcome))
}

/// What the errors of an outcome are errors of.
fn errors(of: ErrorOf) -> &'static str {
    match of {
        ErrorOf::Force => {
            "errors are those of the recovered contact force against the law's answer to the recovered motion, relative, in the bins that the sensors know"
        }
        ErrorOf::Accelerations => {
            "errors are those of the accelerations, relative, as their balance without a law has them"
        }
    }
}

/// Explains what is left beside a motion of the base: taken out of the accelerations before the contact is recovered, and put to the motion of the
/// contact after.
fn beside_base(
    measurement: &Measurement,
    (case, before): (&Case, &[Option<WholeRun>]),
    tone: &BaseTone,
) -> Result<WholeOutcome, StudyError> {
    let mut calm = measurement.clone();
    for (run, motion) in calm.runs.iter_mut().zip(&tone.runs) {
        let turn = tone.omega / run.sampling_rate;
        for (channel, amplitude) in run.acceleration.iter_mut().zip(&motion.acceleration) {
            channel.iter_mut().zip(wave(*amplitude, turn)).for_each(|(a, base)| *a -= base);
        }
    }
    let recovered = case::runs(&calm, FormChoice::Aperiodic)?;
    let mut runs: Vec<Option<WholeRun>> = recovered.iter().map(whole).collect();
    let stiffness = case.rig.lever.map_or(0.0, |_| case.rig.boundary.support_stiffness);
    for (run, motion) in runs.iter_mut().zip(&tone.runs) {
        let Some(WholeRun { dt, found, .. }) = run else { continue };
        let turn = tone.omega * *dt;
        let speed = motion.slip * Complex64::new(0.0, tone.omega);
        let normal = -motion.end * stiffness;
        let parts =
            [(&mut found.slip, motion.slip), (&mut found.velocity, speed), (&mut found.normal, normal)];
        for (signal, amplitude) in parts {
            signal.iter_mut().zip(wave(amplitude, turn)).for_each(|(x, base)| *x += base);
        }
    }
    let outcome = explain_whole(case, &case::samples(&calm), &runs)?;
    Ok(with_base_motion(case, (tone, [before, &runs]), outcome))
}

/// `Re(x e^{iφj})`, `j = 0, 1, …`.
fn wave(amplitude: Complex64, turn: f64) -> impl Iterator<Item = f64> {
    (0..).map(move |j: u32| (amplitude * Complex64::from_polar(1.0, turn * f64::from(j))).re)
}

/// What was recovered of a run, with what that leaves open; `None` where nothing was.
pub(super) fn whole(run: &RunReconstruction) -> Option<WholeRun> {
    let contact = run.contact.as_ref().filter(|_| run.lines.form == Form::Aperiodic)?;
    let (rate, samples) = (run.lines.sampling_rate, run.lines.samples);
    let sampled =
        |bins: &Vec<Complex64>| Harmonics::exact(contact.friction.base, bins.clone()).sample(rate, samples);
    let shared = &contact.shared;
    let excess = excess(run);
    let errors = shared.friction.iter().zip(&shared.slip).zip(&shared.slip_velocity).zip(&shared.normal);
    let errors = errors.map(|(((force, slip), velocity), normal)| {
        let factor = weighed(&excess, force);
        let error = |bins: &Vec<Complex64>| sampled(&bins.iter().map(|bin| bin * factor).collect());
        Motion { force: error(force), slip: error(slip), velocity: error(velocity), normal: error(normal) }
    });
    let finite = |signal: &[f64]| signal.iter().all(|x| x.is_finite());
    let found = Motion {
        force: run.friction_force.values.clone(),
        slip: run.slip_displacement.values.clone(),
        velocity: run.slip_velocity.values.clone(),
        normal: run.normal_force.values.clone(),
    };
    let known = [&found.force, &found.slip, &found.velocity, &found.normal].into_iter().all(|x| finite(x));
    known.then(|| WholeRun {
        dt: rate.recip(),
        shared: errors.collect(),
        own: own(&contact.friction, &shared.friction, &excess),
        own_normal: own(&contact.normal, &shared.normal, &excess),
        left: run.balance.whitened.clone(),
        balance: [run.balance.chi_square.iter().sum(), run.balance.freedom.iter().sum::<usize>() as f64],
        found,
    })
}

/// Bins on each side whose balance tells the noise about one: with five sensors, `√(2/(2·5·17)) = 11 %` of its power.
const NEAR: usize = 8;

/// Noise of each bin, from 0, over what is stated (never less): χ² per degree of freedom of the balance about it. Noise has a colour, and its low
/// end is what a drift is made of.
fn excess(run: &RunReconstruction) -> Vec<f64> {
    let balance = &run.balance;
    let bins = balance.chi_square.len();
    let near = |k: usize| {
        // Towards zero frequency noise rises from bin to bin.
        let half = NEAR.min(k.div_ceil(2));
        let range = k - half..(k + half + 1).min(bins);
        let freedom: usize = balance.freedom[range.clone()].iter().sum();
        let chi: f64 = balance.chi_square[range].iter().sum();
        (chi / freedom.max(1) as f64).max(1.0).sqrt()
    };
    std::iter::once(0).chain(0..bins).map(near).collect()
}

/// The excess where an error has its power.
fn weighed(excess: &[f64], error: &[Complex64]) -> f64 {
    let (sum, power) = error.iter().zip(excess).fold((0.0, 0.0), |(sum, power), (bin, excess)| {
        (sum + bin.norm_sqr() * excess * excess, power + bin.norm_sqr())
    });
    if power > 0.0 { (sum / power).sqrt() } else { 1.0 }
}

/// Standard deviations of real and imaginary part of bins beside the errors that they share.
fn own(lines: &Harmonics, shared: &[Vec<Complex64>], excess: &[f64]) -> Vec<f64> {
    let of = |(k, variance): (usize, &f64)| {
        let common: f64 = shared.iter().filter_map(|error| error.get(k)).map(Complex64::norm_sqr).sum();
        (0.5 * (variance - common).max(0.0)).sqrt() * excess.get(k).copied().unwrap_or(1.0)
    };
    lines.variance.iter().enumerate().map(of).collect()
}

fn explanation(measurement: &Measurement, options: &ExplainOptions, outcome: &WholeOutcome) -> Explanation {
    let found = Found {
        verdict: outcome.verdict,
        effects: &outcome.effects,
        place: outcome.place,
        error: &outcome.error,
        held_out: outcome.held_out.as_ref(),
        runs: &outcome.runs,
        tried: &outcome.tried,
        notes: &outcome.notes,
    };
    let law = &measurement.support.law;
    let side = |values: &Vec<Value>| Identification {
        law: law.clone(),
        parameters: estimates(values),
        ..Identification::default()
    };
    let summary = match outcome.error_of {
        ErrorOf::Force => of_force,
        ErrorOf::Accelerations => summary,
    };
    Explanation {
        exhibits: whole_exhibits(measurement, &outcome.exhibits),
        ..found.explanation((measurement, options), summary, outcome.laws.each_ref().map(side))
    }
}

fn of_force(error: &RunError, source: NoiseFloorSource) -> ErrorSummary {
    let of_accelerations = summary(error, source);
    ErrorSummary { force: of_accelerations.acceleration, acceleration: None, ..of_accelerations }
}
