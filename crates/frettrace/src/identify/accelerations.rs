//! A measurement file: the law and the structure against the accelerations themselves.

mod aperiodic;
mod described;
mod groups;
mod joint;
mod judged;
mod loops;
mod problem;
mod support;

use super::contact_record::comparison;
use crate::case::{case, recover_aperiodic};
use crate::results::{Identification, Step};
use crate::{Progress, StudyError};
use described::{described, from_loops_alone};
use frettrace_explain::{Case, ExplainError, Fitted, Split, Study};
use frettrace_forward::accelerations::{RunLines, Setting};
use frettrace_friction::effects::{Hook, ModifiedLaw};
use frettrace_identify::contact::{
    ContactFit, ContactHistory, ContactModel, ContactSettings, Extras, Family, identify_contact,
};
use frettrace_identify::evidence::{Candidate, rank};
use frettrace_identify::{GroupTest, Identified, IdentifySettings, Model, widen_to_accuracy};
use frettrace_measurement::Measurement;
use groups::{Condition, conditions};
use loops::Loops;

/// A law with the structure, fitted and judged.
struct Joint {
    family: Family,
    fitted: Fitted,
    identified: Identified,
    steps: Vec<Step>,
    held_out: f64,
    training: Vec<usize>,
    /// Runs that are not periodic and took part by their recovered forces.
    aperiodic: Vec<usize>,
    /// Lines of all runs, with the forces that were recovered beside the contact.
    lines: Vec<RunLines>,
    /// Whether parameters differ between groups of runs.
    tests: Vec<Vec<GroupTest>>,
}

/// A law fitted to the loops recovered without a law.
struct Start {
    family: Family,
    /// Values to start from: the best minimum, then others.
    settings: Vec<Setting>,
    steps: Vec<Step>,
    error: f64,
    loops: ContactFit,
}

/// Identifies one law, or the best of several, on a measurement file.
pub(super) fn identify(
    measurement: &Measurement,
    families: &[Family],
    progress: &Progress,
) -> Result<Identification, StudyError> {
    progress.start(2 * families.len() as u64 + 1, "identify");
    let mut declared = case(measurement)?;
    recover_aperiodic(&mut declared, measurement)?;
    progress.step();
    let mut notes = Vec::new();
    let mut joints: Vec<Joint> = Vec::new();
    let mut unsolved = None;
    let conditions = conditions(measurement);
    let declared = Case { law: families[0], ..declared };
    let (first, blank) = match Study::new(&declared, Split::First) {
        Err(error @ ExplainError::NothingPeriodic { .. }) => {
            progress.finish();
            return without_periods(&declared, families, error);
        }
        study => study?,
    };
    for start in promising(starts((&declared, &first, &blank), families, progress)?, &mut notes) {
        let loops = start.loops.clone();
        let case = Case { law: start.family, ..declared.clone() };
        let fitted: Vec<(Family, &Setting)> =
            joints.iter().map(|joint| (joint.family, &joint.fitted.setting)).collect();
        let fitted = near(start.family, &fitted, &start.settings[0]);
        match study_of(&case, &first).and_then(|study| one_law(study, (start, &fitted), &conditions)) {
            Ok(joint) => joints.push(joint),
            Err(error) => unsolved = unsolved.or(Some((loops, error))),
        }
        progress.step();
    }
    progress.finish();
    if let (true, Some((loops, error))) = (joints.is_empty(), unsolved) {
        return Ok(from_loops_alone(&loops, &error, notes));
    }
    let candidates = joints.iter().map(|joint| Candidate {
        name: joint.family,
        criterion: joint.identified.information_criterion(),
        held_out: joint.held_out,
    });
    let ranking = rank(candidates.collect());
    let best = ranking.candidates.first().map(|c| c.name);
    let Some(joint) = joints.iter().find(|joint| Some(joint.family) == best) else {
        return Err(StudyError::UnknownLaw { name: String::new() });
    };
    let case = Case { law: joint.family, ..declared.clone() };
    let (mut study, _) = study_of(&case, &first)?;
    study.training.clone_from(&joint.training);
    study.model = study.model.with_runs(joint.lines.clone()).map_err(ExplainError::from)?;
    let mut found = described((measurement, &study), joint);
    let (dependence, differing) = groups::described(joint, &conditions, &joint.tests);
    found.dependence = dependence;
    found.notes.extend(differing);
    found.notes.extend(comparison(&ranking));
    found.notes.extend(notes);
    Ok(found)
}

/// The study of another law on the same runs, and its start.
fn study_of<'a>(case: &'a Case, first: &Study<'_>) -> Result<(Study<'a>, Setting), StudyError> {
    let (mut study, start) = Study::new(case, Split::First)?;
    study.training.clone_from(&first.training);
    Ok((study, start))
}

/// Every law on the loops recovered without a law.
fn starts(
    (declared, first, blank): (&Case, &Study<'_>, &Setting),
    families: &[Family],
    progress: &Progress,
) -> Result<Vec<Start>, StudyError> {
    let loops = Loops::new(declared, first, blank)?;
    let mut starts: Vec<Start> = Vec::new();
    for family in families {
        starts.push(from_loops((*family, families.len() > 1), (&loops, &starts), blank)?);
        progress.step();
    }
    Ok(starts)
}

/// Laws whose loops are not far worse than the best ones: others cannot win on the accelerations.
fn promising(starts: Vec<Start>, notes: &mut Vec<String>) -> Vec<Start> {
    let best = starts.iter().map(|s| s.error).fold(f64::INFINITY, f64::min);
    let (kept, dropped): (Vec<_>, Vec<_>) = starts.into_iter().partition(|s| s.error <= 3.0 * best);
    for start in dropped {
        notes.push(format!(
            "{} is ruled out by the recovered loops: force error {:.4} against {best:.4}",
            start.family.name(),
            start.error
        ));
    }
    kept
}

/// Step (v) for one law.
fn one_law(
    (mut study, own): (Study<'_>, Setting),
    (start, fitted): (Start, &[Setting]),
    conditions: &[Condition],
) -> Result<Joint, StudyError> {
    // Where the contact sticks a recovered slip is noise: a law without memory starts from what slides.
    let own_first = start.family.is_static().then_some(own.law);
    let laws = own_first.into_iter().chain(start.settings.iter().map(|s| s.law));
    let settings: Vec<Setting> = laws.map(|law| Setting { law, ..own.clone() }).collect();
    let found = joint::fit(&mut study, &settings, fitted)?;
    let judgement = judged::judged(&study, &found, conditions)?;
    let (fitted, aperiodic) = (found.fitted, found.aperiodic.runs);
    let (identified, tests) = (judgement.identified, judgement.tests);
    let mut steps = start.steps;
    steps.push(Step {
        name: "law and structure together against the accelerations".to_owned(),
        parameters: fitted.unknowns.iter().map(|u| u.parameter.name.clone()).collect(),
        error: study.error(&fitted, &study.training).relative(),
    });
    let held_out = study.error(&fitted, &study.held_out).ratio();
    let training = study.training.clone();
    let lines = study.model.runs;
    Ok(Joint { family: start.family, fitted, identified, steps, held_out, training, aperiodic, lines, tests })
}

/// Starts of a law on the recovered loops.
const STARTS: usize = 16;

/// Steps (i) to (iv): the law on motion and force of the contact recovered without a law.
///
/// A law without memory is fitted as the bristle whose stiff limit it is: where the contact sticks, the sign of a
/// recovered velocity is noise, and the bristle knows what to do there. In a comparison it must stand for itself.
fn from_loops(
    (family, compared): (Family, bool),
    (loops, others): (&Loops, &[Start]),
    blank: &Setting,
) -> Result<Start, StudyError> {
    let bristle = if compared { family } else { bristle(family) };
    let fitted = others.iter().map(|other| (other.loops.family, other.loops.law_values())).collect();
    let settings = ContactSettings { starts: STARTS, fitted, profiles: false, ..ContactSettings::default() };
    let first: Vec<&ContactHistory> = loops.histories.iter().chain(&loops.open).collect();
    let rough = identify_contact(bristle, &first, &settings)?;
    let filled = loops.filled(&rough);
    let used: Vec<&ContactHistory> = filled.iter().chain(&loops.open).collect();
    let fit = identify_contact(bristle, &used, &settings)?;
    let minima = std::iter::once(fit.law_values()).chain(fit.others.iter().cloned());
    let laws = minima.map(|values| begin((family, bristle), &values));
    let settings = laws.map(|law| Setting { law, ..blank.clone() }).collect();
    let steps = fit.steps.iter().map(|s| Step {
        name: s.name.clone(),
        parameters: s.parameters.clone(),
        error: s.error,
    });
    Ok(Start { family, settings, steps: steps.collect(), error: fit.error, loops: fit })
}

/// The bristle of which a law without memory is the stiff limit.
fn bristle(family: Family) -> Family {
    match family {
        Family::Coulomb => Family::Dahl,
        Family::Stribeck => Family::LuGre,
        other => other,
    }
}

/// The joint fits of laws that this one extends, as starts: law and structure of the fit, and neutral values (those of
/// `typical` where they are idle) for what only this law has.
fn near(family: Family, fitted: &[(Family, &Setting)], typical: &Setting) -> Vec<Setting> {
    let smaller = fitted.iter().filter(|(other, _)| family.extends(*other));
    smaller
        .map(|(other, setting)| {
            let own = family.nearest((*other, &other.values(&setting.law)), &family.values(&typical.law));
            Setting { law: interior(family.law(&own)), ..(*setting).clone() }
        })
        .collect()
}

/// The law that leaves least of recovered motion and force where no run is periodic.
fn without_periods(
    declared: &Case,
    families: &[Family],
    error: ExplainError,
) -> Result<Identification, StudyError> {
    let histories = aperiodic::histories(declared);
    let used: Vec<&ContactHistory> = histories.iter().collect();
    let settings = ContactSettings { starts: STARTS, profiles: false, ..ContactSettings::default() };
    let mut best: Option<ContactFit> = None;
    for family in families {
        let family = if families.len() > 1 { *family } else { bristle(*family) };
        let Ok(mut found) = identify_contact(family, &used, &settings) else { continue };
        let values = found.law_values();
        let model = ContactModel::new(family, used.clone(), &values, Extras::default());
        widen_to_accuracy(&model, &mut found.identified, aperiodic::ACCURACY, &[]);
        found.identified.settle(model.parameters(), IdentifySettings::default().widest);
        if best.as_ref().is_none_or(|best| found.error < best.error) {
            best = Some(found);
        }
    }
    let error = StudyError::from(error);
    best.map(|best| from_loops_alone(&best, &error, Vec::new())).ok_or(error)
}

/// A law to start the joint fit from: values of a bristle, of which the law may be the rigid limit.
fn begin((family, bristle): (Family, Family), values: &[f64]) -> ModifiedLaw<f64> {
    let value = |name: &str| {
        bristle.parameter_names().iter().position(|n| *n == name).and_then(|j| values.get(j).copied())
    };
    let own: Vec<f64> = family.parameter_names().iter().map(|name| value(name).unwrap_or_default()).collect();
    interior(family.law(&own))
}

/// The same law in the open interior of what the joint fit admits.
fn interior(mut law: ModifiedLaw<f64>) -> ModifiedLaw<f64> {
    for (hook, least) in [(Hook::StribeckRise, 1e-3), (Hook::StribeckVelocity, 1e-6)] {
        if let Some(value) = law.get(hook) {
            law.set(hook, value.max(least));
        }
    }
    law
}
