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
/// … and that of another channel above which the rig moves as it does elsewhere.
const MOVING: f64 = 0.5;
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
            let others: Vec<&[f64]> = (0..sensors)
                .filter(|other| *other != sensor)
                .map(|other| samples.acceleration[other].as_slice())
                .collect();
            let mask = gaps(signal, &others, period(samples));
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
fn gaps(signal: &[f64], others: &[&[f64]], period: usize) -> Vec<bool> {
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
    quiet_periods(signal, others, period, &mut lost);
    let core = lost.clone();
    for k in (0..n).filter(|&k| core[k]) {
        lost[k.saturating_sub(MARGIN)..(k + MARGIN + 1).min(n)].fill(true);
    }
    lost
}

/// Marks whole periods in which the signal does not move as it does elsewhere, while most other channels do: a rig that beats or
/// dies away is quiet in all of them.
fn quiet_periods(signal: &[f64], others: &[&[f64]], period: usize, lost: &mut [bool]) {
    let n = signal.len();
    if period < FEWEST || n < 4 * period {
        return;
    }
    let starts: Vec<usize> = (0..=n - period).step_by((period / 8).max(1)).collect();
    let share = Share::new(signal, &starts, period);
    let quiet: Vec<usize> = starts.iter().copied().filter(|&start| share.at(start) < GONE).collect();
    if quiet.is_empty() {
        return;
    }
    let beside: Vec<Share<'_>> = others.iter().map(|other| Share::new(other, &starts, period)).collect();
    for start in quiet {
        let moving = beside.iter().filter(|other| other.at(start) > MOVING).count();
        if 2 * moving >= beside.len() {
            lost[start..start + period].fill(true);
        }
    }
}

/// Deviation of a channel within a period, over the usual one.
struct Share<'a> {
    signal: &'a [f64],
    period: usize,
    usual: f64,
}

impl<'a> Share<'a> {
    fn new(signal: &'a [f64], starts: &[usize], period: usize) -> Self {
        let mut sorted: Vec<f64> =
            starts.iter().map(|&start| deviation(&signal[start..start + period])).collect();
        sorted.sort_by(f64::total_cmp);
        Self { signal, period, usual: sorted[sorted.len() / 2] }
    }

    fn at(&self, start: usize) -> f64 {
        deviation(&self.signal[start..start + self.period]) / self.usual
    }
}

/// Root mean square about the mean.
fn deviation(window: &[f64]) -> f64 {
    let mean = window.iter().sum::<f64>() / window.len() as f64;
    (window.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / window.len() as f64).sqrt()
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

#[cfg(test)]
mod tests {
    use super::gaps;

    /// Forty periods of fifty samples; a channel that reads noise of a hundredth in two of them has lost them, unless all others
    /// are as quiet then: a rig that beats.
    #[test]
    fn a_quiet_rig_is_no_dropout() {
        let tone = |quiet: f64, phase: f64| -> Vec<f64> {
            (0..2000)
                .map(|k| {
                    let size = if (1000..1100).contains(&k) { quiet } else { 1.0 };
                    size * (std::f64::consts::TAU * k as f64 / 50.0 + phase).sin()
                })
                .collect()
        };
        let [fallen, going, other] = [tone(0.01, 0.0), tone(1.0, 0.3), tone(0.02, 0.6)];
        let alone = gaps(&fallen, &[&going, &going, &other], 50);
        assert!(alone[1000..1100].iter().all(|lost| *lost));
        assert!(alone.iter().filter(|lost| **lost).count() <= 100 + 2 * super::MARGIN);
        assert!(gaps(&fallen, &[&other, &other, &going], 50).iter().all(|lost| !lost));
    }
}
