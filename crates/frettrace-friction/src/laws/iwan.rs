//! Iwan in Segalman's four parameters: Jenkins elements in parallel with a power-law distribution of strengths.
//!
//! # Equation
//! Virgin curve per newton of normal force, `u < φ_max`: `f = σ0 u − R u^{χ+2}/((χ+1)(χ+2))`, `μ_k` beyond, with
//! `φ_max = μ_k (1 + β)/(σ0 (β + (χ+1)/(χ+2)))` and `R = μ_k (χ+1)/(φ_max^{χ+2} (β + (χ+1)/(χ+2)))`; branches by Masing's
//! rule; `F_t = N⁺ f`.
//!
//! # Parameters
//! | symbol | field | unit | range |
//! |---|---|---|---|
//! | σ0 | `sigma0` | 1/m | > 0, stiffness K_T = σ0 N |
//! | μ_k | `mu_k` | 1 | > 0, F_S = μ_k N |
//! | χ | `chi` | 1 | −1 < χ ≤ 2, slope of log dissipation over log amplitude is χ + 3 |
//! | β | `beta` | 1 | ≥ 0, share of the elements that slip last, at once |
//!
//! # State
//! Slip, force per newton and up to six turning points: the exact hysteresis, no sum over sliders.
//!
//! # Limits
//! β → ∞: Jenkins with k_t = σ0 N. χ → −1: the weak elements have no strength left, Jenkins with k_t = σ0 N β/(1 + β).
//! σ0 → ∞: Coulomb.
//!
//! # Energy per cycle
//! `4 N R A^{χ+3}/((χ+2)(χ+3))` for `A < φ_max`; beyond, `4 μ_k N (A − φ_max)` more.
//!
//! # What it cannot show
//! Stribeck effect, any dependence on velocity. The stiffness follows the normal force.
//!
//! # References
//! D. J. Segalman, J. Appl. Mech. 72 (2005) 752, doi 10.1115/1.1989354; W. D. Iwan, J. Appl. Mech. 33 (1966) 893.
//!
//! # Example
//! ```
//! use frettrace_friction::{FrictionLaw, Step, laws::Iwan};
//! let law: Iwan<f64> = Iwan { sigma0: 2.0, mu_k: 3.0, chi: -0.1, beta: 0.1 };
//! let half = 0.5 * 2.876146789; // half of φ_max
//! let step = Step { slip: [0.0, half], velocity: [half; 2], normal: [1.0; 2], dt: 1.0 };
//! assert!((law.step(law.rest(), &step).1 - 2.138687984).abs() < 1e-8);
//! ```

use crate::masing::{self, Memory};
use crate::parameter::{MU_K, Parameter, Range, SIGMA0};
use crate::{Claims, FrictionLaw, Scalar, Step, positive_part};

/// Parameters of the four-parameter Iwan law.
#[derive(Clone, Copy, Debug)]
pub struct Iwan<T> {
    /// Stiffness per newton of normal force (1/m).
    pub sigma0: T,
    /// Friction coefficient.
    pub mu_k: T,
    /// Exponent χ of the distribution.
    pub chi: T,
    /// Share β of the last elements.
    pub beta: T,
}

/// The parameters in order.
pub(crate) const PARAMETERS: &[Parameter] = &[
    SIGMA0,
    MU_K,
    Parameter::new("chi", "1", Range { low: -1.0, low_allowed: false, high: 2.0, high_allowed: true }, -0.5),
    Parameter::new("beta", "1", Range::NOT_NEGATIVE, 0.5),
];

/// What the law promises.
pub(crate) const CLAIMS: Claims = Claims::MASING;

impl<T: Scalar> Iwan<T> {
    pub(crate) fn from_values([sigma0, mu_k, chi, beta]: [T; 4]) -> Self {
        Self { sigma0, mu_k, chi, beta }
    }

    pub(crate) fn values(&self) -> [T; 4] {
        [self.sigma0, self.mu_k, self.chi, self.beta]
    }

    /// Slip φ_max \[m\] at which the last element slips.
    pub fn full_slip(&self) -> T {
        self.mu_k * (self.beta + 1.0) / (self.sigma0 * (self.beta + (self.chi + 1.0) / (self.chi + 2.0)))
    }

    /// Virgin curve per newton of normal force, for slips ≥ 0. In units of φ_max the power term is
    /// `μ_k s^{χ+2}/((χ+2)(β + (χ+1)/(χ+2)))`.
    pub fn backbone(&self, slip: T) -> T {
        let ratio = slip / self.full_slip();
        if ratio.re() >= 1.0 {
            return self.mu_k;
        }
        if ratio.re() <= 0.0 {
            return self.sigma0 * slip;
        }
        let power = ratio.powd(self.chi + 2.0);
        let share = (self.beta + (self.chi + 1.0) / (self.chi + 2.0)) * (self.chi + 2.0);
        self.sigma0 * slip - self.mu_k * power / share
    }
}

impl<T: Scalar> FrictionLaw<T> for Iwan<T> {
    type State = Memory<T>;

    fn rest(&self) -> Memory<T> {
        masing::virgin()
    }

    #[inline]
    fn step(&self, state: Memory<T>, step: &Step<T>) -> (Memory<T>, T) {
        let (first, second) = step.strokes();
        let backbone = |slip| self.backbone(slip);
        let mut memory = masing::advance(state, &first, backbone);
        if let Some(stroke) = second {
            memory = masing::advance(memory, &stroke, backbone);
        }
        (memory, positive_part(step.normal[1]) * masing::force(&memory))
    }
}
