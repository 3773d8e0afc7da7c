//! Hermite finite elements: a third, independent description of the beam.

use faer::{Mat, MatRef, Side};

use crate::beam::UniformBeam;
use crate::dof::{Dof, Freedom};
use crate::error::{BeamError, positive};

/// A clamped beam of equal Hermite Euler-Bernoulli elements with consistent mass.
///
/// Unknowns are `w_1, θ_1, w_2, θ_2, …` from the first node after the clamp.
#[derive(Clone, Debug)]
pub struct FiniteElements {
    element_length: f64,
    mass: Mat<f64>,
    stiffness: Mat<f64>,
}

/// Natural frequencies (rad/s), rising, and mass-normalised modes (columns).
#[derive(Clone, Debug)]
pub struct EigenModes {
    /// Natural frequencies (rad/s).
    pub natural_frequency: Vec<f64>,
    /// Mass-normalised modes, one column each.
    pub modes: Mat<f64>,
}

impl FiniteElements {
    /// The beam clamped at `x = 0`, free elsewhere.
    ///
    /// # Errors
    /// [`BeamError`] where a quantity is out of range or there is no element.
    pub fn clamped(beam: &UniformBeam, elements: usize) -> Result<Self, BeamError> {
        beam.check()?;
        positive("number of elements", elements as f64)?;
        let length = beam.length / elements as f64;
        let (stiffness, mass) = element_matrices(beam, length);
        let size = 2 * elements;
        let mut result =
            Self { element_length: length, mass: Mat::zeros(size, size), stiffness: Mat::zeros(size, size) };
        for element in 0..elements {
            for row in 0..4 {
                for column in 0..4 {
                    // Unknowns of the clamped node would be −2 and −1.
                    let (Some(i), Some(j)) =
                        ((2 * element + row).checked_sub(2), (2 * element + column).checked_sub(2))
                    else {
                        continue;
                    };
                    result.stiffness[(i, j)] += stiffness[row][column];
                    result.mass[(i, j)] += mass[row][column];
                }
            }
        }
        Ok(result)
    }

    /// Number of unknowns.
    #[must_use]
    pub fn size(&self) -> usize {
        self.mass.nrows()
    }

    /// Mass matrix.
    #[must_use]
    pub fn mass(&self) -> MatRef<'_, f64> {
        self.mass.as_ref()
    }

    /// Stiffness matrix.
    #[must_use]
    pub fn stiffness(&self) -> MatRef<'_, f64> {
        self.stiffness.as_ref()
    }

    /// Index of an unknown of a node; node 0 is the clamp, whose motion is `None`.
    #[must_use]
    pub fn index(&self, node: usize, freedom: Freedom) -> Option<usize> {
        let index = (2 * node).checked_sub(2)? + usize::from(freedom == Freedom::Rotation);
        (index < self.size()).then_some(index)
    }

    /// The row that gives a motion anywhere from the unknowns (Hermite interpolation); its transpose spreads a load.
    #[must_use]
    pub fn row(&self, dof: Dof) -> Vec<f64> {
        let elements = self.size() / 2;
        let place = dof.position / self.element_length;
        let element = (place.floor().max(0.0) as usize).min(elements - 1);
        let s = place - element as f64;
        let l = self.element_length;
        let weights = match dof.freedom {
            Freedom::Displacement => [
                1.0 - 3.0 * s * s + 2.0 * s.powi(3),
                l * (s - 2.0 * s * s + s.powi(3)),
                3.0 * s * s - 2.0 * s.powi(3),
                l * (s.powi(3) - s * s),
            ],
            Freedom::Rotation => [
                (6.0 * s * s - 6.0 * s) / l,
                1.0 - 4.0 * s + 3.0 * s * s,
                (6.0 * s - 6.0 * s * s) / l,
                3.0 * s * s - 2.0 * s,
            ],
        };
        let mut row = vec![0.0; self.size()];
        for (local, weight) in weights.into_iter().enumerate() {
            if let Some(index) = (2 * element + local).checked_sub(2) {
                row[index] += weight;
            }
        }
        row
    }

    /// Adds a spring [N/m or N·m/rad] between a degree of freedom and the ground: `K ← K + k r rᵀ`.
    pub fn add_spring(&mut self, dof: Dof, stiffness: f64) {
        let row = self.row(dof);
        add_rank_one(&mut self.stiffness, &row, stiffness);
    }

    /// Adds a point mass [kg or kg·m²].
    pub fn add_mass(&mut self, dof: Dof, mass: f64) {
        let row = self.row(dof);
        add_rank_one(&mut self.mass, &row, mass);
    }

    /// All natural frequencies and modes, by `M = LLᵀ` and the symmetric problem `L⁻¹KL⁻ᵀ`.
    ///
    /// # Errors
    /// [`BeamError::Eigenvalues`] where the mass matrix is not positive definite or the iteration fails.
    pub fn eigenmodes(&self) -> Result<EigenModes, BeamError> {
        let failed = |reason| BeamError::Eigenvalues { size: self.size(), reason };
        let factor =
            self.mass.llt(Side::Lower).map_err(|_| failed("the mass matrix is not positive definite"))?;
        let lower = factor.L();
        let mut half = self.stiffness.clone();
        lower.solve_lower_triangular_in_place(half.as_mut());
        let mut standard = half.transpose().to_owned();
        lower.solve_lower_triangular_in_place(standard.as_mut());
        let eigen =
            standard.self_adjoint_eigen(Side::Lower).map_err(|_| failed("the iteration did not converge"))?;
        let mut modes = eigen.U().to_owned();
        lower.transpose().solve_upper_triangular_in_place(modes.as_mut());
        let squares = eigen.S().column_vector();
        let natural_frequency = (0..self.size()).map(|n| squares[n].max(0.0).sqrt()).collect();
        Ok(EigenModes { natural_frequency, modes })
    }
}

fn add_rank_one(matrix: &mut Mat<f64>, row: &[f64], value: f64) {
    for (i, &a) in row.iter().enumerate() {
        for (j, &b) in row.iter().enumerate() {
            matrix[(i, j)] += value * a * b;
        }
    }
}

/// Stiffness and consistent mass of one element.
fn element_matrices(beam: &UniformBeam, l: f64) -> ([[f64; 4]; 4], [[f64; 4]; 4]) {
    let k = beam.bending_stiffness / l.powi(3);
    let stiffness = [
        [12.0, 6.0 * l, -12.0, 6.0 * l],
        [6.0 * l, 4.0 * l * l, -6.0 * l, 2.0 * l * l],
        [-12.0, -6.0 * l, 12.0, -6.0 * l],
        [6.0 * l, 2.0 * l * l, -6.0 * l, 4.0 * l * l],
    ];
    let m = beam.mass_per_length * l / 420.0;
    let mass = [
        [156.0, 22.0 * l, 54.0, -13.0 * l],
        [22.0 * l, 4.0 * l * l, 13.0 * l, -3.0 * l * l],
        [54.0, 13.0 * l, 156.0, -22.0 * l],
        [-13.0 * l, -3.0 * l * l, -22.0 * l, 4.0 * l * l],
    ];
    (stiffness.map(|row| row.map(|v| v * k)), mass.map(|row| row.map(|v| v * m)))
}

#[cfg(test)]
mod tests;
