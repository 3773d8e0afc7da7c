//! Noise around each line, from what a projection leaves.

use crate::{Lines, plans};
use num_complex::Complex64;

/// Fewest frequency bins a local noise level is averaged over: its standard deviation is then below 10 %.
const FEWEST_BINS: usize = 128;

/// Variance `σ²` of white noise that would leave the residual's power near each line `0..=H`.
///
/// The periodogram `power` of the residual is averaged over the bins around the line (at least [`FEWEST_BINS`], at least one base
/// frequency to each side) and corrected for the share that the fitted lines took away.
pub(crate) fn line_noise(power: &[f64], lines: &Lines) -> Vec<f64> {
    let bins = power.len();
    let mut sums = vec![0.0; bins + 1];
    for (i, p) in power.iter().enumerate() {
        sums[i + 1] = sums[i] + p;
    }
    let spacing = lines.base / std::f64::consts::TAU / lines.sampling_rate * lines.samples as f64;
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
pub(crate) fn periodogram(x: &[f64]) -> Vec<f64> {
    let spectrum = spectrum(x);
    let scale = 1.0 / x.len() as f64;
    spectrum.iter().map(|z| z.norm_sqr() * scale).collect()
}

/// Amplitudes `2X_k/n` of a real record about its mean, under Hann's window of mean square one: the bins `0..=n/2`.
///
/// The window `½(1 − cos 2πj/n)` of the samples is `½X_k − ¼(X_{k−1} + X_{k+1})` of the bins.
#[must_use]
pub fn tapered_spectrum(x: &[f64]) -> Vec<Complex64> {
    let n = x.len().max(1);
    let mut bins = spectrum(x);
    if let Some(mean) = bins.first_mut() {
        *mean = Complex64::ZERO;
    }
    // Beyond the last bin of a real record its conjugates come back.
    let bin = |k: usize| bins.get(k).copied().unwrap_or_else(|| bins[n - k].conj());
    let scale = (8.0_f64 / 3.0).sqrt() * 2.0 / n as f64;
    (0..bins.len())
        .map(|k| {
            let below = if k == 0 { bin(1 % n).conj() } else { bin(k - 1) };
            (bin(k) * 0.5 - (below + bin((k + 1) % n)) * 0.25) * scale
        })
        .collect()
}

/// Unscaled discrete Fourier transform `Σ_j x_j e^{−2πijk/n}` of the bins `0..=n/2` of a real record.
#[must_use]
pub fn spectrum(x: &[f64]) -> Vec<Complex64> {
    let plan = plans::forward(x.len());
    let mut signal = x.to_vec();
    let mut bins = plan.make_output_vec();
    let done = plan.process(&mut signal, &mut bins);
    debug_assert!(done.is_ok(), "lengths come from the plan");
    bins
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::TAU;

    /// Against the windowed samples' own sums, for even and odd lengths.
    #[test]
    fn the_window_is_a_sum_of_three_bins() {
        for n in [2, 3, 12, 15] {
            let x: Vec<f64> = (0..n).map(|j| 3.0 + (1.7 * j as f64).sin() + 0.2 * (j * j) as f64).collect();
            let mean = x.iter().sum::<f64>() / n as f64;
            let window = |j: usize| (8.0_f64 / 3.0).sqrt() * 0.5 * (1.0 - (TAU * j as f64 / n as f64).cos());
            let found = tapered_spectrum(&x);
            assert_eq!(found.len(), n / 2 + 1);
            for (k, bin) in found.iter().enumerate() {
                let turn = |j: usize| Complex64::cis(-TAU * (j * k) as f64 / n as f64);
                let sum: Complex64 = (0..n).map(|j| turn(j) * (x[j] - mean) * window(j)).sum();
                assert!((bin - sum * (2.0 / n as f64)).norm() < 1e-12, "{n} {k}");
            }
        }
    }
}
