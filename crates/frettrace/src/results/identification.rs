//! `ID.json`: an identified friction law.

use super::number;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// A parameter with its uncertainty.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Estimate {
    /// Best value.
    #[serde(with = "number::scalar")]
    pub value: f64,
    /// Standard deviation, in the same unit.
    #[serde(with = "number::scalar")]
    pub std: f64,
    /// Interval that holds the true value with a probability of 95 %; an open end is infinite (`null`).
    #[serde(with = "number::interval")]
    pub interval95: [f64; 2],
    /// Unit.
    pub unit: String,
    /// Whether the data determine the value at all.
    pub identifiable: bool,
}

/// A calibrated mode.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ModeEstimate {
    /// Natural frequency (Hz).
    pub frequency: Estimate,
    /// Damping ratio.
    pub damping_ratio: Estimate,
}

/// The calibrated structure.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Structure {
    /// Modes in ascending order.
    pub modes: Vec<ModeEstimate>,
}

/// One step of the identification.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Step {
    /// What the step does.
    pub name: String,
    /// Parameters it frees.
    pub parameters: Vec<String>,
    /// Its error: relative RMS of what it fits.
    #[serde(with = "number::scalar")]
    pub error: f64,
}

/// Where the noise floor comes from.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum NoiseFloorSource {
    /// The file states it.
    Given,
    /// From repeated cycles.
    Repeats,
    /// From what lies between the lines of the spectrum.
    #[default]
    Estimated,
}

/// Errors as relative RMS of measured minus predicted.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ErrorSummary {
    /// Of the contact force, where it is known.
    pub force: Option<f64>,
    /// Of the accelerations over all sensors and runs; `null` for a contact record.
    pub acceleration: Option<f64>,
    /// The same measure for a perfect model.
    #[serde(with = "number::scalar")]
    pub noise_floor: f64,
    /// Where the noise floor comes from.
    #[serde(default)]
    pub noise_floor_source: NoiseFloorSource,
}

/// Errors on runs that nothing was fitted to.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct HeldOut {
    /// The errors.
    #[serde(flatten)]
    pub error: ErrorSummary,
    /// Names of the runs.
    #[serde(default)]
    pub runs: Vec<String>,
}

/// What a result rests on.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Provenance {
    /// Version of the program.
    pub version: String,
    /// Seed of every random draw.
    #[serde(default)]
    pub seed: u64,
    /// Runs that were fitted.
    #[serde(default)]
    pub training_runs: Vec<String>,
}

/// A parameter with a value of its own in each group of runs.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct GroupEstimate {
    /// Whether the evidence is strong that the groups differ.
    pub differs: bool,
    /// ΔBIC of one shared value against one a group: above 10 they differ, below −10 they share it.
    #[serde(with = "number::scalar")]
    pub evidence: f64,
    /// Value in each group, in the parameter's unit.
    pub values: Vec<f64>,
    /// Standard deviation of each.
    pub std: Vec<f64>,
}

/// Parameters tested over a condition of the runs.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Dependence {
    /// The condition: preload, excitation frequency, level, lubrication or temperature.
    pub condition: String,
    /// Its groups, in words.
    pub groups: Vec<String>,
    /// The parameters tested.
    pub parameters: BTreeMap<String, GroupEstimate>,
}

/// An identified law: `ID.json`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Identification {
    /// Name of the law.
    pub law: String,
    /// Its parameters by name.
    pub parameters: BTreeMap<String, Estimate>,
    /// Calibrated structure; without modes for a contact record.
    pub structure: Structure,
    /// The steps, in order.
    pub steps: Vec<Step>,
    /// Errors on the runs that were fitted.
    pub error: ErrorSummary,
    /// Errors on the runs that were not; absent where there are too few runs to hold any out.
    pub held_out: Option<HeldOut>,
    /// Whether parameters differ between runs of different preload, frequency, level, lubrication or temperature.
    #[serde(default)]
    pub dependence: Vec<Dependence>,
    /// What the result rests on.
    #[serde(default)]
    pub provenance: Provenance,
    /// What a reader must know: what cannot be seen, what was left out and why.
    #[serde(default)]
    pub notes: Vec<String>,
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The contract's example, word for word in its keys; an open interval is `null`.
    #[test]
    fn json_has_the_keys_of_the_contract() {
        let estimate = Estimate {
            value: 1e5,
            std: 10.0,
            interval95: [f64::NEG_INFINITY, 2e5],
            unit: "1/m".into(),
            identifiable: false,
        };
        let found = Identification {
            law: "dahl".into(),
            parameters: BTreeMap::from([("sigma0".into(), estimate)]),
            held_out: Some(HeldOut::default()),
            ..Identification::default()
        };
        let json = serde_json::to_value(&found).unwrap();
        assert_eq!(json["parameters"]["sigma0"]["interval95"], serde_json::json!([null, 2e5]));
        for key in ["force", "acceleration", "noise_floor"] {
            assert!(json["error"].get(key).is_some(), "error.{key}");
            assert!(json["held_out"].get(key).is_some(), "held_out.{key}");
        }
        assert_eq!(serde_json::from_value::<Identification>(json).unwrap(), found);
    }
}
