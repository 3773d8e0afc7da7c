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
    /// Stretches of the record, as shares of its length, that read zero.
    pub dropouts: Vec<[f64; 2]>,
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
            dropouts: Vec::new(),
        }
    }
}

impl Chain {
    /// Applies everything but the delay, which the filter has applied: gain, offset, hum, noise, then clipping and
    /// dropouts.
    pub(super) fn apply(&self, signal: &mut [f64], rate: f64, random: &mut Pcg64) {
        let count = signal.len() as f64;
        let fresh = (1.0 - self.noise_correlation * self.noise_correlation).sqrt();
        let mut noise: f64 = random.sample(StandardNormal);
        for (k, value) in signal.iter_mut().enumerate() {
            let hum = self.hum.map_or(0.0, |hum| {
                hum.amplitude * (std::f64::consts::TAU * hum.frequency * k as f64 / rate + hum.phase).sin()
            });
            let read = self.gain * *value + self.offset + hum + self.noise * noise;
            let place = k as f64 / count;
            let lost = self.dropouts.iter().any(|[from, to]| (*from..*to).contains(&place));
            *value = if lost { 0.0 } else { read.clamp(-self.limit, self.limit) };
            let draw: f64 = random.sample(StandardNormal);
            noise = self.noise_correlation * noise + fresh * draw;
        }
    }
}
