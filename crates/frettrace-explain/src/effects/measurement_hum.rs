//! `measurement.hum`.
//!
//! *Adds*: a mains tone of its own frequency in one or more sensors.
//!
//! *Shows as*: lines beside those of the motion, at a fixed frequency in every run.
//!
//! *Mistaken for*: `excitation.base-motion`; told apart by a recording at rest.

use super::{Effect, EffectPlace};

pub(super) struct MeasurementHum;

impl Effect for MeasurementHum {
    fn id(&self) -> &'static str {
        "measurement.hum"
    }

    fn place(&self) -> EffectPlace {
        EffectPlace::Measurement
    }

    fn rivals(&self) -> &'static [&'static str] {
        &["excitation.base-motion"]
    }

    fn experiment(&self) -> &'static str {
        "a recording at rest"
    }
}
