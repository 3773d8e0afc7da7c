//! The only place that knows the HDF5 library.

mod attributes;
mod reader;
mod writer;

pub use reader::{Array, Attribute, DataFile};
pub(crate) use writer::{FileWriter, NewArray, Written};
