//! Flat tops: samples that pile up at the largest or smallest value of a channel.

use super::{ChannelFault, Channels, Clipped};
use crate::RunSamples;

/// Samples at an extreme value beside those just inside it: a smooth maximum has 2.4 times as many in the outer half, one
/// of fourth order 5.3 times.
const PILE: f64 = 10.0;
/// Fewest samples of a flat top.
const FEWEST: usize = 8;
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
        let mut limits: Option<[f64; 2]> = None;
        let mut cut = 0;
        for (run, samples) in runs.iter().enumerate() {
            let raw = &samples.acceleration[sensor];
            let Some((found, flat)) = flat_tops(raw, std) else { continue };
            cut += flat;
            let widest = limits.get_or_insert(found);
            *widest = [widest[0].min(found[0]), widest[1].max(found[1])];
            channels.clipped[run][sensor] = Some(Clipped { limits: found, raw: raw.clone() });
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

/// Values at which a channel saturates, infinite where it does not, and the samples there.
fn flat_tops(signal: &[f64], std: f64) -> Option<([f64; 2], usize)> {
    let negative: Vec<f64> = signal.iter().map(|x| -x).collect();
    let top = flat_top(signal, std);
    let bottom = flat_top(&negative, std);
    if top.is_none() && bottom.is_none() {
        return None;
    }
    let flat = top.map_or(0, |t| t.1) + bottom.map_or(0, |b| b.1);
    Some(([bottom.map_or(f64::NEG_INFINITY, |b| -b.0), top.map_or(f64::INFINITY, |t| t.0)], flat))
}

/// The value of a flat top and its samples.
fn flat_top(signal: &[f64], std: f64) -> Option<(f64, usize)> {
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
        return Some((high, same));
    }
    // Noise that was added after the saturation rounds the pile.
    if std <= 0.0 || high - low < LOUD * std {
        return None;
    }
    let outer = sorted.iter().take_while(|x| **x > high - 6.0 * std).count();
    let inner = sorted[outer..].iter().take_while(|x| **x > high - 12.0 * std).count();
    let piled = outer >= 4 * FEWEST && outer as f64 > PILE * inner.max(1) as f64;
    piled.then(|| (sorted[outer / 2], outer))
}
