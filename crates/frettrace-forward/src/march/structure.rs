//! The linear structure of a march: modes, and shapes at ports.

use frettrace_beam::{Dof, ModalModel};
use nalgebra::{DMatrix, SymmetricEigen};

use crate::ForwardError;

/// A place where loads act or motions are read: `factor` times a degree of freedom (a slip is a lever arm times a rotation).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Port {
    /// The degree of freedom.
    pub dof: Dof,
    /// Factor on motion and load alike.
    pub factor: f64,
}

/// Modes of a structure and their shapes at its ports.
#[derive(Clone, Debug, PartialEq)]
pub struct Structure {
    natural_frequency: Vec<f64>,
    damping_ratio: Vec<f64>,
    rows: Vec<Vec<f64>>,
}

/// The residual flexibility moves with modes this far above the last one, …
const RESIDUAL_FREQUENCY: f64 = 1.5;
/// … damped so that they follow their load without ringing.
const RESIDUAL_DAMPING: f64 = 0.7;

impl Structure {
    /// Modes (rad/s, damping ratios) with mass-normalised shapes, one row a port.
    ///
    /// # Errors
    /// [`ForwardError`] where sizes differ or a frequency is not positive.
    pub fn new(
        natural_frequency: Vec<f64>,
        damping_ratio: Vec<f64>,
        rows: Vec<Vec<f64>>,
    ) -> Result<Self, ForwardError> {
        let expected = natural_frequency.len();
        let sizes = rows.iter().map(|row| ("shape values of a port", row.len()));
        for (what, found) in sizes.chain([("damping ratios", damping_ratio.len())]) {
            if found != expected {
                return Err(ForwardError::Size { what, expected, found });
            }
        }
        for &found in &natural_frequency {
            if !(found.is_finite() && found > 0.0) {
                return Err(ForwardError::NotPositive { what: "natural frequency (rad/s)", found });
            }
        }
        Ok(Self { natural_frequency, damping_ratio, rows })
    }

    /// A beam's modes, and its static residual as further modes far above them.
    ///
    /// The residual flexibility of all ports is a positive semidefinite matrix; each of its eigenvectors becomes one mode
    /// at 1.5 times the last frequency with damping ratio 0.7, so that the compliance at the ports is complete and the
    /// slip velocity that belongs to the residual is defined.
    ///
    /// # Errors
    /// [`ForwardError`] as of [`Self::new`].
    pub fn from_beam(model: &ModalModel, ports: &[Port]) -> Result<Self, ForwardError> {
        let modes = model.mode_count();
        let mut natural_frequency = model.natural_frequency().to_vec();
        let mut damping_ratio = model.damping_ratio().to_vec();
        let mut rows: Vec<Vec<f64>> =
            ports.iter().map(|p| model.shapes().iter().map(|s| p.factor * s.at(p.dof)).collect()).collect();
        let flexibility = DMatrix::from_fn(ports.len(), ports.len(), |i, j| {
            ports[i].factor * ports[j].factor * model.residual(ports[i].dof, ports[j].dof)
        });
        let frequency = RESIDUAL_FREQUENCY * natural_frequency[modes - 1];
        for shape in square_root(&flexibility) {
            natural_frequency.push(frequency);
            damping_ratio.push(RESIDUAL_DAMPING);
            for (row, value) in rows.iter_mut().zip(shape) {
                row.push(frequency * value);
            }
        }
        Self::new(natural_frequency, damping_ratio, rows)
    }

    /// Adds the port of a uniform acceleration of the base, `p_n = −∫ρAφ_n dx · a`; returns its index.
    ///
    /// From `φ'''' = (b/L)⁴φ`: `∫φ dx = [φ''']₀ᴸ (L/b)⁴`. Its share in the residual modes falls with the fifth power of
    /// the mode number and is left out.
    pub fn add_base(&mut self, model: &ModalModel) -> usize {
        let beam = model.beam();
        let participation = |shape: &frettrace_beam::ModeShape| {
            let ends = shape.derivatives(beam.length)[3] - shape.derivatives(0.0)[3];
            -beam.mass_per_length * ends * (beam.length / shape.wavenumber()).powi(4)
        };
        let mut row: Vec<f64> = model.shapes().iter().map(participation).collect();
        row.resize(self.mode_count(), 0.0);
        self.rows.push(row);
        self.rows.len() - 1
    }

    /// Adds a point mass (kg) at a port: new modes from `M = I + m φφᵀ`, `K = diag ω²`.
    ///
    /// Damping is transformed with the modes and its couplings, of the order of the damping ratio, are left out.
    ///
    /// # Errors
    /// [`ForwardError::Index`] where there is no such port, [`ForwardError::NotPositive`] for a mass that leaves no
    /// positive mass matrix.
    pub fn add_mass(&mut self, port: usize, mass: f64) -> Result<(), ForwardError> {
        let available = self.rows.len();
        let Some(row) = self.rows.get(port) else {
            return Err(ForwardError::Index { contact: 0, what: "port", index: port, available });
        };
        // M^{-1/2} = I − s φφᵀ of the rank-one matrix; the symmetric problem follows.
        let square: f64 = row.iter().map(|v| v * v).sum();
        if square == 0.0 {
            return Ok(());
        }
        if 1.0 + mass * square <= 0.0 {
            return Err(ForwardError::NotPositive {
                what: "modal mass with the added mass",
                found: 1.0 + mass * square,
            });
        }
        let shrink = (1.0 - (1.0 + mass * square).sqrt().recip()) / square;
        let size = self.mode_count();
        let half =
            DMatrix::from_fn(size, size, |i, j| f64::from(u8::from(i == j)) - shrink * row[i] * row[j]);
        let squares =
            DMatrix::from_fn(size, size, |i, j| if i == j { self.natural_frequency[i].powi(2) } else { 0.0 });
        let eigen = SymmetricEigen::new(&half * squares * &half);
        let vectors = half * eigen.eigenvectors;
        let damping = |n: usize| -> f64 {
            (0..size)
                .map(|k| 2.0 * self.damping_ratio[k] * self.natural_frequency[k] * vectors[(k, n)].powi(2))
                .sum()
        };
        let frequency: Vec<f64> = eigen.eigenvalues.iter().map(|v| v.max(0.0).sqrt()).collect();
        let ratio = (0..size).map(|n| damping(n) / (2.0 * frequency[n])).collect();
        for row in &mut self.rows {
            *row = (0..size).map(|n| (0..size).map(|k| vectors[(k, n)] * row[k]).sum()).collect();
        }
        self.natural_frequency = frequency;
        self.damping_ratio = ratio;
        Ok(())
    }

    /// Number of modes, those of the residual included.
    #[must_use]
    pub fn mode_count(&self) -> usize {
        self.natural_frequency.len()
    }

    /// Natural frequencies (rad/s).
    #[must_use]
    pub fn natural_frequency(&self) -> &[f64] {
        &self.natural_frequency
    }

    /// Damping ratios.
    #[must_use]
    pub fn damping_ratio(&self) -> &[f64] {
        &self.damping_ratio
    }

    /// Shape values at a port.
    #[must_use]
    pub fn row(&self, port: usize) -> &[f64] {
        &self.rows[port]
    }

    /// Number of ports.
    #[must_use]
    pub fn port_count(&self) -> usize {
        self.rows.len()
    }
}

/// Columns `s_k` with `R = Σ s_k s_kᵀ` of a positive semidefinite matrix, by the eigenvectors of its correlation form.
fn square_root(matrix: &DMatrix<f64>) -> Vec<Vec<f64>> {
    let scale: Vec<f64> = (0..matrix.nrows()).map(|i| matrix[(i, i)].max(0.0).sqrt()).collect();
    let correlation = DMatrix::from_fn(matrix.nrows(), matrix.ncols(), |i, j| {
        if scale[i] > 0.0 && scale[j] > 0.0 { matrix[(i, j)] / (scale[i] * scale[j]) } else { 0.0 }
    });
    let eigen = SymmetricEigen::new(correlation);
    // Two ports at one place are one direction: what is left of the other is rounding.
    let kept = (0..scale.len()).filter(|&k| eigen.eigenvalues[k] > 1e-9);
    kept.map(|k| {
        let root = eigen.eigenvalues[k].sqrt();
        (0..scale.len()).map(|i| scale[i] * root * eigen.eigenvectors[(i, k)]).collect()
    })
    .collect()
}
