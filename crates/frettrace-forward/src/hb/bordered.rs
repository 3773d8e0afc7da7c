//! Balance with further unknowns and as many further conditions: curves, and oscillations without excitation.

use super::contact::Contact;
use super::lines::Lines;
use super::solver::Solver;
use super::system::{Problem, pack, unpack};
use crate::ForwardError;
use num_complex::Complex64;

/// Step of the differences by which the further unknowns are differentiated, relative to their scale: the square root
/// of rounding.
const DIFFERENCE: f64 = 1e-8;
/// Contraction up to which the factorised Jacobian is kept, from point to point as well.
const KEEP: f64 = 0.2;
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
    shifted: Vec<Complex64>,
    pub effort: Effort,
}

impl Corrector {
    /// Newton on balance and conditions together; false where it does not converge.
    pub fn correct(
        &mut self,
        solver: &mut Solver,
        contacts: &[Contact],
        conditions: &dyn Conditions,
        state: &mut State,
    ) -> Result<bool, ForwardError> {
        let mut last = f64::INFINITY;
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
            if change <= solver.settings().tolerance {
                return Ok(true);
            }
            if !change.is_finite() || (change > 2.0 * last && last.is_finite()) {
                self.fresh = false;
                return Ok(false);
            }
            self.fresh = change <= KEEP * last;
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
        solver.system.linearise(&problem);
        solver.system.assemble(&problem, extra);
        self.effort.linearisations += 1;
        let size = solver.system.dense.size();
        let inner = size - extra;
        let (mut row, mut here, mut there) = (vec![0.0; inner], vec![0.0; extra], vec![0.0; extra]);
        conditions.values(lines, &state.forces, &state.unknowns, &mut here);
        for e in 0..extra {
            conditions.gradient(lines, e, &mut row);
            (0..inner).for_each(|j| solver.system.dense.matrix[j * size + inner + e] = row[j]);
            let mut unknowns = state.unknowns.clone();
            let step = conditions.scales()[e] * DIFFERENCE;
            unknowns[e] += step;
            let moved = conditions.lines(&unknowns)?;
            let problem = Problem { lines: &moved, contacts };
            solver.system.evaluate(&problem, &state.forces, &mut self.shifted);
            self.effort.evaluations += 1;
            conditions.values(&moved, &state.forces, &unknowns, &mut there);
            let slope: Vec<_> = self.answer.iter().zip(&self.shifted).map(|(a, s)| (a - s) / step).collect();
            let column = &mut solver.system.dense.matrix[(inner + e) * size..(inner + e + 1) * size];
            pack(&slope, solver.system.order, &mut column[..inner]);
            (0..extra).for_each(|i| column[inner + i] = (there[i] - here[i]) / step);
        }
        solver.system.dense.factorise();
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
        self.packed.resize(solver.system.dense.size(), 0.0);
        let inner = self.packed.len() - extra;
        for ((s, a), f) in self.shifted.iter_mut().zip(&self.answer).zip(&state.forces) {
            *s = a - f;
        }
        pack(&self.shifted, solver.system.order, &mut self.packed[..inner]);
        conditions.values(lines, &state.forces, &state.unknowns, &mut self.packed[inner..]);
        self.packed[inner..].iter_mut().for_each(|value| *value = -*value);
        solver.system.dense.solve(&mut self.packed);
        unpack(&self.packed[..inner], solver.system.order, &mut self.shifted);
        let norm = |x: &[Complex64]| x.iter().map(Complex64::norm_sqr).sum::<f64>();
        let mut change = norm(&self.shifted) / norm(&self.answer).max(f64::MIN_POSITIVE);
        state.forces.iter_mut().zip(&self.shifted).for_each(|(f, d)| *f += d);
        for ((p, d), scale) in state.unknowns.iter_mut().zip(&self.packed[inner..]).zip(conditions.scales()) {
            *p += d;
            change += (d / scale).powi(2);
        }
        change.sqrt()
    }
}
