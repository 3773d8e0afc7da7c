//! The foreign contact with no effect is the declared one, and each effect does what its formula says.

use super::*;
use frettrace_friction::effects::{Hook, ModifiedLaw};
use frettrace_friction::laws::Dahl;
use frettrace_friction::{Law, Visitor};
use std::f64::consts::TAU;

fn dahl() -> Bristle {
    Bristle {
        sigma0: 4.0,
        mu_k: 0.4,
        stribeck: [0.0, 1.0, 2.0],
        damping: [0.0, 1.0],
        sigma2: 0.0,
        exponent: 1.0,
        breakaway: 0.0,
    }
}

fn law(bristle: Bristle, form: Form) -> ForeignLaw {
    ForeignLaw { bristle, forms: [form, Form::None], progress: 1.0 }
}

/// Slip, velocity and force over the tenth period of a sinusoidal slip; amplitude 0.5, period 1, normal force 2.
fn loop_of<L: FrictionLaw<f64>>(law: &L, samples: usize) -> Vec<[f64; 3]> {
    let at = |k: usize| {
        let phase = TAU * k as f64 / samples as f64;
        (0.5 * phase.sin(), 0.5 * TAU * phase.cos())
    };
    let mut state = law.rest();
    let mut points = Vec::new();
    for k in 0..10 * samples {
        let ((u0, v0), (u1, v1)) = (at(k), at(k + 1));
        let step = Step { slip: [u0, u1], velocity: [v0, v1], normal: [2.0; 2], dt: 1.0 / samples as f64 };
        let (next, force) = law.step(state, &step);
        state = next;
        if k >= 9 * samples {
            points.push([u1, v1, force]);
        }
    }
    points
}

/// The loop of a law of the catalogue, with so many samples.
struct Loop(usize);

impl Visitor<f64> for Loop {
    type Output = Vec<[f64; 3]>;

    fn visit<L: FrictionLaw<f64>>(self, law: &L) -> Self::Output {
        loop_of(law, self.0)
    }
}

fn largest_difference(a: &[[f64; 3]], b: &[[f64; 3]]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a[2] - b[2]).abs()).fold(0.0, f64::max)
}

/// Two integrations of the same equation: the strokes of the catalogue and Runge-Kutta here. Forces are of size 0.8; the
/// kink at a reversal inside a step costs its square, (1/800)² times the bend.
#[test]
fn without_effects_it_is_the_declared_law() {
    let plain = Dahl { sigma0: 4.0, mu_k: 0.4, exponent: 1.0 };
    assert!(largest_difference(&loop_of(&law(dahl(), Form::None), 800), &loop_of(&plain, 800)) < 1e-5);
    let bristle =
        Bristle { stribeck: [0.2, 1.5, 2.0], damping: [0.05, 2.0], sigma2: 0.03, breakaway: 0.3, ..dahl() };
    let named = [
        ("sigma0", 4.0),
        ("sigma1", 0.05),
        ("v_d", 2.0),
        ("sigma2", 0.03),
        ("mu_s", 0.6),
        ("mu_k", 0.4),
        ("v_s", 1.5),
        ("delta", 2.0),
        ("breakaway", 0.3),
    ];
    let named = named.map(|(name, value)| (name.to_owned(), value)).into();
    let hybrid = Law::Hybrid.with_named(&named).unwrap().visit(Loop(800));
    assert!(largest_difference(&loop_of(&law(bristle, Form::None), 800), &hybrid) < 1e-4);
}

/// At full slip the force is `P μ(…)`: each formula at the middle of the stroke, where `u = 0` and `v = 0.5·2π`.
///
/// With σ0 = 16 the deflection has travelled 16 steady deflections or more from the reversal: nothing is left of its start. It
/// trails a coefficient that changes by a twentieth of the stroke.
#[test]
fn coefficients_are_their_formulas() {
    let v = 0.5 * TAU;
    let cases = [
        (Form::RationalStribeck([0.2, 1.0, 2.0]), 0.4 + 0.2 / (1.0 + v * v)),
        (Form::ViscousPower([0.02, 1.5]), 0.4 + 0.01 * v.powf(1.5)),
        (Form::SmoothAsymmetry([0.2, 0.1]), 0.48),
        (Form::StraightNormalDependence([0.2, 4.0]), 0.44),
        (Form::SettlingWear(-0.1), 0.36),
        (Form::SpeedSquare(0.01), 0.4 + 0.005 * v * v),
        (Form::NormalMemory(0.1), 0.4),
        (Form::SaturatingAgeing([0.5, 1e-3, 1.0]), 0.4),
        (Form::StraightStribeck([0.2, 2.0 * v]), 0.5),
        (Form::EyringViscous([0.1, v]), 0.4 + 0.05 * 1.0_f64.asinh()),
        // An age of d/v: (1e-3/v)/1e-3 = 1/v, to the power of one half.
        (Form::PowerAgeing([0.1, 1e-3, 1e-3, 0.5]), 0.4 * (1.0 + 0.1 / v.sqrt())),
        (Form::ParabolicPosition([0.2, 0.5]), 0.4),
        (Form::SquarePosition([0.2, 10.0]), 0.4),
        // The normal force is 2.
        (Form::Adhesion([0.2, 4.0]), 0.4 * 1.2),
        (Form::RootWear(-0.1), 0.36),
    ];
    for (form, expected) in cases {
        let points = loop_of(&law(Bristle { sigma0: 16.0, ..dahl() }, form), 400);
        let [_, _, force] = points[399];
        assert!((force / 2.0 - expected).abs() < 0.02 * expected, "{form:?}: {} {expected}", force / 2.0);
    }
}

/// A spring beside the contact adds its own force, exactly.
#[test]
fn a_spring_beside_adds_up() {
    let with = loop_of(&law(dahl(), Form::ParallelSpring(3.0)), 200);
    let without = loop_of(&law(dahl(), Form::None), 200);
    for (a, b) in with.iter().zip(without) {
        assert!((a[2] - b[2] - 3.0 * a[0]).abs() < 1e-12);
    }
}

/// A spring in series: just after a reversal the stiffness is that of both, `1/(1/(Pσ0·2) + 1/k)` (`φ = 2` there).
#[test]
fn a_spring_in_series_softens() {
    let points = loop_of(&law(dahl(), Form::SeriesSpring(8.0)), 4000);
    let [a, b] = [points[1000], points[1010]];
    let stiffness = (b[2] - a[2]) / (b[0] - a[0]);
    // φ falls from 2 at the reversal by the travel over the steady deflection, here 0.1 %.
    assert!((stiffness - 1.0 / (1.0 / 16.0 + 1.0 / 8.0)).abs() < 0.02 * stiffness, "{stiffness}");
}

/// Play makes a dead stretch of twice its half after a reversal.
#[test]
fn play_is_taken_up_first() {
    let points = loop_of(&law(dahl(), Form::GradualBacklash(0.05)), 4000);
    let at_slip =
        |slip: f64| points[1000..3000].iter().find(|p| p[0] < slip).map(|p| p[2]).unwrap_or(f64::NAN);
    let tip = points[1000][2];
    assert!((at_slip(0.5 - 0.04) - tip).abs() < 0.02 * tip);
    assert!((at_slip(0.5 - 0.3) - tip).abs() > 0.5 * tip);
}

/// Play that closes gradually is Bouc and Wen's element with the power 8: Runge-Kutta on all states together against the law with hooks,
/// which hands the engaged slip on from step to step. With 4000 samples a period and play of 80 steps at full speed the chord of the bristle's motion
/// over a step costs 1e-3 of the force at most.
#[test]
fn play_that_closes_gradually_is_a_power_of_its_gap() {
    let reference = loop_of(&law(dahl(), Form::GradualBacklash(0.05)), 4000);
    let with = |power: Option<f64>| {
        let mut law = ModifiedLaw::dahl(4.0, 0.4);
        law.set(Hook::Backlash, 0.05);
        if let Some(power) = power {
            law.set(Hook::BacklashPower, power);
        }
        largest_difference(&reference, &loop_of(&law, 4000))
    };
    let [gradual, other, sudden] = [Some(8.0), Some(4.0), None].map(with);
    assert!(gradual < 8e-4, "{gradual}");
    assert!(other > 20.0 * gradual && sudden > 20.0 * gradual, "{other} {sudden}");
}

/// The triangle wave at its corners and zeros.
#[test]
fn the_triangle_is_one() {
    for (x, expected) in [(0.0, 0.0), (0.25, 1.0), (0.5, 0.0), (0.75, -1.0), (0.125, 0.5), (-0.25, -1.0)] {
        assert!((triangle(x) - expected).abs() < 1e-12);
    }
}
