//! Figures of frequency responses: what `response` writes.

use super::chart::{Chart, Curve, Ink, Picture, Role};
use super::kind::{Figure, Kind};
use crate::StudyError;
use frettrace_measurement::{Attribute, DataFile};

/// One level of the file.
struct Level {
    name: String,
    force: f64,
    frequency: Vec<f64>,
    acceleration: Vec<Vec<f64>>,
    slip: Vec<f64>,
    stable: Vec<f64>,
}

/// Figures of frequency responses: accelerations, slip with backbone, and the backbone's damping.
///
/// # Errors
/// [`StudyError::File`] when the file is not such a file.
pub fn figures(file: &DataFile, ink: Ink) -> Result<Vec<Figure>, StudyError> {
    let levels = levels(file)?;
    let column = |name: &str| Ok::<_, StudyError>(file.array(&format!("/backbone/{name}"))?.values);
    let backbone = if file.has_dataset("/backbone/frequency") {
        [column("frequency")?, column("slip_displacement")?, column("damping_ratio")?]
    } else {
        [Vec::new(), Vec::new(), Vec::new()]
    };
    let sensors = levels.iter().map(|level| level.acceleration.len()).max().unwrap_or(0);
    let mut figures: Vec<Figure> = (0..sensors).map(|sensor| acceleration(&levels, sensor, ink)).collect();
    figures.push(slip(&levels, &backbone, ink));
    figures.push(damping(&backbone, ink));
    Ok(figures)
}

fn levels(file: &DataFile) -> Result<Vec<Level>, StudyError> {
    let groups = file.groups("/levels");
    let solved = groups.iter().filter(|id| file.has_dataset(&format!("/levels/{id}/frequency")));
    solved
        .map(|id| {
            let place = format!("/levels/{id}");
            let array = |name: &str| file.array(&format!("{place}/{name}"));
            let force = match file.attribute(&place, "force_amplitude")? {
                Some(Attribute::Numbers(force)) => force.first().copied().unwrap_or(f64::NAN),
                _ => f64::NAN,
            };
            Ok(Level {
                name: format!("{force} N"),
                force,
                frequency: array("frequency")?.values,
                acceleration: array("acceleration")?.columns(),
                slip: array("slip_displacement")?.values,
                stable: array("stable")?.values,
            })
        })
        .collect()
}

/// A response with a gap wherever it is stable.
fn unstable(level: &Level, y: &[f64]) -> Vec<f64> {
    y.iter().zip(&level.stable).map(|(&y, &stable)| if stable == 0.0 { y } else { f64::NAN }).collect()
}

/// Curves of all levels, what is unstable drawn over them in the colour of a fault.
fn draw(
    levels: &[Level],
    values: &[Vec<f64>],
    labels: [&str; 2],
    more: Option<Curve<'_>>,
    ink: Ink,
) -> Picture {
    let lost: Vec<Vec<f64>> = levels.iter().zip(values).map(|(level, y)| unstable(level, y)).collect();
    let mut curves: Vec<Curve<'_>> = Vec::new();
    for (number, (level, y)) in levels.iter().zip(values).enumerate() {
        curves.push(Curve::line(&level.name, Role::Number(number), &level.frequency, y));
    }
    let unstable = levels.iter().zip(&lost).filter(|(_, y)| y.iter().any(|y| y.is_finite()));
    for (number, (level, y)) in unstable.enumerate() {
        let name = if number == 0 { "unstable" } else { "" };
        curves.push(Curve::line(name, Role::Before, &level.frequency, y));
    }
    curves.extend(more);
    let chart = Chart {
        title: labels[0],
        x_label: "excitation frequency [Hz]",
        y_label: labels[1],
        logarithmic: true,
        curves,
    };
    chart.picture(ink)
}

fn acceleration(levels: &[Level], sensor: usize, ink: Ink) -> Figure {
    let values: Vec<Vec<f64>> = levels
        .iter()
        .map(|level| level.acceleration[sensor].iter().map(|a| a / level.force).collect())
        .collect();
    let title = format!("Acceleration a force, sensor {sensor}");
    let labels = [title.as_str(), "rms acceleration / force [m/(s² N)]"];
    let picture = draw(levels, &values, labels, None, ink);
    Figure::new(format!("response-sensor-{sensor}"), Kind::Responses, picture)
}

fn slip(levels: &[Level], [frequency, slip, _]: &[Vec<f64>; 3], ink: Ink) -> Figure {
    let values: Vec<Vec<f64>> = levels.iter().map(|level| level.slip.clone()).collect();
    let backbone = Curve::line("backbone", Role::Measured, frequency, slip);
    let labels = ["Slip at the contact", "slip amplitude [m]"];
    let picture = draw(levels, &values, labels, (!frequency.is_empty()).then_some(backbone), ink);
    Figure::new("response-slip", Kind::Responses, picture)
}

fn damping([_, slip, damping]: &[Vec<f64>; 3], ink: Ink) -> Figure {
    let shown: Vec<f64> = slip.iter().map(|slip| slip.log10()).collect();
    let chart = Chart {
        title: "Damping of the mode",
        x_label: "log10 of the slip amplitude in metres",
        y_label: "damping ratio [1]",
        logarithmic: false,
        curves: vec![Curve::line("backbone", Role::Measured, &shown, damping)],
    };
    Figure::new("backbone-damping", Kind::Responses, chart.picture(ink))
}
