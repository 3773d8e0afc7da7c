//! The balance `R(f̂) = f̂ − F(x(f̂))` of a run: forces assumed minus forces the contacts answer with, and its Jacobian.

use super::chain::{Chain, Gains, LANES};
use super::contact::{Contact, Normal, STATE_LIMIT};
use super::dense::Dense;
use super::element::{Motion, Orbit, Partials};
use super::lines::Lines;
use super::period::{Closure, Memory, close};
use crate::ForwardError;
use frettrace_fourier::{Grid, GridScratch};
use num_complex::Complex64;
use rustfft::{Fft, FftPlanner};
use std::sync::Arc;

/// One run: its structure and its contacts.
#[derive(Clone, Copy)]
pub struct Problem<'a> {
    /// The structure.
    pub lines: &'a Lines,
    /// The contacts; several may add to one force.
    pub contacts: &'a [Contact<'a>],
}

impl Problem<'_> {
    pub(super) fn check(&self) -> Result<(), ForwardError> {
        if !(self.lines.omega() > 0.0 && self.lines.omega().is_finite()) {
            return Err(ForwardError::NotPositive {
                what: "base frequency [rad/s]",
                found: self.lines.omega(),
            });
        }
        for (contact, connected) in self.contacts.iter().enumerate() {
            let check = |what, index, available| {
                let error = ForwardError::Index { contact, what, index, available };
                if index < available { Ok(()) } else { Err(error) }
            };
            check("channel", connected.slip, self.lines.channels())?;
            if let Normal::Channel(index) = connected.normal {
                check("channel", index, self.lines.channels())?;
            }
            for force in connected.outputs().into_iter().flatten() {
                check("force", force, self.lines.forces())?;
            }
            let found = connected.element.states();
            if found > STATE_LIMIT {
                return Err(ForwardError::States { contact, found, limit: STATE_LIMIT });
            }
        }
        Ok(())
    }
}

/// Memory of one contact.
#[derive(Default)]
pub(super) struct Cell {
    pub motion: Motion,
    pub orbit: Orbit,
    pub partials: Partials,
    pub start: Vec<f64>,
}

/// The balance with all its memory, for one order and sampling.
pub(super) struct System {
    pub order: usize,
    pub samples: usize,
    grid: Grid,
    scratch: GridScratch,
    /// A grid of the same samples and more lines, as the truncation was last asked for.
    wide: Option<(Grid, GridScratch)>,
    transform: Arc<dyn Fft<f64>>,
    transform_scratch: Vec<Complex64>,
    columns: Vec<Complex64>,
    signal: Vec<f64>,
    spectrum: Vec<Complex64>,
    pub cells: Vec<Cell>,
    pub dense: Dense,
    /// Worst closure of the last evaluation.
    pub closure: Closure,
}

impl System {
    pub fn new(order: usize, samples: usize) -> Result<Self, ForwardError> {
        let grid = Grid::new(order, samples)?;
        let transform = FftPlanner::new().plan_fft_forward(samples);
        Ok(Self {
            order,
            samples,
            scratch: grid.scratch(),
            wide: None,
            grid,
            transform_scratch: vec![Complex64::ZERO; transform.get_inplace_scratch_len()],
            transform,
            columns: Vec::new(),
            signal: vec![0.0; samples],
            spectrum: vec![Complex64::ZERO; order + 1],
            cells: Vec::new(),
            dense: Dense::new(),
            closure: Closure { mismatch: 0.0 },
        })
    }

    /// Forces the contacts answer with: `answer` (`D × (H + 1)`) from `forces` of the same shape.
    pub fn evaluate(&mut self, problem: &Problem, forces: &[Complex64], answer: &mut [Complex64]) {
        self.cells.resize_with(problem.contacts.len(), Cell::default);
        answer.fill(Complex64::ZERO);
        self.closure = Closure { mismatch: 0.0 };
        for (index, contact) in problem.contacts.iter().enumerate() {
            self.move_contact(problem.lines, contact, forces, index);
            let cell = &mut self.cells[index];
            let closure = close(contact.element, &cell.motion, &mut cell.orbit, &mut cell.partials);
            self.closure.mismatch = self.closure.mismatch.max(closure.mismatch);
            for (o, force) in contact.outputs().into_iter().enumerate() {
                if let Some(force) = force {
                    let row = self.order + 1;
                    let lines = &mut answer[force * row..(force + 1) * row];
                    self.add_force(index, [o, contact.element.forces()], lines);
                }
            }
        }
    }

    fn add_force(&mut self, cell: usize, [output, outputs]: [usize; 2], row: &mut [Complex64]) {
        let forces = self.cells[cell].orbit.forces.iter().skip(output).step_by(outputs);
        self.signal.iter_mut().zip(forces).for_each(|(s, f)| *s = *f);
        self.grid.project(&self.signal, &mut self.spectrum, &mut self.scratch);
        row.iter_mut().zip(&self.spectrum).for_each(|(a, f)| *a += f);
    }

    fn move_contact(&mut self, lines: &Lines, contact: &Contact, forces: &[Complex64], index: usize) {
        let motion = &mut self.cells[index].motion;
        motion.resize(self.samples);
        motion.dt = std::f64::consts::TAU / (lines.omega() * self.samples as f64);
        lines.respond(contact.slip, forces, &mut self.spectrum);
        self.grid.evaluate(&self.spectrum, &mut motion.slip, &mut self.scratch);
        if contact.element.takes_velocity() {
            for (h, x) in self.spectrum.iter_mut().enumerate() {
                *x *= Complex64::new(0.0, h as f64 * lines.omega());
            }
            self.grid.evaluate(&self.spectrum, &mut motion.velocity, &mut self.scratch);
        }
        match contact.normal {
            Normal::Constant(normal) => motion.normal.fill(normal),
            Normal::Channel(channel) => {
                lines.respond(channel, forces, &mut self.spectrum);
                self.grid.evaluate(&self.spectrum, &mut motion.normal, &mut self.scratch);
            }
        }
    }

    /// Partials along the orbits of the last [`Self::evaluate`].
    pub fn linearise(&mut self, problem: &Problem) {
        for (contact, cell) in problem.contacts.iter().zip(&mut self.cells) {
            contact.element.linearise(&cell.motion, &mut cell.orbit, &mut cell.partials);
            contact.element.start_partials(&cell.motion, &mut cell.start);
        }
    }

    /// `K = ∂R/∂f̂ = 1 − ∂F/∂f̂` after [`Self::linearise`], factorised.
    pub fn factorise(&mut self, problem: &Problem) {
        self.assemble(problem, 0);
        self.dense.factorise();
    }

    /// `K` after [`Self::linearise`], with `border` further rows and columns of the identity to be filled in.
    pub fn assemble(&mut self, problem: &Problem, border: usize) {
        self.dense.reset(problem.lines.forces() * (2 * self.order + 1) + border);
        let mut columns = std::mem::take(&mut self.columns);
        for (contact, cell) in problem.contacts.iter().zip(&self.cells) {
            let chain = chain(contact, cell, self.samples);
            // A force that nothing takes up needs no columns.
            let wanted = contact.outputs().into_iter().flatten().count();
            columns.resize(wanted * LANES * self.samples, Complex64::ZERO);
            for force in 0..problem.lines.forces() {
                for first in (0..=self.order).step_by(LANES) {
                    let span = Span { force, first, order: self.order, samples: self.samples };
                    let Some(gains) = span.gains(problem.lines, contact) else { continue };
                    chain.columns(&gains, &mut columns);
                    self.transform.process_with_scratch(&mut columns, &mut self.transform_scratch);
                    span.subtract(contact, &columns, &mut self.dense);
                }
            }
        }
        self.columns = columns;
    }

    /// Lines of the forces of the last [`Self::evaluate`] up to a higher order.
    pub fn spectrum(&mut self, problem: &Problem, order: usize) -> Option<Vec<Complex64>> {
        if self.wide.as_ref().is_none_or(|(grid, _)| grid.order() != order) {
            let grid = Grid::new(order, self.samples).ok()?;
            let scratch = grid.scratch();
            self.wide = Some((grid, scratch));
        }
        let ((grid, scratch), row) = (self.wide.as_mut()?, order + 1);
        let mut lines = vec![Complex64::ZERO; problem.lines.forces() * row];
        let mut one = vec![Complex64::ZERO; row];
        for (contact, cell) in problem.contacts.iter().zip(&self.cells) {
            let outputs = contact.element.forces();
            for (o, force) in contact.outputs().into_iter().enumerate() {
                let Some(force) = force else { continue };
                let signal: Vec<f64> = cell.orbit.forces.iter().skip(o).step_by(outputs).copied().collect();
                grid.project(&signal, &mut one, scratch);
                lines[force * row..(force + 1) * row].iter_mut().zip(&one).for_each(|(a, f)| *a += f);
            }
        }
        Some(lines)
    }

    /// Samples of lines, for a change of motion.
    pub fn samples_of(&mut self, lines: &[Complex64], samples: &mut [f64]) {
        self.grid.evaluate(lines, samples, &mut self.scratch);
    }

    /// Adds the lines of every `stride`-th of the samples to a force.
    pub fn add_lines(&mut self, samples: &[f64], [output, outputs]: [usize; 2], row: &mut [Complex64]) {
        self.signal.iter_mut().zip(samples.iter().skip(output).step_by(outputs)).for_each(|(s, f)| *s = *f);
        self.grid.project(&self.signal, &mut self.spectrum, &mut self.scratch);
        row.iter_mut().zip(&self.spectrum).for_each(|(a, f)| *a += f);
    }
}

/// The chain of one contact along its orbit.
pub(super) fn chain<'a>(contact: &Contact, cell: &'a Cell, samples: usize) -> Chain<'a> {
    let shape = [contact.element.states(), contact.element.forces(), samples];
    let memory = Memory::of(&cell.partials, shape);
    Chain {
        partials: &cell.partials,
        shape,
        memory,
        inverse: memory.inverse(),
        start: &cell.start,
        start_width: 2 + contact.element.parameters(),
    }
}

/// A block of neighbouring lines of one force.
struct Span {
    force: usize,
    first: usize,
    order: usize,
    samples: usize,
}

impl Span {
    /// What the lines do to the contact; `None` if nothing.
    fn gains(&self, lines: &Lines, contact: &Contact) -> Option<Gains> {
        let mut gains = Gains::default();
        let mut largest = 0.0_f64;
        for lane in 0..LANES.min(self.order + 1 - self.first) {
            let h = self.first + lane;
            let slip = -lines.receptance(contact.slip, self.force)[h];
            gains.slip.set(lane, slip);
            gains.velocity.set(lane, slip * Complex64::new(0.0, h as f64 * lines.omega()));
            largest = largest.max(slip.norm());
            if let Normal::Channel(channel) = contact.normal {
                let normal = -lines.receptance(channel, self.force)[h];
                gains.normal.set(lane, normal);
                largest = largest.max(normal.norm());
            }
            let angle = -std::f64::consts::TAU * h as f64 / self.samples as f64;
            gains.turn.set(lane, Complex64::from_polar(1.0, angle));
        }
        (largest > 0.0).then_some(gains)
    }

    fn subtract(&self, contact: &Contact, spectra: &[Complex64], dense: &mut Dense) {
        for (o, target) in contact.outputs().into_iter().enumerate() {
            let Some(target) = target else { continue };
            for lane in 0..LANES.min(self.order + 1 - self.first) {
                let spectrum = &spectra[(o * LANES + lane) * self.samples..][..self.samples];
                self.subtract_line(self.first + lane, target, spectrum, dense);
            }
        }
    }

    /// A force `ξ` on line `h` answers on line `m` with `ξ Φ(m) + conj(ξ Φ(−m))`; the turning frame shifts `Φ` by `h`.
    fn subtract_line(&self, h: usize, target: usize, spectrum: &[Complex64], dense: &mut Dense) {
        let block = 2 * self.order + 1;
        let size = dense.size();
        let scale = 1.0 / self.samples as f64;
        let column = self.force * block + if h == 0 { 0 } else { 2 * h - 1 };
        let bin = |m: isize| spectrum[(m - h as isize).rem_euclid(self.samples as isize) as usize] * scale;
        let (left, right) = dense.matrix[column * size..].split_at_mut(size);
        let left = &mut left[target * block..(target + 1) * block];
        left[0] -= bin(0).re;
        for m in 1..=self.order {
            let value = bin(m as isize) + bin(-(m as isize)).conj();
            left[2 * m - 1] -= value.re;
            left[2 * m] -= value.im;
        }
        if h == 0 {
            return;
        }
        let right = &mut right[target * block..(target + 1) * block];
        right[0] += bin(0).im;
        for m in 1..=self.order {
            let value = bin(m as isize) - bin(-(m as isize)).conj();
            right[2 * m - 1] += value.im;
            right[2 * m] -= value.re;
        }
    }
}

/// Complex lines (`D × (H + 1)`) to reals (`D × (2H + 1)`): mean, then real and imaginary parts.
pub(super) fn pack(lines: &[Complex64], order: usize, reals: &mut [f64]) {
    for (row, out) in lines.chunks_exact(order + 1).zip(reals.chunks_exact_mut(2 * order + 1)) {
        out[0] = row[0].re;
        for (value, pair) in row[1..].iter().zip(out[1..].chunks_exact_mut(2)) {
            pair[0] = value.re;
            pair[1] = value.im;
        }
    }
}

/// Undoes [`pack`].
pub(super) fn unpack(reals: &[f64], order: usize, lines: &mut [Complex64]) {
    for (row, given) in lines.chunks_exact_mut(order + 1).zip(reals.chunks_exact(2 * order + 1)) {
        row[0] = Complex64::new(given[0], 0.0);
        for (value, pair) in row[1..].iter_mut().zip(given[1..].chunks_exact(2)) {
            *value = Complex64::new(pair[0], pair[1]);
        }
    }
}
