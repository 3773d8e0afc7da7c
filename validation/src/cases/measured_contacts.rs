//! Contact records of other laboratories: the declared law identified on some runs, judged on others.

use super::explained_contacts::explained;
use crate::case::{Case, Outcome, Row};
use frettrace::{
    Progress,
    identify::{IdentifyOptions, identify},
};
use frettrace_measurement::convert;
use std::path::{Path, PathBuf};

/// Banded rotary friction damper.
pub const FRICTION_DAMPER: Case = Case { name: "validate_friction_damper", run: friction_damper };
/// Reciprocating tribometer.
pub const TRIBOMETER: Case = Case { name: "validate_tribometer", run: tribometer };
/// Pneumatic piston seals.
pub const PISTON_SEALS: Case = Case { name: "validate_piston_seals", run: piston_seals };
/// Magneto-rheological damper.
pub const MR_DAMPER: Case = Case { name: "validate_mr_damper", run: mr_damper };

fn friction_damper() -> anyhow::Result<Outcome> {
    measured("coble_2022_friction_damper", &["convert_20lb", "convert_30lb", "convert_80lb"])
}

fn tribometer() -> anyhow::Result<Outcome> {
    measured("christopherson_2021_tribometer", &["convert"])
}

fn piston_seals() -> anyhow::Result<Outcome> {
    measured("zillen_2021_piston_seals", &["convert_o_ring", "convert_x_ring"])
}

fn mr_damper() -> anyhow::Result<Outcome> {
    measured("vargas_2021_mr_damper", &["convert_ensaio1", "convert_ensaio3_2", "convert_ensaio8a"])
}

/// Where outside data lie: `FRETTRACE_DATA` (or `measured` in it), or beside the repository.
pub(super) fn data() -> PathBuf {
    let beside = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared/data/measured");
    let folder = std::env::var_os("FRETTRACE_DATA").map_or(beside, PathBuf::from);
    let inner = folder.join("measured");
    if inner.is_dir() { inner } else { folder }
}

/// The description of how a record is made from raw files.
pub(super) fn description(set: &str, name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../data").join(set);
    folder.join(name).with_extension("toml")
}

/// What distinguishes a description in a set.
pub(super) fn label(name: &str) -> &str {
    match name.trim_start_matches("convert").trim_start_matches('_') {
        "" => "the record",
        name => name,
    }
}

/// Which raw file of a description is absent, and what would mend it.
pub(super) fn absent(description: &Path) -> Option<String> {
    let text = std::fs::read_to_string(description).unwrap_or_default();
    let files = text.lines().filter_map(|line| line.trim().strip_prefix("file = \"")?.strip_suffix('"'));
    let missing = files.map(|file| data().join(file)).find(|file| !file.is_file())?;
    Some(format!("{} is absent; set FRETTRACE_DATA (see data/README.md)", missing.display()))
}

/// The declared law identified, then what it lacks.
fn measured(set: &str, descriptions: &[&str]) -> anyhow::Result<Outcome> {
    let mut rows = Vec::new();
    for name in descriptions {
        let path = description(set, name);
        if let Some(reason) = absent(&path) {
            return Ok(Outcome::Skipped(reason));
        }
        rows.extend(judged(&data(), &path, name.trim_start_matches("convert").trim_start_matches('_'))?);
    }
    if let Outcome::Ran(more) = explained(set, descriptions)? {
        rows.extend(more);
    }
    Ok(Outcome::Ran(rows))
}

fn judged(data: &Path, description: &Path, name: &str) -> anyhow::Result<Vec<Row>> {
    let recording = convert(&[data.to_owned()], description)?.recording;
    let found = identify(&recording, &IdentifyOptions::default(), &Progress::silent())?;
    let label = |quantity: &str| format!("{} {name}: {quantity}", found.law).replace(" :", ":");
    let reported = |quantity: &str, value: f64| Row {
        quantity: label(quantity),
        unit: "1",
        source: "none",
        expected: None,
        found: value,
        tolerance: 0.2 * value,
        reason: "a change of a fiftieth would be news",
    };
    let training = found.error.force.unwrap_or(f64::NAN);
    let mut rows =
        vec![reported("noise floor", found.error.noise_floor), reported("error on fitted runs", training)];
    if let Some(held_out) = &found.held_out {
        rows.push(Row {
            quantity: label("error on held-out runs"),
            unit: "1",
            source: "error on the fitted runs",
            expected: Some(training),
            found: held_out.error.force.unwrap_or(f64::NAN),
            tolerance: 0.5 * training,
            reason: "other amplitude, speed or load; a law that only described its own runs would do far worse",
        });
    }
    Ok(rows)
}
