//! Elasto-plastic (Dupont): LuGre that does not creep below its breakaway force.
//!
//! # Equation
//! `F_t = N⁺ (σ0 z + σ1 ż) + σ2 v`, `ż = v (1 − α(r) r)`, `r = σ0 z sgn(v)/μ(v)`; `α = 0` for `r ≤ b` (so also when `z`
//! and `v` differ in sign), `½ [1 + sin(π (r − (1 + b)/2)/(1 − b))]` for `b < r < 1`, 1 beyond; μ(v) as in LuGre.
//!
//! # Parameters
//! | symbol | field | unit | range |
//! |---|---|---|---|
//! | σ0 | `sigma0` | 1/m | > 0 |
//! | σ1 | `sigma1` | s/m | ≥ 0 |
//! | σ2 | `sigma2` | N·s/m | ≥ 0 |
//! | μ_s, μ_k | `mu_s`, `mu_k` | 1 | > 0 |
//! | v_s | `v_s` | m/s | > 0 |
//! | δ | `delta` | 1 | 0 … 20 |
//! | b | `breakaway` | 1 | 0 ≤ b < 1, z_ba over the steady deflection |
//!
//! # State
//! Bristle deflection `z` \[m\].
//!
//! # Limits
//! The hybrid law with v_d → ∞. b → 1: Jenkins with the Stribeck level.
//!
//! # Energy per cycle
//! As hybrid: 0 for slip amplitudes up to `b μ/σ0` (σ1 = σ2 = 0), → `4 μ N (A − μ/σ0)` for b → 1 and constant μ.
//!
//! # What it cannot show
//! Non-local memory. Presliding damping that dies with slip.
//!
//! # References
//! P. Dupont, V. Hayward, B. Armstrong, F. Altpeter, IEEE Trans. Automatic Control 47 (2002) 787,
//! doi 10.1109/TAC.2002.1000274.
//!
//! # Example
//! ```
//! use frettrace_friction::{FrictionLaw, Step, laws::ElastoPlastic};
//! let law = ElastoPlastic {
//!     sigma0: 1e6, sigma1: 0.0, sigma2: 0.0, mu_s: 0.5, mu_k: 0.5, v_s: 1e-3, delta: 2.0, breakaway: 0.3,
//! };
//! let step = Step { slip: [0.0, 1e-7], velocity: [1e-3; 2], normal: [10.0; 2], dt: 1e-4 };
//! let force: f64 = law.step(law.rest(), &step).1;
//! assert!((force - 1.0).abs() < 1e-12); // a fifth of the steady deflection: elastic
//! ```

use crate::parameter::{BREAKAWAY, DELTA, MU_K, MU_S, Parameter, SIGMA0, SIGMA1, SIGMA2, V_S};
use crate::{Bristle, Claims, FrictionLaw, Saturation, Scalar, Steady, Step};

/// Parameters of the elasto-plastic law.
#[derive(Clone, Copy, Debug)]
pub struct ElastoPlastic<T> {
    /// Bristle stiffness per newton of normal force (1/m).
    pub sigma0: T,
    /// Presliding damping per newton of normal force (s/m).
    pub sigma1: T,
    /// Viscous damping (N·s/m).
    pub sigma2: T,
    /// Friction coefficient at rest.
    pub mu_s: T,
    /// Friction coefficient of fast slip.
    pub mu_k: T,
    /// Stribeck velocity (m/s).
    pub v_s: T,
    /// Stribeck exponent.
    pub delta: T,
    /// Elastic share of the steady deflection.
    pub breakaway: T,
}

/// The parameters in order.
pub(crate) const PARAMETERS: &[Parameter] = &[SIGMA0, SIGMA1, SIGMA2, MU_S, MU_K, V_S, DELTA, BREAKAWAY];

/// What the law promises.
pub(crate) const CLAIMS: Claims = Claims::PASSIVE;

impl<T: Scalar> ElastoPlastic<T> {
    pub(crate) fn from_values([sigma0, sigma1, sigma2, mu_s, mu_k, v_s, delta, breakaway]: [T; 8]) -> Self {
        Self { sigma0, sigma1, sigma2, mu_s, mu_k, v_s, delta, breakaway }
    }

    pub(crate) fn values(&self) -> [T; 8] {
        let Self { sigma0, sigma1, sigma2, mu_s, mu_k, v_s, delta, breakaway } = *self;
        [sigma0, sigma1, sigma2, mu_s, mu_k, v_s, delta, breakaway]
    }

    /// The law as a member of the bristle family.
    #[inline]
    pub fn bristle(&self) -> Bristle<T> {
        Bristle {
            sigma1: self.sigma1,
            sigma2: self.sigma2,
            mu_s: self.mu_s,
            v_s: self.v_s,
            delta: self.delta,
            breakaway: self.breakaway,
            saturation: Saturation::Breakaway,
            steady: Steady::Stribeck,
            ..Bristle::plain(self.sigma0, self.mu_k)
        }
    }
}

impl<T: Scalar> FrictionLaw<T> for ElastoPlastic<T> {
    type State = [T; 1];

    fn rest(&self) -> [T; 1] {
        [T::from(0.0)]
    }

    #[inline]
    fn step(&self, state: [T; 1], step: &Step<T>) -> ([T; 1], T) {
        self.bristle().step(state, step)
    }
}
