//! What the modified law must satisfy.

mod formulas;

use super::{Circumstance, Hook, ModifiedLaw, ModifiedState, Periodic, Reached};
use crate::law::Step;
use num_dual::Dual64;

/// Force over one settled period of a sinusoidal slip of amplitude `amplitude`, `samples` samples.
fn settled<T: crate::law::Scalar>(law: &ModifiedLaw<T>, amplitude: f64, samples: usize) -> Vec<(f64, T)> {
    let circumstance = Circumstance { preload: 1.0, ..Circumstance::default() };
    let dt = 1.0 / samples as f64;
    let at = |k: usize| {
        let phase = std::f64::consts::TAU * k as f64 * dt;
        (amplitude * phase.sin(), amplitude * std::f64::consts::TAU * phase.cos())
    };
    let mut state = law.rest_at(T::from(0.0));
    let mut out = Vec::new();
    for period in 0..13 {
        for k in 0..samples {
            let ((u0, v0), (u1, v1)) = (at(k), at(k + 1));
            let step = Step {
                slip: [u0, u1].map(T::from),
                velocity: [v0, v1].map(T::from),
                normal: [T::from(1.0); 2],
                dt,
            };
            let (next, force) = law.advance(state, &step, &circumstance);
            state = next;
            if period == 12 {
                out.push((u1, force));
            }
        }
    }
    out
}

/// Energy of a settled loop by the trapezoid rule on the closed curve.
fn energy(points: &[(f64, f64)]) -> f64 {
    (0..points.len())
        .map(|k| {
            let (a, b) = (points[k], points[(k + 1) % points.len()]);
            0.5 * (a.1 + b.1) * (b.0 - a.0)
        })
        .sum()
}

/// Dahl's loop: tip force `F_c tanh a`, energy `4 F_c²/s₀ (a − tanh a)` with `a = s₀A/F_c`.
/// The trapezoid rule on 4096 points is good to 1e-6.
#[test]
fn dahl_loop_has_its_closed_form() {
    for a in [0.5, 1.0, 5.0] {
        let law: ModifiedLaw<f64> = ModifiedLaw::dahl(2.0, 0.5);
        let points = settled(&law, a * 0.25, 4096);
        let tip = points.iter().map(|p| p.1).fold(0.0, f64::max);
        let work = energy(&points);
        let expected = 4.0 * 0.25 / 2.0 * (a - a.tanh());
        assert!((work - expected).abs() < 1e-5 * expected, "{work} {expected}");
        if a < 2.0 {
            assert!((tip - 0.5 * f64::tanh(a)).abs() < 1e-5);
        }
    }
}

/// The exponent form at `i → 1` is the exponential form.
#[test]
fn exponent_one_is_the_plain_law() {
    let plain: ModifiedLaw<f64> = ModifiedLaw::dahl(3.0, 0.4);
    let mut other = plain;
    other.set(Hook::Exponent, 1.0);
    for (a, b) in settled(&plain, 0.3, 256).iter().zip(settled(&other, 0.3, 256)) {
        assert!((a.1 - b.1).abs() < 1e-12);
    }
}

/// The powered flow at `n = 1` is the plain law; Runge-Kutta steps of a quarter are good to 1e-5.
#[test]
fn flow_power_one_is_the_plain_law() {
    let plain: ModifiedLaw<f64> = ModifiedLaw::dahl(3.0, 0.4);
    let mut other = plain;
    other.set(Hook::FlowPower, 1.0);
    for (a, b) in settled(&plain, 0.3, 256).iter().zip(settled(&other, 0.3, 256)) {
        assert!((a.1 - b.1).abs() < 1e-5);
    }
}

/// Shapes of another laboratory at their neutral values change nothing, beyond what another rule of integration does: a
/// thousandth of a period in which the asymmetry passes zero, Runge-Kutta steps of a quarter in place of a tenth.
#[test]
fn neutral_shapes_change_nothing() {
    let neutral = [
        (vec![(Hook::Breakaway, 0.3)], Hook::BreakawayShape, 0.0, 2e-3),
        (vec![(Hook::Breakaway, 0.3)], Hook::FlowPower, 1.0, 2e-3),
        (vec![(Hook::Breakaway, 0.3)], Hook::Exponent, 1.0, 2e-3),
        (vec![(Hook::Asymmetry, 0.2)], Hook::AsymmetryVelocity, 1e-9, 1e-5),
        (vec![(Hook::NormalExponent, 0.3)], Hook::NormalPower, 0.0, 1e-12),
        (vec![(Hook::Position, 0.4)], Hook::PositionScale, 1e6, 1e-9),
        (vec![(Hook::Viscous, 0.1), (Hook::ViscousReference, 2.0)], Hook::ViscousPower, 1.0, 1e-12),
        (
            vec![(Hook::Viscous, 0.1), (Hook::ViscousReference, 2.0), (Hook::ViscousPower, 0.6)],
            Hook::ViscousCore,
            1e-6,
            1e-3,
        ),
        (
            vec![
                (Hook::Viscous, 0.1),
                (Hook::ViscousReference, 2.0),
                (Hook::ViscousPower, 0.6),
                (Hook::ViscousCore, 0.3),
            ],
            Hook::ViscousTurn,
            2.0,
            1e-12,
        ),
        (
            vec![(Hook::AgeingGain, 0.1), (Hook::AgeingTime, 0.02), (Hook::AgeingDistance, 0.05)],
            Hook::AgeingPower,
            0.0,
            1e-12,
        ),
        (
            vec![(Hook::PeriodicCosine, 0.2), (Hook::PeriodicSine, 0.1), (Hook::PeriodicNumber, 9.0)],
            Hook::PeriodicSteepness,
            1e-5,
            1e-9,
        ),
        (
            vec![(Hook::StribeckRise, 0.2), (Hook::StribeckVelocity, 0.5), (Hook::StribeckExponent, 1.3)],
            Hook::StribeckBend,
            1.0,
            1e-7,
        ),
        (
            vec![
                (Hook::StribeckRise, 0.2),
                (Hook::StribeckVelocity, 0.5),
                (Hook::StribeckExponent, 1.3),
                (Hook::RationalShare, 1.0),
            ],
            Hook::StribeckBend,
            2.0,
            1e-7,
        ),
        (vec![(Hook::Wear, 0.4)], Hook::WearExponent, 1.0, 1e-12),
        (vec![(Hook::Wear, 0.4)], Hook::WearSettling, 0.0, 1e-12),
        (vec![(Hook::Asymmetry, 0.2), (Hook::AsymmetryVelocity, 0.3)], Hook::AsymmetryPower, 2.0, 1e-6),
        (vec![(Hook::Position, 0.4), (Hook::PositionScale, 0.2)], Hook::PositionPower, 2.0, 1e-6),
        (
            vec![(Hook::PeriodicCosine, 0.2), (Hook::PeriodicSine, 0.1), (Hook::PeriodicNumber, 9.0)],
            Hook::PeriodicSharpness,
            1e-6,
            1e-9,
        ),
        (
            vec![(Hook::StribeckRise, 0.2), (Hook::StribeckVelocity, 0.5), (Hook::LagTime, 0.05)],
            Hook::LagSaturation,
            0.0,
            1e-12,
        ),
        (
            vec![
                (Hook::StribeckRise, 0.2),
                (Hook::StribeckVelocity, 0.5),
                (Hook::LagTime, 0.05),
                (Hook::LagSaturation, 3.0),
            ],
            Hook::LagPower,
            1.0,
            1e-7,
        ),
        (vec![(Hook::Sigma1, 0.01), (Hook::DampingVelocity, 1.0)], Hook::DampingRational, 0.0, 1e-12),
        (vec![(Hook::Sigma1, 0.01), (Hook::DampingVelocity, 1.0)], Hook::DampingPower, 2.0, 1e-9),
        (
            vec![
                (Hook::FilmLoss, 0.3),
                (Hook::FilmRise, 0.05),
                (Hook::FilmVelocity, 1.0),
                (Hook::FilmExponent, 0.8),
            ],
            Hook::FilmRational,
            0.0,
            1e-12,
        ),
    ];
    for (effect, shape, value, tolerance) in neutral {
        let mut law: ModifiedLaw<f64> = ModifiedLaw::dahl(3.0, 0.4);
        effect.into_iter().for_each(|(hook, value)| law.set(hook, value));
        let mut other = law;
        other.set(shape, value);
        for (a, b) in settled(&law, 0.3, 1024).iter().zip(settled(&other, 0.3, 1024)) {
            assert!((a.1 - b.1).abs() < tolerance, "{shape:?} {} {}", a.1, b.1);
        }
    }
}

/// What these shapes are for. Sliding at a steady speed, Dahl's force at its limit of 0.4 N beside the viscous one: `c·v·(y^q + c₀^q)^{(p−1)/q}` with
/// `p = 0`, `q = 1`, `v₀ = 1` is `v/(|v| + c₀)`, a film that saturates. A steep wave is a square one. The harmonics of a modulation are its Fourier
/// series, here at the phase `ψ` with `cos ψ = 3/5`, `sin ψ = 4/5`: `cos 2ψ = −7/25`, `sin 2ψ = 24/25`, `cos 3ψ = −117/125`, `sin 3ψ = 44/125`,
/// `cos 4ψ = −527/625`, `sin 4ψ = −336/625`.
#[test]
fn other_shapes_are_their_formulas() {
    let slide = |hooks: &[(Hook, f64)], slip: f64| {
        let mut law: ModifiedLaw<f64> = ModifiedLaw::dahl(1e6, 0.4);
        hooks.iter().for_each(|(hook, value)| law.set(*hook, *value));
        let phase = [[0.6, 0.8]; 2];
        let circumstance = Circumstance { preload: 1.0, phase, ..Circumstance::default() };
        let step = Step { slip: [slip - 0.01, slip], velocity: [0.7; 2], normal: [1.0; 2], dt: 0.01 / 0.7 };
        law.advance(law.rest_at(slip - 0.01), &step, &circumstance).1
    };
    let saturating = [
        (Hook::Viscous, 0.2),
        (Hook::ViscousReference, 1.0),
        (Hook::ViscousPower, 0.0),
        (Hook::ViscousCore, 0.3),
        (Hook::ViscousTurn, 1.0),
    ];
    assert!((slide(&saturating, 0.3) - 0.4 - 0.2 * 0.7 / (0.7 + 0.3)).abs() < 1e-6);
    let square = [
        (Hook::PeriodicCosine, 0.0),
        (Hook::PeriodicSine, 0.1),
        (Hook::PeriodicNumber, 9.0),
        (Hook::PeriodicSteepness, 50.0),
        (Hook::PeriodicCorner, 8.0),
    ];
    for (slip, sign) in [(0.1, 1.0), (0.45, -1.0)] {
        assert!((slide(&square, slip) - 0.4 * (1.0 + 0.1 * sign)).abs() < 1e-6, "{slip}");
    }
    // Straight from 0.6 at rest to 0.4 at a speed of 1, and nothing beyond.
    let straight = |velocity| {
        [
            (Hook::StribeckRise, 0.2),
            (Hook::StribeckVelocity, velocity),
            (Hook::StribeckExponent, 1.0),
            (Hook::StribeckBend, 0.0),
        ]
    };
    assert!((slide(&straight(1.0), 0.3) - 0.4 - 0.2 * 0.3).abs() < 1e-6);
    assert!((slide(&straight(0.5), 0.3) - 0.4).abs() < 1e-9);
    let wave = [
        (Hook::ModulationCosine, 0.1),
        (Hook::ModulationSine, 0.2),
        (Hook::ModulationCosine2, 0.05),
        (Hook::ModulationSine2, 0.02),
        (Hook::ModulationCosine3, -0.03),
        (Hook::ModulationSine3, 0.04),
        (Hook::ModulationCosine4, 0.01),
        (Hook::ModulationSine4, 0.03),
    ];
    let expected =
        0.06 + 0.16 - 0.05 * 7.0 / 25.0 + 0.02 * 24.0 / 25.0 + 0.03 * 117.0 / 125.0 + 0.04 * 44.0 / 125.0
            - 0.01 * 527.0 / 625.0
            - 0.03 * 336.0 / 625.0;
    assert!((slide(&wave, 0.3) - 0.4 * (1.0 + expected)).abs() < 1e-6);
}

/// At rest the curve is 1, and the distance `x = 1 − m` of a lag of bounded rate falls as `ln x + κx = ln x₀ + κx₀ − t/τ`
/// (its equation of motion, separated). From `m = 0` over `t = 0.6 τ` with `κ = 4`, in 256 steps of order two.
#[test]
fn bounded_lag_falls_as_its_closed_form() {
    let (tau, kappa, steps) = (0.05, 4.0, 256);
    let mut law: ModifiedLaw<f64> = ModifiedLaw::dahl(3.0, 0.4);
    for (hook, value) in [
        (Hook::StribeckRise, 0.2),
        (Hook::StribeckVelocity, 0.5),
        (Hook::LagTime, tau),
        (Hook::LagSaturation, kappa),
    ] {
        law.set(hook, value);
    }
    let dt = 0.6 * tau / f64::from(steps);
    let rest = Step { slip: [0.0; 2], velocity: [0.0; 2], normal: [1.0; 2], dt };
    let mut state = law.rest_at(0.0);
    state.0[1] = 0.0;
    for _ in 0..steps {
        state = law.advance(state, &rest, &Circumstance::default()).0;
    }
    let x = 1.0 - state.0[1];
    assert!((x.ln() + kappa * x - kappa + 0.6).abs() < 1e-5, "{x}");
}

/// Far below sliding a bristle and a spring in series are two springs, `u = F/(σ0 N) + cF`, whatever the normal force does meanwhile.
/// The midpoint rule on 1024 steps of two periods is good to 1e-5.
#[test]
fn a_spring_in_series_carries_the_force() {
    let (sigma0, compliance) = (3.0, 0.4);
    let mut law: ModifiedLaw<f64> = ModifiedLaw::dahl(sigma0, 1e6);
    law.set(Hook::SeriesCompliance, compliance);
    let circumstance = Circumstance { preload: 1.0, ..Circumstance::default() };
    let samples = 1024;
    let at = |k: usize| {
        let phase = 2.0 * std::f64::consts::TAU * k as f64 / samples as f64;
        [0.2 * phase.sin(), 0.4 * std::f64::consts::TAU * phase.cos(), 1.0 + 0.5 * (0.5 * phase).sin()]
    };
    let mut state = law.rest_at(0.0);
    for k in 0..samples {
        let (from, to) = (at(k), at(k + 1));
        let pair = |index: usize| [from[index], to[index]];
        let step = Step { slip: pair(0), velocity: pair(1), normal: pair(2), dt: 1.0 / samples as f64 };
        let (next, force) = law.advance(state, &step, &circumstance);
        state = next;
        let expected = to[0] / (1.0 / (sigma0 * to[2]) + compliance);
        assert!((force - expected).abs() < 1e-5, "sample {k}: {force} against {expected}");
    }
}

/// A contact that opens carries nothing, and the spring in series with its bristle gives nothing while it is open, however far its normal force would
/// pull: where it closes again, the bristle has gone as far as the slip, and so has the one without a spring.
#[test]
fn a_spring_in_series_with_an_open_contact_gives_nothing() {
    let plain: ModifiedLaw<f64> = ModifiedLaw::dahl(3.0, 0.4);
    let mut sprung = plain;
    sprung.set(Hook::SeriesCompliance, 0.4);
    let circumstance = Circumstance { preload: 1.0, ..Circumstance::default() };
    let ended = |law: &ModifiedLaw<f64>| {
        let mut state = law.rest_at(0.0);
        let mut force = 0.0;
        for k in 0..8 {
            let slip = [k, k + 1].map(|k| 0.01 * f64::from(k));
            // 1/(σ0 c) below nothing the spring would cancel the bristle.
            let normal = [-0.5 / 1.2, if k == 7 { 1e-9 } else { -1.5 / 1.2 }];
            let step = Step { slip, velocity: [1.0; 2], normal, dt: 0.01 };
            (state, force) = law.advance(state, &step, &circumstance);
        }
        force
    };
    let [plain, sprung] = [&plain, &sprung].map(ended);
    // A Dahl bristle that has gone 0.08 from rest: b = μ(1 − e^{−σ0 u/μ}) = 0.4(1 − e^{−0.6}).
    let expected = 1e-9 * 0.4 * (1.0 - (-0.6_f64).exp());
    assert!(
        (plain - expected).abs() < 1e-12 && (sprung - plain).abs() < 1e-15,
        "{plain} {sprung} {expected}"
    );
}

/// Presliding damping answers to the bristle's own rate, `μ = b + σ1 ż` with `ż = v (1 − r)^i`. At `i = 2` a ramp from rest has
/// `r = ξ/(1 + ξ)`, `ξ = σ0 u/μ`, so that `μ = μ_k ξ/(1 + ξ) + σ1 v/(1 + ξ)²`; Runge-Kutta steps are good to 1e-5.
#[test]
fn presliding_damping_answers_to_the_bristles_rate() {
    let (sigma0, friction, sigma1, speed, steps) = (3.0, 0.4, 0.05, 0.7, 64);
    let mut law: ModifiedLaw<f64> = ModifiedLaw::dahl(sigma0, friction);
    law.set(Hook::Exponent, 2.0);
    law.set(Hook::Sigma1, sigma1);
    let dt = 0.5 / f64::from(steps);
    let mut state = law.rest_at(0.0);
    for k in 0..steps {
        let slip = [k, k + 1].map(|k| speed * dt * f64::from(k));
        let step = Step { slip, velocity: [speed; 2], normal: [1.0; 2], dt };
        let (next, force) =
            law.advance(state, &step, &Circumstance { preload: 1.0, ..Circumstance::default() });
        state = next;
        let xi = sigma0 * slip[1] / friction;
        let expected = friction * xi / (1.0 + xi) + sigma1 * speed / (1.0 + xi).powi(2);
        assert!((force - expected).abs() < 1e-5, "step {k}: {force} against {expected}");
    }
}

/// Friction that falls with the normal force along a straight line, `μ = μ_k (1 + n(1 − x))`, `x = N/N₀`, is the power `q = 1`, and a
/// constant force beside Coulomb's, `μ = μ_k (1 − n + n/x)`, is `q = −1`.
#[test]
fn powers_of_the_normal_force_hold_the_usual_laws() {
    let (friction, n, reference) = (0.4, 0.3, 2.0);
    let sliding = |power: f64, normal: f64| {
        let mut law: ModifiedLaw<f64> = ModifiedLaw::dahl(1e3, friction);
        for (hook, value) in
            [(Hook::NormalExponent, n), (Hook::NormalReference, reference), (Hook::NormalPower, power + n)]
        {
            law.set(hook, value);
        }
        let step = Step { slip: [0.0, 0.1], velocity: [1.0; 2], normal: [normal; 2], dt: 0.1 };
        law.advance(law.rest_at(0.0), &step, &Circumstance { preload: 1.0, ..Circumstance::default() }).1
    };
    for normal in [0.5, 1.0, 2.0, 5.0] {
        let x = normal / reference;
        let expected = [friction * (1.0 + n * (1.0 - x)), friction * (1.0 - n + n / x)];
        for (power, expected) in [1.0, -1.0].into_iter().zip(expected) {
            let ratio = sliding(power, normal) / normal;
            assert!((ratio - expected).abs() < 1e-12, "{power} {normal}: {ratio} against {expected}");
        }
    }
}

/// A hook at zero changes nothing.
#[test]
fn hooks_at_zero_change_nothing() {
    let plain: ModifiedLaw<f64> = ModifiedLaw::dahl(3.0, 0.4);
    let reference = settled(&plain, 0.3, 256);
    for hook in [
        Hook::Asymmetry,
        Hook::Viscous,
        Hook::Position,
        Hook::NormalExponent,
        Hook::Wear,
        Hook::SeriesCompliance,
        Hook::ParallelStiffness,
        Hook::Backlash,
        Hook::ModulationCosine,
        Hook::Sigma1,
    ] {
        let mut law = plain;
        law.set(hook, 0.0);
        for (a, b) in reference.iter().zip(settled(&law, 0.3, 256)) {
            assert!((a.1 - b.1).abs() < 1e-9, "{hook:?}");
        }
    }
}

/// Derivatives by dual numbers are central differences (step 1e-6, error about 1e-8).
#[test]
fn derivatives_agree_with_differences() {
    let mut law: ModifiedLaw<f64> = ModifiedLaw::dahl(4.0, 0.4);
    for (hook, value) in [
        (Hook::StribeckRise, 0.2),
        (Hook::StribeckVelocity, 0.5),
        (Hook::StribeckExponent, 1.6),
        (Hook::RationalShare, 0.4),
        (Hook::LagTime, 0.05),
        (Hook::LagSaturation, 1.5),
        (Hook::LagPower, 1.7),
        (Hook::Asymmetry, 0.1),
        (Hook::Position, 0.2),
        (Hook::NormalExponent, 0.3),
        (Hook::NormalPower, 0.8),
        (Hook::SeriesCompliance, 0.05),
    ] {
        law.set(hook, value);
    }
    for hook in Hook::ALL {
        let Some(value) = law.get(hook) else { continue };
        let dual = law.lift(|h, x| Dual64::new(x, if h == hook { 1.0 } else { 0.0 }));
        let (mut above, mut below) = (law, law);
        above.set(hook, value + 1e-6);
        below.set(hook, value - 1e-6);
        let exact = settled(&dual, 0.3, 128);
        for ((d, a), b) in exact.iter().zip(settled(&above, 0.3, 128)).zip(settled(&below, 0.3, 128)) {
            let difference = (a.1 - b.1) / 2e-6;
            assert!(
                (d.1.eps - difference).abs() < 1e-4 * (1.0 + difference.abs()),
                "{hook:?} {} {difference}",
                d.1.eps
            );
            assert!((d.1.re - (a.1 + b.1) / 2.0).abs() < 1e-6);
        }
    }
}

/// Every kind of state and of saturation, one law each.
fn zoo() -> Vec<ModifiedLaw<f64>> {
    let dahl = ModifiedLaw::dahl(1.5e5, 0.4);
    let with = |law: &ModifiedLaw<f64>, hooks: &[(Hook, f64)]| {
        let mut law = *law;
        hooks.iter().for_each(|&(hook, value)| law.set(hook, value));
        law
    };
    let stribeck = with(
        &dahl,
        &[(Hook::StribeckRise, 0.15), (Hook::StribeckVelocity, 5e-4), (Hook::StribeckExponent, 1.7)],
    );
    let lugre = with(&stribeck, &[(Hook::Sigma1, 3.0), (Hook::DampingVelocity, 1e-3), (Hook::Viscous, 40.0)]);
    let hybrid = with(&lugre, &[(Hook::Breakaway, 0.4)]);
    let mut laws = vec![dahl, stribeck, lugre, hybrid];
    for (law, hooks) in [
        (dahl, vec![(Hook::Exponent, 0.6)]),
        (stribeck, vec![(Hook::Exponent, 1.4)]),
        (dahl, vec![(Hook::SeriesCompliance, 3e-8)]),
        (stribeck, vec![(Hook::FlowPower, 1.5)]),
        (hybrid, vec![(Hook::FlowPower, 1.5)]),
        (hybrid, vec![(Hook::Exponent, 1.4)]),
        (lugre, vec![(Hook::LagTime, 4e-3)]),
        (lugre, vec![(Hook::VelocityLag, 2e-3), (Hook::LagSaturation, 2.0)]),
        (hybrid, vec![(Hook::SpeedLag, 2e-3)]),
        (hybrid, vec![(Hook::Asymmetry, 0.2), (Hook::Position, 3e3)]),
        (
            dahl,
            vec![
                (Hook::FilmLoss, 0.4),
                (Hook::FilmRise, 8e-3),
                (Hook::FilmFall, 2e-3),
                (Hook::FilmVelocity, 2e-3),
            ],
        ),
        (dahl, vec![(Hook::AgeingGain, 0.1), (Hook::AgeingTime, 1e-3), (Hook::AgeingDistance, 2e-6)]),
        (hybrid, vec![(Hook::Backlash, 4e-6)]),
        (dahl, vec![(Hook::Backlash, 3e-7), (Hook::BacklashPower, 3.0)]),
        (lugre, vec![(Hook::Backlash, 4e-6), (Hook::ParallelStiffness, 1e4)]),
        (lugre, vec![(Hook::ForceLag, 2e-3)]),
        (
            dahl,
            vec![
                (Hook::ModulationCosine, 0.2),
                (Hook::ModulationSine, -0.1),
                (Hook::ModulationSteepness, 2.0),
            ],
        ),
        (
            dahl,
            vec![
                (Hook::PeriodicCosine, 0.2),
                (Hook::PeriodicSine, 0.1),
                (Hook::PeriodicNumber, 9.0),
                (Hook::PeriodicSteepness, 3.0),
                (Hook::PeriodicCorner, 1.3),
            ],
        ),
        (
            dahl,
            vec![
                (Hook::ModulationCosine, 0.2),
                (Hook::ModulationSine, -0.1),
                (Hook::ModulationCosine2, 0.05),
                (Hook::ModulationSine2, 0.02),
                (Hook::ModulationCosine3, -0.03),
                (Hook::ModulationSine3, 0.04),
                (Hook::ModulationCosine4, 0.01),
                (Hook::ModulationSine4, 0.03),
            ],
        ),
        (
            dahl,
            vec![
                (Hook::Viscous, 50.0),
                (Hook::ViscousReference, 2e-3),
                (Hook::ViscousPower, 0.4),
                (Hook::ViscousCore, 0.3),
                (Hook::ViscousTurn, 1.6),
            ],
        ),
        (
            dahl,
            vec![
                (Hook::AgeingGain, 0.1),
                (Hook::AgeingTime, 1e-3),
                (Hook::AgeingDistance, 2e-6),
                (Hook::AgeingPower, 0.4),
            ],
        ),
        (stribeck, vec![(Hook::StribeckBend, 1.4)]),
        (stribeck, vec![(Hook::StribeckBend, 0.7)]),
        (dahl, vec![(Hook::NormalExponent, 0.3), (Hook::Wear, 0.2)]),
    ] {
        laws.push(with(&law, &hooks));
    }
    laws
}

/// A period of 50 ms of a slip of two lines under a normal force that varies, and the force that a rigid contact would take.
struct Course {
    slip: Vec<f64>,
    velocity: Vec<f64>,
    normal: Vec<f64>,
    held: Vec<f64>,
}

const SAMPLES: usize = 256;

impl Course {
    fn new(amplitude: f64) -> Self {
        let at = |of: fn(f64) -> f64, size: f64| -> Vec<f64> {
            (0..SAMPLES).map(|k| size * of(std::f64::consts::TAU * k as f64 / SAMPLES as f64)).collect()
        };
        let slip = at(|t| t.cos() + 0.3 * (2.0 * t).sin(), amplitude);
        let velocity = at(|t| -t.sin() + 0.6 * (2.0 * t).cos(), amplitude * std::f64::consts::TAU / 0.05);
        let held = velocity.iter().map(|v| 4e3 * v).collect();
        Self { slip, velocity, normal: at(|t| 50.0 + 12.0 * t.sin(), 1.0), held }
    }

    fn along(&self, rigid: bool) -> Periodic<'_> {
        Periodic {
            slip: &self.slip,
            velocity: &self.velocity,
            normal: &self.normal,
            trial: if rigid { &self.held } else { &[] },
            dt: 0.05 / SAMPLES as f64,
            preload: 50.0,
            progress: 0.4,
            worked: [0.7; 2],
            modulation: 3,
            modulation_phase: 0.7,
            deflection: None,
            drift: 0.0,
        }
    }
}

/// The settled force against the slow way: the law marched along the motion period after period, fifty of them, from the same
/// rest. What the slowest state has not forgotten by then, and what the faster way leaves of it, is below 1e-8 of the friction.
#[test]
fn settling_part_by_part_is_marching_for_long() {
    for course in [2e-5, 1e-6].map(Course::new) {
        for (number, (law, rigid)) in
            zoo().into_iter().flat_map(|law| [(law, false), (law, true)]).enumerate()
        {
            let along = course.along(rigid);
            let mut force = vec![0.0; SAMPLES];
            let start = law.settle(&along, &mut force);
            let virgin = Step {
                slip: [0.0, along.slip[0]],
                velocity: [along.velocity[0]; 2],
                normal: [along.normal[0]; 2],
                dt: along.dt,
            };
            let mut state = law.rest_at(0.0);
            if !along.is_rigid(&law) {
                state = law.advance(state, &virgin, &along.circumstance(&law, SAMPLES - 1)).0;
            }
            let mut marched = vec![0.0; SAMPLES];
            for k in (0..50).flat_map(|_| 0..SAMPLES) {
                let (circumstance, next) = (along.circumstance(&law, k), along.next(k));
                (state, marched[next]) = if along.is_rigid(&law) {
                    law.advance_rigid(state, &along.step(k), (along.trial[next], &circumstance))
                } else {
                    law.advance(state, &along.step(k), &circumstance)
                };
            }
            let apart = force.iter().zip(&marched).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            assert!(apart < 1e-8 * 20.0, "law {number}: {apart:.1e} N");
            let ModifiedState(reached) = state;
            for (a, b) in start.0.iter().zip(reached).take(law.states()) {
                assert!((a - b).abs() < 1e-7 * (a.abs() + 1e-3), "law {number}: {a} {b}");
            }
        }
    }
}

/// The state after one period marched step by step from a start, and the force at every sample.
fn marched(
    law: &ModifiedLaw<f64>,
    along: &Periodic<'_>,
    start: ModifiedState<f64>,
) -> (ModifiedState<f64>, Vec<f64>) {
    let (mut state, mut force) = (start, vec![0.0; SAMPLES]);
    for k in 0..SAMPLES {
        (state, force[along.next(k)]) = law.advance(state, &along.step(k), &along.circumstance(law, k));
    }
    (state, force)
}

/// A contact that has not settled begins its period with a deflection of its own: the force is that of one period marched from there, and the creep
/// what the deflection has gained in it. Begun with the settled deflection, it creeps by nothing.
#[test]
fn a_period_may_begin_with_a_deflection_of_its_own() {
    let course = Course::new(1e-6);
    let plain = course.along(false);
    for (number, law) in zoo().into_iter().enumerate() {
        let settled = law.settle(&plain, &mut vec![0.0; SAMPLES]).0[0];
        // A force that lags follows that of the period, which begins with its last sample: it knows no jump there.
        let away = if law.get(Hook::ForceLag).is_some() { 0.0 } else { 0.03 };
        for deflection in [settled, settled + away] {
            let along = Periodic { deflection: Some(deflection), ..plain };
            let mut force = vec![0.0; SAMPLES];
            let start = law.settle(&along, &mut force);
            assert_eq!(start.0[0], deflection, "law {number}");
            let (state, marched) = marched(&law, &along, start);
            let apart = force.iter().zip(&marched).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            assert!(apart < 1e-8 * 20.0, "law {number}: {apart:.1e} N");
            let creep = law.creep(&along);
            assert!((creep - (state.0[0] - deflection)).abs() < 1e-10, "law {number}: {creep:.1e}");
            assert!(deflection != settled || creep.abs() < 1e-8, "law {number}: {creep:.1e}");
        }
    }
}

/// Where a contact gains slip beside its motion, the deflection of its own comes back to what it was, and the force is that of the march. A bristle that
/// forgets little gains what it would have lost over its stiffness; one that has settled gains nothing, and neither does one with play.
#[test]
fn a_contact_that_gains_slip_keeps_its_deflection() {
    let course = Course::new(1e-6);
    let plain = course.along(false);
    let mut drifting = 0;
    for (number, law) in zoo().into_iter().enumerate() {
        let settled = law.settle(&plain, &mut vec![0.0; SAMPLES]).0[0];
        let at = |deflection: f64| {
            let away = Periodic { deflection: Some(deflection), ..plain };
            (law.drift(&away), Periodic { drift: law.drift(&away), ..away }, law.creep(&away))
        };
        let (none, ..) = at(settled);
        assert!(none.abs() < 1e-14, "law {number}: {none:.1e} m");
        let (drift, along, creep) = at(settled + 0.03);
        if law.get(Hook::Backlash).is_some() {
            assert_eq!(drift, 0.0, "law {number}");
            continue;
        }
        if law.get(Hook::ForceLag).is_some() {
            continue;
        }
        drifting += usize::from(drift != 0.0);
        let mut force = vec![0.0; SAMPLES];
        let start = law.settle(&along, &mut force);
        let (state, marched) = marched(&law, &along, start);
        let apart = force.iter().zip(&marched).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(apart < 1e-8 * 20.0, "law {number}: {apart:.1e} N");
        let kept = state.0[0] - along.deflection.unwrap_or_default();
        assert!(kept.abs() < 1e-8 * creep.abs() + 1e-11, "law {number}: {kept:.1e} of {creep:.1e}");
        if drift != 0.0 && creep.abs() < 1e-3 {
            let stiffness = law.get(Hook::Sigma0).unwrap();
            assert!(drift * stiffness > -0.9 * creep, "law {number}: {drift:.1e} m, {creep:.1e}");
        }
    }
    assert!(drifting > 3, "{drifting}");
}

/// Steps along one motion that share their ends are the steps one by one, derivatives included, but for rounding.
#[test]
fn steps_along_one_motion_share_their_ends() {
    let course = Course::new(2e-5);
    let along = course.along(false);
    for (number, law) in zoo().into_iter().enumerate() {
        let law = law
            .lift(|hook, value| Dual64::new(value, if hook == Hook::MuKinetic { 1.0 } else { 0.3 * value }));
        let (mut one, mut shared, mut reached) =
            (law.rest_at(0.0.into()), law.rest_at(0.0.into()), Reached::default());
        for k in (0..2).flat_map(|_| 0..SAMPLES) {
            let step = along.step(k);
            let step = Step {
                slip: step.slip.map(Dual64::from),
                velocity: step.velocity.map(Dual64::from),
                normal: step.normal.map(Dual64::from),
                dt: step.dt,
            };
            let circumstance = along.circumstance(&law, k);
            let (first, second);
            (one, first) = law.advance(one, &step, &circumstance);
            (shared, second) = law.advance_on(shared, &step, (&circumstance, &mut reached));
            let apart = (first.re - second.re).abs() + (first.eps - second.eps).abs();
            assert!(
                apart < 1e-9 * (first.re.abs() + first.eps.abs() + 1.0),
                "law {number}, step {k}: {apart:.1e}"
            );
        }
    }
}

/// The second and third harmonic of a wave of number `q` alone are waves of `2q` and `3q`.
#[test]
fn harmonics_of_a_wave_are_shorter_waves() {
    let wave = |number: f64, harmonics: [f64; 3]| {
        let mut law: ModifiedLaw<f64> = ModifiedLaw::dahl(2e2, 0.5);
        let sines = [Hook::PeriodicSine, Hook::PeriodicSine2, Hook::PeriodicSine3];
        let cosines = [Hook::PeriodicCosine, Hook::PeriodicCosine2, Hook::PeriodicCosine3];
        for (k, size) in harmonics.into_iter().enumerate() {
            law.set(sines[k], 0.3 * size);
            law.set(cosines[k], 0.2 * size);
        }
        law.set(Hook::PeriodicNumber, number);
        settled(&law, 0.02, 256)
    };
    for (k, harmonics) in [(2.0, [0.0, 1.0, 0.0]), (3.0, [0.0, 0.0, 1.0])] {
        let pairs = wave(90.0, harmonics).into_iter().zip(wave(90.0 * k, [1.0, 0.0, 0.0]));
        pairs.for_each(|(a, b)| assert!((a.1 - b.1).abs() < 1e-12, "{k}: {a:?} {b:?}"));
    }
}
