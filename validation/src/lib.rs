//! How far to trust frettrace.
//!
//! A case asks a question with a known answer and returns rows: quantity, what was expected, what was found, what
//! difference is allowed and why. `cargo run -p validation` runs all cases, writes `REPORT.md` and compares with
//! `baseline.csv`.

pub mod architecture;
pub mod baseline;
pub mod case;
pub mod cases;
pub mod practice;
pub mod report;
pub mod sweep;
