//! Time series of the result.

use crate::contact::ContactHarmonics;
use crate::{RunData, RunLines};
use frettrace_fourier::{Grid, Harmonics, Sampler, variance};
use num_complex::Complex64;
use std::f64::consts::TAU;

/// When samples are taken, and how well the base frequency is known.
pub(crate) struct Times {
    rate: f64,
    /// Time of each sample (s).
    samples: Vec<f64>,
    /// Standard deviation of the base frequency (rad/s); 0 where lines are bins of the record.
    frequency_std: f64,
    sampler: Sampler,
}

impl Times {
    /// Times of the record of some lines, for harmonics like the given ones.
    pub(crate) fn new(lines: &RunLines, frequency_std: f64, like: &Harmonics) -> Self {
        let record = (lines.sampling_rate, lines.samples);
        let own = lines.sampler.as_ref();
        let own = own.filter(|_| like.base == lines.force.base && like.order() == lines.force.order());
        let sampler = own.cloned().unwrap_or_else(|| Sampler::new(like.base, like.order(), record));
        let samples = (0..lines.samples).map(|j| j as f64 / lines.sampling_rate).collect();
        Self { rate: lines.sampling_rate, samples, frequency_std, sampler }
    }

    /// Time of each sample (s).
    pub(crate) fn into_samples(self) -> Vec<f64> {
        self.samples
    }
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
    /// Noise makes independent errors of the lines, without preferred phase: their variance `½ Σ_h E|ε_h|²` is the same at all
    /// times. Errors that lines share, `g_p(t)`, add `Σ_p g_p(t)²`. An error of the base frequency turns the signal about the
    /// middle of the record: `δx(t) = δΩ/Ω · (t − T/2) ẋ(t)`.
    pub(crate) fn from_harmonics(harmonics: &Harmonics, shared: &[Vec<Complex64>], times: &Times) -> Self {
        let Times { rate, samples: ref times, frequency_std, ref sampler } = *times;
        let samples = times.len();
        let values = sampler.sample(&harmonics.coefficients);
        let total = 0.5 * harmonics.variance.iter().sum::<f64>();
        // The lines of a record that has no period are its own bins.
        let own = (harmonics.base * samples as f64 - TAU * rate).abs() < 1e-9 * TAU * rate;
        let grid = own.then_some(samples);
        let (variance, breathing) = split(total, shared, grid);
        let turn = if harmonics.base > 0.0 { frequency_std / harmonics.base } else { 0.0 };
        let middle = 0.5 * (samples as f64 - 1.0) / rate;
        let derivative = harmonics.derivative();
        // At the ends of the record, where the turn matters most.
        let turns = (turn * middle * derivative.rms()).powi(2) > NEGLIGIBLE * total;
        if breathing.is_empty() && !turns {
            return Self { values, std: vec![variance.sqrt(); samples] };
        }
        let mut std = vec![variance; samples];
        add_over_periods(&breathing, harmonics.base / (TAU * rate), &mut std);
        if turns {
            let slope = sampler.sample(&derivative.coefficients);
            for ((variance, slope), time) in std.iter_mut().zip(slope).zip(times) {
                *variance += (turn * (time - middle) * slope).powi(2);
            }
        }
        std.iter_mut().for_each(|variance| *variance = variance.sqrt());
        Self { values, std }
    }

    /// The same with what is independent of it added.
    #[must_use]
    pub(crate) fn with(mut self, other: &Self) -> Self {
        self.values.iter_mut().zip(&other.values).for_each(|(a, b)| *a += b);
        self.std.iter_mut().zip(&other.std).for_each(|(a, b)| *a = a.hypot(*b));
        self
    }

    /// The same, moved by a constant.
    #[must_use]
    pub(crate) fn plus(mut self, constant: f64) -> Self {
        self.values.iter_mut().for_each(|v| *v += constant);
        self
    }
}

/// Time series of a contact.
pub(crate) struct Series {
    pub(crate) friction: Channel,
    pub(crate) slip: Channel,
    pub(crate) slip_velocity: Channel,
    pub(crate) normal: Channel,
    pub(crate) second_support: Option<Channel>,
    pub(crate) acceleration_fit: Vec<Channel>,
}

impl Series {
    /// Samples of what was recovered.
    pub(crate) fn of(contact: &ContactHarmonics, times: &Times) -> Self {
        let series = |harmonics, shared: &[_]| Channel::from_harmonics(harmonics, shared, times);
        let shared = &contact.shared;
        let second = contact.second_support.as_ref();
        Self {
            friction: series(&contact.friction, &shared.friction),
            slip: series(&contact.slip, &shared.slip),
            slip_velocity: series(&contact.slip_velocity, &shared.slip_velocity),
            normal: series(&contact.normal, &shared.normal),
            second_support: second.map(|second| series(second, &shared.second_support)),
            acceleration_fit: contact.acceleration_fit.iter().map(|a| series(a, &[])).collect(),
        }
    }

    /// The same with what is independent of it added.
    pub(crate) fn with(self, other: &Self) -> Self {
        let fits = self.acceleration_fit.into_iter().zip(&other.acceleration_fit);
        Self {
            friction: self.friction.with(&other.friction),
            slip: self.slip.with(&other.slip),
            slip_velocity: self.slip_velocity.with(&other.slip_velocity),
            normal: self.normal.with(&other.normal),
            second_support: self
                .second_support
                .map(|own| other.second_support.as_ref().map_or(own.clone(), |more| own.with(more))),
            acceleration_fit: fits.map(|(own, more)| own.with(more)).collect(),
        }
    }
}

/// Share of the total variance below which a shared error is counted as an independent one.
const NEGLIGIBLE: f64 = 1e-3;

/// Splits a total variance into the part that does not depend on time, and that of the shared errors over one period, at so many
/// places of it.
fn split(total: f64, shared: &[Vec<Complex64>], places: Option<usize>) -> (f64, Vec<f64>) {
    let power = |source: &[Complex64]| 0.5 * source.iter().map(Complex64::norm_sqr).sum::<f64>();
    let strong: Vec<&Vec<Complex64>> = shared.iter().filter(|s| power(s) > NEGLIGIBLE * total).collect();
    let Some(order) = strong.first().map(|source| source.len() - 1) else { return (total, Vec::new()) };
    let samples = places.unwrap_or((8 * order).max(1).next_power_of_two());
    let Ok(grid) = Grid::new(order, samples) else { return (total, Vec::new()) };
    let mut scratch = grid.scratch();
    let (mut sum, mut one) = (vec![0.0; samples], vec![0.0; samples]);
    let mut left = total;
    for source in strong {
        grid.evaluate(source, &mut one, &mut scratch);
        sum.iter_mut().zip(&one).for_each(|(s, g)| *s += g * g);
        left -= power(source);
    }
    (left.max(0.0), sum)
}

/// Adds samples over one period, linear between them, to samples that advance by so many periods each; nothing where there are none.
fn add_over_periods(period: &[f64], advance: f64, to: &mut [f64]) {
    let count = period.len();
    if count < 2 {
        return;
    }
    let step = advance * count as f64;
    // A division each sample would take longer than all else here.
    let mut periods = 0;
    for (j, value) in to.iter_mut().enumerate() {
        let place = j as f64 * step;
        let whole = place as usize;
        if whole - periods >= count {
            periods = whole - whole % count;
        }
        let (first, share) = (whole - periods, place - whole as f64);
        let next = if first + 1 == count { 0 } else { first + 1 };
        *value += period[first] * (1.0 - share) + period[next] * share;
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
