//! Measurement files and contact records.

mod measurement;

pub use measurement::{
    Beam, ContactRecord, ContactRun, Exciter, MeasuredModes, Measurement, Run, SecondSupport, Sensors,
    SlipKind, SlipUnit, Source, Support,
};
