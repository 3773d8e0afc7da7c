//! `measurement.dropout`.
//!
//! *Adds*: samples that are missing (held or zero).
//!
//! *Shows as*: stretches of one sensor that do not move.
//!
//! *Mistaken for*: `measurement.offset`; told apart by the cable exchanged.

use super::{Effect, EffectPlace};

pub(super) struct MeasurementDropout;

impl Effect for MeasurementDropout {
    fn id(&self) -> &'static str {
        "measurement.dropout"
    }

    fn place(&self) -> EffectPlace {
        EffectPlace::Measurement
    }

    fn rivals(&self) -> &'static [&'static str] {
        &["measurement.offset"]
    }

    fn experiment(&self) -> &'static str {
        "the cable exchanged"
    }
}
