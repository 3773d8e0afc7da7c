//! The figures of an explanation.

use super::chart::{Chart, Curve, Ink, Role};
use super::words::is_contact_record;
use crate::results::{ContactCurve, ContactLoop, Explanation, ResidualShape, Waveform};

/// One figure.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Figure {
    /// Name for a file, without ending: `loop-0003`.
    pub name: String,
    /// The section of the report it stands in.
    pub section: &'static str,
    /// The picture.
    pub svg: String,
}

/// All figures of an explanation, in reading order.
#[must_use]
pub fn figures(found: &Explanation, ink: Ink) -> Vec<Figure> {
    let exhibits = &found.exhibits;
    let force = if is_contact_record(found) { "measured" } else { "recovered" };
    let loops = exhibits.loops.iter().flat_map(|run| contact_loop(run, force, ink));
    let waveforms = exhibits.waveforms.iter().flat_map(|channel| waveform(channel, ink));
    let shapes = exhibits.residual.iter().map(|shape| residual_shape(shape, ink));
    loops.chain(waveforms).chain(shapes).collect()
}

fn title(what: &str, run: &str, label: &str, held_out: bool) -> String {
    let label = if label.is_empty() { String::new() } else { format!(", {label}") };
    format!("{what}, run {run}{label}{}", if held_out { " (held out)" } else { "" })
}

/// The first point again at the end where the last one is near it: a loop is closed, a part of one is left open.
fn closed(values: &[f64], slip: &[f64]) -> Vec<f64> {
    let range = slip.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), x| (a.min(*x), b.max(*x)));
    let gap = slip.first().zip(slip.last()).map_or(0.0, |(first, last)| (first - last).abs());
    let near = gap <= 0.1 * (range.1 - range.0);
    values.iter().chain(values.first().filter(|_| near)).copied().collect()
}

fn contact_loop(run: &ContactLoop, force: &str, ink: Ink) -> Vec<Figure> {
    let draw = |name: &str, x_label: &str, of: fn(&ContactCurve) -> &[f64]| {
        let named = [
            (force, Role::Measured, &run.measured),
            ("declared model", Role::Before, &run.before),
            ("with the effects", Role::After, &run.after),
        ];
        let points =
            named.map(|(_, _, curve)| (closed(of(curve), &curve.slip), closed(&curve.force, &curve.slip)));
        let curves =
            named.iter().zip(&points).map(|((name, role, _), (x, y))| Curve { name, role: *role, x, y });
        let chart = Chart {
            title: &title("Friction", &run.run, &run.label, run.held_out),
            x_label,
            y_label: "friction force [N]",
            logarithmic: false,
            curves: curves.collect(),
        };
        Figure { name: format!("{name}-{}", run.run), section: "Friction loops", svg: chart.svg(ink) }
    };
    let mut drawn = vec![draw("loop", &format!("slip [{}]", run.slip_unit), |curve| &curve.slip)];
    if !run.measured.slip_velocity.is_empty() {
        let label = format!("slip velocity [{}/s]", run.slip_unit);
        drawn.push(draw("velocity", &label, |curve| &curve.slip_velocity));
    }
    drawn
}

fn waveform(channel: &Waveform, ink: Ink) -> Vec<Figure> {
    let residual =
        |model: &[f64]| -> Vec<f64> { channel.measured.iter().zip(model).map(|(y, m)| y - m).collect() };
    let (before, after) = (residual(&channel.before), residual(&channel.after));
    let curve = |name, role, y| Curve { name, role, x: &channel.time, y };
    let draw = |name: &str, what: &str, curves| {
        let chart = Chart {
            title: &title(what, &channel.run, &channel.label, channel.held_out),
            x_label: "time [s]",
            y_label: &channel.channel,
            logarithmic: false,
            curves,
        };
        Figure {
            name: format!("{name}-{}", channel.run),
            section: "Signals and residuals",
            svg: chart.svg(ink),
        }
    };
    vec![
        draw(
            "signal",
            "Signal",
            vec![
                curve("measured", Role::Measured, &channel.measured),
                curve("declared model", Role::Before, &channel.before),
                curve("with the effects", Role::After, &channel.after),
            ],
        ),
        draw(
            "residual",
            "Residual",
            vec![
                curve("declared model", Role::Before, &before),
                curve("with the effects", Role::After, &after),
            ],
        ),
    ]
}

fn residual_shape(shape: &ResidualShape, ink: Ink) -> Figure {
    let curve = |name, role, y| Curve { name, role, x: &shape.centre, y };
    let chart = Chart {
        title: &format!("Residual against {}", shape.against),
        x_label: &format!("{} [{}]", shape.against, shape.unit),
        y_label: "residual [standard deviations of the noise]",
        logarithmic: false,
        curves: vec![
            curve("declared model", Role::Before, &shape.before),
            curve("with the effects", Role::After, &shape.after),
        ],
    };
    let name = format!("shape-{}", shape.against.replace(' ', "-"));
    Figure { name, section: "Shape of the residual", svg: chart.svg(ink) }
}
