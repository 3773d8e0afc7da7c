//! Noise around each line, from what a projection leaves.

use crate::Lines;
use num_complex::Complex64;
use realfft::RealFftPlanner;
use std::sync::{Arc, Mutex, OnceLock};

/// Fewest frequency bins a local noise level is averaged over: its standard deviation is then below 10 %.
const FEWEST_BINS: usize = 128;

/// Variance `σ²` of white noise that would leave the residual's power near each line `0..=H`.
///
/// The periodogram of the residual is averaged over the bins around the line (at least [`FEWEST_BINS`], at least one base
/// frequency to each side) and corrected for the share that the fitted lines took away.
pub(crate) fn line_noise(residual: &[f64], lines: &Lines) -> Vec<f64> {
    let n = residual.len();
    let power = periodogram(residual);
    let bins = power.len();
    let mut sums = vec![0.0; bins + 1];
    for (i, p) in power.iter().enumerate() {
        sums[i + 1] = sums[i] + p;
    }
    let spacing = lines.base / std::f64::consts::TAU / lines.sampling_rate * n as f64;
    let half = (spacing.ceil() as usize).max(FEWEST_BINS / 2);
    let kept = (1.0 - 1.0 / spacing.max(1.0)).max(0.05);
    (0..=lines.order)
        .map(|h| {
            let centre = (h as f64 * spacing).round() as usize;
            let last = (centre.min(bins - 1) + half).min(bins);
            let first = last.saturating_sub(2 * half);
            (sums[last] - sums[first]) / (last - first).max(1) as f64 / kept
        })
        .collect()
}

/// `|X_k|²/n` of the bins `0..=n/2`: the mean of it is the variance of white noise.
fn periodogram(x: &[f64]) -> Vec<f64> {
    let spectrum = spectrum(x);
    let scale = 1.0 / x.len() as f64;
    spectrum.iter().map(|z| z.norm_sqr() * scale).collect()
}

/// Amplitudes `2X_k/n` of a real record about its mean, under Hann's window of mean square one: the bins `0..=n/2`.
#[must_use]
pub fn tapered_spectrum(x: &[f64]) -> Vec<Complex64> {
    let n = x.len() as f64;
    let mean = x.iter().sum::<f64>() / n.max(1.0);
    let window =
        |j: usize| (8.0_f64 / 3.0).sqrt() * 0.5 * (1.0 - (std::f64::consts::TAU * j as f64 / n).cos());
    let tapered: Vec<f64> = x.iter().enumerate().map(|(j, v)| (v - mean) * window(j)).collect();
    spectrum(&tapered).iter().map(|z| z * (2.0 / n)).collect()
}

/// Unscaled discrete Fourier transform `Σ_j x_j e^{−2πijk/n}` of the bins `0..=n/2` of a real record.
#[must_use]
pub fn spectrum(x: &[f64]) -> Vec<Complex64> {
    static PLANNER: OnceLock<Mutex<RealFftPlanner<f64>>> = OnceLock::new();
    let planner = PLANNER.get_or_init(|| Mutex::new(RealFftPlanner::new()));
    let plan: Arc<_> = match planner.lock() {
        Ok(mut planner) => planner.plan_fft_forward(x.len()),
        Err(poisoned) => poisoned.into_inner().plan_fft_forward(x.len()),
    };
    let mut signal = x.to_vec();
    let mut bins = plan.make_output_vec();
    let done = plan.process(&mut signal, &mut bins);
    debug_assert!(done.is_ok(), "lengths come from the plan");
    bins
}
