//! The modified law with a rigid bristle: set-valued at rest.

use super::hooks::Hook;
use super::modified::{Circumstance, End, ModifiedLaw, ModifiedState, sense};
use crate::law::{Scalar, Step};
use crate::lift::positive_part;

impl<T: Scalar> ModifiedLaw<T> {
    /// Whether the law has a presliding range of its own: only without one can its bristle be taken as rigid.
    #[must_use]
    pub fn yields(&self) -> bool {
        let soft = [Hook::Sigma1, Hook::Breakaway, Hook::BreakawayShape, Hook::Exponent, Hook::FlowPower];
        let beside = [Hook::SeriesCompliance, Hook::Backlash, Hook::ForceLag];
        soft.into_iter().chain(beside).any(|hook| self.on(hook))
    }

    /// As [`Self::advance`] with a rigid bristle, set-valued at rest: the force is `trial`, cut at `±μN⁺`.
    ///
    /// With `trial = F + r·v` and any `r > 0` the force `F` is the answer exactly where the contact sticks (`v = 0`) within
    /// the limit or slides at it (augmented Lagrangian). What acts beside the bristle (viscous force, parallel springs) is in
    /// `trial` and in the answer.
    pub fn advance_rigid(
        &self,
        state: ModifiedState<T>,
        step: &Step<T>,
        (trial, circumstance): (T, &Circumstance),
    ) -> (ModifiedState<T>, T) {
        let normal = self.pressing(step, circumstance);
        let [_, memory, _, lagged] = state.0;
        let place = |k: usize| {
            let velocity = step.velocity[k];
            self.followed(self.place(step.slip[k], (velocity, normal[k])), sense(velocity))
        };
        let (from, mut to) = (place(0), place(1));
        to.memory = self.remember(memory, &from, &to, T::from(step.dt));
        let (b, force) = self.hold(&to, (step.velocity[1], trial), circumstance);
        (ModifiedState([b, to.memory, step.slip[1], lagged]), force)
    }

    /// Force over pressure of the bristle, and the force, at a place of a given velocity.
    pub(super) fn hold(
        &self,
        place: &End<T>,
        (velocity, trial): (T, T),
        circumstance: &Circumstance,
    ) -> (T, T) {
        let zero = T::from(0.0);
        let friction = |sign: f64| self.friction(place, sign, circumstance);
        let beside = self.force(zero, place, velocity, || friction(sense(velocity)));
        let wanted = trial - beside;
        let sign = sense(wanted);
        let pressed = positive_part(place.normal);
        let limit = friction(sign) * pressed;
        let held = if wanted.re().abs() < limit.re() { wanted } else { limit * sign };
        let b = if pressed.re() > 0.0 { held / pressed } else { zero };
        (b, held + beside)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// At rest the held force comes back up to the limit μN = 3 N and not beyond; with a viscous share of 0.1·2 N beside it,
    /// sliding takes 3.2 N.
    #[test]
    fn force_is_held_up_to_the_limit() {
        let mut law: ModifiedLaw<f64> = ModifiedLaw::dahl(1.0, 0.3);
        law.set(Hook::Viscous, 0.1);
        let step =
            |velocity: f64| Step { slip: [0.0; 2], velocity: [velocity; 2], normal: [10.0; 2], dt: 1e-3 };
        let answer = |velocity, trial| {
            law.advance_rigid(law.rest_at(0.0), &step(velocity), (trial, &Circumstance::default())).1
        };
        assert!((answer(0.0, 1.7) - 1.7).abs() < 1e-15);
        assert!((answer(0.0, -50.0) + 3.0).abs() < 1e-15);
        assert!((answer(2.0, 50.0) - 3.2).abs() < 1e-15);
        law.set(Hook::Breakaway, 0.5);
        assert!(law.yields());
    }
}
