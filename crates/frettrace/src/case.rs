//! A measurement file as the case of an explanation or a joint fit.

use crate::reconstruct::{FormChoice, ReconstructOptions, reconstruct, told_apart, uniform_beam};
use crate::{Progress, StudyError};
use frettrace_beam::Boundary;
use frettrace_explain::{BALANCE_CLOSED_RUN, Case, DeclaredModes, Reading, RunSamples, Series};
use frettrace_forward::accelerations::Rig;
use frettrace_identify::contact::Family;
use frettrace_inverse::{CalibratedStructure, Form, Reconstruction, RunReconstruction};
use frettrace_measurement::{Measurement, SlipKind};
use rayon::prelude::*;
use std::collections::BTreeSet;

/// Modes summed; the rest acts through its static flexibility.
const MODES: usize = 40;

/// Gives the runs of a case that are not periodic what the inverse recovers of them over the whole spectrum.
///
/// All runs as the inverse has them; none where all are periodic.
///
/// # Errors
/// [`StudyError`] where the inverse cannot use the rig.
pub fn recover_aperiodic(
    case: &mut Case,
    measurement: &Measurement,
) -> Result<Vec<RunReconstruction>, StudyError> {
    if case.records.iter().all(|record| record.periodic) {
        return Ok(Vec::new());
    }
    let mut found = recovered(&without_sensors(measurement, &broken_off(case)), &on_bins(case))?;
    if let Some(better) = without_bent(case, measurement, &found) {
        found = better;
    }
    if is_told_by_contacts(case) {
        calibrate(&mut case.modes, &found.structure);
    }
    let found = found.runs;
    for (record, run) in case.records.iter_mut().zip(&found) {
        if !record.periodic {
            record.series = series(run);
        }
    }
    Ok(found)
}

/// Modes as the inverse has calibrated them.
fn calibrate(modes: &mut DeclaredModes, structure: &CalibratedStructure) {
    let declared = [&mut modes.frequency, &mut modes.damping];
    let found = [structure.model.natural_frequency(), structure.model.damping_ratio()];
    for (values, found) in declared.into_iter().zip(found) {
        values.iter_mut().zip(found).take(structure.modes).for_each(|(value, found)| *value = *found);
    }
    for mode in 0..structure.modes {
        let known = [
            (&mut modes.frequency_std, modes.frequency.get(mode), structure.frequency_std(mode)),
            (&mut modes.damping_std, modes.damping.get(mode), structure.damping_std(mode)),
        ];
        for (stds, value, share) in known {
            if let (Some(std), Some(value)) = (stds.get_mut(mode), value) {
                *std = share * value;
            }
        }
    }
}

/// Periodic runs, two that are fitted and one held out, below which a file is judged by what is recovered of the others.
const LEAST_PERIODIC: usize = 3;

/// Whether a case is judged by the contacts recovered over the whole spectrum: next to none of its runs are periodic.
pub(crate) fn is_told_by_contacts(case: &Case) -> bool {
    let periodic = case.records.iter().filter(|record| record.periodic).count();
    periodic < LEAST_PERIODIC && case.records.len() >= periodic + LEAST_PERIODIC
}

/// What the inverse recovers of all runs of a measurement.
pub(crate) fn runs(
    measurement: &Measurement,
    form: FormChoice,
) -> Result<Vec<RunReconstruction>, StudyError> {
    let options = ReconstructOptions { form, ..ReconstructOptions::default() };
    Ok(inverse(measurement, options)?.runs)
}

fn inverse(measurement: &Measurement, options: ReconstructOptions) -> Result<Reconstruction, StudyError> {
    Ok(reconstruct(measurement, &options, &Progress::silent())?.inverse)
}

/// Some runs of a measurement.
pub(crate) fn selected(measurement: &Measurement, of: &[usize]) -> Measurement {
    let runs = of.iter().map(|&k| measurement.runs[k].clone()).collect();
    Measurement { runs, ..measurement.clone() }
}

/// All runs of a measurement.
struct Recovered {
    runs: Vec<RunReconstruction>,
    structure: CalibratedStructure,
    /// χ² per degree of freedom of the balance of each: the least, where it was balanced on lines as well.
    reduced: Vec<f64>,
}

impl Recovered {
    /// The worst balance of some runs.
    fn worst(&self, of: &[usize]) -> f64 {
        of.iter().map(|&k| self.reduced[k]).fold(0.0, f64::max)
    }
}

/// Which runs of a case are wanted bin by bin: those that are not periodic, and where it is judged by them the others too.
fn on_bins(case: &Case) -> Vec<bool> {
    let all = is_told_by_contacts(case);
    case.records.iter().map(|record| all || !record.periodic).collect()
}

/// All runs of a measurement, over the whole spectrum those that are wanted bin by bin.
fn recovered(measurement: &Measurement, on_bins: &[bool]) -> Result<Recovered, StudyError> {
    let Reconstruction { runs: mut found, structure, .. } =
        inverse(measurement, ReconstructOptions::default())?;
    let mut reduced: Vec<f64> = found.iter().map(|run| run.balance.reduced()).collect();
    // What the inverse adds beside its lines is no run of bins.
    let on_lines = |k: &usize| found[*k].lines.form != Form::Aperiodic && on_bins[*k];
    let missing: Vec<usize> = (0..found.len()).filter(on_lines).collect();
    if !missing.is_empty() {
        let part = selected(measurement, &missing);
        // Beside periodic runs what is recovered of the others is judged with what is declared.
        let as_declared = !on_bins.iter().all(|on_bins| *on_bins);
        let options = ReconstructOptions { form: FormChoice::Aperiodic, as_declared, splines: false };
        for (k, whole) in missing.into_iter().zip(inverse(&part, options)?.runs) {
            reduced[k] = reduced[k].min(whole.balance.reduced());
            found[k] = whole;
        }
    }
    Ok(Recovered { runs: found, structure, reduced })
}

/// χ² per degree of freedom up to which the balance of a run that was open is closed.
const CLOSED_BALANCE: f64 = 1.5;
/// Factor on the noise of a sensor that is not listened to.
const DEAF: f64 = 1e4;

/// The same with one sensor not listened to, where the balance of runs without a period is open with it, closed without it and without no other
/// one, and its readings are a bent curve of what the others tell: that it saturates is then a fault of the case.
fn without_bent(case: &mut Case, measurement: &Measurement, found: &Recovered) -> Option<Recovered> {
    let noise = measurement.sensors.noise_std.as_ref()?;
    let aperiodic: Vec<usize> = (0..case.records.len()).filter(|&k| !case.records[k].periodic).collect();
    let worst = aperiodic.iter().copied().max_by(|&a, &b| found.reduced[a].total_cmp(&found.reduced[b]))?;
    let closed = found.reduced[worst] <= BALANCE_CLOSED_RUN;
    if closed || !broken_off(case).is_empty() || noise.len() <= LEAST_SENSORS {
        return None;
    }
    // Where its worst run stays open by itself, a sensor is not asked of all.
    let closes = |other: &Measurement| {
        let alone = recovered(&selected(other, &[worst]), &[true]);
        alone.is_ok_and(|alone| alone.reduced[0] <= CLOSED_BALANCE)
    };
    let on_bins = on_bins(case);
    let deaf = |sensor: usize| {
        let mut other = measurement.clone();
        other.sensors.noise_std.iter_mut().for_each(|noise| noise[sensor] *= DEAF);
        let found = closes(&other).then(|| recovered(&other, &on_bins).ok()).flatten()?;
        (found.worst(&aperiodic) <= CLOSED_BALANCE).then_some((sensor, found))
    };
    let mut telling: Vec<(usize, Recovered)> = (0..noise.len()).into_par_iter().filter_map(deaf).collect();
    let (sensor, found) = telling.pop().filter(|_| telling.is_empty())?;
    let reading = |&k: &usize| {
        let (samples, fit) =
            (&measurement.runs[k].acceleration[sensor], &found.runs[k].acceleration_fit[sensor]);
        let count = samples.len().max(1) as f64;
        let mean = samples.iter().sum::<f64>() / count;
        let variance = fit.std.iter().map(|std| std * std).sum::<f64>() / count;
        Reading {
            read: samples.iter().map(|y| y - mean).collect(),
            told: fit.values.clone(),
            deviation: noise[sensor].hypot(variance.sqrt()),
        }
    };
    case.leave_out_bent(sensor, aperiodic.iter().map(reading).collect()).then_some(found)
}

/// Fewest sensors from which a contact is recovered.
const LEAST_SENSORS: usize = 3;

/// Sensors whose signal breaks off or is cut.
fn broken_off(case: &Case) -> BTreeSet<usize> {
    case.faults.iter().filter(|fault| fault.breaks_off()).map(|fault| fault.sensor).collect()
}

/// The measurement as its other sensors have it; whole where too few would be left.
fn without_sensors(measurement: &Measurement, left_out: &BTreeSet<usize>) -> Measurement {
    let mut sound = measurement.clone();
    if measurement.sensors.position.len() < LEAST_SENSORS + left_out.len() {
        return sound;
    }
    fn keep<T>(values: &mut Vec<T>, left_out: &BTreeSet<usize>) {
        let mut place = 0..;
        values.retain(|_| place.next().is_none_or(|sensor| !left_out.contains(&sensor)));
    }
    keep(&mut sound.sensors.position, left_out);
    sound.sensors.noise_std.iter_mut().for_each(|noise| keep(noise, left_out));
    sound.sensors.name.iter_mut().for_each(|names| keep(names, left_out));
    sound.runs.iter_mut().for_each(|run| keep(&mut run.acceleration, left_out));
    sound
}

/// Recovered samples; bins that the prior leads are not known.
fn series(run: &RunReconstruction) -> Option<Series> {
    let friction = &run.contact.as_ref()?.friction;
    let mut deviation: Vec<f64> = friction.variance.iter().map(|v| (0.5 * v).sqrt()).collect();
    for &bin in &run.regularised_lines {
        if let Some(value) = deviation.get_mut(bin) {
            *value = f64::INFINITY;
        }
    }
    Some(Series {
        dt: run.lines.sampling_rate.recip(),
        slip: run.slip_displacement.values.clone(),
        velocity: run.slip_velocity.values.clone(),
        normal: run.normal_force.values.clone(),
        force: run.friction_force.values.clone(),
        deviation,
        open_share: open_share(run),
    })
}

/// Preload shares within which a normal force is zero: its mean is not seen, and a support that opens raises it a little.
const ZERO: f64 = 0.05;
/// Share of the time that a contact must be open for it to be seen.
const OPEN: f64 = 0.02;

/// Share of the time in which the support does not touch: the recovered normal force, freed from its spring, stays at zero and
/// never pulls. A force that followed the spring would go through zero; one of a stiffer support would not stay there.
fn open_share(run: &RunReconstruction) -> f64 {
    let normal = &run.normal_force.values;
    let preload = normal.iter().sum::<f64>() / normal.len().max(1) as f64;
    if !run.normal_deviates || normal.iter().any(|n| *n < -2.0 * ZERO * preload) {
        return 0.0;
    }
    let open = normal.iter().filter(|n| **n < ZERO * preload).count() as f64 / normal.len().max(1) as f64;
    if open >= OPEN { open } else { 0.0 }
}

/// The samples of all runs.
pub(crate) fn samples(measurement: &Measurement) -> Vec<RunSamples<'_>> {
    let runs = measurement.runs.iter().map(|run| RunSamples {
        sampling_rate: run.sampling_rate,
        excitation_frequency: run.excitation_frequency,
        preload: run.preload,
        force: &run.force,
        acceleration: &run.acceleration,
    });
    runs.collect()
}

/// The case a measurement file declares.
///
/// # Errors
/// [`StudyError::Run`] where the lines of a run cannot be found.
pub fn case(measurement: &Measurement) -> Result<Case, StudyError> {
    let noise = measurement.sensors.noise_std.as_deref();
    let samples = samples(measurement);
    let (records, faults) = frettrace_explain::records(&samples, noise)
        .map_err(|(k, source)| StudyError::Run { run: measurement.runs[k].id.clone(), source })?;
    let law = Family::named(&measurement.support.law).unwrap_or(Family::Dahl);
    let mut case = Case {
        rig: rig(measurement),
        records,
        modes: modes(measurement),
        law,
        faults,
        shaken: None,
        without: Vec::new(),
        aside: Vec::new(),
    };
    case.tell_motion_from_hum();
    case.open_higher_modes()?;
    if let Some(second) = &measurement.second_support {
        case.know_support(second.position)?;
    }
    case.leave_out_saturated()?;
    Ok(case)
}

fn rig(measurement: &Measurement) -> Rig {
    let beam = uniform_beam(&measurement.beam);
    let support = &measurement.support;
    let turns = support.slip == SlipKind::Rotation;
    Rig {
        boundary: Boundary::spring(told_apart(support.normal_stiffness, &beam)),
        beam,
        exciter: measurement.exciter.position,
        sensors: measurement.sensors.position.clone(),
        lever: turns.then_some(support.lever_arm),
        known_support: None,
        modes: MODES,
    }
}

fn modes(measurement: &Measurement) -> DeclaredModes {
    let tau = std::f64::consts::TAU;
    let scaled = |values: &[f64]| values.iter().map(|f| f * tau).collect();
    measurement.modes.as_ref().map_or_else(DeclaredModes::default, |m| DeclaredModes {
        frequency: scaled(&m.frequency),
        frequency_std: scaled(&m.frequency_std),
        damping: m.damping_ratio.clone(),
        damping_std: m.damping_ratio_std.clone(),
        measured: m.frequency.len(),
    })
}
