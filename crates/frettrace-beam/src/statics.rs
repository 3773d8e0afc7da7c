//! Static flexibility in closed form.

use crate::beam::{Boundary, UniformBeam};
use crate::dof::{Dof, Freedom};
use crate::error::BeamError;

/// Motion at `output` per unit static load at `input` (m/N, rad/N = m/(N·m), rad/(N·m)).
///
/// Cantilever `w(x) = x²(3a − x)/(6EI)` for `x ≤ a`, its derivatives for rotations and moments, the turning of the clamp
/// `x·a/k_c`, and the springs of the support as an update of rank two.
///
/// # Errors
/// [`BeamError`] where a quantity is out of range.
pub fn static_flexibility(
    beam: &UniformBeam,
    boundary: &Boundary,
    output: Dof,
    input: Dof,
) -> Result<f64, BeamError> {
    beam.check()?;
    boundary.check(beam)?;
    Ok(Statics { beam: *beam, boundary: *boundary }.flexibility(output, input))
}

/// A checked beam on its boundary.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Statics {
    pub(crate) beam: UniformBeam,
    pub(crate) boundary: Boundary,
}

impl Statics {
    pub(crate) fn flexibility(&self, output: Dof, input: Dof) -> f64 {
        let end = [Dof::displacement(self.beam.length), Dof::rotation(self.beam.length)];
        let support = [self.boundary.support_stiffness, self.boundary.support_rotational_stiffness];
        let mut to_output = end.map(|e| self.cantilever(output, e));
        let to_input = end.map(|e| self.cantilever(e, input));
        let mut at_end = end.map(|row| end.map(|column| self.cantilever(row, column)));
        let mut value = self.cantilever(output, input);
        // One spring after the other: 1/k + flexibility at the spring; an absent spring changes nothing.
        let mut input_row = to_input;
        for s in 0..2 {
            if support[s] == 0.0 {
                continue;
            }
            let gain = 1.0 / (1.0 / support[s] + at_end[s][s]);
            value -= to_output[s] * gain * input_row[s];
            let (column, row) = (at_end.map(|r| r[s]), at_end[s]);
            let (output_s, input_s) = (to_output[s], input_row[s]);
            for other in 0..2 {
                to_output[other] -= output_s * gain * row[other];
                input_row[other] -= column[other] * gain * input_s;
                for inner in 0..2 {
                    at_end[other][inner] -= column[other] * gain * row[inner];
                }
            }
        }
        value
    }

    fn cantilever(&self, output: Dof, input: Dof) -> f64 {
        let (x, a) = (output.position, input.position);
        let bending = match (output.freedom, input.freedom) {
            (Freedom::Displacement, Freedom::Displacement) if x <= a => x * x * (3.0 * a - x) / 6.0,
            (Freedom::Displacement, Freedom::Displacement) => a * a * (3.0 * x - a) / 6.0,
            (Freedom::Rotation, Freedom::Displacement) => end_slope(x, a),
            (Freedom::Displacement, Freedom::Rotation) => end_slope(a, x),
            (Freedom::Rotation, Freedom::Rotation) => x.min(a),
        };
        bending / self.beam.bending_stiffness
            + lever(output) * lever(input) / self.boundary.clamp_rotational_stiffness
    }
}

/// `EI θ(x)` per unit force at `a`.
fn end_slope(x: f64, a: f64) -> f64 {
    if x <= a { x * (2.0 * a - x) / 2.0 } else { a * a / 2.0 }
}

/// Motion per unit turn of the clamp.
fn lever(dof: Dof) -> f64 {
    match dof.freedom {
        Freedom::Displacement => dof.position,
        Freedom::Rotation => 1.0,
    }
}
