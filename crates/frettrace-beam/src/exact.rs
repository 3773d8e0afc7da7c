//! The uniform beam in closed form: no modes, no truncation.

use num_complex::Complex64;

use crate::beam::{Boundary, UniformBeam};
use crate::dof::{Dof, Freedom, Receptance};
use crate::error::BeamError;
use crate::statics::Statics;

/// The exact receptance of the uniform beam with hysteretic damping `EI(1 + iη)`.
///
/// The field of a load on the endless beam, `−(e^{-βr} + i e^{-iβr})/(4β³EI)`, plus the four waves that decay away from an
/// end and together meet its conditions; nothing grows with the frequency or the damping. The oracle of [`crate::ModalModel`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ExactBeam {
    statics: Statics,
    loss_factor: f64,
}

impl ExactBeam {
    /// A beam on its boundary with loss factor `η`.
    ///
    /// # Errors
    /// [`BeamError`] where a quantity is out of range.
    pub fn new(beam: &UniformBeam, boundary: &Boundary, loss_factor: f64) -> Result<Self, BeamError> {
        beam.check()?;
        boundary.check(beam)?;
        if !(0.0..1.0).contains(&loss_factor) {
            return Err(BeamError::OutOfRange {
                quantity: "loss factor",
                found: loss_factor,
                allowed: "0 ≤ η < 1",
            });
        }
        Ok(Self { statics: Statics { beam: *beam, boundary: *boundary }, loss_factor })
    }

    fn wave(&self, omega: f64) -> Wave {
        let beam = &self.statics.beam;
        let stiffness = Complex64::new(1.0, self.loss_factor) * beam.bending_stiffness;
        let wavenumber = (beam.mass_per_length * omega * omega / stiffness).powf(0.25) * beam.length;
        Wave { wavenumber, stiffness, length: beam.length }
    }

    /// Conditions at the ends as weights on the scaled derivatives at `ξ = 0` (two) and `ξ = 1` (two).
    fn conditions(&self, wave: &Wave) -> [[Complex64; 4]; 4] {
        let zero = Complex64::ZERO;
        let flexural = wave.stiffness / wave.length;
        let b = wave.wavenumber;
        let boundary = &self.statics.boundary;
        let compliance = b * flexural / boundary.clamp_rotational_stiffness;
        let (moment, slope) = weights(boundary.support_rotational_stiffness, flexural * b);
        let (shear, shift) = weights(boundary.support_stiffness, flexural * b.powi(3) / wave.length.powi(2));
        [
            [Complex64::ONE, zero, zero, zero],
            [zero, 1.0 / (1.0 + compliance), -compliance / (1.0 + compliance), zero],
            [zero, slope, moment, zero],
            [-shift, zero, zero, shear],
        ]
    }
}

/// `(p, q)` proportional to `(1, stiffness/unit)` and bounded.
fn weights(stiffness: f64, unit: Complex64) -> (Complex64, Complex64) {
    if stiffness.is_infinite() {
        (Complex64::ZERO, Complex64::ONE)
    } else {
        (unit / (unit + stiffness), stiffness / (unit + stiffness))
    }
}

impl Receptance for ExactBeam {
    fn receptance(&self, output: Dof, input: Dof, omega: f64) -> Complex64 {
        if omega == 0.0 {
            return Complex64::from(self.statics.flexibility(output, input));
        }
        let wave = self.wave(omega);
        let source = |xi: f64, side: f64| wave.source(input, xi, side);
        let conditions = self.conditions(&wave);
        let ends = [(0.0, -1.0), (1.0, 1.0)];
        let mut system = [[Complex64::ZERO; 5]; 4];
        for (row, (condition, equation)) in conditions.iter().zip(&mut system).enumerate() {
            let (xi, side) = ends[row / 2];
            let homogeneous = wave.homogeneous(xi);
            for (unknown, entry) in equation.iter_mut().take(4).enumerate() {
                *entry = dot(condition, &homogeneous[unknown]);
            }
            equation[4] = -dot(condition, &source(xi, side));
        }
        let amplitudes = solve(system);
        let xi = output.position / wave.length;
        let particular = source(xi, (output.position - input.position).signum());
        let homogeneous = wave.homogeneous(xi);
        let order = usize::from(output.freedom == Freedom::Rotation);
        let field = (0..4).fold(particular[order], |sum, k| sum + amplitudes[k] * homogeneous[k][order]);
        match output.freedom {
            Freedom::Displacement => field,
            Freedom::Rotation => field * wave.wavenumber / wave.length,
        }
    }
}

fn dot(a: &[Complex64; 4], b: &[Complex64; 4]) -> Complex64 {
    a.iter().zip(b).map(|(x, y)| x * y).sum()
}

/// Bending waves at one frequency; derivatives are with respect to `βx`.
struct Wave {
    wavenumber: Complex64,
    stiffness: Complex64,
    length: f64,
}

impl Wave {
    /// Field of a unit force or moment on the endless beam and its first three scaled derivatives; `side` is +1 right of
    /// the load, −1 left of it.
    fn source(&self, input: Dof, xi: f64, side: f64) -> [Complex64; 4] {
        let i = Complex64::I;
        let distance = self.wavenumber * (xi - input.position / self.length).abs();
        let (decay, wave) = ((-distance).exp(), (-i * distance).exp());
        let even = [decay + i * wave, decay - i * wave];
        let odd = [(wave - decay) * side, -(wave + decay) * side];
        let orders = [even[0], odd[0], even[1], odd[1], even[0]];
        let scale = self.length / self.wavenumber;
        match input.freedom {
            Freedom::Displacement => {
                [0, 1, 2, 3].map(|k| -orders[k] * scale.powi(3) / (4.0 * self.stiffness))
            }
            // A moment is the derivative of the force's field with respect to its place, minus that to the position.
            Freedom::Rotation => [0, 1, 2, 3].map(|k| orders[k + 1] * scale.powi(2) / (4.0 * self.stiffness)),
        }
    }

    /// `e^{-bξ}`, `e^{-b(1-ξ)}`, `e^{-ibξ}`, `e^{-ib(1-ξ)}`, each with its first three scaled derivatives.
    fn homogeneous(&self, xi: f64) -> [[Complex64; 4]; 4] {
        let i = Complex64::I;
        let (from_clamp, from_support) = (self.wavenumber * xi, self.wavenumber * (1.0 - xi));
        let near = (-from_clamp).exp();
        let (right, left) = ((-i * from_clamp).exp(), (-i * from_support).exp());
        [
            [near, -near, near, -near],
            [(-from_support).exp(); 4],
            [right, -i * right, -right, i * right],
            [left, i * left, -left, -i * left],
        ]
    }
}

/// Gaussian elimination with row pivoting; the last column is the right-hand side.
fn solve(mut system: [[Complex64; 5]; 4]) -> [Complex64; 4] {
    for column in 0..4 {
        let magnitude = |row: &[Complex64; 5]| row[column].norm_sqr();
        let pivot = (column..4)
            .fold(column, |p, r| if magnitude(&system[r]) > magnitude(&system[p]) { r } else { p });
        system.swap(column, pivot);
        let pivot_row = system[column];
        for row in system.iter_mut().skip(column + 1) {
            let factor = row[column] / pivot_row[column];
            for (entry, &above) in row.iter_mut().zip(&pivot_row) {
                *entry -= factor * above;
            }
        }
    }
    let mut solution = [Complex64::ZERO; 4];
    for row in (0..4).rev() {
        let known: Complex64 = (row + 1..4).map(|k| system[row][k] * solution[k]).sum();
        solution[row] = (system[row][4] - known) / system[row][row];
    }
    solution
}

#[cfg(test)]
mod tests;
