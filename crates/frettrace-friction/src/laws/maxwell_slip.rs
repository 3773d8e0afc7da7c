//! Maxwell-slip: Jenkins elements in parallel, each with its own stiffness and strength.
//!
//! # Equation
//! `dp_i = k_i du` while `|p_i| < w_i`, else `p_i = ±w_i`; `F_t = N⁺ Σ p_i`.
//!
//! # Parameters
//! | symbol | field | unit | range |
//! |---|---|---|---|
//! | k_i | `stiffness` | 1/m | > 0, per newton of normal force |
//! | w_i | `limit` | 1 | > 0, share of the friction coefficient; Σ w_i = μ_k |
//!
//! # State
//! Force per newton of each element.
//!
//! # Limits
//! One element: Jenkins with k_t = k N. Many elements: any Masing curve, Iwan's among them. k_i → ∞: Coulomb.
//!
//! # Energy per cycle
//! `Σ 4 N w_i (A − w_i/k_i)` over the elements that slip.
//!
//! # What it cannot show
//! Stribeck effect, any dependence on velocity. The virgin curve is a polygon.
//!
//! # References
//! W. D. Iwan, J. Appl. Mech. 33 (1966) 893; V. Lampaert, J. Swevers, F. Al-Bender, IEEE Trans. Automatic Control 47
//! (2002) 683, doi 10.1109/9.995050.
//!
//! # Example
//! ```
//! use frettrace_friction::{FrictionLaw, Step, laws::MaxwellSlip};
//! let law = MaxwellSlip { stiffness: [1.0, 2.0], limit: [1.0, 1.0] };
//! let step = Step { slip: [0.0, 0.75], velocity: [1.0; 2], normal: [1.0; 2], dt: 0.75 };
//! assert_eq!(law.step(law.rest(), &step).1, 1.75);
//! ```

use crate::laws::jenkins::limited;
use crate::parameter::{Parameter, Range};
use crate::{Claims, FrictionLaw, Scalar, Step, positive_part};

/// Parameters of the Maxwell-slip law with `E` elements; the catalogue's has four.
#[derive(Clone, Copy, Debug)]
pub struct MaxwellSlip<T, const E: usize = 4> {
    /// Stiffness of each element per newton of normal force (1/m).
    pub stiffness: [T; E],
    /// Force of each element in slip per newton of normal force.
    pub limit: [T; E],
}

const STIFFNESSES: [Parameter; 4] = [
    Parameter::new("stiffness_1", "1/m", Range::POSITIVE, 1e5),
    Parameter::new("stiffness_2", "1/m", Range::POSITIVE, 1e5),
    Parameter::new("stiffness_3", "1/m", Range::POSITIVE, 1e5),
    Parameter::new("stiffness_4", "1/m", Range::POSITIVE, 1e5),
];

/// The parameters in order.
pub(crate) const PARAMETERS: &[Parameter] = &[
    STIFFNESSES[0],
    STIFFNESSES[1],
    STIFFNESSES[2],
    STIFFNESSES[3],
    Parameter::new("limit_1", "1", Range::POSITIVE, 0.05),
    Parameter::new("limit_2", "1", Range::POSITIVE, 0.08),
    Parameter::new("limit_3", "1", Range::POSITIVE, 0.12),
    Parameter::new("limit_4", "1", Range::POSITIVE, 0.2),
];

/// What the law promises.
pub(crate) const CLAIMS: Claims = Claims::MASING;

impl<T: Scalar> MaxwellSlip<T, 4> {
    pub(crate) fn from_values([k1, k2, k3, k4, w1, w2, w3, w4]: [T; 8]) -> Self {
        Self { stiffness: [k1, k2, k3, k4], limit: [w1, w2, w3, w4] }
    }

    pub(crate) fn values(&self) -> [T; 8] {
        let ([k1, k2, k3, k4], [w1, w2, w3, w4]) = (self.stiffness, self.limit);
        [k1, k2, k3, k4, w1, w2, w3, w4]
    }
}

impl<T: Scalar, const E: usize> FrictionLaw<T> for MaxwellSlip<T, E> {
    type State = [T; E];

    fn rest(&self) -> [T; E] {
        [T::from(0.0); E]
    }

    #[inline]
    fn step(&self, mut state: [T; E], step: &Step<T>) -> ([T; E], T) {
        let (first, second) = step.strokes();
        let mut force = T::from(0.0);
        for (index, element) in state.iter_mut().enumerate() {
            let (k, w) = (self.stiffness[index], self.limit[index]);
            *element = limited(*element + k * first.travel, w);
            if let Some(stroke) = second {
                *element = limited(*element + k * stroke.travel, w);
            }
            force += *element;
        }
        (state, positive_part(step.normal[1]) * force)
    }
}
