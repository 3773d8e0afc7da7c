//! `measurement.gain`.
//!
//! *Adds*: a gain of one sensor.
//!
//! *Shows as*: one sensor off in proportion to its signal, on every line and level.
//!
//! *Mistaken for*: `measurement.position`; told apart by the sensor exchanged with its neighbour.

use super::{Effect, EffectPlace, StructureForm};
use crate::{Case, Scales, signed};
use frettrace_forward::accelerations::{Quantity, Setting};

pub(super) struct MeasurementGain;

impl Effect for MeasurementGain {
    fn id(&self) -> &'static str {
        "measurement.gain"
    }

    fn place(&self) -> EffectPlace {
        EffectPlace::Measurement
    }

    fn rivals(&self) -> &'static [&'static str] {
        &["measurement.position"]
    }

    fn experiment(&self) -> &'static str {
        "the sensor exchanged with its neighbour"
    }

    fn is_exact(&self) -> bool {
        true
    }

    fn structure_forms(&self, _case: &Case, setting: &Setting, _scales: &Scales) -> Vec<StructureForm> {
        (0..setting.sensors.len())
            .map(|sensor| {
                let unknown = signed(Quantity::Gain(sensor), ("gain", "1"), 0.01, (0.1, 10.0));
                StructureForm { setting: setting.clone(), unknowns: vec![unknown], sensor: Some(sensor) }
            })
            .collect()
    }
}
