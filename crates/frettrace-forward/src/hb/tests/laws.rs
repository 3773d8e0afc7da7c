//! Two laws written for the tests alone: friction proportional to the normal force.

use crate::hb::{Family, Friction};
use frettrace_friction::{FrictionLaw, Scalar, Step};

/// Jenkins element: spring `k` (N/m) in series with a slider of limit `mu·N`.
#[derive(Clone, Copy, Debug)]
pub(in crate::hb) struct Jenkins {
    /// `k`, `mu`.
    pub parameters: [f64; 2],
}

#[derive(Clone, Copy)]
pub(in crate::hb) struct JenkinsLaw<T>([T; 2]);

impl Family for Jenkins {
    type Law<T: Scalar> = Friction<JenkinsLaw<T>>;

    fn parameters(&self) -> &[f64] {
        &self.parameters
    }

    fn law<T: Scalar>(&self, parameters: &[T]) -> Friction<JenkinsLaw<T>> {
        Friction(JenkinsLaw([parameters[0], parameters[1]]))
    }
}

impl<T: Scalar> FrictionLaw<T> for JenkinsLaw<T> {
    type State = [T; 1];

    fn rest(&self) -> [T; 1] {
        [T::zero()]
    }

    fn step(&self, [force]: [T; 1], step: &Step<T>) -> ([T; 1], T) {
        let limit = self.0[1] * step.normal[1];
        let trial = force + self.0[0] * (step.slip[1] - step.slip[0]);
        let force = if trial.re().abs() <= limit.re() { trial } else { limit * trial.re().signum() };
        ([force], force)
    }
}

/// Dahl's law of exponent 1, exact for steps of one sign: `dF/du = k (1 − F sgn(v)/(mu N))`.
#[derive(Clone, Copy, Debug)]
pub(in crate::hb) struct Dahl {
    /// `k`, `mu`.
    pub parameters: [f64; 2],
}

#[derive(Clone, Copy)]
pub(in crate::hb) struct DahlLaw<T>([T; 2]);

impl Family for Dahl {
    type Law<T: Scalar> = Friction<DahlLaw<T>>;

    fn parameters(&self) -> &[f64] {
        &self.parameters
    }

    fn law<T: Scalar>(&self, parameters: &[T]) -> Friction<DahlLaw<T>> {
        Friction(DahlLaw([parameters[0], parameters[1]]))
    }
}

impl<T: Scalar> FrictionLaw<T> for DahlLaw<T> {
    type State = [T; 1];

    fn rest(&self) -> [T; 1] {
        [T::zero()]
    }

    fn step(&self, [z]: [T; 1], step: &Step<T>) -> ([T; 1], T) {
        let [stiffness, mu] = self.0;
        let moved = step.slip[1] - step.slip[0];
        let limit = mu / stiffness * moved.re().signum();
        let z = limit + (z - limit) * (-(stiffness * moved / mu) * moved.re().signum()).exp();
        ([z], stiffness * z * step.normal[1])
    }
}
