//! One monotone stretch of a step, in the order in which things depend on each other: the motion, the memory, the friction
//! coefficient, the deflection. Only the last of these depends on the deflection itself.

use super::hooks::Hook;
use super::kernel::{bent, elasto_plastic, power, relax, rise};
use super::modified::{Circumstance, End, ModifiedLaw, Stretch, sense};
use crate::bristle::Friction;
use crate::law::{Scalar, Stroke};
use crate::lift::positive_part;

/// A monotone stretch: its start, the place at half its time, its end.
pub(super) struct Leg<T> {
    motion: Stretch<T>,
    /// Whether the friction coefficient changes along it.
    varies: bool,
    pub(super) sign: f64,
    /// Velocity at half time.
    middle: T,
    pub(super) ends: [End<T>; 3],
}

impl<T: Scalar> Leg<T> {
    /// As far as the motion alone decides it; `start` is what is known of its start from the stretch before, in the same sense.
    pub(super) fn new(law: &ModifiedLaw<T>, motion: Stretch<T>, start: Option<End<T>>) -> Self {
        let [u0, u1] = motion.slip;
        let [v0, v1] = motion.velocity;
        let [n0, n1] = motion.normal;
        let sign = motion.sign();
        let end = |slip, velocity, normal| law.followed(law.place(slip, (velocity, normal)), sign);
        let varies = law.varies();
        if !varies {
            let [start, stop] = [(u0, v0, n0), (u1, v1, n1)].map(|(u, v, n)| law.place(u, (v, n)));
            return Self { motion, varies, sign, middle: v0, ends: [start, start, stop] };
        }
        // Hermite interpolant at mid-time: u = ū + (v₀ − v₁)dt/8, v = 3Δu/(2dt) − (v₀ + v₁)/4.
        let bend = (v0 - v1) * motion.dt * 0.125;
        let middle = (u1 - u0) / motion.dt * 1.5 - (v0 + v1) * 0.25;
        let half = end((u0 + u1) * 0.5 + bend, middle, (n0 + n1) * 0.5);
        let ends = [start.unwrap_or_else(|| end(u0, v0, n0)), half, end(u1, v1, n1)];
        Self { motion, varies, sign, middle, ends }
    }

    /// Leads the memory through the stretch; the memory after it.
    pub(super) fn recall(&mut self, law: &ModifiedLaw<T>, memory: T) -> T {
        let half = self.motion.dt * 0.5;
        let [start, middle, stop] = &mut self.ends;
        start.memory = memory;
        if self.varies {
            middle.memory = law.remember(memory, start, middle, half);
            stop.memory = law.remember(middle.memory, middle, stop, half);
        } else {
            (middle.memory, stop.memory) = (memory, memory);
        }
        stop.memory
    }

    /// The friction coefficient at start, half time and end; that of the start may be known from the stretch before.
    pub(super) fn friction(
        &self,
        law: &ModifiedLaw<T>,
        circumstance: &Circumstance,
        start: Option<T>,
    ) -> [T; 3] {
        let at = |end: &End<T>| law.friction(end, self.sign, circumstance);
        let first = start.unwrap_or_else(|| at(&self.ends[0]));
        if self.varies { [first, at(&self.ends[1]), at(&self.ends[2])] } else { [first; 3] }
    }

    /// How the deflection moves under the given friction coefficients.
    pub(super) fn flow(&self, law: &ModifiedLaw<T>, friction: [T; 3]) -> Flow<T> {
        let [start, middle, stop] = &self.ends;
        let part = |mu, slip, normal: [&End<T>; 2]| Part { mu, slip, normal: normal.map(|end| end.normal) };
        let travel = self.motion.slip[1] - self.motion.slip[0];
        if !self.varies {
            return Flow::Whole(part([friction[0]; 2], travel, [start, stop]));
        }
        let stepwise = [Hook::SeriesCompliance, Hook::BreakawayShape, Hook::FlowPower];
        let rounded = law.on(Hook::Breakaway) && law.on(Hook::Exponent);
        if rounded || stepwise.into_iter().any(|hook| law.on(hook)) {
            let [first, mid, last] = friction;
            return Flow::Halves([
                part([first, mid], middle.slip - start.slip, [start, middle]),
                part([mid, last], stop.slip - middle.slip, [middle, stop]),
            ]);
        }
        let [v0, v1] = self.motion.velocity;
        let stroke = Stroke {
            travel,
            direction: self.sign,
            velocity: [v0, self.middle, v1],
            fraction: [T::from(0.0), T::from(0.5), T::from(1.0)],
            duration: self.motion.dt,
        };
        Flow::Stroke(Friction::new(law.at(Hook::Sigma0), &stroke, friction), self.sign)
    }
}

/// Part of a monotone stretch over which the friction coefficient is taken as linear.
#[derive(Clone, Copy)]
pub(super) struct Part<T> {
    mu: [T; 2],
    slip: T,
    /// Normal force at both ends.
    normal: [T; 2],
}

/// How the deflection moves over a stretch.
#[derive(Clone, Copy)]
pub(super) enum Flow<T> {
    Whole(Part<T>),
    Halves([Part<T>; 2]),
    Stroke(Friction<T>, f64),
}

impl<T: Scalar> Flow<T> {
    /// The deflection after it.
    pub(super) fn over(&self, law: &ModifiedLaw<T>, b: T) -> T {
        match self {
            Self::Whole(part) => part.over(law, b),
            Self::Halves([first, second]) => second.over(law, first.over(law, b)),
            Self::Stroke(friction, sign) => {
                let loading = b * *sign;
                let after = if law.on(Hook::Breakaway) {
                    friction.breakaway(loading, law.at(Hook::Breakaway))
                } else if law.on(Hook::Exponent) {
                    friction.power(loading, law.at(Hook::Exponent))
                } else {
                    friction.linear(loading)
                };
                after * *sign
            }
        }
    }
}

impl<T: Scalar> Part<T> {
    fn over(&self, law: &ModifiedLaw<T>, b: T) -> T {
        let mean = (self.mu[0] + self.mu[1]) * 0.5;
        let reach = law.at(Hook::Sigma0) / mean;
        if !law.on(Hook::SeriesCompliance) {
            return self.by(law, b, (sense(self.slip), reach * self.slip.abs()));
        }
        // The spring carries N·b and is c·N·b long: db = σ0 φ (du − c b dN)/(1 + σ0 φ N c), with the rate at mid-stretch, predicted by
        // half a stretch. An open contact carries nothing, and its spring is as long as unloaded.
        let compliance = law.at(Hook::SeriesCompliance);
        let [from, to] = self.normal.map(positive_part);
        let stiffness = law.at(Hook::Sigma0) * (from + to) * 0.5 * compliance;
        let pushed = |at: T, share: f64| {
            let driven = self.slip - compliance * at * (to - from);
            let sign = sense(driven);
            // A bristle that returns from beyond its limit does so by its own root, not by the spring.
            let rate = positive_part(law.yielding(at * sign / mean));
            let xi = reach * driven.abs() / (stiffness * rate + 1.0) * share;
            self.by(law, b, (sign, xi))
        };
        pushed(pushed(b, 0.5), 1.0)
    }

    fn by(&self, law: &ModifiedLaw<T>, b: T, (sign, xi): (f64, T)) -> T {
        let mean = (self.mu[0] + self.mu[1]) * 0.5;
        let flow = |ratio| law.yielding(ratio);
        if law.on(Hook::Breakaway) {
            elasto_plastic(b * sign / mean, (law.at(Hook::Breakaway), flow), xi) * mean * sign
        } else if law.on(Hook::FlowPower) {
            bent(b * sign / mean, (flow, 0.25), xi) * mean * sign
        } else if law.on(Hook::Exponent) {
            power(b * sign / mean, law.at(Hook::Exponent), xi) * mean * sign
        } else {
            relax(b, sign, self.mu, xi)
        }
    }
}

impl<T: Scalar> ModifiedLaw<T> {
    /// A place of a motion.
    pub(super) fn place(&self, slip: T, (velocity, normal): (T, T)) -> End<T> {
        let zero = T::from(0.0);
        End { slip, speed: velocity.abs(), normal, memory: zero, target: zero }
    }

    /// The same with what the memory follows there, where the motion has the given sense.
    pub(super) fn followed(&self, place: End<T>, sign: f64) -> End<T> {
        End { target: self.target(place.speed, sign), ..place }
    }

    /// Whether a stretch begins as the one before it ended; where play is caught the velocity of the bristle jumps.
    pub(super) fn joins(&self) -> bool {
        !self.on(Hook::Backlash)
    }

    /// Rate `φ(r)` of the deflection over that of the bristle's stuck root: `ż = v·φ(r)`, below nothing where it returns from `r > 1`.
    pub(super) fn yielding(&self, ratio: T) -> T {
        let mut held = ratio;
        if self.on(Hook::FlowPower) {
            held = ratio * ((ratio.abs() + 1e-12).ln() * (self.at(Hook::FlowPower) - 1.0)).exp();
        }
        if self.on(Hook::Breakaway) {
            held = rise(ratio, self.at(Hook::Breakaway), self.at(Hook::BreakawayShape)) * held;
        }
        let left = -held + 1.0;
        if !self.on(Hook::Exponent) {
            return left;
        }
        let rate = ((left.abs() + 1e-12).ln() * self.at(Hook::Exponent)).exp();
        if left.re() < 0.0 { -rate } else { rate }
    }

    /// Whether the deflection after a stretch is a linear function of that before it.
    pub(super) fn is_linear(&self) -> bool {
        let bent = [Hook::Breakaway, Hook::FlowPower, Hook::Exponent, Hook::SeriesCompliance];
        !bent.into_iter().any(|hook| self.on(hook))
    }
}
