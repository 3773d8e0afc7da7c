//! Cattaneo-Mindlin: partial slip of a sphere on a flat under constant normal force, exactly.
//!
//! # Equation
//! Virgin curve `F_t = μ_k N⁺ [1 − (1 − u/u_s)^{3/2}]` up to `u_s`, `μ_k N⁺` beyond; branches by Masing's rule.
//! `u_s = 3 μ_k N/(16 G* a)`, `G* = G/(2(2 − ν))` for like materials, `a` the radius of contact.
//!
//! # Parameters
//! | symbol | field | unit | range |
//! |---|---|---|---|
//! | μ_k | `mu_k` | 1 | > 0 |
//! | u_s | `slip_distance` | m | > 0, travel to gross slip |
//!
//! # State
//! Slip, force per newton and up to six turning points.
//!
//! # Limits
//! u_s → 0: Coulomb. The virgin curve is Dahl's with exponent 1/3 and `σ0 = 3 μ_k/(2 u_s)`; the branches are not.
//!
//! # Energy per cycle
//! With `τ` = force amplitude over μ_k N and `p = 1 − τ`: `4.8 μ_k N u_s {1 − p^{5/3} − (5τ/6)(1 + p^{2/3})}`; for small
//! τ `(4/27) μ_k N u_s τ³`; beyond u_s, `0.8 μ_k N u_s + 4 μ_k N (A − u_s)`.
//!
//! # What it cannot show
//! Stribeck effect, dependence on velocity. A varying normal force scales the whole loop; the true contact remembers
//! the annuli of stick it had (Mindlin and Deresiewicz 1953), which this law does not.
//!
//! # References
//! C. Cattaneo, Rend. Accad. Lincei 27 (1938); R. D. Mindlin, J. Appl. Mech. 16 (1949) 259; K. L. Johnson, Contact
//! Mechanics (1985), section 7.4.
//!
//! # Example
//! ```
//! use frettrace_friction::{FrictionLaw, Step, laws::CattaneoMindlin};
//! let law: CattaneoMindlin<f64> = CattaneoMindlin { mu_k: 0.2, slip_distance: 2e-6 };
//! let step = Step { slip: [0.0, 1.5e-6], velocity: [1.5e-6; 2], normal: [100.0; 2], dt: 1.0 };
//! assert!((law.step(law.rest(), &step).1 - 20.0 * 0.875).abs() < 1e-12); // 1 − (1/4)^{3/2} = 7/8
//! ```

use crate::masing::{self, Memory};
use crate::parameter::{MU_K, Parameter, Range};
use crate::{Claims, FrictionLaw, Scalar, Step, positive_part};

/// Parameters of the Cattaneo-Mindlin law.
#[derive(Clone, Copy, Debug)]
pub struct CattaneoMindlin<T> {
    /// Friction coefficient.
    pub mu_k: T,
    /// Travel to gross slip \[m\].
    pub slip_distance: T,
}

/// The parameters in order.
pub(crate) const PARAMETERS: &[Parameter] =
    &[MU_K, Parameter::new("slip_distance", "m", Range::POSITIVE, 1e-6)];

/// What the law promises.
pub(crate) const CLAIMS: Claims = Claims::MASING;

impl<T: Scalar> CattaneoMindlin<T> {
    pub(crate) fn from_values([mu_k, slip_distance]: [T; 2]) -> Self {
        Self { mu_k, slip_distance }
    }

    pub(crate) fn values(&self) -> [T; 2] {
        [self.mu_k, self.slip_distance]
    }

    /// Virgin curve per newton of normal force, for slips ≥ 0.
    pub fn backbone(&self, slip: T) -> T {
        let rest = -slip / self.slip_distance + 1.0;
        if rest.re() <= 0.0 { self.mu_k } else { self.mu_k * (-(rest * rest.sqrt()) + 1.0) }
    }
}

impl<T: Scalar> FrictionLaw<T> for CattaneoMindlin<T> {
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
