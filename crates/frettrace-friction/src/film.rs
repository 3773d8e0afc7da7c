//! The lubricant film between sliding surfaces, after Yanada and Tran: its thickness follows the velocity with a delay.
//!
//! `dh/dt = (h_ss − h)/τ`, `h_ss = (1 − μ_k/μ_s) min(|v|/v_b, 1)^{2/3}`; `τ` is `tau_growth` while the film grows,
//! `tau_decay` while it thins, `tau_rest` at rest. The static level falls with the film:
//! `μ(v, h) = μ_k + [(1 − h) μ_s − μ_k] exp(−(|v|/v_s)^δ)`.

use crate::bristle::stribeck;
use crate::parameter::{Parameter, Range};
use crate::{Scalar, Step, positive_part};

/// Velocity v_b at which the film is full.
pub const V_B: Parameter = Parameter::new("v_b", "m/s", Range::POSITIVE, 2e-3);
/// Time constant of a growing film.
pub const TAU_GROWTH: Parameter = Parameter::new("tau_growth", "s", Range::POSITIVE, 5e-3);
/// Time constant of a thinning film.
pub const TAU_DECAY: Parameter = Parameter::new("tau_decay", "s", Range::POSITIVE, 2e-2);
/// Time constant at rest.
pub const TAU_REST: Parameter = Parameter::new("tau_rest", "s", Range::POSITIVE, 1.0);
/// Time constant of the fluid's inertia.
pub const INERTIA: Parameter = Parameter::new("inertia", "s", Range::NOT_NEGATIVE, 1e-3);

/// Parameters of the film and of the Stribeck curve it moves.
#[derive(Clone, Copy, Debug)]
pub struct Film<T> {
    /// Friction coefficient at rest.
    pub mu_s: T,
    /// Friction coefficient of fast slip.
    pub mu_k: T,
    /// Stribeck velocity (m/s).
    pub v_s: T,
    /// Stribeck exponent.
    pub delta: T,
    /// Velocity at which the film is full (m/s).
    pub v_b: T,
    /// Time constants \[s\]: growth, decay, rest.
    pub tau: [T; 3],
}

impl<T: Scalar> Film<T> {
    /// Steady thickness at a slip velocity (m/s), dimensionless.
    pub fn steady(&self, velocity: T) -> T {
        let full = positive_part(-self.mu_k / self.mu_s + 1.0);
        let ratio = velocity / self.v_b;
        let size = if ratio.re() < 0.0 { -ratio } else { ratio };
        if size.re() >= 1.0 {
            full
        } else if size.re() == 0.0 {
            T::from(0.0)
        } else {
            full * (size * size).cbrt()
        }
    }

    /// Thickness after a step, exact for a steady thickness that changes linearly in it.
    pub fn step(&self, thickness: T, step: &Step<T>) -> T {
        let [before, after] = step.velocity.map(|velocity| self.steady(velocity));
        let [growth, decay, rest] = self.tau;
        let tau = if step.velocity[0].re() == 0.0 && step.velocity[1].re() == 0.0 {
            rest
        } else if before.re() + after.re() >= 2.0 * thickness.re() {
            growth
        } else {
            decay
        };
        let length = tau.recip() * step.dt;
        let slope = -(-length).exp_m1() / length;
        after + (thickness - before) * (-length).exp() - (after - before) * slope
    }

    /// Friction coefficient at a slip velocity (m/s) and a thickness.
    #[inline]
    pub fn coefficient(&self, velocity: T, thickness: T) -> T {
        stribeck(velocity, [self.mu_s * (-thickness + 1.0), self.mu_k, self.v_s, self.delta])
    }
}

/// Slip acceleration (m/s²) of the Hermite cubic at the end of a step.
pub fn acceleration<T: Scalar>(step: &Step<T>) -> T {
    let [v0, v1] = step.velocity;
    let mean = (step.slip[1] - step.slip[0]) / step.dt;
    (v0 * 2.0 + v1 * 4.0 - mean * 6.0) / step.dt
}
