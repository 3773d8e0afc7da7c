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
    /// The width for a record: its noise `σ` from third differences (`Var Δ³ = 20σ²`), its third derivative from a
    /// first wide pass; `m` minimises `3σ²/(dt²m³) + (u‴(m dt)²/10)²`, variance and bias of the velocity.
    pub(super) fn of(time: &[f64], slip: &[f64]) -> Self {
        let n = slip.len();
        if n < 8 {
            return Self { half: 1, noise: 0.0 };
        }
        let dt = (time[n - 1] - time[0]) / (n - 1) as f64;
        let mut third: Vec<f64> =
            slip.windows(4).map(|w| (w[3] - 3.0 * w[2] + 3.0 * w[1] - w[0]).abs()).collect();
        third.sort_by(f64::total_cmp);
        // The median of |Δ³| does not see the kinks of reversals; 0.6745 turns it into a standard deviation.
        let noise = third[third.len() / 2] / 0.6745 / 20.0_f64.sqrt();
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
        for k in 0..n {
            let window = k.saturating_sub(self.half)..(k + self.half + 1).min(n);
            let [a, b, c] = parabola(&time[window.clone()], &slip[window], time[k]);
            motion.slip[k] = a;
            motion.velocity[k] = b;
            motion.acceleration[k] = 2.0 * c;
        }
        motion
    }
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
