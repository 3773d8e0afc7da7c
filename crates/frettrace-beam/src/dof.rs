//! Degrees of freedom of the beam, and what is known about a structure through them.

use num_complex::Complex64;

/// Which motion of a point is meant.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Freedom {
    /// Transverse displacement `w` (m); its conjugate load is a force (N).
    Displacement,
    /// Rotation `θ = dw/dx` (rad); its conjugate load is a moment (N·m).
    Rotation,
}

/// A degree of freedom of the beam: a place and a motion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Dof {
    /// Position from the clamp (m).
    pub position: f64,
    /// The motion.
    pub freedom: Freedom,
}

impl Dof {
    /// The transverse displacement at a position (m).
    #[must_use]
    pub fn displacement(position: f64) -> Self {
        Self { position, freedom: Freedom::Displacement }
    }

    /// The rotation at a position (m).
    #[must_use]
    pub fn rotation(position: f64) -> Self {
        Self { position, freedom: Freedom::Rotation }
    }
}

/// A linear structure known by its receptances.
pub trait Receptance {
    /// Motion at `output` per unit load at `input` at angular frequency `omega` (rad/s) (`e^{+iωt}`).
    fn receptance(&self, output: Dof, input: Dof, omega: f64) -> Complex64;
}
