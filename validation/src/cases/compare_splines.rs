//! Splines against cut series, harmonic against subharmonic form, over sets whose truth is known.

use crate::case::{Case, Outcome, Row};
use crate::practice;
use frettrace::Progress;
use frettrace::reconstruct::{FormChoice, ReconstructOptions, reconstruct};
use frettrace_measurement::{DataFile, read_measurement};
use std::path::Path;

/// The case.
pub const CASE: Case = Case { name: "compare_splines", run };

/// Forms and splines that are compared.
const WAYS: [(&str, FormChoice, bool); 6] = [
    ("form by evidence", FormChoice::Auto, false),
    ("form by evidence and spline", FormChoice::Auto, true),
    ("harmonic", FormChoice::Harmonic, false),
    ("harmonic and spline", FormChoice::Harmonic, true),
    ("subharmonic", FormChoice::Subharmonic, false),
    ("subharmonic and spline", FormChoice::Subharmonic, true),
];

fn run() -> anyhow::Result<Outcome> {
    let Some(folder) = practice::folder() else { return Ok(Outcome::Skipped(practice::ABSENT.into())) };
    let sets = compared(&folder)?;
    let row = |(way, (name, _, _)): (usize, &(&str, FormChoice, bool))| {
        let found = middle(sets.iter().map(|(_, errors)| errors[way]).collect());
        Row {
            quantity: format!("friction force, {name}: median error of {} sets", sets.len()),
            unit: "1",
            source: "nothing known before",
            expected: None,
            found,
            tolerance: 0.5 * found,
            reason: "half of itself",
        }
    };
    Ok(Outcome::Ran(WAYS.iter().enumerate().map(row).collect()))
}

/// The table, set by set.
///
/// # Errors
/// Where the sets are absent or cannot be read.
pub fn table() -> anyhow::Result<String> {
    let folder = practice::folder().ok_or_else(|| anyhow::anyhow!(practice::ABSENT))?;
    let mut text = "| set |".to_owned();
    WAYS.iter().for_each(|(name, _, _)| text += &format!(" {name} |"));
    text += "\n|---|---|---|---|---|---|---|\n";
    for (name, errors) in compared(&folder)? {
        text += &format!("| {name} |");
        errors.iter().for_each(|error| text += &format!(" {:.2} % |", 100.0 * error));
        text += "\n";
    }
    Ok(text)
}

/// Median error over the runs of each set, for each way.
fn compared(folder: &Path) -> anyhow::Result<Vec<(String, Vec<f64>)>> {
    practice::names(folder)
        .into_iter()
        .map(|name| {
            let measurement = read_measurement(folder.join(format!("{name}.h5")))?;
            let truth = DataFile::open(folder.join(format!("{name}.truth.h5")))?;
            let errors = WAYS
                .iter()
                .map(|&(_, form, splines)| {
                    let options = ReconstructOptions { form, splines, as_declared: false };
                    let found = reconstruct(&measurement, &options, &Progress::silent())?;
                    let runs = found.result.runs.iter().map(|run| {
                        let place = format!("/runs/{}/friction_force", run.id);
                        Ok(error(&run.friction_force.values, &truth.array(&place)?.values))
                    });
                    Ok(middle(runs.collect::<anyhow::Result<_>>()?))
                })
                .collect::<anyhow::Result<_>>()?;
            Ok((name, errors))
        })
        .collect()
}

/// Relative root mean square of the difference, means removed.
fn error(found: &[f64], truth: &[f64]) -> f64 {
    let n = truth.len() as f64;
    let mean = |x: &[f64]| x.iter().sum::<f64>() / n;
    let (a, b) = (mean(found), mean(truth));
    let left: f64 = found.iter().zip(truth).map(|(x, y)| (x - a - y + b).powi(2)).sum();
    (left / truth.iter().map(|y| (y - b).powi(2)).sum::<f64>()).sqrt()
}

fn middle(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or(f64::NAN)
}
