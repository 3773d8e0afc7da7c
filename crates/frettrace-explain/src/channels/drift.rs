//! Offsets that drift over a record, as a charge amplifier's or a warming sensor's do: a ramp or a slow bend in one channel.
//!
//! The drift of every channel is fitted beside the lines of the motion as `Σ c_k P_k`, `k = 1 … 3`, Legendre polynomials over the
//! record, whose mean square is `Σ c_k²/(2k + 1)`.

use super::bare::{Bare, bare};
use super::{ChannelFault, Channels, HEARD, HEARD_IN_A_RUN};
use crate::RunSamples;

/// Finds drifts and takes them out; their means are left to whoever looks for offsets. What most channels have, two of
/// them alike, or a few runs alone, is a motion that has not settled.
pub(super) fn find(
    runs: &[RunSamples<'_>],
    noise: Option<&[f64]>,
    channels: &mut Channels,
) -> Vec<ChannelFault> {
    let Some(bare) = bare(runs, noise, channels) else { return Vec::new() };
    let sensors = bare.first().map_or(0, |b| b.drift.len());
    let mut found: Vec<ChannelFault> = Vec::new();
    for sensor in 0..sensors {
        let (mut gain, mut loudness, mut ramp, mut hearing) = (0.0, 0.0, 0.0, 0);
        for one in &bare {
            let square = power(&one.drift[sensor]);
            let of_run = square * one.run.force.len() as f64 / one.variance[sensor];
            hearing += usize::from(of_run > HEARD_IN_A_RUN);
            gain += of_run;
            loudness += square / one.variance[sensor];
            ramp += 2.0 * one.drift[sensor].first().copied().unwrap_or_default();
        }
        let count = bare.len() as f64;
        let loud = gain > HEARD_IN_A_RUN * count && loudness > HEARD * HEARD * count;
        if loud && 2 * hearing > bare.len() {
            let mean = ramp / count;
            let parameter = ("drift_over_record".into(), "m/s^2".into(), mean, mean.abs() * gain.powf(-0.5));
            found.push(ChannelFault {
                id: "measurement.offset",
                sensor,
                parameters: vec![parameter],
                evidence: gain,
            });
        }
    }
    if 2 * found.len() > sensors {
        return Vec::new();
    }
    found.retain(|fault| {
        !(0..sensors).any(|other| other != fault.sensor && alike(&bare, [fault.sensor, other]))
    });
    for fault in &found {
        for (one, signals) in bare.iter().zip(&mut channels.signal) {
            let drift = one.projector.drift(&one.drift[fault.sensor]);
            signals[fault.sensor].iter_mut().zip(drift).for_each(|(value, drift)| *value -= drift);
        }
    }
    found
}

/// Share of two channels' drifts that is common to them from which it is a motion that both see.
const COMMON: f64 = 0.5;

/// Whether another channel, in which a drift is sure too, drifts as one channel does, run by run.
fn alike(bare: &[Bare<'_>], [one, other]: [usize; 2]) -> bool {
    let product = |a: usize, b: usize| -> f64 {
        let of_run = |run: &Bare<'_>| -> f64 {
            let pairs = run.drift[a].iter().zip(&run.drift[b]).zip(1..);
            pairs.map(|((a, b), k)| a * b / f64::from(2 * k + 1)).sum()
        };
        bare.iter().map(of_run).sum()
    };
    let square = product(other, other);
    let sure = bare.iter().map(|b| b.run.force.len() as f64 / b.variance[other]).sum::<f64>() * square
        > HEARD_IN_A_RUN * (bare.len() as f64).powi(2);
    sure && product(one, other).powi(2) > COMMON * product(one, one) * square
}

/// Mean square of a drift over the record.
fn power(coefficients: &[f64]) -> f64 {
    coefficients.iter().zip(1..).map(|(c, k)| c * c / f64::from(2 * k + 1)).sum()
}
