//! Runs in which no beam keeps to the motion that a balance follows.
//!
//! Near a fold of its characteristic the contact gives way and snaps, within a time that no line of a balance resolves
//! ([`AccelerationModel::stability_margin`](frettrace_forward::accelerations::AccelerationModel::stability_margin)). What such runs leave is no
//! evidence of an effect, and bends all that is fitted to them: where nothing explains all runs, the others are asked by themselves. A name
//! that explains them must bring the runs set aside nearer, too, to what a snap leaves. That nothing is missing is not said of a part of the runs.

use super::asked_again::answer;
use super::{Outcome, Place, Verdict};
use crate::{Case, ExplainError, Fitted, Study};
use frettrace_friction::effects::Hook;

/// Margin of stability below which a run is set aside: a fold of the contact (0) is nearer than an undisturbed beam (1) by a fifth. Right models
/// of simulated rigs leave noise where it is above 0.95, some more below that, and all more below 0.8.
const STEADY: f64 = 0.8;
/// Error over noise of all runs up to which what is left may be that of the runs set aside: with right laws their own was below it. From farther off
/// no law tells where a contact is near a fold.
const OF_A_SNAP: f64 = 10.0;
/// Fewest other runs that are asked by themselves: one of them is held out.
const LEAST_STEADY: usize = 4;

/// Explains a case.
///
/// # Errors
/// [`ExplainError`] where no run is periodic or the model cannot be evaluated at all.
pub fn explain(case: &Case) -> Result<Outcome, ExplainError> {
    let (mut found, study) = answer(case)?;
    let unexplained = found.verdict == Verdict::Unexplained && found.place == Some(Place::Contact);
    let all = study.all_runs();
    if !unexplained || study.error(&found.model.fitted, &all).ratio() > OF_A_SNAP {
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
