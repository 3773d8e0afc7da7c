//! The benchmark of a mass on a spring with dry friction: four parameters from the position alone.

use crate::case::{Case, Outcome, Row};
use frettrace_identify::{FitSettings, Model, NoSolution, Parameter, fit_from_many, starts};
use nalgebra::DMatrix;
use rand::SeedableRng;
use rand_distr::{Distribution, StandardNormal};
use rand_pcg::Pcg64;

/// The case.
pub const CASE: Case = Case { name: "compare_two_bodies", run };

/// Mass (kg), spring (N/m), friction distance (m) and friction force (N).
const TRUE: [f64; 4] = [400.0, 2000.0, 1e-4, 1700.0];
const START: [f64; 4] = [380.0, 2200.0, 1.2e-4, 1900.0];
const NAMES: [(&str, &str); 4] = [("mass", "kg"), ("spring", "N/m"), ("distance", "m"), ("friction", "N")];
/// Samples of a run and their distance (s).
const SAMPLES: usize = 1000;
const STEP: f64 = 5e-3;
/// Peaks of the saw-tooth forces (N) of the two runs that are fitted and the one that is not.
const PEAKS: [f64; 2] = [3000.0, 6000.0];
const UNSEEN: f64 = 4500.0;
/// Steps between samples in the data and in the fit: not the same, so that the fit cannot undo the data's own error.
const FINE: usize = 256;
const COARSE: usize = 64;
/// Noise of the position (m).
const NOISE: f64 = 1e-5;
/// Starts about the benchmark's own, which is the first.
const STARTS: usize = 12;

fn run() -> anyhow::Result<Outcome> {
    let measured: Vec<Vec<f64>> =
        PEAKS.iter().enumerate().map(|(k, peak)| noisy(&positions(&TRUE, *peak, FINE), k)).collect();
    let parameters = NAMES
        .iter()
        .zip(START)
        .map(|((name, unit), value)| Parameter::positive(name, unit, (value / 100.0, value * 100.0)));
    let model = Slider { parameters: parameters.collect(), measured };
    // A mass that stops or does not quite stop is another motion: χ² has minima in the friction distance beside the true one.
    let many = fit_from_many(
        &model,
        &starts(&model.parameters, &START, &[0.1, 0.1, 0.7, 0.15], STARTS),
        &FitSettings { max_iterations: 20, ..FitSettings::default() },
    )?;
    let found = many.best();
    let mut rows: Vec<Row> = (0..4)
        .map(|j| Row {
            quantity: format!("{} of the two-body benchmark", NAMES[j].0),
            unit: NAMES[j].1,
            source: "idnlgreydemo: true values 400, 2000, 1e-4, 1700",
            expected: Some(TRUE[j]),
            found: found.values[j],
            tolerance: 0.02 * TRUE[j],
            reason: "10 µm of noise on the position; the friction distance is 100 µm",
        })
        .collect();
    let unseen = positions(&TRUE, UNSEEN, FINE);
    let predicted = positions(&found.values, UNSEEN, COARSE);
    rows.push(Row {
        quantity: "position of the run that was not fitted, RMS error".to_owned(),
        unit: "m",
        source: "the noise",
        expected: Some(0.0),
        found: rms(unseen.iter().zip(&predicted).map(|(a, b)| a - b)),
        tolerance: NOISE,
        reason: "no more than the noise of a position",
    });
    Ok(Outcome::Ran(rows))
}

/// A saw-tooth of period 2.5 s.
fn force(peak: f64, time: f64) -> f64 {
    let phase = (time / 2.5).fract();
    peak * if phase < 0.25 {
        4.0 * phase
    } else if phase < 0.75 {
        2.0 - 4.0 * phase
    } else {
        4.0 * phase - 4.0
    }
}

/// `m ẍ = u − k x − F`, `Ḟ = (f ẋ − |ẋ| F)/e`: friction exact in each step of constant speed, motion by the trapezoidal rule.
fn positions(values: &[f64], peak: f64, steps: usize) -> Vec<f64> {
    let &[mass, spring, distance, level] = values else { return Vec::new() };
    let dt = STEP / steps as f64;
    let (mut x, mut v, mut friction) = (0.0, 0.0, 0.0);
    let mut out = Vec::with_capacity(SAMPLES);
    for k in 0..SAMPLES * steps {
        if k % steps == 0 {
            out.push(x);
        }
        let time = (k as f64 + 0.5) * dt;
        // The bristle is stiffer than the spring by four orders: both slopes go into the step implicitly (trapezoid).
        let slope = spring + (level - friction * f64::signum(v)) / distance;
        let pull = force(peak, time) - spring * x - friction;
        let next = ((mass / dt - 0.25 * dt * slope) * v + pull) / (mass / dt + 0.25 * dt * slope);
        let travelled = 0.5 * dt * (v + next);
        let limit = level * f64::signum(travelled);
        friction = limit + (friction - limit) * (-travelled.abs() / distance).exp();
        x += travelled;
        v = next;
    }
    out
}

/// White noise of a fixed seed.
fn noisy(clean: &[f64], run: usize) -> Vec<f64> {
    let mut random = Pcg64::seed_from_u64(run as u64);
    clean
        .iter()
        .map(|x| {
            let unit: f64 = StandardNormal.sample(&mut random);
            x + NOISE * unit
        })
        .collect()
}

fn rms(values: impl Iterator<Item = f64>) -> f64 {
    let (sum, count) = values.fold((0.0, 0.0), |(sum, count), x| (sum + x * x, count + 1.0));
    (sum / f64::max(count, 1.0)).sqrt()
}

/// Measured against simulated positions of the fitted runs.
struct Slider {
    parameters: Vec<Parameter>,
    measured: Vec<Vec<f64>>,
}

impl Model for Slider {
    type Memory = ();

    fn parameters(&self) -> &[Parameter] {
        &self.parameters
    }

    fn residual_count(&self) -> usize {
        PEAKS.len() * SAMPLES
    }

    fn memory(&self) {}

    fn residual(&self, values: &[f64], (): &mut (), residual: &mut [f64]) -> Result<(), NoSolution> {
        for ((peak, measured), out) in PEAKS.iter().zip(&self.measured).zip(residual.chunks_mut(SAMPLES)) {
            for ((out, x), y) in out.iter_mut().zip(positions(values, *peak, COARSE)).zip(measured) {
                *out = (y - x) / NOISE;
            }
        }
        if residual.iter().all(|r| r.is_finite()) { Ok(()) } else { Err(NoSolution) }
    }

    fn linearise(
        &self,
        values: &[f64],
        _free: &[bool],
        memory: &mut (),
        (residual, jacobian): (&mut [f64], &mut DMatrix<f64>),
    ) -> Result<(), NoSolution> {
        self.residual(values, memory, residual)?;
        let mut beside = vec![0.0; residual.len()];
        for j in 0..values.len() {
            let mut moved = values.to_vec();
            moved[j] *= 1.0 + 1e-6;
            self.residual(&moved, memory, &mut beside)?;
            for (row, (a, b)) in beside.iter().zip(&*residual).enumerate() {
                jacobian[(row, j)] = (a - b) / (1e-6 * values[j]);
            }
        }
        Ok(())
    }
}
