//! Masses, springs and dashpots added to a structure known by its receptances.

use num_complex::Complex64;

use crate::dof::{Dof, Freedom, Receptance};

/// What is attached between a degree of freedom and the ground.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Element {
    /// Mass (kg), or rotary inertia (kg·m²) on a rotation.
    Mass(f64),
    /// Spring [N/m or N·m/rad].
    Spring(f64),
    /// Viscous dashpot [N·s/m or N·m·s/rad].
    Dashpot(f64),
}

impl Element {
    /// Load per unit motion at `omega` (rad/s): `−ω²m`, `k` or `iωc`.
    #[must_use]
    pub fn dynamic_stiffness(self, omega: f64) -> Complex64 {
        match self {
            Self::Mass(mass) => Complex64::from(-omega * omega * mass),
            Self::Spring(stiffness) => Complex64::from(stiffness),
            Self::Dashpot(damping) => Complex64::new(0.0, omega * damping),
        }
    }

    /// Derivative of [`Self::dynamic_stiffness`] with respect to the element's value.
    #[must_use]
    pub fn dynamic_stiffness_slope(self, omega: f64) -> Complex64 {
        match self {
            Self::Mass(_) => Self::Mass(1.0),
            Self::Spring(_) => Self::Spring(1.0),
            Self::Dashpot(_) => Self::Dashpot(1.0),
        }
        .dynamic_stiffness(omega)
    }
}

/// An element at a degree of freedom.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Attachment {
    /// Where it acts.
    pub dof: Dof,
    /// What it is.
    pub element: Element,
}

impl Attachment {
    /// Adds the element to a receptance matrix in place, `H ← H − h_a Z/(1 + Z H_aa) h_aᵀ`.
    ///
    /// `matrix` is square, row-major, `size × size`; `at` is the index of the attachment's degree of freedom in it. Several
    /// attachments are added one after the other.
    pub fn attach(&self, matrix: &mut [Complex64], size: usize, at: usize, omega: f64) {
        let stiffness = self.element.dynamic_stiffness(omega);
        let gain = stiffness / (1.0 + stiffness * matrix[at * size + at]);
        for row in 0..size {
            if row == at {
                continue;
            }
            let factor = matrix[row * size + at] * gain;
            for column in 0..size {
                let load = matrix[at * size + column];
                if column != at {
                    matrix[row * size + column] -= factor * load;
                }
            }
        }
        // Row and column of the attachment itself shrink by the same factor.
        let shrink = 1.0 / (1.0 + stiffness * matrix[at * size + at]);
        for other in 0..size {
            matrix[at * size + other] *= shrink;
            if other != at {
                matrix[other * size + at] *= shrink;
            }
        }
    }
}

/// A structure with attachments; itself a structure, so that modifications nest.
#[derive(Clone, Debug, PartialEq)]
pub struct Modified<R> {
    /// The structure without them.
    pub base: R,
    /// The attachments.
    pub attachments: Vec<Attachment>,
}

impl<R: Receptance> Modified<R> {
    /// Derivative of a receptance with respect to the value of attachment `index`: `−H_oa (∂Z/∂p) H_ai`.
    #[must_use]
    pub fn value_derivative(&self, index: usize, pair: [Dof; 2], omega: f64) -> Complex64 {
        let at = self.attachments[index];
        let [output, input] = pair;
        -self.receptance(output, at.dof, omega)
            * at.element.dynamic_stiffness_slope(omega)
            * self.receptance(at.dof, input, omega)
    }

    /// Derivative of a receptance with respect to the position of attachment `index` (1/m), for an attachment to a
    /// displacement: `−Z (H_oθ H_ai + H_oa H_θi)` with `θ` the rotation at the same place; `None` for one to a rotation.
    #[must_use]
    pub fn position_derivative(&self, index: usize, pair: [Dof; 2], omega: f64) -> Option<Complex64> {
        let at = self.attachments[index];
        if at.dof.freedom == Freedom::Rotation {
            return None;
        }
        let turn = Dof::rotation(at.dof.position);
        let [output, input] = pair;
        let product = self.receptance(output, turn, omega) * self.receptance(at.dof, input, omega)
            + self.receptance(output, at.dof, omega) * self.receptance(turn, input, omega);
        Some(-at.element.dynamic_stiffness(omega) * product)
    }
}

impl<R: Receptance> Receptance for Modified<R> {
    fn receptance(&self, output: Dof, input: Dof, omega: f64) -> Complex64 {
        let dofs: Vec<Dof> =
            [output, input].into_iter().chain(self.attachments.iter().map(|a| a.dof)).collect();
        let size = dofs.len();
        let mut matrix: Vec<Complex64> =
            dofs.iter().flat_map(|&o| dofs.iter().map(move |&i| self.base.receptance(o, i, omega))).collect();
        for (index, attachment) in self.attachments.iter().enumerate() {
            attachment.attach(&mut matrix, size, index + 2, omega);
        }
        matrix[1]
    }
}

#[cfg(test)]
mod tests;
