//! The study: all rooms wired, and the reports.
//!
//! Functions here map types between the rooms and contain no formula; they never print.
//!
//! | module | holds |
//! |---|---|
//! | [`results`] | what `identify` and `explain` find, exactly as their JSON files |
//! | [`report`] | the findings in words, figures and one HTML page |
//! | [`store`] | results written beside their place, then renamed |

mod error;
mod progress;
pub mod report;
pub mod results;
pub mod store;

pub use error::StudyError;
pub use progress::Progress;
