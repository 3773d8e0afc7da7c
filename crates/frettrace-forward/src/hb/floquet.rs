//! Stability of a periodic motion: Floquet multipliers.
//!
//! A small disturbance of modes and contact states is carried through one period: modes exactly for forces that are
//! linear over a step, contacts by the partials of the law. It dies out if all eigenvalues of that map, the multipliers, lie
//! inside the unit circle. The error is that of the hold, `(ωΔt)²/12`.

use super::contact::{Contact, Normal};
use super::element::INPUTS;
use super::network::Network;
use super::solver::Solver;
use super::system::Problem;
use crate::ForwardError;
use nalgebra::{DMatrix, Matrix4};
use num_complex::Complex64;

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

/// A disturbance and what it is made of: modes, forces, states of each contact.
struct Disturbance<'a> {
    network: &'a Network,
    contacts: &'a [Contact<'a>],
    modes: Vec<ModeStep>,
    /// Motion of each port by its value and velocity rows, and loads by ports: the contacts', then the supports'.
    ports: Vec<usize>,
    size: usize,
    states_at: Vec<usize>,
}

impl<'a> Disturbance<'a> {
    fn new(network: &'a Network, contacts: &'a [Contact<'a>], dt: f64) -> Self {
        let structure = &network.structure;
        let modes = structure.natural_frequency().iter().zip(structure.damping_ratio());
        let modes: Vec<_> = modes.map(|(w, z)| mode_step(w * w, 2.0 * z * w - network.feed, dt)).collect();
        let mut ports = network.forces.clone();
        ports.extend(network.supports.iter().map(|s| s.port));
        let mut size = 2 * modes.len() + ports.len();
        let mut states_at = Vec::new();
        for contact in contacts {
            states_at.push(size);
            size += contact.element.states();
        }
        Self { network, contacts, modes, ports, size, states_at }
    }

    fn force_at(&self, force: usize) -> usize {
        2 * self.modes.len() + force
    }

    /// Displacement or velocity of a port in every column of the disturbance.
    fn port(&self, port: usize, velocity: bool, x: &DMatrix<f64>, out: &mut [f64]) {
        out.fill(0.0);
        let row = self.network.structure.row(port);
        for (j, value) in out.iter_mut().enumerate() {
            let column = x.column(j);
            *value = row.iter().enumerate().map(|(n, r)| r * column[2 * n + usize::from(velocity)]).sum();
        }
    }

    /// Old and new motion of a contact's inputs: slip, velocity, normal.
    fn inputs(&self, contact: &Contact, x: &DMatrix<f64>) -> [Vec<f64>; 3] {
        let mut rows = [vec![0.0; self.size], vec![0.0; self.size], vec![0.0; self.size]];
        let slip = self.network.channels[contact.slip];
        for (velocity, row) in [(false, 0), (true, 1)] {
            self.port(slip.port, velocity, x, &mut rows[row]);
            rows[row].iter_mut().for_each(|v| *v *= slip.scale);
        }
        if let Normal::Channel(channel) = contact.normal {
            let normal = self.network.channels[channel];
            self.port(normal.port, false, x, &mut rows[2]);
            rows[2].iter_mut().for_each(|v| *v *= normal.scale);
        }
        rows
    }

    /// How the new inputs of a contact answer to a unit of a new load: slip, velocity, normal.
    fn gains(&self, contact: &Contact, force: usize) -> [f64; 3] {
        let slip = self.network.channels[contact.slip];
        let normal = match contact.normal {
            Normal::Channel(channel) => {
                let reading = self.network.channels[channel];
                reading.scale * self.gain(reading.port, force, 0)
            }
            Normal::Constant(_) => 0.0,
        };
        [slip.scale * self.gain(slip.port, force, 0), slip.scale * self.gain(slip.port, force, 1), normal]
    }

    fn gain(&self, port: usize, force: usize, part: usize) -> f64 {
        let (row, load) = (self.network.structure.row(port), self.network.structure.row(self.ports[force]));
        self.modes.iter().enumerate().map(|(n, step)| row[n] * step[part][3] * load[n]).sum()
    }

    /// Modes over a step with the old loads held and the new ones still missing. Loads are minus the forces.
    fn drift(&self, x: &DMatrix<f64>, next: &mut DMatrix<f64>) {
        for j in 0..self.size {
            for (n, step) in self.modes.iter().enumerate() {
                let old: f64 = self
                    .ports
                    .iter()
                    .enumerate()
                    .map(|(d, &port)| -self.network.structure.row(port)[n] * x[(self.force_at(d), j)])
                    .sum();
                let (q, v) = (x[(2 * n, j)], x[(2 * n + 1, j)]);
                next[(2 * n, j)] = step[0][0] * q + step[0][1] * v + step[0][2] * old;
                next[(2 * n + 1, j)] = step[1][0] * q + step[1][1] * v + step[1][2] * old;
            }
        }
    }

    /// One step `k`: drift, then the new forces, each an implicit linear equation.
    fn step(&self, k: usize, partials: &[&[f64]], x: &DMatrix<f64>, next: &mut DMatrix<f64>) {
        self.drift(x, next);
        let count = self.ports.len();
        let mut system = DMatrix::<f64>::identity(count, count);
        let mut right = DMatrix::<f64>::zeros(count, self.size);
        let mut later = Vec::new();
        for (index, contact) in self.contacts.iter().enumerate() {
            let (m, o) = (contact.element.states(), contact.element.forces());
            let width = m + INPUTS;
            let (old, new) = (self.inputs(contact, x), self.inputs(contact, next));
            for (j, row) in partials[index][k * (m + o) * width..].chunks_exact(width).take(m + o).enumerate()
            {
                let value = self.answer((row, self.states_at[index], m), x, (&old, &new));
                if j < m {
                    later.push((self.states_at[index] + j, index, row, value));
                } else if let Some(force) = contact.outputs()[j - m] {
                    right.row_mut(force).iter_mut().zip(&value).for_each(|(r, v)| *r += v);
                    for d in 0..count {
                        let gain = self.gains(contact, d);
                        system[(force, d)] += (0..3).map(|i| row[m + 2 * i + 1] * gain[i]).sum::<f64>();
                    }
                }
            }
        }
        self.add_supports(next, &mut system, &mut right);
        if let Some(forces) = system.lu().solve(&right) {
            self.finish(&forces, &later, next);
        }
    }

    fn answer(
        &self,
        (row, at, m): (&[f64], usize, usize),
        x: &DMatrix<f64>,
        (old, new): (&[Vec<f64>; 3], &[Vec<f64>; 3]),
    ) -> Vec<f64> {
        let one = |j: usize| {
            let states: f64 = (0..m).map(|i| row[i] * x[(at + i, j)]).sum();
            let motion = (0..3).map(|i| row[m + 2 * i] * old[i][j] + row[m + 2 * i + 1] * new[i][j]);
            states + motion.sum::<f64>()
        };
        (0..self.size).map(one).collect()
    }

    fn add_supports(&self, next: &DMatrix<f64>, system: &mut DMatrix<f64>, right: &mut DMatrix<f64>) {
        let first = self.network.forces.len();
        let (mut position, mut velocity) = (vec![0.0; self.size], vec![0.0; self.size]);
        for (index, support) in self.network.supports.iter().enumerate() {
            self.port(support.port, false, next, &mut position);
            self.port(support.port, true, next, &mut velocity);
            for j in 0..self.size {
                right[(first + index, j)] += support.stiffness * position[j] + support.damping * velocity[j];
            }
            for d in 0..self.ports.len() {
                system[(first + index, d)] += support.stiffness * self.gain(support.port, d, 0)
                    + support.damping * self.gain(support.port, d, 1);
            }
        }
    }

    /// Puts the new forces in: they move the modes, and with them the states of the contacts.
    fn finish(
        &self,
        forces: &DMatrix<f64>,
        later: &[(usize, usize, &[f64], Vec<f64>)],
        next: &mut DMatrix<f64>,
    ) {
        let count = self.ports.len();
        for j in 0..self.size {
            for (n, step) in self.modes.iter().enumerate() {
                let load: f64 =
                    (0..count).map(|d| -self.network.structure.row(self.ports[d])[n] * forces[(d, j)]).sum();
                next[(2 * n, j)] += step[0][3] * load;
                next[(2 * n + 1, j)] += step[1][3] * load;
            }
            (0..count).for_each(|d| next[(self.force_at(d), j)] = forces[(d, j)]);
        }
        for (at, index, row, value) in later {
            let contact = &self.contacts[*index];
            let m = contact.element.states();
            for j in 0..self.size {
                let late: f64 = (0..count)
                    .map(|d| {
                        let gain = self.gains(contact, d);
                        (0..3).map(|i| row[m + 2 * i + 1] * gain[i]).sum::<f64>() * forces[(d, j)]
                    })
                    .sum();
                next[(*at, j)] = value[j] - late;
            }
        }
    }
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
        let partials: Vec<&[f64]> =
            self.system.cells.iter().map(|cell| cell.partials.rows.as_slice()).collect();
        let size = disturbance.size;
        let (mut x, mut next) = (DMatrix::identity(size, size), DMatrix::zeros(size, size));
        for k in 0..samples {
            disturbance.step(k, &partials, &x, &mut next);
            std::mem::swap(&mut x, &mut next);
        }
        let mut multipliers: Vec<Complex64> = x.complex_eigenvalues().iter().copied().collect();
        multipliers.sort_by(|a, b| b.norm().total_cmp(&a.norm()));
        Ok(Floquet { multipliers })
    }
}
