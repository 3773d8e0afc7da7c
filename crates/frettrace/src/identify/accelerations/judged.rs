//! What may be said of a joint fit: intervals, what widens them, and what takes them back.

use super::groups::{Condition, tested};
use super::joint::{FEW_ITERATIONS, Found};
use super::problem::Problem;
use crate::StudyError;
use frettrace_explain::{Fitted, Study, Unknown, signed};
use frettrace_forward::accelerations::{AccelerationModel, Quantity, Rig, RunLines};
use frettrace_friction::effects::Hook;
use frettrace_identify::{
    Fit, FitSettings, GroupTest, Grouping, Identified, IdentifySettings, Model, correct_by, identify,
    test_groups, widen_by_groups, widen_by_held, widen_to_accuracy,
};

/// Share of a period in which the contact is at its limit from which it slides beyond doubt.
const SLIDING: f64 = 0.1;
/// Friction that a contact which only sticks may have as well.
const MORE_FRICTION: f64 = 1.3;
/// Difference of χ² that a limit which touches the noise may gain: that of five standard deviations.
const LIKE: f64 = 25.0;
/// No accelerometer and no load cell is calibrated better than to this share, which is the same for all runs.
const CALIBRATION: f64 = 5e-4;
/// No two models of the same beam and contact agree better than to this share of a parameter.
const ACCURACY: f64 = 5e-4;
/// Power of what a series misses over that of what half as many lines again change of it: kinks make it fall by the square of
/// the lines, so that they change it by a half.
const CUT: f64 = 4.0;
/// Error over that of the noise from which a law is not that of the contact.
const MISFIT: f64 = 1.5;

/// What may be said of a joint fit.
pub(super) struct Judgement {
    pub(super) identified: Identified,
    /// One test a condition and parameter.
    pub(super) tests: Vec<Vec<GroupTest>>,
}

/// Intervals: by covariance where a parameter is sharp, by profile where it is not; calibration and model accuracy on top.
/// Whether they are narrow enough to call a parameter known is asked last.
pub(super) fn judged(
    study: &Study<'_>,
    found: &Found,
    conditions: &[Condition],
) -> Result<Judgement, StudyError> {
    let fitted = &found.fitted;
    let (unknowns, fit) = with_gains(study, fitted);
    let problem = Problem::new(study, fitted, (&unknowns, found.beside()));
    let mut identified = intervals(&problem, &fit, &fitted.unknowns)?;
    let sizes = problem.sizes();
    let runs = [&study.training[..], &found.aperiodic.runs].concat();
    let wanted = tested(fitted.unknowns.iter().map(|u| u.quantity));
    let tests = conditions.iter().map(|condition| {
        let group: Vec<usize> = runs.iter().map(|run| condition.group[*run]).collect();
        let grouping = Grouping { sizes: &sizes, group: &group };
        test_groups(&problem, (&fit, &identified), grouping, &wanted)
    });
    let tests: Vec<Vec<GroupTest>> = tests.collect();
    let held: Vec<(usize, f64)> = (fitted.unknowns.len()..unknowns.len()).map(|k| (k, CALIBRATION)).collect();
    widen_by_groups(&problem, &fit, &mut identified, &sizes);
    widen_by_held(&problem, &fit, &mut identified, &held);
    let accuracy = ACCURACY.hypot(found.normal_doubt);
    widen_to_accuracy(&problem, &mut identified, accuracy, &per_normal_force(&fitted.unknowns));
    let mut cut = 0.0;
    if let Some(change) = truncation(study, fitted) {
        cut = (CUT * change.iter().map(|d| d * d).sum::<f64>() / fitted.fit.data_cost).min(1.0);
        correct_by(&problem, &fit, &mut identified, &problem.change(change));
    }
    let slow = reaches_no_sliding(study, fitted, &identified);
    identified.settle(problem.parameters(), IdentifySettings::default().widest);
    if slow {
        identified.withhold_those(
            |name| name == "mu_k",
            "v_s may be larger than the fastest sliding: what was seen may be the static coefficient, or any on the way to the sliding one",
            "sliding speeds from zero to three v_s",
        );
    }
    take_back(study, found, &mut identified, cut);
    Ok(Judgement { identified, tests })
}

/// Which unknowns are those of the law that are forces per normal force.
fn per_normal_force(unknowns: &[Unknown]) -> Vec<usize> {
    let hooks = [Hook::MuKinetic, Hook::StribeckRise, Hook::Sigma0, Hook::Sigma1];
    let is_one = |unknown: &Unknown| hooks.iter().any(|hook| unknown.quantity == Quantity::Law(*hook));
    unknowns.iter().enumerate().filter(|(_, unknown)| is_one(unknown)).map(|(j, _)| j).collect()
}

/// The unknowns and their fit, with the gain of each sensor held at 1.
fn with_gains(study: &Study<'_>, fitted: &Fitted) -> (Vec<Unknown>, Fit) {
    let count = fitted.unknowns.len() + study.case.rig.sensors.len();
    let mut unknowns = fitted.unknowns.clone();
    let gain = |k| signed(Quantity::Gain(k), ("gain", "1"), CALIBRATION, (0.5, 2.0));
    unknowns.extend((0..count - fitted.unknowns.len()).map(gain));
    let mut fit = fitted.fit.clone();
    fit.values.resize(count, 1.0);
    fit.free.resize(count, false);
    fit.at_bound.resize(count, false);
    (unknowns, fit)
}

/// Intervals under the noise alone.
fn intervals(problem: &Problem<'_>, fit: &Fit, unknowns: &[Unknown]) -> Result<Identified, StudyError> {
    let mut settings = IdentifySettings {
        profiled: vec![false; fit.values.len()],
        fit: FitSettings {
            max_iterations: 4,
            relative_tolerance: 1e-5,
            absolute_tolerance: 0.05,
            ..FitSettings::default()
        },
        ..IdentifySettings::default()
    };
    let plain = identify(problem, fit, &settings)?;
    for (j, unknown) in unknowns.iter().enumerate() {
        let parameter = &plain.parameters[j];
        let share = parameter.std.map_or(f64::INFINITY, |s| s / parameter.value.abs());
        settings.profiled[j] = matches!(unknown.quantity, Quantity::Law(_)) && (0.1..0.3).contains(&share);
    }
    if !settings.profiled.contains(&true) {
        return Ok(plain);
    }
    Ok(identify(problem, fit, &settings)?)
}

/// Whether the Stribeck curve may still fall beyond the fastest sliding: its velocity is not bounded below that, or not at all.
fn reaches_no_sliding(study: &Study<'_>, fitted: &Fitted, identified: &Identified) -> bool {
    let place = fitted.unknowns.iter().position(|u| u.quantity == Quantity::Law(Hook::StribeckVelocity));
    place.is_some_and(|place| {
        identified.parameters[place].interval95.is_none_or(|(_, high)| high > study.scales.velocity)
    })
}

/// Takes the intervals back where the contact only sticks, or where this law is not that of the contact; `cut` is the share of χ²
/// that finer series would take away.
fn take_back(study: &Study<'_>, found: &Found, identified: &mut Identified, cut: f64) {
    let fitted = &found.fitted;
    if found.aperiodic.runs.is_empty() && only_sticks(study, fitted) {
        identified.withhold(
            "the contact hardly slides in the runs that take part: what it held is only a lower bound of its friction",
            "runs at higher levels",
        );
    }
    let ratio = study.error(fitted, &study.training).ratio() * (1.0_f64 - cut).sqrt();
    if ratio > MISFIT {
        identified.withhold(
            &format!(
                "with this law the error is {ratio:.1} times that of the noise: its parameters describe no part of the contact"
            ),
            "another law on the same runs, or the effect that explain names",
        );
    }
}

/// Whether a rigid contact with much more friction describes the runs as well: χ² of a contact that sticks falls where the
/// limit touches the noise, and its curvature there says nothing of larger limits.
fn only_sticks(study: &Study<'_>, fitted: &Fitted) -> bool {
    if !fitted.setting.holds_rigidly() || study.training.iter().any(|run| slides(study, fitted, *run)) {
        return false;
    }
    let mut stronger = fitted.setting.clone();
    for hook in [Hook::MuKinetic, Hook::StribeckRise] {
        if let Some(value) = stronger.law.get(hook) {
            stronger.law.set(hook, MORE_FRICTION * value);
        }
    }
    let others: Vec<Unknown> =
        fitted.unknowns.iter().filter(|u| !matches!(u.quantity, Quantity::Law(_))).cloned().collect();
    let Ok(found) = study.fit(stronger, &others, &fitted.memory, FEW_ITERATIONS) else { return false };
    let inflation = (fitted.fit.data_cost / study.residual_count().max(1) as f64).max(1.0);
    found.fit.cost - fitted.fit.cost < LIKE * inflation
}

/// Whether the contact is at its kinetic limit, or above it, for a good part of a period.
fn slides(study: &Study<'_>, fitted: &Fitted, run: usize) -> bool {
    let Ok(contact) = study.model.contact(&fitted.setting, run, &mut fitted.memory.clone()) else {
        return false;
    };
    let limit = 0.99 * fitted.setting.law.get(Hook::MuKinetic).unwrap_or_default();
    let at_limit =
        contact.force.iter().zip(&contact.normal).filter(|(force, normal)| force.abs() >= limit * **normal);
    at_limit.count() as f64 > SLIDING * contact.force.len() as f64
}

/// What longer series and finer grids change in the whitened prediction; `None` where their balance does not close.
fn truncation(study: &Study<'_>, fitted: &Fitted) -> Option<Vec<f64>> {
    let rig = Rig { modes: 2 * study.model.rig().modes, ..study.model.rig().clone() };
    let finer = |run: &RunLines| RunLines {
        contact_order: 3 * run.contact_order / 2,
        samples: 2 * run.samples,
        ..run.clone()
    };
    let model = AccelerationModel::new(rig, study.model.runs.iter().map(finer).collect()).ok()?;
    let fine = model.predict(&fitted.setting, &study.training, &mut model.memory()).ok()?;
    let coarse = study.model.predict(&fitted.setting, &study.training, &mut fitted.memory.clone()).ok()?;
    let mut change = Vec::with_capacity(study.residual_count());
    for ((run, fine), coarse) in study.training.iter().zip(&fine).zip(&coarse) {
        for (s, deviation) in study.model.runs[*run].deviation.iter().enumerate() {
            for ((a, b), std) in fine[s].iter().zip(&coarse[s]).zip(deviation) {
                let d = (a - b) / *std;
                change.extend([d.re, d.im]);
            }
        }
    }
    Some(change)
}
