//! `EXPLAIN.json`: what the declared model lacks.

use super::{Estimate, Identification, NoiseFloorSource, Provenance, number};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// The outcome of an explanation.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Verdict {
    /// The declared model says all that the data say.
    NothingMissing,
    /// Named effects were missing; with them the model is complete.
    Explained,
    /// Something is missing that is in no list.
    #[default]
    Unexplained,
}

/// Where an effect lives.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Place {
    /// In the friction contact.
    Contact,
    /// In the beam and its supports.
    Structure,
    /// In the exciter.
    Excitation,
    /// In the measurement chain.
    Measurement,
}

/// An effect the declared model lacks.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Effect {
    /// Its id in the contract's list.
    pub id: String,
    /// Probability that it is there.
    #[serde(with = "number::scalar")]
    pub probability: f64,
    /// Position on the beam (m), for effects that have one.
    pub position_m: Option<f64>,
    /// Index of the sensor from 0, for effects of one channel.
    pub sensor: Option<usize>,
    /// Its parameters by name.
    pub parameters: BTreeMap<String, Estimate>,
    /// Ids of effects these data cannot tell from it (at most two).
    #[serde(default)]
    pub indistinguishable_from: Vec<String>,
    /// The experiment that would tell them apart.
    #[serde(default)]
    pub separating_experiment: Option<String>,
}

/// Error before and after, as relative RMS of measured minus predicted.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct BeforeAfter {
    /// With the declared model.
    #[serde(with = "number::scalar")]
    pub before: f64,
    /// With the effects in it.
    #[serde(with = "number::scalar")]
    pub after: f64,
    /// The same measure for a perfect model.
    #[serde(with = "number::scalar")]
    pub noise_floor: f64,
    /// Where the noise floor comes from.
    #[serde(default)]
    pub noise_floor_source: NoiseFloorSource,
    /// Names of the runs it is about.
    #[serde(default)]
    pub runs: Vec<String>,
}

/// A candidate that was tried.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Candidate {
    /// Its id.
    pub id: String,
    /// Relative RMS error with it, on the fitted runs.
    #[serde(with = "number::scalar")]
    pub error: f64,
    /// Evidence against the model without it: difference of the Bayesian information criterion, positive for it.
    #[serde(with = "number::scalar")]
    pub evidence: f64,
}

/// What a control asks.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Question {
    /// The declared model with noise drawn anew: an effect named there is a false alarm.
    #[default]
    Surrogate,
    /// The data, with the named effects taken out of the list.
    LeftOut,
    /// The explaining model with noise drawn anew, its effects at a share of their size.
    Injection,
}

/// The same search, asked where the answer is known.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Control {
    /// What was asked.
    pub question: Question,
    /// Share of its size at which the effect was injected.
    pub share: Option<f64>,
    /// The verdict.
    pub verdict: Verdict,
    /// Effects named.
    pub named: Vec<String>,
    /// Where something is missing.
    pub place: Option<Place>,
    /// Whether that is the right answer.
    pub right: bool,
}

/// The residual against one quantity: mean square in bins, in units of the noise.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ResidualShape {
    /// The quantity: slip, slip velocity, normal force, phase, time, level or sensor.
    pub against: String,
    /// Its unit.
    pub unit: String,
    /// Centres of the bins.
    #[serde(with = "number::series")]
    pub centre: Vec<f64>,
    /// Residual before, in standard deviations of the noise.
    #[serde(with = "number::series")]
    pub before: Vec<f64>,
    /// Residual after, in standard deviations of the noise.
    #[serde(with = "number::series")]
    pub after: Vec<f64>,
}

/// The residual over two quantities at once: quadratic means in cells, in units of the noise.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ResidualMap {
    /// The quantity across: phase, slip, sensor.
    pub across: String,
    /// Its unit.
    pub across_unit: String,
    /// Centres of the cells across.
    #[serde(with = "number::series")]
    pub x: Vec<f64>,
    /// The quantity upwards: level, sensor, slip velocity, run.
    pub up: String,
    /// Its unit.
    pub up_unit: String,
    /// Centres of the cells upwards.
    #[serde(with = "number::series")]
    pub y: Vec<f64>,
    /// Residual before, a row for each `y`; cells that nothing fell in are `null`.
    #[serde(with = "number::table")]
    pub before: Vec<Vec<f64>>,
    /// Residual after.
    #[serde(with = "number::table")]
    pub after: Vec<Vec<f64>>,
}

/// One period of a contact, means removed.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ContactCurve {
    /// Slip.
    #[serde(with = "number::series")]
    pub slip: Vec<f64>,
    /// Slip velocity; empty where it is not known.
    #[serde(with = "number::series", default)]
    pub slip_velocity: Vec<f64>,
    /// Friction force (N).
    #[serde(with = "number::series")]
    pub force: Vec<f64>,
    /// Energy that friction takes in this period, in joules.
    #[serde(with = "number::scalar", default)]
    pub energy_per_cycle_j: f64,
}

/// Friction force against slip over one period of a run.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ContactLoop {
    /// Name of the run.
    pub run: String,
    /// Label of the run.
    pub label: String,
    /// Whether nothing was fitted to this run.
    pub held_out: bool,
    /// Unit of the slip.
    pub slip_unit: String,
    /// Measured, or recovered without a law.
    pub measured: ContactCurve,
    /// As the declared model has it.
    pub before: ContactCurve,
    /// As the model with the effects has it.
    pub after: ContactCurve,
}

/// One channel over one period of a run.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Waveform {
    /// Name of the run.
    pub run: String,
    /// Label of the run.
    pub label: String,
    /// Whether nothing was fitted to this run.
    pub held_out: bool,
    /// What is shown, with its unit: `acceleration of sensor 3 (m/s²)`.
    pub channel: String,
    /// Whether the channel was recovered from accelerations; else a sensor read it.
    #[serde(default)]
    pub is_recovered: bool,
    /// Time (s).
    #[serde(with = "number::series")]
    pub time: Vec<f64>,
    /// Measured or recovered.
    #[serde(with = "number::series")]
    pub measured: Vec<f64>,
    /// Modelled by the declared model.
    #[serde(with = "number::series")]
    pub before: Vec<f64>,
    /// Modelled with the effects in it.
    #[serde(with = "number::series")]
    pub after: Vec<f64>,
}

/// Amplitudes over frequency.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Amplitudes {
    /// Frequencies (Hz).
    #[serde(with = "number::series")]
    pub frequency: Vec<f64>,
    /// Amplitudes, in the unit of the channel.
    #[serde(with = "number::series")]
    pub amplitude: Vec<f64>,
}

/// Spectrum of a channel with the floor of its noise, and of what both models leave of it.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ChannelSpectrum {
    /// Name of the run.
    pub run: String,
    /// Label of the run.
    pub label: String,
    /// Whether nothing was fitted to this run.
    pub held_out: bool,
    /// What is shown, with its unit.
    pub channel: String,
    /// Measured.
    pub measured: Amplitudes,
    /// Where the floor comes from.
    pub floor_name: String,
    /// What a perfect model would leave, in quadratic mean.
    pub floor: Amplitudes,
    /// What the declared model leaves.
    pub before: Amplitudes,
    /// What the model with the effects leaves.
    pub after: Amplitudes,
}

/// What the report draws; at most some hundred points a curve.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Exhibits {
    /// Whether motion and force were measured in the contact itself; else they were recovered from accelerations.
    #[serde(default)]
    pub contact_is_measured: bool,
    /// Friction loops, measured and modelled.
    #[serde(default)]
    pub loops: Vec<ContactLoop>,
    /// Channels, measured and modelled.
    #[serde(default)]
    pub waveforms: Vec<Waveform>,
    /// Spectra of the same channels.
    #[serde(default)]
    pub spectra: Vec<ChannelSpectrum>,
    /// The residual against what may drive it.
    #[serde(default)]
    pub residual: Vec<ResidualShape>,
    /// The residual over two quantities at once.
    #[serde(default)]
    pub maps: Vec<ResidualMap>,
}

/// What the declared model lacks: `EXPLAIN.json`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Explanation {
    /// The outcome.
    pub verdict: Verdict,
    /// The effects named.
    pub effects: Vec<Effect>,
    /// Where they live; `null` when nothing is missing.
    pub place: Option<Place>,
    /// Error on the runs that were fitted.
    pub error: BeforeAfter,
    /// Error on runs that nothing was fitted to; absent where there are too few runs to hold any out.
    pub held_out: Option<BeforeAfter>,
    /// All candidates tried, best first.
    pub candidates: Vec<Candidate>,
    /// The declared model, fitted.
    pub baseline: Identification,
    /// The model with the effects in it, fitted.
    pub model: Identification,
    /// The same search where the answer is known; empty unless asked for.
    #[serde(default)]
    pub controls: Vec<Control>,
    /// What the report draws.
    #[serde(default)]
    pub exhibits: Exhibits,
    /// What the result rests on.
    #[serde(default)]
    pub provenance: Provenance,
    /// What a reader must know: what stays open, and why.
    #[serde(default)]
    pub notes: Vec<String>,
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Words and keys are those of the contract.
    #[test]
    fn json_has_the_words_of_the_contract() {
        let found = Explanation {
            verdict: Verdict::NothingMissing,
            place: Some(Place::Contact),
            held_out: Some(BeforeAfter {
                before: 0.1,
                after: 0.02,
                noise_floor: 0.02,
                ..BeforeAfter::default()
            }),
            effects: vec![Effect { id: "friction.stribeck".into(), ..Effect::default() }],
            ..Explanation::default()
        };
        let json = serde_json::to_value(&found).unwrap();
        assert_eq!(json["verdict"], "nothing-missing");
        assert_eq!(json["place"], "contact");
        assert_eq!(json["held_out"]["before"], 0.1);
        for key in ["id", "probability", "position_m", "sensor", "parameters", "indistinguishable_from"] {
            assert!(json["effects"][0].get(key).is_some(), "effects.{key}");
        }
        assert_eq!(serde_json::from_value::<Explanation>(json).unwrap(), found);
    }
}
