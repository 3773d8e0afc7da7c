//! RIG.toml: a rig for `simulate` and `response`, units in its keys.
//!
//! | table | keys |
//! |---|---|
//! | top | `title`, `seed` (1) |
//! | `[beam]` | `length_m`, `width_m`, `thickness_m`, `youngs_modulus_pa`, `density_kg_per_m3`, for tubes `area_m2` and `second_moment_m4` |
//! | `[clamp]` | `rotational_stiffness_n_m_per_rad` (infinite) |
//! | `[modes]` | `damping_ratio` (list; the last holds for the rest), `natural_frequency_hz` (list; the beam's own), `declared` (6, 0 = none in the file), `frequency_relative_std` (1e-5), `damping_relative_std` (1e-3) |
//! | `[support]` | `slip` (`rotation`, `transverse`), `lever_arm_m`, `normal_stiffness_n_per_m`, `law`, and `[support.parameters]` |
//! | `[support.parameters]` | `sigma0_per_m`, `sigma1_s_per_m`, `sigma2_n_s_per_m`, `mu_s`, `mu_k`, `v_s_m_per_s`, `v_d_m_per_s`, `delta`, `exponent`, `breakaway`: those of the law, no others |
//! | `[second_support]` | `position_m`, `stiffness_n_per_m`, `gap_m` (0): declared in the file, its force is not |
//! | `[exciter]` | `position_m` |
//! | `[sensors]` | `position_m` (list), `noise_std_m_per_s2` (0), `noise_correlation` (0 = white) |
//! | `[sampling]` | `rate_hz`, `samples` |
//! | `[[run]]` | `frequency_hz`, `preload_n`, `force_amplitude_n` (list: one run each), `lubricated` |
//! | `[[effect]]` | `id` and the keys of [`Effect`]: what the file does not declare |

mod check;
mod effect;

use std::path::Path;

use serde::Deserialize;

use crate::StudyError;

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
    /// Stiffness of the support spring (N/m), for rotation.
    pub normal_stiffness_n_per_m: Option<f64>,
    /// The declared friction law.
    pub law: String,
    /// Its parameters.
    pub parameters: RigFriction,
}

/// Parameters of the declared law.
#[derive(Clone, Debug, Default, Deserialize, PartialEq)]
#[serde(deny_unknown_fields)]
pub struct RigFriction {
    /// `σ0` (1/m).
    pub sigma0_per_m: Option<f64>,
    /// `σ1` (s/m).
    pub sigma1_s_per_m: Option<f64>,
    /// `σ2` (N·s/m).
    pub sigma2_n_s_per_m: Option<f64>,
    /// `μ_s`.
    pub mu_s: Option<f64>,
    /// `μ_k`.
    pub mu_k: Option<f64>,
    /// `v_s` (m/s).
    pub v_s_m_per_s: Option<f64>,
    /// `v_d` (m/s).
    pub v_d_m_per_s: Option<f64>,
    /// `δ`.
    pub delta: Option<f64>,
    /// Dahl's exponent.
    pub exponent: Option<f64>,
    /// Elastic share of the steady deflection.
    pub breakaway: Option<f64>,
}

impl RigFriction {
    /// Parameters given: name in results, key in the file, value.
    #[must_use]
    pub fn given(&self) -> Vec<(&'static str, &'static str, f64)> {
        let all = [
            ("sigma0", "sigma0_per_m", self.sigma0_per_m),
            ("sigma1", "sigma1_s_per_m", self.sigma1_s_per_m),
            ("sigma2", "sigma2_n_s_per_m", self.sigma2_n_s_per_m),
            ("mu_s", "mu_s", self.mu_s),
            ("mu_k", "mu_k", self.mu_k),
            ("v_s", "v_s_m_per_s", self.v_s_m_per_s),
            ("v_d", "v_d_m_per_s", self.v_d_m_per_s),
            ("delta", "delta", self.delta),
            ("exponent", "exponent", self.exponent),
            ("breakaway", "breakaway", self.breakaway),
        ];
        all.into_iter().filter_map(|(name, key, value)| Some((name, key, value?))).collect()
    }
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
}

/// Reads a rig.
///
/// # Errors
/// [`StudyError::Read`], [`StudyError::RigSyntax`] for an unknown key or a bare mistake, [`StudyError::RigValue`] for a value
/// out of range.
pub fn read_rig(path: &Path) -> Result<Rig, StudyError> {
    let text = std::fs::read_to_string(path).map_err(|source| StudyError::Read { path: path.to_owned(), source })?;
    parse_rig(&text, path)
}

/// Reads a rig from text; `path` names it in errors.
///
/// # Errors
/// As [`read_rig`].
pub fn parse_rig(text: &str, path: &Path) -> Result<Rig, StudyError> {
    let rig: Rig = toml::from_str(text).map_err(|error| StudyError::RigSyntax {
        path: path.to_owned(),
        line: error.span().map_or(1, |span| text[..span.start.min(text.len())].lines().count().max(1)),
        message: error.message().replace('\n', " "),
    })?;
    check::check(&rig).map_err(|problem| StudyError::RigValue {
        path: path.to_owned(),
        place: problem.place,
        found: problem.found,
        allowed: problem.allowed,
    })?;
    Ok(rig)
}

#[cfg(test)]
mod tests;
