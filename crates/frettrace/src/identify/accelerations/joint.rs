//! Step (v): law and structure together against the accelerations, and what may be said of the result.

use crate::StudyError;
use frettrace_explain::{AccelerationFit, Case, Fitted, Study, Unknown, positive, signed};
use frettrace_forward::accelerations::{Quantity, Setting};
use frettrace_friction::effects::Hook;
use frettrace_identify::contact::Family;
use frettrace_identify::{
    FitSettings, Held, Identified, IdentifySettings, Parameter, identify, starts, widen_by_groups,
    widen_by_held, widen_to_accuracy,
};
use rayon::prelude::*;

/// Linearisations of a fit: a good start needs less than ten.
const MOST_ITERATIONS: usize = 30;
/// χ² per residual above which the first start is not trusted and others are tried.
const DOUBTFUL: f64 = 1.3;
/// Starts tried then, a multiple of two threads.
const MORE_STARTS: usize = 4;
/// Linearisations of each of them: what is not near by then is not worth more.
const FEW_ITERATIONS: usize = 12;
/// No accelerometer and no load cell keeps its calibration from run to run better than to this share.
const CALIBRATION: f64 = 5e-4;
/// No two models of the same beam and contact agree better than to this share of a parameter.
const ACCURACY: f64 = 5e-4;

/// Imbalance of a line that still counts as balanced where a run does not close to less, in standard deviations: it
/// adds a tenth to the variance.
const LOOSE: f64 = 0.3;

/// The best joint fit. Runs whose balance does not close at the start join once the others have improved the law; those
/// that still do not close are taken out of the training runs.
pub(super) fn fit(study: &mut Study<'_>, setting: Setting, compared: bool) -> Result<Fitted, StudyError> {
    let all = study.training.clone();
    study.training = closing(study, &setting, &all);
    if study.training.len() < all.len() {
        study.model.tolerance = LOOSE;
        study.training = closing(study, &setting, &all);
    }
    if study.training.is_empty() {
        study.training.clone_from(&all);
    }
    let mut fitted = fit_training(study, setting, compared)?;
    let closed = closing(study, &fitted.setting, &all);
    if closed.len() > study.training.len() {
        let few = std::mem::replace(&mut study.training, closed);
        match fit_training(study, fitted.setting.clone(), compared) {
            Ok(better) => fitted = better,
            Err(_) => study.training = few,
        }
    }
    Ok(fitted)
}

/// The runs of a list whose balance closes.
fn closing(study: &Study<'_>, setting: &Setting, runs: &[usize]) -> Vec<usize> {
    let closes = |run: &usize| study.model.predict(setting, &[*run], &mut study.model.memory()).is_ok();
    runs.par_iter().copied().filter(closes).collect()
}

/// The best fit to the training runs.
fn fit_training(study: &Study<'_>, setting: Setting, compared: bool) -> Result<Fitted, StudyError> {
    let memory = study.model.memory();
    let unknowns = unknowns(study.case, compared);
    let first = study.fit(setting.clone(), &unknowns, &memory, MOST_ITERATIONS);
    let enough = DOUBTFUL * study.residual_count() as f64;
    if first.as_ref().is_ok_and(|f| f.fit.data_cost < enough) {
        return Ok(first?);
    }
    let others: Vec<Fitted> = around(&setting, &unknowns)
        .into_par_iter()
        .chain(softer(&setting))
        .filter_map(|start| study.fit(start, &unknowns, &memory, FEW_ITERATIONS).ok())
        .collect();
    let best = others.into_iter().min_by(|a, b| a.fit.cost.total_cmp(&b.fit.cost));
    match (first, best) {
        (Ok(first), Some(other)) => Ok(if other.fit.cost < first.fit.cost { other } else { first }),
        (Err(_), Some(other)) => Ok(other),
        (first, None) => Ok(first?),
    }
}

/// What the declared model leaves open; in a comparison a law without memory keeps its bristle stiff, since with a free
/// one it would be Dahl's.
fn unknowns(case: &Case, compared: bool) -> Vec<Unknown> {
    let mut unknowns = case.unknowns();
    if case.law == Family::Dahl {
        unknowns.push(positive(Hook::Exponent, 0.02, 8.0));
    }
    if compared && case.law.is_static() {
        unknowns.retain(|u| u.quantity != Quantity::Law(Hook::Sigma0));
    }
    unknowns
}

/// Settings around one: a factor of e about each positive parameter of the law.
fn around(setting: &Setting, unknowns: &[Unknown]) -> Vec<Setting> {
    let law: Vec<&Unknown> = unknowns
        .iter()
        .filter(|u| matches!(u.quantity, Quantity::Law(_)) && u.parameter.bounds.0 > 0.0)
        .collect();
    let parameters: Vec<Parameter> = law.iter().map(|u| u.parameter.clone()).collect();
    let centre: Vec<f64> = law.iter().map(|u| setting.get(u.quantity).unwrap_or(1.0)).collect();
    starts(&parameters, &centre, &vec![1.0; law.len()], MORE_STARTS)
        .into_iter()
        .map(|values| {
            let mut moved = setting.clone();
            law.iter().zip(values).for_each(|(u, value)| moved.set(u.quantity, value));
            moved
        })
        .collect()
}

/// The same law with a softer bristle: where the balance of a stiff one is not found from rest, a fit that starts soft
/// walks there.
fn softer(setting: &Setting) -> Vec<Setting> {
    let stiffness = setting.get(Quantity::Law(Hook::Sigma0)).unwrap_or(1.0);
    [3.0, 10.0, 30.0]
        .map(|factor| {
            let mut moved = setting.clone();
            moved.set(Quantity::Law(Hook::Sigma0), stiffness / factor);
            moved
        })
        .to_vec()
}

/// Intervals: by covariance where a parameter is sharp, by profile where it is not; calibration and model accuracy on top.
pub(super) fn judged(study: &Study<'_>, fitted: &Fitted) -> Result<Identified, StudyError> {
    let count = fitted.unknowns.len();
    let sensors = study.case.rig.sensors.len();
    let mut unknowns = fitted.unknowns.clone();
    let gain = |k| signed(Quantity::Gain(k), ("gain", "1"), CALIBRATION, (0.5, 2.0));
    unknowns.extend((0..sensors).map(gain));
    let mut fit = fitted.fit.clone();
    fit.values.resize(count + sensors, 1.0);
    fit.free.resize(count + sensors, false);
    fit.at_bound.resize(count + sensors, false);
    let warm = fitted.memory.clone();
    let problem =
        AccelerationFit::new(&study.model, fitted.setting.clone(), &unknowns, study.training.clone(), warm);
    let mut settings = IdentifySettings {
        profiled: vec![false; count + sensors],
        fit: FitSettings {
            max_iterations: 4,
            relative_tolerance: 1e-5,
            absolute_tolerance: 0.05,
            ..FitSettings::default()
        },
        ..IdentifySettings::default()
    };
    let plain = identify(&problem, &fit, &settings)?;
    for (j, unknown) in fitted.unknowns.iter().enumerate() {
        let parameter = &plain.parameters[j];
        let share = parameter.std.map_or(f64::INFINITY, |s| s / parameter.value.abs());
        settings.profiled[j] = matches!(unknown.quantity, Quantity::Law(_)) && (0.1..0.3).contains(&share);
    }
    let mut judged =
        if settings.profiled.contains(&true) { identify(&problem, &fit, &settings)? } else { plain };
    let held: Vec<(usize, f64)> = (count..count + sensors).map(|k| (k, CALIBRATION)).collect();
    let sizes: Vec<usize> = study.training.iter().map(|run| residuals(study, *run)).collect();
    widen_by_groups(&problem, &fit, &mut judged, &sizes);
    widen_by_held(&problem, &fit, &mut judged, &Held { parameters: &held, sizes: &sizes });
    widen_to_accuracy(&problem, &mut judged, ACCURACY);
    Ok(judged)
}

/// Real residuals of a run: real and imaginary part of every line of every sensor.
fn residuals(study: &Study<'_>, run: usize) -> usize {
    study.model.runs[run].acceleration.iter().map(|lines| 2 * lines.len()).sum()
}
