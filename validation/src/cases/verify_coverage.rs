//! Whether the intervals of `identify` and the bands of `reconstruct` hold the truth on simulated rigs of all laws: the stored rigs,
//! counted, and one of them asked again.

use super::stored;
use crate::case::{Case, Outcome, Row};
use crate::sweep::CLEAN;
use crate::sweep::coverage::{Covered, cover};
use crate::sweep::plan::plan;
use anyhow::Context;

/// The case.
pub const CASE: Case = Case { name: "verify_coverage", run };

/// The seed of the stored rigs.
const SEED: u64 = 241;

fn run() -> anyhow::Result<Outcome> {
    let mut sets: Vec<Covered> = stored("verify_coverage/coverage.jsonl")?;
    sets.retain(|set| !set.unmade);
    let answered: Vec<&Covered> = sets.iter().filter(|set| set.failure.is_none()).collect();
    let inside = |channel: usize| mean(answered.iter().filter_map(|set| set.inside.get(channel).copied()));
    let all = || answered.iter().flat_map(|set| &set.parameters);
    let held = mean(all().map(|parameter| f64::from(u8::from(parameter.is_inside()))));
    let deviation = mean(all().map(|parameter| parameter.deviation.powi(2))).sqrt();
    // Whether a target is met is for the reader.
    let reported = |quantity: String, found: f64| Row {
        quantity,
        unit: "1",
        source: "counted",
        expected: None,
        found,
        tolerance: 0.05,
        reason: "change that would matter",
    };
    let mut rows = vec![reported(
        format!("rigs answered, of {} that were made", sets.len()),
        answered.len() as f64 / sets.len().max(1) as f64,
    )];
    for (channel, name) in ["friction force", "slip", "slip velocity"].into_iter().enumerate() {
        rows.push(reported(
            format!("{name}: samples within the band of 95 % (target 0.90 to 0.98)"),
            inside(channel),
        ));
    }
    rows.push(reported(
        format!("parameters within their interval of 95 %, of {} (target 0.90 to 0.98)", all().count()),
        held,
    ));
    rows.push(reported("parameters: deviation over the stated one, rms".into(), deviation));
    rows.push(again(&answered)?);
    Ok(Outcome::Ran(rows))
}

/// The first rig asked again: a file that another program wrote tells nothing of this one.
fn again(answered: &[&Covered]) -> anyhow::Result<Row> {
    let stored = answered.first().context("no rig is stored")?;
    let plan = plan(SEED, CLEAN);
    let planned =
        plan.iter().find(|set| set.name == stored.name).context("a stored rig is not in the plan")?;
    let now = cover(planned, || {});
    let pairs = now.parameters.iter().zip(&stored.parameters);
    let moved = pairs.map(|(a, b)| (a.deviation - b.deviation).abs()).fold(0.0, f64::max);
    let same = now.parameters.len() == stored.parameters.len();
    Ok(Row {
        quantity: format!("asked again: change of a deviation ({})", stored.name),
        unit: "1",
        source: "the same rig, made and asked again",
        expected: Some(0.0),
        found: if same { moved } else { f64::INFINITY },
        tolerance: 0.02,
        reason: "rounding, in standard deviations",
    })
}

fn mean(values: impl Iterator<Item = f64>) -> f64 {
    let (sum, count) = values.fold((0.0, 0.0), |(sum, count), value| (sum + value, count + 1.0));
    sum / count
}
