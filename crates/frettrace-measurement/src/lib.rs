//! Measurement files and contact records: read, checked and written; results written; laboratory formats converted.
//!
//! The two kinds of file are HDF5. [`read`] takes either, [`read_measurement`] and [`read_contact_record`]
//! one of them; every violation of the format is one line: file, place, what is wrong, what would mend it.
//! Files are written beside their target and renamed when whole.

mod convert;
mod error;
mod formats;
mod hdf5;
mod measurement;
pub mod quality;
mod read;
mod response;
mod results;
mod units;
mod write;

pub use convert::{Converted, convert, guess};
pub use error::{Error, Problem};
pub use formats::{Column, Table, read_table};
pub use hdf5::{Array, Attribute, DataFile};
pub use measurement::{
    Beam, ContactRecord, ContactRun, Exciter, MeasuredModes, Measurement, Run, SecondSupport, Sensors,
    SlipKind, SlipUnit, Source, Support,
};
pub use read::{LAWS, Recording, read, read_contact_record, read_measurement};
pub use response::{ResponseBackbone, ResponseFile, ResponseLevel, write_response};
pub use results::{
    Coefficients, Estimate, Form, HarmonicTable, ReconstructedRun, Reconstruction, write_reconstruction,
};
pub use write::{RunTruth, Truth, write_contact_record, write_measurement};
