//! Time series of the result.

use crate::RunData;
use frettrace_fourier::Harmonics;

/// When samples are taken, and how well the base frequency is known (rad/s); 0 where lines are bins of the record.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Times {
    pub(crate) rate: f64,
    pub(crate) samples: usize,
    pub(crate) frequency_std: f64,
}

/// A time series with its standard deviation, one value a sample.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Channel {
    /// Values.
    pub values: Vec<f64>,
    /// Standard deviations.
    pub std: Vec<f64>,
}

impl Channel {
    /// Samples of harmonics.
    ///
    /// Line errors are independent and without preferred phase: their variance `½ Σ_h E|ε_h|²` is the same at all times.
    /// An error of the base frequency turns the signal about the middle of the record: `δx(t) = δΩ/Ω · (t − T/2) ẋ(t)`.
    pub(crate) fn from_harmonics(harmonics: &Harmonics, times: &Times) -> Self {
        let Times { rate, samples, frequency_std } = *times;
        let variance = 0.5 * harmonics.variance.iter().sum::<f64>();
        let turn = if harmonics.base > 0.0 { frequency_std / harmonics.base } else { 0.0 };
        let middle = 0.5 * (samples as f64 - 1.0) / rate;
        let std = if turn > 0.0 {
            let slope = harmonics.derivative().sample(rate, samples);
            let drift = |j: usize| turn * (j as f64 / rate - middle) * slope[j];
            (0..samples).map(|j| (variance + drift(j).powi(2)).sqrt()).collect()
        } else {
            vec![variance.sqrt(); samples]
        };
        Self { values: harmonics.sample(rate, samples), std }
    }

    /// The same, moved by a constant.
    #[must_use]
    pub(crate) fn plus(mut self, constant: f64) -> Self {
        self.values.iter_mut().for_each(|v| *v += constant);
        self
    }
}

/// Relative root mean square of measured less fitted acceleration over all sensors, means removed; and of noise alone.
pub(crate) fn errors(run: &RunData<'_>, fit: &[Channel], noise_std: &[f64]) -> (f64, f64) {
    let (mut left, mut power, mut noise) = (0.0, 0.0, 0.0);
    for ((measured, fit), std) in run.accelerations.iter().zip(fit).zip(noise_std) {
        let difference: Vec<f64> = measured.iter().zip(&fit.values).map(|(a, b)| a - b).collect();
        left += variance(&difference);
        power += variance(measured);
        noise += std * std;
    }
    let scale = power.max(f64::MIN_POSITIVE);
    ((left / scale).sqrt(), (noise / scale).sqrt())
}

/// Mean square about the mean.
fn variance(x: &[f64]) -> f64 {
    let n = x.len().max(1) as f64;
    let mean = x.iter().sum::<f64>() / n;
    x.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / n
}
