//! Coulomb made smooth: the sign of the velocity replaced by a steep curve.
//!
//! # Equation
//! `F_t = μ_k N⁺ S(v/v_ref)` with `S(s)` = tanh s · (2/π) arctan s · s/√(1 + s²) · s clipped to ±1.
//!
//! # Parameters
//! | symbol | field | unit | range |
//! |---|---|---|---|
//! | μ_k | `mu_k` | 1 | > 0 |
//! | v_ref | `v_ref` | m/s | > 0 |
//!
//! # State
//! None.
//!
//! # Limits
//! v_ref → 0: Coulomb. v_ref → ∞: a viscous damper `μ_k N v/v_ref` (arctan: times 2/π).
//!
//! # Energy per cycle
//! Below Coulomb's `4 μ_k N A`. For harmonic slip, in units of it and with `w = ω A/v_ref`: arctan `(√(1 + w²) − 1)/w`; algebraic
//! `[√(1 + w²) E(m) − K(m)/√(1 + w²)]/w`, complete elliptic integrals of the parameter `m = w²/(1 + w²)`; clipped
//! `sin θ + (w/2)(π/2 − θ − sin θ cos θ)` with `cos θ = 1/w`, `θ = 0` for `w ≤ 1`; tanh by quadrature.
//!
//! # What it cannot show
//! Sticking: under any force, however small, the contact creeps. No elastic presliding.
//!
//! # References
//! J.-J. Sinou, L. Jezequel, Eur. J. Mech. A 26 (2007) 106 (tanh); V. Vad and D. Cebon (1996, arctan);
//! D. D. Quinn, J. Vib. Acoust. 126 (2004) 436, doi 10.1115/1.1760564 (on the class).
//!
//! # Example
//! ```
//! use frettrace_friction::{FrictionLaw, Step, laws::{RegularisedCoulomb, Shape}};
//! let law = RegularisedCoulomb { mu_k: 0.5, v_ref: 1e-3, shape: Shape::Linear };
//! let step = Step { slip: [0.0, 1e-7], velocity: [5e-4; 2], normal: [10.0; 2], dt: 2e-4 };
//! assert_eq!(law.step([], &step).1, 2.5);
//! ```

use std::f64::consts::FRAC_2_PI;

use crate::laws::jenkins::limited;
use crate::parameter::{MU_K, Parameter, V_REF};
use crate::{Claims, FrictionLaw, Scalar, Step, positive_part};

/// The curve that replaces the sign.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Shape {
    /// `tanh s`.
    Tanh,
    /// `(2/π) arctan s`.
    Arctan,
    /// `s/√(1 + s²)`.
    Algebraic,
    /// `s` clipped to ±1.
    Linear,
}

/// Parameters of a regularised Coulomb law.
#[derive(Clone, Copy, Debug)]
pub struct RegularisedCoulomb<T> {
    /// Friction coefficient.
    pub mu_k: T,
    /// Velocity over which the sign turns (m/s).
    pub v_ref: T,
    /// The curve.
    pub shape: Shape,
}

/// The parameters in order.
pub(crate) const PARAMETERS: &[Parameter] = &[MU_K, V_REF];

/// What the law promises.
pub(crate) const CLAIMS: Claims = Claims::BOUNDED;

impl<T: Scalar> RegularisedCoulomb<T> {
    pub(crate) fn from_values([mu_k, v_ref]: [T; 2], shape: Shape) -> Self {
        Self { mu_k, v_ref, shape }
    }

    pub(crate) fn values(&self) -> [T; 2] {
        [self.mu_k, self.v_ref]
    }
}

impl<T: Scalar> FrictionLaw<T> for RegularisedCoulomb<T> {
    type State = [T; 0];

    fn rest(&self) -> [T; 0] {
        []
    }

    #[inline]
    fn step(&self, state: [T; 0], step: &Step<T>) -> ([T; 0], T) {
        let s = step.velocity[1] / self.v_ref;
        let curve = match self.shape {
            Shape::Tanh => s.tanh(),
            Shape::Arctan => s.atan() * FRAC_2_PI,
            Shape::Algebraic => s / (s * s + 1.0).sqrt(),
            Shape::Linear => limited(s, T::from(1.0)),
        };
        (state, self.mu_k * positive_part(step.normal[1]) * curve)
    }
}
