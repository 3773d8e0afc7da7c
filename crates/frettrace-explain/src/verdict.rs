//! The verdict: nothing missing, explained by named effects, or unexplained with a place.

use crate::balance_fit::BalanceCandidate;
use crate::effects::{ALL, EffectPlace};
use crate::search::Explained;
use crate::study::merge;
use crate::{Case, ChannelFault, ExplainError, RunError, Study, Unknown};
use frettrace_forward::accelerations::{Quantity, Setting};
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
#[derive(Clone, Debug)]
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
    /// What a reader must know.
    pub notes: Vec<String>,
}

/// Most effects named together.
const MOST_EFFECTS: usize = 2;
/// Evidence that a claim needs against its rivals.
const EVIDENCE: f64 = 10.0;
/// Largest share of the excess over the noise that a second effect may leave: a mechanism that is there takes its own away.
const PROXY: f64 = 0.4;
/// A model nearer to the noise than this is fitted further, and on a finer grid, before it is judged.
const NEAR: f64 = 6.0;
/// Relative error of the recovered force of a run without a period from which the law is in doubt: five times the accuracy
/// with which such a force is recovered.
const SERIES_OPEN: f64 = 0.05;
/// Improvement on held-out runs that a claim needs, in standard errors.
const HELD_OUT: f64 = 2.5;
/// The structure is calibrated on the balance above this χ² per degree of freedom: with the thousand degrees of freedom of
/// a set, two standard deviations.
const BALANCE_CALIBRATED: f64 = 1.1;
/// The balance of all training runs is closed below this χ² per degree of freedom …
const BALANCE_CLOSED: f64 = 1.6;
/// … wide open above this, where a law would only be bent to what is missing, …
const BALANCE_WIDE: f64 = 100.0;
/// … and closed below this in each of them.
const BALANCE_CLOSED_RUN: f64 = 2.6;

/// Explains a case.
///
/// # Errors
/// [`ExplainError`] where no run is periodic or the model cannot be evaluated at all.
pub fn explain(case: &Case) -> Result<Outcome, ExplainError> {
    let (study, setting) = Study::new(case)?;
    let mut search = Search {
        study,
        refined: false,
        other_formula: false,
        coarse: None,
        before: Vec::new(),
        tried: Vec::new(),
        rivals: Vec::new(),
        notes: Vec::new(),
    };
    let mut baseline = search.baseline(setting)?;
    if !baseline.complete() && baseline.ratio < NEAR {
        baseline = search.further(baseline);
        search.coarse = None;
    }
    search.before = search.errors_as_read(&baseline);
    let done = baseline.complete() && !search.series_open(&baseline);
    let model = if done { baseline.clone() } else { search.close(&baseline)? };
    Ok(search.outcome(baseline, model))
}

/// A model that another one was preferred to.
#[derive(Clone, Copy)]
struct Rival {
    /// Its last effect.
    effect: usize,
    criterion: f64,
    /// What its error holds beside the noise.
    excess: f64,
}

struct Search<'a> {
    study: Study<'a>,
    /// Whether the study is on its finer grid.
    refined: bool,
    /// Whether a name stands whose formula leaves more than the noise.
    other_formula: bool,
    /// The study on its plain grid, while it is not settled that the finer one stays.
    coarse: Option<Study<'a>>,
    /// Errors of the declared model: training runs, then held-out runs where there are any.
    before: Vec<RunError>,
    tried: Vec<Tried>,
    /// Models beside the best one.
    rivals: Vec<Rival>,
    notes: Vec<String>,
}

fn is_law(unknown: &Unknown) -> bool {
    matches!(unknown.quantity, Quantity::Law(_))
}

impl Search<'_> {
    /// The declared model: the law on the recovered contacts, then the whole.
    fn baseline(&self, mut setting: Setting) -> Result<Explained, ExplainError> {
        let unknowns = self.study.case.unknowns();
        let law: Vec<Unknown> = unknowns.iter().filter(|u| is_law(u)).cloned().collect();
        if self.study.case.loosely_known() || self.study.balance_reduced(&setting).0 > BALANCE_CALIBRATED {
            // Modes that are known loosely, beside the noise, are calibrated on the balance before any force is recovered.
            let calibrated = self.study.balance_base(&setting, &[]);
            if calibrated.reduced.is_finite() {
                setting = calibrated.setting;
            }
        }
        let recovered = self.study.recovered(&setting)?;
        if let Some(base) = self.study.contact_base(&recovered, &setting, &law) {
            setting.law = base.law;
        }
        // No law closes a balance that is wide open: a few steps show how far the declared model is.
        let wide = self.study.balance_reduced(&setting).0 > BALANCE_WIDE;
        let steps = if wide { 4 } else { 10 };
        // Where a stiff contact has no steady answer from a cold start, a softer one leads to it.
        for softer in [1.0, 0.2, 0.04, 0.008] {
            let mut setting = setting.clone();
            let stiffness = setting.law.get(Hook::Sigma0).unwrap_or(1.0);
            setting.law.set(Hook::Sigma0, softer * stiffness);
            if let Ok(found) = self.study.whole(setting, &unknowns, (Vec::new(), Vec::new()), steps) {
                return Ok(found);
            }
        }
        // A declared model without a steady answer is still a model: it explains nothing.
        self.study.blank(setting, &unknowns)
    }

    /// Whether the balance of every training run closes without a law.
    fn closed(&self, setting: &Setting) -> bool {
        let (reduced, worst) = self.study.balance_reduced(setting);
        reduced <= BALANCE_CLOSED && worst <= BALANCE_CLOSED_RUN
    }

    /// Where the balance is open, the structure within what is declared may close it: no effect is needed for that.
    fn calibrate(&self, current: &mut Explained) {
        let setting = &current.fitted.setting;
        let (open, _) = self.study.balance_reduced(setting);
        if open <= BALANCE_CALIBRATED {
            return;
        }
        let structural: Vec<Unknown> = current.added.iter().filter(|u| !is_law(u)).cloned().collect();
        let calibrated = self.study.balance_base(setting, &structural);
        if self.closed(&calibrated.setting) && self.study.balance_reduced(&calibrated.setting).0 < open {
            current.fitted.setting = calibrated.setting;
        }
    }

    /// Adds effects until the model is complete or nothing more is worth it.
    fn close(&mut self, baseline: &Explained) -> Result<Explained, ExplainError> {
        let mut single = None;
        let current = self.extended(baseline, &mut single)?;
        if current.complete() || current.sufficient(baseline) {
            return Ok(current);
        }
        let Some((one, rivals)) = single else { return Ok(current) };
        let left = least_excess(&one, &rivals);
        if !one.dominant(baseline, left) {
            return Ok(current);
        }
        // What a second effect took would be the first one's other formula.
        self.rivals = rivals;
        self.other_formula = true;
        Ok(one)
    }

    /// The model with effects, and on the way the one with a single effect and its rivals.
    fn extended(
        &mut self,
        baseline: &Explained,
        single: &mut Option<(Explained, Vec<Rival>)>,
    ) -> Result<Explained, ExplainError> {
        let mut current = baseline.clone();
        for _ in 0..MOST_EFFECTS {
            self.calibrate(&mut current);
            let before = current.clone();
            let rivals = std::mem::take(&mut self.rivals);
            let found = if self.closed(&current.fitted.setting) {
                match self.slight_round(&current)? {
                    Some(found) => Some(found),
                    None => self.contact_round(&current)?,
                }
            } else {
                self.structure_round(&current, f64::INFINITY)?
            };
            let mut better = match found {
                Some(better)
                    if better.criterion + EVIDENCE < current.criterion && better.ratio <= current.ratio =>
                {
                    better
                }
                _ => {
                    self.rivals = rivals;
                    break;
                }
            };
            if !better.complete() {
                // A second effect may not be named for what a longer fit would have done.
                better = self.further(better);
            }
            if !before.effects.is_empty() && better.excess() > PROXY * before.excess() {
                // It takes away a little of everything: a stand-in for what neither effect is.
                self.rivals = rivals;
                self.coarsened();
                break;
            }
            self.coarse = None;
            current = better;
            if before.effects.is_empty() {
                *single = Some((current.clone(), self.rivals.clone()));
            }
            if current.complete() && current.effects.len() > 1 {
                current = self.pruned(current, &before);
                if current.effects.len() == before.effects.len() {
                    self.rivals = rivals;
                }
            }
            if current.complete() && !self.series_open(&current) {
                break;
            }
        }
        Ok(current)
    }

    /// A longer fit; then, where that is near the noise but not within it, one on a finer grid.
    fn further(&mut self, mut current: Explained) -> Explained {
        if let Ok(better) = self.study.polished(&current)
            && better.criterion < current.criterion
        {
            current = better;
        }
        if current.complete() || current.ratio > NEAR || self.refined {
            return current;
        }
        let Ok(study) = self.study.refined() else { return current };
        match study.polished(&current) {
            Ok(better) if better.excess() < 0.7 * current.excess() => {
                self.coarse = Some(std::mem::replace(&mut self.study, study));
                self.refined = true;
                better
            }
            _ => current,
        }
    }

    /// Back to the plain grid, where a model on the finer one is not kept.
    fn coarsened(&mut self) {
        if let Some(study) = self.coarse.take() {
            (self.study, self.refined) = (study, false);
        }
    }

    /// Errors of a model: training runs, then held-out runs where there are any.
    fn errors(&self, model: &Explained) -> Vec<RunError> {
        [&self.study.training, &self.study.held_out]
            .into_iter()
            .filter(|runs| !runs.is_empty())
            .map(|runs| self.study.error(&model.fitted, runs))
            .collect()
    }

    /// The same of the samples as they were read, faults of the channels included.
    fn errors_as_read(&self, model: &Explained) -> Vec<RunError> {
        [&self.study.training, &self.study.held_out]
            .into_iter()
            .filter(|runs| !runs.is_empty())
            .map(|runs| self.study.error_as_read(&model.fitted, runs))
            .collect()
    }

    /// Largest relative error of the law's force in the runs without a period.
    fn series_error(&self, model: &Explained) -> f64 {
        let law = &model.fitted.setting.law;
        self.study.series.iter().map(|(_, contact)| contact.error(law)).fold(0.0, f64::max)
    }

    fn series_open(&self, model: &Explained) -> bool {
        self.series_error(model) > SERIES_OPEN
    }

    /// Without the last effect where the model is complete without it too.
    fn pruned(&self, current: Explained, before: &Explained) -> Explained {
        match self.study.without_last(&current, before) {
            Some(plain) if plain.complete() && plain.criterion < current.criterion + EVIDENCE => plain,
            _ => current,
        }
    }

    fn contact_round(&mut self, current: &Explained) -> Result<Option<Explained>, ExplainError> {
        let unknowns = merge(&self.study.case.unknowns(), &current.added);
        let law: Vec<Unknown> = unknowns.iter().filter(|u| is_law(u)).cloned().collect();
        let mut setting = current.fitted.setting.clone();
        let recovered = self.study.recovered(&setting)?;
        let base = self.study.contact_base(&recovered, &setting, &law);
        let plain = base.as_ref().map_or(f64::INFINITY, |b| b.criterion);
        if let Some(base) = &base {
            setting.law = base.law;
        }
        let candidates = self.study.contact_candidates(&recovered, &setting, &law, &current.effects);
        self.tried.extend(candidates.iter().map(|c| Tried {
            id: ALL[c.effect].id(),
            error: f64::NAN,
            evidence: plain - c.criterion,
        }));
        let found = self.study.contact_round(current, &candidates);
        Ok(self.take_best(current, found))
    }

    /// Records what was tried and keeps the best.
    fn take_best(&mut self, current: &Explained, mut found: Vec<Explained>) -> Option<Explained> {
        found.iter_mut().for_each(|one| one.book(current));
        found.sort_by(|a, b| a.criterion.total_cmp(&b.criterion));
        for one in &found {
            let Some(&effect) = one.effects.last() else { continue };
            let error = self.study.error(&one.fitted, &self.study.training).relative();
            let evidence = current.criterion - one.criterion;
            let id = ALL[effect].id();
            self.tried.retain(|t| t.id != id);
            self.tried.push(Tried { id, error, evidence });
        }
        self.rivals = found
            .iter()
            .filter_map(|one| {
                let rival =
                    |&effect: &usize| Rival { effect, criterion: one.criterion, excess: one.excess() };
                one.effects.last().map(rival)
            })
            .collect();
        let best = found.first()?.criterion;
        // A richer effect that contains a simpler one must earn its name against it.
        let simpler = found.iter().position(|one| {
            one.criterion < best + EVIDENCE
                && one.complete() == found[0].complete()
                && one.effects.last().is_some_and(|&e| contained(found[0].effects.last(), e))
        });
        Some(found.swap_remove(simpler.unwrap_or(0)))
    }

    /// Where structure effects start from: what was declared, or the model that already holds effects. A base fit of a law to
    /// an open balance bends the structure to what is missing.
    fn structural_start(&self, current: &Explained) -> Setting {
        if current.effects.is_empty() {
            let declared = self.study.case.setting(current.fitted.setting.law);
            if !self.study.case.loosely_known() {
                return declared;
            }
            let calibrated = self.study.balance_base(&declared, &[]);
            if calibrated.reduced.is_finite() { calibrated.setting } else { declared }
        } else {
            current.fitted.setting.clone()
        }
    }

    /// A structure effect where the balance is closed by what is usual, yet not by what the noise allows.
    fn slight_round(&mut self, current: &Explained) -> Result<Option<Explained>, ExplainError> {
        let (reduced, _) = self.study.balance_reduced(&current.fitted.setting);
        if reduced <= BALANCE_CALIBRATED {
            return Ok(None);
        }
        let found = self.structure_round(current, 0.5 * (1.0 + reduced))?;
        Ok(found.filter(|better| better.excess() < PROXY * current.excess()))
    }

    /// Effects outside the contact that bring χ² per degree of freedom of the balance below `limit`.
    fn structure_round(
        &mut self,
        current: &Explained,
        limit: f64,
    ) -> Result<Option<Explained>, ExplainError> {
        let structural: Vec<Unknown> = current.added.iter().filter(|u| !is_law(u)).cloned().collect();
        let setting = self.structural_start(current);
        let plain = self.study.balance_base(&setting, &structural);
        let mut candidates = self.study.balance_candidates(&setting, &structural, &current.effects);
        if setting.ports.is_empty() {
            candidates.extend(self.study.force_candidates(&setting, plain.criterion));
            candidates.extend(self.study.base_candidate(&setting, plain.criterion));
        }
        candidates.sort_by(|a, b| a.criterion.total_cmp(&b.criterion));
        // One form of each effect is re-fitted, of the best effect two: on recovered forces close forms change places.
        let leader = candidates.first().map(|c| c.effect);
        let mut seen = Vec::new();
        candidates.retain(|c| {
            let before = seen.iter().filter(|effect| **effect == c.effect).count();
            seen.push(c.effect);
            before < if Some(c.effect) == leader { 2 } else { 1 }
        });
        self.tried.extend(candidates.iter().map(|c| Tried {
            id: ALL[c.effect].id(),
            error: f64::NAN,
            evidence: plain.criterion - c.criterion,
        }));
        let best = candidates.first().map_or(f64::INFINITY, |c| c.criterion);
        let found = candidates
            .iter()
            .take(4)
            .filter(|c| c.criterion < 3.0 * best && c.reduced < limit)
            .filter_map(|candidate| self.with_structure(current, candidate).ok())
            .collect();
        Ok(self.take_best(current, found))
    }

    /// The whole model with a structure effect: the law anew on contacts recovered with it, then everything.
    fn with_structure(
        &self,
        current: &Explained,
        candidate: &BalanceCandidate,
    ) -> Result<Explained, ExplainError> {
        let own = candidate.unknowns.iter().filter(|u| !current.fitted.unknowns.contains(u));
        let declared = self.study.case.unknowns();
        let brought: Vec<Unknown> = own.filter(|u| !declared.contains(u)).cloned().collect();
        let added = merge(&current.added, &brought);
        let unknowns = merge(&declared, &added);
        let law: Vec<Unknown> = unknowns.iter().filter(|u| is_law(u)).cloned().collect();
        let mut setting = candidate.setting.clone();
        let recovered = self.study.recovered(&setting)?;
        if let Some(base) = self.study.contact_base(&recovered, &setting, &law) {
            setting.law = base.law;
        }
        let mut effects = current.effects.clone();
        effects.push(candidate.effect);
        let mut found = self.study.whole(setting, &unknowns, (effects, added), 12)?;
        found.sensors = current.sensors.iter().copied().chain([candidate.sensor]).collect();
        Ok(found)
    }

    fn outcome(mut self, baseline: Explained, model: Explained) -> Outcome {
        let borne_out = self.borne_out(&baseline, &model);
        let faults = &self.study.case.faults;
        let named: Vec<&ChannelFault> = faults.iter().filter(|f| self.study.case.allows(f.id)).collect();
        let nameless = named.len() < faults.len();
        let near = model.complete() || model.sufficient(&baseline) || self.other_formula;
        let filled = near && borne_out;
        let complete = filled && !nameless;
        let verdict = match (model.effects.is_empty() && named.is_empty(), complete) {
            (true, true) => Verdict::NothingMissing,
            (false, true) => Verdict::Explained,
            _ => Verdict::Unexplained,
        };
        let place = match verdict {
            Verdict::NothingMissing => None,
            Verdict::Explained if model.effects.is_empty() => Some(EffectPlace::Measurement),
            Verdict::Explained => model.effects.first().map(|&e| ALL[e].place()),
            Verdict::Unexplained if nameless && filled => Some(EffectPlace::Measurement),
            Verdict::Unexplained => Some(self.place(&model)),
        };
        let effects: Vec<Named> = if verdict == Verdict::Explained {
            named.iter().map(|fault| faulty(fault)).chain(self.named(&model)).collect()
        } else {
            Vec::new()
        };
        self.tried.extend(faults.iter().map(|fault| Tried {
            id: fault.id,
            error: f64::NAN,
            evidence: fault.evidence,
        }));
        self.tried.sort_by(|a, b| b.evidence.total_cmp(&a.evidence));
        self.remark(&baseline, &model);
        let after = self.errors(&model);
        let errors = |k: usize| Some([*self.before.get(k)?, *after.get(k)?]);
        Outcome {
            verdict,
            effects,
            place,
            error: errors(0).unwrap_or_default(),
            held_out: errors(1),
            runs: [self.study.training.clone(), self.study.held_out.clone()],
            tried: self.tried,
            notes: self.notes,
            baseline,
            model,
        }
    }

    /// Whether runs that nothing was fitted to bear out what is named.
    fn borne_out(&mut self, baseline: &Explained, model: &Explained) -> bool {
        let held_out = &self.study.held_out;
        if model.effects.is_empty() || held_out.is_empty() {
            return true;
        }
        let found = self.study.improvement(&baseline.fitted, &model.fitted, held_out);
        self.notes
            .push(format!("held-out runs improve by {found:.1} standard errors; a claim needs {HELD_OUT}"));
        found > HELD_OUT
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
        let left_out = self.study.case.records.iter().filter(|r| !r.periodic).count();
        if left_out > 0 {
            let entered = self.study.series.len();
            let [before, after] = [baseline, model].map(|m| 100.0 * self.series_error(m));
            self.notes.push(format!(
                "{left_out} runs are not periodic: no waveform is predicted for them; {entered} of them entered through the recovered force, which the law misses by {before:.1} % before and {after:.1} % after"
            ));
        }
        if self.other_formula {
            self.notes.push(format!(
                "the named effect leaves {:.2} times the noise in the worst training run: its formula here is another one, but it takes {:.2} % of what was missing and every rival leaves ten times as much",
                model.worst,
                100.0 * (1.0 - model.excess() / baseline.excess())
            ));
        }
        if self.refined {
            self.notes.push("the model with the effects was fitted on a phase grid twice as fine".into());
        }
        self.notes
            .push("mean friction, preload, mean position and drift cannot be seen by accelerometers".into());
    }

    /// Place of what stays unexplained: an open balance is never the contact.
    fn place(&self, model: &Explained) -> EffectPlace {
        let mut model = model.clone();
        self.calibrate(&mut model);
        if self.closed(&model.fitted.setting) {
            return EffectPlace::Contact;
        }
        self.study.open_place(&self.structural_start(&model))
    }

    fn named(&self, model: &Explained) -> Vec<Named> {
        let best = model.criterion;
        let close = |effect: usize| {
            let other = move |r: &&Rival| r.effect != effect && r.criterion - best < EVIDENCE;
            self.rivals.iter().filter(other)
        };
        model
            .effects
            .iter()
            .zip(&model.sensors)
            .enumerate()
            .map(|(k, (&effect, &sensor))| {
                let last = k + 1 == model.effects.len();
                let odds: f64 =
                    if last { close(effect).map(|r| (0.5 * (best - r.criterion)).exp()).sum() } else { 0.0 };
                Named {
                    id: ALL[effect].id(),
                    probability: 1.0 / (1.0 + odds),
                    position: position(model, effect),
                    sensor,
                    parameters: parameters(model, k),
                    indistinguishable: if last {
                        at_most_two(effect, close(effect).map(|r| r.effect))
                    } else {
                        Vec::new()
                    },
                    experiment: ALL[effect].experiment(),
                }
            })
            .collect()
    }
}

/// The least that a model with another effect leaves over the noise.
fn least_excess(model: &Explained, rivals: &[Rival]) -> f64 {
    let others = rivals.iter().filter(|rival| !model.effects.contains(&rival.effect));
    others.map(|rival| rival.excess).fold(f64::INFINITY, f64::min)
}

/// A fault of a channel as a named effect: it was seen in the samples themselves.
fn faulty(fault: &ChannelFault) -> Named {
    let effect = ALL.iter().find(|e| e.id() == fault.id);
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
fn at_most_two(effect: usize, left: impl Iterator<Item = usize>) -> Vec<&'static str> {
    let mut ids: Vec<_> = left.map(|other| ALL[other].id()).collect();
    ids.sort_by_key(|id| !ALL[effect].rivals().contains(id));
    ids.truncate(2);
    ids
}

/// Whether the effect `of` becomes the effect `simpler` at some value of its parameters.
fn contained(of: Option<&usize>, simpler: usize) -> bool {
    let of = of.map_or("", |&e| ALL[e].id());
    CONTAINED.iter().any(|(rich, plain)| *rich == of && *plain == ALL[simpler].id())
}

/// Effects that contain others: a lag of no time is the curve it lags behind, and so on.
const CONTAINED: [(&str, &str); 6] = [
    ("friction.lag", "friction.stribeck"),
    ("friction.film", "friction.stribeck"),
    ("friction.film", "friction.lag"),
    ("friction.ageing", "friction.stribeck"),
    ("friction.presliding-damping", "friction.viscous"),
    ("structure.second-support", "structure.cubic-stiffness"),
];

/// Position of an effect along the beam, where it has one.
fn position(model: &Explained, effect: usize) -> Option<f64> {
    if ALL[effect].place() != EffectPlace::Structure {
        return None;
    }
    model
        .added
        .iter()
        .find(|u| matches!(u.quantity, Quantity::PortPosition(_) | Quantity::MassPosition))
        .and_then(|u| model.fitted.setting.get(u.quantity))
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
