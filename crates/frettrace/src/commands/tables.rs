//! Results as tables for a terminal.

use frettrace::{
    report::words::{number, percent},
    results::{BeforeAfter, Estimate},
};
use std::collections::BTreeMap;

/// Parameters with their intervals.
pub fn estimates(parameters: &BTreeMap<String, Estimate>) -> String {
    let row = |(name, estimate): (&String, &Estimate)| {
        let [low, high] = estimate.interval95.map(number);
        let remark = if estimate.identifiable { "" } else { "  not determined by these data" };
        format!("  {name:12} {:>11}  [{low} … {high}] {}{remark}\n", number(estimate.value), estimate.unit)
    };
    parameters.iter().map(row).collect()
}

/// Error before and after.
pub fn before_after(name: &str, error: &BeforeAfter) -> String {
    format!(
        "error on {name:14} before {:>8}   after {:>8}   noise {:>8}\n",
        percent(error.before),
        percent(error.after),
        percent(error.noise_floor)
    )
}

/// What a reader must know.
pub fn notes(notes: &[String]) -> String {
    notes.iter().map(|note| format!("note: {note}\n")).collect()
}
