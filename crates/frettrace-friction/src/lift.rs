//! The chain rule, written out: values computed in `f64` with their partial derivatives, lifted into the scalar `T`.

use crate::Scalar;

/// `value + Σ partial · (argument − its real part)`: for `f64` the value itself, for dual numbers of first order the
/// value with the right derivatives, at the price of one scaled sum instead of a chain of dual operations.
#[inline(always)]
pub fn lift<T: Scalar, const M: usize>(value: f64, partials: [f64; M], arguments: [T; M]) -> T {
    let mut lifted = T::from(value);
    if T::NDERIV > 0 {
        for (partial, argument) in partials.into_iter().zip(arguments) {
            // An argument without influence may be infinite, and ∞ − ∞ is no number.
            if partial != 0.0 {
                lifted += (argument - argument.re()) * partial;
            }
        }
    }
    lifted
}

/// `Σ c_i x^i`, its terms summed in pairs, and pairs of those: a sum one by one would wait for each.
#[inline(always)]
pub(crate) fn in_pairs(c: &[f64; 8], x: f64) -> f64 {
    let square = x * x;
    let quarter = |i: usize| c[i] + c[i + 1] * x;
    let half = |i: usize| quarter(i) + quarter(i + 2) * square;
    half(0) + half(4) * (square * square)
}

/// The larger of a number and zero: compression only.
#[inline(always)]
pub fn positive_part<T: Scalar>(value: T) -> T {
    if value.re() > 0.0 { value } else { T::from(0.0) }
}

/// The sign of the real part, 0 at 0.
#[inline(always)]
pub fn sign(value: f64) -> f64 {
    if value > 0.0 {
        1.0
    } else if value < 0.0 {
        -1.0
    } else {
        0.0
    }
}
