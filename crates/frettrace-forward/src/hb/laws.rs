//! Contact elements that push back in more than the tangential direction, or have no memory.

use super::contact::{ContactLaw, Family};
use crate::march::Characteristic;
use frettrace_friction::{Scalar, Step};

/// Unilateral normal spring with a Jenkins element whose slip limit follows the normal force.
///
/// `N = max(N_0 + k_n g, 0)`, `T_k = clamp(T_{k−1} + k_t Δu, ±μ N_k)`: the first force is `T`, the second `N − N_0`. Lift-off
/// (`N = 0`) releases the spring. The normal input is the closing `g` (m); the slider is taken from sample to sample, as
/// in the codes compared with.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ElasticContact {
    /// Normal stiffness `k_n` (N/m).
    pub normal_stiffness: f64,
    /// Normal force at `g = 0` (N).
    pub preload: f64,
    /// Tangential stiffness `k_t` (N/m).
    pub tangential_stiffness: f64,
    /// Friction coefficient `μ`.
    pub friction_coefficient: f64,
}

impl Family for ElasticContact {
    type Law<T: Scalar> = Self;

    fn parameters(&self) -> &[f64] {
        &[]
    }

    fn law<T: Scalar>(&self, _: &[T]) -> Self {
        *self
    }
}

impl<T: Scalar> ContactLaw<T> for ElasticContact {
    type State = [T; 1];

    const FORCES: usize = 2;
    const VELOCITY: bool = false;

    fn rest(&self) -> [T; 1] {
        [T::zero()]
    }

    #[inline]
    fn step(&self, [spring]: [T; 1], step: &Step<T>) -> ([T; 1], [T; 2]) {
        let closed = positive(step.normal[1] * self.normal_stiffness + self.preload);
        let limit = closed * self.friction_coefficient;
        let trial = spring + (step.slip[1] - step.slip[0]) * self.tangential_stiffness;
        let tangential = if trial.re() > limit.re() {
            limit
        } else if trial.re() < -limit.re() {
            -limit
        } else {
            trial
        };
        ([tangential], [tangential, closed - self.preload])
    }
}

/// A stop behind a clearance, on one side or on both, with a damper that acts while it is touched and never pulls.
///
/// `f = max(k (x − c) + d ẋ, 0)` for `x > c`, likewise with the sign turned for `x < −c` if two-sided; else 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stop {
    /// Stiffness `k` (N/m).
    pub stiffness: f64,
    /// Damping while touched `d` (N s/m).
    pub damping: f64,
    /// Clearance `c` (m); negative: preloaded.
    pub clearance: f64,
    /// Whether there is one on the other side as well.
    pub two_sided: bool,
}

impl Family for Stop {
    type Law<T: Scalar> = Self;

    fn parameters(&self) -> &[f64] {
        &[]
    }

    fn law<T: Scalar>(&self, _: &[T]) -> Self {
        *self
    }
}

impl<T: Scalar> ContactLaw<T> for Stop {
    type State = [T; 0];

    const FORCES: usize = 1;

    fn rest(&self) -> [T; 0] {
        []
    }

    #[inline]
    fn step(&self, state: [T; 0], step: &Step<T>) -> ([T; 0], [T; 2]) {
        let push = |x: T, v: T| {
            let depth = x - self.clearance;
            if depth.re() > 0.0 { positive(depth * self.stiffness + v * self.damping) } else { T::zero() }
        };
        let [x, v] = [step.slip[1], step.velocity[1]];
        let force = push(x, v);
        (state, [if self.two_sided { force - push(-x, -v) } else { force }, T::zero()])
    }
}

/// A local load of the time march as an element of the harmonic balance; the force is minus the load.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LocalElement(pub Characteristic);

impl Family for LocalElement {
    type Law<T: Scalar> = Self;

    fn parameters(&self) -> &[f64] {
        &[]
    }

    fn law<T: Scalar>(&self, _: &[T]) -> Self {
        *self
    }
}

impl<T: Scalar> ContactLaw<T> for LocalElement {
    type State = [T; 0];

    const FORCES: usize = 1;

    fn rest(&self) -> [T; 0] {
        []
    }

    #[inline]
    fn step(&self, state: [T; 0], step: &Step<T>) -> ([T; 0], [T; 2]) {
        let [x, v] = [step.slip[1], step.velocity[1]];
        let force = match self.0 {
            Characteristic::Spring(k) => x * k,
            Characteristic::CubicSpring(k) => x * x * x * k,
            Characteristic::Dashpot(c) => v * c,
            Characteristic::QuadraticDashpot(c) => v * v * (c * v.re().signum()),
            Characteristic::Stop { stiffness, gap } => positive(x - gap) * stiffness,
            Characteristic::YieldingCubicSpring { stiffness, scale } => {
                let ratio = x / scale;
                x * x * x * stiffness / (ratio * ratio + 1.0)
            }
            Characteristic::HyperbolicSpring { stiffness, scale } => {
                let ratio = x / scale;
                (ratio.sinh() - ratio) * (6.0 * stiffness * scale.powi(3))
            }
            Characteristic::SmoothStop { stiffness, gap, smoothness } => {
                let ratio = (x - gap) / smoothness;
                let distance = ratio * ratio.re().signum();
                (positive(ratio) + (-distance).exp().ln_1p()) * (stiffness * smoothness)
            }
            // The power's derivative at rest is undefined below 1; from 1 on the force and its slope are 0 there.
            Characteristic::PowerDashpot { damping, power } => {
                let sense = v.re().signum();
                if v.re() == 0.0 { T::zero() } else { (v * sense).powf(power) * (damping * sense) }
            }
            Characteristic::RoundStop { stiffness, gap } => {
                let pressed = positive(x - gap);
                if pressed.re() > 0.0 { pressed.powf(1.5) * stiffness } else { pressed }
            }
            Characteristic::EvenSpring(k) => x * x * k,
            Characteristic::SmoothCoulomb { level, velocity } => (v / velocity).tanh() * level,
        };
        (state, [force, T::zero()])
    }
}

#[inline]
fn positive<T: Scalar>(value: T) -> T {
    if value.re() > 0.0 { value } else { T::zero() }
}
