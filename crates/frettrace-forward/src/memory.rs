//! The memory equation: the beam reduced exactly to its point contact.
//!
//! Seen from the contact the beam is one number in time, `u(t) = u°(t) − ∫₀ᵗ h(t − s) F(s) ds`: the slip `u°` that all other loads
//! make, less the contact force convolved with the contact's own impulse response `h` (Szalai, Proc. R. Soc. A 470, 2013, 0593).
//! Nothing is truncated where `h` holds all modes: those summed and, at once, the residual flexibility of the rest.
//!
//! Why it matters: a beam has no mass at a point. At the pinned end of a beam `h(t) → 1/(2EIκ√(πt))`, `κ = (ρA/4EI)^{1/4}`, so that
//! a contact which sticks while it moves at `v₀` needs the force `4EIκ v₀ √(t/π)`: it sets in continuously. A sum of modes
//! without the residual has `h(t) ∝ t`, a mass, and needs an impulse.

use frettrace_beam::ModalModel;

use crate::ForwardError;
use crate::march::Port;

/// Convolution with the contact's impulse response, for forces that are linear between equidistant times and zero at the first.
#[derive(Clone, Debug, PartialEq)]
pub struct Memory {
    /// Slip (m) after `m` steps per unit (N) of the force's hat function.
    weights: Vec<f64>,
}

/// What a contact does to the slip.
#[derive(Clone, Debug, PartialEq)]
pub struct ContactMotion {
    /// Contact force (N), against positive slip.
    pub force: Vec<f64>,
    /// Slip (m).
    pub slip: Vec<f64>,
}

impl Memory {
    /// Weights of `samples` steps of `step` seconds at the contact `port`.
    ///
    /// The ramp response of a mode is `t/ω² − 2ζ/ω³ + e(t)` with
    /// `e(t) = e^{−ζωt}(2ζ/ω³ cos ω_d t + (2ζ² − 1)/(ω²ω_d) sin ω_d t)`; a hat is the second difference of ramps.
    ///
    /// # Errors
    /// [`ForwardError::NotPositive`] for a step that is not a positive number.
    pub fn new(model: &ModalModel, port: Port, step: f64, samples: usize) -> Result<Self, ForwardError> {
        let mut memory = Self::truncated(model, port, step, samples)?;
        if let Some(first) = memory.weights.first_mut() {
            *first += port.factor.powi(2) * model.residual(port.dof, port.dof);
        }
        Ok(memory)
    }

    /// The same of the summed modes alone, to show what that does.
    ///
    /// # Errors
    /// As of [`Self::new`].
    pub fn truncated(
        model: &ModalModel,
        port: Port,
        step: f64,
        samples: usize,
    ) -> Result<Self, ForwardError> {
        if !(step > 0.0 && step.is_finite()) {
            return Err(ForwardError::NotPositive { what: "step of the memory [s]", found: step });
        }
        let mut weights = vec![0.0; samples];
        for (n, shape) in model.shapes().iter().enumerate() {
            let participation = (port.factor * shape.at(port.dof)).powi(2);
            let mode = Mode { frequency: model.natural_frequency()[n], damping: model.damping_ratio()[n] };
            let [mut before, mut now] = [0.0, step].map(|t| mode.transient(t));
            for (m, weight) in weights.iter_mut().enumerate() {
                let hat = if m == 0 {
                    mode.steady(step) + now
                } else {
                    let after = mode.transient((m + 1) as f64 * step);
                    let hat = after - 2.0 * now + before;
                    (before, now) = (now, after);
                    hat
                };
                *weight += participation * hat / step;
            }
        }
        Ok(Self { weights })
    }

    /// Slip (m) that the forces of all earlier steps make at step `force.len()`.
    fn past(&self, force: &[f64]) -> f64 {
        force.iter().rev().zip(self.weights.iter().skip(1)).map(|(f, w)| f * w).sum()
    }

    /// The contact force that gives the slip `wanted` where all other loads alone would give `free` (m): the inverse.
    ///
    /// Lengths beyond the weights' or the shorter slice are left out.
    #[must_use]
    pub fn force(&self, free: &[f64], wanted: &[f64]) -> Vec<f64> {
        let mut force = Vec::with_capacity(free.len());
        for (free, wanted) in free.iter().zip(wanted).take(self.weights.len()) {
            let past = self.past(&force);
            force.push((free - past - wanted) / self.weights[0]);
        }
        force
    }

    /// Motion with rigid dry friction of the level `limit` (N): the contact sticks while that takes less force, and slips at it.
    #[must_use]
    pub fn dry_friction(&self, free: &[f64], limit: f64) -> ContactMotion {
        let mut motion = ContactMotion { force: Vec::new(), slip: Vec::new() };
        let mut held = free.first().copied().unwrap_or(0.0);
        for free in free.iter().take(self.weights.len()) {
            let here = free - self.past(&motion.force);
            let force = ((here - held) / self.weights[0]).clamp(-limit, limit);
            held = here - self.weights[0] * force;
            motion.force.push(force);
            motion.slip.push(held);
        }
        motion
    }
}

struct Mode {
    frequency: f64,
    damping: f64,
}

impl Mode {
    fn steady(&self, t: f64) -> f64 {
        t / self.frequency.powi(2) - 2.0 * self.damping / self.frequency.powi(3)
    }

    fn transient(&self, t: f64) -> f64 {
        let (w, z) = (self.frequency, self.damping);
        let damped = w * (1.0 - z * z).sqrt();
        let (sine, cosine) = (damped * t).sin_cos();
        (-z * w * t).exp() * (2.0 * z / w.powi(3) * cosine + (2.0 * z * z - 1.0) / (w * w * damped) * sine)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use frettrace_beam::{Boundary, Dof, ModalOptions, UniformBeam};
    use std::f64::consts::PI;

    const BEAM: UniformBeam = UniformBeam { length: 1.0, bending_stiffness: 1.0, mass_per_length: 1.0 };

    fn model(modes: usize, damping: f64) -> ModalModel {
        let options = ModalOptions { modes, damping_ratio: vec![damping], ..ModalOptions::default() };
        ModalModel::new(&BEAM, &Boundary::pinned(), &options).unwrap()
    }

    fn port() -> Port {
        Port { dof: Dof::rotation(1.0), factor: 1.0 }
    }

    /// A constant force makes the static rotation `L/4EI` (clamped-pinned beam) in the end: first frequency 15.4, so that 40
    /// time units at 10 % damping leave e^{-60} of the transient.
    #[test]
    fn weights_add_up_to_the_static_flexibility() {
        let memory = Memory::new(&model(40, 0.1), port(), 0.01, 4000).unwrap();
        let sum: f64 = memory.weights.iter().sum();
        assert!((sum - 0.25).abs() < 1e-9, "{sum}");
    }

    /// Stick onset: `F = 4EIκ v₀ √(t/π)`, `κ = (1/4)^{1/4}`, before the wave returns from the clamp. The square root at the start
    /// costs piecewise linear forces some per cent in the first ten steps, and less later.
    #[test]
    fn sticking_sets_in_as_the_square_root_of_time() {
        let step = 2e-6;
        let memory = Memory::new(&model(400, 0.0), port(), step, 200).unwrap();
        let free: Vec<f64> = (0..200).map(|k| k as f64 * step).collect();
        let force = memory.force(&free, &[0.0; 200]);
        let kappa = 0.25_f64.powf(0.25);
        for k in [20, 50, 100, 199] {
            let exact = 4.0 * kappa * (free[k] / PI).sqrt();
            assert!((force[k] / exact - 1.0).abs() < 0.03, "{k}: {} {exact}", force[k]);
        }
    }

    /// What friction does to the slip, the inverse takes out again.
    #[test]
    fn the_inverse_recovers_the_friction_force() {
        let memory = Memory::new(&model(40, 0.01), port(), 1e-3, 800).unwrap();
        let free: Vec<f64> = (0..800).map(|k| 0.2 * (1e-3 * f64::from(k) * 15.0).sin()).collect();
        let motion = memory.dry_friction(&free, 0.1);
        assert!(motion.force.iter().any(|f| f.abs() < 0.099) && motion.force.contains(&0.1));
        let back = memory.force(&free, &motion.slip);
        assert!(back.iter().zip(&motion.force).all(|(a, b)| (a - b).abs() < 1e-9));
    }

    #[test]
    fn a_step_must_be_positive() {
        assert!(Memory::new(&model(3, 0.0), port(), 0.0, 3).is_err());
    }
}
