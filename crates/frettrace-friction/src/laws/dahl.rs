//! Dahl: a bristle that bends elastically at first and saturates at the friction coefficient.
//!
//! # Equation
//! `F_t = N⁺ σ0 z`, `ż = v · sgn(1 − r)|1 − r|^i`, `r = σ0 z sgn(v)/μ_k`.
//!
//! # Parameters
//! | symbol | field | unit | range |
//! |---|---|---|---|
//! | σ0 | `sigma0` | 1/m | > 0 |
//! | μ_k | `mu_k` | 1 | > 0 |
//! | i | `exponent` | 1 | 0 … 20; 1 is Dahl's own choice, 1/3 Mindlin's partial slip |
//!
//! # State
//! Bristle deflection `z` \[m\].
//!
//! # Limits
//! σ0 → ∞: Coulomb. i = 0: Jenkins. i = 1: LuGre without damping and with μ_s = μ_k. From rest, with
//! `ξ = σ0 x/μ_k`: `F/(μ_k N) = 1 − e^{−ξ}` (i = 1), else `1 − [1 + (i − 1) ξ]^{−1/(i − 1)}`, which for i < 1 is full at
//! `ξ = 1/(1 − i)`.
//!
//! # Energy per cycle
//! i = 1, amplitude `A`, `a = σ0 A/μ_k`: tip force `μ_k N tanh a`, energy `4 (μ_k² N/σ0)(a − tanh a)`. Any i, by the tip
//! force `t μ_k N`: `a = [(1 + t)^{1−i} − (1 − t)^{1−i}]/(2(1 − i))` and
//! `(μ_k² N/σ0) {4a − 2[(1 + t)^{2−i} − (1 − t)^{2−i}]/(2 − i)}`, with `ln((1 + t)/(1 − t))` for the quotient whose power is 0;
//! for i < 1 and t = 1, `4 μ_k N` for each metre more.
//!
//! # What it cannot show
//! Stiction peak, Stribeck effect, any dependence on velocity. Minor loops do not close and the bristle drifts under a
//! biased small force. σ0 is identifiable only while `a` is below about 3.
//!
//! # References
//! P. R. Dahl, A solid friction model, TOR-158 (1968); AIAA J. 14 (1976) 1675, doi 10.2514/3.61511.
//!
//! # Example
//! ```
//! use frettrace_friction::{FrictionLaw, Step, laws::Dahl};
//! let law = Dahl { sigma0: 1e6, mu_k: 0.5, exponent: 1.0 };
//! let step = Step { slip: [0.0, 1e-6], velocity: [1e-3; 2], normal: [1.0; 2], dt: 1e-3 };
//! let virgin = 0.5 * (1.0 - (-2.0_f64).exp());
//! assert!((law.step(law.rest(), &step).1 - virgin).abs() < 1e-15);
//! ```

use crate::parameter::{EXPONENT, MU_K, Parameter, SIGMA0};
use crate::{Bristle, Claims, FrictionLaw, Saturation, Scalar, Step};

/// Parameters of the Dahl law.
#[derive(Clone, Copy, Debug)]
pub struct Dahl<T> {
    /// Bristle stiffness per newton of normal force (1/m).
    pub sigma0: T,
    /// Friction coefficient.
    pub mu_k: T,
    /// Exponent i.
    pub exponent: T,
}

/// The parameters in order.
pub(crate) const PARAMETERS: &[Parameter] = &[SIGMA0, MU_K, EXPONENT];

/// What the law promises.
pub(crate) const CLAIMS: Claims = Claims::RATE_INDEPENDENT;

impl<T: Scalar> Dahl<T> {
    pub(crate) fn from_values([sigma0, mu_k, exponent]: [T; 3]) -> Self {
        Self { sigma0, mu_k, exponent }
    }

    pub(crate) fn values(&self) -> [T; 3] {
        [self.sigma0, self.mu_k, self.exponent]
    }

    /// The law as a member of the bristle family.
    #[inline]
    pub fn bristle(&self) -> Bristle<T> {
        let plain = Bristle::plain(self.sigma0, self.mu_k);
        Bristle { exponent: self.exponent, saturation: Saturation::Power, ..plain }
    }
}

impl<T: Scalar> FrictionLaw<T> for Dahl<T> {
    type State = [T; 1];

    fn rest(&self) -> [T; 1] {
        [T::from(0.0)]
    }

    #[inline]
    fn step(&self, state: [T; 1], step: &Step<T>) -> ([T; 1], T) {
        self.bristle().step(state, step)
    }
}
