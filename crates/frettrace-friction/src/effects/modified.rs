//! The modified law: the bristle family, one step at a time, with its hooks.
//!
//! ```text
//! F_t = N⁺(b + σ1(v)ż) + σ2 v + …,   db/dt = σ0 v φ(r),   r = b·sgn(v)/μ(v, u, N, …)
//! ```
//! A step is cut where the velocity changes sign (cubic Hermite interpolant of the slip), so that each stretch is
//! monotone and rate-independent laws depend on slip alone.

use super::hooks::{HOOKS, Hook};
use super::kernel::{closing, relax, taken};
use super::leg::Leg;
use crate::law::{FrictionLaw, Scalar, Step};
use crate::lift::positive_part;

/// What a step needs to know beside the motion of the contact.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Circumstance {
    /// Preload `N₀` \[N\].
    pub preload: f64,
    /// Place of the run between the first (0) and the last (1).
    pub progress: f64,
    /// The same in the work that friction had done when it began and when it ended.
    pub worked: [f64; 2],
    /// Cosine and sine of the modulation's phase at the old and the new sample.
    pub phase: [[f64; 2]; 2],
}

impl Default for Circumstance {
    fn default() -> Self {
        Self { preload: 0.0, progress: 0.0, worked: [0.0; 2], phase: [[1.0, 0.0]; 2] }
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
#[derive(Clone, Copy, Debug, PartialEq)]
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
    /// What the memory follows there.
    pub(super) target: T,
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

    /// Force at one end, of which `friction` gives the friction coefficient, without the force lag.
    pub(super) fn force(&self, b: T, end: &End<T>, velocity: T, friction: impl FnOnce() -> T) -> T {
        let pressed = positive_part(end.normal);
        let mut ratio = b;
        if self.on(Hook::BristleAsymmetry) {
            let side = b / (self.at(Hook::BristleTurn) * self.at(Hook::MuKinetic));
            ratio *= self.at(Hook::BristleAsymmetry) * self.turned(side) + 1.0;
        }
        if self.on(Hook::Sigma1) {
            ratio += self.damping(b, (velocity, pressed), friction());
        }
        if self.on(Hook::LatticeCosine) {
            let (sine, cosine) = (self.at(Hook::PeriodicNumber) * end.slip).sin_cos();
            ratio += self.at(Hook::LatticeCosine) * cosine + self.at(Hook::LatticeSine) * sine;
        }
        if self.on(Hook::ViscousNormal) {
            ratio += self.at(Hook::ViscousNormal) * velocity;
        }
        if self.on(Hook::NormalWhole) {
            ratio *= self.normal_factor(end.normal, 0.0);
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
        if self.on(Hook::ShoulderStiffness) {
            let (side, gap) = (sense(end.slip), self.at(Hook::ShoulderGap));
            let pushed = end.slip - gap * side;
            force += if pushed.re() * side > 0.0 {
                self.at(Hook::ShoulderStiffness) * pushed
            } else {
                T::from(0.0)
            };
        }
        if self.on(Hook::ParallelCubic) {
            force += self.at(Hook::ParallelCubic) * end.slip * end.slip * end.slip;
        }
        force
    }

    /// `|v/v₀|^{p−1}` of the viscous force, one where no power is stated; the corner at rest of a power below one is rounded
    /// over `v₀/1000`, or `(y^q + c^q)^{(p−1)/q}`, `y = |v|/v₀`: from a straight line near rest to a power at speed, which a force that thins with
    /// the rate of shear has (Eyring's arsinh within 2e-3, hyperbolic and rational saturation).
    fn thickening(&self, velocity: T) -> T {
        if !self.on(Hook::ViscousPower) {
            return T::from(1.0);
        }
        let x = velocity / self.at(Hook::ViscousReference);
        let bend = self.at(Hook::ViscousPower) - 1.0;
        if !self.on(Hook::ViscousCore) {
            return (bend * 0.5 * (x * x + 1e-6).ln()).exp();
        }
        let turn = if self.on(Hook::ViscousTurn) { self.at(Hook::ViscousTurn) } else { T::from(2.0) };
        let speed = (x * x + 1e-6).sqrt();
        let power = |of: T| (turn * of.ln()).exp();
        (bend * (power(speed) + power(self.at(Hook::ViscousCore))).ln() / turn).exp()
    }

    /// `σ1(v)·ż` with `ż = v·φ(r)`, of which a spring in series takes a part.
    fn damping(&self, b: T, (velocity, normal): (T, T), friction: T) -> T {
        let ratio = b * sense(velocity) / friction;
        let mut rate = self.yielding(ratio);
        if self.on(Hook::DampingStuck) {
            let stuck = positive_part(-ratio.abs() + 1.0);
            rate += (stuck - rate) * self.at(Hook::DampingStuck);
        }
        let given = self.at(Hook::Sigma0) * normal * self.at(Hook::SeriesCompliance);
        let rate = if self.on(Hook::SeriesCompliance) { rate / (given * rate + 1.0) } else { rate };
        let mut sigma1 = self.at(Hook::Sigma1);
        if self.on(Hook::DampingVelocity) {
            let x = velocity / self.at(Hook::DampingVelocity);
            let mut grown = x * x;
            if self.on(Hook::DampingPower) {
                grown = (self.at(Hook::DampingPower) * 0.5 * (grown + 1e-9).ln()).exp();
            }
            let fading = (-grown).exp();
            let rational = (grown + 1.0).recip();
            sigma1 *= fading + (rational - fading) * self.at(Hook::DampingRational);
        }
        sigma1 * velocity * rate
    }

    /// The engaged slip after play, and whether the contact is dragged along.
    pub(super) fn engage(&self, engaged: T, slip: T) -> (T, bool) {
        let play = self.at(Hook::Backlash);
        if engaged.re() < (slip - play).re() {
            (slip - play, true)
        } else if engaged.re() > (slip + play).re() {
            (slip + play, true)
        } else {
            (engaged, false)
        }
    }

    /// Normal force with the modulation of the preload at the given cosine and sine of its phase.
    pub(super) fn modulated(&self, normal: T, [c, s]: [f64; 2], preload: f64) -> T {
        if !self.on(Hook::ModulationCosine) {
            return normal;
        }
        let [cosine, sine] = [Hook::ModulationCosine, Hook::ModulationSine].map(|hook| self.at(hook));
        let steepness = self.at(Hook::ModulationSteepness);
        let mut share = cosine * c + sine * s;
        if self.on(Hook::ModulationSteepness) && steepness.re() > 0.0 {
            let size = (cosine * cosine + sine * sine).sqrt();
            share = size * (steepness * share / size).tanh() / steepness.tanh();
        }
        if self.on(Hook::ModulationCosine2) {
            let [c2, s2] = [c * c - s * s, 2.0 * s * c];
            let [c3, s3] = [c2 * c - s2 * s, s2 * c + c2 * s];
            let [c4, s4] = [c2 * c2 - s2 * s2, 2.0 * s2 * c2];
            share += self.at(Hook::ModulationCosine2) * c2 + self.at(Hook::ModulationSine2) * s2;
            share += self.at(Hook::ModulationCosine3) * c3 + self.at(Hook::ModulationSine3) * s3;
            share += self.at(Hook::ModulationCosine4) * c4 + self.at(Hook::ModulationSine4) * s4;
        }
        normal + share * preload
    }

    /// The same at both ends of a step.
    pub(super) fn pressing(&self, step: &Step<T>, circumstance: &Circumstance) -> [T; 2] {
        let Circumstance { phase, preload, .. } = circumstance;
        [0, 1].map(|k| self.modulated(step.normal[k], phase[k], *preload))
    }

    /// The motion of the bristle over a step, and the engaged slip after it.
    pub(super) fn motion(&self, engaged: T, step: &Step<T>, normal: [T; 2]) -> (Stretch<T>, T) {
        let dt = T::from(step.dt);
        if !self.on(Hook::Backlash) {
            return (Stretch { slip: step.slip, velocity: step.velocity, normal, dt }, step.slip[1]);
        }
        let (caught, velocity) = self.catch(engaged, step);
        (Stretch { slip: [engaged, caught], velocity, normal, dt }, caught)
    }

    /// The engaged slip after a step, and its velocity at both ends.
    pub(super) fn catch(&self, engaged: T, step: &Step<T>) -> (T, [T; 2]) {
        let play = self.at(Hook::Backlash);
        if !self.on(Hook::BacklashPower) || play.re() <= 0.0 {
            let (caught, dragged) = self.engage(engaged, step.slip[1]);
            // Held by the play: a chord without reversal.
            return (caught, if dragged { step.velocity } else { [T::from(0.0); 2] });
        }
        let power = self.at(Hook::BacklashPower);
        let handed = |place: T, v: T| v * taken(place * sense(v), power);
        let begun = (step.slip[0] - engaged) / play;
        let whole = Stretch {
            slip: step.slip,
            velocity: step.velocity,
            normal: [T::from(0.0); 2],
            dt: T::from(step.dt),
        };
        let (first, second) = whole.cut();
        let closed = std::iter::once(first).chain(second).fold(begun, |place, part| {
            let sign = part.sign();
            let travel = (part.slip[1] - part.slip[0]) * sign / play;
            closing(place * sign, power, travel) * sign
        });
        let velocity = [handed(begun, step.velocity[0]), handed(closed, step.velocity[1])];
        (step.slip[1] - play * closed, velocity)
    }

    /// From the old sample to the new one under the given circumstance.
    pub fn advance(
        &self,
        state: ModifiedState<T>,
        step: &Step<T>,
        circumstance: &Circumstance,
    ) -> (ModifiedState<T>, T) {
        self.advance_on(state, step, (circumstance, &mut Reached::default()))
    }

    /// As [`Self::advance`], step by step along one motion: what the end of the last step and the start of this one have in common
    /// is computed once. `reached` begins empty and belongs to this motion, its derivatives included.
    pub fn advance_on(
        &self,
        state: ModifiedState<T>,
        step: &Step<T>,
        (circumstance, reached): (&Circumstance, &mut Reached<T>),
    ) -> (ModifiedState<T>, T) {
        let normal = self.pressing(step, circumstance);
        let [b, memory, engaged, lagged] = state.0;
        let (motion, caught) = self.motion(engaged, step, normal);
        if !self.joins() {
            *reached = Reached::default();
        }
        let (first, second) = motion.cut();
        let mut rubbed = self.stretch((b, memory), first, (circumstance, &mut *reached));
        if let Some(second) = second {
            rubbed = self.stretch(rubbed, second, (circumstance, &mut *reached));
        }
        let force = |k: usize, (b, memory): (T, T), known: Option<T>| {
            let velocity = step.velocity[k];
            let end = End { memory, ..self.place(step.slip[k], (velocity, normal[k])) };
            let friction = || known.unwrap_or_else(|| self.friction(&end, sense(velocity), circumstance));
            self.force(b, &end, velocity, friction)
        };
        let known = reached.towards(sense(step.velocity[1])).filter(|_| self.joins());
        let mut answer = force(1, rubbed, known.map(|(_, friction)| friction));
        let mut new_lagged = lagged;
        if self.on(Hook::ForceLag) {
            new_lagged = self.lag(lagged, [force(0, (b, memory), None), answer], T::from(step.dt));
            answer = new_lagged;
        }
        (ModifiedState([rubbed.0, rubbed.1, caught, new_lagged]), answer)
    }

    /// The lagged force after `dt` in which the force went from one value to the other.
    pub(super) fn lag(&self, lagged: T, force: [T; 2], dt: T) -> T {
        relax(lagged, 1.0, force, self.at(Hook::ForceLag).recip() * dt)
    }

    /// One monotone stretch: the new deflection and memory.
    fn stretch(
        &self,
        (b, memory): (T, T),
        motion: Stretch<T>,
        (circumstance, reached): (&Circumstance, &mut Reached<T>),
    ) -> (T, T) {
        let known = reached.towards(motion.sign());
        let mut leg = Leg::new(self, motion, known.map(|(end, _)| end));
        let memory = leg.recall(self, memory);
        let friction = leg.friction(self, circumstance, known.map(|(_, friction)| friction));
        reached.0 = Some((leg.sign, leg.ends[2], friction[2]));
        (leg.flow(self, friction).over(self, b), memory)
    }
}

/// Where a motion has come to: its sense, its place, and the friction coefficient there.
#[derive(Clone, Copy)]
pub struct Reached<T>(Option<(f64, End<T>, T)>);

impl<T: Copy> Reached<T> {
    /// The place and the friction coefficient there, for a motion that goes on in the same sense.
    fn towards(&self, sign: f64) -> Option<(End<T>, T)> {
        self.0.filter(|(sense, ..)| *sense == sign).map(|(_, end, friction)| (end, friction))
    }
}

impl<T> Default for Reached<T> {
    fn default() -> Self {
        Self(None)
    }
}

/// Sense of a velocity, forwards at rest.
pub(super) fn sense<T: Scalar>(velocity: T) -> f64 {
    if velocity.re() < 0.0 { -1.0 } else { 1.0 }
}

/// A stretch whose duration is a scalar of the law (the time of a reversal depends on the motion).
pub(super) struct Stretch<T> {
    pub(super) slip: [T; 2],
    pub(super) velocity: [T; 2],
    pub(super) normal: [T; 2],
    pub(super) dt: T,
}

impl<T: Scalar> Stretch<T> {
    /// Sense of the motion.
    pub(super) fn sign(&self) -> f64 {
        sense(self.slip[1] - self.slip[0])
    }

    /// Cuts the motion at the zero of the velocity: one monotone part, or two.
    pub(super) fn cut(self) -> (Self, Option<Self>) {
        let [v0, v1] = self.velocity;
        if v0.re() * v1.re() >= 0.0 || self.dt.re() <= 0.0 {
            return (self, None);
        }
        let (share, slip) = reversal(&self);
        let rest = T::from(0.0);
        let normal = self.normal[0] + (self.normal[1] - self.normal[0]) * share;
        let first = Self {
            slip: [self.slip[0], slip],
            velocity: [v0, rest],
            normal: [self.normal[0], normal],
            dt: self.dt * share,
        };
        let second = Self {
            slip: [slip, self.slip[1]],
            velocity: [rest, v1],
            normal: [normal, self.normal[1]],
            dt: self.dt * (-share + 1.0),
        };
        (first, Some(second))
    }
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
