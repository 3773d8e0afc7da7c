//! LuGre: Dahl's bristle with the Stribeck effect, presliding and viscous damping.
//!
//! # Equation
//! `F_t = N⁺ (σ0 z + σ1(v) ż) + σ2 v`, `ż = v (1 − r)`, `r = σ0 z sgn(v)/μ(v)`,
//! `μ(v) = μ_k + (μ_s − μ_k) exp(−(|v|/v_s)^δ)`, `σ1(v) = σ1 exp(−(v/v_d)²)`.
//!
//! # Parameters
//! | symbol | field | unit | range |
//! |---|---|---|---|
//! | σ0 | `sigma0` | 1/m | > 0 |
//! | σ1 | `sigma1` | s/m | ≥ 0 |
//! | v_d | `v_d` | m/s | > 0, infinite: constant σ1 |
//! | σ2 | `sigma2` | N·s/m | ≥ 0 |
//! | μ_s, μ_k | `mu_s`, `mu_k` | 1 | > 0 |
//! | v_s | `v_s` | m/s | > 0 |
//! | δ | `delta` | 1 | 0 … 20 |
//!
//! # State
//! Bristle deflection `z` \[m\]; `|z| ≤ max(μ_s, μ_k)/σ0` once inside.
//!
//! # Limits
//! μ_s = μ_k, σ1 = σ2 = 0: Dahl with exponent 1. σ0 → ∞: Stribeck. Steady slip: `F = μ(v) N sgn v + σ2 v`. At constant
//! velocity `z = z_s + (z_0 − z_s) exp(−σ0 |v| t/μ)`.
//!
//! # Energy per cycle
//! No closed form; Dahl's at the limit above. The map from `v` to `F` is passive when
//! `σ2 > σ1 N (μ_s − μ_k)/μ_k` (constant σ1), or for `v_d < 4 √(2e) μ_k/σ1`.
//!
//! # What it cannot show
//! Purely elastic presliding: it drifts under a small oscillating force with a bias. Its breakaway force depends on
//! the rate of loading whether the contact's does or not.
//!
//! # References
//! C. Canudas de Wit, H. Olsson, K. J. Åström, P. Lischinsky, IEEE Trans. Automatic Control 40 (1995) 419,
//! doi 10.1109/9.376053; K. J. Åström, C. Canudas de Wit, IEEE Control Systems 28(6) (2008) 101.
//!
//! # Example
//! ```
//! use frettrace_friction::{FrictionLaw, Step, laws::Lugre};
//! let law = Lugre {
//!     sigma0: 1e5, sigma1: 300.0, v_d: f64::INFINITY, sigma2: 0.4, mu_s: 1.5, mu_k: 1.0, v_s: 1e-3, delta: 2.0,
//! };
//! let step = Step { slip: [0.0, 1e-3], velocity: [2e-3; 2], normal: [1.0; 2], dt: 0.5 };
//! let steady = 1.0 + 0.5 * (-4.0_f64).exp() + 0.4 * 2e-3;
//! assert!((law.step(law.rest(), &step).1 - steady).abs() < 1e-14);
//! ```

use std::ops::ControlFlow;

use crate::parameter::{DELTA, MU_K, MU_S, Parameter, SIGMA0, SIGMA1, SIGMA2, V_D, V_S};
use crate::{Bristle, Claims, FrictionLaw, Saturation, Scalar, Steady, Step, Stretch};

/// Parameters of the LuGre law.
#[derive(Clone, Copy, Debug)]
pub struct Lugre<T> {
    /// Bristle stiffness per newton of normal force (1/m).
    pub sigma0: T,
    /// Presliding damping per newton of normal force (s/m).
    pub sigma1: T,
    /// Velocity above which presliding damping dies (m/s).
    pub v_d: T,
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
}

/// The parameters in order.
pub(crate) const PARAMETERS: &[Parameter] = &[SIGMA0, SIGMA1, V_D, SIGMA2, MU_S, MU_K, V_S, DELTA];

/// What the law promises.
pub(crate) const CLAIMS: Claims = Claims::PASSIVE;

impl<T: Scalar> Lugre<T> {
    pub(crate) fn from_values([sigma0, sigma1, v_d, sigma2, mu_s, mu_k, v_s, delta]: [T; 8]) -> Self {
        Self { sigma0, sigma1, v_d, sigma2, mu_s, mu_k, v_s, delta }
    }

    pub(crate) fn values(&self) -> [T; 8] {
        [self.sigma0, self.sigma1, self.v_d, self.sigma2, self.mu_s, self.mu_k, self.v_s, self.delta]
    }

    /// The law as a member of the bristle family.
    #[inline]
    pub fn bristle(&self) -> Bristle<T> {
        Bristle {
            sigma1: self.sigma1,
            v_d: self.v_d,
            sigma2: self.sigma2,
            mu_s: self.mu_s,
            v_s: self.v_s,
            delta: self.delta,
            saturation: Saturation::Linear,
            steady: Steady::Stribeck,
            ..Bristle::plain(self.sigma0, self.mu_k)
        }
    }
}

impl<T: Scalar> FrictionLaw<T> for Lugre<T> {
    type State = [T; 1];

    fn rest(&self) -> [T; 1] {
        [T::from(0.0)]
    }

    #[inline]
    fn step(&self, state: [T; 1], step: &Step<T>) -> ([T; 1], T) {
        self.bristle().step(state, step)
    }

    #[inline]
    fn follow(
        &self,
        state: [T; 1],
        stretch: &Stretch<'_, T>,
        record: impl FnMut(usize, [T; 1], T) -> ControlFlow<()>,
    ) -> [T; 1] {
        self.bristle().follow(state, stretch, record)
    }
}
