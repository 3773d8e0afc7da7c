//! Step (v): law and structure together against the accelerations.

use super::aperiodic::Aperiodic;
use super::problem::{self, Problem};
use super::support;
use crate::StudyError;
use frettrace_explain::support::SupportForce;
use frettrace_explain::{ExplainError, Fitted, Study, Unknown, positive, soften};
use frettrace_forward::accelerations::{Quantity, RunLines, Setting};
use frettrace_friction::effects::Hook;
use frettrace_identify::contact::Family;
use frettrace_identify::{FitSettings, Parameter, Transform, starts};
use rayon::prelude::*;

/// Linearisations of a fit: a good start needs less than ten.
const MOST_ITERATIONS: usize = 30;
/// χ² per residual above which the first start is not trusted and others are tried.
const DOUBTFUL: f64 = 1.3;
/// Starts tried then, a multiple of two threads.
const MORE_STARTS: usize = 4;
/// Starts that are tried together then, the better of which is followed to its end, and how often that is done.
const TOGETHER: usize = 3;
const ROUNDS: usize = 3;
/// Standard deviations within which two fits are one.
const SAME: f64 = 3.0;
/// Share of a line, and ten times that of the loudest line, to which it counts at first.
const SOFT: f64 = 0.02;
/// Linearisations of each of them: what is not near by then is not worth more.
pub(super) const FEW_ITERATIONS: usize = 12;
/// Linearisations with which a found minimum is made sharp.
const POLISH: usize = 40;

/// Lines of the excitation with which a fit begins, and the accuracy to which they predict a line, as a share of it and, ten
/// times less, of the loudest.
const COARSE: usize = 64;
const COARSE_ACCURACY: f64 = 3e-3;
/// χ² per residual above which a fit gets a finer phase grid, each twice as fine as the one before, and how many.
const RESOLVED: f64 = 1.05;
const MOST_REFINED: usize = 3;
/// Times that the force of a second support is fitted anew beside law and structure.
const RENEWALS: usize = 3;

/// Imbalance of a line that still counts as balanced where a run does not close to less, in standard deviations: it
/// adds a tenth to the variance.
const LOOSE: f64 = 0.3;

/// A joint fit with what was compared beside plain lines.
pub(super) struct Found {
    pub(super) fitted: Fitted,
    support: Option<SupportForce>,
    pub(super) aperiodic: Aperiodic,
    /// Relative standard deviation of the mean normal force under the unknown mean of a second support's force.
    pub(super) normal_doubt: f64,
}

impl Found {
    /// Whether anything but plain lines is compared.
    fn is_more(&self) -> bool {
        self.support.is_some() || !self.aperiodic.runs.is_empty()
    }

    pub(super) fn beside(&self) -> problem::Beside<'_> {
        let aperiodic = Some(&self.aperiodic).filter(|a| !a.runs.is_empty());
        problem::Beside { support: self.support.as_ref(), aperiodic }
    }
}

/// The best joint fit. Runs whose balance does not close at the start join once the others have improved the law; those
/// that still do not close are taken out of the training runs. `smaller` are fits of laws that this one extends.
pub(super) fn fit(
    study: &mut Study<'_>,
    starts: &[Setting],
    smaller: &[Setting],
) -> Result<Found, StudyError> {
    let fine = study.model.runs.clone();
    let is_coarse = coarsen(study)?;
    let mut fitted = by_lines(study, starts)?;
    if is_coarse {
        refine(study, fine)?;
        let few = closing(study, &fitted.setting, &study.training);
        study.training = if few.is_empty() { study.training.clone() } else { few };
        let (setting, unknowns) = (fitted.setting, fitted.unknowns);
        fitted = study.fit(setting, &unknowns, &study.model.memory(), POLISH)?;
    }
    fitted = refined(study, fitted);
    for start in smaller {
        let again = study.fit(start.clone(), &fitted.unknowns, &study.model.memory(), POLISH);
        fitted = again.ok().filter(|again| again.fit.cost < fitted.fit.cost).unwrap_or(fitted);
    }
    let aperiodic = Aperiodic::new(study, &fitted.setting)?;
    let mut found = Found { fitted, support: None, aperiodic, normal_doubt: 0.0 };
    found.fitted = polished(study, &found);
    for _ in 0..RENEWALS {
        found.support = SupportForce::new(study, &found.fitted, &study.training)?;
        if found.support.is_none() {
            break;
        }
        found.fitted = polished(study, &found);
        if let Some(support) = &found.support {
            support.renew(study, &found.fitted);
        }
    }
    found.normal_doubt = support::doubt(study, &found.fitted);
    Ok(found)
}

/// The fit on finer phase grids, where it leaves more than the noise: corners of stick and slip send their force to every line, and a
/// grid that cuts them short bends the law. A rigid contact has them in every run, one that yields in the runs that change.
fn refined(study: &mut Study<'_>, mut fitted: Fitted) -> Fitted {
    let enough = RESOLVED * study.residual_count() as f64;
    for _ in 0..MOST_REFINED {
        if fitted.fit.data_cost <= enough {
            break;
        }
        let rigid = fitted.setting.holds_rigidly();
        let finer = if rigid { study.refined() } else { study.resolved(&fitted) };
        let Ok(Some(mut finer)) = finer else { break };
        let found = finer.fit(fitted.setting.clone(), &fitted.unknowns, &finer.model.memory(), POLISH);
        let Some(found) = found.ok().filter(|found| found.fit.cost < fitted.fit.cost) else { break };
        fitted = found;
        if rigid && finer.doubt_grid(&fitted).is_ok() {
            let doubted = finer.fit(fitted.setting.clone(), &fitted.unknowns, &fitted.memory, POLISH);
            fitted = doubted.unwrap_or(fitted);
        }
        *study = finer;
    }
    fitted
}

/// The best fit to the lines of the accelerations.
fn by_lines(study: &mut Study<'_>, starts: &[Setting]) -> Result<Fitted, StudyError> {
    let setting = &starts[0];
    let all = study.training.clone();
    study.training = closing(study, setting, &all);
    if study.training.len() < all.len() {
        study.model.tolerance = LOOSE;
        study.training = closing(study, setting, &all);
    }
    if study.training.is_empty() {
        study.training.clone_from(&all);
    }
    let mut fitted = fit_training(study, starts)?;
    if support::recover(study, &fitted.setting) {
        fitted = fit_training(study, &[fitted.setting.clone()])?;
    }
    let closed = closing(study, &fitted.setting, &all);
    if closed.len() > study.training.len() {
        let left = fitted.fit.data_cost / study.residual_count().max(1) as f64;
        let few = std::mem::replace(&mut study.training, closed);
        match joined(study, &fitted, left) {
            Ok(better) => fitted = better,
            Err(_) => study.training = few,
        }
    }
    Ok(fitted)
}

/// A fit with the runs that joined: where it leaves no more than the fit to the others (χ² per residual), it is not searched anew.
fn joined(study: &mut Study<'_>, before: &Fitted, left: f64) -> Result<Fitted, StudyError> {
    let memory = study.model.memory();
    let enough = left.max(DOUBTFUL) * study.residual_count() as f64;
    match study.fit(before.setting.clone(), &before.unknowns, &memory, MOST_ITERATIONS) {
        Ok(found) if found.fit.data_cost <= enough => Ok(found),
        _ => fit_training(study, std::slice::from_ref(&before.setting)),
    }
}

/// Takes the lines above [`COARSE`] of the excitation away: a fit far from its minimum needs none of them, and the balance of
/// a contact costs the third power of its lines. Whether there were any.
fn coarsen(study: &mut Study<'_>) -> Result<bool, StudyError> {
    let mut runs = study.model.runs.clone();
    let mut is_coarse = false;
    for (run, record) in runs.iter_mut().zip(&study.case.records) {
        let most = COARSE * record.subharmonic;
        if run.contact_order <= 2 * most {
            continue;
        }
        is_coarse = true;
        run.force.truncate(most + 1);
        run.known_force.truncate(most + 1);
        for lines in &mut run.acceleration {
            lines.truncate(most + 1);
        }
        for deviations in &mut run.deviation {
            deviations.truncate(most + 1);
        }
        soften_all(run, COARSE_ACCURACY);
        run.contact_order = most + most / 4 + 4;
        run.samples = (8 * run.contact_order).next_power_of_two();
    }
    if is_coarse {
        study.model = study.model.with_runs(runs).map_err(ExplainError::from)?;
    }
    Ok(is_coarse)
}

/// Gives all lines back, with what has been found of a second support's force.
fn refine(study: &mut Study<'_>, mut fine: Vec<RunLines>) -> Result<(), StudyError> {
    for (run, coarse) in fine.iter_mut().zip(&study.model.runs) {
        run.known_force.iter_mut().zip(&coarse.known_force).for_each(|(to, from)| *to = *from);
    }
    study.model = study.model.with_runs(fine).map_err(ExplainError::from)?;
    Ok(())
}

/// The same minimum more sharply: along a weak direction a fit that ends where χ² falls by a part in a thousand of itself is
/// standard deviations away from it. With a second support or runs that are not periodic it is another minimum.
fn polished(study: &Study<'_>, rough: &Found) -> Fitted {
    let fitted = &rough.fitted;
    let problem = Problem::new(study, fitted, (&fitted.unknowns, rough.beside()));
    let settings = FitSettings {
        max_iterations: POLISH,
        relative_tolerance: 1e-6,
        absolute_tolerance: 0.01,
        ..FitSettings::default()
    };
    match frettrace_identify::fit(&problem, &fitted.fit.values, &settings) {
        Ok(found) if rough.is_more() || found.cost < fitted.fit.cost => {
            let setting = problem.accelerations.at(&found.values);
            let mut memory = fitted.memory.clone();
            // Solutions near it; a run that does not balance keeps none.
            let _ = study.model.predict(&setting, &study.training, &mut memory);
            let mut sharper = fitted.clone();
            (sharper.setting, sharper.fit, sharper.memory) = (setting, found, memory);
            sharper
        }
        _ => fitted.clone(),
    }
}

/// The runs of a list whose balance closes.
fn closing(study: &Study<'_>, setting: &Setting, runs: &[usize]) -> Vec<usize> {
    let closes = |run: &usize| study.model.predict(setting, &[*run], &mut study.model.memory()).is_ok();
    runs.par_iter().copied().filter(closes).collect()
}

/// The best fit to the training runs: from the first start, and where that leaves more than noise from all of them.
fn fit_training(study: &mut Study<'_>, starts: &[Setting]) -> Result<Fitted, StudyError> {
    let unknowns = unknowns(study);
    let first = smoothed(study, &starts[..1], &unknowns).pop().unwrap_or_else(|| starts[0].clone());
    let memory = study.model.memory();
    let first = study.fit(first, &unknowns, &memory, MOST_ITERATIONS);
    let enough = DOUBTFUL * study.residual_count() as f64;
    if first.as_ref().is_ok_and(|f| f.fit.data_cost < enough) {
        return Ok(first?);
    }
    let rigid = starts[0].holds_rigidly();
    let on_contacts = study.laws_on_contacts(&starts[0])?;
    let on_contacts: Vec<Setting> =
        on_contacts.into_iter().map(|law| Setting { law, ..starts[0].clone() }).collect();
    let softer = if rigid { Vec::new() } else { softer(&starts[0]) };
    let others = [&on_contacts, &starts[1..], &softer, &around(&starts[0], &unknowns)].concat();
    let mut best = first;
    for few in others.chunks(TOGETHER).take(ROUNDS) {
        let Some(start) = smoothed(study, few, &unknowns).into_iter().next() else { continue };
        let Ok(found) = study.fit(start, &unknowns, &memory, MOST_ITERATIONS) else { continue };
        let again = best.as_ref().is_ok_and(|best| is_same(best, &found));
        if best.as_ref().is_ok_and(|best| best.fit.cost <= found.fit.cost) {
            if again {
                break;
            }
            continue;
        }
        let done = again || found.fit.data_cost < enough;
        best = Ok(found);
        if done {
            break;
        }
    }
    Ok(best?)
}

/// Whether two fits from different starts ended in one minimum: every parameter of the law within three standard deviations of
/// the noise, χ² above its expectation included. What it leaves is then the model's, not the search's.
fn is_same(one: &Fitted, other: &Fitted) -> bool {
    let law = one.unknowns.iter().enumerate().filter(|(_, u)| matches!(u.quantity, Quantity::Law(_)));
    let near = |(j, std): (usize, f64)| (one.fit.values[j] - other.fit.values[j]).abs() <= SAME * std;
    law.filter_map(|(j, _)| Some((j, *one.deviation.get(j)?))).all(near)
}

/// Fits from some starts to lines that count by their size and not only by their noise, best first: where a line is
/// known to a part in 1e5, χ² is a narrow bent valley that a step of any length leaves; to two parts in a hundred it is
/// a bowl around the same minimum.
fn smoothed(study: &mut Study<'_>, starts: &[Setting], unknowns: &[Unknown]) -> Vec<Setting> {
    let sharp: Vec<Vec<Vec<f64>>> = study.model.runs.iter().map(|run| run.deviation.clone()).collect();
    study.model.runs.iter_mut().for_each(|run| soften_all(run, SOFT));
    let memory = study.model.memory();
    let fit = |start: &Setting| study.fit(start.clone(), unknowns, &memory, FEW_ITERATIONS).ok();
    let mut fitted: Vec<Fitted> = starts.par_iter().filter_map(fit).collect();
    fitted.sort_by(|a, b| a.fit.cost.total_cmp(&b.fit.cost));
    for (run, deviation) in study.model.runs.iter_mut().zip(sharp) {
        run.deviation = deviation;
    }
    fitted.into_iter().map(|f| f.setting).collect()
}

/// Lets the lines of all sensors count to a share of themselves.
fn soften_all(run: &mut RunLines, share: f64) {
    for (lines, deviations) in run.acceleration.iter().zip(&mut run.deviation) {
        soften(deviations, lines, share);
    }
}

/// What the declared model leaves open.
fn unknowns(study: &Study<'_>) -> Vec<Unknown> {
    let mut unknowns = study.case.unknowns();
    if study.case.law == Family::Dahl {
        unknowns.push(positive(Hook::Exponent, 0.02, 8.0));
    }
    // A step of the fit goes ten scales at most: one scale is a damping that makes a tenth of the preload at top speed.
    let share = 0.1 / study.scales.velocity;
    for unknown in &mut unknowns {
        match unknown.quantity {
            Quantity::Law(Hook::Sigma1) => unknown.parameter.transform = Transform::Linear { scale: share },
            Quantity::Law(Hook::Viscous) => {
                let scale = share * study.scales.preload;
                unknown.parameter.transform = Transform::Linear { scale };
            }
            _ => {}
        }
    }
    let told = Family::Hybrid.parameters(&[1.0; 9]).into_iter().chain(Family::Dahl.parameters(&[1.0; 3]));
    for described in told {
        let name = if described.name == "mu_s" { "mu_rise" } else { &described.name };
        let alike = unknowns.iter_mut().filter(|u| u.parameter.name == name);
        alike.for_each(|u| u.parameter.experiment.clone_from(&described.experiment));
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
