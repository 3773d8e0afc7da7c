//! Channels at fault, found in their own samples before any model is blamed: dropouts, clipping, drift, mains hum, offsets.
//!
//! What a fault spoils is mended or left out, so that everything after works on what the channel would have read; the
//! difference counts in the error before.

mod bare;
mod clipping;
mod drift;
mod dropout;
mod hum;

use crate::records::MOST_DIVIDED;
use crate::{RunRecord, RunSamples, Saturation};
use frettrace_forward::accelerations::RunLines;
use frettrace_fourier::ProjectionError;
use rayon::prelude::*;

/// A fault of a channel.
#[derive(Clone, Debug, PartialEq)]
pub struct ChannelFault {
    /// The id of the effect.
    pub id: &'static str,
    /// Index of the sensor.
    pub sensor: usize,
    /// Name, unit, value and standard deviation of what describes it.
    pub parameters: Vec<(String, String, f64, f64)>,
    /// χ² that it explains.
    pub evidence: f64,
}

impl ChannelFault {
    /// Whether the signal breaks off or is cut: what a periodic run lost is filled from its other periods, the others have none.
    #[must_use]
    pub fn breaks_off(&self) -> bool {
        matches!(self.id, "measurement.dropout" | "measurement.clipping")
    }
}

/// Saturation of one channel in one run.
#[derive(Clone, Debug, PartialEq)]
pub enum Clipped {
    /// Flat tops: the lines of the channel are lost.
    Hard {
        /// Lowest and highest value that the channel reads (m/s²).
        limits: [f64; 2],
        /// What it read.
        raw: Vec<f64>,
        /// How it bends before it is flat.
        bend: Option<Saturation>,
    },
    /// A bend: the lines are those of what it read.
    Soft(Saturation),
}

/// Sensors that must be left in a run for one to be left out.
pub(crate) const LEAST_LEFT: usize = 3;
/// What lies beside the lines over the noise from which drift and hum are looked for.
const LOUD: f64 = 1.15;
/// χ² per run that a drift or a tone must explain in a channel.
const HEARD_IN_A_RUN: f64 = 40.0;
/// Smallest size of a drift or a hum over the noise: half a deviation adds an eighth to a quarter to the power of the noise.
const HEARD: f64 = 0.5;
/// Standard errors by which the mean of a channel must differ from nothing to be an offset.
const OFFSET_CLAIM: f64 = 8.0;

/// Lines of all runs, with the faults of the channels found and mended.
///
/// # Errors
/// Index of the run whose lines cannot be found, and why.
pub fn records(
    runs: &[RunSamples<'_>],
    noise: Option<&[f64]>,
) -> Result<(Vec<RunRecord>, Vec<ChannelFault>), (usize, ProjectionError)> {
    let mut channels = Channels::new(runs);
    let mut faults = clipping::find(runs, noise, &mut channels);
    faults.extend(dropout::find(runs, &mut channels));
    let mut records = channels.records(runs, noise)?;
    // Hum first, beside any drift: what a tone leaves of a broken period over the record looks like one.
    for find in [hum::find, drift::find] {
        if !records.iter().any(|r| more_than_noise(r, noise)) {
            break;
        }
        let before = (channels.signal.clone(), channels.drowning.clone());
        let found = find(runs, noise, &mut channels);
        if found.is_empty() {
            continue;
        }
        // Without a fault that is one, every run is closer to its lines than with it.
        let mended = channels.records(runs, noise)?;
        if quieter(&mended, &records) {
            faults.extend(found);
            records = mended;
        } else {
            (channels.signal, channels.drowning) = before;
        }
    }
    for offset in offsets(&mut records) {
        match faults.iter_mut().find(|fault| fault.id == offset.id && fault.sensor == offset.sensor) {
            Some(known) => {
                known.parameters.extend(offset.parameters);
                known.evidence += offset.evidence;
            }
            None => faults.push(offset),
        }
    }
    RunLines::follow_excitation(records.iter_mut().map(|record| &mut record.lines));
    Ok((records, faults))
}

/// Signals of all runs as far as they are mended: `[run][sensor]`.
struct Channels {
    signal: Vec<Vec<Vec<f64>>>,
    clipped: Vec<Vec<Option<Clipped>>>,
    /// Tones that a run has and cannot tell from its lines: `[run]`, sensor, frequency (Hz), amplitude (m/s²).
    drowning: Vec<Vec<(usize, f64, f64)>>,
}

impl Channels {
    fn new(runs: &[RunSamples<'_>]) -> Self {
        Self {
            signal: runs.iter().map(|r| r.acceleration.to_vec()).collect(),
            clipped: runs.iter().map(|r| vec![None; r.acceleration.len()]).collect(),
            drowning: vec![Vec::new(); runs.len()],
        }
    }

    /// Leaves a sensor out where it clips, as long as three others are left there: a flat top is no motion.
    fn blank(&mut self, sensor: usize) {
        for (signal, clipped) in self.signal.iter_mut().zip(&self.clipped) {
            if clipped[sensor].is_some() && clipped.iter().filter(|c| c.is_none()).count() >= LEAST_LEFT {
                signal[sensor].fill(0.0);
            }
        }
    }

    fn records(
        &self,
        runs: &[RunSamples<'_>],
        noise: Option<&[f64]>,
    ) -> Result<Vec<RunRecord>, (usize, ProjectionError)> {
        let mut records = self.projected(runs, noise)?;
        for (k, (run, record)) in runs.iter().zip(&mut records).enumerate() {
            for (s, raw) in run.acceleration.iter().enumerate() {
                record.power[s] = mean_square(raw.iter().copied());
            }
            let channels = run.acceleration.iter().zip(&self.signal[k]).zip(&self.clipped[k]);
            record.excess = channels
                .map(|((raw, mended), clipped)| match clipped {
                    Some(_) => 0.0,
                    None => mean_square(raw.iter().zip(mended).map(|(a, b)| a - b)),
                })
                .collect();
            for &(sensor, frequency, amplitude) in &self.drowning[k] {
                record.drown(sensor, frequency, amplitude);
            }
            record.silence(&self.clipped[k]);
        }
        Ok(known_noise(records))
    }

    /// Each run on lines of its own, and on those of the fraction of the excitation that most runs move with.
    fn projected(
        &self,
        runs: &[RunSamples<'_>],
        noise: Option<&[f64]>,
    ) -> Result<Vec<RunRecord>, (usize, ProjectionError)> {
        let last = runs.len().saturating_sub(1).max(1) as f64;
        let on = |k: usize, subharmonic: Option<usize>| {
            let mended = RunSamples { acceleration: &self.signal[k], ..runs[k] };
            RunRecord::on(&mended, (noise, k as f64 / last), subharmonic).map_err(|source| (k, source))
        };
        let found: Vec<_> = (0..runs.len()).into_par_iter().map(|k| on(k, None)).collect();
        let mut found = found.into_iter().collect::<Result<Vec<_>, _>>()?;
        let Some(common) = common_subharmonic(&found) else { return Ok(found) };
        let whole = found.par_iter_mut().enumerate().filter(|(_, r)| r.periodic && r.subharmonic == 1);
        whole.for_each(|(k, record)| {
            // A record too short for these lines stays on its own.
            if let Some(divided) = on(k, Some(common)).ok().filter(|divided| divided.periodic) {
                *record = divided;
            }
        });
        Ok(found)
    }
}

/// The fraction of the excitation, one over this, with which most periodic runs move: what moves them so may be in the others too, beneath their
/// noise.
fn common_subharmonic(records: &[RunRecord]) -> Option<usize> {
    let periodic: Vec<usize> = records.iter().filter(|r| r.periodic).map(|r| r.subharmonic).collect();
    let most =
        |subharmonic: &usize| 2 * periodic.iter().filter(|s| *s == subharmonic).count() > periodic.len();
    (2..=MOST_DIVIDED).find(most)
}

/// Whether a channel holds more beside the lines than noise.
fn more_than_noise(record: &RunRecord, noise: Option<&[f64]>) -> bool {
    let left = record.residual.iter().map(|r| mean_square(r.iter().copied()).sqrt());
    let loud = left.enumerate().any(|(s, left)| left > LOUD * noise.map_or(record.noise[s], |n| n[s]));
    loud || !record.periodic
}

/// Whether less lies beside the lines, and no run is lost.
fn quieter(new: &[RunRecord], old: &[RunRecord]) -> bool {
    let left = |all: &[RunRecord]| all.iter().flat_map(|r| &r.beside).sum::<f64>();
    let kept = new.iter().zip(old).all(|(n, o)| n.periodic || !o.periodic);
    kept && left(new) < left(old)
}

/// Gives a sensor that is left out in a run the noise it has in the others.
fn known_noise(mut records: Vec<RunRecord>) -> Vec<RunRecord> {
    let sensors = records.first().map_or(0, |r| r.noise.len());
    for sensor in 0..sensors {
        let heard: Vec<f64> = records.iter().map(|r| r.noise[sensor]).filter(|n| *n > 0.0).collect();
        let usual = heard.iter().sum::<f64>() / heard.len().max(1) as f64;
        for record in records.iter_mut().filter(|r| r.noise[sensor] <= 0.0) {
            record.noise[sensor] = usual;
        }
    }
    records
}

pub(crate) fn mean_square(values: impl ExactSizeIterator<Item = f64>) -> f64 {
    let count = values.len().max(1) as f64;
    values.map(|v| v * v).sum::<f64>() / count
}

/// Samples of one period of the excitation.
fn period(run: &RunSamples<'_>) -> usize {
    (run.sampling_rate / run.excitation_frequency).round().max(1.0) as usize
}

/// Offsets: line 0 of a channel off in all runs, by the same amount or by one that drifts from the first run to the last, taken out
/// of the lines. A vibration that lasts has no mean acceleration.
fn offsets(records: &mut [RunRecord]) -> Vec<ChannelFault> {
    let sensors = records.first().map_or(0, |r| r.power.len());
    let mut faults = Vec::new();
    for sensor in 0..sensors {
        let seen: Vec<Mean> = records
            .iter()
            .filter(|r| r.periodic && r.clipped[sensor].is_none())
            .map(|r| Mean {
                value: r.lines.acceleration[sensor][0].re,
                deviation: r.lines.deviation[sensor][0].max(f64::MIN_POSITIVE),
                progress: r.lines.progress,
            })
            .collect();
        let claims = |offset: &Offset| offset.claim() >= OFFSET_CLAIM;
        let constant = Offset::of(&seen, false).filter(claims);
        let drifting = Offset::of(&seen, true).filter(|offset| offset.drifts());
        let Some(offset) = drifting.or(constant) else { continue };
        for record in records.iter_mut() {
            let off = offset.at(record.lines.progress);
            record.lines.acceleration[sensor][0].re -= off;
            record.excess[sensor] += off * off;
        }
        let [start, slope] = offset.values;
        let named = |name: &str, (value, std): (f64, f64)| (name.into(), "m/s^2".into(), value, std);
        let mut parameters = vec![named("offset", start)];
        if slope.0 != 0.0 {
            parameters.push(named("offset_drift", slope));
        }
        let evidence = offset.claim().powi(2);
        faults.push(ChannelFault { id: "measurement.offset", sensor, parameters, evidence });
    }
    faults
}

/// Mean of a channel in a run at its place between the first (0) and the last (1).
struct Mean {
    value: f64,
    deviation: f64,
    progress: f64,
}

/// `a + b p` over the runs, each with its standard deviation; `b = 0` where it does not drift.
struct Offset {
    values: [(f64, f64); 2],
}

impl Offset {
    /// Weighted least squares; the scatter between runs counts where it is larger than the deviations. `None` where there are too few
    /// runs, or they stand at one place.
    fn of(seen: &[Mean], drifting: bool) -> Option<Self> {
        let width = 1 + usize::from(drifting);
        if seen.len() < 2 * width {
            return None;
        }
        let sum = |of: &dyn Fn(&Mean) -> f64| seen.iter().map(|m| of(m) * m.deviation.powi(-2)).sum::<f64>();
        let (w, wp, wpp) = (sum(&|_| 1.0), sum(&|m| m.progress), sum(&|m| m.progress * m.progress));
        let (wy, wpy) = (sum(&|m| m.value), sum(&|m| m.progress * m.value));
        let determinant = w * wpp - wp * wp;
        if drifting && determinant <= 1e-9 * w * wpp {
            return None;
        }
        let (start, slope, variances) = if drifting {
            let values = ((wpp * wy - wp * wpy) / determinant, (w * wpy - wp * wy) / determinant);
            (values.0, values.1, [wpp / determinant, w / determinant])
        } else {
            (wy / w, 0.0, [w.recip(), 0.0])
        };
        let left = sum(&|m| (m.value - start - slope * m.progress).powi(2));
        let scatter = (left / (seen.len() - width) as f64).max(1.0);
        let [first, second] = variances.map(|variance| (variance * scatter).sqrt());
        Some(Self { values: [(start, first), (slope, second)] })
    }

    fn at(&self, progress: f64) -> f64 {
        self.values[0].0 + self.values[1].0 * progress
    }

    /// Standard errors by which the surer of its values differs from nothing.
    fn claim(&self) -> f64 {
        let errors = |(value, std): (f64, f64)| if value == 0.0 { 0.0 } else { value.abs() / std };
        self.values.map(errors).into_iter().fold(0.0, f64::max)
    }

    fn drifts(&self) -> bool {
        let (slope, std) = self.values[1];
        slope.abs() >= OFFSET_CLAIM * std
    }
}
