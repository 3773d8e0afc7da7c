//! What sits between channels and forces: contact laws written over any scalar, and where they are connected.

use frettrace_friction::{FrictionLaw, FrictionModel, Scalar, Step, Stretch};
use std::ops::ControlFlow;

/// Most internal states a law may have.
pub const STATE_LIMIT: usize = 15;

/// A law from the motion of a contact to one or two forces, one step at a time.
///
/// A [`FrictionLaw`] becomes one by [`Friction`]; a law that also pushes back in the normal direction gives two forces.
pub trait ContactLaw<T: Scalar>: Copy {
    /// Internal state: an array of at most [`STATE_LIMIT`] scalars.
    type State: Copy + AsRef<[T]> + AsMut<[T]>;

    /// Forces given: 1 (tangential) or 2 (tangential, normal).
    const FORCES: usize;

    /// Whether the slip velocity matters.
    const VELOCITY: bool = true;

    /// The state of an unloaded contact.
    fn rest(&self) -> Self::State;

    /// From the old sample to the new one: the new state and the forces at the new sample. With one force the second
    /// is ignored.
    fn step(&self, state: Self::State, step: &Step<T>) -> (Self::State, [T; 2]);

    /// As [`FrictionLaw::follow`], with both forces.
    #[inline]
    fn follow(
        &self,
        mut state: Self::State,
        stretch: &Stretch<'_, T>,
        mut record: impl FnMut(usize, Self::State, [T; 2]) -> ControlFlow<()>,
    ) -> Self::State {
        for index in 0..stretch.steps() {
            let (new, forces) = self.step(state, &stretch.step(index));
            state = new;
            if record(index, state, forces).is_break() {
                break;
            }
        }
        state
    }
}

/// A friction law as a contact law with one force.
#[derive(Clone, Copy, Debug)]
pub struct Friction<L>(pub L);

impl<T: Scalar, L: FrictionLaw<T>> ContactLaw<T> for Friction<L> {
    type State = L::State;

    const FORCES: usize = 1;

    fn rest(&self) -> Self::State {
        self.0.rest()
    }

    fn step(&self, state: Self::State, step: &Step<T>) -> (Self::State, [T; 2]) {
        let (state, force) = self.0.step(state, step);
        (state, [force, T::zero()])
    }

    #[inline]
    fn follow(
        &self,
        state: Self::State,
        stretch: &Stretch<'_, T>,
        mut record: impl FnMut(usize, Self::State, [T; 2]) -> ControlFlow<()>,
    ) -> Self::State {
        self.0.follow(state, stretch, |index, after, force| record(index, after, [force, T::zero()]))
    }
}

/// A law with its free parameters, over whichever scalar the solver asks for.
pub trait Family: Sync {
    /// The law over the scalar `T`.
    type Law<T: Scalar>: ContactLaw<T>;

    /// Values of the free parameters: those whose tangents are wanted, at most a few dozen; may be empty.
    fn parameters(&self) -> &[f64];

    /// The law with these parameters (as many as [`Self::parameters`] has).
    fn law<T: Scalar>(&self, parameters: &[T]) -> Self::Law<T>;
}

/// Any law of the catalogue with values that are given: none of its parameters is free.
pub struct Declared(pub FrictionModel);

impl Family for Declared {
    type Law<T: Scalar> = Friction<FrictionModel<T>>;

    fn parameters(&self) -> &[f64] {
        &[]
    }

    fn law<T: Scalar>(&self, _: &[T]) -> Self::Law<T> {
        Friction(self.0.lift())
    }
}

/// Where the normal force of a contact comes from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Normal {
    /// Constant (N).
    Constant(f64),
    /// A channel: the normal force itself (N), or whatever the law takes for it (a gap (m)).
    Channel(usize),
}

/// A contact law connected to the structure.
#[derive(Clone, Copy)]
pub struct Contact<'a> {
    /// Channel whose motion is the slip.
    pub slip: usize,
    /// Where the normal force comes from.
    pub normal: Normal,
    /// Force that the law's first output adds to.
    pub force: usize,
    /// Force that the law's second output adds to; `None` drops it.
    pub normal_force: Option<usize>,
    /// The law.
    pub element: &'a dyn super::Element,
}

impl Contact<'_> {
    pub(super) fn outputs(&self) -> [Option<usize>; 2] {
        let second = if self.element.forces() > 1 { self.normal_force } else { None };
        [Some(self.force), second]
    }
}
