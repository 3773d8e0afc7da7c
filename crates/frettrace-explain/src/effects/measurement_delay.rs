//! `measurement.delay`.
//!
//! *Adds*: a delay of one sensor, or the low pass of first order `1/(1 + iωτ)` of a slow one.
//!
//! *Shows as*: one sensor late: its residual grows with the order of the line; behind a low pass it is weaker there too.
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
            [pure, low_pass].map(|unknown| StructureForm {
                setting: setting.clone(),
                unknowns: vec![unknown],
                sensor: Some(sensor),
            })
        };
        (0..setting.sensors.len()).flat_map(forms).collect()
    }
}
