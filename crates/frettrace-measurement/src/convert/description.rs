//! The TOML that says which column is what, its unit and sign, the runs and the rig.

use std::path::Path;

use serde::Deserialize;

use crate::error::{Error, Problem};
use crate::units::{Dimension, quantity, si_name};

/// The description of a conversion. Quantities are texts with units (`"501 mm"`, `"30 lbf"`).
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Description {
    pub(super) kind: Kind,
    #[serde(default)]
    pub(super) title: String,
    #[serde(default)]
    pub(super) simulated: bool,
    pub(super) law: String,
    pub(super) slip_unit: Option<String>,
    pub(super) moving_mass: Option<String>,
    pub(super) force_noise_std: Option<String>,
    pub(super) sampling_rate: Option<String>,
    pub(super) resample: Option<Resample>,
    pub(super) channels: Channels,
    pub(super) beam: Option<Beam>,
    pub(super) modes: Option<Modes>,
    pub(super) support: Option<Support>,
    pub(super) second_support: Option<Place>,
    pub(super) exciter: Option<Place>,
    #[serde(default)]
    pub(super) runs: Vec<Run>,
}

/// The two kinds of file.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub(super) enum Kind {
    Measurement,
    Contact,
}

/// Uniform sampling made from uneven.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Resample {
    pub(super) rate: String,
    pub(super) method: Method,
}

/// How values between samples are found.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub(super) enum Method {
    /// Straight lines.
    Linear,
    /// Cubics that never overshoot (Fritsch and Carlson 1980).
    Pchip,
}

/// Which column is what.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Channels {
    pub(super) time: Option<Channel>,
    pub(super) force: Channel,
    pub(super) slip_displacement: Option<Channel>,
    pub(super) slip_velocity: Option<Channel>,
    pub(super) slip_acceleration: Option<Channel>,
    pub(super) normal_force: Option<Channel>,
    #[serde(default)]
    pub(super) acceleration: Vec<Sensor>,
}

/// A column by its number, from 1, or its name.
#[derive(Clone, Debug, Deserialize)]
#[serde(untagged)]
pub(super) enum ColumnName {
    Number(usize),
    Name(String),
}

impl std::fmt::Display for ColumnName {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Number(number) => write!(formatter, "{number}"),
            Self::Name(name) => formatter.write_str(name),
        }
    }
}

/// A channel: column, unit, sign, sensitivity, offset, and further columns added to it.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Channel {
    pub(super) column: ColumnName,
    pub(super) unit: String,
    pub(super) sign: Option<i32>,
    /// Of a transducer whose column is in volts: `"100 mV/g"`.
    pub(super) sensitivity: Option<String>,
    /// `"mean"`, or a quantity, subtracted.
    pub(super) offset: Option<String>,
    #[serde(default)]
    pub(super) add: Vec<Term>,
}

/// A column times a factor: `{ column = 6, unit = "bar", factor = "-491 mm^2" }` takes the thrust of a pressure off.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Term {
    pub(super) column: ColumnName,
    pub(super) unit: String,
    pub(super) factor: String,
}

/// An accelerometer.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Sensor {
    pub(super) column: ColumnName,
    pub(super) unit: String,
    pub(super) sign: Option<i32>,
    pub(super) sensitivity: Option<String>,
    pub(super) offset: Option<String>,
    pub(super) position: String,
    pub(super) name: Option<String>,
    pub(super) noise_std: Option<String>,
}

impl Sensor {
    pub(super) fn channel(&self) -> Channel {
        Channel {
            column: self.column.clone(),
            unit: self.unit.clone(),
            sign: self.sign,
            sensitivity: self.sensitivity.clone(),
            offset: self.offset.clone(),
            add: Vec::new(),
        }
    }
}

/// The beam.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Beam {
    pub(super) length: String,
    pub(super) width: String,
    pub(super) thickness: String,
    pub(super) youngs_modulus: String,
    pub(super) density: String,
    pub(super) area: Option<String>,
    pub(super) second_moment: Option<String>,
}

/// Modes measured with the friction removed.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Modes {
    pub(super) frequency_hz: Vec<f64>,
    #[serde(default)]
    pub(super) frequency_std_hz: Vec<f64>,
    pub(super) damping_ratio: Vec<f64>,
    #[serde(default)]
    pub(super) damping_ratio_std: Vec<f64>,
}

/// The friction support.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Support {
    pub(super) position: String,
    pub(super) slip: Slip,
    pub(super) lever_arm: Option<String>,
    pub(super) normal_stiffness: Option<String>,
}

/// How the contact face slips.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub(super) enum Slip {
    Rotation,
    Transverse,
}

/// A place on the beam.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Place {
    pub(super) position: String,
}

/// One run: a file, or a piece of one.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Run {
    pub(super) file: Option<String>,
    pub(super) label: Option<String>,
    pub(super) from: Option<String>,
    pub(super) to: Option<String>,
    pub(super) preload: Option<String>,
    pub(super) excitation_frequency: Option<String>,
    pub(super) lubricated: Option<bool>,
    pub(super) temperature_k: Option<f64>,
}

/// The description's file, for errors.
#[derive(Clone, Copy)]
pub(super) struct Origin<'a>(pub(super) &'a Path);

impl Origin<'_> {
    pub(super) fn invalid(self, place: &str, problem: Problem) -> Error {
        Error::Invalid { file: self.0.to_path_buf(), place: place.into(), problem: problem.into() }
    }

    /// A quantity of the dimension expected.
    pub(super) fn quantity(self, place: &str, text: &str, dimension: Dimension) -> Result<f64, Error> {
        match quantity(text) {
            Some((value, found)) if found == dimension => Ok(value),
            _ => {
                let expected = si_name(dimension).to_string();
                Err(self.invalid(place, Problem::WrongQuantity { found: text.into(), expected }))
            }
        }
    }

    pub(super) fn optional(
        self,
        place: &str,
        text: Option<&String>,
        dimension: Dimension,
    ) -> Result<Option<f64>, Error> {
        text.map(|text| self.quantity(place, text, dimension)).transpose()
    }

    /// A part of the description that this kind of file needs.
    pub(super) fn need<T>(self, place: &str, part: Option<T>) -> Result<T, Error> {
        part.ok_or_else(|| self.invalid(place, Problem::MissingEntry))
    }
}

/// Reads a description.
pub(super) fn read(path: &Path) -> Result<Description, Error> {
    let text =
        std::fs::read_to_string(path).map_err(|source| Error::Open { file: path.to_path_buf(), source })?;
    toml::from_str(&text).map_err(|error| {
        let line =
            error.span().map_or(1, |span| 1 + text[..span.start.min(text.len())].matches('\n').count());
        let reason = error.message().replace('\n', " ");
        Origin(path).invalid(&format!("line {line}"), Problem::BadDescription { reason })
    })
}
