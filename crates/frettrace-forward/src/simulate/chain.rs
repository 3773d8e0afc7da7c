//! What the measuring chain of a sensor adds and takes away.

use rand::RngExt;
use rand_distr::StandardNormal;
use rand_pcg::Pcg64;

/// A measuring chain; the default is a perfect one.
#[derive(Clone, Debug, PartialEq)]
pub struct Chain {
    /// Factor on the signal.
    pub gain: f64,
    /// Time by which the channel is late (s).
    pub delay: f64,
    /// Constant added (m/s²).
    pub offset: f64,
    /// Mains hum.
    pub hum: Option<Hum>,
    /// Standard deviation of the noise (m/s²).
    pub noise: f64,
    /// Correlation of the noise from sample to sample; 0 is white.
    pub noise_correlation: f64,
    /// Largest magnitude the chain can carry (m/s²).
    pub limit: f64,
    /// Largest reading upwards (m/s²), where it is another one.
    pub upper_limit: f64,
    /// Stretches of the record, as shares of its length, that read zero.
    pub dropouts: Vec<[f64; 2]>,
    /// Whether lost samples repeat the last good one instead of reading zero.
    pub holds: bool,
    /// Change of the offset from the first sample to the last (m/s²).
    pub offset_drift: f64,
    /// Offset at the first sample (m/s²) that dies away, to e⁻⁴ of it at the last: a charge amplifier after a shock.
    pub settling_offset: f64,
    /// What else it does to the signal.
    pub distortion: Option<Distortion>,
}

/// What a chain may do to a signal `x` beside gain and delay.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Distortion {
    /// `x/(1 + |x/limit|⁸)^{1/8}`: a limit (m/s²) that is approached smoothly.
    SoftLimit(f64),
    /// `x + c x²` (s²/m).
    Quadratic(f64),
    /// A high-pass of first order (Hz).
    HighPass(f64),
    /// A low-pass of first order with its time constant (s).
    LowPass(f64),
    /// Two of them with the same time constant (s) after one another.
    TwoLowPasses(f64),
}

impl Distortion {
    /// Applies it to samples at a rate; a filter is first run in over the stretch `warm_up` of the signal.
    pub(super) fn apply(self, signal: &mut [f64], rate: f64, warm_up: &[f64]) {
        match self {
            Self::SoftLimit(limit) => {
                for x in signal {
                    *x /= (1.0 + (*x / limit).powi(8)).powf(0.125);
                }
            }
            Self::Quadratic(coefficient) => {
                for x in signal {
                    *x += coefficient * *x * *x;
                }
            }
            Self::HighPass(corner) => {
                first_order(signal, std::f64::consts::TAU * corner / rate, warm_up, |x, slow| x - slow);
            }
            Self::LowPass(time) => first_order(signal, 1.0 / (time * rate), warm_up, |_, slow| slow),
            Self::TwoLowPasses(time) => {
                let step = 1.0 / (time * rate);
                let mut first = warm_up.to_vec();
                first_order(&mut first, step, warm_up, |_, slow| slow);
                first_order(signal, step, warm_up, |_, slow| slow);
                first_order(signal, step, &first, |_, slow| slow);
            }
        }
    }
}

/// Follows the signal with `s' = (x − s)/τ`, exact for samples joined by straight lines; `step` is `Δt/τ`.
fn first_order(signal: &mut [f64], step: f64, warm_up: &[f64], read: impl Fn(f64, f64) -> f64) {
    let kept = (-step).exp();
    let mean = (1.0 - kept) / step;
    let mut slow = 0.0;
    let mut last = warm_up.first().copied().unwrap_or(0.0);
    let mut follow = |x: f64| {
        slow = kept * slow + x - (x - last) * mean - kept * last;
        last = x;
        slow
    };
    for &x in warm_up {
        follow(x);
    }
    for x in signal {
        *x = read(*x, follow(*x));
    }
}

/// A sinusoid that does not come from the structure.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hum {
    /// Amplitude (m/s²).
    pub amplitude: f64,
    /// Frequency (Hz).
    pub frequency: f64,
    /// Phase (rad).
    pub phase: f64,
    /// Amplitude of the third harmonic over that of the first.
    pub third: f64,
}

impl Hum {
    /// Its value at a time (s).
    fn at(&self, time: f64) -> f64 {
        let phase = std::f64::consts::TAU * self.frequency * time + self.phase;
        self.amplitude * (phase.sin() + self.third * (3.0 * phase).sin())
    }
}

impl Default for Chain {
    fn default() -> Self {
        Self {
            gain: 1.0,
            delay: 0.0,
            offset: 0.0,
            hum: None,
            noise: 0.0,
            noise_correlation: 0.0,
            limit: f64::INFINITY,
            upper_limit: f64::INFINITY,
            dropouts: Vec::new(),
            holds: false,
            offset_drift: 0.0,
            settling_offset: 0.0,
            distortion: None,
        }
    }
}

impl Chain {
    /// Applies everything but the delay, which the filter has applied: gain, offset, hum, noise, then clipping and
    /// dropouts.
    pub(super) fn apply(&self, signal: &mut [f64], rate: f64, random: &mut Pcg64) {
        let count = signal.len() as f64;
        let fresh = (1.0 - self.noise_correlation * self.noise_correlation).sqrt();
        let mut held = 0.0;
        let mut noise: f64 = random.sample(StandardNormal);
        for (k, value) in signal.iter_mut().enumerate() {
            let hum = self.hum.map_or(0.0, |hum| hum.at(k as f64 / rate));
            let place = k as f64 / count;
            let settling = self.settling_offset * (-4.0 * place).exp();
            let offset = self.offset + self.offset_drift * place + settling;
            let read = self.gain * *value + offset + hum + self.noise * noise;
            let lost = self.dropouts.iter().any(|[from, to]| (*from..*to).contains(&place));
            if !lost {
                held = read.clamp(-self.limit, self.limit.min(self.upper_limit));
            }
            *value = if lost && !self.holds { 0.0 } else { held };
            let draw: f64 = random.sample(StandardNormal);
            noise = self.noise_correlation * noise + fresh * draw;
        }
    }
}
