//! `measurement.delay`.
//!
//! *Adds*: a delay of one sensor.
//!
//! *Shows as*: one sensor late: its residual grows with the order of the line.
//!
//! *Mistaken for*: `measurement.gain`; told apart by a tap with a hammer seen by all channels.

use super::{Effect, EffectPlace, StructureForm};
use crate::{Case, Scales, signed};
use frettrace_forward::accelerations::{Quantity, Setting};

pub(super) struct MeasurementDelay;

impl Effect for MeasurementDelay {
    fn id(&self) -> &'static str {
        "measurement.delay"
    }

    fn place(&self) -> EffectPlace {
        EffectPlace::Measurement
    }

    fn rivals(&self) -> &'static [&'static str] {
        &["measurement.gain"]
    }

    fn experiment(&self) -> &'static str {
        "a tap with a hammer seen by all channels"
    }

    fn structure_forms(&self, _case: &Case, setting: &Setting, scales: &Scales) -> Vec<StructureForm> {
        (0..setting.sensors.len())
            .map(|sensor| {
                let unknown = signed(
                    Quantity::Delay(sensor),
                    ("delay", "s"),
                    1e-4 * scales.period,
                    (-0.05 * scales.period, 0.05 * scales.period),
                );
                StructureForm { setting: setting.clone(), unknowns: vec![unknown], sensor: Some(sensor) }
            })
            .collect()
    }
}
