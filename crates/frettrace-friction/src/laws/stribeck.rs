//! Stribeck: Coulomb with a friction coefficient that falls from rest to fast slip, and viscous drag.
//!
//! # Equation
//! `F_t = μ(v) N⁺ sgn(v) + σ2 v`, `μ(v) = μ_k + (μ_s − μ_k) exp(−(|v|/v_s)^δ)`.
//!
//! # Parameters
//! | symbol | field | unit | range |
//! |---|---|---|---|
//! | μ_s | `mu_s` | 1 | > 0 |
//! | μ_k | `mu_k` | 1 | > 0 |
//! | v_s | `v_s` | m/s | > 0 |
//! | δ | `delta` | 1 | 0 … 20 |
//! | σ2 | `sigma2` | N·s/m | ≥ 0 |
//!
//! # State
//! None.
//!
//! # Limits
//! μ_s = μ_k, σ2 = 0: Coulomb. v_s → 0: Coulomb with a higher force at rest only. The limit σ0 → ∞ of LuGre.
//!
//! # Energy per cycle
//! `∮ (μ(v) N |v| + σ2 v²) dt`. For harmonic slip and δ = 2, with `w = ω A/v_s` and Dawson's integral `D`:
//! `4 N A [μ_k + (μ_s − μ_k) D(w)/w] + π σ2 ω A²`. For any δ the dry part lies between `4 min(μ_k, μ_s) N A` and
//! `4 max(μ_k, μ_s) N A`.
//!
//! # What it cannot show
//! Elastic presliding; lag of friction behind velocity; a breakaway force that depends on the rate of loading.
//!
//! # References
//! R. Stribeck, VDI-Z. 46 (1902); K. J. Åström, C. Canudas de Wit, IEEE Control Systems 28(6) (2008) 101,
//! doi 10.1109/MCS.2008.929425.
//!
//! # Example
//! ```
//! use frettrace_friction::{FrictionLaw, Step, laws::Stribeck};
//! let law = Stribeck { mu_s: 0.5, mu_k: 0.3, v_s: 1e-3, delta: 2.0, sigma2: 0.0 };
//! let step = Step { slip: [0.0, 1e-6], velocity: [1e-3; 2], normal: [1.0; 2], dt: 1e-3 };
//! let at_v_s = 0.3 + 0.2 * (-1.0_f64).exp();
//! assert!((law.step([], &step).1 - at_v_s).abs() < 1e-15);
//! ```

use crate::bristle::stribeck;
use crate::laws::coulomb::sense;
use crate::parameter::{DELTA, MU_K, MU_S, Parameter, SIGMA2, V_S};
use crate::{Claims, FrictionLaw, Scalar, Step, positive_part};

/// Parameters of the Stribeck law.
#[derive(Clone, Copy, Debug)]
pub struct Stribeck<T> {
    /// Friction coefficient at rest.
    pub mu_s: T,
    /// Friction coefficient of fast slip.
    pub mu_k: T,
    /// Stribeck velocity (m/s).
    pub v_s: T,
    /// Stribeck exponent.
    pub delta: T,
    /// Viscous damping (N·s/m).
    pub sigma2: T,
}

/// The parameters in order.
pub(crate) const PARAMETERS: &[Parameter] = &[MU_S, MU_K, V_S, DELTA, SIGMA2];

/// What the law promises.
pub(crate) const CLAIMS: Claims = Claims::PASSIVE;

impl<T: Scalar> Stribeck<T> {
    pub(crate) fn from_values([mu_s, mu_k, v_s, delta, sigma2]: [T; 5]) -> Self {
        Self { mu_s, mu_k, v_s, delta, sigma2 }
    }

    pub(crate) fn values(&self) -> [T; 5] {
        [self.mu_s, self.mu_k, self.v_s, self.delta, self.sigma2]
    }

    /// The steady friction coefficient μ(v).
    #[inline]
    pub fn coefficient(&self, velocity: T) -> T {
        stribeck(velocity, [self.mu_s, self.mu_k, self.v_s, self.delta])
    }
}

impl<T: Scalar> FrictionLaw<T> for Stribeck<T> {
    type State = [T; 0];

    fn rest(&self) -> [T; 0] {
        []
    }

    #[inline]
    fn step(&self, state: [T; 0], step: &Step<T>) -> ([T; 0], T) {
        let velocity = step.velocity[1];
        let dry = self.coefficient(velocity) * positive_part(step.normal[1]) * sense(step);
        (state, dry + self.sigma2 * velocity)
    }

    fn at_rest(&self, _: [T; 0], step: &Step<T>) -> Option<[T; 2]> {
        let level = self.mu_s * positive_part(step.normal[1]);
        Some([-level, level])
    }
}
