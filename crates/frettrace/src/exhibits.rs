//! What the report draws, mapped from the exhibits of the explanation.

use crate::report::spectra::{self, Channel, Residual};
use crate::results::{
    ChannelSpectrum, ContactCurve, ContactLoop, Exhibits, ResidualMap, ResidualShape, Waveform,
};
use frettrace_explain::aperiodic::WholeExhibit;
use frettrace_explain::{Exhibit, Loop, Shape, maps, shapes};
use frettrace_measurement::{Measurement, Run};

/// Most runs whose spectra are shown.
pub(crate) const SPECTRA: usize = 4;

/// Loops of all runs, the worst channel of each held-out run, and the shape of the residual.
#[must_use]
pub fn exhibits(measurement: &Measurement, shown: &[Exhibit], held_out: &[usize]) -> Exhibits {
    let unseen = || shown.iter().filter(|exhibit| held_out.contains(&exhibit.run));
    let looped = |exhibit: &Exhibit| {
        let sides = (&exhibit.recovered, &exhibit.modelled);
        contact_loop(&measurement.runs[exhibit.run], held_out.contains(&exhibit.run), sides)
    };
    Exhibits {
        contact_is_measured: false,
        loops: shown.iter().map(looped).collect(),
        waveforms: unseen().map(|exhibit| waveform(measurement, exhibit)).collect(),
        spectra: unseen().take(SPECTRA).map(|exhibit| spectrum(measurement, exhibit)).collect(),
        residual: shapes(shown).into_iter().map(shape).collect(),
        maps: maps(shown).into_iter().map(map).collect(),
    }
}

/// Loops of runs without a period, each the cycle of its largest slip, and the force of the held-out ones in time.
#[must_use]
pub fn whole_exhibits(measurement: &Measurement, shown: &[WholeExhibit]) -> Exhibits {
    let unseen = shown.iter().filter(|exhibit| exhibit.held_out);
    let looped = |exhibit: &WholeExhibit| {
        contact_loop(
            &measurement.runs[exhibit.run],
            exhibit.held_out,
            (&exhibit.recovered, &exhibit.modelled),
        )
    };
    Exhibits {
        loops: shown.iter().map(looped).collect(),
        waveforms: unseen.map(|exhibit| whole_force(measurement, exhibit)).collect(),
        ..Exhibits::default()
    }
}

fn whole_force(measurement: &Measurement, exhibit: &WholeExhibit) -> Waveform {
    let run = &measurement.runs[exhibit.run];
    let [before, after] = exhibit.modelled.each_ref().map(|of| rounded(&of.force));
    Waveform {
        run: run.id.clone(),
        label: run.label.clone(),
        held_out: true,
        channel: "force [N]".to_owned(),
        is_recovered: true,
        time: rounded(&exhibit.time),
        measured: rounded(&exhibit.recovered.force),
        before,
        after,
    }
}

/// A run's loop, recovered and under both models.
fn contact_loop(run: &Run, held_out: bool, (recovered, [before, after]): (&Loop, &[Loop; 2])) -> ContactLoop {
    ContactLoop {
        run: run.id.clone(),
        label: run.label.clone(),
        held_out,
        slip_unit: "m".into(),
        measured: curve(recovered),
        before: curve(before),
        after: curve(after),
    }
}

fn curve(given: &Loop) -> ContactCurve {
    ContactCurve {
        slip: rounded(&given.slip),
        slip_velocity: rounded(&given.velocity),
        force: rounded(&given.force),
        energy_per_cycle_j: given.energy,
    }
}

/// The sensor that the declared model misses most.
fn worst(exhibit: &Exhibit) -> usize {
    let before = exhibit.residual[0].iter().enumerate();
    before.max_by(|a, b| a.1.total_cmp(b.1)).map_or(0, |(sensor, _)| sensor)
}

/// The whole record of that sensor, and the lines that the models leave of one period.
fn spectrum(measurement: &Measurement, exhibit: &Exhibit) -> ChannelSpectrum {
    let run = &measurement.runs[exhibit.run];
    let sensor = worst(exhibit);
    let [measured, before, after] = &exhibit.acceleration;
    let left = [before, after].map(|model| -> Vec<f64> {
        let pairs = measured.get(sensor).into_iter().flatten().zip(model.get(sensor).into_iter().flatten());
        pairs.map(|(y, m)| y - m).collect()
    });
    let step = exhibit.time.get(1).copied().unwrap_or(f64::NAN);
    let period = step * exhibit.time.len() as f64;
    let channel = Channel {
        signal: &run.acceleration[sensor],
        sampling_rate: run.sampling_rate,
        noise_std: measurement.sensors.noise_std.as_ref().and_then(|std| std.get(sensor).copied()),
        residual: left.each_ref().map(|left| Residual::Period(left, period)),
    };
    ChannelSpectrum {
        run: run.id.clone(),
        label: run.label.clone(),
        held_out: true,
        channel: format!("acceleration of sensor {sensor} [m/s²]"),
        ..spectra::channel(&channel)
    }
}

/// One period of that sensor.
fn waveform(measurement: &Measurement, exhibit: &Exhibit) -> Waveform {
    let run = &measurement.runs[exhibit.run];
    let sensor = worst(exhibit);
    let [measured, before, after] =
        exhibit.acceleration.each_ref().map(|sensors| sensors.get(sensor).map_or(Vec::new(), |x| rounded(x)));
    Waveform {
        run: run.id.clone(),
        label: run.label.clone(),
        held_out: true,
        channel: format!("acceleration of sensor {sensor} [m/s²]"),
        is_recovered: false,
        time: rounded(&exhibit.time),
        measured,
        before,
        after,
    }
}

fn shape(given: Shape) -> ResidualShape {
    let [before, after] = given.residual;
    ResidualShape {
        against: given.against.into(),
        unit: given.unit.into(),
        centre: rounded(&given.centre),
        before: rounded(&before),
        after: rounded(&after),
    }
}

fn map(given: frettrace_explain::ResidualMap) -> ResidualMap {
    let [before, after] = given.residual.map(|rows| rows.iter().map(|row| rounded(row)).collect());
    ResidualMap {
        across: given.across.name.into(),
        across_unit: given.across.unit.into(),
        x: rounded(&given.across.centre),
        up: given.up.name.into(),
        up_unit: given.up.unit.into(),
        y: rounded(&given.up.centre),
        before,
        after,
    }
}

/// Six significant digits: more than a drawing shows, and half the size of the file.
pub(crate) fn rounded(values: &[f64]) -> Vec<f64> {
    values.iter().map(|value| format!("{value:.5e}").parse().unwrap_or(*value)).collect()
}
