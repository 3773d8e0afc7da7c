//! Motion from noisy slip: local parabolas whose width balances noise against curvature.

use nalgebra::{Matrix3, Vector3};

/// Local parabolas over `2m + 1` samples.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Smoother {
    half: usize,
    noise: f64,
}

/// Smooth slip with its derivatives.
pub(super) struct Motion {
    pub(super) slip: Vec<f64>,
    pub(super) velocity: Vec<f64>,
    pub(super) acceleration: Vec<f64>,
}

/// Widest window, samples on each side.
const WIDEST: usize = 60;

impl Smoother {
    /// The width for a record: its noise `σ`, its third derivative from a first wide pass; `m` minimises `3σ²/(dt²m³) + (u‴(m dt)²/10)²`, variance and bias of the velocity.
    pub(super) fn of(time: &[f64], slip: &[f64]) -> Self {
        let n = slip.len();
        if n < 8 {
            return Self { half: 1, noise: 0.0 };
        }
        let dt = (time[n - 1] - time[0]) / (n - 1) as f64;
        let noise = noise(slip);
        let first = Self { half: 5.min(n / 8).max(1), noise };
        let accelerations = first.motion(time, slip).acceleration;
        let bend = accelerations.windows(2).map(|w| ((w[1] - w[0]) / dt).abs());
        let bend = bend.sum::<f64>() / (n - 1) as f64;
        let mut best = (f64::INFINITY, 1);
        for m in 1..=WIDEST.min(n / 8) {
            let size = m as f64;
            let variance = 3.0 * noise.powi(2) / (dt * dt * size.powi(3));
            let bias = bend * (size * dt).powi(2) / 10.0;
            let risk = variance + bias * bias;
            if risk < best.0 {
                best = (risk, m);
            }
        }
        Self { half: best.1, noise }
    }

    /// Standard deviation of the noise of a slip sample.
    pub(super) fn noise(&self) -> f64 {
        self.noise
    }

    /// Slip, velocity and acceleration at every sample.
    pub(super) fn motion(&self, time: &[f64], slip: &[f64]) -> Motion {
        let n = slip.len();
        let mut motion = Motion { slip: vec![0.0; n], velocity: vec![0.0; n], acceleration: vec![0.0; n] };
        let width = (2 * self.half + 1).min(n);
        for k in 0..n {
            // As wide at the ends: two samples make no parabola.
            let first = k.saturating_sub(self.half).min(n - width);
            let window = first..first + width;
            let [a, b, c] = parabola(&time[window.clone()], &slip[window], time[k]);
            motion.slip[k] = a;
            motion.velocity[k] = b;
            motion.acceleration[k] = 2.0 * c;
        }
        motion
    }
}

/// Orders of the differences that tell noise.
const DIFFERENCES: std::ops::RangeInclusive<usize> = 3..=8;

/// Noise from differences: `Var Δᵖ = C(2p, p) σ²`. Each order holds the whole of the noise and `(2 sin ½θ)ᵖ` of a motion that
/// turns by `θ` from sample to sample, so that the least of the estimates is the nearest.
fn noise(slip: &[f64]) -> f64 {
    let mut differences = slip.to_vec();
    let (mut gain, mut least) = (1.0, f64::INFINITY);
    for order in 1..=*DIFFERENCES.end() {
        differences = differences.windows(2).map(|w| w[1] - w[0]).collect();
        let p = order as f64;
        // C(2p, p) = C(2p − 2, p − 1)·(4p − 2)/p.
        gain *= (4.0 * p - 2.0) / p;
        if !DIFFERENCES.contains(&order) || differences.is_empty() {
            continue;
        }
        let mut sizes: Vec<f64> = differences.iter().map(|d| d.abs()).collect();
        let middle = sizes.len() / 2;
        // The median does not see the kinks of reversals; 0.6745 turns it into a standard deviation.
        let (_, median, _) = sizes.select_nth_unstable_by(middle, f64::total_cmp);
        least = least.min(*median / 0.6745 / f64::sqrt(gain));
    }
    least
}

/// `a + b(t − t₀) + c(t − t₀)²` by least squares.
fn parabola(time: &[f64], value: &[f64], at: f64) -> [f64; 3] {
    let span = (time[time.len() - 1] - time[0]).max(f64::MIN_POSITIVE);
    let mut matrix = Matrix3::zeros();
    let mut right = Vector3::zeros();
    for (t, x) in time.iter().zip(value) {
        let s = (t - at) / span;
        let row = Vector3::new(1.0, s, s * s);
        matrix += row * row.transpose();
        right += row * *x;
    }
    match matrix.cholesky() {
        Some(solver) => {
            let found = solver.solve(&right);
            [found[0], found[1] / span, found[2] / (span * span)]
        }
        // Two samples or equal times: no parabola, only a mean.
        None => [value.iter().sum::<f64>() / value.len() as f64, 0.0, 0.0],
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::SeedableRng;
    use rand_distr::{Distribution, StandardNormal};

    /// A parabola comes back to the last digits, at its ends too.
    #[test]
    fn a_parabola_has_its_velocity_at_the_ends() {
        let time: Vec<f64> = (0..20).map(|k| 0.1 * f64::from(k)).collect();
        let slip: Vec<f64> = time.iter().map(|t| 1.0 + 2.0 * t + 3.0 * t * t).collect();
        let motion = Smoother { half: 1, noise: 0.0 }.motion(&time, &slip);
        for (t, v) in time.iter().zip(&motion.velocity) {
            assert!((v - 2.0 - 6.0 * t).abs() < 1e-11, "{t}: {v}");
        }
    }

    /// A sine of ten samples a period: its third differences are a twentieth of it, `(2 sin 18°)³/√20`; its noise of a
    /// thousandth is found all the same, to less than a half.
    #[test]
    fn a_fast_motion_is_no_noise() {
        let mut generator = rand_pcg::Pcg64::seed_from_u64(1);
        let mut normal = || -> f64 { StandardNormal.sample(&mut generator) };
        let slip: Vec<f64> = (0..300)
            .map(|k| (std::f64::consts::TAU * k as f64 / 10.0 + 0.1).sin() + 1e-3 * normal())
            .collect();
        assert!((noise(&slip) / 1e-3 - 1.0).abs() < 0.4, "{}", noise(&slip));
    }
}
