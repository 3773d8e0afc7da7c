//! Offsets that drift over a record, as a charge amplifier's or a warming sensor's do: a ramp or a slow bend in one channel.
//!
//! The drift of every channel is fitted beside the lines of the motion as `Σ c_k P_k`, `k = 1 … 3`, Legendre polynomials over the
//! record, whose mean square is `Σ c_k²/(2k + 1)`.

use super::bare::{Bare, bare};
use super::{ChannelFault, Channels, HEARD, HEARD_IN_A_RUN};
use crate::RunSamples;

/// Finds drifts and takes them out; their means are left to whoever looks for offsets. What most channels have, two of
/// them alike, or a few runs alone, is a motion that has not settled. Runs without a period are not asked: their motion has a part as
/// slow as any drift.
pub(super) fn find(
    runs: &[RunSamples<'_>],
    noise: Option<&[f64]>,
    channels: &mut Channels,
) -> Vec<ChannelFault> {
    let Some(bare) = bare(runs, noise, channels) else { return Vec::new() };
    let (places, bare): (Vec<usize>, Vec<Bare<'_>>) =
        bare.into_iter().enumerate().filter(|(_, one)| one.is_steady()).unzip();
    let sensors = bare.first().map_or(0, |b| b.drift.len());
    let heard: Vec<Heard> = (0..sensors).map(|sensor| Heard::of(&bare, sensor)).collect();
    let loud = |(_, heard): &(usize, &Heard)| heard.sure && heard.loud && 2 * heard.runs > bare.len();
    let mut found: Vec<ChannelFault> =
        heard.iter().enumerate().filter(loud).map(|(sensor, heard)| heard.fault(sensor)).collect();
    if 2 * found.len() > sensors {
        return Vec::new();
    }
    found.retain(|fault| {
        let alike = |other: usize| heard[other].sure && alike(&bare, [fault.sensor, other]);
        !(0..sensors).any(|other| other != fault.sensor && alike(other))
    });
    for fault in &found {
        for (one, &place) in bare.iter().zip(&places) {
            let signals = &mut channels.signal[place];
            let drift = one.projector.drift(&one.drift[fault.sensor]);
            signals[fault.sensor].iter_mut().zip(drift).for_each(|(value, drift)| *value -= drift);
        }
    }
    found
}

/// The drift of one channel in all runs.
struct Heard {
    /// χ² that it explains.
    gain: f64,
    /// Runs in which it explains enough.
    runs: usize,
    /// Whether it explains enough on the whole, and is large enough beside the noise.
    sure: bool,
    loud: bool,
    /// Its mean rise from the first sample to the last (m/s²).
    ramp: f64,
}

impl Heard {
    fn of(bare: &[Bare<'_>], sensor: usize) -> Self {
        let count = bare.len() as f64;
        let over_noise = |one: &Bare<'_>| {
            let drift = &one.drift[sensor];
            product(drift, drift) / one.variance[sensor]
        };
        let gains = || bare.iter().map(|one| over_noise(one) * one.run.force.len() as f64);
        let gain: f64 = gains().sum();
        let loudness: f64 = bare.iter().map(over_noise).sum();
        let rise = |one: &Bare<'_>| 2.0 * one.drift[sensor].first().copied().unwrap_or_default();
        Self {
            gain,
            runs: gains().filter(|gain| *gain > HEARD_IN_A_RUN).count(),
            sure: gain > HEARD_IN_A_RUN * count,
            loud: loudness > HEARD * HEARD * count,
            ramp: bare.iter().map(rise).sum::<f64>() / count,
        }
    }

    fn fault(&self, sensor: usize) -> ChannelFault {
        let std = self.ramp.abs() * self.gain.powf(-0.5);
        let parameter = ("drift_over_record".into(), "m/s^2".into(), self.ramp, std);
        ChannelFault { id: "measurement.offset", sensor, parameters: vec![parameter], evidence: self.gain }
    }
}

/// Share of two channels' drifts that is common to them from which it is a motion that both see.
const COMMON: f64 = 0.5;

/// Whether two channels drift alike, run by run.
fn alike(bare: &[Bare<'_>], [one, other]: [usize; 2]) -> bool {
    let sum = |a: usize, b: usize| bare.iter().map(|run| product(&run.drift[a], &run.drift[b])).sum::<f64>();
    sum(one, other).powi(2) > COMMON * sum(one, one) * sum(other, other)
}

/// Mean product of two drifts over the record.
fn product(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).zip(1..).map(|((a, b), k)| a * b / f64::from(2 * k + 1)).sum()
}
