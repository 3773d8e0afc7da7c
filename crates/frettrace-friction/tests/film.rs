//! The laws with film dynamics against closed forms: a film of first order, and what it makes of Stribeck and LuGre.

use std::f64::consts::{PI, TAU};

use frettrace_friction::film::Film;
use frettrace_friction::laws::{FilmLugre, FilmStribeck};
use frettrace_friction::{FrictionLaw, Step};

const FILM: Film<f64> =
    Film { mu_s: 0.5, mu_k: 0.3, v_s: 1e-3, delta: 2.0, v_b: 2e-3, tau: [5e-3, 2e-2, 0.7] };

fn stribeck() -> FilmStribeck<f64> {
    FilmStribeck { film: FILM, sigma2: 4.0, inertia: 0.0 }
}

/// `h_ss = (1 − μ_k/μ_s) min(|v|/v_b, 1)^{2/3}`.
fn steady(v: f64) -> f64 {
    (1.0 - 0.3 / 0.5) * (v.abs() / 2e-3).min(1.0).powf(2.0 / 3.0)
}

/// `μ_k + [(1 − h) μ_s − μ_k] exp(−(v/v_s)²)`.
fn coefficient(v: f64, h: f64) -> f64 {
    0.3 + ((1.0 - h) * 0.5 - 0.3) * (-(v / 1e-3).powi(2)).exp()
}

fn slide(v: f64, dt: f64) -> Step<f64> {
    Step { slip: [0.0, v * dt], velocity: [v; 2], normal: [10.0; 2], dt }
}

/// `h = h_ss + (h_0 − h_ss) e^{−t/τ}` at constant velocity: τ of growth, of decay and of rest, in steps of any length; the force
/// is that of the film at the moment. Exact but for rounding.
#[test]
fn a_film_relaxes_with_the_time_constant_of_its_sense() {
    let law = stribeck();
    let mut before = 0.0;
    for (v, tau, dt) in [(1.5e-3, 5e-3, 1e-3), (-4e-4, 2e-2, 7e-3), (0.0, 0.7, 0.1), (3e-3, 5e-3, 2e-2)] {
        let mut state = [before];
        for k in 1..=20 {
            let (new, force) = law.step(state, &slide(v, dt));
            state = new;
            let h = steady(v) + (before - steady(v)) * (-f64::from(k) * dt / tau).exp();
            assert!((state[0] - h).abs() < 1e-14, "{v} {k}: {} {h}", state[0]);
            if v != 0.0 {
                let expected = 10.0 * coefficient(v, h).copysign(v) + 4.0 * v;
                assert!((force - expected).abs() < 1e-12, "{v} {k}: {force} {expected}");
            }
        }
        before = state[0];
    }
}

/// At constant velocity under a settled film the bristle is LuGre's: `σ0 z = μ (1 − e^{−σ0 x/μ})`, `ż = v e^{−σ0 x/μ}`.
#[test]
fn a_bristle_under_a_settled_film_has_the_closed_form() {
    let law = FilmLugre { sigma0: 2e5, sigma1: 40.0, film: FILM, sigma2: 4.0, inertia: 0.0 };
    let (v, dt) = (6e-4, 1e-4);
    let mu = coefficient(v, steady(v));
    let mut state = [0.0, steady(v)];
    for k in 1..=200 {
        let force;
        (state, force) = law.step(state, &slide(v, dt));
        let left = (-2e5 * v * f64::from(k) * dt / mu).exp();
        let expected = 10.0 * (mu * (1.0 - left) + 40.0 * v * left) + 4.0 * v;
        assert!((force - expected).abs() < 1e-11, "{k}: {force} {expected}");
    }
}

/// The inertia of the fluid adds `σ2 T v̇`: in phase with the slip, so that it takes no energy; viscous friction takes
/// `π σ2 ω A²`. The acceleration of the Hermite cubic has an error of second order: (2π/4000)²/12 of it, 2e-7.
#[test]
fn the_inertia_of_the_fluid_takes_no_energy() {
    let (amplitude, omega, samples) = (1e-4, 30.0, 4000_u32);
    let dt = TAU / omega / f64::from(samples);
    let motion = |k: u32| {
        let phase = omega * f64::from(k) * dt;
        (amplitude * phase.sin(), amplitude * omega * phase.cos())
    };
    let film = Film { mu_s: 1e-12, mu_k: 1e-12, ..FILM };
    let with = |inertia: f64| FilmLugre { sigma0: 1e5, sigma1: 0.0, film, sigma2: 4.0, inertia };
    let (heavy, light) = (with(8e-3), with(0.0));
    let mut states = [[0.0; 2]; 2];
    let mut energy = [0.0; 2];
    for k in 0..samples {
        let ((u0, v0), (u1, v1)) = (motion(k), motion(k + 1));
        let step = Step { slip: [u0, u1], velocity: [v0, v1], normal: [1.0; 2], dt };
        let (a, fa) = heavy.step(states[0], &step);
        let (b, fb) = light.step(states[1], &step);
        states = [a, b];
        let expected = -4.0 * 8e-3 * omega * omega * u1;
        assert!((fa - fb - expected).abs() < 1e-6 * 4.0 * 8e-3 * omega * omega * amplitude);
        energy[0] += fa * v1 * dt;
        energy[1] += fb * v1 * dt;
    }
    let viscous = PI * 4.0 * omega * amplitude * amplitude;
    assert!((energy[1] / viscous - 1.0).abs() < 1e-6, "{} {viscous}", energy[1]);
    assert!((energy[0] / viscous - 1.0).abs() < 1e-6, "{} {viscous}", energy[0]);
}

/// The film is behind its velocity: at the same speed friction is larger while speed rises than while it falls. Slow
/// cycles close the loop; its width falls with the frequency as that of a filter of first order does.
#[test]
fn friction_is_larger_while_speed_rises() {
    let law = FilmStribeck { film: Film { tau: [5e-3, 5e-3, 5e-3], ..FILM }, sigma2: 0.0, inertia: 0.0 };
    let width = |omega: f64| {
        let samples = 4000_u32;
        let dt = TAU / omega / f64::from(samples);
        // Speed between 0.2 and 1.0 mm/s, always forwards.
        let speed = |k: u32| 6e-4 - 4e-4 * (omega * f64::from(k) * dt).cos();
        let slip = |k: u32| {
            let phase = omega * f64::from(k) * dt;
            (6e-4 * phase - 4e-4 * phase.sin()) / omega
        };
        let mut state = law.rest();
        let mut forces = Vec::new();
        for k in 0..20 * samples {
            let step = Step {
                slip: [slip(k), slip(k + 1)],
                velocity: [speed(k), speed(k + 1)],
                normal: [1.0; 2],
                dt,
            };
            let force;
            (state, force) = law.step(state, &step);
            forces.push(force);
        }
        let last = &forces[19 * samples as usize..];
        // A quarter and three quarters through the cycle the speed is the same, rising and falling.
        last[999] - last[2999]
    };
    let [slow, middle, fast] = [2.0, 20.0, 200.0].map(width);
    assert!(slow > 0.0 && middle > 5.0 * slow && fast > middle, "{slow} {middle} {fast}");
}

/// A film that follows at once: Stribeck with `(1 − h_ss(v)) μ_s` in the place of μ_s.
#[test]
fn a_fast_film_is_its_steady_one() {
    let law = FilmStribeck { film: Film { tau: [1e-9; 3], ..FILM }, sigma2: 0.0, inertia: 0.0 };
    for v in [1e-5, 3e-4, 1.1e-3, -7e-4, 5e-3] {
        let (_, force) = law.step(law.rest(), &slide(v, 1e-2));
        let expected = 10.0 * coefficient(v, steady(v)).copysign(v);
        assert!((force - expected).abs() < 1e-12, "{v}: {force} {expected}");
    }
}
