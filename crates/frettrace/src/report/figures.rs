//! The figures of an explanation.

use super::chart::{Chart, Curve, Ink, Role};
use super::kind::{Figure, Kind, title};
use super::words::is_contact_record;
use super::{identified, residuals, spectra};
use crate::results::{ContactCurve, ContactLoop, Explanation, Waveform};

/// All figures of an explanation, in reading order.
#[must_use]
pub fn figures(found: &Explanation, ink: Ink) -> Vec<Figure> {
    let exhibits = &found.exhibits;
    let view = View { named: !found.effects.is_empty(), contact: is_contact_record(found), ink };
    let loops = exhibits.loops.iter().flat_map(|run| contact_loop(run, view));
    let waveforms = exhibits.waveforms.iter().flat_map(|channel| waveform(channel, view));
    let mut all: Vec<Figure> = loops.chain(waveforms).collect();
    all.extend(exhibits.spectra.iter().map(|of| spectra::explained(of, view.named, ink)));
    all.extend(residuals::figures(exhibits, view.named, ink));
    all.extend(identified::explained(found, ink));
    all
}

/// How an explanation is drawn.
#[derive(Clone, Copy)]
struct View {
    /// Whether effects were named: without them there is one model, and one curve of it.
    named: bool,
    /// Whether the contact itself was measured.
    contact: bool,
    ink: Ink,
}

/// The first point again at the end where the last one is near it: a loop is closed, a part of one is left open.
fn closed(values: &[f64], slip: &[f64]) -> Vec<f64> {
    let range = slip.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), x| (a.min(*x), b.max(*x)));
    let gap = slip.first().zip(slip.last()).map_or(0.0, |(first, last)| (first - last).abs());
    let near = gap <= 0.1 * (range.1 - range.0);
    values.iter().chain(values.first().filter(|_| near)).copied().collect()
}

fn contact_loop(run: &ContactLoop, view: View) -> Vec<Figure> {
    let force = if view.contact { "measured" } else { "recovered" };
    let named = [
        (force, Role::Measured, &run.measured),
        ("declared model", Role::Before, &run.before),
        ("with the effects", Role::After, &run.after),
    ];
    let named = &named[..if view.named { 3 } else { 2 }];
    let draw = |name: &str, x_label: &str, of: fn(&ContactCurve) -> &[f64]| {
        let points: Vec<_> = named
            .iter()
            .map(|(_, _, curve)| (closed(of(curve), &curve.slip), closed(&curve.force, &curve.slip)))
            .collect();
        let curves =
            named.iter().zip(&points).map(|((name, role, _), (x, y))| Curve::line(name, *role, x, y));
        let chart = Chart {
            title: &title("Friction", &run.run, &run.label, run.held_out),
            x_label,
            y_label: "friction force [N]",
            logarithmic: false,
            curves: curves.collect(),
        };
        Figure::new(format!("{name}-{}", run.run), Kind::Loops, chart.picture(view.ink))
    };
    let mut drawn = vec![draw("loop", &format!("slip [{}]", run.slip_unit), |curve| &curve.slip)];
    if !run.measured.slip_velocity.is_empty() {
        let label = format!("slip velocity [{}/s]", run.slip_unit);
        drawn.push(draw("velocity", &label, |curve| &curve.slip_velocity));
    }
    drawn
}

fn waveform(channel: &Waveform, view: View) -> Vec<Figure> {
    let residual =
        |model: &[f64]| -> Vec<f64> { channel.measured.iter().zip(model).map(|(y, m)| y - m).collect() };
    let (before, after) = (residual(&channel.before), residual(&channel.after));
    let curve = |name, role, y| Curve::line(name, role, &channel.time, y);
    let draw = |name: &str, what: &str, mut curves: Vec<Curve<'_>>| {
        if !view.named {
            curves.pop();
        }
        let chart = Chart {
            title: &title(what, &channel.run, &channel.label, channel.held_out),
            x_label: "time [s]",
            y_label: &channel.channel,
            logarithmic: false,
            curves,
        };
        Figure::new(format!("{name}-{}", channel.run), Kind::Signals, chart.picture(view.ink))
    };
    let origin = if channel.is_recovered { "recovered" } else { "measured" };
    let signal = vec![
        curve(origin, Role::Measured, &channel.measured),
        curve("declared model", Role::Before, &channel.before),
        curve("with the effects", Role::After, &channel.after),
    ];
    let left =
        vec![curve("declared model", Role::Before, &before), curve("with the effects", Role::After, &after)];
    vec![draw("signal", "Signal", signal), draw("residual", "Residual", left)]
}
