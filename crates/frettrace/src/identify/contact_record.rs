//! A contact record: motion and force measured in the contact itself.

use super::estimates::{estimate, remark};
use crate::results::{ErrorSummary, HeldOut, Identification, NoiseFloorSource, Provenance, Step};
use crate::{Progress, StudyError};
use frettrace_identify::contact::{
    ContactFit, ContactHistory, ContactModel, ContactSettings, Extras, Family, FloorSource, PreparedRun,
    RawRun, compare, identify_contact,
};
use frettrace_measurement::{ContactRecord, ContactRun, SlipUnit};
use rayon::prelude::*;
use std::collections::BTreeMap;

/// Seed of the draws of slip noise.
pub(crate) const SEED: u64 = 1;

/// A record ready to be fitted.
struct Prepared {
    training: Vec<ContactHistory>,
    held_out: Vec<ContactHistory>,
    training_runs: Vec<String>,
    held_out_runs: Vec<String>,
    /// Floor of the training part and of the held-out part (N), and where it comes from.
    floor: [f64; 2],
    source: FloorSource,
    settings: ContactSettings,
}

/// Identifies one law, or the best of several, on a contact record.
pub(super) fn identify(
    record: &ContactRecord,
    families: &[Family],
    progress: &Progress,
) -> Result<Identification, StudyError> {
    progress.start(families.len() as u64 + 1, "identify");
    let prepared = prepare(record);
    progress.step();
    let training: Vec<&ContactHistory> = prepared.training.iter().collect();
    let mut fits: Vec<ContactFit> = Vec::new();
    for family in families {
        let fitted = fits.iter().map(|fit| (fit.family, fit.law_values())).collect();
        let settings = ContactSettings { fitted, ..prepared.settings.clone() };
        fits.push(identify_contact(*family, &training, &settings)?);
        progress.step();
    }
    progress.finish();
    let modelled: Vec<(ContactFit, ContactModel<'_>)> =
        fits.into_iter().map(|fit| (fit.clone(), model_of(&fit, &prepared.training, &prepared))).collect();
    let held_out: Vec<f64> = modelled.iter().map(|(fit, _)| held_out_error(fit, &prepared)).collect();
    let ranking = compare(&modelled, &held_out, prepared.floor[0]);
    let best = ranking.candidates.first().map(|c| c.name);
    let mut notes = comparison(&ranking);
    let place = modelled.iter().position(|(fit, _)| Some(fit.family) == best).unwrap_or(0);
    let (fit, _) = &modelled[place];
    let mut found = described(record, fit, &prepared);
    found.held_out = Some(HeldOut {
        error: summary(held_out[place], &prepared.held_out, (prepared.floor[1], prepared.source)),
        runs: prepared.held_out_runs.clone(),
    })
    .filter(|_| !prepared.held_out.is_empty());
    found.notes.append(&mut notes);
    Ok(found)
}

fn prepare(record: &ContactRecord) -> Prepared {
    let newtons = in_newtons(record);
    let runs: Vec<PreparedRun> = record
        .runs
        .par_iter()
        .enumerate()
        .map(|(k, run)| PreparedRun::new(&raw(run, newtons), SEED + k as u64))
        .collect();
    let held: Vec<bool> = held_out(&runs);
    let source = runs.first().map_or(FloorSource::Estimated, |r| r.floor_source);
    let mut prepared = Prepared {
        training: Vec::new(),
        held_out: Vec::new(),
        training_runs: Vec::new(),
        held_out_runs: Vec::new(),
        floor: [0.0; 2],
        source,
        settings: ContactSettings { extras: extras(record), ..ContactSettings::default() },
    };
    let by_cycles = held.iter().all(|h| !h);
    let mut squares = [[0.0; 2]; 2];
    for ((run, id), held) in runs.iter().zip(record.runs.iter().map(|r| r.id.clone())).zip(held) {
        let whole = 0..run.history.len();
        let (training, rest) = if by_cycles {
            run.split()
        } else if held {
            (0..0, whole)
        } else {
            (whole, 0..0)
        };
        for (place, range) in [training, rest].into_iter().enumerate() {
            squares[place][0] += run.floor.powi(2) * range.len() as f64;
            squares[place][1] += range.len() as f64;
            if !range.is_empty() {
                let part = run.part(range);
                let (histories, names) = if place == 0 {
                    (&mut prepared.training, &mut prepared.training_runs)
                } else {
                    (&mut prepared.held_out, &mut prepared.held_out_runs)
                };
                histories.push(part);
                names.push(if by_cycles { format!("{id} ({})", PARTS[place]) } else { id.clone() });
            }
        }
    }
    prepared.floor = squares.map(|[sum, count]| (sum / f64::max(count, 1.0)).sqrt());
    prepared
}

/// Names of the parts of a run that is split.
pub(crate) const PARTS: [&str; 2] = ["first two thirds of its cycles", "last third of its cycles"];

/// Which runs are held out: one in four, in the inner levels of amplitude, or of load or speed where amplitudes are
/// alike; none where there are fewer than four.
pub(crate) fn held_out(runs: &[PreparedRun]) -> Vec<bool> {
    let mut held = vec![false; runs.len()];
    if runs.len() < 4 {
        return held;
    }
    let levels: [fn(&ContactHistory) -> f64; 3] =
        [ContactHistory::amplitude, ContactHistory::mean_normal, ContactHistory::top_speed];
    // A twentieth is what the amplitude of one drive may scatter by.
    let varies = |level: &fn(&ContactHistory) -> f64| {
        let of = runs.iter().map(|run| level(&run.history));
        let (low, high) = of.fold((f64::INFINITY, 0.0), |(a, b), x| (f64::min(a, x), f64::max(b, x)));
        high > 1.05 * low
    };
    let level = levels.into_iter().find(varies).unwrap_or(levels[0]);
    let mut order: Vec<usize> = (0..runs.len()).collect();
    order.sort_by(|a, b| level(&runs[*a].history).total_cmp(&level(&runs[*b].history)));
    for place in (2..runs.len() - 1).step_by(4) {
        held[order[place]] = true;
    }
    held
}

pub(crate) fn raw(run: &ContactRun, newtons: bool) -> RawRun<'_> {
    RawRun {
        label: &run.label,
        time: &run.time,
        slip: &run.slip_displacement,
        velocity: run.slip_velocity.as_deref(),
        acceleration: run.slip_acceleration.as_deref(),
        normal: run.normal_force.as_deref().filter(|_| !newtons),
        preload: run.preload.filter(|_| !newtons),
        force: &run.force,
        force_std: run.force_noise_std,
    }
}

/// Whether the normal force is unknown in some run, so that the laws are in newtons.
pub(crate) fn in_newtons(record: &ContactRecord) -> bool {
    record.runs.iter().any(|run| run.preload.is_none() && run.normal_force.is_none())
}

fn extras(record: &ContactRecord) -> Extras {
    let forces = record.runs.iter().flat_map(|r| &r.force);
    let (sum, count) = forces.fold((0.0, 0.0), |(sum, count), f| (sum + f * f, count + 1.0));
    let rms = (sum / f64::max(count, 1.0)).sqrt();
    Extras {
        known_mass: record.moving_mass.filter(|m| m.is_finite()),
        wanted_mass: record.moving_mass.is_some_and(f64::is_nan),
        // Load cells drift: a tenth of the force is a generous offset.
        offset: Some(0.1 * rms),
    }
}

fn model_of<'a>(fit: &ContactFit, histories: &'a [ContactHistory], prepared: &Prepared) -> ContactModel<'a> {
    ContactModel::new(fit.family, histories.iter().collect(), &fit.law_values(), prepared.settings.extras)
}

fn held_out_error(fit: &ContactFit, prepared: &Prepared) -> f64 {
    model_of(fit, &prepared.held_out, prepared).relative_error(&fit.identified.values())
}

fn summary(error: f64, histories: &[ContactHistory], (floor, source): (f64, FloorSource)) -> ErrorSummary {
    let forces = histories.iter().flat_map(|h| &h.force);
    let (sum, count) = forces.fold((0.0, 0.0), |(sum, count), f| (sum + f * f, count + 1.0));
    let rms = (sum / f64::max(count, 1.0)).sqrt().max(f64::MIN_POSITIVE);
    ErrorSummary {
        force: Some(error),
        acceleration: None,
        noise_floor: floor / rms,
        noise_floor_source: match source {
            FloorSource::Given => NoiseFloorSource::Given,
            FloorSource::Repeats => NoiseFloorSource::Repeats,
            FloorSource::Estimated => NoiseFloorSource::Estimated,
        },
    }
}

fn described(record: &ContactRecord, fit: &ContactFit, prepared: &Prepared) -> Identification {
    let newtons = in_newtons(record);
    let mut parameters = BTreeMap::new();
    let mut notes = Vec::new();
    for parameter in &fit.identified.parameters {
        let (name, unit) = published(&parameter.name, &parameter.unit, (newtons, record.slip_unit));
        notes.extend(remark(&name, parameter));
        let mut value = estimate(parameter);
        value.unit = unit;
        parameters.insert(name, value);
    }
    if newtons {
        notes.push("the normal force is not known: friction levels and stiffness are in newtons".to_owned());
    }
    let steps = fit.steps.iter().map(|step| Step {
        name: step.name.clone(),
        parameters: step.parameters.iter().map(|n| published(n, "", (newtons, record.slip_unit)).0).collect(),
        error: step.error,
    });
    Identification {
        law: fit.family.name().to_owned(),
        parameters,
        steps: steps.collect(),
        error: summary(fit.error, &prepared.training, (prepared.floor[0], prepared.source)),
        provenance: Provenance {
            version: env!("CARGO_PKG_VERSION").to_owned(),
            seed: SEED,
            training_runs: prepared.training_runs.clone(),
        },
        notes,
        ..Identification::default()
    }
}

/// Name and unit of a parameter in the result: in newtons where the normal force is unknown, in radians where the
/// contact turns.
pub(crate) fn published(name: &str, unit: &str, (newtons, slip): (bool, SlipUnit)) -> (String, String) {
    let (name, unit) = match (name, newtons) {
        ("mu_k", true) => ("friction_level", "N"),
        ("mu_s", true) => ("static_friction_level", "N"),
        ("sigma0", true) => (name, "N/m"),
        ("sigma1", true) => (name, "N·s/m"),
        _ => (name, unit),
    };
    let unit = if slip == SlipUnit::Radian { radians(unit) } else { unit.to_owned() };
    (name.to_owned(), unit)
}

/// A unit of the slip's metre in radians: only the whole letter m.
fn radians(unit: &str) -> String {
    match unit {
        "1/m" => "1/rad",
        "m/s" => "rad/s",
        "s/m" => "s/rad",
        "N/m" => "N/rad",
        "N·s/m" => "N·s/rad",
        other => other,
    }
    .to_owned()
}

/// What a comparison of laws says, in words.
pub(super) fn comparison(ranking: &frettrace_identify::evidence::Ranking<Family>) -> Vec<String> {
    let [best, others @ ..] = &ranking.candidates[..] else { return Vec::new() };
    if others.is_empty() {
        return Vec::new();
    }
    let list: Vec<String> = others
        .iter()
        .map(|c| {
            format!(
                "{} ΔBIC {:.1}, held-out error {:.4}",
                c.name.name(),
                c.criterion - best.criterion,
                c.held_out
            )
        })
        .collect();
    let mut notes = vec![format!(
        "{} has the best evidence (held-out error {:.4}); {}",
        best.name.name(),
        best.held_out,
        list.join("; ")
    )];
    if ranking.alike > 1 {
        let names: Vec<&str> = ranking.candidates[..ranking.alike].iter().map(|c| c.name.name()).collect();
        notes.push(format!("these laws cannot be told apart on these data: {}", names.join(", ")));
    }
    notes
}
