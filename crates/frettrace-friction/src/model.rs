//! A law of the catalogue as a law: what needs one type for all of them steps through here.

use std::ops::ControlFlow;

use crate::{FrictionLaw, FrictionModel, Scalar, Step, Stretch, Visitor, masing};

/// Room for the longest state, that of Masing's memory.
const ROOM: usize = masing::LENGTH;

/// State of a law of the catalogue.
#[derive(Clone, Copy, Debug)]
pub struct ModelState<T> {
    values: [T; ROOM],
    length: usize,
}

impl<T: Scalar> ModelState<T> {
    fn of(state: &[T]) -> Self {
        let mut values = [T::from(0.0); ROOM];
        values[..state.len()].copy_from_slice(state);
        Self { values, length: state.len() }
    }

    /// The state in the law's own type.
    fn own<L: FrictionLaw<T>>(&self, law: &L) -> L::State {
        let mut state = law.rest();
        state.as_mut().copy_from_slice(self.as_ref());
        state
    }
}

impl<T> AsRef<[T]> for ModelState<T> {
    fn as_ref(&self) -> &[T] {
        &self.values[..self.length]
    }
}

impl<T> AsMut<[T]> for ModelState<T> {
    fn as_mut(&mut self) -> &mut [T] {
        &mut self.values[..self.length]
    }
}

struct Resting;

impl<T: Scalar> Visitor<T> for Resting {
    type Output = ModelState<T>;

    fn visit<L: FrictionLaw<T>>(self, law: &L) -> ModelState<T> {
        ModelState::of(law.rest().as_ref())
    }
}

struct Stepping<'a, T> {
    state: ModelState<T>,
    step: &'a Step<T>,
}

impl<T: Scalar> Visitor<T> for Stepping<'_, T> {
    type Output = (ModelState<T>, T);

    fn visit<L: FrictionLaw<T>>(self, law: &L) -> Self::Output {
        let (state, force) = law.step(self.state.own(law), self.step);
        (ModelState::of(state.as_ref()), force)
    }
}

struct AtRest<'a, T> {
    state: ModelState<T>,
    step: &'a Step<T>,
}

impl<T: Scalar> Visitor<T> for AtRest<'_, T> {
    type Output = Option<[T; 2]>;

    fn visit<L: FrictionLaw<T>>(self, law: &L) -> Self::Output {
        law.at_rest(self.state.own(law), self.step)
    }
}

struct Following<'a, T, R> {
    state: ModelState<T>,
    stretch: &'a Stretch<'a, T>,
    record: R,
}

impl<T: Scalar, R: FnMut(usize, ModelState<T>, T) -> ControlFlow<()>> Visitor<T> for Following<'_, T, R> {
    type Output = ModelState<T>;

    fn visit<L: FrictionLaw<T>>(self, law: &L) -> ModelState<T> {
        let Self { state, stretch, mut record } = self;
        let end = law.follow(state.own(law), stretch, |index, state, force| {
            record(index, ModelState::of(state.as_ref()), force)
        });
        ModelState::of(end.as_ref())
    }
}

impl<T: Scalar> FrictionLaw<T> for FrictionModel<T> {
    type State = ModelState<T>;

    fn rest(&self) -> ModelState<T> {
        self.visit(Resting)
    }

    fn step(&self, state: ModelState<T>, step: &Step<T>) -> (ModelState<T>, T) {
        self.visit(Stepping { state, step })
    }

    fn at_rest(&self, state: ModelState<T>, step: &Step<T>) -> Option<[T; 2]> {
        self.visit(AtRest { state, step })
    }

    /// The law is found out once for the whole stretch.
    fn follow(
        &self,
        state: ModelState<T>,
        stretch: &Stretch<'_, T>,
        record: impl FnMut(usize, ModelState<T>, T) -> ControlFlow<()>,
    ) -> ModelState<T> {
        self.visit(Following { state, stretch, record })
    }
}

impl FrictionModel {
    /// The same law over another scalar.
    #[must_use]
    pub fn lift<T: Scalar>(&self) -> FrictionModel<T> {
        let values = self.values();
        self.law().build(|position| T::from(values[position]))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Law, Period};

    /// One period of every law, by the model and by the law itself: the same numbers.
    #[test]
    fn a_model_is_its_law() {
        struct March<'a>(Period<'a, f64>, &'a mut [f64]);
        impl Visitor<f64> for March<'_> {
            type Output = Vec<f64>;

            fn visit<L: FrictionLaw<f64>>(self, law: &L) -> Vec<f64> {
                self.0.march(law, law.rest(), self.1).unwrap().as_ref().to_vec()
            }
        }
        let phase = |k: i32| 0.1 * f64::from(k);
        let slip: Vec<f64> = (0..63).map(|k| 3e-6 * phase(k).sin()).collect();
        let velocity: Vec<f64> = (0..63).map(|k| 3e-4 * phase(k).cos()).collect();
        let normal = [20.0; 63];
        let period = Period { slip: &slip, velocity: &velocity, normal: &normal, dt: 1e-3 };
        for law in Law::ALL {
            let model = law.with_values(&law.example()).unwrap();
            let mut forces = [[0.0; 63]; 2];
            let [direct, wrapped] = &mut forces;
            let state = model.visit(March(period, direct));
            let end = period.march(&model, model.rest(), wrapped).unwrap();
            assert_eq!(forces[0], forces[1], "{}", law.name());
            assert_eq!(state, end.as_ref(), "{}", law.name());
            assert_eq!(model.lift::<f64>().values(), model.values(), "{}", law.name());
        }
    }
}
