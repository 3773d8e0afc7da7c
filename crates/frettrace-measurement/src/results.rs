//! The result file of a reconstruction (`REC.h5`).
//!
//! Every dataset carries `units`; `time`, `sensor_position` and `harmonics/frequency` are dimension scales, so that
//! h5py and xarray label the axes by themselves.

use std::path::Path;

use num_complex::Complex64;

use crate::error::Error;
use crate::hdf5::{FileWriter, NewArray, Written};
use crate::write::{list, rows};

/// Form of the motion of a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Form {
    /// Period of the excitation.
    Harmonic,
    /// A multiple of the period of the excitation.
    Subharmonic,
    /// No period: quasi-periodic, chaotic or still settling.
    Aperiodic,
}

/// A quantity and its standard deviation, one number a sample.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Estimate {
    /// Values.
    pub values: Vec<f64>,
    /// Standard deviations, as many.
    pub std: Vec<f64>,
}

/// Complex Fourier coefficients of one quantity: `x(t) = Re Σ c_k exp(2πi f_k t)`.
#[derive(Clone, Debug, PartialEq)]
pub struct Coefficients {
    /// Name of the quantity (`friction_force`).
    pub name: String,
    /// Its units.
    pub units: String,
    /// One coefficient a line.
    pub values: Vec<Complex64>,
    /// Standard deviations of the modulus, as many; empty where not known.
    pub std: Vec<f64>,
}

/// The lines of one run.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct HarmonicTable {
    /// Frequency of every line \[Hz\], from 0.
    pub frequency: Vec<f64>,
    /// The quantities.
    pub quantities: Vec<Coefficients>,
}

/// What was reconstructed of one run.
#[derive(Clone, Debug, PartialEq)]
pub struct ReconstructedRun {
    /// Name of the run's group (`0001`).
    pub id: String,
    /// Label of the run.
    pub label: String,
    /// Refined fundamental frequency \[Hz\]: the excitation's divided by the subharmonic order.
    pub fundamental_frequency: f64,
    /// Form of the motion.
    pub form: Form,
    /// 1 for the harmonic form, ν for a motion of ν periods of the excitation.
    pub subharmonic_order: u32,
    /// Number of harmonics of the fundamental kept.
    pub harmonics: u32,
    /// Relative RMS of measured minus fitted acceleration.
    pub acceleration_error: f64,
    /// The same measure for a perfect model.
    pub noise_floor: f64,
    /// What accelerometers cannot show, set to 0 (`mean friction_force`, …).
    pub unobservable: Vec<String>,
    /// Why the run could not be solved, or what to mind.
    pub note: Option<String>,
    /// Further numbers by name, written as attributes of the run.
    pub numbers: Vec<(String, f64)>,
    /// Time of every sample \[s\].
    pub time: Vec<f64>,
    /// Friction force \[N\].
    pub friction_force: Estimate,
    /// Normal force \[N\], the declared preload included.
    pub normal_force: Estimate,
    /// Slip \[m\].
    pub slip_displacement: Estimate,
    /// Slip velocity (m/s).
    pub slip_velocity: Estimate,
    /// Fitted acceleration (m/s²), one a sensor.
    pub acceleration_fit: Vec<Estimate>,
    /// Force of the second support \[N\], where one is declared.
    pub second_support_force: Option<Estimate>,
    /// Complex Fourier coefficients.
    pub coefficients: HarmonicTable,
}

/// A reconstruction of all runs of a measurement file.
#[derive(Clone, Debug, PartialEq)]
pub struct Reconstruction {
    /// Title.
    pub title: String,
    /// Positions of the sensors \[m\].
    pub sensor_position: Vec<f64>,
    /// The runs.
    pub runs: Vec<ReconstructedRun>,
}

/// Format name of a reconstruction.
const FORMAT: &str = "frettrace-reconstruction";

/// Writes a reconstruction, beside `path` first and renamed when whole.
///
/// # Errors
/// [`Error::Write`].
pub fn write_reconstruction(path: impl AsRef<Path>, result: &Reconstruction) -> Result<(), Error> {
    let file = FileWriter::create(path.as_ref())?.uncompressed();
    file.text("/", "format", FORMAT)?;
    file.integer("/", "format_version", 1)?;
    file.text("/", "title", &result.title)?;
    file.group("/runs")?;
    for run in &result.runs {
        let place = format!("/runs/{}", run.id);
        file.group(&place)?;
        write_attributes(&file, &place, run)?;
        write_signals(&file, &place, run, &result.sensor_position)?;
        write_coefficients(&file, &format!("{place}/harmonics"), &run.coefficients)?;
    }
    file.finish()
}

fn write_attributes(file: &FileWriter, place: &str, run: &ReconstructedRun) -> Result<(), Error> {
    let form = match run.form {
        Form::Harmonic => "harmonic",
        Form::Subharmonic => "subharmonic",
        Form::Aperiodic => "aperiodic",
    };
    file.text(place, "label", &run.label)?;
    file.text(place, "form", form)?;
    file.integer(place, "subharmonic_order", i64::from(run.subharmonic_order))?;
    file.integer(place, "harmonics", i64::from(run.harmonics))?;
    file.number(place, "fundamental_frequency", run.fundamental_frequency)?;
    file.number(place, "acceleration_error", run.acceleration_error)?;
    file.number(place, "noise_floor", run.noise_floor)?;
    file.text(place, "unobservable", &run.unobservable.join(", "))?;
    if let Some(note) = &run.note {
        file.text(place, "note", note)?;
    }
    run.numbers.iter().try_for_each(|(name, value)| file.number(place, name, *value))
}

fn write_signals(
    file: &FileWriter,
    place: &str,
    run: &ReconstructedRun,
    position: &[f64],
) -> Result<(), Error> {
    let time = list(file, &format!("{place}/time"), &run.time, "s")?;
    file.scale(&time, "time")?;
    let all = [
        ("friction_force", Some(&run.friction_force), "N"),
        ("normal_force", Some(&run.normal_force), "N"),
        ("slip_displacement", Some(&run.slip_displacement), "m"),
        ("slip_velocity", Some(&run.slip_velocity), "m/s"),
        ("second_support_force", run.second_support_force.as_ref(), "N"),
    ];
    for (name, estimate, units) in
        all.into_iter().filter_map(|(name, estimate, units)| Some((name, estimate?, units)))
    {
        file.attach(&list(file, &format!("{place}/{name}"), &estimate.values, units)?, 0, &time)?;
        file.attach(&list(file, &format!("{place}/{name}_std"), &estimate.std, units)?, 0, &time)?;
    }
    let sensors = list(file, &format!("{place}/sensor_position"), position, "m")?;
    file.scale(&sensors, "sensor_position")?;
    let (values, std): (Vec<_>, Vec<_>) =
        run.acceleration_fit.iter().map(|fit| (fit.values.clone(), fit.std.clone())).unzip();
    for (name, columns) in [("acceleration_fit", values), ("acceleration_fit_std", std)] {
        let shape = [columns.first().map_or(0, Vec::len), columns.len()];
        let array = NewArray { shape: &shape, values: &rows(&columns), units: "m/s^2" };
        let written = file.array(&format!("{place}/{name}"), array)?;
        file.attach(&written, 0, &time)?;
        file.attach(&written, 1, &sensors)?;
    }
    Ok(())
}

fn write_coefficients(file: &FileWriter, place: &str, table: &HarmonicTable) -> Result<(), Error> {
    file.group(place)?;
    if table.frequency.is_empty() {
        return Ok(());
    }
    let frequency = list(file, &format!("{place}/frequency"), &table.frequency, "Hz")?;
    file.scale(&frequency, "frequency")?;
    for quantity in &table.quantities {
        write_quantity(file, place, quantity, &frequency)?;
    }
    Ok(())
}

fn write_quantity(
    file: &FileWriter,
    place: &str,
    quantity: &Coefficients,
    frequency: &Written,
) -> Result<(), Error> {
    let (real, imaginary): (Vec<f64>, Vec<f64>) = quantity.values.iter().map(|c| (c.re, c.im)).unzip();
    let array = NewArray { shape: &[real.len()], values: &real, units: &quantity.units };
    let name = &quantity.name;
    let written = file.complex(&format!("{place}/{name}"), array, &imaginary)?;
    file.attach(&written, 0, frequency)?;
    file.describe(&written, "convention", "x(t) = Re sum_k c_k exp(2 pi i f_k t)")?;
    if !quantity.std.is_empty() {
        file.attach(
            &list(file, &format!("{place}/{name}_std"), &quantity.std, &quantity.units)?,
            0,
            frequency,
        )?;
    }
    Ok(())
}
