//! What is said in the end: verdict, names, place, errors and what a reader must know.

mod borne_out;
mod names;
mod remarks;
mod stands_in;

pub(crate) use names::faulty;

use super::rules::{stays_with_contact, takes_all, takes_both};
use super::{BALANCE_CALIBRATED, Search};
use crate::effects::{ALL, EffectPlace};
use crate::left::LeftLines;
use crate::search::{Explained, OTHER_FORMULA, REST, excess};
use crate::{ChannelFault, RunError, Unknown};

/// The outcome.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// The declared model says all that the data say.
    NothingMissing,
    /// With the named effects the model is complete.
    Explained,
    /// Something is missing that is in no list.
    Unexplained,
}

/// Where something is missing.
pub use crate::effects::EffectPlace as Place;

/// A named effect.
#[derive(Clone, Debug)]
pub struct Named {
    /// Its id.
    pub id: &'static str,
    /// Probability against the best rival, from the difference of the criteria.
    pub probability: f64,
    /// Position on the beam (m).
    pub position: Option<f64>,
    /// Index of the sensor.
    pub sensor: Option<usize>,
    /// What it brought: name, unit, value, standard deviation.
    pub parameters: Vec<(String, String, f64, f64)>,
    /// Ids that the data cannot tell from it.
    pub indistinguishable: Vec<&'static str>,
    /// The experiment that would.
    pub experiment: &'static str,
}

/// A candidate that was tried.
#[derive(Clone, Copy, Debug)]
pub struct Tried {
    /// Its id.
    pub id: &'static str,
    /// Relative RMS error with it on the training runs; NaN where it was judged on the recovered contact alone.
    pub error: f64,
    /// Difference of the criterion to the model without it, positive for it.
    pub evidence: f64,
}

/// What came of an explanation.
pub struct Outcome {
    /// The verdict.
    pub verdict: Verdict,
    /// Named effects.
    pub effects: Vec<Named>,
    /// Where something is missing.
    pub place: Option<Place>,
    /// The declared model.
    pub baseline: Explained,
    /// The model with the effects in it.
    pub model: Explained,
    /// All candidates, best first.
    pub tried: Vec<Tried>,
    /// Errors of the training runs before and after.
    pub error: [RunError; 2],
    /// Errors of the held-out runs before and after.
    pub held_out: Option<[RunError; 2]>,
    /// Indices of the training and of the held-out runs.
    pub runs: [Vec<usize>; 2],
    /// Indices of the runs that are neither, because no beam keeps to the motion that the model has in them, or no phase grid to the beam's.
    pub aside: Vec<usize>,
    /// Indices of the runs whose motion the balance of the declared model does not have: none at all, or none near one that repeats after several
    /// periods of the excitation. They are told where the contact lacks what has no name.
    pub unanswered: Vec<usize>,
    /// What a reader must know.
    pub notes: Vec<String>,
}

impl Search<'_> {
    pub(super) fn outcome(mut self, mut baseline: Explained, mut model: Explained) -> Outcome {
        if !model.complete() && self.traces_a_curve(&model) {
            model = self.sharpened(model, LeftLines::is_noise, Self::traces_a_curve);
        }
        let within_grid = if model.complete() { None } else { self.within_grid(&model) };
        let by_grid = within_grid.is_some();
        if let Some(doubted) = within_grid {
            self.notes.push(format!(
                "what is left, {:.2} times the noise, is no more than the phase grid of the rigid contact's balance may be wrong by",
                doubted.ratio
            ));
            model = doubted;
        }
        let borne_out = self.borne_out_on_its_grid(&baseline, &mut model);
        let faults = &self.study.case.faults;
        let named: Vec<&ChannelFault> = faults.iter().filter(|f| self.study.case.allows(f.id)).collect();
        let nameless = named.len() < faults.len();
        let shaken = self.study.case.shaken;
        let by_method = by_grid || self.within_method && model.effects.is_empty();
        let within = model.complete() && self.takes_all(&baseline, &model);
        let by_curve = !within && self.leaves_a_curve(&model);
        let near = within || model.sufficient(&baseline) || self.other_formula || by_method || by_curve;
        let filled = near && borne_out;
        let misread = filled && self.misread(&model);
        let contradicted = self.series_contradicts(&model);
        let stands_in = filled && self.stands_in(&mut model);
        let told = self.tells_both(&baseline, &model);
        let complete = filled
            && !nameless
            && shaken.is_none()
            && !self.strained
            && !misread
            && !contradicted
            && !stands_in
            && told;
        let verdict = match (model.effects.is_empty() && named.is_empty(), complete) {
            (true, true) => Verdict::NothingMissing,
            (false, true) => Verdict::Explained,
            _ => Verdict::Unexplained,
        };
        let place = match verdict {
            Verdict::NothingMissing => None,
            Verdict::Explained if model.effects.is_empty() => Some(EffectPlace::Measurement),
            Verdict::Explained => model.effects.first().map(|&e| ALL[e].place()),
            Verdict::Unexplained if shaken.is_some() && filled => Some(EffectPlace::Excitation),
            Verdict::Unexplained if misread || nameless && filled => Some(EffectPlace::Measurement),
            Verdict::Unexplained if self.strained => Some(EffectPlace::Structure),
            Verdict::Unexplained => Some(self.place(&baseline, &model)),
        };
        let alike = baseline.fitted.fit.values == model.fitted.fit.values;
        self.study.doubt_values(&mut model);
        if alike {
            baseline.fitted.deviation.clone_from(&model.fitted.deviation);
        }
        let effects: Vec<Named> = if verdict == Verdict::Explained {
            named.iter().map(|fault| faulty(fault)).chain(self.named(&model)).collect()
        } else {
            Vec::new()
        };
        if verdict == Verdict::Unexplained && self.worse(&baseline, &model) {
            self.notes.push("what was tried last made held-out runs worse: it is not in the model".into());
            model = baseline.clone();
        }
        self.tried.extend(faults.iter().map(|fault| Tried {
            id: fault.id,
            error: f64::NAN,
            evidence: fault.evidence,
        }));
        self.tried.sort_by(|a, b| b.evidence.total_cmp(&a.evidence));
        self.remark(&baseline, &model);
        let nameless_in_contact = verdict == Verdict::Unexplained && place == Some(EffectPlace::Contact);
        let unanswered =
            if nameless_in_contact { self.study.unanswered(&baseline.fitted) } else { Vec::new() };
        let after = self.errors(&model);
        let errors = |k: usize| Some([*self.before.get(k)?, *after.get(k)?]);
        Outcome {
            verdict,
            effects,
            place,
            error: errors(0).unwrap_or_default(),
            held_out: errors(1),
            runs: [self.study.training.clone(), self.study.held_out.clone()],
            aside: self.study.case.aside.clone(),
            unanswered,
            tried: self.tried,
            notes: self.notes,
            baseline,
            model,
        }
    }

    /// Whether the names of a complete model leave nothing of what was missing: the noise of the lines, or a trace. What stands in for a
    /// weak effect comes within the noise of all samples and leaves a part of the effect beside that of the lines.
    pub(super) fn takes_all(&self, baseline: &Explained, model: &Explained) -> bool {
        self.claimed(model) == 0 || takes_all(model.left(), [baseline, model].map(Explained::excess))
    }

    /// Whether what two named effects leave speaks for both, where nothing else does: of one outside the contact's law and one in it the balance tells the former without a law,
    /// and the recovered contacts the latter. What the grid of a rigid contact leaves says nothing.
    fn tells_both(&self, baseline: &Explained, model: &Explained) -> bool {
        let in_law = |place: usize| model.own(place).iter().any(Unknown::is_of_law);
        let alike = self.claimed(model) == 2 && in_law(0) == in_law(1) && !model.fitted.setting.rigid;
        !alike || takes_both(model.left(), [baseline, model].map(Explained::excess))
    }

    /// Whether a sensor that saturates is all that a model misses: its lines are compared with nothing, and all others hold noise. The curve by
    /// which it bends here is another one.
    fn leaves_a_curve(&mut self, model: &Explained) -> bool {
        let found = self.traces_a_curve(model) && model.left().is_noise();
        if found {
            self.notes.push(format!(
                "the sensor that saturates leaves {:.2} times the noise in the worst training run: the curve by which it bends is another one, but all other lines hold noise",
                model.worst
            ));
        }
        found
    }

    /// Whether a model with a sensor that saturates leaves no more than a trace of what that read wrong.
    pub(super) fn traces_a_curve(&self, model: &Explained) -> bool {
        model.worst <= OTHER_FORMULA && self.is_trace_of_a_curve(0, model.excess())
    }

    /// Whether an excess of the training runs (0) or of those held out (1) is a trace of what a sensor that saturates read wrong in them.
    fn is_trace_of_a_curve(&self, runs: usize, left: f64) -> bool {
        let saturates = self.study.case.faults.iter().any(|fault| fault.id == "measurement.clipping");
        saturates && self.before.get(runs).is_some_and(|read| left <= REST * excess(read.ratio()))
    }

    /// How many of a model's effects were fitted: every run in which the support lifts off bears that out by itself.
    fn claimed(&self, model: &Explained) -> usize {
        model.effects.len() - usize::from(self.lifts_off)
    }

    /// Whether runs that nothing was fitted to are predicted worse than by the declared model.
    fn worse(&self, baseline: &Explained, model: &Explained) -> bool {
        let error = |of: &Explained| self.study.error(&of.fitted, &self.study.held_out).error;
        !self.study.held_out.is_empty() && error(model) > error(baseline)
    }

    /// Place of what stays unexplained: an open balance is never the contact, whatever closes it without a name. One that is closed by what is usual, yet
    /// not by what the noise allows, is the contact's unless one more free value a line takes most of that.
    fn place(&self, baseline: &Explained, model: &Explained) -> EffectPlace {
        let mut model = model.clone();
        self.calibrate(&mut model);
        let outside = shared_place(&model).filter(|&place| place != EffectPlace::Contact);
        let stands_in = outside.is_some() && self.is_open(baseline);
        let (reduced, _) = self.study.balance_reduced(&model.fitted.setting);
        if reduced <= BALANCE_CALIBRATED && !stands_in {
            return EffectPlace::Contact;
        }
        let closed = self.closed(&model.fitted.setting);
        // Effects that are not named may have bent the structure to what is missing: it is asked where the declared one leaves more than the noise.
        let (mut place, mut left) = self.study.open_place(&self.declared_start(&model));
        if left > BALANCE_CALIBRATED && !model.effects.is_empty() {
            let bent = self.study.open_place(&model.fitted.setting);
            if bent.1 < left {
                (place, left) = bent;
            }
        }
        if closed && !stands_in && stays_with_contact(reduced, left) {
            return EffectPlace::Contact;
        }
        // What stands in for all but a trace of what opened the balance leaves nothing of another place.
        outside.filter(|_| stands_in && model.leaves_a_trace(baseline)).unwrap_or(place)
    }
}

/// The place that the effects of a model share.
fn shared_place(model: &Explained) -> Option<EffectPlace> {
    let mut places = model.effects.iter().map(|&effect| ALL[effect].place());
    let first = places.next()?;
    places.all(|place| place == first).then_some(first)
}
