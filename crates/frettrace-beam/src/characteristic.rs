//! The frequency equation of the uniform beam with elastic ends, in a form that never overflows.
//!
//! With `ξ = x/L`, `b = βL` the mode is `ψ = A e^{-bξ} + B e^{-b(1-ξ)} + C sin bξ + D cos bξ`; all four functions are
//! bounded. The two conditions at the clamp give `A` and `D` from `B` and `C`, the two at the support a 2 × 2 determinant.

use crate::beam::Ends;
use crate::error::BeamError;

/// Coefficients `A, B, C, D`.
pub(crate) type Coefficients = [f64; 4];

/// Step of the scan for sign changes: neighbouring roots are more than 1 apart for every pair of elastic ends.
const SCAN_STEP: f64 = 0.1;
/// Start of the scan: below it rounding hides the determinant, above it lies the first root of every clamp stiffness allowed.
const SCAN_START: f64 = 0.05;

/// `ψ` and its first three derivatives with respect to `bξ`.
pub(crate) fn scaled_derivatives(wavenumber: f64, coefficients: &Coefficients, xi: f64) -> [f64; 4] {
    let [a, b, c, d] = *coefficients;
    let near = a * (-wavenumber * xi).exp();
    let far = b * (-wavenumber * (1.0 - xi)).exp();
    let (sine, cosine) = (wavenumber * xi).sin_cos();
    let even = c * sine + d * cosine;
    let odd = c * cosine - d * sine;
    [near + far + even, far - near + odd, near + far - even, far - near - odd]
}

/// `A` and `D` that meet the conditions at the clamp.
fn complete(wavenumber: f64, ends: &Ends, far: f64, sine: f64) -> Coefficients {
    let twice = 2.0 * ends.clamp_compliance * wavenumber;
    let far_at_clamp = far * (-wavenumber).exp();
    let near = (sine + far_at_clamp * (1.0 - twice)) / (1.0 + twice);
    [near, far, sine, -near - far_at_clamp]
}

/// A condition `w_0·p + w_1·q = 0` with `w = (1, ratio)`, scaled so that `ratio = ∞` is allowed.
fn weights(ratio: f64) -> (f64, f64) {
    if ratio.is_finite() { (1.0 / (1.0 + ratio), ratio / (1.0 + ratio)) } else { (0.0, 1.0) }
}

/// Residuals of the two conditions at the support.
fn support_conditions(wavenumber: f64, ends: &Ends, coefficients: &Coefficients) -> [f64; 2] {
    let [w, slope, moment, shear] = scaled_derivatives(wavenumber, coefficients, 1.0);
    let (m, r) = weights(ends.support_rotation / wavenumber);
    let (q, s) = weights(ends.support / wavenumber.powi(3));
    [m * moment + r * slope, q * shear - s * w]
}

fn rows(wavenumber: f64, ends: &Ends) -> [[f64; 2]; 2] {
    let far = support_conditions(wavenumber, ends, &complete(wavenumber, ends, 1.0, 0.0));
    let sine = support_conditions(wavenumber, ends, &complete(wavenumber, ends, 0.0, 1.0));
    [[far[0], sine[0]], [far[1], sine[1]]]
}

/// The determinant whose zeros are the natural wavenumbers.
pub(crate) fn determinant(wavenumber: f64, ends: &Ends) -> f64 {
    let [first, second] = rows(wavenumber, ends);
    first[0] * second[1] - first[1] * second[0]
}

/// Coefficients of the mode at a root, not normalised.
pub(crate) fn mode_coefficients(wavenumber: f64, ends: &Ends) -> Coefficients {
    let [first, second] = rows(wavenumber, ends);
    let longer = if first[0].hypot(first[1]) > second[0].hypot(second[1]) { first } else { second };
    complete(wavenumber, ends, longer[1], -longer[0])
}

/// The first `count` roots.
///
/// # Errors
/// [`BeamError::RootNotBracketed`] where a root lies outside the interval between the softest ends (hinged-free) and the
/// stiffest ones (clamped-clamped): a root was missed.
pub(crate) fn roots(ends: &Ends, count: usize) -> Result<Vec<f64>, BeamError> {
    let mut found = Vec::with_capacity(count);
    let mut low = SCAN_START;
    let mut value = determinant(low, ends);
    while found.len() < count {
        let high = low + SCAN_STEP;
        let next = determinant(high, ends);
        if value == 0.0 || value * next < 0.0 {
            let root = bisect(ends, low, high);
            check_place(found.len() + 1, root)?;
            found.push(root);
        } else if low > (count as f64 + 1.0) * std::f64::consts::PI {
            check_place(found.len() + 1, low)?;
        }
        (low, value) = (high, next);
    }
    Ok(found)
}

fn check_place(mode: usize, root: f64) -> Result<(), BeamError> {
    let low = ((mode as f64 - 0.76) * std::f64::consts::PI).max(0.0);
    let low = if mode == 1 { 0.0 } else { low };
    let high = (mode as f64 + 0.51) * std::f64::consts::PI;
    if (low..=high).contains(&root) {
        Ok(())
    } else {
        Err(BeamError::RootNotBracketed { mode, found: root, low, high })
    }
}

/// Bisection to the last bit: about fifty evaluations, without an assumption on the slope.
fn bisect(ends: &Ends, mut low: f64, mut high: f64) -> f64 {
    let sign = determinant(low, ends).signum();
    loop {
        let middle = 0.5 * (low + high);
        if middle <= low || middle >= high {
            return middle;
        }
        let value = determinant(middle, ends);
        if value == 0.0 {
            return middle;
        }
        if value.signum() == sign {
            low = middle;
        } else {
            high = middle;
        }
    }
}
