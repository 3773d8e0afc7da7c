//! `measurement.position`.
//!
//! *Adds*: a sensor that sits elsewhere than declared.
//!
//! *Shows as*: one sensor off with the slope of each deflection shape.
//!
//! *Mistaken for*: `measurement.gain`; told apart by a ruler.

use super::{Effect, EffectPlace, StructureForm};
use crate::{Case, Scales, signed};
use frettrace_forward::accelerations::{Quantity, Setting};

pub(super) struct MeasurementPosition;

impl Effect for MeasurementPosition {
    fn id(&self) -> &'static str {
        "measurement.position"
    }

    fn place(&self) -> EffectPlace {
        EffectPlace::Measurement
    }

    fn rivals(&self) -> &'static [&'static str] {
        &["measurement.gain"]
    }

    fn experiment(&self) -> &'static str {
        "a ruler"
    }

    fn is_exact(&self) -> bool {
        true
    }

    fn structure_forms(&self, _case: &Case, setting: &Setting, scales: &Scales) -> Vec<StructureForm> {
        (0..setting.sensors.len())
            .map(|sensor| {
                let unknown = signed(
                    Quantity::Shift(sensor),
                    ("shift", "m"),
                    1e-3 * scales.length,
                    (-0.2 * scales.length, 0.2 * scales.length),
                );
                StructureForm { setting: setting.clone(), unknowns: vec![unknown], sensor: Some(sensor) }
            })
            .collect()
    }
}
