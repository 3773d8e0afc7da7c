//! How good the signals of a run are: level, noise, steadiness, subharmonics, clipping, dead channels.
//!
//! Periodic motion is projected on the lines of the excitation frequency; what the lines leave is noise or motion of
//! another period. Nothing here knows the beam.

use crate::{ContactRun, Run, Sensors};
use frettrace_fourier::{Lines, ProjectionError, Projector, refine};
use num_complex::Complex64;
use serde::Serialize;

/// Highest subharmonic order looked for.
const HIGHEST_SUBHARMONIC: usize = 6;
/// Subharmonic lines count where they lift the explained variance by this factor: with thousands of samples the residual
/// variance is known within a few per cent, and a factor of 1.5 is far outside that.
const SUBHARMONIC_GAIN: f64 = 1.5;
/// Consecutive samples on the extreme value that make a plateau: a sampled sine has at most two equal highest samples.
const PLATEAU: usize = 3;

/// Share of the motion that harmonics beyond the band may leave: force kinks decay as 1/h², about 1e-3 at the band's edge.
const FOLDED: f64 = 5e-3;

/// State of a channel.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum ChannelState {
    /// Nothing to complain of.
    Good,
    /// The same extreme value stands for several samples in a row, at either end.
    Clipped,
    /// No line rises above the noise although other channels see the motion.
    Dead,
}

/// One accelerometer in one run.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Channel {
    /// Root mean square without the mean (m/s²).
    pub rms: f64,
    /// Standard deviation of the noise (m/s²): declared, or what the lines leave.
    pub noise_std: f64,
    /// Whether the noise is declared in the file.
    pub noise_declared: bool,
    /// Level of the lines over the noise \[dB\].
    pub signal_to_noise_db: f64,
    /// Longest plateau at the extreme value, in samples.
    pub plateau: usize,
    /// State.
    pub state: ChannelState,
}

/// One run.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct RunQuality {
    /// Name of the run's group in the file.
    pub id: String,
    /// Label.
    pub label: String,
    /// Samples.
    pub samples: usize,
    /// Excitation frequency refined from the force channel \[Hz\].
    pub frequency: f64,
    /// Its standard deviation \[Hz\].
    pub frequency_std: f64,
    /// Root mean square of the excitation force without its mean \[N\].
    pub force_rms: f64,
    /// Root mean square of the accelerations over all sensors, without means (m/s²).
    pub level: f64,
    /// Share of the acceleration in harmonics of the excitation above the first (relative RMS).
    pub harmonic_share: f64,
    /// Largest relative change of the first harmonic between the first and the last third of the run.
    pub unsteadiness: f64,
    /// Order of the subharmonic motion; 1 where the motion has the period of the excitation.
    pub subharmonic_order: usize,
    /// Whether lines explain the motion down to the declared noise; `null` where no noise is declared.
    pub periodic: Option<bool>,
    /// What no line explains, relative to the level: noise in a periodic run, more where the run is not periodic.
    pub unexplained_share: f64,
    /// The channels, in the order of the sensors.
    pub channels: Vec<Channel>,
}

/// One run of a contact record.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ContactQuality {
    /// Name of the run's group in the file.
    pub id: String,
    /// Label.
    pub label: String,
    /// Samples.
    pub samples: usize,
    /// Duration \[s\].
    pub duration: f64,
    /// Whether samples are equidistant.
    pub uniform: bool,
    /// Root mean square of the force without its mean \[N\].
    pub force_rms: f64,
    /// Largest minus smallest slip, in the unit of the slip.
    pub slip_span: f64,
    /// Number of cycles of the slip, from the crossings of its mid line with a dead band of a tenth of the span: a record of
    /// n cycles has 2n − 1 crossings when it begins on the mid line, 2n otherwise.
    pub cycles: usize,
}

/// Judges the signals of one run of a contact record.
#[must_use]
pub fn judge_contact(run: &ContactRun) -> ContactQuality {
    let (low, high) = extremes(&run.slip_displacement);
    let duration = match (run.time.first(), run.time.last()) {
        (Some(first), Some(last)) => last - first,
        _ => 0.0,
    };
    let (middle, band) = (0.5 * (low + high), 0.05 * (high - low));
    let sides = run.slip_displacement.iter().map(|u| u - middle).filter(|u| u.abs() > band);
    let signs: Vec<bool> = sides.map(|u| u > 0.0).collect();
    let crossings = signs.windows(2).filter(|pair| pair[0] != pair[1]).count();
    ContactQuality {
        id: run.id.clone(),
        label: run.label.clone(),
        samples: run.force.len(),
        duration,
        uniform: run.sampling_rate.is_some(),
        force_rms: variance(&run.force).sqrt(),
        slip_span: high - low,
        cycles: crossings.div_ceil(2),
    }
}

/// Judges the signals of one run.
///
/// # Errors
/// [`ProjectionError`] when the run is too short for lines of its excitation frequency.
pub fn judge(run: &Run, sensors: &Sensors) -> Result<RunQuality, ProjectionError> {
    let nominal = std::f64::consts::TAU * run.excitation_frequency;
    let frequency = refine(lines(run, nominal, 1), &[&run.force])?;
    let harmonic = Split::new(run, frequency.base, 1)?;
    let subharmonic_order = subharmonic_order(run, frequency.base, &harmonic)?;
    let split = Split::new(run, frequency.base, subharmonic_order)?;
    let level = mean_square(run.acceleration.iter().map(|channel| variance(channel))).sqrt();
    let first = mean_square(harmonic.first.iter().map(|x| 0.5 * x.norm_sqr())).sqrt();
    let channels = channels(run, sensors, &split);
    Ok(RunQuality {
        id: run.id.clone(),
        label: run.label.clone(),
        samples: run.force.len(),
        frequency: frequency.base / std::f64::consts::TAU,
        frequency_std: frequency.std / std::f64::consts::TAU,
        force_rms: variance(&run.force).sqrt(),
        level,
        harmonic_share: ratio((split.signal.powi(2) - first.powi(2)).max(0.0).sqrt(), level),
        unsteadiness: unsteadiness(run, frequency.base)?,
        subharmonic_order,
        periodic: periodic(sensors, &split),
        unexplained_share: ratio(split.residual(), level),
        channels,
    })
}

/// Lines of `base / order` up to the band edge, at most as many as a quarter of the samples determines.
fn lines(run: &Run, base: f64, order: usize) -> Lines {
    let base = base / order as f64;
    let samples = run.force.len();
    let edge = (0.45 * run.sampling_rate * std::f64::consts::TAU / base) as usize;
    Lines { base, order: edge.min(samples / 8).max(1), samples, sampling_rate: run.sampling_rate, drift: 0 }
}

/// Accelerations split into lines and the rest.
struct Split {
    first: Vec<Complex64>,
    lines_rms: Vec<f64>,
    residual_std: Vec<f64>,
    signal: f64,
}

impl Split {
    fn new(run: &Run, base: f64, order: usize) -> Result<Self, ProjectionError> {
        let projector = Projector::new(lines(run, base, order))?;
        let fits = run
            .acceleration
            .iter()
            .map(|channel| projector.project(channel))
            .collect::<Result<Vec<_>, _>>()?;
        let first = fits.iter().filter_map(|fit| fit.harmonics.coefficients.get(order).copied()).collect();
        let lines_rms: Vec<f64> = fits.iter().map(|fit| fit.harmonics.rms()).collect();
        let residual_std = fits.iter().map(|fit| fit.residual_std).collect();
        let signal = mean_square(lines_rms.iter().map(|rms| rms * rms)).sqrt();
        Ok(Self { first, lines_rms, residual_std, signal })
    }

    fn residual(&self) -> f64 {
        mean_square(self.residual_std.iter().map(|std| std * std)).sqrt()
    }
}

/// The order whose lines explain most of what the harmonics leave; 1 where none explains much more.
fn subharmonic_order(run: &Run, base: f64, harmonic: &Split) -> Result<usize, ProjectionError> {
    let (mut best, mut least) = (1, harmonic.residual() / SUBHARMONIC_GAIN.sqrt());
    for order in 2..=HIGHEST_SUBHARMONIC {
        match Split::new(run, base, order) {
            Ok(split) if split.residual() < least => (best, least) = (order, split.residual() / 1.05),
            // Too short a run for lines this close: no statement about this order.
            Ok(_) | Err(ProjectionError::Unresolved { .. } | ProjectionError::TooShort { .. }) => {}
            Err(error) => return Err(error),
        }
    }
    Ok(best)
}

/// Whether the residual is within twice the declared noise (a stated noise may well be wrong by a factor of two), or so small a
/// share of the motion that harmonics beyond the band, which stick-slip makes and sampling folds back, explain it.
fn periodic(sensors: &Sensors, split: &Split) -> Option<bool> {
    let declared = sensors.noise_std.as_deref()?;
    let noise = mean_square(declared.iter().map(|std| std * std)).sqrt();
    (noise > 0.0).then(|| split.residual() < (2.0 * noise).max(FOLDED * split.signal))
}

/// Relative change of the first harmonic, amplitude and phase, between the first and the last third.
fn unsteadiness(run: &Run, base: f64) -> Result<f64, ProjectionError> {
    let samples = run.force.len() / 3;
    let start = run.force.len() - samples;
    let part = Lines { samples, order: 1, ..lines(run, base, 1) };
    let projector = Projector::new(part)?;
    let turn = Complex64::cis(-base * start as f64 / run.sampling_rate);
    let (mut change, mut size) = (0.0, 0.0);
    for channel in &run.acceleration {
        let early = first_line(&projector, &channel[..samples])?;
        let late = first_line(&projector, &channel[start..])? * turn;
        change += (late - early).norm_sqr();
        size += early.norm_sqr();
    }
    Ok(ratio(change, size).sqrt())
}

fn first_line(projector: &Projector, x: &[f64]) -> Result<Complex64, ProjectionError> {
    Ok(projector.project(x)?.harmonics.coefficients.get(1).copied().unwrap_or_default())
}

fn channels(run: &Run, sensors: &Sensors, split: &Split) -> Vec<Channel> {
    let loudest = split.lines_rms.iter().copied().fold(0.0, f64::max);
    let declared = sensors.noise_std.as_deref().unwrap_or_default();
    let judge_one = |(index, samples): (usize, &Vec<f64>)| {
        let left = split.residual_std[index];
        let noise_std = declared.get(index).copied().filter(|std| *std > 0.0).unwrap_or(left);
        let lines_rms = split.lines_rms[index];
        let plateau = plateau(samples);
        let silent = lines_rms <= noise_std && loudest > 10.0 * noise_std.max(lines_rms);
        let state = match plateau {
            _ if silent => ChannelState::Dead,
            PLATEAU.. => ChannelState::Clipped,
            _ => ChannelState::Good,
        };
        Channel {
            rms: variance(samples).sqrt(),
            noise_std,
            noise_declared: index < declared.len(),
            signal_to_noise_db: 20.0 * ratio(lines_rms, noise_std).log10(),
            plateau,
            state,
        }
    };
    run.acceleration.iter().enumerate().map(judge_one).collect()
}

/// Longest run of equal samples at the highest or the lowest value.
fn plateau(x: &[f64]) -> usize {
    let (low, high) = extremes(x);
    let longest = |extreme: f64| {
        let (mut longest, mut here) = (0, 0);
        for value in x {
            here = if *value == extreme { here + 1 } else { 0 };
            longest = longest.max(here);
        }
        longest
    };
    longest(high).max(longest(low))
}

fn extremes(x: &[f64]) -> (f64, f64) {
    x.iter()
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| (low.min(*value), high.max(*value)))
}

fn variance(x: &[f64]) -> f64 {
    let mean = x.iter().sum::<f64>() / x.len().max(1) as f64;
    mean_square(x.iter().map(|value| (value - mean).powi(2)))
}

fn mean_square(squares: impl ExactSizeIterator<Item = f64>) -> f64 {
    let count = squares.len().max(1) as f64;
    squares.sum::<f64>() / count
}

/// `a / b`, and 0 where both vanish.
fn ratio(a: f64, b: f64) -> f64 {
    if a == 0.0 { 0.0 } else { a / b }
}

#[cfg(test)]
mod tests;
