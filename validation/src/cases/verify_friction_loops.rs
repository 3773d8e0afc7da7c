//! Steady loops of the Dahl law against their closed form.

use crate::case::{Case, Outcome, Row};
use frettrace_friction::{Closing, Period, close_loop, laws::Dahl};
use std::f64::consts::TAU;

/// The case.
pub const CASE: Case = Case { name: "verify_friction_loops", run };

/// Amplitudes `a = σ0 A/μ` and energies `W σ0/(μ² N) = 4 (a − tanh a)` of the loop with exponent 1.
const AMPLITUDES: [f64; 3] = [0.5, 1.0, 5.0];
const SAMPLES: usize = 2000;

fn run() -> anyhow::Result<Outcome> {
    let rows = AMPLITUDES.iter().map(|&a| {
        Ok(Row {
            quantity: format!("Dahl energy per cycle at amplitude {a}"),
            unit: "1",
            source: "closed form 4 (a − tanh a)",
            expected: Some(4.0 * (a - a.tanh())),
            found: energy(a)?,
            tolerance: 1e-5 * 4.0 * (a - a.tanh()),
            reason: "2000 samples a period, sums of second order",
        })
    });
    Ok(Outcome::Ran(rows.collect::<anyhow::Result<_>>()?))
}

/// Energy of a loop of slip amplitude `a` with σ0 = μ = N = 1.
fn energy(a: f64) -> anyhow::Result<f64> {
    let phase = |k: usize| TAU * k as f64 / SAMPLES as f64;
    let slip: Vec<f64> = (0..SAMPLES).map(|k| a * phase(k).cos()).collect();
    let velocity: Vec<f64> = (0..SAMPLES).map(|k| -a * TAU * phase(k).sin()).collect();
    let period =
        Period { slip: &slip, velocity: &velocity, normal: &[1.0; SAMPLES], dt: 1.0 / SAMPLES as f64 };
    let mut force = vec![0.0; SAMPLES];
    let law = Dahl { sigma0: 1.0, mu_k: 1.0, exponent: 1.0 };
    close_loop(&law, &period, &mut force, Closing::default())?;
    Ok(force.iter().zip(&velocity).map(|(f, v)| f * v / SAMPLES as f64).sum())
}
