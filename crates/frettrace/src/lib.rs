//! The study: all rooms wired, and the reports.
