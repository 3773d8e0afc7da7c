//! Force-balance friction (FBFM): within a small velocity the friction force holds the contact, for tubes on supports.
//!
//! # Equation
//! `|v| ≥ v_ref`: `F_t = μ_k N⁺ sgn(v)`. Below: the force that balances the others, read from the motion of the mass
//! that moves with the contact, `F_others = F_old + m Δv/Δt` (from `m v̇ = F_others − F`), limited to `±μ_s N⁺`.
//!
//! # Parameters
//! | symbol | field | unit | range |
//! |---|---|---|---|
//! | μ_s | `mu_s` | 1 | > 0 |
//! | μ_k | `mu_k` | 1 | > 0 |
//! | v_0 | `v_ref` | m/s | > 0, below it the contact sticks |
//! | m | `moving_mass` | kg | > 0 |
//!
//! # State
//! The friction force \[N\] of the last sample.
//!
//! # Limits
//! v_0 → 0: Coulomb with stiction. m → ∞, or Δt → 0: full friction by the sense of the acceleration inside the band, since a
//! mass that is held has none; of a step Δt it takes `2 μ_s N Δt/(m |v̇|)` to turn, so that the force is first order in Δt.
//!
//! # Energy per cycle
//! `4 μ_k N A` for `v_0 → 0`.
//!
//! # What it cannot show
//! Elastic presliding. It needs the mass, so it belongs to the rig as much as to the contact; along a given motion with coarse
//! steps it depends on them: inside the band it is a rule for time marching rather than a law.
//!
//! # References
//! D. Karnopp, J. Dyn. Syst. Meas. Control 107 (1985) 100; X. Tan, R. J. Rogers, PVP-328 (1996) 347; M. A. Hassan, R. J.
//! Rogers, J. Pressure Vessel Technol. 127 (2005). Equations from general knowledge.
//!
//! # Example
//! ```
//! use frettrace_friction::{FrictionLaw, Step, laws::Fbfm};
//! let law = Fbfm { mu_s: 0.5, mu_k: 0.4, v_ref: 1e-3, moving_mass: 1.0 };
//! let step = Step { slip: [0.0, 0.0], velocity: [0.0, 5e-4], normal: [10.0; 2], dt: 1e-3 };
//! assert_eq!(law.step(law.rest(), &step).1, 0.5); // it held against half a newton
//! ```

use crate::laws::jenkins::limited;
use crate::parameter::{MU_K, MU_S, Parameter, Range, V_REF};
use crate::{Claims, FrictionLaw, Scalar, Step, positive_part, sign};

/// Parameters of the force-balance law.
#[derive(Clone, Copy, Debug)]
pub struct Fbfm<T> {
    /// Friction coefficient that ends stick.
    pub mu_s: T,
    /// Friction coefficient of sliding.
    pub mu_k: T,
    /// Velocity below which the contact sticks (m/s).
    pub v_ref: T,
    /// Mass that moves with the contact \[kg\].
    pub moving_mass: T,
}

/// The parameters in order.
pub(crate) const PARAMETERS: &[Parameter] =
    &[MU_S, MU_K, V_REF, Parameter::new("moving_mass", "kg", Range::POSITIVE, 1.0)];

/// Not passive: inside the band it follows the motion of the mass.
pub(crate) const CLAIMS: Claims = Claims { passive: false, jumps: true, ..Claims::BOUNDED };

impl<T: Scalar> Fbfm<T> {
    pub(crate) fn from_values([mu_s, mu_k, v_ref, moving_mass]: [T; 4]) -> Self {
        Self { mu_s, mu_k, v_ref, moving_mass }
    }

    pub(crate) fn values(&self) -> [T; 4] {
        [self.mu_s, self.mu_k, self.v_ref, self.moving_mass]
    }
}

impl<T: Scalar> FrictionLaw<T> for Fbfm<T> {
    type State = [T; 1];

    fn rest(&self) -> [T; 1] {
        [T::from(0.0)]
    }

    #[inline]
    fn step(&self, state: [T; 1], step: &Step<T>) -> ([T; 1], T) {
        let ([v0, v1], normal) = (step.velocity, positive_part(step.normal[1]));
        let force = if v1.re().abs() < self.v_ref.re() {
            limited(state[0] + self.moving_mass * (v1 - v0) / step.dt, self.mu_s * normal)
        } else {
            self.mu_k * normal * sign(v1.re())
        };
        ([force], force)
    }
}
