//! A modulation of the preload with a frequency of its own.
//!
//! Under `N (1 + a cos(ωt + φ))` a sliding contact's force `L` becomes `L (1 + a cos(ωt + φ))`: of what a law leaves, `r`,
//! `z(ω) = 2 Σ_j r_j L_j e^{−iωt_j} / Σ_j L_j²` is the amplitude `a e^{iφ}`, and its power over all runs shows the frequency.

use super::run::{OpenRun, Wave};
use super::search::Fitted;
use crate::series::Series;
use frettrace_fourier::spectrum;
use frettrace_friction::effects::{Hook, ModifiedLaw};
use nalgebra::DVector;
use num_complex::Complex64;
use std::f64::consts::TAU;

/// Finer grid of frequencies than a record's bins.
const FINER: usize = 8;
/// Periods in a record below which a modulation is a drift.
const LEAST_PERIODS: f64 = 2.0;
/// Frequencies that are tried.
const TRIED: usize = 2;
/// Least distance of these, in bins of the record.
const APART: f64 = 2.0;

/// What a law leaves times its force, sample by sample from where it has settled, and the sum of the force's squares.
fn product(run: &OpenRun, law: &ModifiedLaw<f64>, xi: &DVector<f64>) -> (Vec<f64>, f64) {
    let (motion, answered) = run.answered(law, xi);
    let first = Series::settling(answered.len());
    let left: Vec<f64> =
        motion.force.iter().zip(&answered).map(|(force, answered)| force - answered).collect();
    // A drift that the run leaves open is no part of it.
    let left = run.faster(&left);
    let mut product = vec![0.0; answered.len()];
    for k in first..answered.len() {
        product[k] = left[k] * answered[k];
    }
    let square = answered[first..].iter().map(|f| f * f).sum::<f64>();
    (product, square.max(f64::MIN_POSITIVE))
}

/// Amplitude `z(ω)` of a run.
fn amplitude(run: &OpenRun, (law, xi): (&ModifiedLaw<f64>, &DVector<f64>), omega: f64) -> Complex64 {
    let (product, square) = product(run, law, xi);
    let turn = Complex64::from_polar(1.0, -omega * run.whole.dt);
    let sum = product.iter().rev().fold(Complex64::ZERO, |sum, p| sum * turn + p);
    sum * (2.0 / square)
}

/// The modulation that a run asks for beside a law that has one.
pub(super) fn phased(run: &OpenRun, law: &ModifiedLaw<f64>, omega: f64) -> Wave {
    let mut plain = *law;
    plain.set(Hook::ModulationCosine, 0.0);
    plain.set(Hook::ModulationSine, 0.0);
    let settled = run.begin(&plain).map(|mut open| {
        run.settle(&plain, &mut open);
        open.xi
    });
    let xi = settled.unwrap_or_else(|| DVector::zeros(run.errors()));
    let value = |hook: Hook| law.get(hook).unwrap_or_default();
    // `C cos ψ + S sin ψ` is the real part of `(C − iS) e^{iψ}`.
    let own = Complex64::new(value(Hook::ModulationCosine), -value(Hook::ModulationSine));
    Wave { omega, phase: amplitude(run, (&plain, &xi), omega).arg() - own.arg() }
}

/// Modulations that the training runs show most beside a fitted law, one phase a run each.
pub(super) fn candidates(runs: &[OpenRun], fitted: &Fitted) -> Vec<Vec<Wave>> {
    let Some(first) = runs.first() else { return Vec::new() };
    let alike = |run: &&OpenRun| run.whole.dt == first.whole.dt;
    let longest = runs.iter().map(|run| run.whole.found.force.len()).max().unwrap_or(0);
    let padded = (FINER * longest).next_power_of_two();
    let mut power = vec![0.0; padded / 2 + 1];
    for (run, open) in runs.iter().zip(&fitted.open).filter(|(run, _)| alike(run)) {
        let (mut product, square) = product(run, &fitted.law, &open.xi);
        product.resize(padded, 0.0);
        power.iter_mut().zip(spectrum(&product)).for_each(|(sum, z)| *sum += (2.0 * z / square).norm_sqr());
    }
    let bin = padded as f64 / longest as f64;
    let mut left: Vec<usize> = ((LEAST_PERIODS * bin) as usize..power.len() - 1)
        .filter(|&k| power[k] >= power[k - 1] && power[k] > power[k + 1])
        .collect();
    left.sort_by(|&a, &b| power[b].total_cmp(&power[a]));
    let mut peaks: Vec<usize> = Vec::new();
    for k in left {
        if peaks.len() < TRIED && peaks.iter().all(|&other| (k as f64 - other as f64).abs() > APART * bin) {
            peaks.push(k);
        }
    }
    let omega = |k: usize| {
        // Vertex of the parabola through a peak and its neighbours.
        let [a, b, c] = [power[k - 1], power[k], power[k + 1]];
        let offset = 0.5 * (a - c) / (a - 2.0 * b + c);
        TAU * (k as f64 + if offset.is_finite() { offset } else { 0.0 }) / (padded as f64 * first.whole.dt)
    };
    let wave = |omega: f64| -> Vec<Wave> {
        let phase =
            |(run, open): (&OpenRun, &super::run::Open)| amplitude(run, (&fitted.law, &open.xi), omega).arg();
        runs.iter().zip(&fitted.open).map(|pair| Wave { omega, phase: phase(pair) }).collect()
    };
    peaks.into_iter().map(|k| wave(omega(k))).collect()
}
