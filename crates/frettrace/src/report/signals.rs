//! Figures of signals: what a measurement file, a contact record or a reconstruction holds.

use super::chart::{Chart, Curve, Ink, Role};
use super::figures::Figure;
use crate::StudyError;
use frettrace_fourier::spectrum;
use frettrace_measurement::{ContactRecord, ContactRun, DataFile, Measurement, Recording, Run};

/// Points a curve shows at most: more than a page has pixels.
const POINTS: usize = 2000;

/// Figures of a recording: signals and spectra, run by run.
#[must_use]
pub fn recording(recording: &Recording, ink: Ink) -> Vec<Figure> {
    match recording {
        Recording::Measurement(measurement) => {
            measurement.runs.iter().flat_map(|run| measured(measurement, run, ink)).collect()
        }
        Recording::Contact(record) => record.runs.iter().flat_map(|run| contact(record, run, ink)).collect(),
    }
}

fn measured(measurement: &Measurement, run: &Run, ink: Ink) -> Vec<Figure> {
    let names: Vec<String> = (0..run.acceleration.len()).map(|s| sensor_name(measurement, s)).collect();
    let shown = samples_of_periods(run);
    let time: Vec<f64> = (0..shown).map(|k| k as f64 / run.sampling_rate).collect();
    let curves = run
        .acceleration
        .iter()
        .zip(&names)
        .enumerate()
        .map(|(s, (y, name))| numbered(s, name, &time, &y[..shown]));
    let signal = Chart {
        title: &format!("Accelerations, run {}", run.id),
        x_label: "time [s]",
        y_label: "acceleration [m/s²]",
        logarithmic: false,
        curves: curves.collect(),
    };
    let amplitudes: Vec<Vec<f64>> = run.acceleration.iter().map(|y| amplitudes(y)).collect();
    let samples = run.force.len();
    let frequency: Vec<f64> =
        (0..samples / 2 + 1).map(|k| k as f64 * run.sampling_rate / samples as f64).collect();
    let spectra = Chart {
        title: &format!("Spectra, run {}", run.id),
        x_label: "frequency [Hz]",
        y_label: "amplitude [m/s²]",
        logarithmic: true,
        curves: amplitudes
            .iter()
            .zip(&names)
            .enumerate()
            .map(|(s, (y, name))| numbered(s, name, &frequency, y))
            .collect(),
    };
    vec![
        Figure { name: format!("signal-{}", run.id), section: "Signals", svg: signal.svg(ink) },
        Figure { name: format!("spectrum-{}", run.id), section: "Spectra", svg: spectra.svg(ink) },
    ]
}

fn numbered<'a>(number: usize, name: &'a str, x: &'a [f64], y: &'a [f64]) -> Curve<'a> {
    Curve { name, role: Role::Number(number), x, y }
}

fn sensor_name(measurement: &Measurement, sensor: usize) -> String {
    let named = measurement.sensors.name.as_ref().and_then(|names| names.get(sensor).cloned());
    named.unwrap_or_else(|| format!("sensor {sensor}"))
}

/// Samples of the first three periods of the excitation, as far as the run goes.
fn samples_of_periods(run: &Run) -> usize {
    let samples = 3.0 * run.sampling_rate / run.excitation_frequency;
    (samples.ceil() as usize).clamp(1, run.force.len())
}

/// Amplitudes of the discrete Fourier transform without its mean, seen through a Hann window.
fn amplitudes(signal: &[f64]) -> Vec<f64> {
    let mean = signal.iter().sum::<f64>() / signal.len() as f64;
    let turn = std::f64::consts::TAU / signal.len() as f64;
    let windowed: Vec<f64> =
        signal.iter().enumerate().map(|(k, x)| (x - mean) * (1.0 - (turn * k as f64).cos())).collect();
    spectrum(&windowed).iter().map(|bin| 2.0 * bin.norm() / signal.len() as f64).collect()
}

fn contact(record: &ContactRecord, run: &ContactRun, ink: Ink) -> Vec<Figure> {
    let unit = match record.slip_unit {
        frettrace_measurement::SlipUnit::Metre => "m",
        frettrace_measurement::SlipUnit::Radian => "rad",
    };
    let force = thin(&run.force);
    let (time, slip) = (thin(&run.time), thin(&run.slip_displacement));
    let draw = |name: &str, x_label: &str, x: &[f64]| {
        let chart = Chart {
            title: &format!("Force, run {} {}", run.id, run.label),
            x_label,
            y_label: "force [N]",
            logarithmic: false,
            curves: vec![Curve { name: "measured", role: Role::Measured, x, y: &force }],
        };
        Figure { name: format!("{name}-{}", run.id), section: "Force", svg: chart.svg(ink) }
    };
    vec![draw("loop", &format!("slip [{unit}]"), &slip), draw("force", "time [s]", &time)]
}

/// Every n-th value, so that at most [`POINTS`] are left.
fn thin(values: &[f64]) -> Vec<f64> {
    let stride = values.len().div_ceil(POINTS).max(1);
    values.iter().step_by(stride).copied().collect()
}

/// Figures of a reconstruction (`REC.h5`): friction loops and the forces in time, run by run.
///
/// # Errors
/// [`StudyError::File`] when the file is not such a file.
pub fn reconstruction(file: &DataFile, ink: Ink) -> Result<Vec<Figure>, StudyError> {
    let mut figures = Vec::new();
    for run in file.groups("/runs") {
        let column = |name: &str| Ok::<_, StudyError>(file.array(&format!("/runs/{run}/{name}"))?.values);
        let (time, friction) = (column("time")?, column("friction_force")?);
        let (normal, slip, velocity) =
            (column("normal_force")?, column("slip_displacement")?, column("slip_velocity")?);
        let draw = |name: &str, x_label: &str, x: &[f64], curves: &[(&'static str, Role, &[f64])]| {
            let curve = |&(name, role, y): &(_, _, _)| Curve { name, role, x, y };
            let chart = Chart {
                title: &format!("Recovered contact, run {run}"),
                x_label,
                y_label: "force [N]",
                logarithmic: false,
                curves: curves.iter().map(curve).collect(),
            };
            Figure { name: format!("{name}-{run}"), section: "Recovered contact", svg: chart.svg(ink) }
        };
        let friction_only = [("friction force", Role::Measured, &friction[..])];
        figures.push(draw("loop", "slip [m]", &slip, &friction_only));
        figures.push(draw("velocity", "slip velocity [m/s]", &velocity, &friction_only));
        let both =
            [("friction force", Role::Measured, &friction[..]), ("normal force", Role::After, &normal[..])];
        figures.push(draw("forces", "time [s]", &time, &both));
    }
    Ok(figures)
}
