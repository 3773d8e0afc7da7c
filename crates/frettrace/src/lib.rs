//! The study: all rooms wired, and the reports.
//!
//! Functions here map types between the rooms and contain no formula; they never print.
//!
//! | module | holds |
//! |---|---|
//! | [`results`] | what `identify` and `explain` find, exactly as their JSON files |
//! | [`store`] | results written beside their place, then renamed |

mod error;
mod progress;
pub mod results;
pub mod store;

pub use error::StudyError;
pub use progress::Progress;
