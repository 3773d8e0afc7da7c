//! Evidence for subharmonics.

use frettrace_fourier::{Frequency, Lines, Projector, dot};
use std::f64::consts::LN_2;

/// Highest subharmonic order that is looked for.
const HIGHEST_ORDER: usize = 8;
/// Multiples of the excitation frequency up to which subharmonic lines are looked for: the lowest ones carry the evidence.
const MULTIPLES: usize = 4;
/// Excess of the residual's variance over the noise below which nothing is looked for: five standard deviations of the
/// variance of a thousand samples.
const LOWEST_EXCESS: f64 = 0.2;

/// Search for lines between the multiples of the excitation frequency in what the harmonic form leaves.
pub(super) struct Subharmonics<'a> {
    pub(super) base: Frequency,
    pub(super) sampling_rate: f64,
    pub(super) noise_std: &'a [f64],
}

impl Subharmonics<'_> {
    /// The order `ν ≥ 2` of greatest evidence, if there is evidence; when `forced`, the best in any case.
    ///
    /// Evidence is the difference of the Bayesian information criterion, `Σ_c n ln(σ_1²/σ_ν²) − p ln n` with the `p` real
    /// unknowns of the lines between the harmonics.
    pub(super) fn best(&self, residuals: &[&[f64]], forced: bool) -> Option<usize> {
        let raised = residuals
            .iter()
            .zip(self.noise_std)
            .any(|(r, noise)| mean_square(r) > (1.0 + LOWEST_EXCESS) * noise * noise);
        if !raised && !forced {
            return None;
        }
        (2..=HIGHEST_ORDER)
            .map(|order| (order, self.evidence(residuals, order)))
            .max_by(|a, b| a.1.total_cmp(&b.1))
            .filter(|(_, evidence)| forced || *evidence > 10.0)
            .map(|(order, _)| order)
    }

    fn evidence(&self, residuals: &[&[f64]], order: usize) -> f64 {
        let Some(samples) = residuals.first().map(|r| r.len()) else { return 0.0 };
        let base = self.base.base / order as f64;
        let band = (0.9 * std::f64::consts::PI * self.sampling_rate / base) as usize;
        let highest = (MULTIPLES * order).min(band);
        let lines = Lines { base, order: highest, samples, sampling_rate: self.sampling_rate, drift: 0 };
        let Ok(projector) = Projector::new(lines) else { return f64::NEG_INFINITY };
        let n = samples as f64;
        // The harmonics themselves are not new; each line between them has a cosine and a sine.
        let unknowns = 2.0 * (highest - highest / order) as f64;
        residuals
            .iter()
            .map(|residual| {
                let power = mean_square(residual);
                let left = projector.project(residual).map_or(power, |p| mean_square(&p.residual));
                n * (power / left.max(1e-9 * power)).ln() - unknowns * n.ln()
            })
            .sum()
    }
}

fn mean_square(x: &[f64]) -> f64 {
    dot(x, x) / x.len().max(1) as f64
}

/// Standard deviation of white noise with the median of a periodogram `|X_k|²/n`: `median = σ² ln 2`.
pub(super) fn floor(periodogram: &[f64]) -> f64 {
    let mut power: Vec<f64> = periodogram.iter().skip(1).copied().collect();
    let middle = power.len() / 2;
    if power.is_empty() {
        return 0.0;
    }
    let (_, median, _) = power.select_nth_unstable_by(middle, f64::total_cmp);
    (*median / LN_2).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::SeedableRng;
    use rand_distr::Distribution;
    use std::f64::consts::TAU;

    fn noise(seed: u64, n: usize) -> Vec<f64> {
        let mut random = rand_pcg::Pcg64::seed_from_u64(seed);
        let normal = rand_distr::Normal::new(0.0, 1.0).unwrap();
        (0..n).map(|_| normal.sample(&mut random)).collect()
    }

    fn search(noise_std: &[f64]) -> Subharmonics<'_> {
        Subharmonics { base: Frequency { base: TAU * 50.0, std: 0.0 }, sampling_rate: 4096.0, noise_std }
    }

    /// The floor of white noise is its standard deviation; the median of 2048 values scatters by 1/√2048·√2/2 ≈ 3 %.
    #[test]
    fn floor_of_white_noise() {
        let power: Vec<f64> =
            frettrace_fourier::spectrum(&noise(1, 4096)).iter().map(|z| z.norm_sqr() / 4096.0).collect();
        assert!((floor(&power) - 1.0).abs() < 0.06);
    }

    /// Noise alone, even when it is stronger than declared, shows no subharmonics; a line at half the frequency does.
    #[test]
    fn subharmonics_need_evidence() {
        let plain = noise(2, 4096);
        assert_eq!(search(&[0.5]).best(&[&plain], false), None);
        for order in [2, 3] {
            let with: Vec<f64> = plain
                .iter()
                .enumerate()
                .map(|(j, v)| v + (TAU * 50.0 / f64::from(order) * j as f64 / 4096.0).cos())
                .collect();
            assert_eq!(search(&[1.0]).best(&[&with], false), Some(order as usize));
        }
    }
}
