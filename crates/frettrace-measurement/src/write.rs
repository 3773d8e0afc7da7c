//! Writing both kinds of file, and the truth of simulated ones.

use std::path::Path;

use crate::error::Error;
use crate::hdf5::{FileWriter, NewArray, Written};
use crate::measurement::{
    Beam, ContactRecord, ContactRun, Measurement, Run, SlipKind, SlipUnit, Source, Support,
};
use crate::read::{CONTACT_FORMAT, FORMAT_VERSION, MEASUREMENT_FORMAT};

/// What a simulation knows of one run: one number a sample each.
#[derive(Clone, Debug, PartialEq)]
pub struct RunTruth {
    /// Name of the run's group.
    pub id: String,
    /// Friction force \[N\].
    pub friction_force: Vec<f64>,
    /// Normal force \[N\].
    pub normal_force: Vec<f64>,
    /// Slip \[m\].
    pub slip_displacement: Vec<f64>,
    /// Slip velocity (m/s).
    pub slip_velocity: Vec<f64>,
    /// Force of the second support \[N\], where there is one.
    pub second_support_force: Option<Vec<f64>>,
}

/// What a simulation knows: written to `/truth` of a simulated measurement file.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Truth {
    /// Numbers by name (`sigma0`, `mu_k`, `effect_size`, …), written as attributes.
    pub numbers: Vec<(String, f64)>,
    /// Words by name (`law`, `effect`, …), written as attributes.
    pub words: Vec<(String, String)>,
    /// The runs.
    pub runs: Vec<RunTruth>,
}

/// Writes a measurement file, with what the simulation knows where there is such.
///
/// The file is written beside `path` and renamed when whole.
///
/// # Errors
/// [`Error::Write`].
pub fn write_measurement(
    path: impl AsRef<Path>,
    measurement: &Measurement,
    truth: Option<&Truth>,
) -> Result<(), Error> {
    let file = FileWriter::create(path.as_ref())?;
    header(&file, MEASUREMENT_FORMAT, &measurement.title, measurement.source)?;
    write_beam(&file, measurement)?;
    write_support(&file, &measurement.support)?;
    if let Some(second) = measurement.second_support {
        file.group("/second_support")?;
        file.number("/second_support", "position", second.position)?;
    }
    file.group("/exciter")?;
    file.number("/exciter", "position", measurement.exciter.position)?;
    write_sensors(&file, measurement)?;
    file.group("/runs")?;
    for run in &measurement.runs {
        write_run(&file, run)?;
    }
    if let Some(truth) = truth {
        write_truth(&file, truth)?;
    }
    file.finish()
}

/// Writes a contact record, beside `path` first and renamed when whole.
///
/// # Errors
/// [`Error::Write`].
pub fn write_contact_record(path: impl AsRef<Path>, record: &ContactRecord) -> Result<(), Error> {
    let file = FileWriter::create(path.as_ref())?;
    header(&file, CONTACT_FORMAT, &record.title, record.source)?;
    let unit = match record.slip_unit {
        SlipUnit::Metre => "m",
        SlipUnit::Radian => "rad",
    };
    file.group("/contact")?;
    file.text("/contact", "law", &record.law)?;
    file.text("/contact", "slip_unit", unit)?;
    if let Some(mass) = record.moving_mass {
        file.number("/contact", "moving_mass", mass)?;
    }
    file.group("/runs")?;
    for run in &record.runs {
        write_contact_run(&file, run, unit)?;
    }
    file.finish()
}

fn header(file: &FileWriter, format: &str, title: &str, source: Source) -> Result<(), Error> {
    file.text("/", "format", format)?;
    file.integer("/", "format_version", i64::from(FORMAT_VERSION))?;
    file.text("/", "title", title)?;
    let source = match source {
        Source::Measured => "measured",
        Source::Simulated => "simulated",
    };
    file.text("/", "source", source)
}

fn write_beam(file: &FileWriter, measurement: &Measurement) -> Result<(), Error> {
    let Beam { length, width, thickness, youngs_modulus, density, area, second_moment } = measurement.beam;
    file.group("/beam")?;
    let all = [
        ("length", Some(length)),
        ("width", Some(width)),
        ("thickness", Some(thickness)),
        ("youngs_modulus", Some(youngs_modulus)),
        ("density", Some(density)),
        ("area", area),
        ("second_moment", second_moment),
    ];
    for (name, value) in all.into_iter().filter_map(|(name, value)| Some((name, value?))) {
        file.number("/beam", name, value)?;
    }
    let Some(modes) = &measurement.modes else { return Ok(()) };
    file.group("/beam/modes")?;
    let all = [
        ("frequency", &modes.frequency, "Hz"),
        ("frequency_std", &modes.frequency_std, "Hz"),
        ("damping_ratio", &modes.damping_ratio, "1"),
        ("damping_ratio_std", &modes.damping_ratio_std, "1"),
    ];
    for (name, values, units) in all.into_iter().filter(|(_, values, _)| !values.is_empty()) {
        list(file, &format!("/beam/modes/{name}"), values, units)?;
    }
    Ok(())
}

fn write_support(file: &FileWriter, support: &Support) -> Result<(), Error> {
    file.group("/support")?;
    file.number("/support", "position", support.position)?;
    let slip = match support.slip {
        SlipKind::Rotation => "rotation",
        SlipKind::Transverse => "transverse",
    };
    file.text("/support", "slip", slip)?;
    if support.slip == SlipKind::Rotation {
        file.number("/support", "lever_arm", support.lever_arm)?;
    }
    file.number("/support", "normal_stiffness", support.normal_stiffness)?;
    file.text("/support", "law", &support.law)
}

fn write_sensors(file: &FileWriter, measurement: &Measurement) -> Result<(), Error> {
    let sensors = &measurement.sensors;
    file.group("/sensors")?;
    list(file, "/sensors/position", &sensors.position, "m")?;
    if let Some(noise) = &sensors.noise_std {
        list(file, "/sensors/noise_std", noise, "m/s^2")?;
    }
    match &sensors.name {
        Some(names) => file.texts("/sensors/name", names),
        None => Ok(()),
    }
}

fn write_run(file: &FileWriter, run: &Run) -> Result<(), Error> {
    let place = format!("/runs/{}", run.id);
    file.group(&place)?;
    file.text(&place, "label", &run.label)?;
    file.number(&place, "sampling_rate", run.sampling_rate)?;
    file.number(&place, "excitation_frequency", run.excitation_frequency)?;
    file.number(&place, "preload", run.preload)?;
    if let Some(lubricated) = run.lubricated {
        file.integer(&place, "lubricated", i64::from(lubricated))?;
    }
    if let Some(temperature) = run.temperature {
        file.number(&place, "temperature", temperature)?;
    }
    let values = rows(&run.acceleration);
    let shape = [run.force.len(), run.acceleration.len()];
    file.array(
        &format!("{place}/acceleration"),
        NewArray { shape: &shape, values: &values, units: "m/s^2" },
    )?;
    list(file, &format!("{place}/force"), &run.force, "N").map(drop)
}

fn write_contact_run(file: &FileWriter, run: &ContactRun, unit: &str) -> Result<(), Error> {
    let place = format!("/runs/{}", run.id);
    file.group(&place)?;
    file.text(&place, "label", &run.label)?;
    let numbers = [
        ("preload", run.preload),
        ("sampling_rate", run.sampling_rate),
        ("force_noise_std", run.force_noise_std),
    ];
    for (name, value) in numbers.into_iter().filter_map(|(name, value)| Some((name, value?))) {
        file.number(&place, name, value)?;
    }
    let (velocity, acceleration) = (format!("{unit}/s"), format!("{unit}/s^2"));
    let time = run.sampling_rate.is_none().then_some(&run.time);
    let all = [
        ("time", time, "s"),
        ("force", Some(&run.force), "N"),
        ("slip_displacement", Some(&run.slip_displacement), unit),
        ("slip_velocity", run.slip_velocity.as_ref(), velocity.as_str()),
        ("slip_acceleration", run.slip_acceleration.as_ref(), acceleration.as_str()),
        ("normal_force", run.normal_force.as_ref(), "N"),
    ];
    for (name, values, units) in
        all.into_iter().filter_map(|(name, values, units)| Some((name, values?, units)))
    {
        list(file, &format!("{place}/{name}"), values, units)?;
    }
    Ok(())
}

fn write_truth(file: &FileWriter, truth: &Truth) -> Result<(), Error> {
    file.group("/truth")?;
    for (name, value) in &truth.numbers {
        file.number("/truth", name, *value)?;
    }
    for (name, value) in &truth.words {
        file.text("/truth", name, value)?;
    }
    file.group("/truth/runs")?;
    for run in &truth.runs {
        let place = format!("/truth/runs/{}", run.id);
        file.group(&place)?;
        let all = [
            ("friction_force", Some(&run.friction_force), "N"),
            ("normal_force", Some(&run.normal_force), "N"),
            ("slip_displacement", Some(&run.slip_displacement), "m"),
            ("slip_velocity", Some(&run.slip_velocity), "m/s"),
            ("second_support_force", run.second_support_force.as_ref(), "N"),
        ];
        for (name, values, units) in
            all.into_iter().filter_map(|(name, values, units)| Some((name, values?, units)))
        {
            list(file, &format!("{place}/{name}"), values, units)?;
        }
    }
    Ok(())
}

pub(crate) fn list(file: &FileWriter, place: &str, values: &[f64], units: &str) -> Result<Written, Error> {
    file.array(place, NewArray { shape: &[values.len()], values, units })
}

/// Columns as rows: the last axis of the file's arrays is the sensor.
pub(crate) fn rows(columns: &[Vec<f64>]) -> Vec<f64> {
    let samples = columns.first().map_or(0, Vec::len);
    (0..samples).flat_map(|sample| columns.iter().map(move |column| column[sample])).collect()
}
