//! What further hooks add, against their formulas.

use super::settled;
use crate::effects::{Circumstance, Hook, ModifiedLaw};
use crate::law::Step;

/// Forces beside the bristle under a normal force of 1 N, sample by sample: what a hook adds is its formula.
#[test]
fn forces_beside_the_bristle_are_their_formulas() {
    let plain: ModifiedLaw<f64> = ModifiedLaw::dahl(3.0, 0.4);
    let amplitude = 0.3;
    let with = |hooks: &[(Hook, f64)]| {
        let mut law = plain;
        hooks.iter().for_each(|&(hook, value)| law.set(hook, value));
        settled(&law, amplitude, 256)
    };
    let velocity = |k: usize| {
        let phase = std::f64::consts::TAU * (k + 1) as f64 / 256.0;
        amplitude * std::f64::consts::TAU * phase.cos()
    };
    let lattice = [(Hook::LatticeCosine, 0.1), (Hook::LatticeSine, -0.2), (Hook::PeriodicNumber, 8.0)];
    let shoulders = [(Hook::ShoulderStiffness, 5.0), (Hook::ShoulderGap, 0.2)];
    let without = settled(&plain, amplitude, 256);
    let found = [with(&[(Hook::ViscousNormal, 0.7)]), with(&lattice), with(&shoulders)];
    for (k, &(slip, force)) in without.iter().enumerate() {
        let beyond = (slip.abs() - 0.2).max(0.0) * slip.signum();
        let expected = [0.7 * velocity(k), 0.1 * (8.0 * slip).cos() - 0.2 * (8.0 * slip).sin(), 5.0 * beyond];
        for (found, expected) in found.iter().zip(expected) {
            assert!((found[k].1 - force - expected).abs() < 1e-12, "{k}: {} {expected}", found[k].1 - force);
        }
    }
    // Damping of what sticks: `σ1 v (1 − |r|)` beside the bristle's force.
    let stuck = with(&[(Hook::Sigma1, 0.02), (Hook::DampingStuck, 1.0)]);
    for (k, (found, plain)) in stuck.iter().zip(&without).enumerate() {
        let expected = plain.1 + 0.02 * velocity(k) * (1.0 - plain.1.abs() / 0.4).max(0.0);
        assert!((found.1 - expected).abs() < 1e-12);
    }
    let sided = with(&[(Hook::BristleAsymmetry, 0.3), (Hook::BristleTurn, 0.5)]);
    for (found, plain) in sided.iter().zip(&without) {
        let y = plain.1 / (0.5 * 0.4);
        let expected = plain.1 * (1.0 + 0.3 * y / (1.0 + y * y).sqrt());
        assert!((found.1 - expected).abs() < 1e-12);
    }
}

/// The friction coefficient of a stiff contact under a velocity `V cos ωt` that is lagged with `ωτ = 0.3` and set ahead again by the whole of
/// the lag: the all-pass turns it by `2 arctan 0.3` and leaves its size. A thousand samples a period interpolate memory and coefficient to some 1e-5.
#[test]
fn a_lag_set_ahead_again_is_a_delay() {
    let (rise, fast) = (0.2, 0.8);
    let mut law: ModifiedLaw<f64> = ModifiedLaw::dahl(1e5, 0.3);
    for (hook, value) in [
        (Hook::StribeckRise, rise),
        (Hook::StribeckVelocity, fast),
        (Hook::StribeckExponent, 2.0),
        (Hook::VelocityLag, 0.3 / std::f64::consts::TAU),
        (Hook::LagDelay, 1.0),
    ] {
        law.set(hook, value);
    }
    let (amplitude, samples) = (0.3, 1024);
    let found = settled(&law, amplitude, samples);
    let late = 2.0 * 0.3_f64.atan();
    for (k, &(_, force)) in found.iter().enumerate() {
        let phase = std::f64::consts::TAU * (k + 1) as f64 / samples as f64;
        if phase.cos().abs() < 0.05 {
            continue;
        }
        let delayed = amplitude * std::f64::consts::TAU * (phase - late).cos();
        let expected = (0.3 + rise * (-(delayed / fast).powi(2)).exp()) * phase.cos().signum();
        assert!((force - expected).abs() < 5e-5, "{k}: {force} {expected}");
    }
}

/// Wear with the work is that with the number of the run, at the place that the work has.
#[test]
fn wear_goes_with_the_run_or_with_the_work() {
    let coefficient = |hooks: &[(Hook, f64)], circumstance: &Circumstance| {
        let mut law: ModifiedLaw<f64> = ModifiedLaw::dahl(1e6, 0.3);
        [(Hook::Wear, 0.4)].iter().chain(hooks).for_each(|&(hook, value)| law.set(hook, value));
        let step = Step { slip: [0.0, 1.0], velocity: [1.0; 2], normal: [1.0; 2], dt: 1.0 };
        law.advance(law.rest_at(0.0), &step, circumstance).1
    };
    let over = |progress, worked| Circumstance { preload: 1.0, progress, worked, ..Circumstance::default() };
    let at = |progress, worked: f64| over(progress, [worked; 2]);
    let settling = (Hook::WearSettling, 3.0);
    for shape in [vec![], vec![settling]] {
        let by_work = [&shape[..], &[(Hook::WearWork, 1.0)]].concat();
        let (run, work) = (coefficient(&shape, &at(0.7, 0.2)), coefficient(&by_work, &at(0.2, 0.7)));
        assert!((run - work).abs() < 1e-12, "{run} {work}");
    }
    assert!((coefficient(&[(Hook::WearWork, 1.0)], &at(0.2, 0.7)) - 0.3 * 1.28).abs() < 1e-9);
    // Half of a run's own work counts, or the share that is told: 0.3 (1 + 0.4 · 0.7), 0.3 (1 + 0.4 · 0.9).
    let own = over(0.2, [0.5, 0.9]);
    assert!((coefficient(&[(Hook::WearWork, 1.0)], &own) - 0.3 * 1.28).abs() < 1e-9);
    let whole = [(Hook::WearWork, 1.0), (Hook::WearOwn, 1.0)];
    assert!((coefficient(&whole, &own) - 0.3 * 1.36).abs() < 1e-9);
}
