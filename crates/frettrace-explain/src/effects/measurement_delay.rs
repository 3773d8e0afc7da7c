//! `measurement.delay`.
//!
//! *Adds*: a delay of one sensor, or the low pass of a slow one, of first order or of two such stages, `(1 + iωτ/n)⁻ⁿ`.
//!
//! *Shows as*: one sensor late: its residual grows with the order of the line; behind a low pass it is weaker there too.
//!
//! *Mistaken for*: `measurement.gain`; told apart by a tap with a hammer seen by all channels.

use super::{Effect, EffectPlace, StructureForm};
use crate::{Case, Scales, signed};
use frettrace_forward::accelerations::{Quantity, SensorSetting, Setting};

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

    fn is_exact(&self) -> bool {
        true
    }

    fn structure_forms(&self, _case: &Case, setting: &Setting, scales: &Scales) -> Vec<StructureForm> {
        let forms = |sensor| {
            let pure = signed(
                Quantity::Delay(sensor),
                ("delay", "s"),
                1e-4 * scales.period,
                (-0.05 * scales.period, 0.05 * scales.period),
            );
            let low_pass =
                signed(Quantity::Lag(sensor), ("lag", "s"), 1e-4 * scales.period, (0.0, 0.2 * scales.period));
            let one = setting.sensors[sensor];
            let two = SensorSetting { stages: 2.0, ..one };
            [(pure, one), (low_pass.clone(), one), (low_pass, two)].map(|(unknown, channel)| {
                let mut setting = setting.clone();
                setting.sensors[sensor] = channel;
                StructureForm { setting, unknowns: vec![unknown], sensor: Some(sensor) }
            })
        };
        (0..setting.sensors.len()).flat_map(forms).collect()
    }
}
