//! Modified Stribeck: the Stribeck law with film dynamics and the inertia of the fluid (Yanada-Tran).
//!
//! # Equation
//! `F_t = μ(v, h) N⁺ sgn(v) + σ2 (v + T v̇)`, film `h` and `μ(v, h)` as in [`crate::film`].
//!
//! # Parameters
//! | symbol | field | unit | range |
//! |---|---|---|---|
//! | μ_s, μ_k | `film.mu_s`, `film.mu_k` | 1 | > 0 |
//! | v_s | `film.v_s` | m/s | > 0 |
//! | δ | `film.delta` | 1 | 0 … 20 |
//! | v_b | `film.v_b` | m/s | > 0, velocity of the full film |
//! | τ | `film.tau`; in files `tau_growth`, `tau_decay`, `tau_rest` | s | > 0 |
//! | σ2 | `sigma2` | N·s/m | ≥ 0 |
//! | T | `inertia` | s | ≥ 0 |
//!
//! # State
//! Film thickness `h`, dimensionless: 0 … 1 − μ_k/μ_s.
//!
//! # Limits
//! τ → ∞ from rest, T = 0: Stribeck. τ → 0: Stribeck with `(1 − h_ss(v)) μ_s` in the place of μ_s.
//!
//! # Energy per cycle
//! No closed form but for a film that does not change, where it is Stribeck's; the inertia takes none in a closed cycle.
//!
//! # What it cannot show
//! Elastic presliding.
//!
//! # References
//! H. Yanada, Y. Sekikawa, Mechatronics 18 (2008) 330, doi 10.1016/j.mechatronics.2008.02.002; X. B. Tran, N. Hafizah,
//! H. Yanada, Mechatronics 22 (2012) 65. Equations from general knowledge.
//!
//! # Example
//! ```
//! use frettrace_friction::{FrictionLaw, Step, film::Film, laws::FilmStribeck};
//! let film = Film { mu_s: 0.5, mu_k: 0.3, v_s: 1e-3, delta: 2.0, v_b: 2e-3, tau: [1e-3, 1e-2, 1.0] };
//! let law: FilmStribeck<f64> = FilmStribeck { film, sigma2: 0.0, inertia: 0.0 };
//! let step = Step { slip: [0.0, 1e-4], velocity: [1e-3; 2], normal: [1.0; 2], dt: 0.1 };
//! let h = 0.4 * 0.25_f64.cbrt(); // (1/2)^{2/3} of the full film
//! let expected = 0.3 + (0.5 * (1.0 - h) - 0.3) * (-1.0_f64).exp();
//! assert!((law.step(law.rest(), &step).1 - expected).abs() < 1e-12);
//! ```

use crate::film::{Film, INERTIA, TAU_DECAY, TAU_GROWTH, TAU_REST, V_B, acceleration};
use crate::laws::coulomb::sense;
use crate::parameter::{DELTA, MU_K, MU_S, Parameter, SIGMA2, V_S};
use crate::{Claims, FrictionLaw, Scalar, Step, positive_part};

/// Parameters of the modified Stribeck law.
#[derive(Clone, Copy, Debug)]
pub struct FilmStribeck<T> {
    /// Film and Stribeck curve.
    pub film: Film<T>,
    /// Viscous damping (N·s/m).
    pub sigma2: T,
    /// Time constant of the fluid's inertia \[s\].
    pub inertia: T,
}

/// The parameters in order.
pub(crate) const PARAMETERS: &[Parameter] =
    &[MU_S, MU_K, V_S, DELTA, V_B, TAU_GROWTH, TAU_DECAY, TAU_REST, SIGMA2, INERTIA];

/// What the law promises.
pub(crate) const CLAIMS: Claims = Claims::PASSIVE;

impl<T: Scalar> FilmStribeck<T> {
    pub(crate) fn from_values(values: [T; 10]) -> Self {
        let [mu_s, mu_k, v_s, delta, v_b, growth, decay, rest, sigma2, inertia] = values;
        Self { film: Film { mu_s, mu_k, v_s, delta, v_b, tau: [growth, decay, rest] }, sigma2, inertia }
    }

    pub(crate) fn values(&self) -> [T; 10] {
        let Film { mu_s, mu_k, v_s, delta, v_b, tau: [growth, decay, rest] } = self.film;
        [mu_s, mu_k, v_s, delta, v_b, growth, decay, rest, self.sigma2, self.inertia]
    }
}

impl<T: Scalar> FrictionLaw<T> for FilmStribeck<T> {
    type State = [T; 1];

    fn rest(&self) -> [T; 1] {
        [T::from(0.0)]
    }

    #[inline]
    fn step(&self, state: [T; 1], step: &Step<T>) -> ([T; 1], T) {
        let (thickness, velocity) = (self.film.step(state[0], step), step.velocity[1]);
        let dry = self.film.coefficient(velocity, thickness) * positive_part(step.normal[1]) * sense(step);
        ([thickness], dry + self.sigma2 * (velocity + self.inertia * acceleration(step)))
    }

    fn at_rest(&self, state: [T; 1], step: &Step<T>) -> Option<[T; 2]> {
        let thickness = self.film.step(state[0], step);
        let level = self.film.coefficient(T::from(0.0), thickness) * positive_part(step.normal[1]);
        Some([-level, level])
    }
}
