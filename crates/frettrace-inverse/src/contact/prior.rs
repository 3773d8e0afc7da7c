//! Prior variances of the forces on each line, from their own spectrum (empirical Bayes).

use num_complex::Complex64;
use std::f64::consts::{PI, SQRT_2};

/// Rounds of reweighting; the weights hardly move after the second.
const ROUNDS: usize = 3;
/// Variances by which a line stands out by itself: one in a hundred and fifty lines of noise does.
const STANDS_OUT: f64 = 4.0;

/// Prior variance `E|f_h|²` (N²) of each line, from the forces found without prior and their variances.
///
/// Friction forces fall with the line, and hold odd or even multiples unequally: the power of each class (lines `stride` apart)
/// is the non-increasing sequence nearest to `|f|² − v`, with weights `1/(P + v)²` (pool adjacent violators). The mean `m` of a
/// pool is known to `s = (Σ weights)^{−1/2}` and no power is negative: the prior is the mean of a normal distribution with `m` and
/// `s` cut at zero, so that what may hide below the noise is neither lost nor promised to be absent. A line that stands out of
/// its own noise speaks for itself.
pub(super) fn variances(found: &[(Complex64, f64)], stride: usize) -> Vec<f64> {
    let mut prior = vec![f64::MIN_POSITIVE; found.len()];
    for class in 0..stride.max(1) {
        let lines: Vec<usize> = (class..found.len()).step_by(stride.max(1)).collect();
        let seen: Vec<usize> = lines.iter().copied().filter(|h| found[*h].1.is_finite()).collect();
        let excess: Vec<f64> = seen.iter().map(|h| found[*h].0.norm_sqr() - found[*h].1).collect();
        let noise: Vec<f64> = seen.iter().map(|h| found[*h].1).collect();
        for ((h, power), excess) in seen.iter().zip(falling(&excess, &noise)).zip(&excess) {
            let alone = if *excess > STANDS_OUT * found[*h].1 { *excess } else { 0.0 };
            prior[*h] = power.max(alone).max(f64::MIN_POSITIVE);
        }
    }
    prior
}

/// The prior of a structure in doubt: as wide, against the variances `doubted` that it makes, as the prior of the `plain` balance
/// against the noise. A doubt widens bands; what the noise does not hide is not drawn towards zero for it.
pub(super) fn widened(plain: &[(Complex64, f64)], doubted: &[(Complex64, f64)], stride: usize) -> Vec<f64> {
    let priors = variances(plain, stride);
    let scale = |(plain, doubted): (&(Complex64, f64), &(Complex64, f64))| {
        let known = plain.1 > 0.0 && plain.1.is_finite() && doubted.1.is_finite();
        if known { doubted.1 / plain.1 } else { 1.0 }
    };
    priors.iter().zip(plain.iter().zip(doubted)).map(|(prior, pair)| prior * scale(pair)).collect()
}

/// Lines that were pooled.
#[derive(Clone, Copy)]
struct Pool {
    weight: f64,
    sum: f64,
    lines: usize,
}

impl Pool {
    fn mean(&self) -> f64 {
        self.sum / self.weight
    }

    fn expected(&self) -> f64 {
        positive_mean(self.mean(), self.weight.sqrt().recip())
    }
}

fn falling(excess: &[f64], noise: &[f64]) -> Vec<f64> {
    let spread = |pools: &[Pool], value: &dyn Fn(&Pool) -> f64| -> Vec<f64> {
        pools.iter().flat_map(|pool| std::iter::repeat_n(value(pool), pool.lines)).collect()
    };
    let mut pools = Vec::new();
    let mut power = vec![0.0; excess.len()];
    for _ in 0..ROUNDS {
        pools = pooled(excess, noise, &power);
        power = spread(&pools, &|pool| pool.mean().max(0.0));
    }
    spread(&pools, &Pool::expected)
}

/// Adjacent violators of a falling sequence pooled, with weights from the powers of the round before.
fn pooled(excess: &[f64], noise: &[f64], power: &[f64]) -> Vec<Pool> {
    let mut pools: Vec<Pool> = Vec::new();
    for ((e, v), p) in excess.iter().zip(noise).zip(power) {
        let weight = 1.0 / (p + v).powi(2).max(f64::MIN_POSITIVE);
        let mut pool = Pool { weight, sum: weight * e, lines: 1 };
        while let Some(last) = pools.pop_if(|last| last.mean() <= pool.mean()) {
            pool = Pool {
                weight: pool.weight + last.weight,
                sum: pool.sum + last.sum,
                lines: pool.lines + last.lines,
            };
        }
        pools.push(pool);
    }
    pools
}

/// Mean of a normal distribution of mean `m` and standard deviation `s` cut at zero: `m + s φ(m/s)/Φ(m/s)`.
fn positive_mean(m: f64, s: f64) -> f64 {
    let at = m / s;
    if at > 6.0 {
        return m;
    }
    if at < -6.0 {
        // The first term of the asymptotic series.
        return -s / at;
    }
    let density = (-0.5 * at * at).exp() / (2.0 * PI).sqrt();
    (m + s * density / normal(at)).max(0.0)
}

/// Distribution function of the normal distribution (Abramowitz & Stegun 7.1.26, right to 1e-7; that suffices for a prior but
/// not in the far tail, which is cut off before).
fn normal(x: f64) -> f64 {
    let y = x.abs() / SQRT_2;
    let t = 1.0 / (1.0 + 0.327_591_1 * y);
    let series = [1.061_405_429, -1.453_152_027, 1.421_413_741, -0.284_496_736, 0.254_829_592];
    let tail = 0.5 * series.iter().fold(0.0, |sum, c| (sum + c) * t) * (-y * y).exp();
    if x < 0.0 { tail } else { 1.0 - tail }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Cut at its mean a normal distribution has the mean `s√(2/π)`; far from the cut its own; far beyond it `s²/|m|`.
    #[test]
    fn means_of_cut_normal_distributions() {
        assert!((positive_mean(0.0, 2.0) - 2.0 * (2.0 / PI).sqrt()).abs() < 1e-5);
        assert!((positive_mean(10.0, 1.0) - 10.0).abs() < 1e-12);
        // 1/x (1 − 2/x² …): two over a hundred at ten.
        assert!((positive_mean(-10.0, 1.0) - 0.1).abs() < 2.5e-3);
        // The series is right to 1e-7 of the whole, which is 3 % of the tail at 4.5.
        let exact = 0.213_0;
        assert!((positive_mean(-4.5, 1.0) - exact).abs() < 0.05, "{}", positive_mean(-4.5, 1.0));
    }

    /// Strong lines keep their power, lines of noise share what their mean can hide: here `v/√n` times about 0.8 at the most.
    #[test]
    fn strong_lines_stay_and_noise_is_pooled() {
        let found: Vec<(Complex64, f64)> =
            (0..40).map(|h| (Complex64::from(if h == 0 { 100.0 } else { 1.0 }), 1.0)).collect();
        let prior = variances(&found, 1);
        // A single line knows its power to its own size: m + s φ(1)/Φ(1) = 1.29 m.
        assert!((1.0..1.4).contains(&(prior[0] / 9999.0)), "{}", prior[0]);
        let hidden = 0.8 / 39.0_f64.sqrt();
        assert!(prior[1..].iter().all(|p| (*p - hidden).abs() < 0.3 * hidden), "{prior:?}");
    }
}
