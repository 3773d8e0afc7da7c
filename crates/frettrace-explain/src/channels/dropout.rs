//! Stretches in which a channel reads a constant or nothing but noise, filled with the periodic signal around them.

use super::{ChannelFault, Channels, period};
use crate::RunSamples;
use frettrace_fourier::{Lines, Projector};

/// Fewest equal samples in a row that are a dropout.
const FEWEST: usize = 8;
/// … and share of a period of the excitation that they must last.
const SHARE: f64 = 0.1;
/// Deviation within a period, over the usual one, below which the signal is gone.
const GONE: f64 = 0.1;
/// Samples to each side of a dropout that filters may have touched.
const MARGIN: usize = 2;
/// Steps in which gap and lines around it agree: each leaves the gap's share of the record.
const STEPS: usize = 12;
/// Most lines that fill a gap.
const LINES: usize = 120;

/// Finds dropouts and fills them.
pub(super) fn find(runs: &[RunSamples<'_>], channels: &mut Channels) -> Vec<ChannelFault> {
    let sensors = runs.first().map_or(0, |r| r.acceleration.len());
    let mut faults = Vec::new();
    for sensor in 0..sensors {
        let (mut lost, mut total, mut first) = (0, 0, None);
        for (run, samples) in runs.iter().enumerate() {
            let signal = &samples.acceleration[sensor];
            total += signal.len();
            if channels.clipped[run][sensor].is_some() {
                continue;
            }
            let mask = gaps(signal, period(samples));
            let missing = mask.iter().filter(|m| **m).count();
            if missing == 0 || 2 * missing > signal.len() {
                continue;
            }
            lost += missing;
            first = first.or_else(|| mask.iter().position(|m| *m).map(|k| k as f64 / samples.sampling_rate));
            fill(samples, &mask, &mut channels.signal[run][sensor]);
        }
        if let Some(start) = first {
            faults.push(ChannelFault {
                id: "measurement.dropout",
                sensor,
                parameters: vec![
                    ("lost_share".into(), "1".into(), lost as f64 / total as f64, 1.0 / total as f64),
                    ("first_start".into(), "s".into(), start, 0.0),
                ],
                evidence: 2.0 * lost as f64,
            });
        }
    }
    faults
}

/// Samples that are lost.
fn gaps(signal: &[f64], period: usize) -> Vec<bool> {
    let n = signal.len();
    let mut lost = vec![false; n];
    let fewest = FEWEST.max((SHARE * period as f64) as usize);
    let mut from = 0;
    for k in 1..=n {
        if k < n && signal[k] == signal[from] {
            continue;
        }
        if k - from >= fewest {
            lost[from..k].fill(true);
        }
        from = k;
    }
    quiet_periods(signal, period, &mut lost);
    let core = lost.clone();
    for k in (0..n).filter(|&k| core[k]) {
        lost[k.saturating_sub(MARGIN)..(k + MARGIN + 1).min(n)].fill(true);
    }
    lost
}

/// Marks whole periods in which the signal does not move as it does elsewhere.
fn quiet_periods(signal: &[f64], period: usize, lost: &mut [bool]) {
    let n = signal.len();
    if period < FEWEST || n < 4 * period {
        return;
    }
    let step = (period / 8).max(1);
    let deviation = |from: usize| {
        let window = &signal[from..from + period];
        let mean = window.iter().sum::<f64>() / period as f64;
        (window.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / period as f64).sqrt()
    };
    let starts: Vec<usize> = (0..=n - period).step_by(step).collect();
    let all: Vec<f64> = starts.iter().map(|&s| deviation(s)).collect();
    let mut sorted = all.clone();
    sorted.sort_by(f64::total_cmp);
    let usual = sorted[sorted.len() / 2];
    for (&start, _) in starts.iter().zip(&all).filter(|(_, d)| **d < GONE * usual) {
        lost[start..start + period].fill(true);
    }
}

/// Fills the gaps with the lines of what is left, in turns.
fn fill(run: &RunSamples<'_>, mask: &[bool], signal: &mut [f64]) {
    let base = std::f64::consts::TAU * run.excitation_frequency;
    let samples = signal.len();
    let highest = (0.95 * std::f64::consts::PI * run.sampling_rate / base) as usize;
    let order = highest.min(LINES).min(samples / 8).max(1);
    let refined = frettrace_fourier::refine(
        Lines { base, order: order.min(3), samples, sampling_rate: run.sampling_rate, drift: 0 },
        &[run.force],
    );
    let base = refined.map_or(base, |r| r.base);
    let lines = Lines { base, order, samples, sampling_rate: run.sampling_rate, drift: 0 };
    let Ok(projector) = Projector::new(lines) else { return };
    for (value, _) in signal.iter_mut().zip(mask).filter(|(_, lost)| **lost) {
        *value = 0.0;
    }
    for _ in 0..STEPS {
        let Ok(found) = projector.project(signal) else { return };
        for ((value, left), _) in signal.iter_mut().zip(&found.residual).zip(mask).filter(|(_, lost)| **lost)
        {
            *value -= left;
        }
    }
}
