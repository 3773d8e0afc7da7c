//! Runs in which no beam keeps to the motion that a balance follows.
//!
//! Near a fold of its characteristic the contact gives way and snaps, within a time that no line of a balance resolves
//! ([`AccelerationModel::stability_margin`](frettrace_forward::accelerations::AccelerationModel::stability_margin)). What such runs leave is no
//! evidence of an effect, and bends all that is fitted to them: where nothing explains all runs, the others are asked by themselves. A name
//! that explains them must bring the runs set aside nearer, too, to what a snap leaves. That nothing is missing is not said of a part of the runs.
//!
//! A rigid contact may answer a run on more lines than a balance can have, above all where the motion repeats after several periods of
//! the excitation: what its grid may be wrong by is many times the noise then, and no law can be told in it. The others are asked by
//! themselves, and what is said is said of them. Where they have no name for what is missing and the finest grid resolves all runs, models that are corrected to
//! that are asked about all of them.
//!
//! One whose friction falls more steeply than the structure resists may have no balance at all with the law that its contacts show
//! ([`told_by_contacts`](super::by_contacts)): those runs are judged by what was recovered of them, and the others by themselves.

use super::asked_again::{Begun, answer, answer_from};
use super::{Outcome, Verdict};
use crate::search::NEAR;
use crate::{Case, ExplainError, Fitted, Split, Study};
use frettrace_friction::effects::Hook;

/// Margin of stability below which a run is set aside: a fold of the contact (0) is nearer than an undisturbed beam (1) by a fifth. Right models
/// of simulated rigs leave noise where it is above 0.95, some more below that, and all more below 0.8.
const STEADY: f64 = 0.8;
/// Error over noise of all runs up to which what is left may be that of the runs set aside: with right laws their own was below it. From farther off
/// no law tells where a contact is near a fold.
const OF_A_SNAP: f64 = 10.0;
/// Fewest other runs that are asked by themselves: one of them is held out.
const LEAST_STEADY: usize = 4;

/// Runs that a grid resolves, for each that it does not, from which these are special: a law that is far from the right one parts the grids in all.
const LEAST_RESOLVED: usize = 2;

/// Explains a case.
///
/// # Errors
/// [`ExplainError`] where no run is periodic or the model cannot be evaluated at all.
pub fn explain(case: &Case) -> Result<Outcome, ExplainError> {
    let begun = Begun::new(case, Split::First)?;
    if let Some(found) = beside_told_by_contacts(case, &begun) {
        return Ok(found);
    }
    let unresolved = few_unresolved(&begun);
    if let Some(found) = beside_unresolved(case, &begun, &unresolved) {
        if found.verdict == Verdict::Unexplained && begun.are_resolved_by_the_finest(&unresolved) {
            let (of_all, _) = answer_from(case, begun)?;
            if of_all.verdict != Verdict::Unexplained {
                return Ok(of_all);
            }
        }
        return Ok(found);
    }
    let (mut found, study) = answer_from(case, begun)?;
    let all = study.all_runs();
    if found.verdict != Verdict::Unexplained || study.error(&found.model.fitted, &all).ratio() > OF_A_SNAP {
        return Ok(found);
    }
    let aside = study.unsteady([&found.baseline.fitted, &found.model.fitted]);
    if aside.is_empty() {
        return Ok(found);
    }
    found.notes.push(format!(
        "in {} of {} runs the contact is near a fold of its characteristic, where a beam snaps and a balance does not: what they leave may be that",
        aside.len(),
        all.len()
    ));
    if all.len() - aside.len() < LEAST_STEADY {
        return Ok(found);
    }
    let aside = [&case.aside[..], &aside].concat();
    let steady = Case { aside, ..case.clone() };
    let asked = answer(&steady).ok().filter(|(other, study)| {
        let missed = |fitted: &Fitted| study.error(fitted, &steady.aside).ratio();
        let [before, after] = [&other.baseline, &other.model].map(|model| missed(&model.fitted));
        // A fault of a channel was seen in its samples.
        let nearer = other.model.effects.is_empty() || after < before;
        other.verdict == Verdict::Explained && nearer && after <= OF_A_SNAP
    });
    Ok(asked.map_or(found, |(other, _)| other))
}

/// What the runs of a case beside some come to.
fn explain_beside(case: &Case, runs: &[usize]) -> Option<Outcome> {
    let mut aside = [&case.aside[..], runs].concat();
    aside.sort_unstable();
    explain(&Case { aside, ..case.clone() }).ok()
}

/// What the runs beside those that the contacts tell of come to; `None` where there are none of these, too few others, or the others lack something
/// that has no name.
fn beside_told_by_contacts(case: &Case, begun: &Begun<'_>) -> Option<Outcome> {
    let told = begun.told_by_contacts();
    if told.is_empty() || begun.runs() - told.len() < LEAST_STEADY {
        return None;
    }
    let mut found = explain_beside(case, told)?;
    found.notes.push(format!(
        "in {} of {} runs no balance of the rigid contact answers with the law that the recovered contacts show: its friction falls with speed more steeply than the structure resists; the law meets the force and the motion recovered of them, and no waveform is compared",
        told.len(),
        begun.runs()
    ));
    (found.verdict != Verdict::Unexplained).then_some(found)
}

/// The runs that a grid does not resolve, where these are few: none where it resolves all, or too many are not.
fn few_unresolved(begun: &Begun<'_>) -> Vec<usize> {
    let unresolved = begun.unresolved();
    let resolved = begun.runs() - unresolved.len();
    let few = resolved >= LEAST_STEADY && resolved >= LEAST_RESOLVED * unresolved.len();
    if few { unresolved } else { Vec::new() }
}

/// What the runs beside the unresolved ones tell; `None` where there is none of those.
fn beside_unresolved(case: &Case, begun: &Begun<'_>, unresolved: &[usize]) -> Option<Outcome> {
    if unresolved.is_empty() {
        return None;
    }
    let mut found = explain_beside(case, unresolved)?;
    // That nothing is missing is said where the declared model follows all that it was fitted to, and misses runs held out alone.
    if found.verdict == Verdict::NothingMissing && !begun.follows_fitted() {
        return None;
    }
    // What has no name is not told better by more runs.
    if found.verdict != Verdict::Unexplained && begun.shows_more(&found.model.fitted, unresolved) {
        return None;
    }
    found.notes.push(format!(
        "in {} of {} runs the phase grid may be wrong by more than {NEAR} times the noise: the balance of a rigid contact does not resolve them, and no model is compared with them",
        unresolved.len(),
        begun.runs()
    ));
    Some(found)
}

impl Study<'_> {
    /// Runs in which the settled motion of one of two models is near a fold. Where no bristle is damped, none gives way.
    fn unsteady(&self, models: [&Fitted; 2]) -> Vec<usize> {
        let runs = self.all_runs();
        let mut found = Vec::new();
        for fitted in models.into_iter().filter(|fitted| fitted.setting.law.get(Hook::Sigma1).is_some()) {
            let mut memory = fitted.memory.clone();
            let margins =
                self.model.stability_margin(&fitted.setting, &runs, &mut memory).unwrap_or_default();
            let near = |margin: Option<f64>| margin.is_some_and(|margin| margin < STEADY);
            found.extend(runs.iter().zip(margins).filter(|(_, margin)| near(*margin)).map(|(run, _)| *run));
        }
        found.sort_unstable();
        found.dedup();
        found
    }
}
