//! Jenkins: a spring in series with a Coulomb slider (bilinear hysteresis, elastic dry friction).
//!
//! # Equation
//! `dF = k_t du` while `|F| < μ_k N⁺`; else `F = ±μ_k N⁺`.
//!
//! # Parameters
//! | symbol | field | unit | range |
//! |---|---|---|---|
//! | k_t | `tangential_stiffness` | N/m | > 0 |
//! | μ_k | `mu_k` | 1 | > 0 |
//!
//! # State
//! Force of the spring `F` \[N\]. Lift-off (N ≤ 0) releases the spring.
//!
//! # Limits
//! k_t → ∞: Coulomb. It is Dahl with exponent 0 and σ0 = k_t/N when N is constant.
//!
//! # Energy per cycle
//! `4 F_s (A − F_s/k_t)` for amplitude `A > F_s/k_t`, `F_s = μ_k N`; else 0. With `θ = arccos(1 − 2 F_s/(k_t A))` the
//! first harmonic in phase with `u = A cos` is `(k_t A/π)(θ − ½ sin 2θ)`, out of phase `−(k_t A/π) sin² θ`.
//!
//! # What it cannot show
//! Gradual onset of slip, Stribeck effect, any dependence on velocity.
//!
//! # References
//! G. M. Jenkins, Rep. Prog. Phys. 25 (1962); T. K. Caughey, J. Appl. Mech. 27 (1960) 640; B.-D. Yang, M.-L. Chu,
//! C.-H. Menq, J. Sound Vib. 210 (1998) 461, doi 10.1006/jsvi.1997.1305 (varying normal force).
//!
//! # Example
//! ```
//! use frettrace_friction::{FrictionLaw, Step, laws::Jenkins};
//! let law = Jenkins { tangential_stiffness: 2.0, mu_k: 3.0 };
//! let step = Step { slip: [0.0, 5.0], velocity: [5.0; 2], normal: [1.0; 2], dt: 1.0 };
//! assert_eq!(law.step([0.0], &step).1, 3.0);
//! ```

use crate::parameter::{MU_K, Parameter, STIFFNESS};
use crate::{Claims, FrictionLaw, Scalar, Step, positive_part};

/// Parameters of the Jenkins element.
#[derive(Clone, Copy, Debug)]
pub struct Jenkins<T> {
    /// Tangential stiffness (N/m).
    pub tangential_stiffness: T,
    /// Friction coefficient.
    pub mu_k: T,
}

/// The parameters in order.
pub(crate) const PARAMETERS: &[Parameter] = &[STIFFNESS, MU_K];

/// What the law promises.
pub(crate) const CLAIMS: Claims = Claims::MASING;

impl<T: Scalar> Jenkins<T> {
    pub(crate) fn from_values([tangential_stiffness, mu_k]: [T; 2]) -> Self {
        Self { tangential_stiffness, mu_k }
    }

    pub(crate) fn values(&self) -> [T; 2] {
        [self.tangential_stiffness, self.mu_k]
    }
}

/// The value, no further from 0 than the limit.
#[inline(always)]
pub(crate) fn limited<T: Scalar>(value: T, limit: T) -> T {
    if value.re() > limit.re() {
        limit
    } else if value.re() < -limit.re() {
        -limit
    } else {
        value
    }
}

impl<T: Scalar> FrictionLaw<T> for Jenkins<T> {
    type State = [T; 1];

    fn rest(&self) -> [T; 1] {
        [T::from(0.0)]
    }

    /// The limit is that of the new sample at its end and of the straight line between the samples at a reversal.
    #[inline]
    fn step(&self, state: [T; 1], step: &Step<T>) -> ([T; 1], T) {
        let [n0, n1] = step.normal;
        let (first, second) = step.strokes();
        let mut force = state[0];
        for stroke in [Some(first), second].into_iter().flatten() {
            let normal = n0 + (n1 - n0) * stroke.fraction[2];
            force =
                limited(force + self.tangential_stiffness * stroke.travel, self.mu_k * positive_part(normal));
        }
        ([force], force)
    }
}
