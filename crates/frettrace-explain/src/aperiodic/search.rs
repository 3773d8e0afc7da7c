//! What the declared law lacks, on the recovered motion of runs without a period: one effect after the other inside the law.

mod looks;

use super::Value;
use super::problem::OpenProblem;
use super::run::{Open, OpenRun, Wave};
use super::wave;
use crate::case::Scales;
use crate::deviation::deviations;
use crate::effects::{ALL, shaped};
use crate::law_starts::scattered;
use crate::search::{COMPLETE, REST, SUFFICIENT};
use crate::series_fit::ACCURACY;
use crate::study::merge;
use crate::verdict::{EVIDENCE, HELD_OUT, HELD_OUT_SHARE, MOST_EFFECTS, SERIES_OPEN, Verdict};
use crate::{Case, RunError, Unknown};
use frettrace_friction::effects::ModifiedLaw;
use frettrace_identify::{Fit, Parameter, Status};
use nalgebra::DVector;
use rayon::prelude::*;

/// Upper end of a scatter, in standard deviations (one in twenty).
const UPPER: f64 = 1.645;
/// Steps of a fit to its end, of one from another start, and of a first look at a form.
const ALL_STEPS: usize = 15;
const BEGIN: usize = 8;
const GLANCE: usize = 2;
/// Steps of the law in a sample: its harmonics up to twice the recorded band do not fold, …
const FINE: usize = 2;
/// … and one in a first look.
const COARSE: usize = 1;
/// Runs of a first look and of a second one, over the whole range of levels.
const QUICK_RUNS: usize = 2;
const SECOND_RUNS: usize = 4;
/// Forms of a second look, its steps, and effects that are fitted to their end.
const LOOKED: usize = 8;
const PART: usize = 6;
const ENDED: usize = 3;
/// How often a model is fitted on, as long as each time leaves less than this share of its cost.
const MORE: usize = 3;
const SLOW: f64 = 0.9;
/// Other starts of a law of many values that are tried, and those that get all steps.
const STARTS: usize = 8;
const MANY_VALUES: usize = 4;

/// A law with effects, fitted to the training runs.
#[derive(Clone)]
pub(super) struct Fitted {
    pub law: ModifiedLaw<f64>,
    pub unknowns: Vec<Unknown>,
    /// Effects in the order they were found, and what each brought.
    pub effects: Vec<usize>,
    pub added: Vec<Vec<Unknown>>,
    /// Modulation of the preload, one phase a training run; empty where there is none.
    pub waves: Vec<Wave>,
    /// Minimum of `|r|² + |ξ|²`.
    pub cost: f64,
    /// Number of values.
    pub values: f64,
    pub open: Vec<Open>,
}

impl Fitted {
    /// What models that were fitted to a few runs are ranked by.
    pub fn rank(&self) -> f64 {
        self.cost + self.values
    }

    pub fn criterion(&self, count: f64) -> f64 {
        self.cost + self.values * count.ln()
    }
}

/// A run that nothing was fitted to under a law: what is left, the errors, and the run with its modulation.
pub(super) struct Judged {
    pub run: OpenRun,
    pub open: Open,
    pub left: DVector<f64>,
    pub cost: f64,
}

/// The search.
pub(super) struct Search<'a> {
    pub case: &'a Case,
    pub scales: Scales,
    pub training: Vec<OpenRun>,
    pub held_out: Vec<OpenRun>,
    /// The declared law as the histories show it at first sight, before any fit.
    pub sight: Option<ModifiedLaw<f64>>,
    /// Candidates beside the declared law: effect and evidence.
    pub tried: Vec<(usize, f64)>,
    pub notes: Vec<String>,
}

impl Search<'_> {
    /// Number of real residuals of the training runs.
    pub fn count(&self) -> f64 {
        self.training.iter().map(OpenRun::count).sum::<usize>() as f64
    }

    /// Largest mean square of a complete model on so many residuals: [`COMPLETE`] squared, and the scatter `√(2/n)` of a mean of squares.
    fn limit(count: f64) -> f64 {
        COMPLETE * COMPLETE * (1.0 + UPPER * (2.0 / count.max(1.0)).sqrt())
    }

    pub fn complete(&self, fitted: &Fitted) -> bool {
        fitted.cost <= Self::limit(self.count()) * self.count()
    }

    /// Whether runs that nothing was fitted to leave no more than that.
    pub fn foretold(&self, judged: &[Judged]) -> bool {
        let count: f64 = judged.iter().map(|j| j.run.count() as f64).sum();
        judged.is_empty() || judged.iter().map(|j| j.cost).sum::<f64>() <= Self::limit(count) * count
    }

    /// Whether the names of a model leave so little of what the declared law missed, in runs that it was fitted to and in others, that only another
    /// formula of the same is left: a hundredth, within a fifth of the noise.
    pub fn sufficient(&self, (before, after): (&Fitted, &Fitted), [missed, left]: [&[Judged]; 2]) -> bool {
        let mean = |judged: &[Judged]| {
            let count: f64 = judged.iter().map(|j| j.run.count() as f64).sum();
            judged.iter().map(|j| j.cost).sum::<f64>() / count.max(1.0)
        };
        !after.effects.is_empty()
            && is_trace(before.cost / self.count(), after.cost / self.count())
            && (left.is_empty() || is_trace(mean(missed), mean(left)))
    }

    fn problem<'b>(&self, runs: &'b [OpenRun], from: &Fitted, held: bool) -> OpenProblem<'b> {
        let sizes = [self.scales.preload, self.scales.velocity];
        let (hooks, parameters) =
            Unknown::hooks(&from.unknowns, (&from.law, self.case.law.is_static()), sizes);
        OpenProblem { runs, law: from.law, hooks, parameters, held }
    }

    /// Values of a fitted law under their names, with their standard deviations: those of the curvature, and the accuracy to which a recovered
    /// force is known as a whole.
    pub fn values(&self, fitted: &Fitted) -> Vec<Value> {
        let runs = self.with_waves(&fitted.waves);
        let problem = self.problem(&runs, fitted, true);
        let values: Vec<f64> =
            problem.hooks.iter().map(|hook| fitted.law.get(*hook).unwrap_or_default()).collect();
        let fit = Fit {
            cost: fitted.cost,
            data_cost: fitted.cost,
            iterations: 0,
            status: Status::Converged,
            free: vec![true; values.len()],
            at_bound: vec![false; values.len()],
            values,
        };
        let deviations = deviations(&problem, &fit, &fitted.open);
        let value = |((parameter, value), deviation): ((&Parameter, &f64), f64)| {
            (parameter.name.clone(), parameter.unit.clone(), *value, deviation.hypot(ACCURACY * value))
        };
        problem.parameters.iter().zip(&fit.values).zip(deviations).map(value).collect()
    }

    /// A law with some values free, fitted to runs.
    fn fitted(&self, runs: &[OpenRun], from: &Fitted, (most, held): (usize, bool)) -> Option<Fitted> {
        let problem = self.problem(runs, from, held);
        let extended = |(run, open): (&OpenRun, &Open)| run.extended(&from.law, open);
        let mut open: Vec<Open> =
            runs.iter().zip(&from.open).map(extended).collect::<Option<_>>().unwrap_or_default();
        let fit = problem.solve(most, &mut open).ok()?;
        let law = problem.at(&fit.values);
        // The memory of the last trial may be another place's.
        open.par_iter_mut().zip(runs).for_each(|(open, run)| {
            run.settle(&law, open);
        });
        let phases = if from.waves.is_empty() { 0 } else { runs.len() };
        Some(Fitted { law, cost: fit.cost, values: (fit.values.len() + phases) as f64, open, ..from.clone() })
    }

    /// The declared law from a start: to its end, and where that leaves more than the noise from other starts too.
    pub fn declared(&self, law: ModifiedLaw<f64>) -> Option<Fitted> {
        let (unknowns, _) = Unknown::parted(&self.case.unknowns());
        let begun = Fitted {
            law,
            unknowns,
            effects: Vec::new(),
            added: Vec::new(),
            waves: Vec::new(),
            cost: f64::INFINITY,
            values: 0.0,
            open: Vec::new(),
        };
        let first = self.fitted(&self.training, &begun, (ALL_STEPS, false));
        let done = first.as_ref().is_some_and(|first| self.complete(first));
        if done || begun.unknowns.len() < MANY_VALUES {
            return first;
        }
        let sizes = (self.scales.preload, self.scales.velocity);
        let runs: Vec<OpenRun> = self.some(QUICK_RUNS).iter().map(|&k| self.training[k].clone()).collect();
        let starts = scattered(&law, &begun.unknowns, sizes);
        let from =
            |law: ModifiedLaw<f64>| self.fitted(&runs, &Fitted { law, ..begun.clone() }, (BEGIN, true));
        let mut looked: Vec<Fitted> = starts.into_iter().step_by(3).take(STARTS).filter_map(from).collect();
        looked.sort_by(|a, b| a.cost.total_cmp(&b.cost));
        let best = looked.into_iter().next();
        let ended = best.and_then(|one| {
            self.fitted(&self.training, &Fitted { law: one.law, ..begun.clone() }, (ALL_STEPS, false))
        });
        first.into_iter().chain(ended).min_by(|a, b| a.cost.total_cmp(&b.cost))
    }

    /// A fitted law again, from errors as they are without one.
    pub fn further(&self, fitted: &Fitted) -> Option<Fitted> {
        let runs = self.with_waves(&fitted.waves);
        let from = Fitted { open: Vec::new(), ..fitted.clone() };
        self.fitted(&runs, &from, (ALL_STEPS, false))
    }

    /// Turns all runs to the errors that matter beside a law that is not fitted yet.
    pub fn turn(&mut self, law: &ModifiedLaw<f64>) {
        let turned = |run: &mut OpenRun| {
            if let Some(open) = run.begin(law) {
                run.turn(&open);
            }
        };
        self.training.par_iter_mut().chain(&mut self.held_out).for_each(turned);
    }

    /// Turns all runs to the errors that matter beside a law, marches it in finer steps, and weighs the bins by what the errors of each bin of
    /// its own do there.
    pub fn settle_on(&mut self, fitted: &Fitted) {
        let law = &fitted.law;
        let settled = |run: &OpenRun, open: &Open| {
            let mut run = run.clone();
            if let Some(open) = run.open(law, open.xi.clone()) {
                run.turn(&open);
            }
            let mut run = run.refined(FINE);
            let xi = DVector::zeros(run.errors());
            run.weigh(law, &xi);
            run
        };
        let judged = self.judged(fitted);
        self.training =
            self.training.par_iter().zip(&fitted.open).map(|(run, open)| settled(run, open)).collect();
        self.held_out = judged.par_iter().map(|judged| settled(&judged.run, &judged.open)).collect();
    }

    /// At most so many training runs over the range of levels.
    fn some(&self, most: usize) -> Vec<usize> {
        let n = self.training.len();
        let most = most.min(n);
        (0..most).map(|k| if most > 1 { k * (n - 1) / (most - 1) } else { 0 }).collect()
    }

    pub(super) fn with_waves(&self, waves: &[Wave]) -> Vec<OpenRun> {
        let mut runs = self.training.clone();
        runs.iter_mut().zip(waves).for_each(|(run, wave)| run.wave = *wave);
        runs
    }

    /// The held-out runs under a fitted law.
    pub fn judged(&self, fitted: &Fitted) -> Vec<Judged> {
        let omega = fitted.waves.first().map(|wave| wave.omega);
        let one = |run: &OpenRun| {
            let mut run = run.clone();
            if let Some(omega) = omega {
                run.wave = wave::phased(&run, &fitted.law, omega);
            }
            let mut open = run.begin(&fitted.law)?;
            let mut best: Option<Judged> = None;
            for _ in 0..REOPENED {
                let (left, cost) = run.settle(&fitted.law, &mut open);
                let better = best.as_ref().is_none_or(|best| cost < best.cost);
                if better {
                    best = Some(Judged { run: run.clone(), open: open.clone(), left, cost });
                }
                open = run.open(&fitted.law, open.xi.clone())?;
            }
            best
        };
        self.held_out.par_iter().filter_map(one).collect()
    }

    /// Effects inside the law until it is complete or nothing more is worth it.
    pub fn extended(&mut self, baseline: &Fitted) -> Fitted {
        let mut current = baseline.clone();
        while current.effects.len() < MOST_EFFECTS && !self.complete(&current) {
            let Some(next) = self.round(&current) else { break };
            current = self.ended(next);
        }
        current
    }

    /// A model that leaves more than the noise, fitted further: from errors as they are without one, for those that went with a poorer one are
    /// not its own, and then with the further values of its last effect's shape, which may be another laboratory's.
    fn ended(&self, found: Fitted) -> Fitted {
        let found = self.to_its_end(self.bettered(found.clone(), found));
        let mut richer = found.clone();
        let (Some(&effect), Some(own)) = (found.effects.last(), richer.added.last_mut()) else {
            return found;
        };
        let brought = shaped(effect, &mut richer.law, &found.unknowns, &self.scales);
        if brought.is_empty() {
            return found;
        }
        richer.unknowns = merge(&found.unknowns, &brought);
        own.extend(brought);
        self.to_its_end(self.bettered(found, richer))
    }

    /// A model fitted on as long as that takes a fair share of what it leaves.
    fn to_its_end(&self, mut found: Fitted) -> Fitted {
        for _ in 0..MORE {
            let before = found.cost;
            found = self.bettered(found.clone(), found);
            if found.cost > SLOW * before {
                break;
            }
        }
        found
    }

    /// A model, or where that leaves more than the noise another one fitted to its end, if there is evidence for it.
    fn bettered(&self, found: Fitted, other: Fitted) -> Fitted {
        if self.complete(&found) {
            return found;
        }
        let count = self.count();
        let better = |one: &Fitted| one.criterion(count) + EVIDENCE < found.criterion(count);
        self.further(&other).filter(better).unwrap_or(found)
    }

    /// One effect more: the best, where the evidence for it is strong and runs held out agree.
    fn round(&mut self, current: &Fitted) -> Option<Fitted> {
        let count = self.count();
        let mut found = self.candidates(current);
        found.sort_by(|a, b| a.criterion(count).total_cmp(&b.criterion(count)));
        if current.effects.is_empty() {
            let evidence =
                |one: &Fitted| Some((*one.effects.last()?, current.criterion(count) - one.criterion(count)));
            self.tried = found.iter().filter_map(evidence).collect();
        }
        let best = found.into_iter().next()?;
        let gained = current.criterion(count) - best.criterion(count);
        let id = best.effects.last().map_or("", |&effect| ALL[effect].id());
        if gained < EVIDENCE {
            return None;
        }
        if !self.held_out.is_empty() && !self.confirmed(current, &best) {
            self.notes.push(format!(
                "{id} lowers the residual of the fitted runs (evidence {gained:.0}) but not that of the held-out ones: not named"
            ));
            return None;
        }
        Some(best)
    }

    /// Whether held-out runs improve by [`HELD_OUT`] standard errors, and by half of what they leave over the floor: with `δ` the difference of
    /// what both models leave, `Δχ²` scatters by `2|δ|`, the more so by what is left.
    fn confirmed(&self, before: &Fitted, after: &Fitted) -> bool {
        let (before, after) = (self.judged(before), self.judged(after));
        if before.len() != after.len() {
            return after.len() > before.len();
        }
        let (mut gain, mut moved, mut left, mut count) = (0.0, 0.0, 0.0, 0.0);
        for (old, new) in before.iter().zip(&after) {
            gain += old.cost - new.cost;
            moved += (&old.left - &new.left).norm_squared();
            left += new.cost;
            count += new.run.count() as f64;
        }
        let inflation = (left / count).max(1.0);
        let excess = |cost: f64| (cost / count - 1.0).max(0.0);
        gain > HELD_OUT * 2.0 * (moved * inflation).sqrt()
            && excess(left) <= HELD_OUT_SHARE * excess(left + gain).max(1.0 - 1.0 / COMPLETE)
    }

    /// What a reader must know.
    pub fn remark(&mut self, complete: bool, verdict: Verdict, error: &RunError) {
        self.notes.push(format!(
            "fewer than three runs are periodic, so that no waveform is predicted: the contact is recovered over the whole spectrum without a law ({} of {} runs), and the law asked for its force",
            self.training.len() + self.held_out.len(),
            self.case.records.len()
        ));
        if verdict == Verdict::NothingMissing && !complete {
            self.notes.push(format!(
                "the law leaves {:.2} times the floor, no effect takes that away, and it is below {SERIES_OPEN} of the force: such a force is not known well enough for a doubt",
                error.ratio()
            ));
        }
        self.notes
            .push("mean friction, preload, mean position and drift cannot be seen by accelerometers".into());
    }
}

/// Whether of mean squares (in the noise's) a model leaves a hundredth of what the declared law missed, within a fifth of the noise.
fn is_trace(missed: f64, left: f64) -> bool {
    left <= SUFFICIENT * SUFFICIENT && left - 1.0 <= REST * (missed - 1.0).max(0.0)
}

/// The effect whose frequency is no line of the excitation here.
pub(super) const MODULATION: &str = "excitation.preload-modulation";
/// Rounds in which errors that go with a law are found anew.
const REOPENED: usize = 3;

#[cfg(test)]
mod tests {
    use super::is_trace;

    /// Play that is taken up gradually, on a simulated rig: 430 times the noise without it, 2.01 with a play that is sudden, 1.23 with the further
    /// value of its shape. A tenth of what was missed is no trace of it.
    #[test]
    fn another_formula_leaves_a_trace() {
        assert!(is_trace(430.1, 1.227));
        assert!(!is_trace(430.1, 2.013) && !is_trace(1.4, 1.3) && !is_trace(4.0, 1.3));
        assert!(is_trace(1.0, 1.0));
    }
}
