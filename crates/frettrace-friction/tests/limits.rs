//! Which law becomes which when a parameter goes to its limit.

use frettrace_friction::film::Film;
use frettrace_friction::laws::*;
use frettrace_friction::{Bristle, FrictionLaw, Period};

const SAMPLES: usize = 400;

/// Forces of the sixth period under a slip of ±3e-6 m with a third harmonic, at 10 Hz and 100 N.
fn forces<L: FrictionLaw<f64>>(law: L) -> Vec<f64> {
    let (omega, tau) = (62.8, std::f64::consts::TAU);
    let phase = |k: usize| tau * (k as f64 + 0.5) / SAMPLES as f64;
    let slip: Vec<f64> =
        (0..SAMPLES).map(|k| 3e-6 * (phase(k).sin() + 0.3 * (3.0 * phase(k)).sin())).collect();
    let velocity: Vec<f64> =
        (0..SAMPLES).map(|k| 3e-6 * omega * (phase(k).cos() + 0.9 * (3.0 * phase(k)).cos())).collect();
    let normal = vec![100.0; SAMPLES];
    let period =
        Period { slip: &slip, velocity: &velocity, normal: &normal, dt: tau / omega / SAMPLES as f64 };
    let (mut force, mut state) = (vec![0.0; SAMPLES], law.rest());
    for _ in 0..6 {
        for (k, slot) in force.iter_mut().enumerate() {
            (state, *slot) = law.step(state, &period.step(k));
        }
    }
    force
}

/// Root mean square of the difference over 100 N.
fn distance<A: FrictionLaw<f64>, B: FrictionLaw<f64>>(a: A, b: B) -> f64 {
    let square: f64 = forces(a).iter().zip(forces(b)).map(|(x, y)| (x - y).powi(2)).sum();
    (square / SAMPLES as f64).sqrt() / 100.0
}

fn lugre() -> Lugre<f64> {
    Lugre { sigma0: 5e5, sigma1: 0.0, v_d: 1e-3, sigma2: 0.0, mu_s: 0.4, mu_k: 0.4, v_s: 1e-4, delta: 2.0 }
}

#[test]
fn hybrid_to_lugre_to_dahl_to_coulomb() {
    let wet = Lugre { sigma1: 50.0, sigma2: 30.0, mu_s: 0.6, ..lugre() };
    let spread = Bristle { breakaway: -1e7, ..Hybrid { lugre: wet, breakaway: 0.0 }.bristle() };
    assert!(distance(spread, wet) < 1e-6); // α differs from 1 by (π/2e7)² and the strides of Runge-Kutta
    assert!(distance(Hybrid { lugre: wet, breakaway: 0.5 }, wet) > 1e-2);
    let dahl = Dahl { sigma0: 5e5, mu_k: 0.4, exponent: 1.0 };
    assert!(distance(lugre(), dahl) < 1e-12);
    assert!(distance(wet, dahl) > 1e-2);
    // The bristle's length falls as 1/σ0, the share of samples inside it with its root (the slip turns as a parabola).
    let coulomb = Coulomb { mu_k: 0.4 };
    let far = distance(Dahl { sigma0: 1e13, ..dahl }, coulomb);
    assert!(far < 1e-3 && far < distance(dahl, coulomb) / 100.0, "{far}");
    let stribeck = Stribeck { mu_s: 0.6, mu_k: 0.4, v_s: 1e-4, delta: 2.0, sigma2: 30.0 };
    let stiff = Lugre { sigma0: 1e13, sigma1: 0.0, ..wet };
    assert!(distance(stiff, stribeck) < 2e-3);
}

#[test]
fn three_ways_to_jenkins() {
    let jenkins = Jenkins { tangential_stiffness: 5e7, mu_k: 0.4 };
    assert!(distance(Dahl { sigma0: 5e5, mu_k: 0.4, exponent: 0.0 }, jenkins) < 1e-9);
    let hybrid = Hybrid { lugre: lugre(), breakaway: 0.9999 };
    assert!(distance(hybrid, jenkins) < 1e-4); // the zone is 1e-4 of the level wide
    let dropless = Sdfm { tangential_stiffness: 5e7, tangential_damping: 0.0, mu_s: 0.4, mu_k: 0.4 };
    assert!(distance(dropless, jenkins) < 1e-12);
    assert!(distance(MaxwellSlip { stiffness: [5e5], limit: [0.4] }, jenkins) < 1e-12);
    let narrow = Iwan { sigma0: 5e5, mu_k: 0.4, chi: 0.0, beta: 1e8 };
    assert!(distance(narrow, jenkins) < 1e-6);
    let sharp = BoucWen { sigma0: 5e5, mu_k: 0.4, sharpness: 400.0, beta: 0.5 };
    assert!(distance(sharp, jenkins) < 1e-2); // the knee is 1/n of the level wide
}

#[test]
fn relatives_of_dahl_and_lugre() {
    let dahl = Dahl { sigma0: 5e5, mu_k: 0.4, exponent: 1.0 };
    assert!(distance(BoucWen { sigma0: 5e5, mu_k: 0.4, sharpness: 1.0, beta: 1.0 }, dahl) < 1e-6);
    let wet = Lugre { sigma1: 50.0, sigma2: 30.0, mu_s: 0.6, v_d: f64::INFINITY, ..lugre() };
    let Lugre { sigma0, sigma1, sigma2, mu_s, mu_k, v_s, delta, .. } = wet;
    let elastic = ElastoPlastic { sigma0, sigma1, sigma2, mu_s, mu_k, v_s, delta, breakaway: 0.5 };
    assert!(distance(elastic, Hybrid { lugre: wet, breakaway: 0.5 }) < 1e-12);
    let film = Film { mu_s, mu_k, v_s, delta, v_b: 1e-3, tau: [1e12; 3] };
    assert!(distance(FilmLugre { sigma0, sigma1, film, sigma2, inertia: 0.0 }, wet) < 1e-9);
    let stribeck = Stribeck { mu_s, mu_k, v_s, delta, sigma2 };
    assert!(distance(FilmStribeck { film, sigma2, inertia: 0.0 }, stribeck) < 1e-9);
}

#[test]
fn relatives_of_coulomb_and_maxwell_slip() {
    let coulomb = Coulomb { mu_k: 0.4 };
    for shape in [Shape::Tanh, Shape::Arctan, Shape::Algebraic, Shape::Linear] {
        assert!(distance(RegularisedCoulomb { mu_k: 0.4, v_ref: 1e-12, shape }, coulomb) < 1e-6);
    }
    assert!(distance(Vlfm { mu_k: 0.4, v_ref: 1e-12 }, coulomb) < 1e-12);
    assert!(distance(Fbfm { mu_s: 0.5, mu_k: 0.4, v_ref: 1e-12, moving_mass: 1.0 }, coulomb) < 1e-12);
    assert!(distance(CattaneoMindlin { mu_k: 0.4, slip_distance: 1e-14 }, coulomb) < 1e-12);
    let (stiffness, weight) = ([3e5, 1e5, 1e5, 2e5], [0.04, 0.08, 0.12, 0.16]);
    let gms =
        Gms { stiffness, weight, attraction: 1e4, sigma2: 0.0, mu_s: 0.4, mu_k: 0.4, v_s: 1e-4, delta: 2.0 };
    assert!(distance(gms, MaxwellSlip { stiffness, limit: weight }) < 1e-12);
}

/// Stiffness without bound leaves the sliders alone.
#[test]
fn stiff_laws_are_rigid_ones() {
    let coulomb = Coulomb { mu_k: 0.4 };
    // As for Dahl above: the share of samples inside the elastic part falls with the root of its length.
    let near = |name: &str, found: f64| assert!(found < 2e-3, "{name}: {found}");
    near("jenkins", distance(Jenkins { tangential_stiffness: 1e15, mu_k: 0.4 }, coulomb));
    near("maxwell-slip", distance(MaxwellSlip { stiffness: [1e13; 2], limit: [0.1, 0.3] }, coulomb));
    near("iwan", distance(Iwan { sigma0: 1e13, mu_k: 0.4, chi: -0.5, beta: 0.5 }, coulomb));
    near("bouc-wen", distance(BoucWen { sigma0: 1e13, mu_k: 0.4, sharpness: 1.5, beta: 0.7 }, coulomb));
    let sdfm = Sdfm { tangential_stiffness: 1e15, tangential_damping: 0.0, mu_s: 0.6, mu_k: 0.4 };
    near("sdfm", distance(sdfm, coulomb)); // stiction is over within a sample
    let stribeck = Stribeck { mu_s: 0.6, mu_k: 0.4, v_s: 1e-4, delta: 2.0, sigma2: 30.0 };
    let wet = Lugre { sigma0: 1e13, sigma2: 30.0, mu_s: 0.6, ..lugre() };
    near("hybrid", distance(Hybrid { lugre: wet, breakaway: 0.5 }, stribeck));
    let film = Film { mu_s: 0.6, mu_k: 0.4, v_s: 1e-4, delta: 2.0, v_b: 1e-3, tau: [1e-2, 3e-2, 1.0] };
    let rigid = FilmStribeck { film, sigma2: 30.0, inertia: 1e-3 };
    let bristle = FilmLugre { sigma0: 1e13, sigma1: 0.0, film, sigma2: 30.0, inertia: 1e-3 };
    near("film-lugre", distance(bristle, rigid));
}

/// A drop that is over at once, a ramp that is never left, and a distribution of sliders that begins at zero.
#[test]
fn the_other_ends() {
    let sudden = Stribeck { mu_s: 0.6, mu_k: 0.4, v_s: 1e-12, delta: 2.0, sigma2: 0.0 };
    assert!(distance(sudden, Coulomb { mu_k: 0.4 }) < 1e-12);
    for (shape, factor) in [
        (Shape::Tanh, 1.0),
        (Shape::Arctan, std::f64::consts::FRAC_2_PI),
        (Shape::Algebraic, 1.0),
        (Shape::Linear, 1.0),
    ] {
        // Speeds reach 4e-4 m/s: the force is 2e-7 of the normal force, and the cube of 4e-7 is not seen.
        let ramp = RegularisedCoulomb { mu_k: 0.4, v_ref: 1e3, shape };
        let damper =
            Stribeck { mu_s: 0.0, mu_k: 0.0, v_s: 1.0, delta: 1.0, sigma2: 0.4 * 100.0 * factor / 1e3 };
        assert!(distance(ramp, damper) < 1e-18, "{shape:?}");
    }
    let early = Iwan { sigma0: 5e5, mu_k: 0.4, chi: -1.0 + 1e-9, beta: 0.5 };
    let jenkins = Jenkins { tangential_stiffness: 5e7 * 0.5 / 1.5, mu_k: 0.4 };
    assert!(distance(early, jenkins) < 1e-7);
}
