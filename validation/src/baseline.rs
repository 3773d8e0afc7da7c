//! The stored results: what was found when somebody last looked and agreed.

use crate::case::Row;
use std::collections::BTreeMap;

/// Found values by case and quantity.
pub type Baseline = BTreeMap<(String, String), f64>;

/// Change of a found value, as a share of the row's tolerance, that counts as drift: what rounding on another processor
/// does stays far below it.
const DRIFT: f64 = 0.1;

/// Reads `case,quantity,found` lines; lines that are not such are dropped.
#[must_use]
pub fn read(text: &str) -> Baseline {
    let line = |line: &str| {
        let (head, found) = line.rsplit_once(',')?;
        let (case, quantity) = head.split_once(',')?;
        Some(((case.to_owned(), quantity.to_owned()), found.parse().ok()?))
    };
    text.lines().filter_map(line).collect()
}

/// The lines of a baseline, with their heading.
#[must_use]
pub fn write(results: &[(&str, Vec<Row>)]) -> String {
    let rows = results.iter().flat_map(|(case, rows)| rows.iter().map(move |row| (case, row)));
    let lines = rows.map(|(case, row)| format!("{case},{},{:.12e}\n", row.quantity, row.found));
    "case,quantity,found\n".to_owned() + &lines.collect::<String>()
}

/// Drifts: found values that moved, and quantities that have no stored value.
#[must_use]
pub fn drifts(baseline: &Baseline, results: &[(&str, Vec<Row>)]) -> Vec<String> {
    let mut drifts = Vec::new();
    for (case, rows) in results {
        for row in rows {
            match baseline.get(&((*case).to_owned(), row.quantity.clone())) {
                None => drifts.push(format!("{case}: {} has no stored value", row.quantity)),
                Some(stored) if (stored - row.found).abs() > DRIFT * row.tolerance => {
                    drifts.push(format!("{case}: {} was {stored:.6e}, is {:.6e}", row.quantity, row.found));
                }
                Some(_) => {}
            }
        }
    }
    drifts
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row(found: f64) -> Row {
        Row {
            quantity: "a, with a comma".into(),
            unit: "1",
            source: "made",
            expected: Some(1.0),
            found,
            tolerance: 0.1,
            reason: "made",
        }
    }

    /// What is written is read back, and a value that moves by more than a tenth of its tolerance is drift.
    #[test]
    fn a_drift_is_seen() {
        let stored = read(&write(&[("verify_made", vec![row(1.0)])]));
        assert!(drifts(&stored, &[("verify_made", vec![row(1.009)])]).is_empty());
        assert_eq!(drifts(&stored, &[("verify_made", vec![row(1.011)])]).len(), 1);
        assert_eq!(drifts(&Baseline::new(), &[("verify_made", vec![row(1.0)])]).len(), 1);
    }

    /// An undefined number never passes.
    #[test]
    fn undefined_does_not_pass() {
        assert!(row(1.05).passes() && !row(1.2).passes() && !row(f64::NAN).passes());
    }
}
