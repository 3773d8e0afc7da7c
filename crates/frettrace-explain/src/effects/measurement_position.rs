//! `measurement.position`.
//!
//! *Adds*: a sensor that sits elsewhere than declared, or all of them by one distance.
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
        let form = |quantity: Quantity, sensor: Option<usize>| {
            let farthest = 0.2 * scales.length;
            let unknown = signed(quantity, ("shift", "m"), 1e-3 * scales.length, (-farthest, farthest));
            StructureForm { setting: setting.clone(), unknowns: vec![unknown], sensor }
        };
        let own = (0..setting.sensors.len()).map(|sensor| form(Quantity::Shift(sensor), Some(sensor)));
        // The rule laid at another end.
        own.chain([form(Quantity::CommonShift, None)]).collect()
    }
}
