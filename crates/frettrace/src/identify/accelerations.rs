//! A measurement file: the law and the structure against the accelerations themselves.

mod described;
mod joint;

use super::contact_record::comparison;
use crate::case::case;
use crate::results::{Identification, Step};
use crate::{Progress, StudyError};
use described::{described, from_loops_alone};
use frettrace_explain::{Case, ExplainError, Fitted, Study, histories};
use frettrace_forward::accelerations::Setting;
use frettrace_friction::effects::Hook;
use frettrace_identify::Identified;
use frettrace_identify::contact::{ContactFit, ContactHistory, ContactSettings, Family, identify_contact};
use frettrace_identify::evidence::{Candidate, rank};
use frettrace_measurement::Measurement;

/// A law with the structure, fitted and judged.
struct Joint {
    family: Family,
    fitted: Fitted,
    identified: Identified,
    steps: Vec<Step>,
    held_out: f64,
    training: Vec<usize>,
}

/// A law fitted to the loops recovered without a law.
struct Start {
    family: Family,
    setting: Setting,
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
    let declared = case(measurement)?;
    progress.step();
    let mut notes = Vec::new();
    let mut joints = Vec::new();
    let mut unsolved = None;
    for start in promising(starts(&declared, families, progress)?, &mut notes) {
        let loops = start.loops.clone();
        match one_law(&declared, start, families.len() > 1) {
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
    let case = Case { law: joint.family, ..declared };
    let (mut study, _) = Study::new(&case)?;
    study.training.clone_from(&joint.training);
    let mut found = described((measurement, &study), joint);
    found.notes.extend(comparison(&ranking));
    found.notes.extend(notes);
    Ok(found)
}

/// Every law on the loops recovered without a law.
fn starts(declared: &Case, families: &[Family], progress: &Progress) -> Result<Vec<Start>, StudyError> {
    let case = Case { law: families[0], ..declared.clone() };
    let (study, setting) = Study::new(&case)?;
    let loops = histories(&case, &study.model, &setting, &study.training).map_err(ExplainError::from)?;
    let mut starts = Vec::new();
    for family in families {
        starts.push(from_loops(*family, &loops, &setting)?);
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
fn one_law(declared: &Case, start: Start, compared: bool) -> Result<Joint, StudyError> {
    let case = Case { law: start.family, ..declared.clone() };
    let (mut study, _) = Study::new(&case)?;
    let fitted = joint::fit(&mut study, start.setting, compared)?;
    let identified = joint::judged(&study, &fitted)?;
    let mut steps = start.steps;
    steps.push(Step {
        name: "law and structure together against the accelerations".to_owned(),
        parameters: fitted.unknowns.iter().map(|u| u.parameter.name.clone()).collect(),
        error: study.error(&fitted, &study.training).relative(),
    });
    let held_out = study.error(&fitted, &study.held_out).ratio();
    let training = study.training.clone();
    Ok(Joint { family: start.family, fitted, identified, steps, held_out, training })
}

/// Steps (i) to (iv): the law on motion and force of the contact recovered without a law.
fn from_loops(family: Family, loops: &[ContactHistory], blank: &Setting) -> Result<Start, StudyError> {
    let used: Vec<&ContactHistory> = loops.iter().collect();
    let settings = ContactSettings { starts: 6, profiles: false, ..ContactSettings::default() };
    let fit = identify_contact(family, &used, &settings)?;
    let mut law = family.law(&fit.law_values());
    if family.is_static() {
        // A law without memory is the limit of a stiff bristle: a fiftieth of the smallest slip to full friction.
        let reach = loops.iter().map(ContactHistory::amplitude).fold(f64::INFINITY, f64::min);
        law.set(Hook::Sigma0, 50.0 * fit.law_values()[0] / reach.max(1e-12));
    }
    // Starts in the open interior of what the joint fit admits.
    for (hook, least) in [(Hook::StribeckRise, 1e-3), (Hook::StribeckVelocity, 1e-6)] {
        if let Some(value) = law.get(hook) {
            law.set(hook, value.max(least));
        }
    }
    let loops = fit.clone();
    let steps =
        fit.steps.into_iter().map(|s| Step { name: s.name, parameters: s.parameters, error: s.error });
    Ok(Start {
        family,
        setting: Setting { law, ..blank.clone() },
        steps: steps.collect(),
        error: fit.error,
        loops,
    })
}
