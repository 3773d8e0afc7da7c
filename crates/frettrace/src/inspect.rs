//! What a file holds and how good its signals are.

use crate::{Progress, StudyError};
use frettrace_measurement::{
    ContactRecord, Measurement, Recording, SlipUnit,
    quality::{ContactQuality, RunQuality, judge, judge_contact},
};
use rayon::prelude::*;
use serde::Serialize;

/// What a file holds.
#[derive(Clone, Debug, Serialize)]
#[serde(tag = "format")]
pub enum Inspection {
    /// A measurement file.
    #[serde(rename = "frettrace-measurement")]
    Measurement {
        /// Title.
        title: String,
        /// The declared law.
        law: String,
        /// `rotation` or `transverse`.
        slip: String,
        /// Number of measured modes; 0 where the file gives none.
        modes: usize,
        /// Position of a declared second support (m).
        second_support_m: Option<f64>,
        /// Positions of the sensors (m).
        sensor_position_m: Vec<f64>,
        /// The runs.
        runs: Vec<RunQuality>,
    },
    /// A contact record.
    #[serde(rename = "frettrace-contact")]
    Contact {
        /// Title.
        title: String,
        /// The declared law.
        law: String,
        /// Unit of the slip.
        slip_unit: String,
        /// The runs.
        runs: Vec<ContactQuality>,
    },
}

/// Inspects a recording; runs in parallel.
///
/// # Errors
/// [`StudyError::Run`] when a run is too short for lines of its excitation frequency.
pub fn inspect(recording: &Recording, progress: &Progress) -> Result<Inspection, StudyError> {
    match recording {
        Recording::Measurement(measurement) => inspect_measurement(measurement, progress),
        Recording::Contact(record) => Ok(inspect_contact(record)),
    }
}

fn inspect_measurement(measurement: &Measurement, progress: &Progress) -> Result<Inspection, StudyError> {
    progress.start(measurement.runs.len() as u64, "inspecting runs");
    let runs = measurement
        .runs
        .par_iter()
        .map(|run| {
            let quality = judge(run, &measurement.sensors)
                .map_err(|source| StudyError::Run { run: run.id.clone(), source });
            progress.step();
            quality
        })
        .collect::<Result<_, _>>()?;
    Ok(Inspection::Measurement {
        title: measurement.title.clone(),
        law: measurement.support.law.clone(),
        slip: format!("{:?}", measurement.support.slip).to_lowercase(),
        modes: measurement.modes.as_ref().map_or(0, |modes| modes.frequency.len()),
        second_support_m: measurement.second_support.map(|support| support.position),
        sensor_position_m: measurement.sensors.position.clone(),
        runs,
    })
}

fn inspect_contact(record: &ContactRecord) -> Inspection {
    Inspection::Contact {
        title: record.title.clone(),
        law: record.law.clone(),
        slip_unit: match record.slip_unit {
            SlipUnit::Metre => "m".into(),
            SlipUnit::Radian => "rad".into(),
        },
        runs: record.runs.iter().map(judge_contact).collect(),
    }
}
