//! What rigs measure, and what is said of it.
#![expect(clippy::unwrap_used, reason = "helpers of tests may unwrap")]

use frettrace::Progress;
use frettrace::explain::{ExplainOptions, explain};
use frettrace::results::Explanation;
use frettrace::rig::{Rig, parse_rig};
use frettrace::simulate::simulate;
use frettrace_measurement::{Measurement, Recording};
use std::path::Path;

/// What the rig of a file measures once it is changed.
pub fn measured(text: &str, change: impl FnOnce(&mut Rig)) -> Measurement {
    let mut rig = parse_rig(text, Path::new("rig.toml")).unwrap();
    change(&mut rig);
    simulate(&rig, &Progress::silent()).unwrap().measurement
}

/// What it lacks.
pub fn explained(measurement: Measurement) -> Explanation {
    let recording = Recording::Measurement(measurement);
    explain(&recording, &ExplainOptions::default(), &Progress::silent()).unwrap()
}

/// Ids of the named effects.
pub fn named(found: &Explanation) -> Vec<&str> {
    found.effects.iter().map(|effect| effect.id.as_str()).collect()
}

/// Error of the runs held out over their noise, before and after.
pub fn over_noise(found: &Explanation) -> [f64; 2] {
    let held_out = found.held_out.as_ref().unwrap();
    [held_out.before, held_out.after].map(|error| error / held_out.noise_floor)
}
