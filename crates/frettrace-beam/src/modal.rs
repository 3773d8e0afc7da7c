//! The beam as a modal sum with its static residual.

use num_complex::Complex64;

use crate::beam::{Boundary, UniformBeam};
use crate::dof::{Dof, Receptance};
use crate::error::{BeamError, positive};
use crate::probe::Probe;
use crate::shape::{ModeShape, mode_shapes};
use crate::statics::Statics;

/// What is known about the modes besides the declared beam.
#[derive(Clone, Debug, PartialEq)]
pub struct ModalOptions {
    /// Modes summed; the rest acts through its static flexibility.
    pub modes: usize,
    /// Measured natural frequencies of the first modes (rad/s); may be empty.
    pub natural_frequency: Vec<f64>,
    /// Damping ratios of the first modes; the last one holds for all further modes, none given means undamped.
    pub damping_ratio: Vec<f64>,
    /// Factor on the declared beam's natural frequencies beyond the measured ones (1: the declared beam).
    pub higher_frequency_scale: f64,
}

impl Default for ModalOptions {
    fn default() -> Self {
        Self {
            modes: 100,
            natural_frequency: Vec::new(),
            damping_ratio: Vec::new(),
            higher_frequency_scale: 1.0,
        }
    }
}

/// The beam as modes and a residual.
///
/// `H(ω) = Σ_{n ≤ N} φ_n φ_n / (ω_n² − ω² + 2iζ_nω_nω) + R`, with mass-normalised shapes of the declared beam.
///
/// The residual `R = G − Σ_{n ≤ N} φ_n φ_n/ω_{n,declared}²` is the declared beam's static flexibility `G` less its own
/// first N modes: the flexibility of the modes beyond N and of nothing else. A measured frequency that differs from the
/// declared one therefore moves the static flexibility by exactly its mode's share `φφ (1/ω_n² − 1/ω_{n,declared}²)`,
/// and leaves the residual alone: taking `G` as the fixed total would let an error of the first frequency, which holds
/// most of the flexibility, reappear with the opposite sign in the residual at every harmonic. Modes beyond the measured
/// ones keep the declared beam's frequencies; `higher_frequency_scale` scales them, and the residual by its inverse square,
/// where Young's modulus is doubted.
#[derive(Clone, Debug, PartialEq)]
pub struct ModalModel {
    statics: Statics,
    shapes: Vec<ModeShape>,
    natural_frequency: Vec<f64>,
    damping_ratio: Vec<f64>,
    measured: usize,
    higher_frequency_scale: f64,
}

impl ModalModel {
    /// Modes of the declared beam with the measured values in place.
    ///
    /// # Errors
    /// [`BeamError`] where a quantity is out of range or more measured modes are given than summed.
    pub fn new(beam: &UniformBeam, boundary: &Boundary, options: &ModalOptions) -> Result<Self, BeamError> {
        positive("scale of the higher natural frequencies", options.higher_frequency_scale)?;
        let declared = Self {
            statics: Statics { beam: *beam, boundary: *boundary },
            shapes: mode_shapes(beam, boundary, options.modes)?,
            natural_frequency: Vec::new(),
            damping_ratio: Vec::new(),
            measured: 0,
            higher_frequency_scale: options.higher_frequency_scale,
        };
        declared.with_measured(&options.natural_frequency, &options.damping_ratio)
    }

    /// The same beam with other measured values, given as in [`ModalOptions`]; the shapes, which are dear, are taken over.
    ///
    /// # Errors
    /// As [`Self::new`].
    pub fn with_measured(&self, natural_frequency: &[f64], damping_ratio: &[f64]) -> Result<Self, BeamError> {
        let given = natural_frequency.len().max(damping_ratio.len());
        let held = self.shapes.len();
        if given > held {
            return Err(BeamError::TooManyMeasured { given, held });
        }
        for &frequency in natural_frequency {
            positive("natural frequency [rad/s]", frequency)?;
        }
        for &ratio in damping_ratio {
            if !(0.0..1.0).contains(&ratio) {
                return Err(BeamError::OutOfRange {
                    quantity: "damping ratio",
                    found: ratio,
                    allowed: "0 ≤ ζ < 1",
                });
            }
        }
        let declared =
            self.shapes.iter().map(|shape| self.higher_frequency_scale * shape.natural_frequency());
        let last = damping_ratio.last().copied().unwrap_or(0.0);
        Ok(Self {
            statics: self.statics,
            shapes: self.shapes.clone(),
            natural_frequency: declared
                .enumerate()
                .map(|(n, declared)| natural_frequency.get(n).copied().unwrap_or(declared))
                .collect(),
            damping_ratio: (0..held).map(|n| damping_ratio.get(n).copied().unwrap_or(last)).collect(),
            measured: natural_frequency.len(),
            higher_frequency_scale: self.higher_frequency_scale,
        })
    }

    /// Number of modes summed.
    #[must_use]
    pub fn mode_count(&self) -> usize {
        self.shapes.len()
    }

    /// Number of modes whose frequency was given.
    #[must_use]
    pub fn measured_count(&self) -> usize {
        self.measured
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

    /// Shapes of the declared beam.
    #[must_use]
    pub fn shapes(&self) -> &[ModeShape] {
        &self.shapes
    }

    /// The declared beam.
    #[must_use]
    pub fn beam(&self) -> &UniformBeam {
        &self.statics.beam
    }

    /// The boundary the modes belong to.
    #[must_use]
    pub fn boundary(&self) -> &Boundary {
        &self.statics.boundary
    }

    /// Replaces natural frequency (rad/s) and damping ratio of a mode (from 0), as a calibration does; shapes and residual stay.
    pub fn set_mode(&mut self, mode: usize, natural_frequency: f64, damping_ratio: f64) {
        self.natural_frequency[mode] = natural_frequency;
        self.damping_ratio[mode] = damping_ratio;
    }

    /// Static flexibility of the modes beyond the last one summed.
    #[must_use]
    pub fn residual(&self, output: Dof, input: Dof) -> f64 {
        self.residual_of((output, input), self.shapes.iter().map(|s| s.at(output) * s.at(input)))
    }

    /// The same where the products of the shapes at both places are known.
    pub(crate) fn residual_of(
        &self,
        (output, input): (Dof, Dof),
        products: impl Iterator<Item = f64>,
    ) -> f64 {
        let flexibilities =
            self.shapes.iter().zip(products).map(|(s, product)| product / s.natural_frequency().powi(2));
        let summed: f64 = flexibilities.sum();
        (self.statics.flexibility(output, input) - summed) / self.higher_frequency_scale.powi(2)
    }

    /// Receptance of one modal coordinate, `1/(ω_n² − ω² + 2iζ_nω_nω)`.
    #[must_use]
    #[inline]
    pub fn modal_receptance(&self, mode: usize, omega: f64) -> Complex64 {
        self.dynamic_stiffness(mode, omega).inv()
    }

    /// Derivatives of [`Self::modal_receptance`] with respect to `ω_n` and `ζ_n`.
    #[must_use]
    pub fn modal_receptance_gradient(&self, mode: usize, omega: f64) -> [Complex64; 2] {
        let (frequency, ratio) = (self.natural_frequency[mode], self.damping_ratio[mode]);
        let receptance = self.modal_receptance(mode, omega);
        let squared = receptance * receptance;
        [
            -squared * Complex64::new(2.0 * frequency, 2.0 * ratio * omega),
            -squared * Complex64::new(0.0, 2.0 * frequency * omega),
        ]
    }

    #[inline]
    fn dynamic_stiffness(&self, mode: usize, omega: f64) -> Complex64 {
        let (frequency, ratio) = (self.natural_frequency[mode], self.damping_ratio[mode]);
        Complex64::new(frequency * frequency - omega * omega, 2.0 * ratio * frequency * omega)
    }

    /// Shapes and residuals at a list of degrees of freedom, computed once for many frequencies.
    #[must_use]
    pub fn probe(&self, dofs: &[Dof]) -> Probe {
        Probe::new(self, dofs)
    }
}

impl Receptance for ModalModel {
    fn receptance(&self, output: Dof, input: Dof, omega: f64) -> Complex64 {
        let modal: Complex64 = (0..self.mode_count())
            .map(|n| self.modal_receptance(n, omega) * (self.shapes[n].at(output) * self.shapes[n].at(input)))
            .sum();
        modal + self.residual(output, input)
    }
}

#[cfg(test)]
mod tests;
