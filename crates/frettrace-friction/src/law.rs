//! What every law is: one step from sample to sample.

use num_dual::DualNum;

/// A real or dual number.
pub trait Scalar: DualNum<Primitive = f64> + Copy + Send + Sync {}
impl<T: DualNum<Primitive = f64> + Copy + Send + Sync> Scalar for T {}

/// The motion of the contact over one step; index 0 is the old sample, 1 the new one.
#[derive(Clone, Copy, Debug)]
pub struct Step<T> {
    /// Slip `u` [m].
    pub slip: [T; 2],
    /// Slip velocity `v` [m/s].
    pub velocity: [T; 2],
    /// Normal force `N` [N], compression positive; a law uses `max(N, 0)`.
    pub normal: [T; 2],
    /// Duration [s].
    pub dt: f64,
}

/// A scalar friction law with its parameters over the scalar `T`.
pub trait FrictionLaw<T: Scalar>: Copy {
    /// Internal state (deflections of bristles, film thickness …), a small array.
    type State: Copy + AsRef<[T]> + AsMut<[T]>;

    /// The state of an unloaded contact.
    fn rest(&self) -> Self::State;

    /// From the old sample to the new one: the new state and the friction force `F_t` [N] at the new sample
    /// (positive: it resists positive slip).
    fn step(&self, state: Self::State, step: &Step<T>) -> (Self::State, T);
}
