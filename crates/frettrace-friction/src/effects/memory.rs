//! What the contact remembers beside its deflection: the lagging curve or velocity, the film, the age.

use super::coefficient::ended;
use super::hooks::Hook;
use super::kernel::{decay_mean, relax};
use super::modified::{End, ModifiedLaw, ModifiedState};
use crate::Scalar;

impl<T: Scalar> ModifiedLaw<T> {
    /// Whether the law has a memory beside the deflection (lag, film or ageing).
    #[must_use]
    pub fn remembers(&self) -> bool {
        [Hook::LagTime, Hook::SpeedLag, Hook::VelocityLag, Hook::FilmLoss, Hook::AgeingGain]
            .into_iter()
            .any(|hook| self.on(hook))
    }

    /// The state of a contact that has been at rest at the given slip.
    #[must_use]
    pub fn rest_at(&self, slip: T) -> ModifiedState<T> {
        let memory = if self.on(Hook::LagTime) { T::from(1.0) } else { T::from(0.0) };
        ModifiedState([T::from(0.0), memory, slip, T::from(0.0)])
    }

    /// What the memory follows at a speed in the given sense; 0 where it follows none.
    pub(super) fn target(&self, speed: T, sign: f64) -> T {
        if self.on(Hook::LagTime) {
            self.weight(speed)
        } else if self.on(Hook::SpeedLag) {
            speed
        } else if self.on(Hook::VelocityLag) {
            speed * sign
        } else if self.on(Hook::FilmLoss) {
            self.steady_film(speed)
        } else {
            T::from(0.0)
        }
    }

    /// The memory after a stretch.
    pub(super) fn remember(&self, memory: T, from: &End<T>, to: &End<T>, dt: T) -> T {
        let targets = [from.target, to.target];
        let velocity = || self.at(Hook::StribeckVelocity);
        if self.on(Hook::LagTime) {
            self.follow(memory, targets, dt / self.at(Hook::LagTime), T::from(1.0))
        } else if self.on(Hook::SpeedLag) {
            self.follow(memory, targets, dt / self.at(Hook::SpeedLag), velocity())
        } else if self.on(Hook::VelocityLag) {
            self.follow(memory, targets, dt / self.at(Hook::VelocityLag), velocity())
        } else if self.on(Hook::FilmLoss) {
            let builds = (targets[0] + targets[1]).re() * 0.5 > memory.re();
            let falls = self.on(Hook::FilmFall) && !builds;
            let time = self.at(if falls { Hook::FilmFall } else { Hook::FilmRise });
            relax(memory, 1.0, targets, dt / time)
        } else if self.on(Hook::AgeingGain) {
            let e = (to.slip - from.slip).abs() / self.at(Hook::AgeingDistance);
            memory * (-e).exp() + dt * decay_mean(e)
        } else {
            memory
        }
    }

    /// A lag behind `target` over `e` of its times: `dm/dt = (s − m)/(τ (1 + x^p)^{1/p})`, `x = κ|s − m|/scale`, linear where `κ = 0`,
    /// of bounded rate `scale/(κτ)` where the two are far apart; a plain `p` is 1. The slowing is the mean of its values at both
    /// ends (order two).
    fn follow(&self, memory: T, target: [T; 2], e: T, scale: T) -> T {
        if !self.on(Hook::LagSaturation) {
            return relax(memory, 1.0, target, e);
        }
        let slowing = |distance: T| {
            let x = self.at(Hook::LagSaturation) * distance.abs() / scale;
            if !self.on(Hook::LagPower) {
                return x + 1.0;
            }
            T::from(1.0) / ended(T::from(1.0), x, self.at(Hook::LagPower))
        };
        let begin = slowing(target[0] - memory);
        let end = slowing(target[1] - relax(memory, 1.0, target, e / begin));
        relax(memory, 1.0, target, e / ((begin + end) * 0.5))
    }
}
