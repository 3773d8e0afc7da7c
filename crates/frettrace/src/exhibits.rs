//! What the report draws, mapped from the exhibits of the explanation.

use crate::results::{ContactCurve, ContactLoop, Exhibits, ResidualShape, Waveform};
use frettrace_explain::{Exhibit, Loop};
use frettrace_measurement::Measurement;

/// Loops of all runs, the worst channel of each held-out run, and the residual against run and sensor.
#[must_use]
pub fn exhibits(measurement: &Measurement, shown: &[Exhibit], held_out: &[usize]) -> Exhibits {
    let waveforms = shown.iter().filter(|exhibit| held_out.contains(&exhibit.run));
    Exhibits {
        loops: shown.iter().map(|exhibit| contact_loop(measurement, exhibit, held_out)).collect(),
        waveforms: waveforms.map(|exhibit| waveform(measurement, exhibit)).collect(),
        residual: if shown.is_empty() { Vec::new() } else { vec![by_run(shown), by_sensor(shown)] },
    }
}

fn contact_loop(measurement: &Measurement, exhibit: &Exhibit, held_out: &[usize]) -> ContactLoop {
    let run = &measurement.runs[exhibit.run];
    let [before, after] = &exhibit.modelled;
    ContactLoop {
        run: run.id.clone(),
        label: run.label.clone(),
        held_out: held_out.contains(&exhibit.run),
        slip_unit: "m".into(),
        measured: curve(&exhibit.recovered),
        before: curve(before),
        after: curve(after),
    }
}

fn curve(given: &Loop) -> ContactCurve {
    ContactCurve {
        slip: rounded(&given.slip),
        slip_velocity: rounded(&given.velocity),
        force: rounded(&given.force),
    }
}

/// The sensor that the declared model misses most.
fn waveform(measurement: &Measurement, exhibit: &Exhibit) -> Waveform {
    let run = &measurement.runs[exhibit.run];
    let before = exhibit.residual[0].iter().enumerate();
    let sensor = before.max_by(|a, b| a.1.total_cmp(b.1)).map_or(0, |(sensor, _)| sensor);
    let [measured, before, after] =
        exhibit.acceleration.each_ref().map(|sensors| sensors.get(sensor).map_or(Vec::new(), |x| rounded(x)));
    Waveform {
        run: run.id.clone(),
        label: run.label.clone(),
        held_out: true,
        channel: format!("acceleration of sensor {sensor} [m/s²]"),
        time: rounded(&exhibit.time),
        measured,
        before,
        after,
    }
}

fn by_run(shown: &[Exhibit]) -> ResidualShape {
    let of = |side: usize| shown.iter().map(|exhibit| quadratic_mean(&exhibit.residual[side])).collect();
    ResidualShape {
        against: "run".into(),
        unit: "number".into(),
        centre: shown.iter().map(|exhibit| exhibit.run as f64 + 1.0).collect(),
        before: of(0),
        after: of(1),
    }
}

fn by_sensor(shown: &[Exhibit]) -> ResidualShape {
    let sensors = shown[0].residual[0].len();
    let of = |side: usize| {
        let of_sensor =
            |sensor: usize| shown.iter().map(|exhibit| exhibit.residual[side][sensor]).collect::<Vec<_>>();
        (0..sensors).map(|sensor| quadratic_mean(&of_sensor(sensor))).collect()
    };
    ResidualShape {
        against: "sensor".into(),
        unit: "index".into(),
        centre: (0..sensors).map(|sensor| sensor as f64).collect(),
        before: of(0),
        after: of(1),
    }
}

fn quadratic_mean(values: &[f64]) -> f64 {
    (values.iter().map(|value| value * value).sum::<f64>() / values.len().max(1) as f64).sqrt()
}

/// Six significant digits: more than a drawing shows, and half the size of the file.
fn rounded(values: &[f64]) -> Vec<f64> {
    values.iter().map(|value| format!("{value:.5e}").parse().unwrap_or(*value)).collect()
}
