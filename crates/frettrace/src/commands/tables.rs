//! Results as tables for a terminal.

use frettrace::{
    report::words::{number, percent},
    results::{BeforeAfter, ErrorSummary, Estimate, Identification, Structure},
};
use std::collections::BTreeMap;

/// An identified law.
pub fn identification(found: &Identification) -> String {
    let mut text = format!("law {}\n{}", found.law, estimates(&found.parameters));
    for step in &found.steps {
        text +=
            &format!("step {}: {} (error {})\n", step.name, step.parameters.join(", "), percent(step.error));
    }
    text += &error("fitted runs", &found.error);
    if let Some(held_out) = &found.held_out {
        text += &error("held-out runs", &held_out.error);
    }
    text += &structure(&found.structure);
    text + &notes(&found.notes)
}

/// Parameters with their intervals.
pub fn estimates(parameters: &BTreeMap<String, Estimate>) -> String {
    let row = |(name, estimate): (&String, &Estimate)| {
        let [low, high] = estimate.interval95.map(number);
        let remark = if estimate.identifiable { "" } else { "  not determined by these data" };
        format!("  {name:12} {:>11}  [{low} … {high}] {}{remark}\n", number(estimate.value), estimate.unit)
    };
    parameters.iter().map(row).collect()
}

/// Calibrated modes.
pub fn structure(found: &Structure) -> String {
    let row = |(index, mode): (usize, &frettrace::results::ModeEstimate)| {
        format!(
            "mode {:2}: {:10.4} ± {:.4} Hz, damping {:.3} ± {:.3} %\n",
            index + 1,
            mode.frequency.value,
            mode.frequency.std,
            100.0 * mode.damping_ratio.value,
            100.0 * mode.damping_ratio.std
        )
    };
    found.modes.iter().enumerate().map(row).collect()
}

fn error(name: &str, error: &ErrorSummary) -> String {
    let of = |what: &str, value: Option<f64>| value.map(|value| format!("{what} {}", percent(value)));
    let parts: Vec<_> =
        [of("acceleration", error.acceleration), of("force", error.force)].into_iter().flatten().collect();
    format!("error on {name}: {} (noise {})\n", parts.join(", "), percent(error.noise_floor))
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
