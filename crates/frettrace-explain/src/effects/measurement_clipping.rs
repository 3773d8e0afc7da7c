//! `measurement.clipping`.
//!
//! *Adds*: a sensor that saturates, at a limit or softly.
//!
//! *Shows as*: samples of one sensor that pile up at its largest value, or fall short of what the other sensors say it should read.
//!
//! *Mistaken for*: `measurement.gain`; told apart by the same level at a lower gain.

use super::{Effect, EffectPlace};

pub(super) struct MeasurementClipping;

impl Effect for MeasurementClipping {
    fn id(&self) -> &'static str {
        "measurement.clipping"
    }

    fn place(&self) -> EffectPlace {
        EffectPlace::Measurement
    }

    fn rivals(&self) -> &'static [&'static str] {
        &["measurement.gain"]
    }

    fn experiment(&self) -> &'static str {
        "the same level at a lower gain"
    }
}
