//! What the modified law must satisfy.

use super::{Circumstance, Hook, ModifiedLaw};
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
        (vec![(Hook::Asymmetry, 0.2)], Hook::AsymmetryVelocity, 1e-9, 1e-5),
        (vec![(Hook::NormalExponent, 0.3)], Hook::NormalCurvature, 0.0, 1e-12),
        (vec![(Hook::Position, 0.4)], Hook::PositionScale, 1e6, 1e-9),
        (vec![(Hook::Viscous, 0.1), (Hook::ViscousReference, 2.0)], Hook::ViscousPower, 1.0, 1e-12),
        (vec![(Hook::Wear, 0.4)], Hook::WearExponent, 1.0, 1e-12),
        (
            vec![(Hook::StribeckRise, 0.2), (Hook::StribeckVelocity, 0.5), (Hook::LagTime, 0.05)],
            Hook::LagSaturation,
            0.0,
            1e-12,
        ),
        (vec![(Hook::Sigma1, 0.01), (Hook::DampingVelocity, 1.0)], Hook::DampingRational, 0.0, 1e-12),
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
        (Hook::Asymmetry, 0.1),
        (Hook::Position, 0.2),
        (Hook::NormalExponent, 0.3),
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
