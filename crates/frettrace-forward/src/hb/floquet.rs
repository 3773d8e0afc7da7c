//! Stability of a periodic motion: Floquet multipliers.
//!
//! A small disturbance of modes and contact states is carried through one period: modes exactly for forces that are
//! linear over a step, contacts by the partials of the law. It dies out if all eigenvalues of that map, the multipliers, lie
//! inside the unit circle. The error is that of the hold, `(ωΔt)²/12`.

use super::contact::{Contact, Normal};
use super::element::INPUTS;
use super::network::{Network, Support};
use super::solver::Solver;
use super::system::Problem;
use crate::ForwardError;
use nalgebra::{DMatrix, Matrix4};
use num_complex::Complex64;
use pulp::{Arch, Simd, WithSimd};

/// Multipliers of a periodic motion, the largest first.
#[derive(Clone, Debug, PartialEq)]
pub struct Floquet {
    /// The multipliers.
    pub multipliers: Vec<Complex64>,
}

impl Floquet {
    /// Whether disturbances die out. A contact that stays stuck has the multiplier 1: where it came to rest is kept, and
    /// counts as stable.
    #[must_use]
    pub fn stable(&self) -> bool {
        self.multipliers.first().is_none_or(|m| m.norm() < 1.0 + 1e-6)
    }
}

/// One mode over one step: `[q, q̇]` from `[q, q̇]`, old and new load.
type ModeStep = [[f64; 4]; 2];

/// A matrix by rows; its columns are the disturbances that are carried along.
struct Rows {
    width: usize,
    values: Vec<f64>,
}

impl Rows {
    fn zeros(count: usize, width: usize) -> Self {
        Self { width, values: vec![0.0; count * width] }
    }

    #[inline(always)]
    fn row(&self, i: usize) -> &[f64] {
        &self.values[i * self.width..][..self.width]
    }

    #[inline(always)]
    fn row_mut(&mut self, i: usize) -> &mut [f64] {
        &mut self.values[i * self.width..][..self.width]
    }
}

#[inline(always)]
fn add(target: &mut [f64], factor: f64, source: &[f64]) {
    target.iter_mut().zip(source).for_each(|(t, s)| *t += factor * s);
}

/// How the inputs of a contact come from the modes, and what a unit of each new load adds to the new ones.
struct Inputs {
    slip: Vec<f64>,
    /// Empty where the normal force is held.
    normal: Vec<f64>,
    /// Slip, velocity, normal force.
    gains: Vec<[f64; 3]>,
}

/// What a disturbance is made of: modes (displacement and velocity in turn), forces, states of each contact.
struct Disturbance<'a> {
    contacts: &'a [Contact<'a>],
    supports: &'a [Support],
    modes: Vec<ModeStep>,
    /// Mode shapes at the loads: the contacts', then the supports'.
    loads: Vec<&'a [f64]>,
    inputs: Vec<Inputs>,
    size: usize,
    states_at: Vec<usize>,
}

/// Memory of a step.
struct Scratch {
    /// Slip, velocity and normal force of a contact at the old and at the new sample.
    inputs: [Rows; 2],
    /// Forces before they act back, and the system that makes them act back.
    right: Rows,
    system: DMatrix<f64>,
    forces: Rows,
}

impl<'a> Disturbance<'a> {
    fn new(network: &'a Network, contacts: &'a [Contact<'a>], dt: f64) -> Self {
        let structure = &network.structure;
        let modes = structure.natural_frequency().iter().zip(structure.damping_ratio());
        let modes: Vec<_> = modes.map(|(w, z)| mode_step(w * w, 2.0 * z * w - network.feed, dt)).collect();
        let ports = network.forces.iter().copied().chain(network.supports.iter().map(|s| s.port));
        let loads: Vec<&[f64]> = ports.map(|port| structure.row(port)).collect();
        let mut size = 2 * modes.len() + loads.len();
        let mut states_at = Vec::new();
        for contact in contacts {
            states_at.push(size);
            size += contact.element.states();
        }
        let supports = &network.supports;
        let mut disturbance = Self { contacts, supports, modes, loads, inputs: Vec::new(), size, states_at };
        disturbance.inputs = contacts.iter().map(|contact| disturbance.inputs_of(network, contact)).collect();
        disturbance
    }

    fn inputs_of(&self, network: &Network, contact: &Contact) -> Inputs {
        let scaled = |channel: usize| -> Vec<f64> {
            let reading = network.channels[channel];
            network.structure.row(reading.port).iter().map(|shape| reading.scale * shape).collect()
        };
        let slip = scaled(contact.slip);
        let normal = match contact.normal {
            Normal::Channel(channel) => scaled(channel),
            Normal::Constant(_) => Vec::new(),
        };
        let gains = (self.loads.iter())
            .map(|load| [self.gain(&slip, load, 0), self.gain(&slip, load, 1), self.gain(&normal, load, 0)])
            .collect();
        Inputs { slip, normal, gains }
    }

    /// What a unit of a new load adds to a motion (part 0) or its velocity (part 1).
    fn gain(&self, row: &[f64], load: &[f64], part: usize) -> f64 {
        self.modes.iter().zip(row.iter().zip(load)).map(|(step, (r, l))| r * step[part][3] * l).sum()
    }

    fn scratch(&self) -> Scratch {
        let (count, size) = (self.loads.len(), self.size);
        Scratch {
            inputs: [Rows::zeros(3, size), Rows::zeros(3, size)],
            right: Rows::zeros(count, size),
            system: DMatrix::identity(count, count),
            forces: Rows::zeros(count, size),
        }
    }

    fn force_at(&self, force: usize) -> usize {
        2 * self.modes.len() + force
    }

    /// Slip, velocity and normal force of a contact in every disturbance.
    #[inline(always)]
    fn read(&self, contact: usize, x: &Rows, out: &mut Rows) {
        out.values.fill(0.0);
        let Inputs { slip, normal, .. } = &self.inputs[contact];
        for (n, shape) in slip.iter().enumerate() {
            add(out.row_mut(0), *shape, x.row(2 * n));
            add(out.row_mut(1), *shape, x.row(2 * n + 1));
        }
        for (n, shape) in normal.iter().enumerate() {
            add(out.row_mut(2), *shape, x.row(2 * n));
        }
    }

    /// Modes over a step with the old loads held and the new ones still missing. Loads are minus the forces.
    #[inline(always)]
    fn drift(&self, x: &Rows, next: &mut Rows) {
        next.values.fill(0.0);
        for (n, step) in self.modes.iter().enumerate() {
            for (part, step) in step.iter().enumerate() {
                let target = next.row_mut(2 * n + part);
                add(target, step[0], x.row(2 * n));
                add(target, step[1], x.row(2 * n + 1));
                for (d, load) in self.loads.iter().enumerate() {
                    add(target, -step[2] * load[n], x.row(self.force_at(d)));
                }
            }
        }
    }

    /// One step: drift, then the new forces, each an implicit linear equation; `partials` are those of the step.
    #[inline(always)]
    fn step(&self, partials: &[&[f64]], x: &Rows, next: &mut Rows, scratch: &mut Scratch) {
        self.drift(x, next);
        scratch.right.values.fill(0.0);
        scratch.system.fill_with_identity();
        for (index, contact) in self.contacts.iter().enumerate() {
            let [old, new] = &mut scratch.inputs;
            self.read(index, x, old);
            self.read(index, next, new);
            let (m, at) = (contact.element.states(), self.states_at[index]);
            for (j, row) in partials[index].chunks_exact(m + INPUTS).enumerate() {
                let target = if j < m {
                    next.row_mut(at + j)
                } else if let Some(force) = contact.outputs()[j - m] {
                    for (d, gain) in self.inputs[index].gains.iter().enumerate() {
                        scratch.system[(force, d)] += late(row, m, gain);
                    }
                    scratch.right.row_mut(force)
                } else {
                    continue;
                };
                (0..m).for_each(|i| add(target, row[i], x.row(at + i)));
                for i in 0..3 {
                    add(target, row[m + 2 * i], old.row(i));
                    add(target, row[m + 2 * i + 1], new.row(i));
                }
            }
        }
        self.add_supports(next, scratch);
        self.finish(partials, next, scratch);
    }

    #[inline(always)]
    fn add_supports(&self, next: &Rows, scratch: &mut Scratch) {
        let first = self.loads.len() - self.supports.len();
        for (index, support) in self.supports.iter().enumerate() {
            let (shape, own) = (self.loads[first + index], first + index);
            let target = scratch.right.row_mut(own);
            for (n, shape) in shape.iter().enumerate() {
                add(target, support.stiffness * shape, next.row(2 * n));
                add(target, support.damping * shape, next.row(2 * n + 1));
            }
            for (d, load) in self.loads.iter().enumerate() {
                scratch.system[(own, d)] += support.stiffness * self.gain(shape, load, 0)
                    + support.damping * self.gain(shape, load, 1);
            }
        }
    }

    /// Puts the new forces in: they move the modes, and with them the states of the contacts.
    #[inline(always)]
    fn finish(&self, partials: &[&[f64]], next: &mut Rows, scratch: &mut Scratch) {
        // Without an inverse the forces are those before they act back.
        let _ = scratch.system.try_inverse_mut();
        let Scratch { right, system, forces, .. } = scratch;
        forces.values.fill(0.0);
        for (d, load) in self.loads.iter().enumerate() {
            (0..self.loads.len()).for_each(|e| add(forces.row_mut(d), system[(d, e)], right.row(e)));
            let force = forces.row(d);
            for (n, step) in self.modes.iter().enumerate() {
                add(next.row_mut(2 * n), -step[0][3] * load[n], force);
                add(next.row_mut(2 * n + 1), -step[1][3] * load[n], force);
            }
            next.row_mut(self.force_at(d)).copy_from_slice(force);
            for (index, contact) in self.contacts.iter().enumerate() {
                let (m, gain) = (contact.element.states(), &self.inputs[index].gains[d]);
                for (j, row) in partials[index].chunks_exact(m + INPUTS).take(m).enumerate() {
                    add(next.row_mut(self.states_at[index] + j), -late(row, m, gain), force);
                }
            }
        }
    }
}

/// The disturbances carried along one period, in the code of each instruction set.
struct Period<'a, 'b> {
    disturbance: &'a Disturbance<'b>,
    /// Partials of each contact.
    cells: Vec<&'a [f64]>,
    samples: usize,
    x: &'a mut Rows,
    next: &'a mut Rows,
}

impl WithSimd for Period<'_, '_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let Self { disturbance, cells, samples, x, next } = self;
        let (mut scratch, mut partials) = (disturbance.scratch(), cells.clone());
        for k in 0..samples {
            for (step, cell) in partials.iter_mut().zip(&cells) {
                let length = cell.len() / samples;
                *step = &cell[k * length..(k + 1) * length];
            }
            disturbance.step(&partials, x, next, &mut scratch);
            std::mem::swap(x, next);
        }
    }
}

/// What a row of partials answers to a unit of a new load, through the new inputs.
#[inline(always)]
fn late(row: &[f64], m: usize, gain: &[f64; 3]) -> f64 {
    (0..3).map(|i| row[m + 2 * i + 1] * gain[i]).sum()
}

/// `[q, q̇]` after `dt` of `q̈ + c q̇ + k q = p` with `p` linear in time: by the exponential of the augmented system.
fn mode_step(stiffness: f64, damping: f64, dt: f64) -> ModeStep {
    let (k, c) = (stiffness * dt, damping * dt);
    // States q, q̇, p and the change of p over the step.
    let generator = Matrix4::new(
        0.0, dt, 0.0, 0.0, //
        -k, -c, dt, 0.0, //
        0.0, 0.0, 0.0, 1.0, //
        0.0, 0.0, 0.0, 0.0,
    );
    let map = generator.exp();
    [0, 1].map(|i| [map[(i, 0)], map[(i, 1)], map[(i, 2)] - map[(i, 3)], map[(i, 3)]])
}

impl Solver {
    /// Multipliers of a periodic motion with these contact forces.
    ///
    /// # Errors
    /// A problem that is not one: see [`ForwardError`].
    pub fn floquet(
        &mut self,
        network: &Network,
        contacts: &[Contact],
        (omega, level): (f64, f64),
        forces: &[Complex64],
    ) -> Result<Floquet, ForwardError> {
        let lines = network.lines(omega, self.settings().order, level)?;
        let problem = Problem { lines: &lines, contacts };
        problem.check()?;
        let mut answer = vec![Complex64::ZERO; forces.len()];
        self.system.evaluate(&problem, forces, &mut answer);
        self.system.linearise(&problem);
        let samples = self.settings().samples;
        let dt = std::f64::consts::TAU / (omega * samples as f64);
        let disturbance = Disturbance::new(network, contacts, dt);
        let size = disturbance.size;
        let (mut x, mut next) = (Rows::zeros(size, size), Rows::zeros(size, size));
        (0..size).for_each(|i| x.row_mut(i)[i] = 1.0);
        let cells = self.system.cells.iter().map(|cell| cell.partials.rows.as_slice()).collect();
        Arch::new().dispatch(Period {
            disturbance: &disturbance,
            cells,
            samples,
            x: &mut x,
            next: &mut next,
        });
        let x = DMatrix::from_row_slice(size, size, &x.values);
        let mut multipliers: Vec<Complex64> = x.complex_eigenvalues().iter().copied().collect();
        multipliers.sort_by(|a, b| b.norm().total_cmp(&a.norm()));
        Ok(Floquet { multipliers })
    }
}
