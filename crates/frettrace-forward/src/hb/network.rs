//! Lines of a structure given by its modes, at any frequency: what sweeps need.

use super::lines::Lines;
use crate::ForwardError;
use crate::march::Structure;
use num_complex::Complex64;

/// What is read at a port: `offset + scale · w`. A normal force `N = N_0 − k_n w` has scale `−k_n` and offset `N_0`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reading {
    /// The port.
    pub port: usize,
    /// Factor on the motion of the port.
    pub scale: f64,
    /// What is read at rest.
    pub offset: f64,
}

impl Reading {
    /// The motion of a port itself.
    #[must_use]
    pub fn motion(port: usize) -> Self {
        Self { port, scale: 1.0, offset: 0.0 }
    }
}

/// A harmonic load at a port: `Re p̂ e^{ihωt}`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Load {
    /// The port.
    pub port: usize,
    /// The line `h`: 0 is static, `ν` the excitation of a subharmonic form of order `ν`.
    pub harmonic: usize,
    /// Amplitude `p̂` (N).
    pub amplitude: Complex64,
}

/// A linear spring and dashpot between a port and the ground.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Support {
    /// The port.
    pub port: usize,
    /// Stiffness (N/m).
    pub stiffness: f64,
    /// Damping (N s/m).
    pub damping: f64,
}

/// Modes, loads and supports, and which ports are channels and forces of the harmonic balance.
#[derive(Clone, Debug, PartialEq)]
pub struct Network {
    /// The modes.
    pub structure: Structure,
    /// The channels.
    pub channels: Vec<Reading>,
    /// Ports on which the contact forces act.
    pub forces: Vec<usize>,
    /// The loads.
    pub loads: Vec<Load>,
    /// Linear supports that the modes do not have.
    pub supports: Vec<Support>,
    /// Mass-proportional damping taken out (1/s), a negative damper that feeds every mode alike: `− ε q̇_n`; 0 but for
    /// nonlinear modes.
    pub feed: f64,
}

impl Network {
    /// A network without loads and supports.
    #[must_use]
    pub fn new(structure: Structure, channels: Vec<Reading>, forces: Vec<usize>) -> Self {
        Self { structure, channels, forces, loads: Vec::new(), supports: Vec::new(), feed: 0.0 }
    }

    /// Lines `0..=order` of the base frequency `omega` (rad/s), the alternating loads scaled by `level`.
    ///
    /// # Errors
    /// [`ForwardError::Index`] for a port the structure does not have.
    pub fn lines(&self, omega: f64, order: usize, level: f64) -> Result<Lines, ForwardError> {
        self.check()?;
        let mut lines = Lines::zeros(omega, order, [self.channels.len(), self.forces.len()]);
        let (products, mut receptance) = (self.products(), Vec::new());
        for h in 0..=order {
            self.sum_modes(h as f64 * omega, &products, &mut receptance);
            self.fill(h, level, &receptance, &mut lines);
        }
        Ok(lines)
    }

    fn check(&self) -> Result<(), ForwardError> {
        let available = self.structure.port_count();
        let ports = (self.channels.iter().map(|c| c.port))
            .chain(self.forces.iter().copied())
            .chain(self.loads.iter().map(|l| l.port))
            .chain(self.supports.iter().map(|s| s.port));
        for index in ports {
            if index >= available {
                return Err(ForwardError::Index { contact: 0, what: "port", index, available });
            }
        }
        Ok(())
    }

    /// Products of the mode shapes at two ports, mode by mode for all pairs `j ≤ i`.
    fn products(&self) -> Vec<f64> {
        let (structure, size) = (&self.structure, self.structure.port_count());
        let mut products = Vec::with_capacity(structure.mode_count() * size * (size + 1) / 2);
        for n in 0..structure.mode_count() {
            for i in 0..size {
                let left = structure.row(i)[n];
                products.extend((0..=i).map(|j| left * structure.row(j)[n]));
            }
        }
        products
    }

    /// Receptances of all ports at one frequency (rad/s), row by row: modes, then the supports, each of rank one.
    pub fn receptances(&self, omega: f64, matrix: &mut Vec<Complex64>) {
        self.sum_modes(omega, &self.products(), matrix);
    }

    fn sum_modes(&self, omega: f64, products: &[f64], matrix: &mut Vec<Complex64>) {
        let (structure, size) = (&self.structure, self.structure.port_count());
        matrix.clear();
        matrix.resize(size * size, Complex64::ZERO);
        let pairs = size * (size + 1) / 2;
        // Real and imaginary parts apart: sums over pairs side by side.
        let [mut real, mut imaginary] = [vec![0.0; pairs], vec![0.0; pairs]];
        let modes = structure.natural_frequency().iter().zip(structure.damping_ratio());
        for ((natural, ratio), products) in modes.zip(products.chunks_exact(pairs.max(1))) {
            let damping = 2.0 * ratio * natural - self.feed;
            let modal = Complex64::new(natural * natural - omega * omega, damping * omega).inv();
            for ((re, im), product) in real.iter_mut().zip(&mut imaginary).zip(products) {
                *re += modal.re * product;
                *im += modal.im * product;
            }
        }
        let mut sums = real.iter().zip(&imaginary).map(|(re, im)| Complex64::new(*re, *im));
        for i in 0..size {
            for (j, sum) in (0..=i).zip(&mut sums) {
                matrix[i * size + j] = sum;
                matrix[j * size + i] = sum;
            }
        }
        for support in &self.supports {
            let stiffness = Complex64::new(support.stiffness, support.damping * omega);
            let row: Vec<_> = matrix[support.port * size..(support.port + 1) * size].to_vec();
            let factor = stiffness / (1.0 + stiffness * row[support.port]);
            for i in 0..size {
                for j in 0..size {
                    matrix[i * size + j] -= factor * row[i] * row[j];
                }
            }
        }
    }

    fn fill(&self, h: usize, level: f64, receptance: &[Complex64], lines: &mut Lines) {
        let size = self.structure.port_count();
        for (c, channel) in self.channels.iter().enumerate() {
            let row = &receptance[channel.port * size..(channel.port + 1) * size];
            let scale = if h == 0 { 1.0 } else { level };
            let loads = self.loads.iter().filter(|load| load.harmonic == h);
            let moved: Complex64 = loads.map(|load| row[load.port] * load.amplitude).sum();
            lines.free_mut(c)[h] = moved * scale * channel.scale + if h == 0 { channel.offset } else { 0.0 };
            for (d, &force) in self.forces.iter().enumerate() {
                lines.receptance_mut(c, d)[h] = row[force] * channel.scale;
            }
        }
    }
}
