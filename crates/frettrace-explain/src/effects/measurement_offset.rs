//! `measurement.offset`.
//!
//! *Adds*: an offset of one sensor, constant or drifting over a record or from run to run.
//!
//! *Shows as*: one sensor off on line 0, or a ramp of its mean.
//!
//! *Mistaken for*: `measurement.dropout`; told apart by the sensor at rest.

use super::{Effect, EffectPlace, FREE, StructureForm};
use crate::{Case, Scales, signed};
use frettrace_forward::accelerations::{Quantity, Setting};

pub(super) struct MeasurementOffset;

impl Effect for MeasurementOffset {
    fn id(&self) -> &'static str {
        "measurement.offset"
    }

    fn place(&self) -> EffectPlace {
        EffectPlace::Measurement
    }

    fn rivals(&self) -> &'static [&'static str] {
        &["measurement.dropout"]
    }

    fn experiment(&self) -> &'static str {
        "the sensor at rest"
    }

    fn structure_forms(&self, _case: &Case, setting: &Setting, _scales: &Scales) -> Vec<StructureForm> {
        (0..setting.sensors.len())
            .map(|sensor| {
                let unknown = signed(Quantity::Offset(sensor), ("offset", "m/s^2"), 0.01, FREE);
                StructureForm { setting: setting.clone(), unknowns: vec![unknown], sensor: Some(sensor) }
            })
            .collect()
    }
}
