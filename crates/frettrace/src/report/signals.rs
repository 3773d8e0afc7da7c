//! Figures of what was recorded: a measurement file or a contact record.

use super::chart::{Chart, Curve, Ink, Role};
use super::kind::{Figure, Kind, title};
use super::{shapes, spectra};
use crate::StudyError;
use frettrace_measurement::{ContactRecord, ContactRun, Measurement, Run, SlipUnit};

/// Points a curve shows at most: more than a page has pixels.
const POINTS: usize = 2000;
/// Periods of the excitation that a waveform shows.
pub(super) const PERIODS: f64 = 3.0;

/// Figures of a measurement file: signals and spectra, run by run, and the modes.
///
/// # Errors
/// [`StudyError`] where the declared beam is out of range.
pub fn measurement(measurement: &Measurement, ink: Ink) -> Result<Vec<Figure>, StudyError> {
    let names: Vec<String> =
        (0..measurement.sensors.position.len()).map(|s| sensor_name(measurement, s)).collect();
    let runs = measurement.runs.iter().flat_map(|run| {
        [accelerations(run, &names, ink), spectra::accelerations(measurement, run, &names, ink)]
    });
    let mut figures: Vec<Figure> = runs.collect();
    figures.push(shapes::figure(measurement, ink)?);
    Ok(figures)
}

fn accelerations(run: &Run, names: &[String], ink: Ink) -> Figure {
    let samples = PERIODS * run.sampling_rate / run.excitation_frequency;
    let shown = (samples.ceil() as usize).clamp(1, run.force.len());
    let time: Vec<f64> = (0..shown).map(|k| k as f64 / run.sampling_rate).collect();
    let sensors = run.acceleration.iter().zip(names).enumerate();
    let curves = sensors
        .map(|(number, (y, name))| Curve::line(name, Role::Number(number), &time, &y[..shown]))
        .collect();
    let chart = Chart {
        title: &title("Accelerations", &run.id, &run.label, false),
        x_label: "time [s]",
        y_label: "acceleration [m/s²]",
        logarithmic: false,
        curves,
    };
    Figure::new(format!("signal-{}", run.id), Kind::Signals, chart.picture(ink))
}

/// The sensor's name, or its index.
pub(super) fn sensor_name(measurement: &Measurement, sensor: usize) -> String {
    let named = measurement.sensors.name.as_ref().and_then(|names| names.get(sensor).cloned());
    named.unwrap_or_else(|| format!("sensor {sensor}"))
}

/// Figures of a contact record: loops, force in time and its spectrum, run by run.
#[must_use]
pub fn contact(record: &ContactRecord, ink: Ink) -> Vec<Figure> {
    record.runs.iter().flat_map(|run| contact_run(record, run, ink)).collect()
}

fn contact_run(record: &ContactRecord, run: &ContactRun, ink: Ink) -> Vec<Figure> {
    let unit = if record.slip_unit == SlipUnit::Radian { "rad" } else { "m" };
    let force = thin(&run.force);
    let draw = |(name, kind): (&str, Kind), x_label: &str, x: &[f64]| {
        let x = thin(x);
        let chart = Chart {
            title: &title("Force", &run.id, &run.label, false),
            x_label,
            y_label: "force [N]",
            logarithmic: false,
            curves: vec![Curve::line("measured", Role::Measured, &x, &force)],
        };
        Figure::new(format!("{name}-{}", run.id), kind, chart.picture(ink))
    };
    let mut figures = vec![draw(("loop", Kind::Loops), &format!("slip [{unit}]"), &run.slip_displacement)];
    if let Some(velocity) = &run.slip_velocity {
        figures.push(draw(("velocity", Kind::Loops), &format!("slip velocity [{unit}/s]"), velocity));
    }
    figures.push(draw(("force", Kind::Signals), "time [s]", &run.time));
    figures.extend(spectra::force(run, ink));
    figures
}

/// Every n-th value, so that at most [`POINTS`] are left.
pub(super) fn thin(values: &[f64]) -> Vec<f64> {
    let stride = values.len().div_ceil(POINTS).max(1);
    values.iter().step_by(stride).copied().collect()
}
