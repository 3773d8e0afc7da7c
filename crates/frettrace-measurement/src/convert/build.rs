//! Runs and rigs put together from channels and the description.

use std::path::{Path, PathBuf};

use super::channels::{Place, file_name};
use super::description::{Channel, Slip};
use super::sampling::{first_not_rising, resample, uniform_rate, window};
use super::{Job, Piece, Tables};
use crate::error::{Error, Problem};
use crate::formats::Table;
use crate::measurement::{
    Beam, ContactRecord, ContactRun, Exciter, MeasuredModes, Measurement, Run, SecondSupport, Sensors,
    SlipKind, SlipUnit, Source, Support,
};
use crate::read::LAWS;
use crate::units::{
    ACCELERATION, AREA, DENSITY, Dimension, FORCE, FREQUENCY, LENGTH, MASS, NUMBER, PRESSURE, SECOND_MOMENT,
    STIFFNESS, TIME, VELOCITY,
};

/// A run shorter than this holds no period of anything.
const FEWEST_SAMPLES: usize = 8;

/// The channels of one run, cut and evenly sampled where that is asked for or already so.
struct Signals {
    time: Vec<f64>,
    /// Rate \[Hz\], where sampling is uniform.
    rate: Option<f64>,
    /// The channels in the order asked for.
    values: Vec<Vec<f64>>,
}

/// A channel wanted: its name, dimension and description.
type Wanted<'a> = (&'a str, Dimension, &'a Channel);

pub(super) fn contact_record(job: &mut Job<'_>, inputs: &[PathBuf]) -> Result<ContactRecord, Error> {
    let description = job.description;
    let slip_unit = match description.slip_unit.as_deref() {
        Some("rad") => SlipUnit::Radian,
        Some("m") | None => SlipUnit::Metre,
        Some(other) => {
            return Err(job.origin.invalid("slip_unit", unknown_word("slip_unit", other, &["m", "rad"])));
        }
    };
    let mut tables = Tables::default();
    let pieces = job.pieces(inputs)?;
    let runs = pieces.iter().map(|piece| contact_run(job, piece, tables.get(&piece.file)?, slip_unit));
    let runs = runs.collect::<Result<_, Error>>()?;
    let moving_mass = match description.moving_mass.as_deref() {
        Some("unknown") => Some(f64::NAN),
        _ => job.origin.optional("moving_mass", description.moving_mass.as_ref(), MASS)?,
    };
    Ok(ContactRecord {
        title: description.title.clone(),
        source: source(job),
        law: law(job)?,
        slip_unit,
        moving_mass,
        runs,
    })
}

/// The channels of a contact record that the description names.
fn contact_channels<'a>(job: &Job<'a>, slip_unit: SlipUnit) -> Result<Vec<Wanted<'a>>, Error> {
    let channels = &job.description.channels;
    let slip = job.origin.need("[channels] slip_displacement", channels.slip_displacement.as_ref())?;
    let (displacement, velocity, acceleration) = match slip_unit {
        SlipUnit::Metre => (LENGTH, VELOCITY, ACCELERATION),
        SlipUnit::Radian => (NUMBER, FREQUENCY, [0, 0, -2, 0]),
    };
    let all = [
        ("force", FORCE, Some(&channels.force)),
        ("slip_displacement", displacement, Some(slip)),
        ("slip_velocity", velocity, channels.slip_velocity.as_ref()),
        ("slip_acceleration", acceleration, channels.slip_acceleration.as_ref()),
        ("normal_force", FORCE, channels.normal_force.as_ref()),
    ];
    Ok(all.into_iter().filter_map(|(name, dimension, channel)| Some((name, dimension, channel?))).collect())
}

fn contact_run(
    job: &mut Job<'_>,
    piece: &Piece,
    table: &Table,
    slip_unit: SlipUnit,
) -> Result<ContactRun, Error> {
    let wanted = contact_channels(job, slip_unit)?;
    let names: Vec<&str> = wanted.iter().map(|(name, ..)| *name).collect();
    let Signals { time, rate, values } = signals(job, piece, table, &wanted)?;
    let mut values: Vec<Option<Vec<f64>>> = values.into_iter().map(Some).collect();
    let mut take =
        |name: &str| names.iter().position(|known| *known == name).and_then(|index| values[index].take());
    let run = &piece.run;
    Ok(ContactRun {
        id: piece.id.clone(),
        label: run.label.clone().unwrap_or_else(|| file_name(&piece.file)),
        preload: job.origin.optional("[[runs]] preload", run.preload.as_ref(), FORCE)?,
        force: take("force").unwrap_or_default(),
        slip_displacement: take("slip_displacement").unwrap_or_default(),
        slip_velocity: take("slip_velocity"),
        slip_acceleration: take("slip_acceleration"),
        normal_force: take("normal_force"),
        force_noise_std: job.origin.optional(
            "force_noise_std",
            job.description.force_noise_std.as_ref(),
            FORCE,
        )?,
        sampling_rate: rate,
        time,
    })
}

pub(super) fn measurement(job: &mut Job<'_>, inputs: &[PathBuf]) -> Result<Measurement, Error> {
    let description = job.description;
    let mut tables = Tables::default();
    let pieces = job.pieces(inputs)?;
    let runs = pieces.iter().map(|piece| run(job, piece, tables.get(&piece.file)?));
    let runs = runs.collect::<Result<_, Error>>()?;
    let modes = description.modes.as_ref().map(|modes| MeasuredModes {
        frequency: modes.frequency_hz.clone(),
        frequency_std: modes.frequency_std_hz.clone(),
        damping_ratio: modes.damping_ratio.clone(),
        damping_ratio_std: modes.damping_ratio_std.clone(),
    });
    let position =
        |name: &str, text: &String| job.origin.quantity(&format!("[{name}] position"), text, LENGTH);
    let exciter = job.origin.need("[exciter]", description.exciter.as_ref())?;
    let second = description.second_support.as_ref();
    let second = second.map(|place| position("second_support", &place.position)).transpose()?;
    Ok(Measurement {
        title: description.title.clone(),
        source: source(job),
        beam: beam(job)?,
        modes,
        support: support(job)?,
        second_support: second.map(|position| SecondSupport { position }),
        exciter: Exciter { position: position("exciter", &exciter.position)? },
        sensors: sensors(job)?,
        runs,
    })
}

fn run(job: &mut Job<'_>, piece: &Piece, table: &Table) -> Result<Run, Error> {
    let channels = &job.description.channels;
    let sensors: Vec<Channel> = channels.acceleration.iter().map(|sensor| sensor.channel()).collect();
    let mut wanted: Vec<Wanted<'_>> = vec![("force", FORCE, &channels.force)];
    wanted.extend(sensors.iter().map(|channel| ("acceleration", ACCELERATION, channel)));
    let Signals { rate, mut values, .. } = signals(job, piece, table, &wanted)?;
    let uneven = || invalid(&piece.file, "times", Problem::Uneven);
    let run = &piece.run;
    let frequency = job.origin.need("[[runs]] excitation_frequency", run.excitation_frequency.as_ref())?;
    let preload = job.origin.optional("[[runs]] preload", run.preload.as_ref(), FORCE)?;
    Ok(Run {
        id: piece.id.clone(),
        label: run.label.clone().unwrap_or_else(|| file_name(&piece.file)),
        sampling_rate: rate.ok_or_else(uneven)?,
        excitation_frequency: job.origin.quantity("[[runs]] excitation_frequency", frequency, FREQUENCY)?,
        preload: job.origin.need("[[runs]] preload", preload)?,
        lubricated: run.lubricated,
        temperature: run.temperature_k,
        force: values.remove(0),
        acceleration: values,
    })
}

/// Reads, cuts and, where asked for, resamples the channels of a run.
fn signals(job: &mut Job<'_>, piece: &Piece, table: &Table, wanted: &[Wanted<'_>]) -> Result<Signals, Error> {
    let file = piece.file.as_path();
    let mut whole = Vec::new();
    for &(name, dimension, channel) in wanted {
        whole.push(job.channel(Place { file, table, name, dimension }, channel)?);
    }
    let samples = whole.iter().map(Vec::len).min().unwrap_or(0);
    if let Some(longer) = whole.iter().find(|values| values.len() != samples) {
        let problem = Problem::UnequalChannels { found: samples, expected: longer.len() };
        return Err(invalid(file, "channels", problem));
    }
    let times = times(job, file, table, samples)?;
    let kept = kept(job, piece, &times)?;
    let time = times[kept.clone()].to_vec();
    let values = whole.iter().map(|values| values[kept.clone()].to_vec()).collect();
    let mut signals = evenly(job, file, Signals { rate: uniform_rate(&time), time, values })?;
    for (values, want) in signals.values.iter_mut().zip(wanted) {
        job.offset(Place { file, table, name: want.0, dimension: want.1 }, want.2, values)?;
    }
    let start = signals.time[0];
    signals.time.iter_mut().for_each(|at| *at -= start);
    Ok(signals)
}

/// The samples of a run's piece, in rising time.
fn kept(job: &Job<'_>, piece: &Piece, times: &[f64]) -> Result<std::ops::Range<usize>, Error> {
    let run = &piece.run;
    let from = job.origin.optional("[[runs]] from", run.from.as_ref(), TIME)?;
    let to = job.origin.optional("[[runs]] to", run.to.as_ref(), TIME)?;
    let kept = window(times, from, to);
    if kept.len() < FEWEST_SAMPLES {
        return Err(invalid(&piece.file, "[[runs]] from, to", Problem::EmptyPiece { samples: kept.len() }));
    }
    let Some(standing) = first_not_rising(&times[kept.clone()]) else { return Ok(kept) };
    let (index, range) = (kept.start + standing, "above the time before it".to_string());
    Err(invalid(&piece.file, "times", Problem::EntryOutOfRange { index, found: times[index], range }))
}

/// Even sampling where the description asks for it.
fn evenly(job: &mut Job<'_>, file: &Path, signals: Signals) -> Result<Signals, Error> {
    let Some(wish) = &job.description.resample else { return Ok(signals) };
    let Signals { time, values, .. } = signals;
    let rate = job.origin.quantity("[resample] rate", &wish.rate, FREQUENCY)?;
    if rate.is_nan() || rate <= 0.0 {
        let problem =
            Problem::WrongQuantity { found: wish.rate.clone(), expected: "a rate above 0 Hz".into() };
        return Err(job.origin.invalid("[resample] rate", problem));
    }
    let gap = time.windows(2).map(|pair| pair[1] - pair[0]).fold(0.0, f64::max);
    let (name, method) = (file_name(file), wish.method);
    job.remark(format!("{name}: resampled to {rate} Hz ({method:?}); the longest gap bridged is {gap:.3} s"));
    let values: Vec<Vec<f64>> = values.iter().map(|values| resample(&time, values, rate, method)).collect();
    let time = (0..values[0].len()).map(|sample| time[0] + sample as f64 / rate).collect();
    Ok(Signals { time, rate: Some(rate), values })
}

/// Times of all samples \[s\]: a column, else the stated sampling rate, else the file's own.
fn times(job: &mut Job<'_>, file: &Path, table: &Table, samples: usize) -> Result<Vec<f64>, Error> {
    if let Some(channel) = &job.description.channels.time {
        let times = job.channel(Place { file, table, name: "time", dimension: TIME }, channel)?;
        if let (Some(rate), Some(interval)) = (uniform_rate(&times), table.interval)
            && (rate * interval - 1.0).abs() > 0.01
        {
            let name = file_name(file);
            job.remark(format!(
                "{name}: its header says {} Hz, its column of times {rate:.6} Hz: the column is taken",
                1.0 / interval
            ));
        }
        return Ok(times);
    }
    let stated = job.origin.optional("sampling_rate", job.description.sampling_rate.as_ref(), FREQUENCY)?;
    let rate = stated.or(table.interval.map(|interval| 1.0 / interval));
    let rate = rate.ok_or_else(|| job.origin.invalid("sampling_rate", Problem::MissingEntry))?;
    Ok((0..samples).map(|sample| sample as f64 / rate).collect())
}

fn source(job: &Job<'_>) -> Source {
    if job.description.simulated { Source::Simulated } else { Source::Measured }
}

fn law(job: &Job<'_>) -> Result<String, Error> {
    let law = &job.description.law;
    if LAWS.contains(&law.as_str()) {
        Ok(law.clone())
    } else {
        Err(job.origin.invalid("law", unknown_word("law", law, &LAWS)))
    }
}

fn unknown_word(name: &str, found: &str, allowed: &[&str]) -> Problem {
    Problem::UnknownWord {
        name: name.into(),
        found: found.into(),
        allowed: allowed.iter().map(ToString::to_string).collect(),
    }
}

fn invalid(file: &Path, place: &str, problem: Problem) -> Error {
    Error::Invalid { file: file.to_path_buf(), place: place.into(), problem: problem.into() }
}

fn beam(job: &Job<'_>) -> Result<Beam, Error> {
    let beam = job.origin.need("[beam]", job.description.beam.as_ref())?;
    let quantity = |name: &str, text: &String, dimension| {
        job.origin.quantity(&format!("[beam] {name}"), text, dimension)
    };
    Ok(Beam {
        length: quantity("length", &beam.length, LENGTH)?,
        width: quantity("width", &beam.width, LENGTH)?,
        thickness: quantity("thickness", &beam.thickness, LENGTH)?,
        youngs_modulus: quantity("youngs_modulus", &beam.youngs_modulus, PRESSURE)?,
        density: quantity("density", &beam.density, DENSITY)?,
        area: job.origin.optional("[beam] area", beam.area.as_ref(), AREA)?,
        second_moment: job.origin.optional(
            "[beam] second_moment",
            beam.second_moment.as_ref(),
            SECOND_MOMENT,
        )?,
    })
}

fn support(job: &Job<'_>) -> Result<Support, Error> {
    let support = job.origin.need("[support]", job.description.support.as_ref())?;
    let lever_arm = job.origin.optional("[support] lever_arm", support.lever_arm.as_ref(), LENGTH)?;
    let stiffness = match support.normal_stiffness.as_deref() {
        Some("infinite") => Some(f64::INFINITY),
        _ => {
            job.origin.optional("[support] normal_stiffness", support.normal_stiffness.as_ref(), STIFFNESS)?
        }
    };
    let rotation = support.slip == Slip::Rotation;
    Ok(Support {
        position: job.origin.quantity("[support] position", &support.position, LENGTH)?,
        slip: if rotation { SlipKind::Rotation } else { SlipKind::Transverse },
        lever_arm: if rotation { job.origin.need("[support] lever_arm", lever_arm)? } else { 0.0 },
        normal_stiffness: if rotation {
            job.origin.need("[support] normal_stiffness", stiffness)?
        } else {
            stiffness.unwrap_or(0.0)
        },
        law: law(job)?,
    })
}

fn sensors(job: &Job<'_>) -> Result<Sensors, Error> {
    let all = &job.description.channels.acceleration;
    if all.is_empty() {
        return Err(job.origin.invalid("[[channels.acceleration]]", Problem::MissingEntry));
    }
    let quantity =
        |text: &String, dimension| job.origin.quantity("[[channels.acceleration]]", text, dimension);
    let position = all.iter().map(|sensor| quantity(&sensor.position, LENGTH)).collect::<Result<_, _>>()?;
    let noise: Option<Vec<&String>> = all.iter().map(|sensor| sensor.noise_std.as_ref()).collect();
    let noise = noise
        .map(|texts| texts.into_iter().map(|text| quantity(text, ACCELERATION)).collect::<Result<_, _>>());
    let named = all.iter().any(|sensor| sensor.name.is_some());
    let names = all.iter().map(|sensor| sensor.name.clone().unwrap_or_default()).collect();
    Ok(Sensors { position, noise_std: noise.transpose()?, name: named.then_some(names) })
}
