//! What the contact remembers beside its deflection: the lagging curve or velocity, the film, the age.

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

    /// The memory after a stretch.
    pub(super) fn remember(&self, memory: T, from: &End<T>, to: &End<T>, dt: T) -> T {
        if self.on(Hook::LagTime) {
            let (old, new) = (self.weight(from.speed), self.weight(to.speed));
            self.follow(memory, [old, new], dt / self.at(Hook::LagTime), T::from(1.0))
        } else if self.on(Hook::SpeedLag) {
            self.follow(
                memory,
                [from.speed, to.speed],
                dt / self.at(Hook::SpeedLag),
                self.at(Hook::StribeckVelocity),
            )
        } else if self.on(Hook::VelocityLag) {
            let sign = if (to.slip - from.slip).re() < 0.0 { -1.0 } else { 1.0 };
            let ends = [from.speed * sign, to.speed * sign];
            self.follow(memory, ends, dt / self.at(Hook::VelocityLag), self.at(Hook::StribeckVelocity))
        } else if self.on(Hook::FilmLoss) {
            let (old, new) = (self.steady_film(from.speed), self.steady_film(to.speed));
            let builds = (old + new).re() * 0.5 > memory.re();
            let falls = self.on(Hook::FilmFall) && !builds;
            let time = self.at(if falls { Hook::FilmFall } else { Hook::FilmRise });
            relax(memory, 1.0, [old, new], dt / time)
        } else if self.on(Hook::AgeingGain) {
            let e = (to.slip - from.slip).abs() / self.at(Hook::AgeingDistance);
            memory * (-e).exp() + dt * decay_mean(e)
        } else {
            memory
        }
    }

    /// A lag behind `target` over `e` of its times: `dm/dt = (s − m)/(τ (1 + κ|s − m|/scale))`, linear where `κ = 0`, of bounded
    /// rate `scale/(κτ)` where the two are far apart. The slowing is the mean of its values at both ends (order two).
    fn follow(&self, memory: T, target: [T; 2], e: T, scale: T) -> T {
        if !self.on(Hook::LagSaturation) {
            return relax(memory, 1.0, target, e);
        }
        let slowing = |distance: T| self.at(Hook::LagSaturation) * distance.abs() / scale + 1.0;
        let begin = slowing(target[0] - memory);
        let end = slowing(target[1] - relax(memory, 1.0, target, e / begin));
        relax(memory, 1.0, target, e / ((begin + end) * 0.5))
    }
}
