//! Friction from the energy of loops and from amplitudes at resonance.

use crate::case::{Case, Outcome, Row};
use frettrace_friction::{Closing, Period, close_loop, laws::Dahl};
use nalgebra::{Matrix2, Vector2};
use std::f64::consts::{PI, TAU};

/// The case.
pub const CASE: Case = Case { name: "compare_loop_area", run };

/// Friction force and viscous damping ratio that the two methods should find (natural frequency, stiffness 1).
const FRICTION: f64 = 1.0;
const DAMPING: f64 = 0.1;
/// Amplitudes of the excitation at resonance: above 4/π of the friction, so that the mass never stops.
const EXCITATIONS: [f64; 3] = [2.5, 4.0, 8.0];
/// Amplitudes of the loops in sliding distances: mostly sliding, where the area knows the friction, and mostly sticking,
/// where it knows the stiffness.
const AMPLITUDES: [f64; 4] = [0.5, 1.0, 5.0, 10.0];
const SAMPLES: usize = 2000;

fn run() -> anyhow::Result<Outcome> {
    let mut rows = resonance();
    rows.extend(energy()?);
    Ok(Outcome::Ran(rows))
}

/// Liang and Feeny: `P = 4F/π + 2ζX` at resonance, a straight line through two or more pairs (excitation, amplitude).
fn resonance() -> Vec<Row> {
    let (mut normal, mut right) = (Matrix2::zeros(), Vector2::zeros());
    for excitation in EXCITATIONS {
        let regressor = Vector2::new(4.0 / PI, 2.0 * amplitude(excitation));
        normal += regressor * regressor.transpose();
        right += regressor * excitation;
    }
    let found = normal.lu().solve(&right).unwrap_or_else(Vector2::zeros);
    let names = [("friction force by regression at resonance", FRICTION), ("damping ratio by it", DAMPING)];
    let row = |(k, (name, truth)): (usize, &(&str, f64))| Row {
        quantity: (*name).to_owned(),
        unit: "1",
        source: "Den Hartog's steady motion with viscous damping, r = 1",
        expected: Some(*truth),
        found: found[k],
        tolerance: 0.02 * truth,
        reason: "the method takes the first harmonic of the friction for all of it",
    };
    names.iter().enumerate().map(row).collect()
}

/// Exact amplitude at resonance under an excitation (`X = −Gβ + √(V² − (Hβ)²)` at r = 1, times the excitation).
fn amplitude(excitation: f64) -> f64 {
    let beta = FRICTION / excitation;
    let s = (1.0 - DAMPING * DAMPING).sqrt();
    let (swell, turn) = (DAMPING * PI, s * PI);
    let d = swell.cosh() + turn.cos();
    let g = (swell.sinh() - DAMPING / s * turn.sin()) / d;
    let h = turn.sin() / (s * d);
    excitation * ((0.25 / (DAMPING * DAMPING) - (h * beta).powi(2)).sqrt() - g * beta)
}

/// Stiffness and friction of Dahl's law from the energies of loops alone, `W = 4(F²/σ)(a − tanh a)`, `a = σA/F`.
fn energy() -> anyhow::Result<Vec<Row>> {
    let law = Dahl { sigma0: 2.0, mu_k: 1.0, exponent: 1.0 };
    let amplitudes = AMPLITUDES.map(|a| a * law.mu_k / law.sigma0);
    let mut areas = [0.0; AMPLITUDES.len()];
    for (area, amplitude) in areas.iter_mut().zip(amplitudes) {
        *area = loop_area(&law, amplitude)?;
    }
    let mut guess = Vector2::new(1.0_f64.ln(), 2.0_f64.ln());
    // Gauss-Newton on logarithms of energies and parameters: both are positive, and the energies span three decades.
    for _ in 0..30 {
        let (mut normal, mut right) = (Matrix2::zeros(), Vector2::zeros());
        for (area, amplitude) in areas.iter().zip(amplitudes) {
            let of = |p: Vector2<f64>| closed_form(p[0].exp(), p[1].exp(), amplitude).ln();
            let here = of(guess);
            let slope = |e: Vector2<f64>| (of(guess + e * 1e-6) - here) / 1e-6;
            let gradient = Vector2::new(slope(Vector2::x()), slope(Vector2::y()));
            normal += gradient * gradient.transpose();
            right += gradient * (area.ln() - here);
        }
        guess += normal.lu().solve(&right).unwrap_or_else(Vector2::zeros);
    }
    let row = |name: &str, truth: f64, found: f64| Row {
        quantity: name.to_owned(),
        unit: "1",
        source: "Dahl's loops, exponent 1",
        expected: Some(truth),
        found,
        tolerance: 1e-3 * truth,
        reason: "2000 samples a loop",
    };
    Ok(vec![
        row("stiffness from loop areas alone", law.sigma0, guess[0].exp()),
        row("friction from loop areas alone", law.mu_k, guess[1].exp()),
    ])
}

fn closed_form(stiffness: f64, friction: f64, amplitude: f64) -> f64 {
    let a = stiffness * amplitude / friction;
    4.0 * friction * friction / stiffness * (a - a.tanh())
}

fn loop_area(law: &Dahl<f64>, amplitude: f64) -> anyhow::Result<f64> {
    let phase = |k: usize| TAU * k as f64 / SAMPLES as f64;
    let slip: Vec<f64> = (0..SAMPLES).map(|k| amplitude * phase(k).cos()).collect();
    let velocity: Vec<f64> = (0..SAMPLES).map(|k| -amplitude * TAU * phase(k).sin()).collect();
    let normal = [1.0; SAMPLES];
    let period = Period { slip: &slip, velocity: &velocity, normal: &normal, dt: 1.0 / SAMPLES as f64 };
    let mut force = vec![0.0; SAMPLES];
    close_loop(law, &period, &mut force, Closing::default())?;
    Ok(force.iter().zip(&velocity).map(|(f, v)| f * v / SAMPLES as f64).sum())
}
