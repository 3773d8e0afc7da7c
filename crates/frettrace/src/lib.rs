//! The study: all rooms wired, and the reports.
//!
//! Functions here map types between the rooms and contain no formula; they never print.
//!
//! | module | holds |
//! |---|---|
//! | [`case`] | a measurement file as the case of an explanation |
//! | [`explain`] | what the declared model lacks |
//! | [`hypotheses`] | amplitude-dependent modes: three hypotheses at every level |
//! | [`identify`] | the friction law behind a recording |
//! | [`inspect`] | what a file holds and how good its signals are |
//! | [`modes`] | modes of the declared beam beside the measured ones |
//! | [`reconstruct`] | contact forces and slip, by the inverse |
//! | [`results`] | what `identify` and `explain` find, exactly as their JSON files |
//! | [`report`] | the findings in words, figures and one HTML page |
//! | [`response`] | frequency responses of a rig over levels, with stability and backbone |
//! | [`rig`] | RIG.toml, what a simulation is made from |
//! | [`simulate`] | a rig to a measurement with its truth |
//! | [`store`] | results written beside their place, then renamed |

pub mod case;
mod error;
mod exhibits;
pub mod explain;
pub mod hypotheses;
pub mod identify;
pub mod inspect;
pub mod modes;
mod progress;
pub mod reconstruct;
pub mod report;
pub mod response;
pub mod results;
pub mod rig;
pub mod simulate;
pub mod store;

pub use error::StudyError;
pub use progress::Progress;
