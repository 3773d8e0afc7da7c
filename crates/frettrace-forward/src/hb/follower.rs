//! What a curve remembers of itself while it is followed, and its next step.

use super::bordered::{Conditions, Corrector, Effort, State};
use super::contact::Contact;
use super::continuation::{Curve, Point, Sweep, SweepStatus};
use super::lines::Lines;
use super::network::Network;
use super::newton::Status;
use super::solver::Solver;
use super::system::{Problem, pack};
use crate::ForwardError;
use num_complex::Complex64;

/// Points the predictor goes through.
const MEMORY: usize = 4;
/// First step, as a share of the longest.
const FIRST: f64 = 0.2;
/// Shortest step, as a share of the range.
const SHORTEST: f64 = 1e-7;
/// Error of the predictor, in units of what is aimed at, from which the step is made again.
const FAR_OFF: f64 = 30.0;

/// Arclengths beside the last point at which a jump is looked for, all short beside the range and the forces, …
const BESIDE: [f64; 3] = [1e-7, 1e-6, 1e-5];
/// … and the share of the forces by which what the contacts answer then differs: a law without a jump answers with a share that is of the
/// order of the arclength times its stiffness over the structure's, a thousand at most.
const FINITE: f64 = 0.03;

/// The plane across the predictor: `Σ t (y − y₀) = 0` in scaled variables.
struct Plane<'a> {
    network: &'a Network,
    sweep: &'a Sweep,
    order: usize,
    base: State,
    normal: Vec<f64>,
    force_scale: f64,
    scales: [f64; 1],
}

impl Conditions for Plane<'_> {
    fn lines(&self, unknowns: &[f64]) -> Result<Lines, ForwardError> {
        self.network.lines(unknowns[0], self.order, self.sweep.level)
    }

    fn scales(&self) -> &[f64] {
        &self.scales
    }

    fn values(&self, _: &Lines, forces: &[Complex64], unknowns: &[f64], values: &mut [f64]) {
        let moved: Vec<_> = forces.iter().zip(&self.base.forces).map(|(f, b)| f - b).collect();
        let mut packed = vec![0.0; self.normal.len() - 1];
        pack(&moved, self.order, &mut packed);
        let along: f64 = packed.iter().zip(&self.normal).map(|(x, t)| x * t / self.force_scale).sum();
        let last = self.normal[packed.len()];
        values[0] = along + last * (unknowns[0] - self.base.unknowns[0]) / self.scales[0];
    }

    fn gradient(&self, _: &Lines, _: usize, row: &mut [f64]) {
        row.iter_mut().zip(&self.normal).for_each(|(r, t)| *r = t / self.force_scale);
    }
}

/// Points behind the predictor with their arclengths, the newest last.
pub(super) struct Track {
    states: Vec<(f64, State)>,
    width: f64,
    force_scale: f64,
}

impl Track {
    /// Polynomial through the last `count` points at `s`, and its derivative.
    fn predict(&self, s: f64, count: usize) -> (State, State) {
        let states = &self.states[self.states.len().saturating_sub(count)..];
        let (_, first) = &states[0];
        let zero = || State { forces: vec![Complex64::ZERO; first.forces.len()], unknowns: vec![0.0] };
        let (mut at, mut slope) = (zero(), zero());
        for (i, (si, state)) in states.iter().enumerate() {
            let others = || states.iter().enumerate().filter(move |(j, _)| *j != i);
            let weight: f64 = others().map(|(_, (sj, _))| (s - sj) / (si - sj)).product();
            let change: f64 = others()
                .map(|(k, (sk, _))| {
                    let rest = others().filter(|(j, _)| *j != k).map(|(_, (sj, _))| (s - sj) / (si - sj));
                    rest.product::<f64>() / (si - sk)
                })
                .sum();
            for (target, factor) in [(&mut at, weight), (&mut slope, change)] {
                target.forces.iter_mut().zip(&state.forces).for_each(|(t, f)| *t += f * factor);
                target.unknowns[0] += state.unknowns[0] * factor;
            }
        }
        (at, slope)
    }

    fn distance(&self, a: &State, b: &State) -> f64 {
        let forces = distance(&a.forces, &b.forces) / self.force_scale;
        forces.hypot((a.unknowns[0] - b.unknowns[0]) / self.width)
    }

    fn push(&mut self, state: State) {
        let s = self.states.last().map_or(0.0, |(s, last)| s + self.distance(last, &state));
        self.states.push((s, state));
        if self.states.len() > MEMORY {
            self.states.remove(0);
        }
    }
}

/// What became of a step.
pub(super) enum Advance {
    /// A point that fits the prediction.
    Reached(State),
    /// None: the next try is shorter.
    Rejected,
    /// The steps became too short, and why.
    Ended(SweepStatus),
}

/// A curve that grows point by point, with whichever solver is handed to it.
pub(super) struct Follower<'a> {
    network: &'a Network,
    contacts: &'a [Contact<'a>],
    sweep: &'a Sweep,
    curve: Curve,
    track: Track,
    corrector: Corrector,
    step: f64,
}

impl<'a> Follower<'a> {
    pub fn new(network: &'a Network, contacts: &'a [Contact<'a>], sweep: &'a Sweep) -> Self {
        let width = (sweep.range[1] - sweep.range[0]).abs();
        Self {
            network,
            contacts,
            sweep,
            curve: Curve {
                points: Vec::new(),
                status: SweepStatus::NoStart,
                evaluations: 0,
                linearisations: 0,
            },
            track: Track { states: Vec::new(), width, force_scale: 1.0 },
            corrector: Corrector::default(),
            step: FIRST * sweep.longest,
        }
    }

    /// Number of points.
    pub fn points(&self) -> usize {
        self.curve.points.len()
    }

    /// A direction needs two points at given frequencies.
    pub fn wants_start(&self) -> bool {
        self.curve.points.len() < 2
    }

    /// The next point at a given frequency; `None` where there is none.
    pub fn start(&mut self, solver: &mut Solver) -> Result<Option<()>, ForwardError> {
        let [from, to] = self.sweep.range;
        let omega = from + self.points() as f64 * FIRST * self.sweep.longest * (to - from);
        let near = self.curve.points.last().map(|point| point.forces.clone());
        let Some(forces) = self.solve_at(solver, omega, near.as_deref())? else { return Ok(None) };
        self.track.force_scale = size(&forces);
        self.track.push(State { forces: forces.clone(), unknowns: vec![omega] });
        self.curve.points.push(Point { omega, forces, truncation: None, turned: false });
        Ok(Some(()))
    }

    /// The balance at a given frequency.
    fn solve_at(
        &mut self,
        solver: &mut Solver,
        omega: f64,
        near: Option<&[Complex64]>,
    ) -> Result<Option<Vec<Complex64>>, ForwardError> {
        let lines = self.network.lines(omega, solver.settings().order, self.sweep.level)?;
        let solution = solver.solve(&Problem { lines: &lines, contacts: self.contacts }, near)?;
        self.curve.evaluations += solution.evaluations;
        self.curve.linearisations += solution.linearisations;
        Ok((solution.status == Status::Converged).then_some(solution.forces))
    }

    /// One step along the curve.
    pub fn advance(&mut self, solver: &mut Solver) -> Result<Advance, ForwardError> {
        let s = self.track.states.last().map_or(0.0, |(s, _)| *s);
        let count = if self.corrector.careful { 2 } else { MEMORY };
        let (predicted, slope) = self.track.predict(s + self.step, count);
        let plane = self.plane(solver.settings().order, (&predicted, &slope));
        let mut state = predicted.clone();
        let converged = self.corrector.correct(solver, self.contacts, &plane, &mut state)?;
        let error = self.track.distance(&state, &predicted);
        if !converged || error > FAR_OFF * self.sweep.resolution {
            self.step *= 0.4;
            self.corrector.forget();
            self.corrector.careful = true;
            let ended = self.step < SHORTEST;
            return Ok(if ended { Advance::Ended(self.end(solver)?) } else { Advance::Rejected });
        }
        self.corrector.careful = false;
        let used = count.min(self.track.states.len());
        let growth = (self.sweep.resolution / error.max(1e-12)).powf(1.0 / used as f64);
        self.step = (self.step * (0.9 * growth).clamp(0.4, 2.0)).min(self.sweep.longest);
        Ok(Advance::Reached(state))
    }

    /// Why no step is short enough: beside the last point the contacts answer a little motion with a finite force, or not.
    fn end(&self, solver: &mut Solver) -> Result<SweepStatus, ForwardError> {
        let Some((s, last)) = self.track.states.last() else { return Ok(SweepStatus::Stalled) };
        let here = self.answer(solver, last)?;
        for beside in BESIDE {
            let (moved, _) = self.track.predict(s + beside, 2);
            let change = distance(&self.answer(solver, &moved)?, &here);
            if change > FINITE * size(&here) {
                return Ok(SweepStatus::Jumped);
            }
        }
        Ok(SweepStatus::Stalled)
    }

    /// What the contacts answer to the forces of a state.
    fn answer(&self, solver: &mut Solver, state: &State) -> Result<Vec<Complex64>, ForwardError> {
        let lines = self.network.lines(state.unknowns[0], solver.settings().order, self.sweep.level)?;
        let mut answer = state.forces.clone();
        solver.system.evaluate(
            &Problem { lines: &lines, contacts: self.contacts },
            &state.forces,
            &mut answer,
        );
        Ok(answer)
    }

    fn plane(&self, order: usize, (predicted, slope): (&State, &State)) -> Plane<'a> {
        let count = slope.forces.len() / (order + 1) * (2 * order + 1);
        let mut normal = vec![0.0; count + 1];
        pack(&slope.forces, order, &mut normal[..count]);
        normal[..count].iter_mut().for_each(|t| *t /= self.track.force_scale);
        normal[count] = slope.unknowns[0] / self.track.width;
        Plane {
            network: self.network,
            sweep: self.sweep,
            order,
            base: predicted.clone(),
            normal,
            force_scale: self.track.force_scale,
            scales: [self.track.width],
        }
    }

    /// Puts the last points, and with them the direction, on the order of another solver; false where one of them cannot be
    /// found there, and nothing has changed then.
    pub fn change_order(&mut self, solver: &mut Solver) -> Result<bool, ForwardError> {
        let order = solver.settings().order;
        let last = self.track.states.len().saturating_sub(2);
        let mut states: Vec<State> =
            self.track.states[last..].iter().map(|(_, state)| state.clone()).collect();
        let rows = self.network.forces.len();
        states.iter_mut().for_each(|state| state.forces = resized(&state.forces, rows, order));
        let mut fresh = Track { states: Vec::new(), ..self.track };
        states.iter().for_each(|state| fresh.push(state.clone()));
        let (_, slope) = fresh.predict(0.0, 2);
        fresh.states.clear();
        for mut state in states {
            let plane = self.plane(order, (&state.clone(), &slope));
            let mut corrector = Corrector::default();
            let found = corrector.correct(solver, self.contacts, &plane, &mut state)?;
            self.curve.evaluations += corrector.effort.evaluations;
            self.curve.linearisations += corrector.effort.linearisations;
            if !found {
                return Ok(false);
            }
            fresh.push(state);
        }
        self.track = fresh;
        self.corrector.forget();
        Ok(true)
    }

    /// [`super::Solution::truncation`] of the state reached last, for each of two orders at which it might be cut.
    pub fn truncation(
        &self,
        solver: &mut Solver,
        state: &State,
        cuts: [usize; 2],
    ) -> Result<[f64; 2], ForwardError> {
        let order = 2 * solver.settings().order;
        let lines = self.network.lines(state.unknowns[0], order, self.sweep.level)?;
        Ok(solver.truncation_above(&Problem { lines: &lines, contacts: self.contacts }, cuts))
    }

    /// The last point.
    pub fn last(&self) -> Option<&State> {
        self.track.states.last().map(|(_, state)| state)
    }

    /// Notes how exact the last point is.
    pub fn note(&mut self, truncation: f64) {
        if let Some(point) = self.curve.points.last_mut() {
            point.truncation = Some(truncation);
        }
    }

    /// Starts anew from nothing: the first points are wanted again.
    pub fn restart(&mut self) {
        self.curve.points.clear();
        self.track.states.clear();
    }

    /// Adds a point; one beyond the range is put on its end.
    pub fn accept(
        &mut self,
        solver: &mut Solver,
        state: State,
        truncation: Option<f64>,
    ) -> Result<Option<SweepStatus>, ForwardError> {
        let [from, to] = self.sweep.range;
        let share = (state.unknowns[0] - from) / (to - from);
        let ended = match share {
            x if x >= 1.0 => Some((SweepStatus::Finished, to)),
            x if x <= 0.0 => Some((SweepStatus::Returned, from)),
            _ => None,
        };
        if let Some((status, omega)) = ended {
            // Where the balance has no solution near the end, the point beyond it is left out.
            if let Some(forces) = self.solve_at(solver, omega, Some(&state.forces))? {
                self.curve.points.push(Point { omega, forces, truncation, turned: false });
            }
            return Ok(Some(status));
        }
        let omega = state.unknowns[0];
        let points = &self.curve.points;
        let turned = match points.as_slice() {
            [.., before, last] => (omega - last.omega) * (last.omega - before.omega) < 0.0,
            _ => false,
        };
        self.track.force_scale = size(&state.forces).max(0.1 * self.track.force_scale);
        self.curve.points.push(Point { omega, forces: state.forces.clone(), truncation, turned });
        self.track.push(state);
        Ok(None)
    }

    /// The curve as far as it has come.
    pub fn curve(mut self, status: SweepStatus) -> Curve {
        let Effort { evaluations, linearisations } = self.corrector.effort;
        self.curve.evaluations += evaluations;
        self.curve.linearisations += linearisations;
        Curve { status, ..self.curve }
    }
}

/// Lines of every force, cut or padded.
fn resized(forces: &[Complex64], rows: usize, order: usize) -> Vec<Complex64> {
    let (old, new) = (forces.len() / rows.max(1), order + 1);
    let mut out = vec![Complex64::ZERO; rows * new];
    for (to, from) in out.chunks_exact_mut(new).zip(forces.chunks_exact(old.max(1))) {
        let both = new.min(old);
        to[..both].copy_from_slice(&from[..both]);
    }
    out
}

fn distance(a: &[Complex64], b: &[Complex64]) -> f64 {
    a.iter().zip(b).map(|(x, y)| (x - y).norm_sqr()).sum::<f64>().sqrt()
}

fn size(forces: &[Complex64]) -> f64 {
    forces.iter().map(Complex64::norm_sqr).sum::<f64>().sqrt().max(f64::MIN_POSITIVE)
}
