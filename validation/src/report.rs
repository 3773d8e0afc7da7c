//! `REPORT.md`: one row a quantity.

use crate::case::Row;

/// The report of all cases, and what was skipped with its reason.
#[must_use]
pub fn markdown(results: &[(&str, Vec<Row>)], skipped: &[(&str, String)]) -> String {
    let mut text = String::from(
        "# Validation report\n\nWritten by `cargo run -p validation`; questions, sources and reasons are in `cases/`.\n\n\
         | case | quantity | unit | expected | found | difference | allowed | |\n|---|---|---|---|---|---|---|---|\n",
    );
    for (case, rows) in results {
        for row in rows {
            text += &format!(
                "| {case} | {} | {} | {} | {} | {} | {:.1e} | {} |\n",
                row.quantity,
                row.unit,
                row.expected.map_or("–".into(), short),
                short(row.found),
                row.expected.map_or("–".into(), |expected| format!("{:.1e}", row.found - expected)),
                row.tolerance,
                if row.passes() { "✓" } else { "✗" }
            );
        }
    }
    for (case, reason) in skipped {
        text += &format!("\nSkipped: {case}: {reason}\n");
    }
    text
}

fn short(value: f64) -> String {
    if value == 0.0 || (1e-3..1e5).contains(&value.abs()) {
        format!("{value:.6}")
    } else {
        format!("{value:.4e}")
    }
}
