//! The uniform beam and how its ends are held.

use crate::error::{BeamError, positive, stiffness};

/// A uniform Euler-Bernoulli beam.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct UniformBeam {
    /// Length `L` (m).
    pub length: f64,
    /// Bending stiffness `EI` (N·m²).
    pub bending_stiffness: f64,
    /// Mass per length `ρA` (kg/m).
    pub mass_per_length: f64,
}

impl UniformBeam {
    /// A beam of rectangular section: `A = b·h`, `I = b·h³/12`, bending in the direction of `thickness` (SI units).
    #[must_use]
    pub fn rectangular(length: f64, section: [f64; 2], youngs_modulus: f64, density: f64) -> Self {
        let [width, thickness] = section;
        Self {
            length,
            bending_stiffness: youngs_modulus * width * thickness.powi(3) / 12.0,
            mass_per_length: density * width * thickness,
        }
    }

    /// A tube of outer and inner diameter (m): `A = π(D² − d²)/4`, `I = π(D⁴ − d⁴)/64`.
    #[must_use]
    pub fn tube(length: f64, diameters: [f64; 2], youngs_modulus: f64, density: f64) -> Self {
        let [outer, inner] = diameters;
        Self {
            length,
            bending_stiffness: youngs_modulus * std::f64::consts::PI * (outer.powi(4) - inner.powi(4)) / 64.0,
            mass_per_length: density * std::f64::consts::PI * (outer.powi(2) - inner.powi(2)) / 4.0,
        }
    }

    /// Angular frequency (rad/s) of the dimensionless wavenumber `βL`: `ω = (βL)² √(EI/ρA)/L²`.
    #[must_use]
    pub fn angular_frequency(&self, wavenumber: f64) -> f64 {
        wavenumber * wavenumber * (self.bending_stiffness / self.mass_per_length).sqrt()
            / (self.length * self.length)
    }

    pub(crate) fn check(&self) -> Result<(), BeamError> {
        positive("beam length [m]", self.length)?;
        positive("bending stiffness [N·m²]", self.bending_stiffness)?;
        positive("mass per length [kg/m]", self.mass_per_length)
    }
}

/// How the ends are held: clamp at `x = 0` (no displacement), support at `x = L`.
///
/// `EI w''(0) = k_c w'(0)`, `EI w''(L) = −k_r w'(L)`, `EI w'''(L) = k_s w(L)`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Boundary {
    /// Rotational stiffness of the clamp `k_c` (N·m/rad); infinite = rigid.
    pub clamp_rotational_stiffness: f64,
    /// Transverse stiffness of the support `k_s` (N/m); 0 = free, infinite = pinned.
    pub support_stiffness: f64,
    /// Rotational stiffness of the support `k_r` (N·m/rad).
    pub support_rotational_stiffness: f64,
}

impl Default for Boundary {
    /// The cantilever.
    fn default() -> Self {
        Self {
            clamp_rotational_stiffness: f64::INFINITY,
            support_stiffness: 0.0,
            support_rotational_stiffness: 0.0,
        }
    }
}

/// Below this `k_c L/EI` the beam hangs on its clamp spring alone as a rigid body and rounding spoils the first mode.
const SOFTEST_CLAMP: f64 = 1e-4;

impl Boundary {
    /// Rigid clamp, free end.
    #[must_use]
    pub fn cantilever() -> Self {
        Self::default()
    }

    /// Rigid clamp, pinned end.
    #[must_use]
    pub fn pinned() -> Self {
        Self { support_stiffness: f64::INFINITY, ..Self::default() }
    }

    /// Rigid clamp, end on a transverse spring (N/m).
    #[must_use]
    pub fn spring(support_stiffness: f64) -> Self {
        Self { support_stiffness, ..Self::default() }
    }

    /// The stiffness `k_s` (N/m) from which a motion `w(L)` tells the reaction of the support, `k_s w(L)`: a pin has a reaction without a motion, and is
    /// modelled by a spring some thousand times as stiff as the beam, `k_s = 10⁴ EI/L³` and more.
    ///
    /// # Errors
    /// [`BeamError::OutOfRange`] where it is infinite, or below zero.
    pub fn reaction_stiffness(&self) -> Result<f64, BeamError> {
        let found = self.support_stiffness;
        if (0.0..f64::INFINITY).contains(&found) {
            return Ok(found);
        }
        Err(BeamError::OutOfRange {
            quantity: "support stiffness [N/m]",
            found,
            allowed: "0 to any finite value where its reaction is asked; for a pin 1e4 EI/L³ and more",
        })
    }

    pub(crate) fn check(&self, beam: &UniformBeam) -> Result<(), BeamError> {
        stiffness("clamp rotational stiffness [N·m/rad]", self.clamp_rotational_stiffness)?;
        stiffness("support stiffness [N/m]", self.support_stiffness)?;
        stiffness("support rotational stiffness [N·m/rad]", self.support_rotational_stiffness)?;
        let scale = beam.length / beam.bending_stiffness;
        if self.clamp_rotational_stiffness * scale < SOFTEST_CLAMP {
            return Err(BeamError::Mechanism {
                clamp: self.clamp_rotational_stiffness,
                support: self.support_stiffness,
            });
        }
        Ok(())
    }

    /// The same in units of the beam: `EI/(k_c L)`, `k_s L³/EI`, `k_r L/EI`.
    pub(crate) fn dimensionless(&self, beam: &UniformBeam) -> Ends {
        let flexural = beam.bending_stiffness / beam.length;
        Ends {
            clamp_compliance: flexural / self.clamp_rotational_stiffness,
            support: self.support_stiffness * beam.length.powi(2) / flexural,
            support_rotation: self.support_rotational_stiffness / flexural,
        }
    }
}

/// The ends of a beam of unit length, stiffness and mass.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Ends {
    pub(crate) clamp_compliance: f64,
    pub(crate) support: f64,
    pub(crate) support_rotation: f64,
}

#[cfg(test)]
mod tests {
    use super::*;

    /// `0 · k_s w(L)` of a pin would be no number.
    #[test]
    fn the_reaction_of_a_pin_is_not_told_by_its_motion() {
        assert_eq!(Boundary::spring(2e5).reaction_stiffness(), Ok(2e5));
        assert_eq!(Boundary::cantilever().reaction_stiffness(), Ok(0.0));
        let refused = Boundary::pinned().reaction_stiffness().unwrap_err().to_string();
        assert!(refused.starts_with("support stiffness [N/m] is inf, allowed: 0 to any finite"), "{refused}");
        assert!(Boundary::spring(f64::NAN).reaction_stiffness().is_err());
    }
}
