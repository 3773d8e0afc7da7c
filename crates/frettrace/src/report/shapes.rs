//! Mode shapes of the declared beam on its support, with what is mounted where.

use super::chart::{Chart, Curve, Ink, Role};
use super::kind::{Figure, Kind};
use super::words::number;
use crate::{StudyError, modes::modes, reconstruct::rig};
use frettrace_measurement::Measurement;

/// Points of a shape.
const POINTS: usize = 200;
/// Modes drawn where fewer were measured, and at most.
const DRAWN: std::ops::RangeInclusive<usize> = 3..=5;

/// Colours of up to five modes, far apart in the order of the spectrum.
fn hue(mode: usize) -> Role {
    Role::Number(7 * mode / 4)
}

/// Shapes over their largest deflection, dots at the sensors.
pub(super) fn figure(measurement: &Measurement, ink: Ink) -> Result<Figure, StudyError> {
    let structure = rig(measurement)?.structure;
    let listed = modes(measurement)?;
    let measured = listed.iter().filter(|mode| mode.measured_hz.is_some()).count();
    let count = measured.clamp(*DRAWN.start(), *DRAWN.end()).min(structure.shapes().len());
    let length = measurement.beam.length;
    let along: Vec<f64> = (0..=POINTS).map(|k| length * k as f64 / POINTS as f64).collect();
    let sensors = &measurement.sensors.position;
    let shapes = structure.shapes().iter().take(count).enumerate().map(|(index, shape)| {
        let at = |x: &f64| shape.derivatives(*x)[0];
        let largest = along.iter().map(|x| at(x).abs()).fold(f64::MIN_POSITIVE, f64::max);
        let over = |places: &[f64]| -> Vec<f64> { places.iter().map(|x| at(x) / largest).collect() };
        let frequency =
            listed.get(index).map_or(f64::NAN, |mode| mode.measured_hz.unwrap_or(mode.declared_hz));
        let source =
            if listed.get(index).is_some_and(|mode| mode.measured_hz.is_some()) { "" } else { " (declared)" };
        (format!("{} Hz{source}", number(frequency)), over(&along), over(sensors))
    });
    let shapes: Vec<(String, Vec<f64>, Vec<f64>)> = shapes.collect();
    let exciter = [measurement.exciter.position; 2];
    let supports: Vec<f64> = std::iter::once(measurement.support.position)
        .chain(measurement.second_support.map(|second| second.position))
        .collect();
    let zeros = vec![0.0; supports.len()];
    let mut curves: Vec<Curve<'_>> = Vec::new();
    for (number, (name, shape, _)) in shapes.iter().enumerate() {
        curves.push(Curve::line(name, hue(number), &along, shape));
    }
    for (number, (_, _, dots)) in shapes.iter().enumerate() {
        curves.push(Curve::dots("", hue(number), sensors, dots));
    }
    curves.push(Curve::dots("support", Role::Measured, &supports, &zeros));
    curves.push(Curve::dashed("exciter", Role::Floor, &exciter, &[-1.0, 1.0]));
    let chart = Chart {
        title: "Mode shapes of the declared beam; dots: sensors",
        x_label: "position along the beam [m]",
        y_label: "deflection over its largest [1]",
        logarithmic: false,
        curves,
    };
    Ok(Figure::new("modes", Kind::Modes, chart.picture(ink)))
}
