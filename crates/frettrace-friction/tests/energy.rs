//! The closed forms of the energy per cycle that the laws state, against their own steps along a harmonic slip.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use frettrace_friction::laws::*;
use frettrace_friction::{Closing, FrictionLaw, Period, close_loop};

/// Normal force \[N\], amplitude \[m\] and circular frequency (rad/s) of the slip.
const N: f64 = 40.0;
const A: f64 = 3e-6;
const OMEGA: f64 = 200.0;

/// Energy of the closed loop under `A sin ωt`, in units of `4 N A`: the rectangle rule over 2¹⁵ samples, which leaves `(2π/2¹⁵)² =
/// 4e-8` of what is kinked and as good as nothing of what is smooth.
fn energy<L: FrictionLaw<f64>>(law: L) -> f64 {
    let samples = 1 << 15;
    let phase = |k: usize| TAU * (k as f64 + 0.5) / samples as f64;
    let slip: Vec<f64> = (0..samples).map(|k| A * phase(k).sin()).collect();
    let velocity: Vec<f64> = (0..samples).map(|k| A * OMEGA * phase(k).cos()).collect();
    let (normal, dt) = (vec![N; samples], TAU / OMEGA / samples as f64);
    let period = Period { slip: &slip, velocity: &velocity, normal: &normal, dt };
    let mut force = vec![0.0; samples];
    let closing = Closing { periods: 2000, ..Closing::default() };
    assert!(close_loop(&law, &period, &mut force, closing).is_ok_and(|closed| closed.closed));
    force.iter().zip(&velocity).map(|(f, v)| f * v * dt).sum::<f64>() / (4.0 * N * A)
}

fn assert_near(name: &str, found: f64, expected: f64, tolerance: f64) {
    assert!((found - expected).abs() < tolerance * expected.abs(), "{name}: {found} for {expected}");
}

#[test]
fn coulomb_and_its_relatives() {
    assert_near("coulomb", energy(Coulomb { mu_k: 0.3 }), 0.3, 1e-6);
    let fbfm = Fbfm { mu_s: 0.5, mu_k: 0.3, v_ref: 1e-9, moving_mass: 1.0 };
    assert_near("fbfm", energy(fbfm), 0.3, 1e-6);
    for w in [0.4, 1.0, 2.5, 30.0_f64] {
        let law = |shape| RegularisedCoulomb { mu_k: 0.3, v_ref: A * OMEGA / w, shape };
        // Above v_ref up to the phase θ from the middle of the stroke.
        let theta = if w > 1.0 { w.recip().acos() } else { 0.0 };
        let (sine, rest) = (theta.sin(), FRAC_PI_2 - theta - theta.sin() * theta.cos());
        assert_near("linear", energy(law(Shape::Linear)), 0.3 * (sine + 0.5 * w * rest), 1e-6);
        let root = (1.0 + w * w).sqrt();
        assert_near("arctan", energy(law(Shape::Arctan)), 0.3 * (root - 1.0) / w, 1e-6);
        let [first, second] = elliptic(w * w / (1.0 + w * w));
        assert_near(
            "algebraic",
            energy(law(Shape::Algebraic)),
            0.3 * (root * second - first / root) / w,
            1e-6,
        );
        let ramp = w * rest - w * w * (2.0 / 3.0 - sine + sine.powi(3) / 3.0);
        assert_near("vlfm", energy(Vlfm { mu_k: 0.3, v_ref: A * OMEGA / w }), 0.3 * (sine + ramp), 1e-6);
    }
}

/// Complete elliptic integrals of the first and second kind by the arithmetic-geometric mean.
fn elliptic(m: f64) -> [f64; 2] {
    let (mut a, mut b, mut sum, mut power) = (1.0_f64, (1.0 - m).sqrt(), 0.5 * m, 0.5);
    for _ in 0..8 {
        let c = 0.5 * (a - b);
        (a, b) = (0.5 * (a + b), (a * b).sqrt());
        power *= 2.0;
        sum += power * c * c;
    }
    let first = FRAC_PI_2 / a;
    [first, first * (1.0 - sum)]
}

/// Dawson's integral over its argument, `e^{−w²} ∫₀¹ e^{w² s²} ds`, as a series of positive terms.
fn dawson_ratio(w: f64) -> f64 {
    let (mut term, mut sum) = (1.0, 0.0);
    for n in 0..200 {
        sum += term / (2.0 * f64::from(n) + 1.0);
        term *= w * w / (f64::from(n) + 1.0);
    }
    sum * (-w * w).exp()
}

#[test]
fn stribeck() {
    for w in [0.3, 1.0, 4.0] {
        let law = Stribeck { mu_s: 0.5, mu_k: 0.3, v_s: A * OMEGA / w, delta: 2.0, sigma2: 900.0 };
        let viscous = PI * 900.0 * OMEGA * A / (4.0 * N);
        assert_near("stribeck", energy(law), 0.3 + 0.2 * dawson_ratio(w) + viscous, 1e-6);
    }
}

#[test]
fn laws_with_sliders() {
    let jenkins = Jenkins { tangential_stiffness: 2e7, mu_k: 0.3 };
    assert_near("jenkins", energy(jenkins), 0.3 * (1.0 - 0.3 * N / 2e7 / A), 1e-6);
    let law = MaxwellSlip { stiffness: [1e5, 3e5, 2e4], limit: [0.1, 0.2, 0.3] };
    // The third element never slips.
    let expected = 0.1 * (1.0 - 0.1 / 1e5 / A) + 0.2 * (1.0 - 0.2 / 3e5 / A);
    assert_near("maxwell-slip", energy(law), expected, 1e-6);
    let sdfm = Sdfm { tangential_stiffness: 2e7, tangential_damping: 0.0, mu_s: 0.5, mu_k: 0.3 };
    let expected = 0.3 + N * (0.5 + 0.3) * (0.5 - 3.0 * 0.3) / (4.0 * 2e7 * A);
    // The force drops by 0.2 N between two samples: up to 2π/2¹⁵ of it each way.
    assert_near("sdfm", energy(sdfm), expected, 3e-4);
    let stuck = Sdfm { tangential_stiffness: 1e6, tangential_damping: 900.0, ..sdfm };
    assert_near("sdfm in stick", energy(stuck), PI * 900.0 * OMEGA * A / (4.0 * N), 1e-6);
}

#[test]
fn elastic_zones_take_nothing() {
    let lugre = Lugre {
        sigma0: 5e4,
        sigma1: 0.0,
        v_d: 1e-3,
        sigma2: 0.0,
        mu_s: 0.3,
        mu_k: 0.3,
        v_s: 1e-3,
        delta: 2.0,
    };
    // The steady deflection is 6e-6 m: the slip reaches half of it.
    let hybrid = |breakaway| energy(Hybrid { lugre, breakaway });
    assert!(hybrid(0.51).abs() < 1e-12 && hybrid(0.3) > 1e-4, "{} {}", hybrid(0.51), hybrid(0.3));
    let Lugre { sigma0, sigma1, sigma2, mu_s, mu_k, v_s, delta, .. } = lugre;
    let law = ElastoPlastic { sigma0, sigma1, sigma2, mu_s, mu_k, v_s, delta, breakaway: 0.51 };
    assert!(energy(law).abs() < 1e-12);
    let narrow = Hybrid { lugre: Lugre { sigma0: 5e5, ..lugre }, breakaway: 0.9999 };
    // The zone is 1e-4 of the level wide.
    assert_near("narrow zone", energy(narrow), 0.3 * (1.0 - 0.3 / 5e5 / A), 3e-4);
}

/// n = 1: with `c = 2β − 1` and the tip force `t`, loading takes `ln(1 + ct)/c − ln(1 − t) = 2a`.
#[test]
fn bouc_wen_of_sharpness_one() {
    for (beta, t) in [(0.6, 0.3_f64), (1.0, 0.7), (2.0, 0.95)] {
        let c = 2.0 * beta - 1.0;
        let a = 0.5 * ((c * t).ln_1p() / c - (-t).ln_1p());
        let law = BoucWen { sigma0: a * 0.3 / A, mu_k: 0.3, sharpness: 1.0, beta };
        let expected = 2.0 * ((c * t).ln_1p() / (c * c) - t / c - (-t).ln_1p() - t);
        // In units of 4 N A; the strides of Runge-Kutta leave 1e-6.
        assert_near("bouc-wen", energy(law), 0.3 * expected / (4.0 * a), 3e-6);
    }
}

/// Gross slip adds `4 μ N (A − u_s)` to the 0.8 μ N u_s of full partial slip.
#[test]
fn mindlin_beyond_partial_slip() {
    let law = CattaneoMindlin { mu_k: 0.3, slip_distance: 1e-6 };
    assert_near("mindlin", energy(law), 0.3 * (0.2 * 1e-6 / A + 1.0 - 1e-6 / A), 1e-6);
}
