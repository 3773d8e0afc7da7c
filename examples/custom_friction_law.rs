//! A friction law of one's own: the Jenkins element, a spring in series with a Coulomb slider.

#![expect(clippy::print_stdout, reason = "an example prints")]

use frettrace_friction::{Closing, FrictionLaw, Period, Scalar, Step, close_loop, positive_part};
use std::f64::consts::TAU;

// ANCHOR: law
/// `F = k_t (u − w)`, where the slider's position `w` follows as soon as `|F|` would exceed `μN`.
#[derive(Clone, Copy)]
struct Jenkins<T> {
    /// Tangential stiffness `k_t` (N/m).
    stiffness: T,
    /// Friction coefficient `μ`.
    mu: T,
}

impl<T: Scalar> FrictionLaw<T> for Jenkins<T> {
    /// The force carried by the spring (N).
    type State = [T; 1];

    fn rest(&self) -> [T; 1] {
        [T::from(0.0)]
    }

    fn step(&self, [force]: [T; 1], step: &Step<T>) -> ([T; 1], T) {
        let trial = force + self.stiffness * (step.slip[1] - step.slip[0]);
        let limit = self.mu * positive_part(step.normal[1]);
        let force = if trial.re().abs() <= limit.re() { trial } else { limit * trial.re().signum() };
        ([force], force)
    }
}
// ANCHOR_END: law

fn main() -> anyhow::Result<()> {
    // Parameters
    let law = Jenkins { stiffness: 2.0e6, mu: 0.3 };
    let (amplitude, normal, samples) = (20e-6, 100.0, 20_000);

    // Data: one period of slip of the given amplitude.
    let phase = |k: usize| TAU * k as f64 / samples as f64;
    let slip: Vec<f64> = (0..samples).map(|k| amplitude * phase(k).cos()).collect();
    let velocity: Vec<f64> = (0..samples).map(|k| -amplitude * TAU * phase(k).sin()).collect();
    let normal_force = vec![normal; samples];

    // Solve: repeat the period until the loop closes.
    let period = Period { slip: &slip, velocity: &velocity, normal: &normal_force, dt: 1.0 / samples as f64 };
    let mut force = vec![0.0; samples];
    let closed = close_loop(&law, &period, &mut force, Closing::default())?;

    // Look: energy per cycle against the closed form 4 μN (A − μN/k_t).
    let energy: f64 = force.iter().zip(&velocity).map(|(f, v)| f * v / samples as f64).sum();
    let limit = law.mu * normal;
    println!("closed: {} after {} periods", closed.closed, closed.periods);
    println!("energy per cycle {:.4} mJ", 1e3 * energy);
    println!("closed form      {:.4} mJ", 4e3 * limit * (amplitude - limit / law.stiffness));
    Ok(())
}
