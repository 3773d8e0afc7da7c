//! Controls: the same search, asked where the answer is known.
//!
//! *Surrogates*: the declared model at its fit, `y = ŷ(θ) + ε` with `ε` drawn anew on every line at its standard deviation. An
//! effect named there is a false alarm.
//!
//! *Left out*: the data as they are, with the named effects taken out of the list. Right is `unexplained`, or a name that the
//! effect is known to be mistaken for: with the better one out of the way it may well be complete.
//!
//! *Injections*: the model with the named effects at full and at half size (each value that measures a size goes the stated
//! share of the way from where it does nothing), with noise drawn anew. Right is the same names, or their class.
//!
//! Runs that are not periodic have no lines to draw, and channels no faults: both are left out of what is drawn.

use crate::effects::{ALL, listed};
use crate::records::power;
use crate::verdict::{Named, Outcome, Place, Verdict, explain};
use crate::{Case, ExplainError, RunRecord, Unknown};
use frettrace_forward::accelerations::{AccelerationModel, Prediction, Quantity, Setting};
use frettrace_friction::effects::Hook;
use num_complex::Complex64;
use rand_distr::{Distribution, StandardNormal};
use rand_pcg::Pcg64;
use rayon::prelude::*;

/// What was asked.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Question {
    /// The declared model and noise.
    Surrogate,
    /// The data, without the named effects in the list.
    LeftOut,
    /// The explaining model and noise, its effects at a share of their size.
    Injection(f64),
}

/// One control.
#[derive(Clone, Debug, PartialEq)]
pub struct Control {
    /// What was asked.
    pub question: Question,
    /// The verdict.
    pub verdict: Verdict,
    /// Effects named.
    pub named: Vec<&'static str>,
    /// Place of what is missing.
    pub place: Option<Place>,
    /// Whether that is the right answer.
    pub right: bool,
}

/// Share of its size at which an effect is injected beside the full one.
const HALF: f64 = 0.5;

/// Runs `surrogates` surrogates and, where effects are named, the other two kinds. A control whose data cannot be drawn or
/// explained at all is missing.
///
/// # Errors
/// [`ExplainError`] where the model of the case cannot be evaluated.
pub fn controls(
    case: &Case,
    outcome: &Outcome,
    surrogates: usize,
    seed: u64,
) -> Result<Vec<Control>, ExplainError> {
    let mut questions = vec![Question::Surrogate; surrogates];
    let injectable = !outcome.model.effects.is_empty();
    if outcome.verdict == Verdict::Explained {
        questions.push(Question::LeftOut);
        questions.extend([1.0, HALF].into_iter().filter(|_| injectable).map(Question::Injection));
    }
    let periodic: Vec<RunRecord> = case.records.iter().filter(|r| r.periodic).cloned().collect();
    let clean = Case { records: periodic, faults: Vec::new(), ..case.clone() };
    let lines = clean.records.iter().map(|r| r.lines.clone()).collect();
    let model = AccelerationModel::new(case.rig.clone(), lines)?;
    let asked = questions.par_iter().enumerate().filter_map(|(index, &question)| {
        let drawn = match question {
            Question::LeftOut => left_out(case, outcome),
            Question::Surrogate => {
                let setting = &outcome.baseline.fitted.setting;
                declared_as_made(drawn(&clean, &model, setting, random(seed, index))?, setting)
            }
            Question::Injection(share) => {
                drawn(&clean, &model, &shrunk(outcome, share), random(seed, index))?
            }
        };
        let found = explain(&drawn).ok()?;
        Some(Control::of(question, outcome, &found))
    });
    Ok(asked.collect())
}

/// A stream of its own for every control.
fn random(seed: u64, index: usize) -> Pcg64 {
    Pcg64::new(u128::from(seed), index as u128)
}

impl Control {
    fn of(question: Question, outcome: &Outcome, found: &Outcome) -> Self {
        let named: Vec<&'static str> = found.effects.iter().map(|e| e.id).collect();
        // A name stands for itself and for those that it was said not to be told from.
        let of_class =
            |id: &str| outcome.effects.iter().any(|e| e.id == id || e.indistinguishable.contains(&id));
        let right = match question {
            Question::Surrogate => named.is_empty(),
            Question::LeftOut => {
                let mistaken = |id: &str| {
                    let effect = |e: &Named| listed(e.id).map(|effect| ALL[effect]);
                    outcome.effects.iter().filter_map(effect).any(|e| e.rivals().contains(&id))
                };
                named.iter().all(|id| of_class(id) || mistaken(id))
                    && found.verdict != Verdict::NothingMissing
            }
            Question::Injection(_) => {
                named.len() == outcome.effects.len() && named.iter().all(|id| of_class(id))
            }
        };
        Self { question, verdict: found.verdict, named, place: found.place, right }
    }
}

fn left_out(case: &Case, outcome: &Outcome) -> Case {
    let mut without = case.clone();
    without.without.extend(outcome.effects.iter().map(|e| e.id.to_owned()));
    without
}

/// The case with predictions and noise in the place of its data; `None` where a run has no solution.
fn drawn(clean: &Case, model: &AccelerationModel, setting: &Setting, mut random: Pcg64) -> Option<Case> {
    let runs: Vec<usize> = (0..clean.records.len()).collect();
    let predicted = model.approach(setting, &runs, &mut model.memory()).ok()?;
    let mut made = clean.clone();
    for (record, prediction) in made.records.iter_mut().zip(predicted) {
        redraw(record, prediction, &mut random);
    }
    Some(made)
}

/// A case that is declared as it was made: what the declared model lacks has bent its structure, and a surrogate of it lacks nothing.
fn declared_as_made(mut made: Case, setting: &Setting) -> Case {
    made.modes.frequency.clone_from(&setting.frequency);
    made.modes.damping.clone_from(&setting.damping);
    made
}

fn redraw(record: &mut RunRecord, prediction: Prediction, random: &mut Pcg64) {
    record.unsilence();
    let deviations = &record.lines.deviation;
    let mut normal = || -> f64 { StandardNormal.sample(random) };
    for (s, lines) in prediction.into_iter().enumerate() {
        let noisy = lines.into_iter().zip(&deviations[s]).enumerate().map(|(h, (line, std))| {
            let noise = Complex64::new(normal(), if h == 0 { 0.0 } else { normal() });
            line + noise * *std
        });
        record.lines.acceleration[s] = noisy.collect();
        record.power[s] = power(record.lines.acceleration[s].iter().copied()) + record.beside[s];
        record.excess[s] = 0.0;
    }
}

/// The explaining model with its effects at a share of their size.
fn shrunk(outcome: &Outcome, share: f64) -> Setting {
    let mut setting = outcome.model.fitted.setting.clone();
    let declared = &outcome.baseline.fitted.setting;
    let added = &outcome.model.added;
    for unknown in added {
        let (Some(value), Some(nothing)) =
            (setting.get(unknown.quantity), nothing(unknown.quantity, declared, added))
        else {
            continue;
        };
        setting.set(unknown.quantity, nothing + share * (value - nothing));
    }
    setting
}

/// Value at which a quantity does nothing, where it measures the size of an effect; `None` for shapes, places and times.
fn nothing(quantity: Quantity, declared: &Setting, added: &[Unknown]) -> Option<f64> {
    match quantity {
        // A lag of a curve that came with it has the size of the curve.
        Quantity::Law(Hook::LagTime | Hook::SpeedLag | Hook::VelocityLag) => {
            let rise = added.iter().any(|u| u.quantity == Quantity::Law(Hook::StribeckRise));
            (!rise).then_some(0.0)
        }
        Quantity::Law(hook) => hook.nothing(),
        Quantity::ModeFrequency(_) | Quantity::ModeDamping(_) => declared.get(quantity),
        Quantity::Gain(_) => Some(1.0),
        Quantity::PortPosition(_) | Quantity::MassPosition | Quantity::ContactCompliance => None,
        Quantity::DriftRate | Quantity::DriftSlowing => None,
        _ => Some(0.0),
    }
}

#[cfg(test)]
mod tests {
    use super::ALL;

    /// Every hook that an effect brings either has a size or is brought with one that has.
    #[test]
    fn every_effect_of_the_law_has_a_size() {
        use frettrace_friction::effects::ModifiedLaw;
        let law = ModifiedLaw::dahl(1e5, 0.3);
        let scales =
            crate::Scales { slip: 1e-5, velocity: 1e-3, period: 0.05, preload: 50.0, ..Default::default() };
        for effect in ALL {
            for form in effect.contact_forms(&law, &scales) {
                let sized =
                    form.changes.iter().filter(|c| c.parameter.is_some()).any(|c| c.hook.nothing().is_some());
                assert!(sized, "{}", effect.id());
            }
        }
    }
}
