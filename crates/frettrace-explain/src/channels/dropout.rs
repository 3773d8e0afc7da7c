//! Stretches in which a channel reads a constant or nothing but noise, filled with the periodic signal around them.

use super::{ChannelFault, Channels, period};
use crate::RunSamples;
use frettrace_fourier::{Lines, Projector};

/// Fewest equal samples in a row that are a dropout in a channel whose neighbours are often equal, …
const FEWEST: usize = 8;
/// … and share of a period of the excitation that they must last.
const SHARE: f64 = 0.1;
/// Share of neighbours that are equal by chance below which a channel is read finely: then few in a row are a dropout, …
const RARE: f64 = 1e-3;
/// … so many that chance brings them to the whole of its samples once in a thousand times.
const BY_CHANCE: f64 = 1e-3;
/// Deviation within a period, over the usual one, below which the signal is gone.
const GONE: f64 = 0.1;
/// … and that of another channel above which the rig moves as it does elsewhere.
const MOVING: f64 = 0.5;
/// Share of the windows apart from what is quiet that may hold less than that in a channel that does not come and go by itself.
const WANDERS: f64 = 0.05;
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
        let holds = holds(runs.iter().map(|run| run.acceleration[sensor].as_slice()));
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
            let mask = gaps(signal, &others, (period(samples), holds));
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

/// Stretches of equal samples, first and one beyond the last.
fn stretches(signal: &[f64]) -> impl Iterator<Item = std::ops::Range<usize>> {
    let mut from = 0;
    signal.chunk_by(|a, b| a == b).map(move |equal| {
        let stretch = from..from + equal.len();
        from = stretch.end;
        stretch
    })
}

/// Whether equal samples, a pair and more, are a dropout of a channel: one that is read finely and has more in a row than chance brings. By
/// chance `n p^(m−1)` of `n` samples begin `m` equal ones, and the pairs that stand alone tell `p`.
fn holds<'a>(signals: impl Iterator<Item = &'a [f64]>) -> bool {
    let (mut samples, mut pairs, mut longest) = (0, 0, 0);
    for signal in signals {
        samples += signal.len();
        for stretch in stretches(signal) {
            pairs += usize::from(stretch.len() == 2);
            if stretch.len() > longest && !is_extreme(signal, signal[stretch.start]) {
                longest = stretch.len();
            }
        }
    }
    let chance = (pairs + 1) as f64 / samples.max(1) as f64;
    let fewest = 1.0 + ((BY_CHANCE / samples.max(1) as f64).ln() / chance.ln()).ceil();
    chance < RARE && longest as f64 >= fewest
}

/// Whether a value is the largest or the smallest of a signal: what stays there is clipped.
fn is_extreme(signal: &[f64], value: f64) -> bool {
    signal.iter().all(|x| *x <= value) || signal.iter().all(|x| *x >= value)
}

/// Samples that are lost; of a channel that `holds` its value, any equal ones.
fn gaps(signal: &[f64], others: &[&[f64]], (period, holds): (usize, bool)) -> Vec<bool> {
    let n = signal.len();
    let mut lost = vec![false; n];
    let fewest = FEWEST.max((SHARE * period as f64) as usize);
    for stretch in stretches(signal) {
        let few = holds && stretch.len() > 1 && !is_extreme(signal, signal[stretch.start]);
        if few || stretch.len() >= fewest {
            lost[stretch].fill(true);
        }
    }
    quiet_periods(signal, others, period, &mut lost);
    quiet_halves(signal, others, period, &mut lost);
    let core = lost.clone();
    for k in (0..n).filter(|&k| core[k]) {
        lost[k.saturating_sub(MARGIN)..(k + MARGIN + 1).min(n)].fill(true);
    }
    lost
}

/// Marks whole periods in which the signal does not move as it does elsewhere, while most other channels do: a rig that beats or
/// dies away is quiet in all of them. What is lost is lost and found again from one period to the next. A channel that beats alone,
/// with a hum or near a node of one of two motions, passes through its quiet: where its size grows as `|t|` and a whole
/// period `T` holds the share [`GONE`] of the usual, `T` and an eighth later it has risen by `GONE √12 · 9/8` to at most 0.40. One that comes and
/// goes as it will, in a motion without a period, is below [`MOVING`] in many more windows ([`WANDERS`]) than what is lost touches.
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
    let is_whole = |start: usize| {
        let touched = |own: &usize| own.abs_diff(start) <= period;
        !quiet.iter().any(touched) && !lost[start..start + period].contains(&true)
    };
    let elsewhere: Vec<usize> = starts.iter().copied().filter(|&start| is_whole(start)).collect();
    let low = elsewhere.iter().filter(|&&start| share.at(start) < MOVING).count();
    if low as f64 > WANDERS * elsewhere.len() as f64 {
        return;
    }
    let beside: Vec<Share<'_>> = others.iter().map(|other| Share::new(other, &starts, period)).collect();
    let apart = period / 8;
    for stretch in quiet.chunk_by(|a, b| b - a <= period) {
        let (first, end) = (stretch[0], stretch[stretch.len() - 1] + period);
        let before = first.checked_sub(apart + period);
        let after = Some(end + apart).filter(|from| from + period <= n);
        if !before.into_iter().chain(after).any(|start| share.at(start) > MOVING) {
            continue;
        }
        for &start in stretch {
            let moving = beside.iter().filter(|other| other.at(start) > MOVING).count();
            if 2 * moving >= beside.len() {
                lost[start..start + period].fill(true);
            }
        }
    }
}

/// Marks halves of a period in which the signal is gone that is there at the same phase of every other period, while most other channels move
/// there as they do then. Where a channel that beats alone passes through its quiet and its size grows as `|t|`, the half `T/2` about it
/// holds `1/(4√3)` = 0.14 of what those one period before and after hold, more than [`GONE`].
fn quiet_halves(signal: &[f64], others: &[&[f64]], period: usize, lost: &mut [bool]) {
    let (n, half) = (signal.len(), period / 2);
    if half < FEWEST || n < 4 * period {
        return;
    }
    let own = Halves::new(signal, half);
    let beside: Vec<Halves> = others.iter().map(|other| Halves::new(other, half)).collect();
    for phase in 0..period {
        let starts = || (phase..=n - half).step_by(period);
        // Only the quietest window of a phase can be far quieter than all others.
        let Some(quietest) = starts().min_by(|a, b| own.at(*a).total_cmp(&own.at(*b))) else { continue };
        let least = |of: &Halves| {
            starts()
                .filter(|start| *start != quietest)
                .map(|start| of.at(start))
                .fold(f64::INFINITY, f64::min)
        };
        if own.at(quietest) < GONE * least(&own) {
            let moving = beside.iter().filter(|other| other.at(quietest) > MOVING * least(other)).count();
            if 2 * moving >= beside.len() {
                lost[quietest..quietest + half].fill(true);
            }
        }
    }
}

/// Deviations of a channel in windows of one length, from the sums of its samples and their squares.
struct Halves {
    sums: Vec<[f64; 2]>,
    length: usize,
}

impl Halves {
    fn new(signal: &[f64], length: usize) -> Self {
        let mut sums = vec![[0.0; 2]];
        sums.extend(signal.iter().scan([0.0; 2], |sum, x| {
            *sum = [sum[0] + x, sum[1] + x * x];
            Some(*sum)
        }));
        Self { sums, length }
    }

    fn at(&self, start: usize) -> f64 {
        let [first, end] = [self.sums[start], self.sums[start + self.length]];
        let [mean, square] = [0, 1].map(|k| (end[k] - first[k]) / self.length as f64);
        (square - mean * mean).max(0.0).sqrt()
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
    use super::{gaps, holds};

    /// Four thousand samples of a sine, no two neighbours of which are equal: of chance `2.5·10⁻⁴` three in a row are a dropout, since
    /// `4000 · (2.5·10⁻⁴)² < 10⁻³`, and with them a pair is one. Read in steps of a hundredth, its turns hold a value for many samples and
    /// are none; nor is what stays at its largest value.
    #[test]
    fn a_few_held_samples_are_a_dropout_of_a_finely_read_channel() {
        let sine: Vec<f64> = (0..4000).map(|k| (0.0371 * k as f64 + 0.2).sin()).collect();
        assert!(!holds([sine.as_slice()].into_iter()));
        let mut dropping = sine.clone();
        dropping[701] = dropping[700];
        assert!(!holds([dropping.as_slice()].into_iter()));
        dropping.copy_within(1200..1201, 1201);
        dropping.copy_within(1200..1202, 1202);
        assert!(holds([dropping.as_slice()].into_iter()));
        let lost = gaps(&dropping, &[], (169, true));
        let expected: Vec<usize> = (698..=703).chain(1198..=1205).collect();
        assert_eq!((0..4000).filter(|&k| lost[k]).collect::<Vec<_>>(), expected);
        let coarse: Vec<f64> = sine.iter().map(|x| (100.0 * x).round() / 100.0).collect();
        assert!(!holds([coarse.as_slice()].into_iter()));
        let clipped: Vec<f64> = sine.iter().map(|x| x.min(0.9)).collect();
        assert!(!holds([clipped.as_slice()].into_iter()));
    }

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
        let alone = gaps(&fallen, &[&going, &going, &other], (50, false));
        assert!(alone[1000..1100].iter().all(|lost| *lost));
        assert!(alone.iter().filter(|lost| **lost).count() <= 100 + 2 * super::MARGIN);
        assert!(gaps(&fallen, &[&other, &other, &going], (50, false)).iter().all(|lost| !lost));
    }

    /// Forty periods of fifty samples, the size of each by the map `x ← 4x(1 − x)`, whose values are below half of their median in a third of all periods:
    /// several are below a tenth of it, and nothing is lost.
    #[test]
    fn a_channel_that_comes_and_goes_has_lost_nothing() {
        let wandering = |seed: f64| -> Vec<f64> {
            let sizes = std::iter::successors(Some(seed), |size| Some(4.0 * size * (1.0 - size)));
            let wave =
                |size: f64| (0..50).map(move |k| size * (std::f64::consts::TAU * f64::from(k) / 50.0).sin());
            sizes.take(40).flat_map(wave).collect()
        };
        let others = [wandering(0.3), wandering(0.41)];
        let beside: Vec<&[f64]> = others.iter().map(Vec::as_slice).collect();
        for seed in [0.123, 0.2, 0.57] {
            assert!(gaps(&wandering(seed), &beside, (50, false)).iter().all(|lost| !lost), "{seed}");
        }
    }

    /// Forty periods of sixty samples of which the channel reads noise of a hundredth for forty: less than a period, and for twenty: less than half of
    /// one, which is not looked for.
    #[test]
    fn less_than_a_period_is_lost_where_every_other_period_has_it() {
        let tone = |gone: std::ops::Range<usize>| -> Vec<f64> {
            let size = |k: usize| if gone.contains(&k) { 0.01 } else { 1.0 };
            (0..2400).map(|k| size(k) * (std::f64::consts::TAU * k as f64 / 60.0 + 0.3).sin()).collect()
        };
        let going = tone(0..0);
        let lost = gaps(&tone(1000..1040), &[&going, &going], (60, false));
        assert!(lost[1000..1040].iter().all(|lost| *lost));
        assert!(lost.iter().filter(|lost| **lost).count() <= 44 + 2 * super::MARGIN);
        assert!(gaps(&tone(1000..1020), &[&going, &going], (60, false)).iter().all(|lost| !lost));
        let all = tone(1000..1040);
        assert!(gaps(&all, &[&all, &all], (60, false)).iter().all(|lost| !lost));
    }

    /// Forty periods of fifty samples in which two tones of one size, 1.25 periods apart over the record, beat: the channel is quiet
    /// about its 800th sample, where it holds `π/√6 · 1.25/40` = 0.04 of the usual, and has lost nothing.
    #[test]
    fn a_channel_that_beats_has_lost_nothing() {
        let tone = |frequency: f64, k: usize| (std::f64::consts::TAU * frequency * k as f64 / 50.0).sin();
        let beating: Vec<f64> = (0..2000).map(|k| tone(1.0, k) + tone(1.0 + 1.25 / 40.0, k)).collect();
        let going: Vec<f64> = (0..2000).map(|k| tone(1.0, k)).collect();
        assert!(gaps(&beating, &[&going, &going], (50, false)).iter().all(|lost| !lost));
    }
}
