//! Modified LuGre: LuGre with film dynamics and the inertia of the fluid (Yanada-Tran).
//!
//! # Equation
//! `F_t = N⁺ (σ0 z + σ1 ż) + σ2 (v + T v̇)`, `ż = v (1 − σ0 z sgn(v)/μ(v, h))`, film `h` and `μ(v, h)` as in
//! [`crate::film`].
//!
//! # Parameters
//! | symbol | field | unit | range |
//! |---|---|---|---|
//! | σ0 | `sigma0` | 1/m | > 0 |
//! | σ1 | `sigma1` | s/m | ≥ 0 |
//! | μ_s, μ_k | `film.mu_s`, `film.mu_k` | 1 | > 0 |
//! | v_s | `film.v_s` | m/s | > 0 |
//! | δ | `film.delta` | 1 | 0 … 20 |
//! | v_b | `film.v_b` | m/s | > 0, velocity of the full film |
//! | τ | `film.tau`; in files `tau_growth`, `tau_decay`, `tau_rest` | s | > 0 |
//! | σ2 | `sigma2` | N·s/m | ≥ 0 |
//! | T | `inertia` | s | ≥ 0 |
//!
//! # State
//! Bristle deflection `z` \[m\], film thickness `h`.
//!
//! # Limits
//! τ → ∞ from rest, T = 0: LuGre with constant σ1. σ0 → ∞: the modified Stribeck law.
//!
//! # Energy per cycle
//! No closed form; the inertia takes none in a closed cycle.
//!
//! # What it cannot show
//! Purely elastic presliding (see LuGre).
//!
//! # References
//! H. Yanada, Y. Sekikawa, Mechatronics 18 (2008) 330, doi 10.1016/j.mechatronics.2008.02.002; X. B. Tran, N. Hafizah,
//! H. Yanada, Mechatronics 22 (2012) 65. Equations from general knowledge.
//!
//! # Example
//! ```
//! use frettrace_friction::{FrictionLaw, Step, film::Film, laws::FilmLugre};
//! let film = Film { mu_s: 0.5, mu_k: 0.3, v_s: 1e-3, delta: 2.0, v_b: 2e-3, tau: [1e-3, 1e-2, 1.0] };
//! let law: FilmLugre<f64> = FilmLugre { sigma0: 1e6, sigma1: 0.0, film, sigma2: 0.0, inertia: 0.0 };
//! let step = Step { slip: [0.0, 1e-4], velocity: [1e-3; 2], normal: [1.0; 2], dt: 0.1 };
//! let h = 0.4 * 0.25_f64.cbrt(); // (1/2)^{2/3} of the full film
//! let expected = 0.3 + (0.5 * (1.0 - h) - 0.3) * (-1.0_f64).exp();
//! let (state, _) = law.step(law.rest(), &step);
//! assert!((law.step(state, &step).1 - expected).abs() < 1e-9);
//! ```

use crate::film::{Film, INERTIA, TAU_DECAY, TAU_GROWTH, TAU_REST, V_B, acceleration};
use crate::parameter::{DELTA, MU_K, MU_S, Parameter, SIGMA0, SIGMA1, SIGMA2, V_S};
use crate::{Bristle, Claims, FrictionLaw, Scalar, Step};

/// Parameters of the modified LuGre law.
#[derive(Clone, Copy, Debug)]
pub struct FilmLugre<T> {
    /// Bristle stiffness per newton of normal force (1/m).
    pub sigma0: T,
    /// Presliding damping per newton of normal force (s/m).
    pub sigma1: T,
    /// Film and Stribeck curve.
    pub film: Film<T>,
    /// Viscous damping (N·s/m).
    pub sigma2: T,
    /// Time constant of the fluid's inertia \[s\].
    pub inertia: T,
}

/// The parameters in order.
pub(crate) const PARAMETERS: &[Parameter] =
    &[SIGMA0, SIGMA1, MU_S, MU_K, V_S, DELTA, V_B, TAU_GROWTH, TAU_DECAY, TAU_REST, SIGMA2, INERTIA];

/// What the law promises.
pub(crate) const CLAIMS: Claims = Claims::PASSIVE;

impl<T: Scalar> FilmLugre<T> {
    pub(crate) fn from_values(values: [T; 12]) -> Self {
        let [sigma0, sigma1, mu_s, mu_k, v_s, delta, v_b, growth, decay, rest, sigma2, inertia] = values;
        let film = Film { mu_s, mu_k, v_s, delta, v_b, tau: [growth, decay, rest] };
        Self { sigma0, sigma1, film, sigma2, inertia }
    }

    pub(crate) fn values(&self) -> [T; 12] {
        let Film { mu_s, mu_k, v_s, delta, v_b, tau: [growth, decay, rest] } = self.film;
        let Self { sigma0, sigma1, sigma2, inertia, .. } = *self;
        [sigma0, sigma1, mu_s, mu_k, v_s, delta, v_b, growth, decay, rest, sigma2, inertia]
    }
}

impl<T: Scalar> FrictionLaw<T> for FilmLugre<T> {
    type State = [T; 2];

    fn rest(&self) -> [T; 2] {
        [T::from(0.0); 2]
    }

    #[inline]
    fn step(&self, [z, before]: [T; 2], step: &Step<T>) -> ([T; 2], T) {
        let film = self.film;
        let bristle =
            Bristle { sigma1: self.sigma1, sigma2: self.sigma2, ..Bristle::plain(self.sigma0, film.mu_k) };
        let after = film.step(before, step);
        let z = bristle.deflect(z, step, |instant| {
            film.coefficient(instant.velocity, before + (after - before) * instant.fraction)
        });
        let velocity = step.velocity[1];
        let rate = bristle.rate(z, velocity, film.coefficient(velocity, after));
        let force = bristle.force(z, rate, velocity, step.normal[1]);
        ([z, after], force + self.sigma2 * self.inertia * acceleration(step))
    }
}
