//! The exact step of an oscillator under a load that is linear over the step.

use num_complex::Complex64;

/// Per mode: `q₁ = a_qq q₀ + a_qv v₀ + b_q0 p₀ + b_q1 p₁` and the same for `v₁`.
#[derive(Clone, Debug, Default)]
pub(super) struct Propagator {
    pub(super) from_displacement: [Vec<f64>; 2],
    pub(super) from_velocity: [Vec<f64>; 2],
    pub(super) from_old_load: [Vec<f64>; 2],
    pub(super) from_new_load: [Vec<f64>; 2],
}

impl Propagator {
    /// Coefficients for a step of `dt` (s), at any damping.
    pub(super) fn new(natural_frequency: &[f64], damping_ratio: &[f64], dt: f64) -> Self {
        let mut result = Self::default();
        for (&frequency, &ratio) in natural_frequency.iter().zip(damping_ratio) {
            let [displacement, velocity, old, new] = coefficients(frequency, ratio, dt);
            for row in 0..2 {
                result.from_displacement[row].push(displacement[row]);
                result.from_velocity[row].push(velocity[row]);
                result.from_old_load[row].push(old[row]);
                result.from_new_load[row].push(new[row]);
            }
        }
        result
    }
}

/// Columns for `q₀, v₀, p₀, p₁`; rows `q₁, v₁`.
///
/// With `λ = −ζω + iω_d` the impulse response is `Im(e^{λt})/ω_d`; its integrals against 1 and `t/Δt` are
/// `Δt φ₁(λΔt)` and `Δt φ₂(λΔt)`.
fn coefficients(frequency: f64, ratio: f64, dt: f64) -> [[f64; 2]; 4] {
    if ratio > 1.0 - CRITICAL {
        return overdamped(frequency, ratio.max(1.0 + CRITICAL), dt);
    }
    let damped = frequency * (1.0 - ratio * ratio).sqrt();
    let decay = ratio * frequency;
    let pole = Complex64::new(-decay, damped);
    let z = pole * dt;
    let exponential = z.exp();
    let [first, second] = phi(z);
    let (sine, cosine) = (exponential.im / damped, exponential.re);
    let whole = [(first * dt).im / damped, (first * dt * pole).im / damped];
    let ramp = [(second * dt).im / damped, (second * dt * pole).im / damped];
    [
        [cosine + decay * sine, -frequency * frequency * sine],
        [sine, cosine - decay * sine],
        [whole[0] - ramp[0], whole[1] - ramp[1]],
        ramp,
    ]
}

/// Damping ratios nearer to 1 than this are taken as this much off it: the two poles stay apart, at a cost of 1e-7 of a
/// mode that does not ring anyway.
const CRITICAL: f64 = 1e-7;

/// The same for two real poles `p`, `m`: the impulse response is `(e^{pt} − e^{mt})/(p − m)`.
fn overdamped(frequency: f64, ratio: f64, dt: f64) -> [[f64; 2]; 4] {
    let apart = frequency * (ratio * ratio - 1.0).sqrt();
    // The slow pole from the product of both, which does not cancel.
    let fast = -ratio * frequency - apart;
    let slow = frequency * frequency / fast;
    let quotient = |at_slow: f64, at_fast: f64| (at_slow - at_fast) / (2.0 * apart);
    let [phi_slow, phi_fast] =
        [slow, fast].map(|pole| phi(Complex64::from(pole * dt)).map(|value| value.re * dt));
    let (e_slow, e_fast) = ((slow * dt).exp(), (fast * dt).exp());
    let whole = [quotient(phi_slow[0], phi_fast[0]), quotient(slow * phi_slow[0], fast * phi_fast[0])];
    let ramp = [quotient(phi_slow[1], phi_fast[1]), quotient(slow * phi_slow[1], fast * phi_fast[1])];
    [
        [quotient(-fast * e_slow, -slow * e_fast), -frequency * frequency * quotient(e_slow, e_fast)],
        [quotient(e_slow, e_fast), quotient(slow * e_slow, fast * e_fast)],
        [whole[0] - ramp[0], whole[1] - ramp[1]],
        ramp,
    ]
}

/// `φ₁ = (e^z − 1)/z`, `φ₂ = (e^z − 1 − z)/z²`, by their series where the quotients would cancel.
fn phi(z: Complex64) -> [Complex64; 2] {
    if z.norm() > 0.7 {
        let first = (z.exp() - 1.0) / z;
        return [first, (first - 1.0) / z];
    }
    // Σ z^k/(k+2)!; sixteen terms leave 0.7^16/18! < 1e-18.
    let mut second = Complex64::ZERO;
    for k in (0..16).rev() {
        second = (second * z + 1.0) / f64::from(k + 2);
    }
    [second * z + 1.0, second]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A thousand small steps of the classical Runge-Kutta rule.
    fn marched(frequency: f64, ratio: f64, start: [f64; 2], loads: [f64; 2]) -> [f64; 2] {
        let (count, mut y) = (1000, start);
        let h = 1.0 / f64::from(count);
        let rate = |t: f64, y: [f64; 2]| {
            let load = loads[0] + (loads[1] - loads[0]) * t;
            [y[1], load - 2.0 * ratio * frequency * y[1] - frequency * frequency * y[0]]
        };
        let along = |y: [f64; 2], k: [f64; 2], h: f64| [y[0] + h * k[0], y[1] + h * k[1]];
        for step in 0..count {
            let t = f64::from(step) * h;
            let k1 = rate(t, y);
            let k2 = rate(t + h / 2.0, along(y, k1, h / 2.0));
            let k3 = rate(t + h / 2.0, along(y, k2, h / 2.0));
            let k4 = rate(t + h, along(y, k3, h));
            y = [0, 1].map(|i| y[i] + h / 6.0 * (k1[i] + 2.0 * k2[i] + 2.0 * k3[i] + k4[i]));
        }
        y
    }

    #[test]
    fn a_step_is_exact_at_any_damping() {
        let cases = [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0], [0.0, 0.0, 0.0, 1.0]];
        for (frequency, ratio) in [(0.1, 0.01), (3.0, 0.3), (9.0, 0.7), (3.0, 1.0), (2.0, 1.5), (3.0, 5.0)] {
            let columns = coefficients(frequency, ratio, 1.0);
            for (column, [q, v, p0, p1]) in columns.iter().zip(cases) {
                let expected = marched(frequency, ratio, [q, v], [p0, p1]);
                for (found, expected) in column.iter().zip(expected) {
                    // Runge-Kutta's own error (ωh)⁴ ~ 1e-8 at the fastest pole, and 1e-7 of critical damping.
                    assert!((found - expected).abs() < 3e-7, "{frequency} {ratio}: {found} {expected}");
                }
            }
        }
    }
}
