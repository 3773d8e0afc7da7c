//! `exp(−x)` for the laws' inner loops: cheaper than the library's, without a branch, and inlined.
//!
//! `−x = k ln 2/128 + r` with the nearest whole `k`; `2^{k/128}` is an entry of a table with its exponent shifted, and
//! `exp(r) = 1 + r + … + r⁵/5!` on `|r| ≤ ln 2/256` (P. T. P. Tang, ACM Trans. Math. Software 15 (1989) 144). The series cut
//! off is below `0.0027⁶/6! = 6e-19`; with rounding the relative error stays below [`ERROR`].

/// Bound of the relative error of [`decay`]: two units in the last place.
#[cfg(test)]
const ERROR: f64 = 2.0 * f64::EPSILON;
/// From here on the result stays: beyond lie the numbers that are not normal.
const LIMIT: f64 = 690.0;
/// Added to a small number it leaves the nearest whole number in the last bits: 1.5 · 2⁵².
const WHOLE: f64 = 6_755_399_441_055_744.0;
/// Entries of the table.
const ENTRIES: usize = 128;
/// The leading bits of ln 2/128, few enough that `k` times them is exact.
const HIGH: f64 = 0.693_147_180_369_123_8 / ENTRIES as f64;
/// The rest of ln 2/128.
const LOW: f64 = 1.908_214_929_270_587_7e-10 / ENTRIES as f64;
/// The bits of `2^{i/128}`.
const POWERS: [u64; ENTRIES] = powers();

const fn powers() -> [u64; ENTRIES] {
    let mut table = [0; ENTRIES];
    let mut i = 0;
    while i < ENTRIES {
        // Near zero the series rounds least: the upper half are doubled powers below 1.
        let (part, factor) = if 2 * i < ENTRIES { (i as f64, 1.0) } else { (i as f64 - ENTRIES as f64, 2.0) };
        let (x, mut sum, mut n) = (part * (std::f64::consts::LN_2 / ENTRIES as f64), 1.0, 18.0);
        while n > 0.0 {
            sum = 1.0 + sum * x / n;
            n -= 1.0;
        }
        table[i] = (factor * sum).to_bits();
        i += 1;
    }
    table
}

/// `exp(−x)` of `x ≥ 0` to two units in the last place; below `exp(−690)`, which is as good as 0, it stays there.
#[inline(always)]
pub(crate) fn decay(x: f64) -> f64 {
    // In this order a NaN remains one.
    let x = if x > LIMIT { LIMIT } else { x };
    let shifted = WHOLE - x * (ENTRIES as f64 * std::f64::consts::LOG2_E);
    let whole = shifted - WHOLE;
    let r = (-x - whole * HIGH) - whole * LOW;
    let k = shifted.to_bits().wrapping_sub(WHOLE.to_bits());
    // `k / 128` goes to the exponent, `k mod 128` to the table: what the shift leaves of the remainder is taken off.
    let entry = k % ENTRIES as u64;
    let power = f64::from_bits(POWERS[entry as usize].wrapping_add(k.wrapping_sub(entry) << (52 - 7)));
    let square = r * r;
    let tail = r + square * ((0.5 + r * (1.0 / 6.0)) + square * (1.0 / 24.0 + r * (1.0 / 120.0)));
    power + power * tail
}

/// `xʸ` of `x ≥ 0`, `0 ≤ y` for what goes into [`decay`]: between `exp(−690)` and `exp(690)`, which stand for 0 and ∞.
///
/// `ln x = e ln 2 + 2 artanh s` with `x = 2ᵉ m`, `√½ ≤ m < √2`, `s = (m − 1)/(m + 1)`; the series cut off after `s¹⁹/19` leaves
/// `2 · 0.1716²¹/21 = 8e-18`. The relative error is that of `y ln x` times its size.
#[inline(always)]
pub(crate) fn power(x: f64, y: f64) -> f64 {
    let bits = x.to_bits().wrapping_sub(ROOT_HALF).wrapping_add(BIAS);
    let exponent = f64::from_bits((bits >> 52) | TWO_TO_52.to_bits()) - (TWO_TO_52 + 1023.0);
    let mantissa = f64::from_bits((bits & FRACTION).wrapping_add(ROOT_HALF));
    let s = (mantissa - 1.0) / (mantissa + 1.0);
    let s2 = s * s;
    let s4 = s2 * s2;
    let low = (1.0 / 3.0 + s2 * (1.0 / 5.0)) + s4 * (1.0 / 7.0 + s2 * (1.0 / 9.0));
    let high = (1.0 / 11.0 + s2 * (1.0 / 13.0)) + s4 * (1.0 / 15.0 + s2 * (1.0 / 17.0 + s2 * (1.0 / 19.0)));
    let series = low + (s4 * s4) * high;
    let log = exponent * std::f64::consts::LN_2 + (2.0 * s + 2.0 * s * s2 * series);
    let argument = -y * log;
    // A decay of a negative number is a growth: its formula holds for both.
    decay(if argument > -LIMIT { argument } else { -LIMIT })
}

const ROOT_HALF: u64 = std::f64::consts::FRAC_1_SQRT_2.to_bits();
const BIAS: u64 = 1023 << 52;
const FRACTION: u64 = (1 << 52) - 1;
const TWO_TO_52: f64 = 4_503_599_627_370_496.0;

#[cfg(test)]
mod tests {
    use super::*;

    /// Against the library's exponential, right to half a unit, over the whole range and at the seams.
    #[test]
    fn decays_are_right_to_two_units() {
        let seams = [0.0, 1e-300, 1e-17, LIMIT * (1.0 - 1e-16), LIMIT];
        let sweep = (0..200_000).map(|k| 1e-9 * 1.000_137_f64.powi(k)).filter(|x| *x < LIMIT);
        for x in seams.into_iter().chain(sweep) {
            let (found, expected) = (decay(x), (-x).exp());
            assert!((found - expected).abs() <= ERROR * expected, "{x}: {found:e} {expected:e}");
        }
        assert!(decay(f64::NAN).is_nan() && decay(0.0) == 1.0);
        assert!([709.0, 745.2, 1e4, f64::INFINITY].iter().all(|x| decay(*x) < 1e-299));
    }

    /// Against the library's power; `y ln x` has an error of two units, which its size makes larger.
    #[test]
    fn powers_are_right_to_what_their_exponent_allows() {
        for y in [0.1, 0.5, 1.0, 1.7, 3.0, 10.0] {
            for k in 0..40_000 {
                let x = 1e-12 * 1.0014_f64.powi(k);
                let (found, expected) = (power(x, y), x.powf(y));
                if expected.ln().abs() < 600.0 {
                    let error = 2.0 * f64::EPSILON * (2.0 + (y * x.ln()).abs());
                    assert!((found - expected).abs() <= error * expected, "{x}^{y}: {found:e} {expected:e}");
                }
            }
        }
        assert!(power(0.0, 0.8) < 1e-200 && power(f64::INFINITY, 0.8) > 1e200 && power(1.0, 7.0) == 1.0);
    }
}
