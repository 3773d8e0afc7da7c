//! Tangents of the solution by the implicit function theorem: one factorisation, a right-hand side a parameter.
//!
//! `K df̂/dθ = ∂F/∂θ|_law + ∂F/∂x · (∂x̂0/∂θ − ∂G/∂θ f̂)`.

use super::contact::{Contact, Normal};
use super::element::INPUTS;
use super::lines::Lines;
use super::solver::{Solution, Solver};
use super::system::{Cell, Problem, chain, pack, unpack};
use crate::ForwardError;
use num_complex::Complex64;

/// Tangents of the contact forces, each `D × (H + 1)` like [`Solution::forces`].
#[derive(Clone, Debug, PartialEq)]
pub struct Tangents {
    /// By the parameters of the laws, contact by contact.
    pub law: Vec<Vec<Complex64>>,
    /// By the changes of the structure that were given.
    pub structure: Vec<Vec<Complex64>>,
}

impl Solver {
    /// Tangents at a solution. Each of `structure` holds `∂x̂0/∂θ` and `∂G/∂θ` in place of `x̂0` and `G`.
    ///
    /// # Errors
    /// [`ForwardError::Size`] where a change of the structure or the solution is not shaped like the problem.
    pub fn tangents(
        &mut self,
        problem: &Problem,
        solution: &Solution,
        structure: &[Lines],
    ) -> Result<Tangents, ForwardError> {
        problem.check()?;
        let (count, order) = (problem.lines.forces(), self.settings.order);
        size("lines of the solution", count * (order + 1), solution.forces.len())?;
        for change in structure {
            size("channels of a change of the structure", problem.lines.channels(), change.channels())?;
            size("forces of a change of the structure", count, change.forces())?;
        }
        let mut answer = vec![Complex64::ZERO; solution.forces.len()];
        self.system.evaluate(problem, &solution.forces, &mut answer);
        self.system.linearise(problem);
        self.system.factorise(problem);
        let mut right = Vec::new();
        for index in 0..problem.contacts.len() {
            self.law_sides(problem, index, &mut right);
        }
        let laws = right.len();
        for change in structure {
            let side = self.structure_side(problem, &solution.forces, change);
            right.push(side);
        }
        let mut law = self.back_substitute(right);
        let structure = law.split_off(laws);
        Ok(Tangents { law, structure })
    }

    fn back_substitute(&mut self, mut right: Vec<Vec<Complex64>>) -> Vec<Vec<Complex64>> {
        let (order, size) = (self.settings.order, self.system.dense.size());
        let mut reals = vec![0.0; size * right.len()];
        for (side, column) in right.iter().zip(reals.chunks_exact_mut(size.max(1))) {
            pack(side, order, column);
        }
        if !right.is_empty() {
            self.system.dense.solve(&mut reals);
        }
        for (side, column) in right.iter_mut().zip(reals.chunks_exact(size.max(1))) {
            unpack(column, order, side);
        }
        right
    }

    /// `∂F/∂θ` for the law parameters of one contact.
    fn law_sides(&mut self, problem: &Problem, index: usize, right: &mut Vec<Vec<Complex64>>) {
        let contact = &problem.contacts[index];
        let parameters = contact.element.parameters();
        if parameters == 0 {
            return;
        }
        let cell = std::mem::take(&mut self.system.cells[index]);
        let mut rows = Vec::new();
        contact.element.parameter_partials(&cell.motion, &cell.orbit, &mut rows);
        for parameter in 0..parameters {
            let change: Vec<f64> = rows.iter().skip(parameter).step_by(parameters).copied().collect();
            let width = 2 + parameters;
            let start: Vec<f64> = cell.start.iter().skip(2 + parameter).step_by(width).copied().collect();
            let mut side = vec![Complex64::ZERO; problem.lines.forces() * (self.settings.order + 1)];
            self.add_answer(contact, &cell, [&change, &start], &mut side);
            right.push(side);
        }
        self.system.cells[index] = cell;
    }

    /// `∂F/∂x · (δx̂0 − δG f̂)` over all contacts.
    fn structure_side(&mut self, problem: &Problem, forces: &[Complex64], change: &Lines) -> Vec<Complex64> {
        let mut side = vec![Complex64::ZERO; forces.len()];
        for (index, contact) in problem.contacts.iter().enumerate() {
            let cell = std::mem::take(&mut self.system.cells[index]);
            let motion = self.changed_motion(problem.lines.omega(), contact, forces, change);
            let (steps, start) = changed_steps(contact, &cell, &motion);
            self.add_answer(contact, &cell, [&steps, &start], &mut side);
            self.system.cells[index] = cell;
        }
        side
    }

    /// Samples of the change of slip, slip velocity and normal force.
    fn changed_motion(
        &mut self,
        omega: f64,
        contact: &Contact,
        forces: &[Complex64],
        change: &Lines,
    ) -> [Vec<f64>; 3] {
        let samples = self.settings.samples;
        let mut lines = vec![Complex64::ZERO; self.settings.order + 1];
        let mut motion = [vec![0.0; samples], vec![0.0; samples], vec![0.0; samples]];
        change.respond(contact.slip, forces, &mut lines);
        self.system.samples_of(&lines, &mut motion[0]);
        lines.iter_mut().enumerate().for_each(|(h, x)| *x *= Complex64::new(0.0, h as f64 * omega));
        self.system.samples_of(&lines, &mut motion[1]);
        if let Normal::Channel(channel) = contact.normal {
            change.respond(channel, forces, &mut lines);
            self.system.samples_of(&lines, &mut motion[2]);
        }
        motion
    }

    fn add_answer(
        &mut self,
        contact: &Contact,
        cell: &Cell,
        [change, start]: [&[f64]; 2],
        side: &mut [Complex64],
    ) {
        let (outputs, row) = (contact.element.forces(), self.settings.order + 1);
        let mut forces = vec![0.0; self.settings.samples * outputs];
        chain(contact, cell, self.settings.samples).real(change, start, &mut forces);
        for (o, target) in contact.outputs().into_iter().enumerate() {
            if let Some(target) = target {
                let lines = &mut side[target * row..(target + 1) * row];
                self.system.add_lines(&forces, [o, outputs], lines);
            }
        }
    }
}

/// What a change of motion does in every step, and to the start from rest.
fn changed_steps(contact: &Contact, cell: &Cell, motion: &[Vec<f64>; 3]) -> (Vec<f64>, Vec<f64>) {
    let (m, o) = (contact.element.states(), contact.element.forces());
    let (width, samples) = (m + INPUTS, motion[0].len());
    let mut steps = Vec::with_capacity(samples * (m + o));
    for (k, block) in cell.partials.rows.chunks_exact((m + o) * width).enumerate() {
        let new = if k + 1 == samples { 0 } else { k + 1 };
        for row in block.chunks_exact(width) {
            let inputs = row[m..].chunks_exact(2).zip(motion);
            steps.push(inputs.map(|(pair, x)| pair[0] * x[k] + pair[1] * x[new]).sum());
        }
    }
    let rows = cell.start.chunks_exact(2 + contact.element.parameters());
    let start = rows.map(|row| row[0] * motion[0][0] + row[1] * motion[2][0]).collect();
    (steps, start)
}

fn size(what: &'static str, expected: usize, found: usize) -> Result<(), ForwardError> {
    if expected == found { Ok(()) } else { Err(ForwardError::Size { what, expected, found }) }
}
