//! Evidence on samples whose neighbours are correlated.

/// Independent samples of residuals: `n/(1 + 2Σρ_k)` while the autocorrelation stays above two standard errors of a
/// white residual's, run by run; never fewer than four.
#[must_use]
pub fn effective_count(residuals: &[&[f64]]) -> f64 {
    residuals.iter().map(|residual| independent(residual)).sum::<f64>().max(4.0)
}

fn independent(residual: &[f64]) -> f64 {
    let n = residual.len();
    let square: f64 = residual.iter().map(|r| r * r).sum();
    if square <= 0.0 || n < 8 {
        return n as f64;
    }
    let mut sum = 1.0;
    for lag in 1..n / 2 {
        let product: f64 = residual[lag..].iter().zip(residual).map(|(a, b)| a * b).sum();
        let correlation = product / square;
        if correlation < 2.0 / (n as f64).sqrt() {
            break;
        }
        sum += 2.0 * correlation;
    }
    n as f64 / sum
}

/// `ΔBIC = n_eff ln(S₀/S₁) − k ln n_eff`: evidence for a model with `added` more parameters, `S` being mean squares in
/// units of the noise. What is less than noise is no merit.
#[must_use]
pub(super) fn evidence(squares: [f64; 2], added: f64, effective: f64) -> f64 {
    let [before, after] = squares.map(|s| s.max(1.0));
    effective * (before / after).ln() - added * effective.ln()
}

/// By how many standard errors the squared residual falls, runs taken together: mean of `r₀² − r₁²` over its standard
/// error at the effective number of samples.
#[must_use]
pub(super) fn improvement(before: &[Vec<f64>], after: &[Vec<f64>]) -> f64 {
    let falls: Vec<Vec<f64>> = before
        .iter()
        .zip(after)
        .map(|(b, a)| b.iter().zip(a).map(|(b, a)| b * b - a * a).collect())
        .collect();
    let count: f64 = falls.iter().map(|f| f.len() as f64).sum();
    let mean = falls.iter().flatten().sum::<f64>() / f64::max(count, 1.0);
    let centred: Vec<Vec<f64>> = falls.iter().map(|f| f.iter().map(|x| x - mean).collect()).collect();
    let parts: Vec<&[f64]> = centred.iter().map(Vec::as_slice).collect();
    let variance = centred.iter().flatten().map(|x| x * x).sum::<f64>() / f64::max(count, 1.0);
    mean / (variance / effective_count(&parts)).sqrt().max(f64::MIN_POSITIVE)
}
