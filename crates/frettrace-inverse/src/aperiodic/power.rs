//! Local means of powers over neighbouring bins.

/// Half width, in bins, of a mean.
const NEAR: usize = 4;
/// Rounds of reweighting; the weights hardly move after the second.
const ROUNDS: usize = 3;

/// Mean power about each bin (from bin 1), of powers known to the variances `v`; `first` bins are not asked.
///
/// The power of a noisy amplitude scatters by `P + v`: the bins about `c` weigh `1/(P_c + v)²`, so that a bin that the sensors do not
/// see takes its power from those that they do. Towards zero frequency nothing is seen, and what is there is drawn from the bins above
/// as `k^{−tilt}`: 0 for a level, 2 for a random walk.
pub(super) fn smoothed(powers: &[f64], variances: &[f64], (tilt, first): (i32, usize)) -> Vec<f64> {
    let scale = |k: usize| (k as f64 + 1.0).powi(tilt);
    let scaled =
        |values: &[f64]| -> Vec<f64> { values.iter().enumerate().map(|(k, p)| p * scale(k)).collect() };
    let (powers, variances) = (scaled(powers), scaled(variances));
    let mean = |weight: &dyn Fn(usize, usize) -> f64| -> Vec<f64> {
        (0..powers.len())
            .map(|c| {
                let near = c.saturating_sub(NEAR).max(first)..(c.max(first) + NEAR + 1).min(powers.len());
                let (sum, total) = near.fold((0.0, 0.0), |(sum, total), i| {
                    let w = weight(c, i);
                    if w.is_finite() { (sum + w * powers[i], total + w) } else { (sum, total) }
                });
                (sum / total.max(f64::MIN_POSITIVE)).max(f64::MIN_POSITIVE)
            })
            .collect()
    };
    // Squares of very small numbers would vanish.
    let unit = variances.iter().copied().filter(|v| v.is_finite()).fold(f64::MIN_POSITIVE, f64::max);
    let mut found = mean(&|_, i| unit / variances[i]);
    for _ in 0..ROUNDS {
        let last = found;
        found = mean(&|c, i| (unit / (last[c] + variances[i])).powi(2));
    }
    found.iter().enumerate().map(|(k, p)| (p / scale(k)).max(f64::MIN_POSITIVE)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Powers that fall as they are said to are found as they are, seen or not.
    #[test]
    fn what_nobody_sees_follows_the_tilt() {
        let walk: Vec<f64> = (1..60).map(|k| 4.0 / f64::from(k * k)).collect();
        let mut variances = vec![1e-6; walk.len()];
        let mut seen = walk.clone();
        for k in 0..2 {
            (variances[k], seen[k]) = (1e6, 77.0);
        }
        let found = smoothed(&seen, &variances, (2, 0));
        for (found, expected) in found.iter().zip(&walk) {
            assert!((found / expected - 1.0).abs() < 1e-9, "{found} {expected}");
        }
        let asked = smoothed(&seen, &vec![1e-6; walk.len()], (2, 2));
        assert!((asked[0] / walk[0] - 1.0).abs() < 1e-9);
    }

    /// A level among equals is their mean.
    #[test]
    fn a_level_is_the_mean() {
        let found = smoothed(&[1.0, 3.0, 1.0, 3.0, 2.0], &[1.0; 5], (0, 0));
        assert!(found.iter().all(|p| (p - 2.0).abs() < 1e-12), "{found:?}");
    }
}
