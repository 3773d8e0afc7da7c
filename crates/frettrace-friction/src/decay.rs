//! `exp(−x)` of several numbers side by side, for the laws' inner loops; one by one the library's is faster.
//!
//! `x = k ln 2 − r` with the nearest whole `k`, then `exp(r) = 1 + r + … + r¹³/13!` on `|r| ≤ ½ ln 2`, then the exponent's
//! bits (W. J. Cody, W. Waite, *Software Manual for the Elementary Functions*, 1980, chapter 6). The series cut off is
//! below `0.347¹⁴/14! = 4e-18`; with rounding the relative error stays below [`ERROR`].

/// Bound of the relative error of [`decays`]: two units in the last place.
#[cfg(test)]
const ERROR: f64 = 2.0 * f64::EPSILON;
/// From here on the result is left to the library: it is near the smallest normal number, 0 or not a number.
const LIMIT: f64 = 690.0;
/// Added to a small number it leaves the nearest whole number in the last bits: 1.5 · 2⁵².
const WHOLE: f64 = 6_755_399_441_055_744.0;
/// The leading bits of ln 2, few enough that `k` times them is exact.
const LN_2_HIGH: f64 = 0.693_147_180_369_123_8;
/// The rest of ln 2.
const LN_2_LOW: f64 = 1.908_214_929_270_587_7e-10;

/// `exp(−x)`; for `x ≥ 0` the relative error is two units in the last place at most.
#[inline(always)]
pub(crate) fn decays<const N: usize>(x: [f64; N]) -> [f64; N] {
    // Comparisons with NaN are false.
    if x.iter().all(|x| (0.0..LIMIT).contains(x)) { x.map(series) } else { x.map(|x| (-x).exp()) }
}

#[inline(always)]
fn series(x: f64) -> f64 {
    let shifted = x * std::f64::consts::LOG2_E + WHOLE;
    let whole = shifted - WHOLE;
    let r = (whole * LN_2_HIGH - x) + whole * LN_2_LOW;
    // Pairs of terms, so that no addition waits for the last one.
    let (r2, r4) = (r * r, (r * r) * (r * r));
    let low = (0.5 + r * (1.0 / 6.0)) + r2 * (1.0 / 24.0 + r * (1.0 / 120.0));
    let middle = (1.0 / 720.0 + r * (1.0 / 5040.0)) + r2 * (1.0 / 40_320.0 + r * (1.0 / 362_880.0));
    let high = (1.0 / 3_628_800.0 + r * (1.0 / 39_916_800.0))
        + r2 * (1.0 / 479_001_600.0 + r * (1.0 / 6_227_020_800.0));
    let power = 1.0 + (r + r2 * (low + r4 * (middle + r4 * high)));
    power * f64::from_bits(1023_u64.wrapping_sub(shifted.to_bits() & 0x7ff) << 52)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Against the library's exponential, right to half a unit, over the whole range and at the seams.
    #[test]
    fn decays_are_right_to_two_units() {
        let seams = [0.0, 1e-300, 1e-17, LIMIT * (1.0 - 1e-16), LIMIT, 709.0, 745.2, 1e4, f64::INFINITY];
        let sweep = (0..200_000).map(|k| 1e-9 * 1.000_137_f64.powi(k));
        for x in seams.into_iter().chain(sweep) {
            let ([found], expected) = (decays([x]), (-x).exp());
            assert!((found - expected).abs() <= ERROR * expected, "{x}: {found:e} {expected:e}");
        }
        assert!(decays([f64::NAN])[0].is_nan() && decays([0.0]) == [1.0]);
    }
}
