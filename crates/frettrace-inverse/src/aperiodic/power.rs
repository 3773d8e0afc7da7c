//! Local means of powers over neighbouring bins.

/// Half width, in bins, of a mean.
const NEAR: usize = 4;
/// Rounds of reweighting; the weights hardly move after the second.
const ROUNDS: usize = 3;

/// How much larger a power may be that is drawn from five bins: of their ten real amplitudes 95 % of a t-distribution lie within 2.23
/// instead of 1.96 deviations, `(2.23/1.96)² = 1.3`, and its variance is 10/8 of what they show.
pub(super) const FROM_FEW: f64 = 1.6;

/// Mean power about each bin (from bin 1), of powers known to the variances `v`; `first` bins are not asked.
///
/// The power of a noisy amplitude scatters by `P + v`: the bins about `c` weigh `1/(P_c + v)²`, and the mean about the bin above is one
/// more of them, without noise. So what the sensors do not see, towards zero frequency above all, is drawn from the nearest bins that
/// they do see, as `k^{−tilt}`: 0 for a level, 2 for a random walk.
pub(super) fn smoothed(powers: &[f64], variances: &[f64], (tilt, first): (i32, usize)) -> Vec<f64> {
    let scale = |k: usize| (k as f64 + 1.0).powi(tilt);
    let scaled =
        |values: &[f64]| -> Vec<f64> { values.iter().enumerate().map(|(k, p)| p * scale(k)).collect() };
    let (powers, variances) = (scaled(powers), scaled(variances));
    let near = |c: usize| c.saturating_sub(NEAR).max(first)..(c.max(first) + NEAR + 1).min(powers.len());
    let mean = |last: Option<&[f64]>| -> Vec<f64> {
        let mut found = vec![f64::MIN_POSITIVE; powers.len()];
        let mut above: Option<f64> = None;
        for c in (0..powers.len()).rev() {
            // Relative to the bin's own power, the square of a small number would vanish. At first nothing but the noise is known.
            let own = last.map_or(0.0, |last| last[c]);
            let unit =
                if own > 0.0 { own } else { near(c).map(|i| variances[i]).fold(f64::INFINITY, f64::min) };
            let of = |i: usize| (unit / (own + variances[i])).powi(2);
            let (mut sum, mut total) = above.filter(|_| own > 0.0).map_or((0.0, 0.0), |above| (above, 1.0));
            for i in near(c).filter(|i| variances[*i].is_finite()) {
                (sum, total) = (sum + of(i) * powers[i], total + of(i));
            }
            if total > 0.0 {
                found[c] = (sum / total).max(f64::MIN_POSITIVE);
                above = Some(found[c]);
            }
        }
        found
    };
    let mut found = mean(None);
    for _ in 0..ROUNDS {
        found = mean(Some(&found));
    }
    found.iter().enumerate().map(|(k, p)| (p / scale(k)).max(f64::MIN_POSITIVE)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Powers that fall as they are said to are found as they are, seen or not, however many are not.
    #[test]
    fn what_nobody_sees_follows_the_tilt() {
        let walk: Vec<f64> = (1..60).map(|k| 4.0 / f64::from(k * k)).collect();
        let mut variances = vec![1e-6; walk.len()];
        let mut seen = walk.clone();
        for k in 0..12 {
            (variances[k], seen[k]) = (1e6, 0.0);
        }
        let found = smoothed(&seen, &variances, (2, 0));
        for (found, expected) in found.iter().zip(&walk) {
            assert!((found / expected - 1.0).abs() < 1e-3, "{found} {expected}");
        }
        let asked = smoothed(&seen, &vec![1e-6; walk.len()], (2, 12));
        assert!((asked[0] / walk[0] - 1.0).abs() < 1e-9);
    }

    /// A level among equals is their mean.
    #[test]
    fn a_level_is_the_mean() {
        let found = smoothed(&[1.0, 3.0, 1.0, 3.0, 2.0], &[1.0; 5], (0, 0));
        assert!(found.iter().all(|p| (p - 2.0).abs() < 1e-12), "{found:?}");
    }
}
