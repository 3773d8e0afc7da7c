//! Generalised Maxwell-slip: Maxwell-slip elements whose slip follows the Stribeck curve with a lag.
//!
//! # Equation
//! Element i sticks, `dp_i = k_i du`, until `|p_i| = α_i μ(v)`; then slips, `dp_i/dt = sgn(v) C (α_i − |p_i|/μ(v))`, until
//! the velocity reverses. `F_t = N⁺ Σ p_i + σ2 v`, `α_i = w_i/Σ w`, μ(v) as in LuGre.
//!
//! # Parameters
//! | symbol | field | unit | range |
//! |---|---|---|---|
//! | k_i | `stiffness` | 1/m | > 0, per newton of normal force |
//! | w_i | `weight` | 1 | > 0 |
//! | C | `attraction` | 1/s | > 0 |
//! | σ2 | `sigma2` | N·s/m | ≥ 0 |
//! | μ_s, μ_k | `mu_s`, `mu_k` | 1 | > 0 |
//! | v_s | `v_s` | m/s | > 0 |
//! | δ | `delta` | 1 | 0 … 20 |
//!
//! # State
//! For each element its force per newton and the sense in which it slips (0: it sticks).
//!
//! # Limits
//! μ_s = μ_k and σ2 = 0: Maxwell-slip. C → ∞: no lag. Steady slip: `μ(v) N sgn v + σ2 v`.
//!
//! # Energy per cycle
//! No closed form but Maxwell-slip's at that limit.
//!
//! # What it cannot show
//! A breakaway force that depends on the rate of loading otherwise than through C.
//!
//! # References
//! F. Al-Bender, V. Lampaert, J. Swevers, IEEE Trans. Automatic Control 50 (2005) 1883, doi 10.1109/TAC.2005.858676.
//! Equations from general knowledge, elements compared with the weighted level.
//!
//! # Example
//! ```
//! use frettrace_friction::{FrictionLaw, Step, laws::Gms};
//! let law: Gms<f64> = Gms {
//!     stiffness: [1e5; 4], weight: [0.1, 0.2, 0.3, 0.4], attraction: 1e4, sigma2: 0.0,
//!     mu_s: 0.5, mu_k: 0.3, v_s: 1e-3, delta: 2.0,
//! };
//! let step = Step { slip: [0.0, 1e-2], velocity: [1e-2; 2], normal: [1.0; 2], dt: 1.0 };
//! assert!((law.step(law.rest(), &step).1 - 0.3).abs() < 1e-12); // fast slip
//! ```

use crate::bristle::stribeck;
use crate::parameter::{DELTA, MU_K, MU_S, Parameter, Range, SIGMA2, V_S};
use crate::{Claims, FrictionLaw, Scalar, Step, Stroke, positive_part};

const ELEMENTS: usize = 4;

/// Parameters of the generalised Maxwell-slip law.
#[derive(Clone, Copy, Debug)]
pub struct Gms<T> {
    /// Stiffness of each element per newton of normal force (1/m).
    pub stiffness: [T; ELEMENTS],
    /// Weight of each element; only their ratios count.
    pub weight: [T; ELEMENTS],
    /// Attraction to the Stribeck curve in slip [1/s].
    pub attraction: T,
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
pub(crate) const PARAMETERS: &[Parameter] = &[
    Parameter::new("stiffness_1", "1/m", Range::POSITIVE, 1e5),
    Parameter::new("stiffness_2", "1/m", Range::POSITIVE, 1e5),
    Parameter::new("stiffness_3", "1/m", Range::POSITIVE, 1e5),
    Parameter::new("stiffness_4", "1/m", Range::POSITIVE, 1e5),
    Parameter::new("weight_1", "1", Range::POSITIVE, 0.1),
    Parameter::new("weight_2", "1", Range::POSITIVE, 0.2),
    Parameter::new("weight_3", "1", Range::POSITIVE, 0.3),
    Parameter::new("weight_4", "1", Range::POSITIVE, 0.4),
    Parameter::new("attraction", "1/s", Range::POSITIVE, 5e3),
    SIGMA2,
    MU_S,
    MU_K,
    V_S,
    DELTA,
];

/// What the law promises.
pub(crate) const CLAIMS: Claims = Claims::PASSIVE;

impl<T: Scalar> Gms<T> {
    pub(crate) fn from_values(values: [T; 14]) -> Self {
        let [k1, k2, k3, k4, w1, w2, w3, w4, attraction, sigma2, mu_s, mu_k, v_s, delta] = values;
        let (stiffness, weight) = ([k1, k2, k3, k4], [w1, w2, w3, w4]);
        Self { stiffness, weight, attraction, sigma2, mu_s, mu_k, v_s, delta }
    }

    pub(crate) fn values(&self) -> [T; 14] {
        let ([k1, k2, k3, k4], [w1, w2, w3, w4]) = (self.stiffness, self.weight);
        let Self { attraction, sigma2, mu_s, mu_k, v_s, delta, .. } = *self;
        [k1, k2, k3, k4, w1, w2, w3, w4, attraction, sigma2, mu_s, mu_k, v_s, delta]
    }

    /// One element along one stroke. It sticks until its force meets the level α μ(v), at a moment found on the stroke's
    /// velocity parabola; from there it relaxes to the level over `μ/(α C)` of its own level.
    fn element(&self, index: usize, [force, slipping]: [T; 2], stroke: &Stroke<T>) -> [T; 2] {
        let total = self.weight.iter().fold(T::from(0.0), |sum, weight| sum + *weight);
        let share = self.weight[index] / total * stroke.direction;
        let level = |velocity: T| share * self.coefficient(velocity);
        let sense = T::from(stroke.direction);
        if slipping.re() == stroke.direction {
            return [self.relax(force, [level(stroke.velocity[0]), T::from(1.0)], share, stroke), sense];
        }
        let path = Path::new(stroke);
        let elastic = |moment: T| force + self.stiffness[index] * path.travel(moment);
        let excess = |moment: T| (elastic(moment) - level(path.velocity(moment))) * stroke.direction;
        if excess(T::from(1.0)).re() < 0.0 {
            return [force + self.stiffness[index] * stroke.travel, T::from(0.0)];
        }
        let broken = breaking_moment(&excess);
        let start = level(path.velocity(broken));
        [self.relax(start, [start, -broken + 1.0], share, stroke), sense]
    }

    #[inline(always)]
    fn coefficient(&self, velocity: T) -> T {
        stribeck(velocity, [self.mu_s, self.mu_k, self.v_s, self.delta])
    }

    /// The force after slipping over the last `rest` of a stroke, on a level that moves evenly from `start`.
    fn relax(&self, force: T, [start, rest]: [T; 2], share: T, stroke: &Stroke<T>) -> T {
        let level = share * self.coefficient(stroke.velocity[2]);
        let mean = (level + start) / share * 0.5;
        let length = self.attraction * stroke.duration * rest / mean;
        let decay = (-length).exp();
        let slope = if length.re() == 0.0 { T::from(1.0) } else { -(-length).exp_m1() / length };
        level + (force - start) * decay - (level - start) * slope
    }
}

/// Velocity and travel within a stroke, on the parabola through its three velocities.
struct Path<T> {
    start: T,
    lean: T,
    bend: T,
    duration: T,
}

impl<T: Scalar> Path<T> {
    fn new(stroke: &Stroke<T>) -> Self {
        let [v0, v1, v2] = stroke.velocity;
        let (lean, bend) = (v1 * 4.0 - v0 * 3.0 - v2, (v0 + v2 - v1 * 2.0) * 2.0);
        Self { start: v0, lean, bend, duration: stroke.duration }
    }

    fn velocity(&self, moment: T) -> T {
        self.start + moment * (self.lean + moment * self.bend)
    }

    fn travel(&self, moment: T) -> T {
        self.duration * moment * (self.start + moment * (self.lean * 0.5 + moment * self.bend * (1.0 / 3.0)))
    }
}

/// Halvings of a stroke in search of the moment of breaking: to rounding.
const HALVINGS: usize = 50;

/// The moment at which `excess` turns positive, 0 if it is so from the start; its derivatives by one Newton step.
fn breaking_moment<T: Scalar>(excess: &impl Fn(T) -> T) -> T {
    if excess(T::from(0.0)).re() >= 0.0 {
        return T::from(0.0);
    }
    let (mut before, mut after) = (0.0, 1.0);
    for _ in 0..HALVINGS {
        let middle = 0.5 * (before + after);
        if excess(T::from(middle)).re() < 0.0 { before = middle } else { after = middle }
    }
    let residual = excess(T::from(after));
    if T::NDERIV == 0 {
        return T::from(after);
    }
    let (below, above) = ((after - DIFFERENCE).max(0.0), (after + DIFFERENCE).min(1.0));
    let slope = (excess(T::from(above)).re() - excess(T::from(below)).re()) / (above - below);
    -(residual - residual.re()) / slope + after
}

/// Step of the difference that gives the slope at the moment of breaking: the cube root of rounding.
const DIFFERENCE: f64 = 6e-6;

impl<T: Scalar> FrictionLaw<T> for Gms<T> {
    type State = [T; 2 * ELEMENTS];

    fn rest(&self) -> Self::State {
        [T::from(0.0); 2 * ELEMENTS]
    }

    #[inline]
    fn step(&self, mut state: Self::State, step: &Step<T>) -> (Self::State, T) {
        let (first, second) = step.strokes();
        let mut force = T::from(0.0);
        for index in 0..ELEMENTS {
            let mut element = self.element(index, [state[2 * index], state[2 * index + 1]], &first);
            if let Some(stroke) = second {
                element = self.element(index, element, &stroke);
            }
            [state[2 * index], state[2 * index + 1]] = element;
            force += element[0];
        }
        (state, positive_part(step.normal[1]) * force + self.sigma2 * step.velocity[1])
    }
}
