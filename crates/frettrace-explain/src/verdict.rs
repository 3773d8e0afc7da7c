//! The verdict: nothing missing, explained by named effects, or unexplained with a place.

use crate::contact_search::ContactCandidate;
use crate::effects::{ALL, listed};
use crate::search::{Asked, Explained};
use crate::series_fit::SeriesContact;
use crate::study::as_declared;
use crate::{ExplainError, RunError, Study, Unknown};
use frettrace_forward::accelerations::{Quantity, Setting};
use rayon::prelude::*;

mod asked_again;
mod baseline;
mod by_contacts;
mod choice;
mod contact_rounds;
mod finer;
mod known;
mod open_runs;
mod outcome;
mod outside_rounds;
mod pairs;
mod rules;
mod slight;
mod steady;

pub use open_runs::{SeenSupport, peak_from_rest};
pub(crate) use outcome::faulty;
pub use outcome::{Named, Outcome, Place, Tried, Verdict};
pub(crate) use slight::DEVIATES;
pub use steady::explain;

/// Most effects named together.
pub(crate) const MOST_EFFECTS: usize = 2;
/// Evidence that a claim needs against its rivals.
pub(crate) const EVIDENCE: f64 = 10.0;
/// Largest share of the excess over the noise that a second effect may leave: a mechanism that is there takes its own away.
const PROXY: f64 = 0.4;
/// Relative error of the recovered force of a run without a period from which the law is in doubt: five times the accuracy
/// with which such a force is recovered.
pub(crate) const SERIES_OPEN: f64 = 0.05;
/// … and χ² per residual above which, with that, it contradicts the law: what five times the accuracy makes.
const SERIES_BEYOND: f64 = 25.0;
/// Error over noise up to which runs that nothing was fitted to bear out that nothing is missing.
const BORNE_OUT: f64 = 1.2;
/// Error over noise of runs held out from which they contradict a model that follows those it was fitted to: what its values are
/// uncertain by adds some per cent.
const CONTRADICTED: f64 = 1.1;
/// … and up to which it is the noise and the common uncertainty of the fitted values.
const FORETOLD: f64 = 1.03;
/// Improvement on held-out runs that a claim needs, in standard errors.
pub(crate) const HELD_OUT: f64 = 2.5;
/// Share of their excess over the noise that a claim may leave there: more than half of it must go.
pub(crate) const HELD_OUT_SHARE: f64 = 0.5;
/// The structure is calibrated on the balance above this χ² per degree of freedom: with the thousand degrees of freedom of
/// a set, two standard deviations.
pub(crate) const BALANCE_CALIBRATED: f64 = 1.1;
/// χ² per degree of freedom below which the balance of all training runs is closed, where that of each is below [`BALANCE_CLOSED_RUN`], and that
/// of a whole spectrum: its thousands of bins scatter by some per cent.
pub const BALANCE_CLOSED: f64 = 1.6;
/// … and wide open above this, where a law would only be bent to what is missing.
const BALANCE_WIDE: f64 = 100.0;
/// χ² per degree of freedom below which the balance of one run is closed.
pub const BALANCE_CLOSED_RUN: f64 = 2.6;

/// Growth of the worst error that a lift-off seen in runs without a period may bring to the others.
const LIFTED: f64 = 1.02;

/// What a second support along the beam whose stiffness is nothing may be the cube, or the damping, of: near the end, that of the contact too.
const STANDS_IN_FOR: [&str; 4] = [
    "structure.cubic-stiffness",
    "structure.quadratic-damping",
    "structure.modal-damping",
    "friction.viscous",
];

/// A model that another one was preferred to.
#[derive(Clone, Copy)]
struct Rival {
    /// Its last effect.
    effect: usize,
    /// By how much it explains all runs worse.
    behind: f64,
    /// What its error holds beside the noise.
    excess: f64,
    /// What its lines hold beside their noise.
    left: f64,
}

impl Rival {
    /// A model with effects, as the rival of one that explains all runs better by so much.
    fn of(model: &Explained, behind: f64) -> Option<Self> {
        let effect = *model.effects.last()?;
        Some(Self { effect, behind, excess: model.excess(), left: model.left().excess() })
    }

    /// A model and its own rivals as those of a better one.
    fn of_better(better: &Explained, of: (&Explained, Vec<Self>)) -> Vec<Self> {
        Self::of_one_better_by(of.0.criterion - better.criterion, of)
    }

    /// The same of one that explains all runs better by so much.
    fn of_one_better_by(behind: f64, (model, rivals): (&Explained, Vec<Self>)) -> Vec<Self> {
        let moved = |rival: Self| Self { behind: rival.behind + behind, ..rival };
        rivals.into_iter().chain(Self::of(model, 0.0)).map(moved).collect()
    }
}

#[derive(Clone)]
struct Search<'a> {
    study: Study<'a>,
    /// How often the study's grid was made finer.
    refined: usize,
    /// Whether what the declared model leaves is within what the method itself may be wrong by.
    within_method: bool,
    /// Whether no phase grid that a balance gets resolves any run of a rigid contact: nor does the sampling rate resolve the force recovered of those
    /// without a period.
    unresolved: bool,
    /// Whether a name stands whose formula leaves more than the noise.
    other_formula: bool,
    /// Whether a mode must leave what was declared of it, and its name is not asked for.
    strained: bool,
    /// Whether a mode that deviates from what was declared of it is named, or what makes it deviate, which no error shows.
    deviates: bool,
    /// Whether one set of values of the declared law follows all runs, those that were held out among them.
    of_one_law: bool,
    /// Most effects named together.
    most_effects: usize,
    /// Whether the last effect is a lift-off that only runs without a period show.
    lifts_off: bool,
    /// The study before its grid was made finer, and how often it had been, while it is not settled that the finer one stays.
    coarse: Option<(Study<'a>, usize)>,
    /// The declared law on the contacts recovered with the declared structure.
    on_contacts: Option<ContactCandidate>,
    /// Errors of the declared model: training runs, then held-out runs where there are any.
    before: Vec<RunError>,
    tried: Vec<Tried>,
    /// Effects that the whole model was fitted with, and what each brought.
    fitted_with: Vec<(usize, Vec<Quantity>)>,
    /// Effects that the whole model had no answer with, and why.
    refused: Vec<(usize, String)>,
    /// Models beside the best one.
    rivals: Vec<Rival>,
    /// Complete ones among them, or those near one that is not, as they were fitted, the best few.
    runners_up: Vec<Explained>,
    /// Effects, by their places in the model, whose formulas stand under another name, of which alone something shows.
    renamed: Vec<(usize, usize)>,
    /// Whole models that were asked already, by this search or one that it was begun from.
    known: known::Known,
    /// Single names that followed other fitted runs, of which those held out made the search begin anew.
    told_by_others: Vec<usize>,
    notes: Vec<String>,
}

impl<'a> Search<'a> {
    fn new(study: Study<'a>) -> Self {
        Self {
            study,
            refined: 0,
            within_method: false,
            unresolved: false,
            other_formula: false,
            strained: false,
            deviates: false,
            of_one_law: false,
            most_effects: MOST_EFFECTS,
            lifts_off: false,
            coarse: None,
            on_contacts: None,
            before: Vec::new(),
            tried: Vec::new(),
            fitted_with: Vec::new(),
            refused: Vec::new(),
            rivals: Vec::new(),
            runners_up: Vec::new(),
            renamed: Vec::new(),
            told_by_others: Vec::new(),
            known: known::Known::default(),
            notes: Vec::new(),
        }
    }
}

impl Search<'_> {
    /// The models that have an answer and are what their last name says; of those without an answer it is kept why. A support that carries
    /// nothing rubs, where the cubes and dampings that it could stand in for are in the list themselves. A mass that would have to be taken away is none, nor
    /// is a spring that pulls away.
    fn answered(&mut self, asked: Vec<Asked>) -> Vec<Explained> {
        let mut found = Vec::new();
        let rubs = STANDS_IN_FOR.iter().all(|id| self.study.case.allows(id));
        for Asked { effect, answer } in asked {
            match answer {
                Ok(model) if model.is_passive() && (rubs || self.study.carries(&model)) => {
                    found.push(model);
                }
                Ok(_) => {}
                Err(reason) => self.refused.push((effect, reason.to_string())),
            }
        }
        found
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
        let (_, structural) = Unknown::parted(&current.added);
        let calibrated = self.study.balance_base(setting, &structural);
        if self.closed(&calibrated.setting) && self.study.balance_reduced(&calibrated.setting).0 < open {
            current.fitted.setting = calibrated.setting;
        }
    }

    /// Whether no contact force closes the balance, with the structure anywhere within what is declared of it.
    fn is_open(&self, model: &Explained) -> bool {
        let mut calibrated = model.clone();
        self.calibrate(&mut calibrated);
        !self.closed(&calibrated.fitted.setting)
    }

    /// Adds effects until the model is complete or nothing more is worth it.
    fn close(&mut self, baseline: &Explained) -> Result<Explained, ExplainError> {
        let mut single = None;
        let current = self.extended(baseline, &mut single)?;
        // A second name that shows nothing of what it says is what the first one's formula leaves.
        let mended = current.effects.len() > 1 && self.shows_nothing(&current);
        if current.complete() && !mended {
            let named = !current.effects.is_empty();
            let sharp = self.sharpened_among(current, |left| !named || left.is_near_noise());
            return Ok(self.study.without_shapes(sharp));
        }
        let sufficient = current.sufficient(baseline);
        let Some((one, rivals)) = single else { return Ok(current) };
        let left = least_excess(&one, &rivals);
        if !one.dominant(baseline, left) {
            return Ok(current);
        }
        if sufficient && !mended {
            // A single name that leaves so little has another formula all the same.
            self.other_formula = current.effects == one.effects;
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
        let mut settled = false;
        for _ in 0..self.most_effects {
            let mut fitted = current.clone();
            self.calibrate(&mut current);
            if !current.effects.is_empty()
                && let Some(better) = self.restarted(&current)
            {
                // A second effect may not be named for what a finer grid does to the first.
                let better = self.further(better, current.excess());
                self.coarse = None;
                fitted = better.clone();
                current = better;
                if let Some((one, _)) = single.as_mut().filter(|_| current.effects.len() == 1) {
                    one.clone_from(&current);
                }
                if current.complete() && !self.series_open(&current) {
                    break;
                }
                self.calibrate(&mut current);
            }
            let before = current.clone();
            let rivals = std::mem::take(&mut self.rivals);
            let found = if self.closed(&current.fitted.setting) {
                match self.slight_round(&current)? {
                    Some(found) => Some(found),
                    None => {
                        let found = self.contact(&current)?;
                        self.hidden_round(&current, found)?
                    }
                }
            } else {
                let found = self.structure_round(&current, f64::INFINITY)?;
                // A force that hides in the contact's leaves the balance all but closed.
                let wide = self.study.balance_reduced(&current.fitted.setting).0 > BALANCE_WIDE;
                if wide { found } else { self.hidden_round(&current, found)? }
            };
            let mut better = match found {
                Some(better) if better.gain(&current) > EVIDENCE && better.ratio <= current.ratio => better,
                _ => {
                    self.rivals = rivals;
                    current = fitted;
                    break;
                }
            };
            if !better.complete() {
                // A second effect may not be named for what a longer fit would have done.
                let was = better.criterion;
                better = self.further(better, before.excess());
                if better.complete() {
                    better = self.among_the_near(was, better);
                }
            }
            if !before.effects.is_empty() && better.excess() > PROXY * before.excess() {
                // It takes away a little of everything: a stand-in for what neither effect is.
                self.rivals = rivals;
                current = fitted;
                self.coarsened();
                break;
            }
            self.coarse = None;
            current = better;
            if before.effects.is_empty() {
                *single = Some((current.clone(), self.rivals.clone()));
            }
            if current.complete() && current.effects.len() > 1 {
                current = self.pruned(current);
                if current.effects.len() == before.effects.len() {
                    self.rivals = Rival::of_better(&current, (&before, rivals));
                }
            }
            // The balance of a rigid contact leaves as much of a right model, and no second name can be told in it.
            settled = current.complete()
                || current.fitted.setting.rigid
                    && (current.sufficient(baseline) || self.within_grid(&current).is_some());
            if settled && !self.series_open(&current) {
                break;
            }
        }
        if !settled
            && !current.complete()
            && self.most_effects > 1
            && let Some(found) = self.at_last(baseline, single.as_ref())?
        {
            current = found;
        }
        Ok(current)
    }

    /// The model with lift-off, where runs without a period show it: no waveform is predicted for them, but their normal force
    /// was recovered without a law and stays at zero. Nothing is fitted to it.
    fn with_lift_off(&mut self, model: Explained) -> Explained {
        let shares: Vec<f64> =
            self.study.case.records.iter().filter_map(|r| r.series.as_ref()).map(|s| s.open_share).collect();
        let open = shares.iter().filter(|share| **share > 0.0).count();
        let Some(effect) = listed("contact.lift-off") else { return model };
        if open == 0 || model.effects.contains(&effect) || !self.study.case.allows(ALL[effect].id()) {
            return model;
        }
        let forms = ALL[effect].structure_forms(self.study.case, &model.fitted.setting, &self.study.scales);
        let Some(form) = forms.into_iter().next() else { return model };
        let mut fitted = model.fitted.clone();
        fitted.setting = form.setting;
        fitted.memory = self.study.model.memory();
        let mut effects = model.effects.clone();
        effects.push(effect);
        let mut found = self.study.judged(fitted, effects, model.added.clone());
        if found.worst > LIFTED * model.worst {
            return model;
        }
        found.sensors = model.sensors.iter().copied().chain([None]).collect();
        found.book(&model);
        self.rivals.clear();
        self.lifts_off = true;
        self.notes.push(format!(
            "{open} of {} runs without a period show lift-off: their normal force, recovered without a law, stays at zero for up to {:.0} % of the time and never pulls",
            shares.len(),
            100.0 * shares.iter().copied().fold(0.0, f64::max)
        ));
        found
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
        self.study.series.par_iter().map(|(_, contact)| contact.error(law)).reduce(|| 0.0, f64::max)
    }

    /// Whether the force recovered of a run without a period contradicts the law: it misses it by more than five times the accuracy with
    /// which such a force is recovered, and by more than five standard deviations in the mean over the bins.
    fn series_contradicts(&self, model: &Explained) -> bool {
        let setting = &model.fitted.setting;
        let beyond = |contact: &SeriesContact| {
            contact.error(&setting.law) > SERIES_OPEN
                && contact.cost(&setting.law) > SERIES_BEYOND * contact.count() as f64
        };
        self.series_judge(setting) && self.study.series.par_iter().any(|(_, contact)| beyond(contact))
    }

    fn series_open(&self, model: &Explained) -> bool {
        self.series_judge(&model.fitted.setting) && self.series_error(model) > SERIES_OPEN
    }

    /// Whether the force recovered of runs without a period says anything of the law of a setting: it was recovered with the declared structure.
    fn series_judge(&self, setting: &Setting) -> bool {
        !self.unresolved && as_declared(setting)
    }

    /// The declared model from the law of the one that explains, where that ends far better than it did: it had come to rest in
    /// another valley, and the effect stands in for that.
    fn rebased(&mut self, baseline: &Explained, model: &Explained) -> Option<Explained> {
        if model.effects.len() != 1 {
            return None;
        }
        let plain = match self.study.emptied(model, 0) {
            Some(plain) => self.study.fitted_if_near(&plain, baseline.criterion)?,
            None => self.unnamed(model)?,
        };
        (plain.criterion + EVIDENCE < baseline.criterion).then_some(plain)
    }

    /// A complete model whose only effect is nothing within its deviations is the declared one, though a balance has no answer with the effect taken
    /// out and all else as it is.
    fn unnamed(&mut self, model: &Explained) -> Option<Explained> {
        if !model.complete() || !self.study.is_nothing(model, 0) {
            return None;
        }
        self.notes.push(format!(
            "{}, without which a run had no answer, is nothing within its deviation: the model is the declared one",
            ALL[model.effects[0]].id()
        ));
        let mut plain = model.clone();
        plain.effects.clear();
        plain.sensors.clear();
        plain.counts.clear();
        plain.added.clear();
        Some(plain)
    }

    /// Without one of its effects where the model is complete without it too, however little that costs: nothing is left above the
    /// noise that a second name could stand for, and a first effect may have stood in for the second.
    fn pruned(&self, current: Explained) -> Explained {
        let shorter = (0..current.effects.len()).filter_map(|place| self.study.without(&current, place));
        let complete = shorter.filter(Explained::complete);
        complete.min_by(Explained::by_criterion).unwrap_or(current)
    }
}

/// The least that a model with another effect leaves over the noise.
fn least_excess(model: &Explained, rivals: &[Rival]) -> f64 {
    let others = rivals.iter().filter(|rival| !model.effects.contains(&rival.effect));
    others.map(|rival| rival.excess).fold(f64::INFINITY, f64::min)
}
