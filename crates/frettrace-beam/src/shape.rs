//! Mass-normalised mode shapes.

use crate::beam::{Boundary, UniformBeam};
use crate::characteristic::{Coefficients, mode_coefficients, roots, scaled_derivatives};
use crate::dof::{Dof, Freedom};
use crate::error::BeamError;

/// A mode of the uniform beam, `∫ ρA φ² dx = 1`, positive near the clamp.
///
/// The exponentials are bounded, so that modes of any number keep full precision (the usual `cosh − cos` form has lost
/// every digit at mode 12).
#[derive(Clone, Debug, PartialEq)]
pub struct ModeShape {
    wavenumber: f64,
    natural_frequency: f64,
    length: f64,
    coefficients: Coefficients,
}

impl ModeShape {
    /// Dimensionless wavenumber `βL`.
    #[must_use]
    pub fn wavenumber(&self) -> f64 {
        self.wavenumber
    }

    /// Natural frequency (rad/s).
    #[must_use]
    pub fn natural_frequency(&self) -> f64 {
        self.natural_frequency
    }

    /// `φ, φ', φ'', φ'''` at a position (m); units kg^-1/2, kg^-1/2/m, …
    #[must_use]
    pub fn derivatives(&self, position: f64) -> [f64; 4] {
        let scale = self.wavenumber / self.length;
        let [w, d1, d2, d3] = scaled_derivatives(self.wavenumber, &self.coefficients, position / self.length);
        [w, d1 * scale, d2 * scale * scale, d3 * scale.powi(3)]
    }

    /// `∫₀ᴸ φ dx` (m kg^-1/2): from `φ'''' = β⁴ φ`, `(φ'''(L) − φ'''(0))/β⁴`.
    #[must_use]
    pub fn integral(&self) -> f64 {
        let shear = |xi: f64| scaled_derivatives(self.wavenumber, &self.coefficients, xi)[3];
        (shear(1.0) - shear(0.0)) * self.length / self.wavenumber
    }

    /// `φ(x)` or `φ'(x)`.
    #[must_use]
    pub fn at(&self, dof: Dof) -> f64 {
        let [w, slope, ..] = self.derivatives(dof.position);
        match dof.freedom {
            Freedom::Displacement => w,
            Freedom::Rotation => slope,
        }
    }
}

/// The first `count` modes of the beam, in rising frequency.
///
/// # Errors
/// [`BeamError`] where a quantity is out of range.
pub fn mode_shapes(
    beam: &UniformBeam,
    boundary: &Boundary,
    count: usize,
) -> Result<Vec<ModeShape>, BeamError> {
    beam.check()?;
    boundary.check(beam)?;
    let ends = boundary.dimensionless(beam);
    let mass = beam.mass_per_length * beam.length;
    let shape = |wavenumber: f64| {
        let raw = mode_coefficients(wavenumber, &ends);
        let [_, slope, moment, _] = scaled_derivatives(wavenumber, &raw, 0.0);
        let factor = (slope + moment).signum() / (mass * square_integral(wavenumber, &raw)).sqrt();
        ModeShape {
            wavenumber,
            natural_frequency: beam.angular_frequency(wavenumber),
            length: beam.length,
            coefficients: raw.map(|c| c * factor),
        }
    };
    Ok(roots(&ends, count)?.into_iter().map(shape).collect())
}

/// `∫₀¹ ψ² dξ` in closed form.
///
/// From `ψ'''' = b⁴ψ`: `4 b⁴ ψ² = d/dξ [3ψψ''' − ψ'ψ'' + ξ (b⁴ψ² − 2ψ'ψ''' + ψ''²)]`.
fn square_integral(wavenumber: f64, coefficients: &Coefficients) -> f64 {
    let boundary_term = |xi: f64| {
        let [w, d1, d2, d3] = scaled_derivatives(wavenumber, coefficients, xi);
        (3.0 * w * d3 - d1 * d2) / wavenumber + xi * (w * w - 2.0 * d1 * d3 + d2 * d2)
    };
    0.25 * (boundary_term(1.0) - boundary_term(0.0))
}

#[cfg(test)]
mod tests;
