//! Harmonic order and sampling chosen for a stated accuracy.

use super::contact::Contact;
use super::continuation::{Curve, Sweep, SweepStatus};
use super::follower::{Advance, Follower};
use super::lines::Lines;
use super::network::Network;
use super::solver::{Settings, Solution, Solver};
use super::system::{Problem, System};
use crate::ForwardError;
use num_complex::Complex64;

/// What is asked of a solution, and how far the solver may go for it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Accuracy {
    /// Largest motion that the harmonics cut off may cause, relative to the motion of the contacts' channels
    /// ([`Solution::truncation`]).
    pub truncation: f64,
    /// Largest change of the contact forces at twice the samples, relative to the forces ([`Adapted::sampling`]).
    pub sampling: f64,
    /// Lowest and highest order.
    pub orders: [usize; 2],
    /// Samples of the first try, and of curves throughout, for each line. Kinks in the force alias below a hundredth of a per
    /// cent with 8; what turns within a small slip or velocity wants samples inside it.
    pub samples_a_line: usize,
    /// Most samples a period.
    pub samples: usize,
}

impl Default for Accuracy {
    fn default() -> Self {
        Self { truncation: 1e-4, sampling: 1e-4, orders: [15, 127], samples_a_line: 8, samples: 4096 }
    }
}

/// A solution with the accuracy reached: where it is less than asked, the limits were.
#[derive(Clone, Debug, PartialEq)]
pub struct Adapted {
    /// The solution.
    pub solution: Solution,
    /// Order and sampling of it.
    pub settings: Settings,
    /// Change of the contact forces at twice the samples, relative to the forces: an estimate of aliasing and of the
    /// step error of the laws together.
    pub sampling: f64,
}

/// An order is lowered again where the lower one would be this much better than asked.
const MARGIN: f64 = 3.0;

/// A solver that raises order and sampling until the accuracy is reached; memory of every order is kept.
pub struct AdaptiveSolver {
    accuracy: Accuracy,
    settings: Settings,
    solvers: Vec<Solver>,
}

impl AdaptiveSolver {
    /// A solver for this accuracy; tolerance and iterations are those of `settings`.
    #[must_use]
    pub fn new(accuracy: Accuracy, settings: Settings) -> Self {
        Self { accuracy, settings, solvers: Vec::new() }
    }

    /// Solves with the lowest order and sampling that reach the accuracy, from the lines `start` or from none.
    ///
    /// The truncation is known only as far as the problem has lines: give them up to twice the highest order.
    ///
    /// # Errors
    /// As of [`Solver::solve`]; [`ForwardError::Size`] where the lines do not reach the lowest order.
    pub fn solve(&mut self, problem: &Problem, start: Option<&[Complex64]>) -> Result<Adapted, ForwardError> {
        let [lowest, highest] = self.accuracy.orders;
        if problem.lines.order() < lowest {
            let found = problem.lines.order();
            return Err(ForwardError::Size { what: "order of the lines", expected: lowest, found });
        }
        let highest = highest.min(problem.lines.order());
        let (mut order, mut samples) = (lowest, self.samples_for(lowest));
        let mut start = start.map(<[Complex64]>::to_vec);
        loop {
            let settings = Settings { order, samples, ..self.settings };
            let solution = self.solver(settings)?.solve(problem, start.as_deref())?;
            let sampling = sampling_error(problem, &solution, &settings)?;
            let coarse = sampling > self.accuracy.sampling && 2 * samples <= self.accuracy.samples;
            let cut = solution.truncation > self.accuracy.truncation && order < highest;
            if !(coarse || cut) {
                return Ok(Adapted { solution, settings, sampling });
            }
            if cut {
                order = (2 * order + 1).min(highest);
            }
            if coarse {
                samples *= 2;
            }
            samples = samples.max(self.samples_for(order));
            start = Some(solution.forces);
        }
    }

    /// Follows the response of a network over a range of base frequencies; the order of each point is the lowest one of the ladder
    /// `H, 2H + 1, …` whose truncation is below the one asked, or the highest. [`Accuracy::sampling`] is not asked for.
    ///
    /// # Errors
    /// A problem that is not one: see [`ForwardError`].
    pub fn follow(
        &mut self,
        network: &Network,
        contacts: &[Contact],
        sweep: &Sweep,
    ) -> Result<Curve, ForwardError> {
        let mut follower = Follower::new(network, contacts, sweep);
        let mut order = self.accuracy.orders[0];
        while follower.wants_start() {
            if follower.start(self.at_order(order)?)?.is_none() {
                return Ok(follower.curve(SweepStatus::NoStart));
            }
            let Some(first) = follower.last().cloned() else { continue };
            let cut = follower.truncation(self.at_order(order)?, &first, [order; 2])?[0];
            follower.note(cut);
            if cut > self.accuracy.truncation && order < self.accuracy.orders[1] {
                order = self.above(order);
                follower.restart();
            }
        }
        while follower.points() < sweep.points {
            let state = match follower.advance(self.at_order(order)?)? {
                Advance::Reached(state) => state,
                Advance::Rejected => continue,
                Advance::Ended(status) => return Ok(follower.curve(status)),
            };
            let lower = self.below(order);
            let cuts = follower.truncation(self.at_order(order)?, &state, [order, lower])?;
            let above = self.above(order);
            if cuts[0] > self.accuracy.truncation
                && above > order
                && follower.change_order(self.at_order(above)?)?
            {
                order = above;
                continue;
            }
            if let Some(status) = follower.accept(self.at_order(order)?, state, Some(cuts[0]))? {
                return Ok(follower.curve(status));
            }
            if lower < order
                && MARGIN * cuts[1] < self.accuracy.truncation
                && follower.change_order(self.at_order(lower)?)?
            {
                order = lower;
            }
        }
        Ok(follower.curve(SweepStatus::PointLimit))
    }

    /// The solver of an order, with the samples of curves.
    pub(super) fn at_order(&mut self, order: usize) -> Result<&mut Solver, ForwardError> {
        let samples = self.samples_for(order);
        self.solver(Settings { order, samples, ..self.settings })
    }

    fn samples_for(&self, order: usize) -> usize {
        (self.accuracy.samples_a_line * (order + 1)).next_power_of_two()
    }

    fn above(&self, order: usize) -> usize {
        (2 * order + 1).min(self.accuracy.orders[1])
    }

    /// The order from which [`Self::above`] comes here.
    fn below(&self, order: usize) -> usize {
        let mut below = self.accuracy.orders[0];
        while below < order && self.above(below) < order {
            below = self.above(below);
        }
        below
    }

    fn solver(&mut self, settings: Settings) -> Result<&mut Solver, ForwardError> {
        let found = self.solvers.iter().position(|s| *s.settings() == settings);
        let index = match found {
            Some(index) => index,
            None => {
                self.solvers.push(Solver::new(settings)?);
                self.solvers.len() - 1
            }
        };
        Ok(&mut self.solvers[index])
    }
}

/// Relative change of the forces that the contacts answer with, at twice the samples.
fn sampling_error(problem: &Problem, solution: &Solution, settings: &Settings) -> Result<f64, ForwardError> {
    let mut answers = [solution.forces.clone(), solution.forces.clone()];
    for (answer, factor) in answers.iter_mut().zip([1, 2]) {
        System::new(settings.order, factor * settings.samples)?.evaluate(problem, &solution.forces, answer);
    }
    let square = |x: &mut dyn Iterator<Item = Complex64>| x.map(|v| v.norm_sqr()).sum::<f64>();
    let change = square(&mut answers[0].iter().zip(&answers[1]).map(|(a, b)| a - b));
    let whole = square(&mut answers[1].iter().copied());
    Ok(if change == 0.0 { 0.0 } else { (change / whole).sqrt() })
}

impl Lines {
    /// Lines of the motion of a channel up to the lines' own order, under forces of any order.
    #[must_use]
    pub fn motion(&self, channel: usize, forces: &[Complex64]) -> Vec<Complex64> {
        let mut motion = vec![Complex64::ZERO; self.order() + 1];
        self.respond(channel, forces, &mut motion);
        motion
    }
}
