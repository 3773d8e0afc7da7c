//! Flat tops: samples that pile up at the largest or smallest value of a channel.

use super::{ChannelFault, Channels, Clipped, period};
use crate::RunSamples;

/// Samples at an extreme value beside those just inside it: a smooth maximum has 2.4 times as many in the outer half, one
/// of fourth order 5.3 times.
const PILE: f64 = 10.0;
/// Fewest samples of a flat top.
const FEWEST: usize = 8;
/// Consecutive samples that a flat top has: where the sampling rate is a multiple of the frequency, one or two samples of
/// every period lie alone at the top of any signal.
const CONSECUTIVE: usize = 3;
/// Share of the samples of a flat top that lie in such runs and, of a normal distribution's 98.8 %, within 2.5 standard
/// deviations of its middle.
const LEVEL: f64 = 0.9;
/// Peak-to-peak of a signal over its noise below which flat tops cannot be told from noise.
const LOUD: f64 = 60.0;

/// Finds clipped channels; what they read in the runs where they clip is left out of the lines.
pub(super) fn find(
    runs: &[RunSamples<'_>],
    noise: Option<&[f64]>,
    channels: &mut Channels,
) -> Vec<ChannelFault> {
    let sensors = runs.first().map_or(0, |r| r.acceleration.len());
    let mut faults = Vec::new();
    for sensor in 0..sensors {
        let std = noise.map_or(0.0, |n| n[sensor]);
        let all = runs.iter().flat_map(|run| &run.acceleration[sensor]);
        let reach = all.fold([0.0_f64; 2], |[low, high], x| [low.min(*x), high.max(*x)]);
        let mut limits: Option<[f64; 2]> = None;
        let mut cut = 0;
        for (run, samples) in runs.iter().enumerate() {
            let raw = &samples.acceleration[sensor];
            let Some((found, flat)) = flat_tops(raw, std, (reach, period(samples))) else { continue };
            cut += flat;
            let widest = limits.get_or_insert(found);
            *widest = [widest[0].min(found[0]), widest[1].max(found[1])];
            channels.clipped[run][sensor] =
                Some(Clipped::Hard { limits: found, raw: raw.clone(), bend: None });
        }
        channels.blank(sensor);
        let Some([low, high]) = limits else { continue };
        let limit = if high.is_finite() { high } else { -low };
        faults.push(ChannelFault {
            id: "measurement.clipping",
            sensor,
            parameters: vec![("limit".into(), "m/s^2".into(), limit, std.max(1e-6 * limit.abs()))],
            evidence: 2.0 * cut as f64,
        });
    }
    faults
}

/// Values at which a channel saturates, infinite where it does not, and the samples there; `reach` is the least and the largest value of
/// the channel in any run, `period` the samples of a period of the excitation.
fn flat_tops(
    signal: &[f64],
    std: f64,
    ([low, high], period): ([f64; 2], usize),
) -> Option<([f64; 2], usize)> {
    let negative: Vec<f64> = signal.iter().map(|x| -x).collect();
    let top = flat_top(signal, std, (high, period));
    let bottom = flat_top(&negative, std, (-low, period));
    if top.is_none() && bottom.is_none() {
        return None;
    }
    let flat = top.map_or(0, |t| t.1) + bottom.map_or(0, |b| b.1);
    Some(([bottom.map_or(f64::NEG_INFINITY, |b| -b.0), top.map_or(f64::INFINITY, |t| t.0)], flat))
}

/// The value of a flat top and its samples; `reach` is the largest value of the channel in any run. What stays there for a whole period
/// is held there: a vibration comes down from a limit.
fn flat_top(signal: &[f64], std: f64, (reach, period): (f64, usize)) -> Option<(f64, usize)> {
    let mut sorted = signal.to_vec();
    sorted.sort_by(|a, b| b.total_cmp(a));
    let (high, low) = (*sorted.first()?, *sorted.last()?);
    let same = sorted.iter().take_while(|x| **x >= high).count();
    if same == signal.len() {
        return None;
    }
    let next = sorted[same];
    let beside = sorted[same..].iter().take_while(|x| **x >= next).count();
    if same >= FEWEST && same as f64 > PILE * beside as f64 && high - low > 0.0 {
        let longest =
            signal.chunk_by(|a, b| a == b).filter(|stretch| stretch[0] >= high).map(<[f64]>::len).max();
        return (longest < Some(period.max(FEWEST + 1))).then_some((high, same));
    }
    // Noise that was added after the saturation rounds the pile. What another run exceeds is no limit.
    if std <= 0.0 || high - low < LOUD * std || reach > high + 6.0 * std {
        return None;
    }
    let outer = sorted.iter().take_while(|x| **x > high - 6.0 * std).count();
    let inner = sorted[outer..].iter().take_while(|x| **x > high - 12.0 * std).count();
    let piled = outer >= 4 * FEWEST && outer as f64 > PILE * inner.max(1) as f64;
    let middle = sorted[outer / 2];
    (piled && is_level(signal, high - 6.0 * std, [middle, std])).then_some((middle, outer))
}

/// Whether the samples above `threshold` come several in a row, scatter about their `middle` no more than noise of deviation `std` does,
/// and lie as high at their ends as between them. Of five and more in a row the outer two may lie on the slopes and are not asked; of
/// fewer, a slope of 25 deviations a sample leaves `6²/(2·25)` = 0.7 of them, and a parabola whose samples lie within five about two.
fn is_level(signal: &[f64], threshold: f64, [middle, std]: [f64; 2]) -> bool {
    let above = |x: &f64| *x > threshold;
    let runs = signal.chunk_by(|a, b| above(a) == above(b)).filter(|run| above(&run[0]));
    let (mut all, mut together, mut near) = (0, 0, 0);
    let (mut sag, mut tops) = (0.0, 0);
    for run in runs {
        all += run.len();
        near += run.iter().filter(|x| (**x - middle).abs() < 2.5 * std).count();
        if run.len() < CONSECUTIVE {
            continue;
        }
        together += run.len();
        let inner = if run.len() >= CONSECUTIVE + 2 { &run[1..run.len() - 1] } else { run };
        let last = inner.len() - 1;
        sag += inner[1..last].iter().sum::<f64>() / (last - 1) as f64 - 0.5 * (inner[0] + inner[last]);
        tops += 1;
    }
    let least = LEVEL * all as f64;
    together as f64 >= least && near as f64 >= least && sag <= f64::from(tops) * std
}

#[cfg(test)]
mod tests {
    use super::flat_tops;
    use rand::{RngExt, SeedableRng};
    use rand_distr::StandardNormal;
    use rand_pcg::Pcg64;
    use std::f64::consts::TAU;

    fn noisy(clean: impl Fn(f64) -> f64) -> Vec<f64> {
        let mut random = Pcg64::seed_from_u64(5);
        (0..4096).map(|n| clean(f64::from(n)) + random.sample::<f64, _>(StandardNormal)).collect()
    }

    /// A sampling rate that is a multiple of the frequency puts the same few phases into every period: 4 of 8 samples lie
    /// far from the top, one at it; of 25, three lie within 4.5 noises of it, the next 18 noises below.
    #[test]
    fn few_phases_are_no_flat_top() {
        for (samples, amplitude) in [(8.0, 100.0), (25.0, 143.0), (12.0, 1000.0)] {
            let signal = noisy(|n| amplitude * (TAU * n / samples).cos());
            assert!(
                flat_tops(&signal, 1.0, ([0.0; 2], samples as usize)).is_none(),
                "{samples} samples a period"
            );
        }
    }

    /// Cut at four fifths of the amplitude before the noise: 2·acos(0.8) = 74 degrees are flat.
    #[test]
    fn a_cut_below_the_noise_is_found() {
        for samples in [25.0, 38.31] {
            let signal = noisy(|n| (300.0 * (TAU * n / samples).cos()).min(240.0));
            // Another run reads 260: that is no limit.
            assert!(flat_tops(&signal, 1.0, ([-300.0, 260.0], 38)).is_none());
            let (limits, _) = flat_tops(&signal, 1.0, ([-300.0, 244.0], 38)).unwrap();
            // The middle of some 800 samples is known to 1.25/√800 = 0.04 noises; the slopes add a little.
            assert!((limits[1] - 240.0).abs() < 0.3, "{limits:?}");
            assert!(limits[0] == f64::NEG_INFINITY);
        }
    }

    /// Tops `1.5 d² + 0.6 d⁴` deep at `d` samples, in the same phase of every period: two noises at the neighbours of the top and
    /// fifteen beyond them, three in a row in every pile, and no limit.
    #[test]
    fn a_round_top_that_meets_the_samples_alike_is_no_flat_top() {
        let depth = |d: f64| (1.5 * d.powi(2) + 0.6 * d.powi(4)).min(120.0 + 12.0 * d.abs());
        let peak = |n: f64| 400.0 - depth(n.rem_euclid(100.0) - 50.0);
        let signal = noisy(peak);
        assert!(flat_tops(&signal, 1.0, ([-400.0, 404.0], 100)).is_none());
        let cut = noisy(|n| peak(n).min(330.0));
        let (limits, _) = flat_tops(&cut, 1.0, ([-400.0, 334.0], 100)).unwrap();
        assert!((limits[1] - 330.0).abs() < 0.3, "{limits:?}");
    }

    /// A sine of 40 samples a period that is held for 45 of them from where it is largest has lost them; one that is cut at a twentieth of
    /// its amplitude, for nearly half of each period, is clipped.
    #[test]
    fn what_stays_for_a_period_is_no_flat_top() {
        let sine = |n: usize| (TAU * (n as f64 + 0.5) / 40.0).sin();
        let mut held: Vec<f64> = (0..4000).map(sine).collect();
        held.iter_mut().enumerate().for_each(|(n, x)| *x += 1e-6 * (0.3 * n as f64).sin());
        let largest = (0..3900).max_by(|&a, &b| held[a].total_cmp(&held[b])).unwrap();
        let value = held[largest];
        held[largest..largest + 45].fill(value);
        assert!(flat_tops(&held, 0.0, ([-1.1, value], 40)).is_none());
        let cut: Vec<f64> = (0..4000).map(|n| sine(n).min(0.05)).collect();
        assert!(flat_tops(&cut, 0.0, ([-1.0, 0.05], 40)).is_some());
    }
}
