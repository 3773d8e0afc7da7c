//! Contact records of other laboratories explained: what the declared law lacks, error before and after.

use super::measured_contacts::{absent, data, description, label};
use crate::case::{Outcome, Row};
use frettrace::{
    Progress,
    explain::{ExplainOptions, explain},
    results::{BeforeAfter, Explanation, Verdict},
};
use frettrace_measurement::convert;

/// Rows of the explanations of a set.
pub(super) fn explained(set: &str, descriptions: &[&str]) -> anyhow::Result<Outcome> {
    let mut rows = Vec::new();
    for name in descriptions {
        let path = description(set, name);
        if let Some(reason) = absent(&path) {
            return Ok(Outcome::Skipped(reason));
        }
        let recording = convert(&[data()], &path)?.recording;
        let found = explain(&recording, &ExplainOptions::default(), &Progress::silent())?;
        rows.extend(told(&found, name));
    }
    Ok(Outcome::Ran(rows))
}

fn told(found: &Explanation, name: &str) -> Vec<Row> {
    let names: Vec<&str> = found.effects.iter().map(|effect| effect.id.as_str()).collect();
    let verdict = match found.verdict {
        Verdict::NothingMissing => "nothing missing",
        Verdict::Explained => "explained",
        Verdict::Unexplained => "open",
    };
    let lacks = if names.is_empty() { "nothing confirmed".to_owned() } else { names.join(" + ") };
    let mut rows =
        side(&found.error, &format!("fitted runs of {}", label(name)), &format!("{verdict}: {lacks}"));
    if let Some(held_out) = &found.held_out {
        rows.extend(side(held_out, &format!("held-out runs of {}", label(name)), &lacks));
    }
    rows
}

fn side(error: &BeforeAfter, which: &str, verdict: &str) -> Vec<Row> {
    let row = |quantity: String, value: f64| Row {
        quantity,
        unit: "1",
        source: "none",
        expected: None,
        found: value,
        tolerance: 0.2 * value,
        reason: "a change of a fiftieth would be news",
    };
    vec![
        row(format!("explain, {which}: floor"), error.noise_floor),
        row(format!("explain, {which}: before"), error.before),
        Row {
            // No effect may make a prediction worse.
            expected: Some(error.before.min(error.after)),
            source: "error before",
            tolerance: 0.2 * error.after,
            reason: "what is added must not make the prediction worse",
            ..row(format!("explain, {which}: after ({verdict})"), error.after)
        },
    ]
}
