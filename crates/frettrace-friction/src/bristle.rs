//! What the bristle laws share: Dahl, LuGre and hybrid are one equation with other saturation functions.
//!
//! # Equation
//! ```text
//! F_t = N⁺ (σ0 z + σ1(v) ż) + σ2 v        ż = v (1 − s(r))        r = σ0 z sgn(v) / μ
//! μ(v) = μ_k + (μ_s − μ_k) exp(−(|v|/v_s)^δ)        σ1(v) = σ1 exp(−(v/v_d)²)
//! ```
//! | [`Saturation`] | `1 − s(r)` |
//! |---|---|
//! | `Linear` | `1 − r` |
//! | `Power` | `sgn(1 − r) \|1 − r\|^i` |
//! | `Breakaway` | `1 − α(r) r`, `α` = 0 up to `r = b`, a half-sine rise to 1 at `r = 1` |
//!
//! # Pieces to build other laws from
//! [`Bristle::steady`] is μ(v); [`Bristle::deflect`] moves `z` over a step for *any* friction coefficient given as a
//! closure over an [`Instant`] (filtered velocity, film, age, position, sense of slip …); [`Bristle::advance`] does one
//! stroke; [`Bristle::rate`] is ż and [`Bristle::force`] puts the force together. [`Bristle`] itself is the law with
//! μ(v) as above.
//!
//! # Accuracy
//! The step is exact in `Δu` for constant μ (closed form for `Linear` and `Power`; Runge-Kutta of order four inside
//! the partial-slip zone of `Breakaway`). With μ varying inside the step `Linear` and `Breakaway` are of order four,
//! `Power` of order two. Reversals are split at the root of the Hermite velocity. Large `σ0 |Δu| / μ` is stable and
//! tends to `z = μ(v)/σ0`.

use std::ops::ControlFlow;

use crate::decay::{self, decay};
use crate::lift::{lift, positive_part, sign};
use crate::{FrictionLaw, Scalar, Step, Stretch, Stroke};

mod flow;
mod partial_slip;
mod plain;
mod stretch;
#[cfg(test)]
mod tests;

pub use flow::Friction;

/// How the bristle approaches its steady deflection.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Saturation {
    /// `s = r`: LuGre, and Dahl with exponent 1.
    Linear,
    /// `1 − s = sgn(1 − r)|1 − r|^exponent`: Dahl; 1/3 is Mindlin's partial slip.
    Power,
    /// Elastic up to `breakaway`, then a half-sine rise: elasto-plastic and hybrid.
    Breakaway,
}

/// How the friction coefficient depends on the slip velocity.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Steady {
    /// μ = μ_k.
    Constant,
    /// μ(v) = μ_k + (μ_s − μ_k) exp(−(|v|/v_s)^δ).
    Stribeck,
}

/// The parameters of the bristle family; what a law does not have is 0.
#[derive(Clone, Copy, Debug)]
pub struct Bristle<T> {
    /// Stiffness σ0 per newton of normal force (1/m).
    pub sigma0: T,
    /// Presliding damping σ1 per newton of normal force (s/m).
    pub sigma1: T,
    /// Velocity v_d above which presliding damping dies (m/s); infinite: it never does.
    pub v_d: T,
    /// Viscous damping σ2 (N·s/m).
    pub sigma2: T,
    /// Friction coefficient at rest.
    pub mu_s: T,
    /// Friction coefficient of fast slip.
    pub mu_k: T,
    /// Stribeck velocity v_s (m/s).
    pub v_s: T,
    /// Stribeck exponent δ.
    pub delta: T,
    /// Dahl's exponent i (used by [`Saturation::Power`]).
    pub exponent: T,
    /// Elastic share b of the steady deflection (used by [`Saturation::Breakaway`]).
    pub breakaway: T,
    /// The saturation function.
    pub saturation: Saturation,
    /// The steady friction coefficient.
    pub steady: Steady,
}

impl Bristle<f64> {
    /// The same law over another scalar.
    #[must_use]
    pub fn lift<T: Scalar>(&self) -> Bristle<T> {
        Bristle {
            sigma0: self.sigma0.into(),
            sigma1: self.sigma1.into(),
            v_d: self.v_d.into(),
            sigma2: self.sigma2.into(),
            mu_s: self.mu_s.into(),
            mu_k: self.mu_k.into(),
            v_s: self.v_s.into(),
            delta: self.delta.into(),
            exponent: self.exponent.into(),
            breakaway: self.breakaway.into(),
            saturation: self.saturation,
            steady: self.steady,
        }
    }
}

/// A moment inside a step, at which a friction coefficient is wanted.
#[derive(Clone, Copy, Debug)]
pub struct Instant<T> {
    /// Slip velocity (m/s).
    pub velocity: T,
    /// +1 or −1: the sense of the slip, also at the very reversal.
    pub direction: f64,
    /// Fraction of the step's duration ([`Step::at`] gives the slip there).
    pub fraction: T,
}

impl<T: Scalar> Bristle<T> {
    /// The plain bristle: linear saturation, constant friction coefficient, no damping.
    pub fn plain(sigma0: T, mu_k: T) -> Self {
        let (zero, one) = (T::from(0.0), T::from(1.0));
        Self {
            sigma0,
            sigma1: zero,
            v_d: T::from(f64::INFINITY),
            sigma2: zero,
            mu_s: mu_k,
            mu_k,
            v_s: one,
            delta: one,
            exponent: one,
            breakaway: zero,
            saturation: Saturation::Linear,
            steady: Steady::Constant,
        }
    }

    /// The steady friction coefficient μ(v).
    #[inline(always)]
    pub fn steady(&self, velocity: T) -> T {
        match self.steady {
            Steady::Constant => self.mu_k,
            Steady::Stribeck => stribeck(velocity, [self.mu_s, self.mu_k, self.v_s, self.delta]),
        }
    }

    /// Presliding damping σ1(v) = σ1 exp(−(v/v_d)²) (s/m).
    #[inline(always)]
    pub fn presliding_damping(&self, velocity: T) -> T {
        let (sigma1, v_d, v) = (self.sigma1.re(), self.v_d.re(), velocity.re());
        if T::NDERIV == 0 && sigma1 == 0.0 {
            return self.sigma1;
        }
        let ratio = v * v_d.recip();
        let decay = decay(ratio * ratio);
        let slope = 2.0 * sigma1 * decay * ratio / v_d;
        lift(sigma1 * decay, [decay, slope * ratio, -slope], [self.sigma1, self.v_d, velocity])
    }

    /// The new deflection `z` \[m\] after a step, with the friction coefficient μ of each instant.
    #[inline(always)]
    pub fn deflect(&self, z: T, step: &Step<T>, mu: impl Fn(Instant<T>) -> T) -> T {
        match step.strokes() {
            (stroke, None) => self.advance(z, &stroke, along(&stroke, &mu)),
            (first, Some(second)) => {
                let turned = self.advance(z, &first, along(&first, &mu));
                self.advance(turned, &second, along(&second, &mu))
            }
        }
    }

    /// The new deflection `z` \[m\] after one stroke; `mu` at its start, middle and end in time.
    #[inline(always)]
    pub fn advance(&self, z: T, stroke: &Stroke<T>, mu: [T; 3]) -> T {
        if mu.iter().any(|coefficient| coefficient.re() <= 0.0) {
            return T::from(0.0);
        }
        let friction = Friction::new(self.sigma0, stroke, mu);
        let loading = z * self.sigma0 * stroke.direction;
        let after = match self.saturation {
            Saturation::Linear => friction.linear(loading),
            Saturation::Power => friction.power(loading, self.exponent),
            Saturation::Breakaway => friction.breakaway(loading, self.breakaway),
        };
        after * (self.sigma0.recip() * stroke.direction)
    }

    /// The rate ż (m/s) of the deflection.
    #[inline(always)]
    pub fn rate(&self, z: T, velocity: T, mu: T) -> T {
        if mu.re() <= 0.0 {
            return T::from(0.0);
        }
        let r = z * self.sigma0 * sign(velocity.re()) / mu;
        velocity * self.elastic_share(r)
    }

    /// `1 − s(r)`: the share of the slip that deflects the bristle.
    #[inline(always)]
    pub fn elastic_share(&self, r: T) -> T {
        match self.saturation {
            Saturation::Linear => -r + 1.0,
            Saturation::Power => flow::power_share(r, self.exponent),
            Saturation::Breakaway => partial_slip::breakaway_share(r, self.breakaway),
        }
    }

    /// The friction force `N⁺ (σ0 z + σ1(v) ż) + σ2 v` \[N\].
    #[inline(always)]
    pub fn force(&self, z: T, rate: T, velocity: T, normal: T) -> T {
        let mut coefficient = self.sigma0 * z;
        if T::NDERIV > 0 || self.sigma1.re() != 0.0 {
            coefficient += self.presliding_damping(velocity) * rate;
        }
        positive_part(normal) * coefficient + self.sigma2 * velocity
    }
}

impl<T: Scalar> FrictionLaw<T> for Bristle<T> {
    type State = [T; 1];

    fn rest(&self) -> [T; 1] {
        [T::from(0.0)]
    }

    #[inline(always)]
    fn step(&self, state: [T; 1], step: &Step<T>) -> ([T; 1], T) {
        match plain::step(self, state[0].re(), step) {
            Some((z, force)) => ([T::from(z)], T::from(force)),
            None => self.general_step(state, step),
        }
    }

    #[inline]
    fn follow(
        &self,
        state: [T; 1],
        stretch: &Stretch<'_, T>,
        record: impl FnMut(usize, [T; 1], T) -> ControlFlow<()>,
    ) -> [T; 1] {
        stretch::follow(self, state, stretch, record)
    }
}

impl<T: Scalar> Bristle<T> {
    /// Any saturation, reversals, derivatives.
    #[inline(never)]
    fn general_step(&self, state: [T; 1], step: &Step<T>) -> ([T; 1], T) {
        let velocity = step.velocity[1];
        let last = self.steady(velocity);
        let mu = |instant: Instant<T>| {
            if instant.fraction.re() == 1.0 { last } else { self.steady(instant.velocity) }
        };
        let z = self.deflect(state[0], step, mu);
        let undamped = T::NDERIV == 0 && self.sigma1.re() == 0.0;
        let rate = if undamped { velocity } else { self.rate(z, velocity, last) };
        ([z], self.force(z, rate, velocity, step.normal[1]))
    }
}

/// The friction coefficient at the start, the middle and the end of a stroke.
#[inline(always)]
fn along<T: Scalar>(stroke: &Stroke<T>, mu: &impl Fn(Instant<T>) -> T) -> [T; 3] {
    let at = |index: usize| {
        let (velocity, fraction) = (stroke.velocity[index], stroke.fraction[index]);
        mu(Instant { velocity, direction: stroke.direction, fraction })
    };
    [at(0), at(1), at(2)]
}

/// μ(v) = μ_k + (μ_s − μ_k) exp(−(|v|/v_s)^δ) with `[mu_s, mu_k, v_s, delta]`.
#[inline(always)]
pub fn stribeck<T: Scalar>(velocity: T, parameters: [T; 4]) -> T {
    let [mu_s, mu_k, v_s, delta] = parameters;
    let (excess, ratio) = (mu_s.re() - mu_k.re(), velocity.re().abs() * v_s.re().recip());
    if ratio == 0.0 {
        return mu_s;
    }
    let power = stribeck_power(ratio, delta.re());
    let decay = decay(power);
    let value = mu_k.re() + excess * decay;
    if T::NDERIV == 0 {
        return T::from(value);
    }
    let slope = excess * decay * power;
    let partials = [
        -slope * delta.re() / velocity.re(),
        decay,
        1.0 - decay,
        slope * delta.re() / v_s.re(),
        -slope * ratio.ln(),
    ];
    lift(value, partials, [velocity, mu_s, mu_k, v_s, delta])
}

/// `(|v|/v_s)^δ`.
#[inline(always)]
pub(crate) fn stribeck_power(ratio: f64, delta: f64) -> f64 {
    if delta == 2.0 {
        ratio * ratio
    } else if delta == 1.0 {
        ratio
    } else {
        decay::power(ratio, delta)
    }
}
