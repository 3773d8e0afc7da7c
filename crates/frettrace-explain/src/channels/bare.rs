//! Runs with the lines of the motion taken out.

use super::{Channels, LOUD, mean_square};
use crate::RunSamples;
use frettrace_fourier::{Lines, Projector, refine};
use rayon::prelude::*;
use std::f64::consts::TAU;

/// Most lines that are taken out, …
const LINES: usize = 160;
/// … and the share of half the sampling rate up to which.
const HIGHEST: f64 = 0.98;
/// Degree of the drift that a channel may have over a record.
const DEGREE: usize = 3;

/// A run with its lines taken out.
pub(super) struct Bare<'a> {
    pub(super) run: &'a RunSamples<'a>,
    pub(super) projector: Projector,
    /// What lines and drift leave, `[sensor]`.
    pub(super) residual: Vec<Vec<f64>>,
    /// Variance of it, that of the noise where it is known, `[sensor]`.
    pub(super) variance: Vec<f64>,
    /// Coefficients of the drift, `[sensor]`.
    pub(super) drift: Vec<Vec<f64>>,
}

impl Bare<'_> {
    /// Whether most channels hold no more than noise beside lines and drift: a motion without a period is heard by all.
    pub(super) fn is_steady(&self) -> bool {
        let quiet = (self.residual.iter().zip(&self.variance))
            .filter(|(residual, variance)| mean_square(residual.iter().copied()) <= LOUD * LOUD * **variance);
        2 * quiet.count() > self.residual.len()
    }
}

/// All runs without their lines and without their drift; `None` where one of them cannot be projected.
pub(super) fn bare<'a>(
    runs: &'a [RunSamples<'a>],
    noise: Option<&[f64]>,
    channels: &Channels,
) -> Option<Vec<Bare<'a>>> {
    let one = |(run, signals): (&'a RunSamples<'a>, &Vec<Vec<f64>>)| {
        let samples = run.force.len();
        let coarse = Lines {
            base: TAU * run.excitation_frequency,
            order: 3,
            samples,
            sampling_rate: run.sampling_rate,
            drift: 0,
        };
        let base = refine(coarse, &[run.force]).ok()?.base;
        let highest = (HIGHEST * std::f64::consts::PI * run.sampling_rate / base) as usize;
        let order = highest.min(LINES).min(samples / 4).max(1);
        let projector = Projector::new(Lines { base, order, drift: DEGREE, ..coarse }).ok()?;
        let projected = signals.iter().map(|x| projector.project(x)).collect::<Result<Vec<_>, _>>().ok()?;
        let variance = projected
            .iter()
            .enumerate()
            .map(|(s, p)| noise.map_or_else(|| mean_square(p.residual.iter().copied()), |n| n[s] * n[s]))
            .collect();
        let (residual, drift) = projected.into_iter().map(|p| (p.residual, p.drift)).unzip();
        Some(Bare { run, projector, residual, variance, drift })
    };
    runs.par_iter().zip(&channels.signal).map(one).collect()
}
