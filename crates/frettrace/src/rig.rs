//! RIG.toml: a rig for `simulate` and `response`, units in its keys.
//!
//! | table | keys |
//! |---|---|
//! | top | `title`, `seed` (1) |
//! | `[beam]` | `length_m`, `width_m`, `thickness_m`, `youngs_modulus_pa`, `density_kg_per_m3`, for tubes `area_m2` and `second_moment_m4` |
//! | `[clamp]` | `rotational_stiffness_n_m_per_rad` (infinite) |
//! | `[modes]` | `damping_ratio` (list; the last holds for the rest), `natural_frequency_hz` (list; the beam's own), `declared` (6, 0 = none in the file), `frequency_relative_std` (1e-5), `damping_relative_std` (1e-3) |
//! | `[support]` | `slip` (`rotation`, `transverse`), `lever_arm_m`, `normal_stiffness_n_per_m`, `law`, and `[support.parameters]` |
//! | `[support.parameters]` | those of the law, units in the keys: `sigma0_per_m`, `sigma1_s_per_m`, `sigma2_n_s_per_m`, `v_s_m_per_s`, `mu_k`, … ([`parameter_key`]) |
//! | `[second_support]` | `position_m`, `stiffness_n_per_m`, `gap_m` (0): declared in the file, its force is not |
//! | `[exciter]` | `position_m` |
//! | `[sensors]` | `position_m` (list), `noise_std_m_per_s2` (0), `noise_correlation` (0 = white) |
//! | `[sampling]` | `rate_hz`, `samples`, `march_rate_hz` (least steps of the march a second; as many as the sensors' noise asks for) |
//! | `[[run]]` | `frequency_hz`, `preload_n`, `force_amplitude_n` (list: one run each), `beat_share`, `beat_frequency_ratio`, `lubricated` |
//! | `[[effect]]` | `id` and the keys of [`Effect`]: what the file does not declare |
//!
//! Most effects have a second formula, `friction.stribeck/rational`: another laboratory's. It goes by the same name in results.
//! Ids that begin with `unlisted:` are effects without a name, to test that they are not given one.

mod check;
mod effect;

use std::collections::BTreeMap;
use std::path::Path;

use frettrace_beam::UniformBeam;
use frettrace_forward::simulate::Beat;
use frettrace_friction::{FrictionModel, Law, Parameter};
use serde::Deserialize;

use crate::StudyError;

pub(crate) use check::Problem;
pub use effect::Effect;

/// A rig.
#[derive(Clone, Debug, Deserialize, PartialEq)]
#[serde(deny_unknown_fields)]
pub struct Rig {
    /// Title of the file made from it.
    pub title: String,
    /// Seed of noise and phases.
    #[serde(default = "one")]
    pub seed: u64,
    /// The beam.
    pub beam: RigBeam,
    /// The clamp.
    #[serde(default)]
    pub clamp: RigClamp,
    /// Modes and damping.
    pub modes: RigModes,
    /// The friction support.
    pub support: RigSupport,
    /// A declared second support.
    pub second_support: Option<RigSecondSupport>,
    /// The exciter.
    pub exciter: RigExciter,
    /// The accelerometers.
    pub sensors: RigSensors,
    /// Sampling.
    pub sampling: RigSampling,
    /// Runs.
    #[serde(rename = "run")]
    pub runs: Vec<RigRuns>,
    /// Effects that the file does not declare.
    #[serde(rename = "effect", default)]
    pub effects: Vec<Effect>,
}

fn one() -> u64 {
    1
}

/// The beam; its section is `width · thickness` unless area and second moment are given.
#[derive(Clone, Debug, Deserialize, PartialEq)]
#[serde(deny_unknown_fields)]
pub struct RigBeam {
    /// Length (m).
    pub length_m: f64,
    /// Width (m).
    pub width_m: f64,
    /// Thickness in the direction of vibration (m).
    pub thickness_m: f64,
    /// Young's modulus (Pa).
    pub youngs_modulus_pa: f64,
    /// Density (kg/m³).
    pub density_kg_per_m3: f64,
    /// Area of the section (m²).
    pub area_m2: Option<f64>,
    /// Second moment of area (m⁴).
    pub second_moment_m4: Option<f64>,
}

impl RigBeam {
    /// The beam with its section, `A = b·h` and `I = b·h³/12` unless both are given.
    #[must_use]
    pub fn uniform(&self) -> UniformBeam {
        let area = self.area_m2.unwrap_or(self.width_m * self.thickness_m);
        let second_moment = self.second_moment_m4.unwrap_or(self.width_m * self.thickness_m.powi(3) / 12.0);
        UniformBeam {
            length: self.length_m,
            bending_stiffness: self.youngs_modulus_pa * second_moment,
            mass_per_length: self.density_kg_per_m3 * area,
        }
    }
}

/// The clamp.
#[derive(Clone, Debug, Deserialize, PartialEq)]
#[serde(deny_unknown_fields)]
pub struct RigClamp {
    /// Rotational stiffness (N·m/rad).
    pub rotational_stiffness_n_m_per_rad: f64,
}

impl Default for RigClamp {
    fn default() -> Self {
        Self { rotational_stiffness_n_m_per_rad: f64::INFINITY }
    }
}

/// Modes.
#[derive(Clone, Debug, Deserialize, PartialEq)]
#[serde(deny_unknown_fields)]
pub struct RigModes {
    /// Damping ratios; the last one holds for all further modes.
    pub damping_ratio: Vec<f64>,
    /// Natural frequencies that differ from the beam's (Hz).
    #[serde(default)]
    pub natural_frequency_hz: Vec<f64>,
    /// Modes written to the file.
    #[serde(default = "six")]
    pub declared: usize,
    /// Relative standard deviation of the declared frequencies.
    #[serde(default = "frequency_std")]
    pub frequency_relative_std: f64,
    /// Relative standard deviation of the declared damping ratios.
    #[serde(default = "damping_std")]
    pub damping_relative_std: f64,
}

fn six() -> usize {
    6
}

fn frequency_std() -> f64 {
    1e-5
}

fn damping_std() -> f64 {
    1e-3
}

/// Kind of slip.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Eq)]
#[serde(rename_all = "lowercase")]
pub enum RigSlip {
    /// The face turns over its support.
    Rotation,
    /// The beam slides sideways.
    Transverse,
}

/// The friction support at the end of the beam.
#[derive(Clone, Debug, Deserialize, PartialEq)]
#[serde(deny_unknown_fields)]
pub struct RigSupport {
    /// Kind of slip.
    pub slip: RigSlip,
    /// Lever arm (m), for rotation.
    pub lever_arm_m: Option<f64>,
    /// Stiffness of the support spring (N/m), for rotation; `inf` is the pinned end.
    pub normal_stiffness_n_per_m: Option<f64>,
    /// The declared friction law.
    pub law: String,
    /// Its parameters: names of the law with their units, `sigma0_per_m`.
    pub parameters: BTreeMap<String, f64>,
}

/// A second support: a one-sided stop.
#[derive(Clone, Debug, Deserialize, PartialEq)]
#[serde(deny_unknown_fields)]
pub struct RigSecondSupport {
    /// Position (m).
    pub position_m: f64,
    /// Stiffness (N/m).
    pub stiffness_n_per_m: f64,
    /// Clearance (m).
    #[serde(default)]
    pub gap_m: f64,
}

/// The exciter.
#[derive(Clone, Debug, Deserialize, PartialEq)]
#[serde(deny_unknown_fields)]
pub struct RigExciter {
    /// Position (m).
    pub position_m: f64,
}

/// The accelerometers.
#[derive(Clone, Debug, Deserialize, PartialEq)]
#[serde(deny_unknown_fields)]
pub struct RigSensors {
    /// Positions (m).
    pub position_m: Vec<f64>,
    /// Standard deviation of the noise (m/s²).
    #[serde(default)]
    pub noise_std_m_per_s2: f64,
    /// Correlation of the noise from sample to sample; 0 is white.
    #[serde(default)]
    pub noise_correlation: f64,
}

/// Sampling.
#[derive(Clone, Debug, Deserialize, PartialEq)]
#[serde(deny_unknown_fields)]
pub struct RigSampling {
    /// Sampling rate (Hz).
    pub rate_hz: f64,
    /// Samples a run.
    pub samples: usize,
    /// Least steps of the march a second (Hz), rounded up to whole ones in a fine sample. Not given, steps are shortened
    /// until no acceleration changes by more than a tenth of the noise.
    pub march_rate_hz: Option<f64>,
}

/// Least rate of the fine samples (Hz); a step across one is halved where a load bends in it, …
const FINE_RATE: f64 = 60_000.0;
/// … and least number of them a sample, so that accelerations can be had from displacements.
const FINE_SAMPLES: f64 = 8.0;

impl RigSampling {
    /// Fine samples of the march a sample, which the anti-alias filter takes.
    #[must_use]
    pub fn oversampling(&self) -> usize {
        (FINE_RATE / self.rate_hz).ceil().max(FINE_SAMPLES) as usize
    }

    /// Their rate (Hz).
    #[must_use]
    pub fn fine_rate_hz(&self) -> f64 {
        self.rate_hz * self.oversampling() as f64
    }
}

/// Runs that differ in their force only.
#[derive(Clone, Debug, Deserialize, PartialEq)]
#[serde(deny_unknown_fields)]
pub struct RigRuns {
    /// Excitation frequency (Hz).
    pub frequency_hz: f64,
    /// Preload (N).
    pub preload_n: f64,
    /// Amplitudes of the force (N), one run each.
    pub force_amplitude_n: Vec<f64>,
    /// Whether the contact is lubricated: written to the file, changes nothing by itself.
    pub lubricated: Option<bool>,
    /// Beat of the force, as a share of its amplitude; 0 is none.
    #[serde(default)]
    pub beat_share: f64,
    /// Frequency of the beat over the excitation's.
    #[serde(default)]
    pub beat_frequency_ratio: f64,
}

impl RigRuns {
    /// The beat of the force, where there is one.
    pub(crate) fn beat(&self) -> Option<Beat> {
        let beat = Beat { share: self.beat_share, frequency_ratio: self.beat_frequency_ratio };
        (beat.share != 0.0).then_some(beat)
    }
}

/// The declared law with its parameters, all given, all in range.
///
/// # Errors
/// What is wrong, where, and what is allowed.
pub(crate) fn declared_law(support: &RigSupport) -> Result<FrictionModel, Problem> {
    let problem = |place: String, found: &dyn ToString, allowed: String| Problem {
        place,
        found: found.to_string(),
        allowed,
    };
    let Ok(law) = Law::from_name(&support.law) else {
        let known: Vec<&str> = Law::ALL.iter().map(|law| law.name()).collect();
        return Err(problem("support.law".to_owned(), &support.law, known.join(", ")));
    };
    let place = |key: &str| format!("support.parameters.{key}");
    let keys: Vec<String> = law.parameters().iter().map(parameter_key).collect();
    if let Some(unknown) = support.parameters.keys().find(|key| !keys.contains(key)) {
        let allowed = format!("{} has {}", support.law, keys.join(", "));
        return Err(problem(place(unknown), &"unknown", allowed));
    }
    let mut values = Vec::new();
    for (parameter, key) in law.parameters().iter().zip(&keys) {
        match support.parameters.get(key) {
            None => return Err(problem(place(key), &"missing", parameter.range.to_string())),
            Some(value) if !parameter.range.contains(*value) => {
                return Err(problem(place(key), value, parameter.range.to_string()));
            }
            Some(value) => values.push(*value),
        }
    }
    // What is left is for the law as a whole to say.
    law.with_values(&values)
        .map_err(|error| problem("support.parameters".to_owned(), &error, "see there".to_owned()))
}

/// Key of a law's parameter in a rig: its name and unit, `sigma0` in `1/m` is `sigma0_per_m`.
#[must_use]
pub fn parameter_key(parameter: &Parameter) -> String {
    let words = |part: &str| part.replace('·', "_").replace('^', "").to_lowercase();
    let mut key = parameter.name.to_lowercase();
    let (above, below) = parameter.unit.split_once('/').map_or((parameter.unit, None), |(a, b)| (a, Some(b)));
    if above != "1" {
        key = format!("{key}_{}", words(above));
    }
    match below {
        Some(below) => format!("{key}_per_{}", words(below)),
        None => key,
    }
}

/// Reads a rig.
///
/// # Errors
/// [`StudyError::Read`], [`StudyError::RigSyntax`] for an unknown key or a bare mistake, [`StudyError::RigValue`] for a value
/// out of range.
pub fn read_rig(path: &Path) -> Result<Rig, StudyError> {
    let text =
        std::fs::read_to_string(path).map_err(|source| StudyError::Read { path: path.to_owned(), source })?;
    parse_rig(&text, path)
}

/// Reads a rig from text; `path` names it in errors.
///
/// # Errors
/// As [`read_rig`].
pub fn parse_rig(text: &str, path: &Path) -> Result<Rig, StudyError> {
    let rig: Rig = toml::from_str(text).map_err(|error| StudyError::RigSyntax {
        path: path.to_owned(),
        line: error.span().map_or(1, |span| 1 + text[..span.start.min(text.len())].matches('\n').count()),
        message: plain(error.message()),
    })?;
    check::check(&rig).map_err(|problem| StudyError::RigValue {
        path: path.to_owned(),
        place: problem.place,
        found: problem.found,
        allowed: problem.allowed,
    })?;
    Ok(rig)
}

/// What the reader of the text expects, on one line and in words of the file instead of the program.
fn plain(message: &str) -> String {
    let words = [
        ("\n", " "),
        ("expected f64", "expected a number"),
        ("expected usize", "expected a whole number, 0 or more"),
        ("expected u64", "expected a whole number, 0 or more"),
        ("expected a sequence", "expected a list in [ ]"),
        ("unknown variant", "unknown name"),
    ];
    words.iter().fold(message.to_owned(), |text, (from, to)| text.replace(from, to))
}

#[cfg(test)]
pub(crate) mod tests;
