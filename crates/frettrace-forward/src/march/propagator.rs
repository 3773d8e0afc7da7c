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
    /// Coefficients for a step of `dt` (s); damping ratios below 1.
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
