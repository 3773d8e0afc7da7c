//! Coulomb: friction opposes slip with a force that does not depend on its speed.
//!
//! # Equation
//! `F_t = μ_k N⁺ sgn(v)`; at `v = 0` any force in `[−μ_k N⁺, μ_k N⁺]`.
//!
//! # Parameters
//! | symbol | field | unit | range |
//! |---|---|---|---|
//! | μ_k | `mu_k` | 1 | > 0 |
//!
//! # State
//! None.
//!
//! # Limits
//! The limit σ0 → ∞ of Dahl, Jenkins and (with μ_s = μ_k, σ1 = σ2 = 0) LuGre.
//!
//! # Energy per cycle
//! `4 μ_k N A` for slip amplitude `A`.
//!
//! # What it cannot show
//! Elastic presliding, stiction peak, lag. At rest the force follows from the balance of the body, not from the law:
//! [`Coulomb::bounds`] gives the set it must lie in; `step` answers 0 where neither slip nor velocity moves.
//!
//! # References
//! C. A. Coulomb, Théorie des machines simples (1785); J. P. Den Hartog, Trans. ASME 53 (1931) 107.
//!
//! # Example
//! ```
//! use frettrace_friction::{FrictionLaw, Step, laws::Coulomb};
//! let law = Coulomb { mu_k: 0.3 };
//! let step = Step { slip: [0.0, 1e-6], velocity: [1e-3; 2], normal: [100.0; 2], dt: 1e-3 };
//! assert_eq!(law.step([], &step).1, 30.0);
//! ```

use crate::parameter::{MU_K, Parameter};
use crate::{Claims, FrictionLaw, Scalar, Step, positive_part, sign};

/// Parameters of the Coulomb law.
#[derive(Clone, Copy, Debug)]
pub struct Coulomb<T> {
    /// Friction coefficient.
    pub mu_k: T,
}

/// The parameters in order.
pub(crate) const PARAMETERS: &[Parameter] = &[MU_K];

/// What the law promises.
pub(crate) const CLAIMS: Claims = Claims::MASING;

impl<T: Scalar> Coulomb<T> {
    pub(crate) fn from_values([mu_k]: [T; 1]) -> Self {
        Self { mu_k }
    }

    pub(crate) fn values(&self) -> [T; 1] {
        [self.mu_k]
    }

    /// The set the force \[N\] lies in at the slip velocity (m/s) and normal force \[N\]: one value in slip, an interval
    /// at rest.
    pub fn bounds(&self, velocity: T, normal: T) -> [T; 2] {
        let level = self.mu_k * positive_part(normal);
        let sense = sign(velocity.re());
        if sense == 0.0 { [-level, level] } else { [level * sense; 2] }
    }
}

/// The sense of the slip at the end of a step: of the velocity, else of the slip.
#[inline(always)]
pub(crate) fn sense<T: Scalar>(step: &Step<T>) -> f64 {
    let sense = sign(step.velocity[1].re());
    if sense == 0.0 { sign(step.slip[1].re() - step.slip[0].re()) } else { sense }
}

impl<T: Scalar> FrictionLaw<T> for Coulomb<T> {
    type State = [T; 0];

    fn rest(&self) -> [T; 0] {
        []
    }

    #[inline]
    fn step(&self, state: [T; 0], step: &Step<T>) -> ([T; 0], T) {
        (state, self.mu_k * positive_part(step.normal[1]) * sense(step))
    }

    fn at_rest(&self, _: [T; 0], step: &Step<T>) -> Option<[T; 2]> {
        Some(self.bounds(T::from(0.0), step.normal[1]))
    }
}
