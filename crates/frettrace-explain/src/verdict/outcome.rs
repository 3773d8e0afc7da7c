//! What is said in the end: verdict, names, place, errors and what a reader must know.

use super::choice::contained;
use super::finer::RIGID_ACCURACY;
use super::rules::{
    helps, is_as_near, is_followed, may_be, stays_with_contact, stays_with_sensor, takes_all, takes_both,
    takes_its_own,
};
use super::{BALANCE_CALIBRATED, BORNE_OUT, EVIDENCE, FORETOLD, HELD_OUT, Rival, Search};
use crate::effects::{ALL, EffectPlace, listed};
use crate::left::LeftLines;
use crate::search::{Explained, OTHER_FORMULA, REST, excess};
use crate::study::as_declared;
use crate::{ChannelFault, RunError, Unknown};
use frettrace_forward::accelerations::Quantity;
use frettrace_friction::effects::Hook;

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
        self.remark_refused();
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

    /// Whether runs held out bear out the names of a model, which are asked on a finer grid where they do not, or where what is left speaks against a
    /// name, and the lines hold more than their noise: values that were bent to what a grid cuts short follow the fitted runs alone.
    fn borne_out_on_its_grid(&mut self, baseline: &Explained, model: &mut Explained) -> bool {
        let (said, grid) = (self.notes.len(), self.refined);
        let found = self.borne_out(baseline, model);
        let stands = found && self.takes_all(baseline, model) && self.tells_both(baseline, model);
        if stands || self.claimed(model) == 0 || !model.complete() {
            return found;
        }
        *model = self.sharpened(model.clone(), LeftLines::is_noise, |_, sharper| sharper.complete());
        if self.refined == grid {
            return found;
        }
        self.notes.truncate(said);
        self.borne_out(baseline, model)
    }

    /// Whether runs that nothing was fitted to bear out what is named: by its standard error, and by a real share of what was
    /// missing in them.
    fn borne_out(&mut self, baseline: &Explained, model: &Explained) -> bool {
        let held_out = &self.study.held_out;
        if held_out.is_empty() {
            return true;
        }
        if self.deviates {
            self.notes.push(
                "no error shows what is named: a natural frequency lies farther from the declared one than its deviation lets it be by chance".into(),
            );
            return self.study.error(&model.fitted, held_out).ratio() <= BORNE_OUT;
        }
        if self.claimed(model) == 0 {
            let error = self.study.error(&model.fitted, held_out);
            if self.of_one_law {
                self.notes.push(of_one(error.ratio()));
                return true;
            }
            let by_curve = model.left().is_noise() && self.is_trace_of_a_curve(1, excess(error.ratio()));
            return error.ratio() <= BORNE_OUT
                || by_curve
                || self.within_method && self.by_method(model, held_out);
        }
        let ratio = |of: &Explained| self.study.error(&of.fitted, held_out).ratio();
        let unbent = self.unbent_baseline(baseline).filter(|unbent| ratio(unbent) < ratio(baseline));
        // The error of all samples may be the noise of a weak run: what the lines hold must be so, too, or the balance's.
        let foretells = |unbent: &Explained| ratio(unbent) <= FORETOLD && self.by_method(unbent, held_out);
        if unbent.as_ref().is_some_and(foretells) {
            self.notes.push(
                "the declared law as the recovered contacts show it foretells the runs held out within the noise: they bear out no effect".into(),
            );
            return false;
        }
        let baseline = unbent.as_ref().unwrap_or(baseline);
        let found = self.study.improvement(&baseline.fitted, &model.fitted, held_out);
        self.notes
            .push(format!("held-out runs improve by {found:.1} standard errors; a claim needs {HELD_OUT}"));
        let [before, after] = [baseline, model].map(ratio);
        // Where the formula is another one, these runs must be as near as those that were fitted.
        if !helps(found, [before, after]) {
            return false;
        }
        match self.other_formula {
            true => is_as_near(before, after),
            false => {
                (is_followed(before, after) || self.is_of_one_model(model, after))
                    && self.needs_each(model, after)
            }
        }
    }

    /// Whether each of two effects takes what the runs held out miss without it, by the error over the noise that both leave there. That the stronger one
    /// took nearly all of what was missing says nothing of the other.
    fn needs_each(&self, model: &Explained, after: f64) -> bool {
        let two = model.effects.len() > 1 && !self.lifts_off;
        // What cannot be taken out, or leaves a run without an answer, is needed.
        let taken = |place: usize| {
            let Some(without) = self.study.without(model, place) else { return true };
            let before = self.study.error(&without.fitted, &self.study.held_out).ratio();
            takes_its_own(before, after)
        };
        !two || after <= FORETOLD || (0..model.effects.len()).all(taken)
    }

    /// The declared model of a rigid contact as its recovered contacts and the balance show it, without a fit: where the balance of one fitted run
    /// has no answer, or another one, than was measured, a fit bends the model, and any effect that mends this improves runs that the
    /// unbent model foretells.
    fn unbent_baseline(&self, baseline: &Explained) -> Option<Explained> {
        if !baseline.fitted.setting.rigid {
            return None;
        }
        let mut setting = self.declared_start(baseline);
        setting.law = self.recovered_law.unwrap_or(setting.law);
        self.study.blank(setting, &[]).ok()
    }

    /// Whether one set of values of a model, by which held-out runs are helped but not followed, follows all runs, and leaves no more beside
    /// the noise of their lines than that is: what was missed is what the fitted runs do not tell of the values. Two effects have enough values to
    /// follow what is neither.
    fn is_of_one_model(&mut self, model: &Explained, after: f64) -> bool {
        let joint = || self.study.jointly(model);
        let single = self.claimed(model) == 1;
        let follows = single && model.complete() && joint().is_some_and(|joint| joint.left().is_near_noise());
        if follows {
            self.notes.push(of_one(after));
        }
        follows
    }

    /// What an effect of the model is that shows nothing of what its name says: of a wave along the path less than one is travelled. It is the
    /// simpler one that it becomes then, under that one's name (`Ok`); where there is none in the list, it stands in for what has no name.
    /// `None` where it shows what it says.
    fn idle(&self, model: &Explained, place: usize) -> Option<Result<usize, &'static str>> {
        let (law, effect) = (&model.fitted.setting.law, model.effects[place]);
        if !ALL[effect].is_idle(law, self.reach()) {
            return None;
        }
        // What brought its own curve with a memory is the curve without one.
        let has_curve = model.own(place).iter().any(|u| u.quantity == Quantity::Law(Hook::StribeckRise));
        let curve = has_curve.then_some("friction.stribeck");
        let simpler =
            ALL[effect].simpler(law, &self.study.scales).into_iter().map(|simpler| simpler.id).chain(curve);
        let mut named = simpler.filter(|id| self.study.case.allows(id)).filter_map(listed);
        Some(named.find(|&other| contained(Some(&effect), other)).ok_or(ALL[effect].id()))
    }

    /// Whether an effect of the model stands in for what has no name.
    pub(super) fn shows_nothing(&self, model: &Explained) -> bool {
        (0..model.effects.len()).any(|place| matches!(self.idle(model, place), Some(Err(_))))
    }

    /// The same, with what is only the simpler one that it becomes under that one's name.
    fn stands_in(&mut self, model: &mut Explained) -> bool {
        let mut nameless = None;
        for place in 0..model.effects.len() {
            match self.idle(model, place) {
                Some(Ok(other)) => {
                    self.renamed.push((place, std::mem::replace(&mut model.effects[place], other)))
                }
                Some(Err(id)) => nameless = Some(id),
                None => {}
            }
        }
        if let Some(id) = nameless {
            self.notes.push(format!(
                "{id} takes what is missing, but shows nothing of what it says: it stands in for what is in no list"
            ));
        }
        nameless.is_some()
    }

    /// Whether a sensor that has a named fault with one formula only is still the one that the model misses: it has another fault.
    fn misread(&mut self, model: &Explained) -> bool {
        let exact = model.effects.iter().zip(&model.sensors).filter(|(effect, _)| ALL[**effect].is_exact());
        // A slow sensor's filter need not be of first order.
        let slow = |sensor: &usize| model.added.iter().any(|u| u.quantity == Quantity::Lag(*sensor));
        let sensors: Vec<usize> = exact.filter_map(|(_, sensor)| *sensor).filter(|s| !slow(s)).collect();
        let left = |sensor: usize| self.study.left_at(&model.fitted, sensor);
        let misread = sensors.into_iter().find(|&sensor| stays_with_sensor(left(sensor)));
        if let Some(sensor) = misread {
            self.notes.push(format!("sensor {sensor} is still read wrong beyond the noise, and no other is"));
        }
        misread.is_some()
    }

    /// Whether runs that nothing was fitted to are predicted worse than by the declared model.
    fn worse(&self, baseline: &Explained, model: &Explained) -> bool {
        let error = |of: &Explained| self.study.error(&of.fitted, &self.study.held_out).error;
        !self.study.held_out.is_empty() && error(model) > error(baseline)
    }

    /// What a reader must know.
    fn remark(&mut self, baseline: &Explained, model: &Explained) {
        let untrusted = self.study.case.records.iter().map(|r| r.untrusted).fold(0.0, f64::max);
        if untrusted > 0.0 {
            self.notes.push(format!(
                "lines above 0.8 of half the sampling rate, where anti-alias filters bend every channel, and above the 160th of the excitation are in no error: at most {:.1e} of a run's amplitude",
                untrusted.sqrt()
            ));
        }
        if let Some(frequency) = self.study.case.shaken {
            self.notes.push(format!(
                "the beam moves at {frequency} Hz in every run, which no declared force makes: another machine shakes it; that motion is taken out of the runs"
            ));
        }
        let unsettled: Vec<f64> =
            self.study.case.records.iter().map(|r| r.unsettled).filter(|u| *u > 0.0).collect();
        if !unsettled.is_empty() {
            self.notes.push(format!(
                "{} runs have not quite settled: what does not repeat in them, up to {:.2} times the power of the noise, counts as noise there",
                unsettled.len(),
                unsettled.into_iter().fold(0.0, f64::max)
            ));
        }
        let left_out = self.study.case.records.iter().filter(|r| !r.periodic).count();
        if left_out > 0 {
            let entered = self.study.series.len();
            let [before, after] = [baseline, model].map(|m| format!("{:.1} %", 100.0 * self.series_error(m)));
            let judged = as_declared(&model.fitted.setting);
            if !judged {
                self.notes.push(
                    "forces of runs that are not periodic were recovered with what is declared: the model has another structure, excitation or sensor, and its law is not judged by them".into(),
                );
            }
            let missed = if judged {
                format!("the law misses by {before} before and {after} after")
            } else {
                format!("the declared law misses by {before}")
            };
            self.notes.push(format!(
                "{left_out} runs are not periodic: no waveform is predicted for them; {entered} of them entered through the recovered force, which {missed}"
            ));
        }
        let (port, rests) = &model.fitted.setting.rests;
        if let Some(stop) = model.fitted.setting.ports.get(*port).filter(|_| !rests.is_empty()) {
            let low = rests.iter().copied().fold(f64::INFINITY, f64::min);
            let high = rests.iter().copied().fold(f64::NEG_INFINITY, f64::max);
            self.notes.push(format!(
                "the mean of the friction, which no accelerometer sees, holds the beam off by {low:.1e} to {high:.1e} m at the stop: found run by run from the force recovered there; the gap is {:.1e} m if friction has no mean in the run that tells most",
                stop.coefficients[1]
            ));
        }
        let unsettled = model.fitted.setting.deflections.iter().flatten().count();
        if unsettled > 0 {
            self.notes.push(format!(
                "contacts that stick or creep and had not come to their steady state, by the runs they are in: {unsettled}; the deflection with which its period begins is a value of each, told by that run alone, in runs held out too"
            ));
        }
        if self.other_formula {
            self.notes.push(format!(
                "the named effect leaves {:.2} times the noise in the worst training run: its formula here is another one, but it takes {:.2} % of what was missing and every rival leaves ten times as much",
                model.worst,
                100.0 * (1.0 - model.excess() / baseline.excess())
            ));
        }
        if self.within_method {
            self.notes.push(format!(
                "what the declared model leaves, {:.2} times the noise, is within the accuracy of a rigid contact's balance, {RIGID_ACCURACY:.0e} of the amplitude or what its phase grid may be wrong by: no effect is looked for below it",
                baseline.ratio
            ));
        }
        let given = given(baseline, model);
        if !given.is_empty() {
            self.notes.push(format!("the form that did best sets, and does not fit, {}", given.join(", ")));
        }
        if self.refined > 0 {
            self.notes
                .push(format!("the model was fitted on a phase grid {} times as fine", 1 << self.refined));
        }
        self.notes
            .push("mean friction, preload, mean position and drift cannot be seen by accelerometers".into());
    }

    /// Effects with evidence for them that could not be judged: the whole model has no answer with them.
    fn remark_refused(&mut self) {
        let mut seen = Vec::new();
        for (effect, reason) in &self.refused {
            let id = ALL[*effect].id();
            let unjudged = |t: &Tried| t.id == id && t.error.is_nan() && t.evidence > EVIDENCE;
            if !seen.contains(&id) && self.tried.iter().any(unjudged) {
                seen.push(id);
                self.notes.push(format!("{id} could not be judged: with it, {reason}"));
            }
        }
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

    /// Effects that these data do not rule out in one place of a model: the one whose formula stands there under the name of the simpler one that
    /// it shows. In the last place also those near in evidence; where the formula is in doubt, known rivals that leave little more; and known rivals that were not asked for.
    fn not_ruled_out(&self, model: &Explained, place: usize) -> Vec<usize> {
        let effect = model.effects[place];
        let renamed = self.renamed.iter().filter(|(at, _)| *at == place).map(|(_, other)| *other);
        if place + 1 < model.effects.len() {
            return renamed.collect();
        }
        let known = |other: usize| ALL[effect].rivals().contains(&ALL[other].id());
        let held_out = &self.study.held_out;
        let foretold = held_out.is_empty() || self.study.error(&model.fitted, held_out).ratio() <= FORETOLD;
        let near = |r: &&Rival| {
            let other = r.effect != effect;
            other && (r.behind < EVIDENCE || known(r.effect) && may_be(r.left, model.left(), foretold))
        };
        let unasked =
            (0..ALL.len()).filter(|&other| known(other) && !self.study.case.allows(ALL[other].id()));
        let mut found: Vec<usize> =
            self.rivals.iter().filter(near).map(|r| r.effect).chain(unasked).chain(renamed).collect();
        found.sort_unstable();
        found.dedup();
        found
    }

    fn named(&self, model: &Explained) -> Vec<Named> {
        let close = |effect: usize| {
            let other = move |r: &&Rival| r.effect != effect && r.behind < EVIDENCE;
            self.rivals.iter().filter(other)
        };
        model
            .effects
            .iter()
            .zip(&model.sensors)
            .enumerate()
            .map(|(k, (&effect, &sensor))| {
                let last = k + 1 == model.effects.len();
                let odds: f64 = if last { close(effect).map(|r| (-0.5 * r.behind).exp()).sum() } else { 0.0 };
                Named {
                    id: ALL[effect].id(),
                    probability: 1.0 / (1.0 + odds),
                    position: position(model, effect),
                    sensor,
                    parameters: parameters(model, k),
                    indistinguishable: at_most_two(effect, self.not_ruled_out(model, k)),
                    experiment: ALL[effect].experiment(),
                }
            })
            .collect()
    }
}

/// What is said of runs held out that are missed by so many times the noise, where one set of values follows all runs.
fn of_one(missed: f64) -> String {
    format!(
        "the fitted runs leave the values too uncertain to foretell those held out ({missed:.2} times the noise): one set of values follows all of them within the noise"
    )
}

/// A fault of a channel as a named effect: it was seen in the samples themselves.
pub(crate) fn faulty(fault: &ChannelFault) -> Named {
    let effect = listed(fault.id).map(|effect| ALL[effect]);
    Named {
        id: fault.id,
        probability: 1.0,
        position: None,
        sensor: Some(fault.sensor),
        parameters: fault.parameters.clone(),
        indistinguishable: Vec::new(),
        experiment: effect.map_or("", |e| e.experiment()),
    }
}

/// At most two of the effects that the data cannot rule out, those known to look like `effect` first.
fn at_most_two(effect: usize, left: Vec<usize>) -> Vec<&'static str> {
    let mut ids: Vec<_> = left.into_iter().map(|other| ALL[other].id()).collect();
    ids.sort_by_key(|id| !ALL[effect].rivals().contains(id));
    ids.truncate(2);
    ids
}

/// Values of the law that the forms of a model's effects brought with them and no fit moved: which formula it was.
fn given(baseline: &Explained, model: &Explained) -> Vec<String> {
    let [declared, law] = [baseline, model].map(|m| &m.fitted.setting.law);
    let fitted = |hook| model.fitted.unknowns.iter().any(|u| u.quantity == Quantity::Law(hook));
    let brought = Hook::ALL.into_iter().filter(|&hook| declared.get(hook).is_none() && !fitted(hook));
    let told = |hook: Hook| {
        let value = law.get(hook).filter(|&value| value != 0.0)?;
        let (name, unit) = hook.name_and_unit();
        Some(if unit == "1" { format!("{name} {value}") } else { format!("{name} {value:.4e} {unit}") })
    };
    brought.filter_map(told).collect()
}

/// The place that the effects of a model share.
fn shared_place(model: &Explained) -> Option<EffectPlace> {
    let mut places = model.effects.iter().map(|&effect| ALL[effect].place());
    let first = places.next()?;
    places.all(|place| place == first).then_some(first)
}

/// Position of an effect along the beam, where it has one.
fn position(model: &Explained, effect: usize) -> Option<f64> {
    if ALL[effect].place() != EffectPlace::Structure {
        return None;
    }
    model.added.iter().find(|u| u.quantity.is_place()).and_then(|u| model.fitted.setting.get(u.quantity))
}

/// What the effect at a place of the list brought.
fn parameters(model: &Explained, place: usize) -> Vec<(String, String, f64, f64)> {
    model
        .own(place)
        .iter()
        .filter_map(|u| {
            let value = model.fitted.setting.get(u.quantity)?;
            let std = model.deviation(u.quantity);
            Some((u.parameter.name.clone(), u.parameter.unit.clone(), value, std))
        })
        .collect()
}
