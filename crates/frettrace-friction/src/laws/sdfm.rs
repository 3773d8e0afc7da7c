//! Spring-damper friction (SDFM): sticking on a spring and a damper, sliding by Coulomb, for tubes on supports.
//!
//! # Equation
//! Stick: `F_t = S + c_t v`, `dS = k_t du`, until `|F_t| = μ_s N⁺`. Slide: `F_t = μ_k N⁺ sgn(v)` until the velocity
//! reverses; then stick again with the spring loaded by the friction force at the reversal. Where a falling normal force ends stick
//! against the sense of the slip, the spring goes back to `μ_k N⁺` and sticks again.
//!
//! # Parameters
//! | symbol | field | unit | range |
//! |---|---|---|---|
//! | k_t | `tangential_stiffness` | N/m | > 0 |
//! | c_t | `tangential_damping` | N·s/m | ≥ 0 |
//! | μ_s | `mu_s` | 1 | > 0 |
//! | μ_k | `mu_k` | 1 | > 0 |
//!
//! # State
//! Spring force `S` \[N\] and the sense of sliding (0: stick).
//!
//! # Limits
//! μ_s = μ_k, c_t = 0: Jenkins. k_t → ∞: Coulomb with stiction.
//!
//! # Energy per cycle
//! Stick throughout: `π c_t ω A²` in harmonic slip. With sliding and c_t = 0:
//! `4 μ_k N A + (μ_s + μ_k)(μ_s − 3 μ_k) N²/k_t`, which is Jenkins' for μ_s = μ_k.
//!
//! # What it cannot show
//! Partial slip; a Stribeck curve (it has only a drop).
//!
//! # References
//! J. Antunes, F. Axisa, B. Beaufils, D. Guilbaud, Coulomb friction modelling in numerical simulations of vibration
//! and wear work rate of multispan tube bundles (1988), J. Fluids Struct. 4 (1990) 287. Equations from general
//! knowledge; the loaded spring at the reversal, which avoids a jump of the force, is this project's reading.
//!
//! # Example
//! ```
//! use frettrace_friction::{FrictionLaw, Step, laws::Sdfm};
//! let law = Sdfm { tangential_stiffness: 1e6, tangential_damping: 0.0, mu_s: 0.5, mu_k: 0.4 };
//! let step = Step { slip: [0.0, 2e-6], velocity: [1e-3; 2], normal: [10.0; 2], dt: 2e-3 };
//! assert_eq!(law.step(law.rest(), &step).1, 2.0);
//! ```

use crate::parameter::{MU_K, MU_S, Parameter, Range, STIFFNESS};
use crate::{Claims, FrictionLaw, Scalar, Step, Stroke, positive_part};

/// Parameters of the spring-damper law.
#[derive(Clone, Copy, Debug)]
pub struct Sdfm<T> {
    /// Stiffness in stick (N/m).
    pub tangential_stiffness: T,
    /// Damping in stick (N·s/m).
    pub tangential_damping: T,
    /// Friction coefficient that ends stick.
    pub mu_s: T,
    /// Friction coefficient of sliding.
    pub mu_k: T,
}

/// The parameters in order.
pub(crate) const PARAMETERS: &[Parameter] =
    &[STIFFNESS, Parameter::new("tangential_damping", "N·s/m", Range::NOT_NEGATIVE, 100.0), MU_S, MU_K];

/// What the law promises.
pub(crate) const CLAIMS: Claims = Claims::BOUNDED;

impl<T: Scalar> Sdfm<T> {
    pub(crate) fn from_values([tangential_stiffness, tangential_damping, mu_s, mu_k]: [T; 4]) -> Self {
        Self { tangential_stiffness, tangential_damping, mu_s, mu_k }
    }

    pub(crate) fn values(&self) -> [T; 4] {
        [self.tangential_stiffness, self.tangential_damping, self.mu_s, self.mu_k]
    }

    /// State and force after one stroke that ends under the normal force `normal`.
    fn along(&self, [spring, sliding]: [T; 2], stroke: &Stroke<T>, normal: T) -> ([T; 2], T) {
        let kinetic = self.mu_k * normal * stroke.direction;
        if sliding.re() == stroke.direction {
            return ([kinetic, sliding], kinetic);
        }
        let loaded = spring + self.tangential_stiffness * stroke.travel;
        let force = loaded + self.tangential_damping * stroke.velocity[2];
        let (along, limit) = (force.re() * stroke.direction, self.mu_s.re() * normal.re());
        if along >= limit {
            ([kinetic, T::from(stroke.direction)], kinetic)
        } else if along < -limit {
            // A falling normal force no longer holds the spring that an earlier stroke has loaded: it springs back.
            ([-kinetic, T::from(0.0)], -kinetic)
        } else {
            ([loaded, T::from(0.0)], force)
        }
    }
}

impl<T: Scalar> FrictionLaw<T> for Sdfm<T> {
    type State = [T; 2];

    fn rest(&self) -> [T; 2] {
        [T::from(0.0); 2]
    }

    #[inline]
    fn step(&self, state: [T; 2], step: &Step<T>) -> ([T; 2], T) {
        let [n0, n1] = step.normal;
        let (first, second) = step.strokes();
        let mut outcome = (state, T::from(0.0));
        for stroke in [Some(first), second].into_iter().flatten() {
            let normal = positive_part(n0 + (n1 - n0) * stroke.fraction[2]);
            outcome = self.along(outcome.0, &stroke, normal);
        }
        outcome
    }
}
