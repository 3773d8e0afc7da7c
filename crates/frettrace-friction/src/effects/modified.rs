//! The modified law: the bristle family, one step at a time, with its hooks.
//!
//! ```text
//! F_t = N⁺(b + σ1(v)ż) + σ2 v + …,   db/dt = σ0 v φ(r),   r = b·sgn(v)/μ(v, u, N, …)
//! ```
//! A step is cut where the velocity changes sign (cubic Hermite interpolant of the slip), so that each stretch is
//! monotone and rate-independent laws depend on slip alone.

use super::hooks::{HOOKS, Hook};
use super::kernel::{elasto_plastic, power, powered, relax};
use crate::bristle::Friction;
use crate::law::{FrictionLaw, Scalar, Step, Stroke};

/// What a step needs to know beside the motion of the contact.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Circumstance {
    /// Preload `N₀` \[N\].
    pub preload: f64,
    /// Place of the run between the first (0) and the last (1).
    pub progress: f64,
    /// Cosine and sine of the modulation's phase at the old and the new sample.
    pub phase: [[f64; 2]; 2],
}

impl Default for Circumstance {
    fn default() -> Self {
        Self { preload: 0.0, progress: 0.0, phase: [[1.0, 0.0]; 2] }
    }
}

/// Deflection `b = σ0 z`, film or age or lagged weight, engaged slip, lagged force.
#[derive(Clone, Copy, Debug)]
pub struct ModifiedState<T>(pub [T; 4]);

impl<T> AsRef<[T]> for ModifiedState<T> {
    fn as_ref(&self) -> &[T] {
        &self.0
    }
}

impl<T> AsMut<[T]> for ModifiedState<T> {
    fn as_mut(&mut self) -> &mut [T] {
        &mut self.0
    }
}

/// The bristle family with hooks.
#[derive(Clone, Copy, Debug)]
pub struct ModifiedLaw<T> {
    values: [T; HOOKS],
    active: [bool; HOOKS],
}

/// One end of a stretch.
#[derive(Clone, Copy)]
pub(super) struct End<T> {
    pub(super) slip: T,
    pub(super) speed: T,
    pub(super) normal: T,
    pub(super) memory: T,
}

impl<T: Scalar> ModifiedLaw<T> {
    /// Dahl's law with exponent 1.
    #[must_use]
    pub fn dahl(sigma0: T, mu_kinetic: T) -> Self {
        let mut law = Self { values: [T::from(0.0); HOOKS], active: [false; HOOKS] };
        law.set(Hook::Sigma0, sigma0);
        law.set(Hook::MuKinetic, mu_kinetic);
        law
    }

    /// Switches a hook on at a value.
    pub fn set(&mut self, hook: Hook, value: T) {
        self.values[hook as usize] = value;
        self.active[hook as usize] = true;
    }

    /// Switches a hook off.
    pub fn clear(&mut self, hook: Hook) {
        self.values[hook as usize] = T::from(0.0);
        self.active[hook as usize] = false;
    }

    /// The value of a hook where it is active.
    #[must_use]
    pub fn get(&self, hook: Hook) -> Option<T> {
        self.active[hook as usize].then(|| self.values[hook as usize])
    }

    /// The same law over another scalar.
    #[must_use]
    pub fn lift<U: Scalar>(&self, map: impl Fn(Hook, f64) -> U) -> ModifiedLaw<U> {
        let values = std::array::from_fn(|k| map(Hook::ALL[k], self.values[k].re()));
        ModifiedLaw { values, active: self.active }
    }

    pub(super) fn on(&self, hook: Hook) -> bool {
        self.active[hook as usize]
    }

    pub(super) fn at(&self, hook: Hook) -> T {
        self.values[hook as usize]
    }

    /// One part of a monotone stretch over which the friction coefficient is taken as linear.
    fn flow(&self, b: T, mu: [T; 2], slip: T, normal: T) -> T {
        let sign = if slip.re() < 0.0 { -1.0 } else { 1.0 };
        let mean = (mu[0] + mu[1]) * 0.5;
        let xi = self.at(Hook::Sigma0) * slip.abs() / mean;
        if !self.on(Hook::SeriesCompliance) {
            return self.flow_by(b, mu, sign, xi);
        }
        // dz = φ·du/(1 + σ0·φ·N·c): the rate at mid-stretch, predicted by half a stretch.
        let stiffness = self.at(Hook::Sigma0) * normal * self.at(Hook::SeriesCompliance);
        let softened = |b: T| {
            let left = -(b * sign / mean) + 1.0;
            let left = if left.re() > 0.0 { left } else { T::from(0.0) };
            xi / (stiffness * left + 1.0)
        };
        let middle = self.flow_by(b, mu, sign, softened(b) * 0.5);
        self.flow_by(b, mu, sign, softened(middle))
    }

    fn flow_by(&self, b: T, mu: [T; 2], sign: f64, xi: T) -> T {
        let mean = (mu[0] + mu[1]) * 0.5;
        if self.on(Hook::Breakaway) {
            let rise = (self.at(Hook::Breakaway), self.at(Hook::BreakawayShape));
            elasto_plastic(b * sign / mean, rise, xi) * mean * sign
        } else if self.on(Hook::FlowPower) {
            powered(b * sign / mean, self.at(Hook::FlowPower), xi) * mean * sign
        } else if self.on(Hook::Exponent) {
            power(b * sign / mean, self.at(Hook::Exponent), xi) * mean * sign
        } else {
            relax(b, sign, mu, xi)
        }
    }

    /// One monotone stretch: the new deflection and memory.
    fn stretch(&self, (b, memory): (T, T), motion: &Stretch<T>, circumstance: &Circumstance) -> (T, T) {
        let slip = motion.slip[1] - motion.slip[0];
        let sign = if slip.re() < 0.0 { -1.0 } else { 1.0 };
        let end = |k: usize, memory: T| End {
            slip: motion.slip[k],
            speed: motion.velocity[k].abs(),
            normal: motion.normal[k],
            memory,
        };
        let (from, mut to) = (end(0, memory), end(1, memory));
        if !self.varies() {
            let mu = self.friction(&from, sign, circumstance);
            return (self.flow(b, [mu, mu], slip, from.normal), memory);
        }
        // Hermite interpolant at mid-time: u = ū + (v₀ − v₁)dt/8, v = 3Δu/(2dt) − (v₀ + v₁)/4.
        let half = motion.dt * 0.5;
        let bend = (motion.velocity[0] - motion.velocity[1]) * motion.dt * 0.125;
        let speed = slip / motion.dt * 1.5 - (motion.velocity[0] + motion.velocity[1]) * 0.25;
        let mut middle = End {
            slip: (motion.slip[0] + motion.slip[1]) * 0.5 + bend,
            speed: speed.abs(),
            normal: (motion.normal[0] + motion.normal[1]) * 0.5,
            memory,
        };
        middle.memory = self.remember(memory, &from, &middle, half);
        to.memory = self.remember(middle.memory, &middle, &to, half);
        let [start, mid, stop] = [&from, &middle, &to].map(|end| self.friction(end, sign, circumstance));
        let stepwise = [Hook::SeriesCompliance, Hook::BreakawayShape, Hook::FlowPower];
        if stepwise.into_iter().any(|hook| self.on(hook)) {
            let b = self.flow(b, [start, mid], middle.slip - from.slip, from.normal);
            return (self.flow(b, [mid, stop], to.slip - middle.slip, middle.normal), to.memory);
        }
        let stroke = Stroke {
            travel: slip,
            direction: sign,
            velocity: [motion.velocity[0], speed, motion.velocity[1]],
            fraction: [T::from(0.0), T::from(0.5), T::from(1.0)],
            duration: motion.dt,
        };
        let friction = Friction::new(self.at(Hook::Sigma0), &stroke, [start, mid, stop]);
        let after = if self.on(Hook::Breakaway) {
            friction.breakaway(b * sign, self.at(Hook::Breakaway))
        } else if self.on(Hook::Exponent) {
            friction.power(b * sign, self.at(Hook::Exponent))
        } else {
            friction.linear(b * sign)
        };
        (after * sign, to.memory)
    }

    /// Force at one end without the force lag.
    pub(super) fn force(&self, b: T, end: &End<T>, velocity: T, circumstance: &Circumstance) -> T {
        let pressed = if end.normal.re() > 0.0 { end.normal } else { T::from(0.0) };
        let mut ratio = b;
        if self.on(Hook::Sigma1) {
            ratio += self.damping(b, end, velocity, circumstance);
        }
        let mut force = pressed * ratio;
        if self.on(Hook::Viscous) {
            force += self.at(Hook::Viscous) * velocity * self.thickening(velocity);
        }
        if self.on(Hook::ViscousSquare) {
            force += self.at(Hook::ViscousSquare) * velocity * velocity.abs();
        }
        if self.on(Hook::ParallelStiffness) {
            force += self.at(Hook::ParallelStiffness) * end.slip;
        }
        if self.on(Hook::ParallelCubic) {
            force += self.at(Hook::ParallelCubic) * end.slip * end.slip * end.slip;
        }
        force
    }

    /// `|v/v₀|^{p−1}` of the viscous force, one where no power is stated; the corner at rest of a power below one is rounded
    /// over `v₀/1000`.
    fn thickening(&self, velocity: T) -> T {
        if !self.on(Hook::ViscousPower) {
            return T::from(1.0);
        }
        let x = velocity / self.at(Hook::ViscousReference);
        ((self.at(Hook::ViscousPower) - 1.0) * 0.5 * (x * x + 1e-6).ln()).exp()
    }

    /// `σ1(v)·ż` with `ż = v·φ(r)`.
    fn damping(&self, b: T, end: &End<T>, velocity: T, circumstance: &Circumstance) -> T {
        let sign = if velocity.re() < 0.0 { -1.0 } else { 1.0 };
        let ratio = b * sign / self.friction(end, sign, circumstance);
        let rate = if self.on(Hook::Breakaway) {
            let rise = super::kernel::rise(ratio, self.at(Hook::Breakaway), self.at(Hook::BreakawayShape));
            -(rise * ratio) + 1.0
        } else {
            -ratio + 1.0
        };
        let mut sigma1 = self.at(Hook::Sigma1);
        if self.on(Hook::DampingVelocity) {
            let x = velocity / self.at(Hook::DampingVelocity);
            let fading = (-(x * x)).exp();
            let rational = (x * x + 1.0).recip();
            sigma1 *= fading + (rational - fading) * self.at(Hook::DampingRational);
        }
        sigma1 * velocity * rate
    }

    /// The engaged slip after play, and whether the contact is dragged along.
    fn engage(&self, engaged: T, slip: T) -> (T, bool) {
        let play = self.at(Hook::Backlash);
        if engaged.re() < (slip - play).re() {
            (slip - play, true)
        } else if engaged.re() > (slip + play).re() {
            (slip + play, true)
        } else {
            (engaged, false)
        }
    }

    pub(super) fn modulated(&self, normal: [T; 2], circumstance: &Circumstance) -> [T; 2] {
        if !self.on(Hook::ModulationCosine) {
            return normal;
        }
        let [cosine, sine] = [Hook::ModulationCosine, Hook::ModulationSine].map(|hook| self.at(hook));
        let steepness = self.at(Hook::ModulationSteepness);
        let shaped = self.on(Hook::ModulationSteepness) && steepness.re() > 0.0;
        std::array::from_fn(|k| {
            let [c, s] = circumstance.phase[k];
            let mut share = cosine * c + sine * s;
            if shaped {
                let size = (cosine * cosine + sine * sine).sqrt();
                share = size * (steepness * share / size).tanh() / steepness.tanh();
            }
            normal[k] + share * circumstance.preload
        })
    }

    /// From the old sample to the new one under the given circumstance.
    pub fn advance(
        &self,
        state: ModifiedState<T>,
        step: &Step<T>,
        circumstance: &Circumstance,
    ) -> (ModifiedState<T>, T) {
        let normal = self.modulated(step.normal, circumstance);
        let [b, memory, engaged, lagged] = state.0;
        let mut motion = Stretch { slip: step.slip, velocity: step.velocity, normal, dt: T::from(step.dt) };
        let mut caught = step.slip[1];
        if self.on(Hook::Backlash) {
            let (to, dragged) = self.engage(engaged, step.slip[1]);
            let speed = if dragged { step.velocity[1] } else { T::from(0.0) };
            motion.slip = [engaged, to];
            // Held by the play: a chord without reversal.
            motion.velocity = [if dragged { step.velocity[0] } else { T::from(0.0) }, speed];
            caught = to;
        }
        let (new_b, new_memory) = self.cut_at_reversal((b, memory), &motion, circumstance);
        let end = |k: usize, memory: T| End {
            slip: step.slip[k],
            speed: step.velocity[k].abs(),
            normal: normal[k],
            memory,
        };
        let mut force = self.force(new_b, &end(1, new_memory), step.velocity[1], circumstance);
        let mut new_lagged = lagged;
        if self.on(Hook::ForceLag) {
            let old = self.force(b, &end(0, memory), step.velocity[0], circumstance);
            new_lagged = relax(lagged, 1.0, [old, force], self.at(Hook::ForceLag).recip() * step.dt);
            force = new_lagged;
        }
        (ModifiedState([new_b, new_memory, caught, new_lagged]), force)
    }

    /// Cuts a step at the zero of the velocity and advances both parts.
    fn cut_at_reversal(&self, state: (T, T), motion: &Stretch<T>, circumstance: &Circumstance) -> (T, T) {
        let [v0, v1] = motion.velocity;
        if v0.re() * v1.re() >= 0.0 || motion.dt.re() <= 0.0 {
            return self.stretch(state, motion, circumstance);
        }
        let (share, slip) = reversal(motion);
        let rest = T::from(0.0);
        let normal = motion.normal[0] + (motion.normal[1] - motion.normal[0]) * share;
        let first = Stretch {
            slip: [motion.slip[0], slip],
            velocity: [v0, rest],
            normal: [motion.normal[0], normal],
            dt: motion.dt * share,
        };
        let second = Stretch {
            slip: [slip, motion.slip[1]],
            velocity: [rest, v1],
            normal: [normal, motion.normal[1]],
            dt: motion.dt * (-share + 1.0),
        };
        let state = self.stretch(state, &first, circumstance);
        self.stretch(state, &second, circumstance)
    }
}

/// A stretch whose duration is a scalar of the law (the time of a reversal depends on the motion).
struct Stretch<T> {
    slip: [T; 2],
    velocity: [T; 2],
    normal: [T; 2],
    dt: T,
}

/// Share of the step up to the reversal, and the slip there, on the cubic Hermite interpolant.
///
/// `v(s)` of the interpolant is a parabola in `s`; one Newton step from the chord's zero is enough, since an error
/// of the time enters the slip squared.
fn reversal<T: Scalar>(motion: &Stretch<T>) -> (T, T) {
    let [a, b] = [motion.velocity[0] * motion.dt, motion.velocity[1] * motion.dt];
    let d = motion.slip[1] - motion.slip[0];
    // u(s) − u₀ = a s + (3d − 2a − b) s² + (a + b − 2d) s³
    let (c2, c3) = (d * 3.0 - a * 2.0 - b, a + b - d * 2.0);
    let mut share = a / (a - b);
    for _ in 0..2 {
        let slope = c2 * 2.0 + c3 * share * 6.0;
        let moved = share - (a + share * (c2 * 2.0 + c3 * share * 3.0)) / slope;
        if moved.re() > 0.0 && moved.re() < 1.0 {
            share = moved;
        }
    }
    (share, motion.slip[0] + share * (a + share * (c2 + c3 * share)))
}

impl<T: Scalar> FrictionLaw<T> for ModifiedLaw<T> {
    type State = ModifiedState<T>;

    fn rest(&self) -> Self::State {
        self.rest_at(T::from(0.0))
    }

    fn step(&self, state: Self::State, step: &Step<T>) -> (Self::State, T) {
        self.advance(state, step, &Circumstance::default())
    }
}
