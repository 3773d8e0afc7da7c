//! Hybrid spring-damper: LuGre with a truly elastic, a partial-slip and a plastic distance.
//!
//! # Equation
//! `F_t = N⁺ (σ0 z + σ1(v) ż) + σ2 v`, `ż = v (1 − α(r) r)`, `r = σ0 z sgn(v)/μ(v)`; `α = 0` for `r ≤ b`,
//! `½ [1 + sin(π (r − (1 + b)/2)/(1 − b))]` for `b < r < 1`, 1 beyond. μ(v) and σ1(v) as in LuGre. Unloading (`r < 0`)
//! is purely elastic.
//!
//! # Parameters
//! | symbol | field | unit | range |
//! |---|---|---|---|
//! | σ0 | `lugre.sigma0` | 1/m | > 0 |
//! | σ1 | `lugre.sigma1` | s/m | ≥ 0 |
//! | v_d | `lugre.v_d` | m/s | > 0, infinite: constant σ1 |
//! | σ2 | `lugre.sigma2` | N·s/m | ≥ 0 |
//! | μ_s, μ_k | `lugre.mu_s`, `lugre.mu_k` | 1 | > 0 |
//! | v_s | `lugre.v_s` | m/s | > 0 |
//! | δ | `lugre.delta` | 1 | 0 … 20 |
//! | b | `breakaway` | 1 | 0 ≤ b < 1, elastic share of the steady deflection |
//!
//! # State
//! Bristle deflection `z` \[m\]. Elastic distance `b z_ss`, partial-slip distance `(1 − b) z_ss` in `z`, plastic distance
//! slip with `ż = 0`; `z_ss = μ(v)/σ0`.
//!
//! # Limits
//! b → 1: Jenkins (with the Stribeck level). Formally b → −∞: LuGre (α = 1 everywhere). σ0 → ∞: Stribeck, and with
//! μ_s = μ_k, σ2 = 0 Coulomb.
//!
//! # Energy per cycle
//! 0 for slip amplitudes up to `b μ/σ0` (σ1 = σ2 = 0); → `4 μ N (A − μ/σ0)` for b → 1 and constant μ.
//!
//! # What it cannot show
//! Non-local memory: an inner loop does not close exactly unless it is elastic.
//!
//! # References
//! This project's reading of the hybrid model of R. Azizian and N. Mureithi, J. Pressure Vessel Technol. 136 (2014)
//! 031303, doi 10.1115/1.4025446, with the zone function of P. Dupont et al., IEEE Trans. Automatic Control 47 (2002)
//! 787, doi 10.1109/TAC.2002.1000274.
//!
//! # Example
//! ```
//! use frettrace_friction::{FrictionLaw, Step, laws::{Hybrid, Lugre}};
//! let lugre: Lugre<f64> = Lugre {
//!     sigma0: 1e6, sigma1: 0.0, v_d: 1e-3, sigma2: 0.0, mu_s: 0.5, mu_k: 0.5, v_s: 1e-3, delta: 2.0,
//! };
//! let law = Hybrid { lugre, breakaway: 0.6 };
//! let step = Step { slip: [0.0, 2.5e-7], velocity: [1e-3; 2], normal: [10.0; 2], dt: 2.5e-4 };
//! assert!((law.step(law.rest(), &step).1 - 2.5).abs() < 1e-12); // half of the steady deflection: still elastic
//! ```

use super::lugre;
use crate::parameter::{BREAKAWAY, Parameter};
use crate::{Bristle, Claims, FrictionLaw, Saturation, Scalar, Step};

use super::Lugre;

/// Parameters of the hybrid law.
#[derive(Clone, Copy, Debug)]
pub struct Hybrid<T> {
    /// What it shares with LuGre.
    pub lugre: Lugre<T>,
    /// Elastic share of the steady deflection.
    pub breakaway: T,
}

const BASE: &[Parameter] = lugre::PARAMETERS;

/// The parameters in order.
pub(crate) const PARAMETERS: &[Parameter] =
    &[BASE[0], BASE[1], BASE[2], BASE[3], BASE[4], BASE[5], BASE[6], BASE[7], BREAKAWAY];

/// What the law promises.
pub(crate) const CLAIMS: Claims = Claims::PASSIVE;

impl<T: Scalar> Hybrid<T> {
    pub(crate) fn from_values([a, b, c, d, e, f, g, h, breakaway]: [T; 9]) -> Self {
        Self { lugre: Lugre::from_values([a, b, c, d, e, f, g, h]), breakaway }
    }

    pub(crate) fn values(&self) -> [T; 9] {
        let [a, b, c, d, e, f, g, h] = self.lugre.values();
        [a, b, c, d, e, f, g, h, self.breakaway]
    }

    /// The law as a member of the bristle family.
    #[inline]
    pub fn bristle(&self) -> Bristle<T> {
        Bristle { saturation: Saturation::Breakaway, breakaway: self.breakaway, ..self.lugre.bristle() }
    }
}

impl<T: Scalar> FrictionLaw<T> for Hybrid<T> {
    type State = [T; 1];

    fn rest(&self) -> [T; 1] {
        [T::from(0.0)]
    }

    #[inline]
    fn step(&self, state: [T; 1], step: &Step<T>) -> ([T; 1], T) {
        self.bristle().step(state, step)
    }
}
