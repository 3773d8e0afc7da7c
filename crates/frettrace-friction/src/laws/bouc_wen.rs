//! Bouc-Wen: a hysteresis whose loading and unloading branches are bent separately.
//!
//! # Equation
//! `F_t = N⁺ σ0 z`, `ż = v − β |v| |r|^{n−1} r − (1 − β) v |r|^n`, `r = σ0 z/μ_k`.
//!
//! # Parameters
//! | symbol | field | unit | range |
//! |---|---|---|---|
//! | σ0 | `sigma0` | 1/m | > 0 |
//! | μ_k | `mu_k` | 1 | > 0, saturation |
//! | n | `sharpness` | 1 | ≥ 1 |
//! | β | `beta` | 1 | 1/2 … 3, at 1/2 unloading is elastic |
//!
//! # State
//! Deflection `z` \[m\]; in the usual notation A = 1, β' = β (σ0/μ_k)^n, γ' = (1 − β)(σ0/μ_k)^n.
//!
//! # Limits
//! n = 1, β = 1: Dahl with exponent 1. n → ∞ (β = 1/2): Jenkins. σ0 → ∞: Coulomb.
//!
//! # Energy per cycle
//! n = 1, with `c = 2β − 1`, `a = σ0 A/μ_k` and the tip force `t μ_k N`: `2a = ln(1 + ct)/c − ln(1 − t)`, energy
//! `2 (μ_k² N/σ0) [ln(1 + ct)/c² − t/c − ln(1 − t) − t]`, which is Dahl's for β = 1. Else by quadrature.
//!
//! # What it cannot show
//! Stribeck effect, any dependence on velocity. Not every parameter set dissipates: β ≥ 1/2 does.
//!
//! # References
//! R. Bouc (1967); Y.-K. Wen, J. Eng. Mech. Div. ASCE 102 (1976) 249; F. Ikhouane, J. Rodellar, Systems with Hysteresis
//! (2007).
//!
//! # Example
//! ```
//! use frettrace_friction::{FrictionLaw, Step, laws::BoucWen};
//! let law: BoucWen<f64> = BoucWen { sigma0: 1e6, mu_k: 0.5, sharpness: 2.0, beta: 0.5 };
//! let step = Step { slip: [0.0, 5e-7], velocity: [1e-3; 2], normal: [1.0; 2], dt: 5e-4 };
//! // From rest dr/dx = 1 − r²: r = tanh x.
//! assert!((law.step(law.rest(), &step).1 - 0.5 * 1.0_f64.tanh()).abs() < 1e-6);
//! ```

use nalgebra::SVector;
use num_dual::{Derivative, DualSVec64};

use crate::parameter::{MU_K, Parameter, Range, SIGMA0};
use crate::{Claims, FrictionLaw, Scalar, Step, lift, positive_part};

/// Parameters of the Bouc-Wen law.
#[derive(Clone, Copy, Debug)]
pub struct BoucWen<T> {
    /// Initial stiffness per newton of normal force (1/m).
    pub sigma0: T,
    /// Friction coefficient.
    pub mu_k: T,
    /// Sharpness n of the transition.
    pub sharpness: T,
    /// Share β that depends on the sense of loading.
    pub beta: T,
}

/// The parameters in order.
pub(crate) const PARAMETERS: &[Parameter] = &[
    SIGMA0,
    MU_K,
    Parameter::new("sharpness", "1", Range::half_open(1.0, 50.0), 1.5),
    Parameter::new("beta", "1", Range { high_allowed: true, ..Range::half_open(0.5, 3.0) }, 0.7),
];

/// What the law promises.
pub(crate) const CLAIMS: Claims = Claims::RATE_INDEPENDENT;

/// Relaxation lengths in one Runge-Kutta step, and those after which the start is forgotten.
const STRIDE: f64 = 0.1;
const FORGOTTEN: f64 = 40.0;

impl<T: Scalar> BoucWen<T> {
    pub(crate) fn from_values([sigma0, mu_k, sharpness, beta]: [T; 4]) -> Self {
        Self { sigma0, mu_k, sharpness, beta }
    }

    pub(crate) fn values(&self) -> [T; 4] {
        [self.sigma0, self.mu_k, self.sharpness, self.beta]
    }

    fn flow(&self, r: T, x: T) -> T {
        let arguments = [r, x, self.sharpness, self.beta];
        if T::NDERIV == 0 {
            return T::from(saturate(arguments.map(|argument| argument.re())));
        }
        let seeds: [DualSVec64<4>; 4] =
            std::array::from_fn(|index| DualSVec64::from_re(arguments[index].re()).derivative(index));
        let DualSVec64 { re, eps: Derivative(slopes, ..) } = saturate(seeds);
        let slopes: SVector<f64, 4> = slopes.unwrap_or_else(SVector::zeros);
        lift(re, std::array::from_fn(|index| slopes[index]), arguments)
    }
}

/// `dr/dx = 1 − |r|^n (β sgn(r) + 1 − β)`, loading positive, by Runge-Kutta of order four.
fn saturate<D: Scalar>([mut r, x, n, beta]: [D; 4]) -> D {
    let slope = |r: D| {
        let bend = if r.re() < 0.0 { -beta * 2.0 + 1.0 } else { D::from(1.0) };
        let size = if r.re() < 0.0 { -r } else { r };
        if size.re() == 0.0 { D::from(1.0) } else { -(bend * size.powd(n)) + 1.0 }
    };
    let bound = n.re() * (2.0 * beta.re() - 1.0).abs().max(1.0);
    let mut left = x;
    if left.re() > FORGOTTEN {
        (r, left) = (D::from(1.0), D::from(0.0));
    }
    let stride = STRIDE / bound;
    while left.re() > 0.0 {
        let step = if left.re() > stride { D::from(stride) } else { left };
        let k1 = slope(r);
        let k2 = slope(r + step * k1 * 0.5);
        let k3 = slope(r + step * k2 * 0.5);
        let k4 = slope(r + step * k3);
        r += step * (k1 + (k2 + k3) * 2.0 + k4) * (1.0 / 6.0);
        left = if left.re() > stride { left - stride } else { D::from(0.0) };
    }
    r
}

impl<T: Scalar> FrictionLaw<T> for BoucWen<T> {
    type State = [T; 1];

    fn rest(&self) -> [T; 1] {
        [T::from(0.0)]
    }

    #[inline]
    fn step(&self, state: [T; 1], step: &Step<T>) -> ([T; 1], T) {
        let (first, second) = step.strokes();
        let scale = self.sigma0 / self.mu_k;
        let mut r = state[0] * scale;
        for stroke in [Some(first), second].into_iter().flatten() {
            r = self.flow(r * stroke.direction, stroke.travel * stroke.direction * scale) * stroke.direction;
        }
        let z = r / scale;
        ([z], positive_part(step.normal[1]) * self.sigma0 * z)
    }
}
