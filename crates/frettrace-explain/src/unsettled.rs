//! Motions that have not quite settled.
//!
//! Lines of a motion whose size changes slowly over a record are its means, and what they leave grows from the middle of the record to its ends:
//! of a change `ε x`, with `x` from −1 to 1 over the record, the mean of `r² x²` is `3/5` of that of `r²`, where noise, a hum and lines that fold
//! have a third. With `U = 3 ⟨r² x²⟩/⟨r²⟩` that is 9/5 and 1: the drift has the share `(U − 1)/(4/5)` of what lies beside the lines. By chance `U`
//! of Gaussian noise is off by `√(0.8/N)`: of white noise `N` are its bins, of coloured noise the bins times `⟨P⟩²/⟨P²⟩`, with the level `P`
//! around each line.

use frettrace_fourier::Projected;

/// `⟨(3x² − 1)²⟩` over the record.
const SPREAD: f64 = 0.8;
/// Deviations by which all sensors together must show the drift, and one sensor.
const CHANCE: f64 = 5.0;
const HEARD: f64 = 2.0;

/// Mean square of what drifts in each channel (unit²): zero where not all sensors together and most of them show it. What a single one has is
/// no motion.
pub(crate) fn drifting(channels: &[Projected]) -> Vec<f64> {
    let shown: Vec<Shown> = channels.iter().map(Shown::of).collect();
    let total: f64 = shown.iter().map(|s| s.beyond / s.deviation).sum();
    let heard = shown.iter().filter(|s| s.beyond > HEARD * s.deviation).count();
    if total <= CHANCE * (shown.len() as f64).sqrt() || 2 * heard < shown.len() {
        return vec![0.0; channels.len()];
    }
    shown.iter().map(|s| (s.beyond / SPREAD).clamp(0.0, 1.0) * s.power).collect()
}

/// What a channel shows of a drift.
struct Shown {
    /// `U − 1`, and its deviation by chance.
    beyond: f64,
    deviation: f64,
    /// Mean square beside the lines.
    power: f64,
}

impl Shown {
    fn of(channel: &Projected) -> Self {
        let samples = channel.residual.len() as f64;
        let place = |j: usize| 2.0 * (j as f64 + 0.5) / samples - 1.0;
        let power: f64 = channel.residual.iter().map(|r| r * r).sum();
        let outer: f64 = channel.residual.iter().enumerate().map(|(j, r)| (r * place(j)).powi(2)).sum();
        let levels = &channel.harmonics.variance;
        let lines = levels.len() as f64;
        let mean = levels.iter().sum::<f64>() / lines;
        let square = levels.iter().map(|level| level * level).sum::<f64>() / lines;
        if power == 0.0 || square == 0.0 {
            return Self { beyond: 0.0, deviation: 1.0, power: 0.0 };
        }
        let independent = channel.periodogram.len() as f64 * mean * mean / square;
        Self {
            beyond: 3.0 * outer / power - 1.0,
            deviation: (SPREAD / independent).sqrt(),
            power: power / samples,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::drifting;
    use frettrace_fourier::{Lines, Projected, Projector};
    use rand::SeedableRng;
    use rand_distr::{Distribution, Normal};

    const SAMPLES: usize = 4000;

    /// Four channels of noise of deviation one beside a tone of amplitude 20 that changes by `change` of it from the middle of the record to
    /// either end, and a hum of amplitude `hum` in the first.
    fn channels(change: f64, hum: f64) -> Vec<Projected> {
        let mut generator = rand_pcg::Pcg64::seed_from_u64(5);
        let noise = Normal::new(0.0, 1.0).unwrap();
        let lines = Lines { base: 60.0, order: 4, samples: SAMPLES, sampling_rate: 1000.0, drift: 0 };
        let projector = Projector::new(lines).unwrap();
        (0..4)
            .map(|s| {
                let signal: Vec<f64> = (0..SAMPLES)
                    .map(|j| {
                        let (t, x) = (j as f64 / 1000.0, 2.0 * j as f64 / SAMPLES as f64 - 1.0);
                        let tone = 20.0 * (1.0 + change * x) * (60.0 * t + f64::from(s)).sin();
                        let hum = if s == 0 { hum * (61.0 * t).sin() } else { 0.0 };
                        tone + hum + noise.sample(&mut generator)
                    })
                    .collect();
                projector.project(&signal).unwrap()
            })
            .collect()
    }

    /// A tone that changes by `ε` holds `½ (20 ε)²/3` beside its line: 0.167 with `ε` = 0.05, a sixth of the noise.
    #[test]
    fn a_tone_that_grows_is_told_from_noise() {
        let expected = 0.5 * (20.0_f64 * 0.05).powi(2) / 3.0;
        let found = drifting(&channels(0.05, 0.0));
        let mean = found.iter().sum::<f64>() / 4.0;
        assert!((mean / expected - 1.0).abs() < 0.25, "{found:?} of {expected}");
        assert_eq!(drifting(&channels(0.0, 0.0)), vec![0.0; 4]);
    }

    /// A hum a sixth of a hertz from a line, which looks like a drift of it, in one channel.
    #[test]
    fn what_one_sensor_hears_is_no_drift_of_the_motion() {
        assert_eq!(drifting(&channels(0.0, 2.0)), vec![0.0; 4]);
    }
}
