//! The measurement file.

use super::LAWS;
use super::fields::{Fields, run_names};
use crate::error::{Error, Problem};
use crate::hdf5::DataFile;
use crate::measurement::{
    Beam, Exciter, MeasuredModes, Measurement, Run, SecondSupport, Sensors, SlipKind, Source, Support,
};

/// Positions are given with rounding: a support at the end may stand this share beyond it.
const BEYOND_END: f64 = 1e-6;
/// Fewer samples than this hold no period of anything.
const FEWEST_SAMPLES: usize = 8;

pub(super) fn read(file: &DataFile) -> Result<Measurement, Error> {
    let root = Fields::new(file, "/");
    let beam = beam(file)?;
    let sensors = sensors(file, beam.length)?;
    let count = sensors.position.len();
    let runs = run_names(file)?.into_iter().map(|name| run(file, name, count));
    Ok(Measurement {
        title: root.optional_text("title")?.unwrap_or_default(),
        source: source(&root)?,
        modes: modes(file)?,
        support: support(file, beam.length)?,
        second_support: second_support(file, beam.length)?,
        exciter: Exciter { position: position(&Fields::required(file, "/exciter")?, beam.length)? },
        runs: runs.collect::<Result<_, _>>()?,
        sensors,
        beam,
    })
}

pub(super) fn source(root: &Fields<'_>) -> Result<Source, Error> {
    let word = root.word("source", &["measured", "simulated"])?;
    Ok(if word == "simulated" { Source::Simulated } else { Source::Measured })
}

fn beam(file: &DataFile) -> Result<Beam, Error> {
    let group = Fields::required(file, "/beam")?;
    Ok(Beam {
        length: group.positive("length")?,
        width: group.positive("width")?,
        thickness: group.positive("thickness")?,
        youngs_modulus: group.positive("youngs_modulus")?,
        density: group.positive("density")?,
        area: group.optional_positive("area")?,
        second_moment: group.optional_positive("second_moment")?,
    })
}

fn modes(file: &DataFile) -> Result<Option<MeasuredModes>, Error> {
    if !file.has_group("/beam/modes") {
        return Ok(None);
    }
    let group = Fields::new(file, "/beam/modes");
    let frequency = group.list("frequency", "Hz", None)?;
    let count = frequency.len();
    group.entries("frequency", &frequency, "above 0", |value| value > 0.0)?;
    let falling = frequency.windows(2).position(|pair| pair[1] <= pair[0]).map(|at| at + 1);
    if let Some(index) = falling {
        let range = "above the entry before it".to_string();
        return Err(
            group.invalid_in("frequency", Problem::EntryOutOfRange { index, found: frequency[index], range })
        );
    }
    let damping_ratio = group.list("damping_ratio", "1", Some(count))?;
    group
        .entries("damping_ratio", &damping_ratio, "from 0 to below 1", |value| (0.0..1.0).contains(&value))?;
    let frequency_std = group.optional_list("frequency_std", "Hz", Some(count))?.unwrap_or_default();
    group.entries("frequency_std", &frequency_std, "0 or above", |value| value >= 0.0)?;
    let damping_ratio_std = group.optional_list("damping_ratio_std", "1", Some(count))?.unwrap_or_default();
    group.entries("damping_ratio_std", &damping_ratio_std, "0 or above", |value| value >= 0.0)?;
    Ok((count > 0).then_some(MeasuredModes { frequency, frequency_std, damping_ratio, damping_ratio_std }))
}

/// The attribute `position`, on the beam and off its clamp.
fn position(group: &Fields<'_>, length: f64) -> Result<f64, Error> {
    let value = group.number("position")?;
    let fits = value > 0.0 && value <= length * (1.0 + BEYOND_END);
    group.check("position", value, fits, &format!("above 0 and at most the beam's length, {length} m"))?;
    Ok(value)
}

fn support(file: &DataFile, length: f64) -> Result<Support, Error> {
    let group = Fields::required(file, "/support")?;
    let position = position(&group, length)?;
    let rotation = group.word("slip", &["rotation", "transverse"])? == "rotation";
    let (slip, lever_arm, normal_stiffness) = if rotation {
        let stiffness = group.number("normal_stiffness")?;
        group.check(
            "normal_stiffness",
            stiffness,
            stiffness > 0.0,
            "above 0, or infinite for a pinned end",
        )?;
        (SlipKind::Rotation, group.positive("lever_arm")?, stiffness)
    } else {
        let stiffness = group.optional_number("normal_stiffness")?.unwrap_or(0.0);
        group.check("normal_stiffness", stiffness, stiffness >= 0.0, "0 or above")?;
        (SlipKind::Transverse, 0.0, stiffness)
    };
    Ok(Support { position, slip, lever_arm, normal_stiffness, law: group.word("law", &LAWS)? })
}

fn second_support(file: &DataFile, length: f64) -> Result<Option<SecondSupport>, Error> {
    if !file.has_group("/second_support") {
        return Ok(None);
    }
    Ok(Some(SecondSupport { position: position(&Fields::new(file, "/second_support"), length)? }))
}

fn sensors(file: &DataFile, length: f64) -> Result<Sensors, Error> {
    let group = Fields::required(file, "/sensors")?;
    let position = group.list("position", "m", None)?;
    if position.is_empty() {
        let problem = Problem::WrongShape { found: vec![0], expected: "(S), one position a sensor".into() };
        return Err(group.invalid_in("position", problem));
    }
    let range = format!("above 0 and at most the beam's length, {length} m");
    group.entries("position", &position, &range, |x| x > 0.0 && x <= length * (1.0 + BEYOND_END))?;
    if let Some((first, second)) = equal_pair(&position) {
        let problem = Problem::Duplicate { first, second, value: position[first] };
        return Err(group.invalid_in("position", problem));
    }
    let count = position.len();
    let noise_std = group.optional_list("noise_std", "m/s^2", Some(count))?;
    group.entries("noise_std", noise_std.as_deref().unwrap_or_default(), "above 0", |value| value > 0.0)?;
    let name = group.texts("name")?;
    if let Some(found) = name.as_ref().map(Vec::len).filter(|&found| found != count) {
        let problem =
            Problem::WrongShape { found: vec![found], expected: format!("({count}), one name a sensor") };
        return Err(group.invalid_in("name", problem));
    }
    Ok(Sensors { position, noise_std, name })
}

fn equal_pair(values: &[f64]) -> Option<(usize, usize)> {
    let pairs = (0..values.len()).flat_map(|second| (0..second).map(move |first| (first, second)));
    pairs.into_iter().find(|&(first, second)| values[first] == values[second])
}

fn run(file: &DataFile, id: String, sensors: usize) -> Result<Run, Error> {
    let group = Fields::new(file, format!("/runs/{id}"));
    let sampling_rate = group.positive("sampling_rate")?;
    let excitation_frequency = group.positive("excitation_frequency")?;
    let range = format!("below half the sampling rate, {} Hz", sampling_rate / 2.0);
    group.check(
        "excitation_frequency",
        excitation_frequency,
        excitation_frequency < sampling_rate / 2.0,
        &range,
    )?;
    let preload = group.number("preload")?;
    group.check("preload", preload, preload.is_finite() && preload >= 0.0, "0 or above")?;
    let array = group.array("acceleration", "m/s^2")?;
    if array.shape.len() != 2 || array.shape[1] != sensors || array.shape[0] < FEWEST_SAMPLES {
        let expected =
            format!("(n, {sensors}), a row a sample and a column a sensor, n at least {FEWEST_SAMPLES}");
        return Err(group.invalid_in("acceleration", Problem::WrongShape { found: array.shape, expected }));
    }
    group.finite("acceleration", &array)?;
    Ok(Run {
        label: group.optional_text("label")?.unwrap_or_default(),
        sampling_rate,
        excitation_frequency,
        preload,
        lubricated: group.optional_number("lubricated")?.map(|value| value != 0.0),
        temperature: group.optional_positive("temperature")?,
        force: group.list("force", "N", Some(array.shape[0]))?,
        acceleration: array.columns(),
        id,
    })
}
