//! Receptances between a list of degrees of freedom, over many frequencies without allocation.

use num_complex::Complex64;

use crate::dof::Dof;
use crate::modal::ModalModel;

/// Shapes and residuals of a [`ModalModel`] at a list of degrees of freedom.
///
/// Only frequencies and damping are read from the model at evaluation, so one probe serves a whole calibration
/// ([`ModalModel::set_mode`]). Matrices are square, row-major, symmetric: entry `[i·len + j]` is the motion at degree of
/// freedom `i` per unit load at `j`.
#[derive(Clone, Debug, PartialEq)]
pub struct Probe {
    dofs: Vec<Dof>,
    modes: usize,
    shapes: Vec<f64>,
    residual: Vec<f64>,
}

impl Probe {
    pub(crate) fn new(model: &ModalModel, dofs: &[Dof]) -> Self {
        let count = dofs.len();
        let shapes: Vec<f64> =
            model.shapes().iter().flat_map(|shape| dofs.iter().map(|&dof| shape.at(dof))).collect();
        let mut residual = vec![0.0; count * count];
        for i in 0..count {
            for j in i..count {
                let products = shapes.chunks_exact(count).map(|shape| shape[i] * shape[j]);
                let value = model.residual_of((dofs[i], dofs[j]), products);
                residual[i * count + j] = value;
                residual[j * count + i] = value;
            }
        }
        Self { dofs: dofs.to_vec(), modes: model.mode_count(), shapes, residual }
    }

    /// The degrees of freedom, in the order of the rows.
    #[must_use]
    pub fn dofs(&self) -> &[Dof] {
        &self.dofs
    }

    /// Shape values of one mode (from 0) at all degrees of freedom.
    #[must_use]
    pub fn shape(&self, mode: usize) -> &[f64] {
        &self.shapes[mode * self.dofs.len()..(mode + 1) * self.dofs.len()]
    }

    /// The static residual matrix.
    #[must_use]
    pub fn residual(&self) -> &[f64] {
        &self.residual
    }

    /// Fills `matrix` (`len²`) with the receptances at `omega` (rad/s).
    pub fn receptances(&self, model: &ModalModel, omega: f64, matrix: &mut [Complex64]) {
        let size = self.dofs.len();
        for (entry, &residual) in matrix.iter_mut().zip(&self.residual) {
            *entry = Complex64::from(residual);
        }
        for mode in 0..self.modes {
            let gain = model.modal_receptance(mode, omega);
            let shape = self.shape(mode);
            for (row, &output) in shape.iter().enumerate() {
                let scaled = gain * output;
                for (entry, &input) in matrix[row * size..(row + 1) * size].iter_mut().zip(shape) {
                    *entry += scaled * input;
                }
            }
        }
    }

    /// Fills `matrix` with the derivative of the receptances with respect to `ω_n` (`[0]`) and `ζ_n` (`(1)`) of one mode.
    pub fn gradient(&self, model: &ModalModel, mode: usize, omega: f64, matrices: [&mut [Complex64]; 2]) {
        let size = self.dofs.len();
        let shape = self.shape(mode);
        for (matrix, gain) in matrices.into_iter().zip(model.modal_receptance_gradient(mode, omega)) {
            for (index, entry) in matrix.iter_mut().enumerate() {
                *entry = gain * (shape[index / size] * shape[index % size]);
            }
        }
    }
}
