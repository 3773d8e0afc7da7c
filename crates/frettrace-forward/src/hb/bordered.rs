//! Balance with further unknowns and as many further conditions: curves, and oscillations without excitation.

use super::contact::Contact;
use super::lines::Lines;
use super::solver::Solver;
use super::system::{Problem, System, pack, unpack};
use crate::ForwardError;
use num_complex::Complex64;

/// Step of the differences by which the further unknowns are differentiated, relative to their scale: the square root
/// of rounding.
const DIFFERENCE: f64 = 1e-8;
/// Contraction up to which the factorised Jacobian is kept, from point to point as well; Broyden's updates help it.
const KEEP: f64 = 0.5;
/// The same for Jacobians from fewer samples: they cost less than a balance more.
const KEEP_CHEAP: f64 = 0.2;
/// Contraction from which the size of the next correction is foretold.
const SURE: f64 = 0.2;
/// Corrections before a step counts as lost.
const LIMIT: usize = 16;

/// A family of structures with conditions that pick one of them.
pub(super) trait Conditions {
    /// The structure at these values of the further unknowns.
    fn lines(&self, unknowns: &[f64]) -> Result<Lines, ForwardError>;
    /// Scales of the further unknowns.
    fn scales(&self) -> &[f64];
    /// Values of the conditions: zero at the solution.
    fn values(&self, lines: &Lines, forces: &[Complex64], unknowns: &[f64], values: &mut [f64]);
    /// Derivatives of a condition by the packed forces.
    fn gradient(&self, lines: &Lines, condition: usize, row: &mut [f64]);
}

/// A point on a curve: contact forces and further unknowns.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct State {
    pub forces: Vec<Complex64>,
    pub unknowns: Vec<f64>,
}

/// What the corrector did.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Effort {
    pub evaluations: usize,
    pub linearisations: usize,
}

/// The corrector; its Jacobian lives in the solver it is used with.
#[derive(Default)]
pub(super) struct Corrector {
    fresh: bool,
    packed: Vec<f64>,
    answer: Vec<Complex64>,
    /// What the contacts answer with in the system the Jacobian is taken from.
    base: Vec<Complex64>,
    shifted: Vec<Complex64>,
    /// Corrections since the Jacobian or the point was new, with their squares.
    history: Vec<(Vec<f64>, f64)>,
    pub effort: Effort,
    /// Whether the Jacobian is taken from all samples, however many there are.
    pub careful: bool,
}

impl Corrector {
    /// The system whose Jacobian is taken, and whether it has fewer samples than the balance.
    fn slopes<'s>(&self, solver: &'s mut Solver) -> &'s mut System {
        if self.careful { &mut solver.system } else { solver.slopes() }
    }

    fn cheap(&self, solver: &Solver) -> bool {
        solver.coarse.is_some() && !self.careful
    }

    /// Newton on balance and conditions together; false where it does not converge.
    pub fn correct(
        &mut self,
        solver: &mut Solver,
        contacts: &[Contact],
        conditions: &dyn Conditions,
        state: &mut State,
    ) -> Result<bool, ForwardError> {
        let mut last = f64::INFINITY;
        let cheap = self.cheap(solver);
        self.fresh &= !cheap;
        self.history.clear();
        let size = state.forces.len();
        self.answer.resize(size, Complex64::ZERO);
        self.shifted.resize(size, Complex64::ZERO);
        for _ in 0..LIMIT {
            let lines = conditions.lines(&state.unknowns)?;
            let problem = Problem { lines: &lines, contacts };
            solver.system.evaluate(&problem, &state.forces, &mut self.answer);
            self.effort.evaluations += 1;
            if !self.fresh {
                self.build(solver, contacts, conditions, (state, &lines))?;
            }
            let change = self.step(solver, conditions, state, &lines);
            // What the next correction will be, once two in a row have shown how they shrink.
            let shrink = if last.is_finite() { (change / last).min(1.0) } else { 1.0 };
            if change * if shrink < SURE { shrink } else { 1.0 } <= solver.settings().tolerance {
                return Ok(true);
            }
            if !change.is_finite() || (change > 2.0 * last && last.is_finite()) {
                self.fresh = false;
                return Ok(false);
            }
            self.fresh = change <= if cheap { KEEP_CHEAP } else { KEEP } * last;
            last = change;
        }
        self.fresh = false;
        Ok(false)
    }

    /// Forgets the Jacobian.
    pub fn forget(&mut self) {
        self.fresh = false;
    }

    /// The Jacobian at the state that was evaluated last, bordered and factorised.
    fn build(
        &mut self,
        solver: &mut Solver,
        contacts: &[Contact],
        conditions: &dyn Conditions,
        (state, lines): (&State, &Lines),
    ) -> Result<(), ForwardError> {
        let problem = Problem { lines, contacts };
        let extra = state.unknowns.len();
        let cheap = self.cheap(solver);
        let system = self.slopes(solver);
        self.base.clone_from(&self.answer);
        if cheap {
            system.evaluate(&problem, &state.forces, &mut self.base);
            self.effort.evaluations += 1;
        }
        system.linearise(&problem);
        system.assemble(&problem, extra);
        self.effort.linearisations += 1;
        let size = system.dense.size();
        let inner = size - extra;
        let (mut row, mut here, mut there) = (vec![0.0; inner], vec![0.0; extra], vec![0.0; extra]);
        conditions.values(lines, &state.forces, &state.unknowns, &mut here);
        for e in 0..extra {
            conditions.gradient(lines, e, &mut row);
            (0..inner).for_each(|j| system.dense.matrix[j * size + inner + e] = row[j]);
            let mut unknowns = state.unknowns.clone();
            let step = conditions.scales()[e] * DIFFERENCE;
            unknowns[e] += step;
            let moved = conditions.lines(&unknowns)?;
            let problem = Problem { lines: &moved, contacts };
            system.evaluate(&problem, &state.forces, &mut self.shifted);
            self.effort.evaluations += 1;
            conditions.values(&moved, &state.forces, &unknowns, &mut there);
            let slope: Vec<_> = self.base.iter().zip(&self.shifted).map(|(a, s)| (a - s) / step).collect();
            let column = &mut system.dense.matrix[(inner + e) * size..(inner + e + 1) * size];
            pack(&slope, system.order, &mut column[..inner]);
            (0..extra).for_each(|i| column[inner + i] = (there[i] - here[i]) / step);
        }
        system.dense.factorise();
        self.history.clear();
        self.fresh = true;
        Ok(())
    }

    /// One correction; gives its size.
    fn step(
        &mut self,
        solver: &mut Solver,
        conditions: &dyn Conditions,
        state: &mut State,
        lines: &Lines,
    ) -> f64 {
        let extra = state.unknowns.len();
        self.packed.resize(self.slopes(solver).dense.size(), 0.0);
        let inner = self.packed.len() - extra;
        for ((s, a), f) in self.shifted.iter_mut().zip(&self.answer).zip(&state.forces) {
            *s = a - f;
        }
        pack(&self.shifted, solver.system.order, &mut self.packed[..inner]);
        conditions.values(lines, &state.forces, &state.unknowns, &mut self.packed[inner..]);
        self.packed[inner..].iter_mut().for_each(|value| *value = -*value);
        let system = if self.careful { &mut solver.system } else { solver.slopes() };
        system.dense.solve(&mut self.packed);
        let size: f64 = self.answer.iter().map(Complex64::norm_sqr).sum();
        let scale = size.sqrt().max(f64::MIN_POSITIVE);
        self.packed[..inner].iter_mut().for_each(|x| *x /= scale);
        self.packed[inner..].iter_mut().zip(conditions.scales()).for_each(|(x, s)| *x /= s);
        let change = self.update();
        self.packed[..inner].iter_mut().for_each(|x| *x *= scale);
        unpack(&self.packed[..inner], solver.system.order, &mut self.shifted);
        state.forces.iter_mut().zip(&self.shifted).for_each(|(f, d)| *f += d);
        let unknowns = state.unknowns.iter_mut().zip(&self.packed[inner..]).zip(conditions.scales());
        unknowns.for_each(|((p, d), scale)| *p += d * scale);
        change
    }

    /// Broyden's rank-one updates, kept as corrections (C. T. Kelley, *Iterative Methods for Linear and Nonlinear
    /// Equations*, 1995, algorithm brsol); gives the size of the correction.
    fn update(&mut self) -> f64 {
        let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(x, y)| x * y).sum::<f64>();
        for pair in self.history.windows(2) {
            let factor = dot(&pair[0].0, &self.packed) / pair[0].1;
            self.packed.iter_mut().zip(&pair[1].0).for_each(|(z, s)| *z += factor * s);
        }
        if let Some((last, square)) = self.history.last() {
            let rest = 1.0 - dot(last, &self.packed) / square;
            self.packed.iter_mut().for_each(|z| *z /= rest);
        }
        let square = dot(&self.packed, &self.packed);
        self.history.push((self.packed.clone(), square));
        square.sqrt()
    }
}
