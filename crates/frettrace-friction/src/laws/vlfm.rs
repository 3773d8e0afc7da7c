//! Velocity-limited friction (VLFM): Coulomb with a smooth ramp at small velocity, for tubes on supports.
//!
//! # Equation
//! `F_t = μ_k N⁺ s (2 − |s|)` with `s = v/v_ref` for `|s| < 1`; `μ_k N⁺ sgn(v)` beyond. (The straight ramp is
//! [`super::RegularisedCoulomb`] with [`super::Shape::Linear`].)
//!
//! # Parameters
//! | symbol | field | unit | range |
//! |---|---|---|---|
//! | μ_k | `mu_k` | 1 | > 0 |
//! | v_0 | `v_ref` | m/s | > 0 |
//!
//! # State
//! None.
//!
//! # Limits
//! v_0 → 0: Coulomb.
//!
//! # Energy per cycle
//! Below Coulomb's `4 μ_k N A`; for harmonic slip, in units of it, with `w = ω A/v_0` and `cos θ = 1/w` (`θ = 0` for `w ≤ 1`):
//! `sin θ + w (π/2 − θ − sin θ cos θ) − w² (2/3 − sin θ + sin³ θ/3)`.
//!
//! # What it cannot show
//! Sticking: the contact creeps under any load. No elastic presliding.
//!
//! # References
//! R. J. Rogers, R. J. Pick, Nucl. Eng. Des. 44 (1977) 247. Equation from general knowledge.
//!
//! # Example
//! ```
//! use frettrace_friction::{FrictionLaw, Step, laws::Vlfm};
//! let law = Vlfm { mu_k: 0.5, v_ref: 1e-3 };
//! let step = Step { slip: [0.0, 1e-7], velocity: [5e-4; 2], normal: [10.0; 2], dt: 2e-4 };
//! assert_eq!(law.step([], &step).1, 3.75);
//! ```

use crate::parameter::{MU_K, Parameter, V_REF};
use crate::{Claims, FrictionLaw, Scalar, Step, positive_part, sign};

/// Parameters of the velocity-limited law.
#[derive(Clone, Copy, Debug)]
pub struct Vlfm<T> {
    /// Friction coefficient.
    pub mu_k: T,
    /// Velocity at which friction is full (m/s).
    pub v_ref: T,
}

/// The parameters in order.
pub(crate) const PARAMETERS: &[Parameter] = &[MU_K, V_REF];

/// What the law promises.
pub(crate) const CLAIMS: Claims = Claims::BOUNDED;

impl<T: Scalar> Vlfm<T> {
    pub(crate) fn from_values([mu_k, v_ref]: [T; 2]) -> Self {
        Self { mu_k, v_ref }
    }

    pub(crate) fn values(&self) -> [T; 2] {
        [self.mu_k, self.v_ref]
    }
}

impl<T: Scalar> FrictionLaw<T> for Vlfm<T> {
    type State = [T; 0];

    fn rest(&self) -> [T; 0] {
        []
    }

    #[inline]
    fn step(&self, state: [T; 0], step: &Step<T>) -> ([T; 0], T) {
        let s = step.velocity[1] / self.v_ref;
        let sense = sign(s.re());
        let ramp = if s.re().abs() < 1.0 { s * (-s * sense + 2.0) } else { T::from(sense) };
        (state, self.mu_k * positive_part(step.normal[1]) * ramp)
    }
}
