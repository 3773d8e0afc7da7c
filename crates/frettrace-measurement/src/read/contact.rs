//! The contact record.

use super::fields::{Fields, run_names};
use super::{LAWS, measured};
use crate::error::{Error, Problem};
use crate::hdf5::DataFile;
use crate::measurement::{ContactRecord, ContactRun, SlipUnit};

const FEWEST_SAMPLES: usize = 8;

pub(super) fn read(file: &DataFile) -> Result<ContactRecord, Error> {
    let root = Fields::new(file, "/");
    let contact = Fields::required(file, "/contact")?;
    let unit = contact.word("slip_unit", &["m", "rad"])?;
    let moving_mass = contact.optional_number("moving_mass")?;
    let mass_fits = moving_mass.is_none_or(|mass| mass.is_nan() || (mass.is_finite() && mass >= 0.0));
    contact.check(
        "moving_mass",
        moving_mass.unwrap_or(0.0),
        mass_fits,
        "0 or above, or NaN where it is wanted",
    )?;
    let runs = run_names(file)?.into_iter().map(|name| run(file, name, &unit));
    Ok(ContactRecord {
        title: root.optional_text("title")?.unwrap_or_default(),
        source: measured::source(&root)?,
        law: contact.word("law", &LAWS)?,
        slip_unit: if unit == "rad" { SlipUnit::Radian } else { SlipUnit::Metre },
        moving_mass,
        runs: runs.collect::<Result<_, _>>()?,
    })
}

fn run(file: &DataFile, id: String, unit: &str) -> Result<ContactRun, Error> {
    let group = Fields::new(file, format!("/runs/{id}"));
    let force = group.list("force", "N", None)?;
    let count = force.len();
    if count < FEWEST_SAMPLES {
        let expected = format!("(n), n at least {FEWEST_SAMPLES}");
        return Err(group.invalid_in("force", Problem::WrongShape { found: vec![count], expected }));
    }
    let preload = group.optional_number("preload")?;
    group.check(
        "preload",
        preload.unwrap_or(0.0),
        preload.is_none_or(|n| n.is_finite() && n >= 0.0),
        "0 or above",
    )?;
    let sampling_rate = group.optional_positive("sampling_rate")?;
    let optional = |name: &str, units: &str| group.optional_list(name, units, Some(count));
    Ok(ContactRun {
        label: group.optional_text("label")?.unwrap_or_default(),
        preload,
        time: time(&group, sampling_rate, count)?,
        sampling_rate,
        slip_displacement: group.list("slip_displacement", unit, Some(count))?,
        slip_velocity: optional("slip_velocity", &format!("{unit}/s"))?,
        slip_acceleration: optional("slip_acceleration", &format!("{unit}/s^2"))?,
        normal_force: optional("normal_force", "N")?,
        force_noise_std: group.optional_positive("force_noise_std")?,
        force,
        id,
    })
}

/// The time of every sample: the dataset where there is one, else from the sampling rate.
fn time(group: &Fields<'_>, sampling_rate: Option<f64>, count: usize) -> Result<Vec<f64>, Error> {
    if let Some(time) = group.optional_list("time", "s", Some(count))? {
        let standing = time.windows(2).position(|pair| pair[1] <= pair[0]).map(|at| at + 1);
        return match standing {
            None => Ok(time),
            Some(index) => {
                let range = "above the entry before it".into();
                Err(group.invalid_in("time", Problem::EntryOutOfRange { index, found: time[index], range }))
            }
        };
    }
    let rate = sampling_rate
        .ok_or_else(|| group.missing("sampling_rate", "in Hz, or give a dataset `time` in s"))?;
    Ok((0..count).map(|sample| sample as f64 / rate).collect())
}
