//! What a laboratory would hand over of a simulation, and its truth.

use std::f64::consts::TAU;

use frettrace_forward::simulate::{Marching, SimulatedRecord, SimulatedRun};
use frettrace_measurement::{
    Beam, Exciter, MeasuredModes, Measurement, Run, RunTruth, SecondSupport, Sensors, SlipKind, Source,
    Support, Truth,
};
use rand::{RngExt, SeedableRng};
use rand_distr::StandardNormal;

use super::{MODES, boundary, declared_modes};
use crate::StudyError;
use crate::rig::{Effect, Rig, RigRuns, RigSlip};

/// Modes as a modal test would give them: true values of the declared structure with errors of the stated size.
fn measured_modes(rig: &Rig) -> Result<Option<MeasuredModes>, StudyError> {
    if rig.modes.declared == 0 {
        return Ok(None);
    }
    let [frequency, ratio] = declared_modes(rig, &boundary(rig), rig.modes.declared)?;
    // Another stream than the runs': they are seeded with multiples of the seed plus their number.
    let mut random = rand_pcg::Pcg64::seed_from_u64(!rig.seed);
    let mut measure = |values: Vec<f64>, relative: f64, unit: f64| -> (Vec<f64>, Vec<f64>) {
        let std: Vec<f64> = values.iter().map(|v| relative * v / unit).collect();
        let read = values.iter().zip(&std).map(|(v, s)| {
            let error: f64 = random.sample(StandardNormal);
            v / unit + s * error
        });
        (read.collect(), std)
    };
    let (frequency, frequency_std) = measure(frequency, rig.modes.frequency_relative_std, TAU);
    let (damping_ratio, damping_ratio_std) = measure(ratio, rig.modes.damping_relative_std, 1.0);
    Ok(Some(MeasuredModes { frequency, frequency_std, damping_ratio, damping_ratio_std }))
}

pub(super) fn measurement(
    rig: &Rig,
    runs: &[(&RigRuns, SimulatedRun)],
    records: Vec<SimulatedRecord>,
) -> Result<Measurement, StudyError> {
    let b = &rig.beam;
    let noise = rig.sensors.noise_std_m_per_s2;
    Ok(Measurement {
        title: rig.title.clone(),
        source: Source::Simulated,
        beam: Beam {
            length: b.length_m,
            width: b.width_m,
            thickness: b.thickness_m,
            youngs_modulus: b.youngs_modulus_pa,
            density: b.density_kg_per_m3,
            area: b.area_m2,
            second_moment: b.second_moment_m4,
        },
        modes: measured_modes(rig)?,
        support: Support {
            position: b.length_m,
            slip: match rig.support.slip {
                RigSlip::Rotation => SlipKind::Rotation,
                RigSlip::Transverse => SlipKind::Transverse,
            },
            lever_arm: rig.support.lever_arm_m.unwrap_or_default(),
            normal_stiffness: rig.support.normal_stiffness_n_per_m.unwrap_or_default(),
            law: rig.support.law.clone(),
        },
        second_support: rig.second_support.as_ref().map(|s| SecondSupport { position: s.position_m }),
        exciter: Exciter { position: rig.exciter.position_m },
        sensors: Sensors {
            position: rig.sensors.position_m.clone(),
            noise_std: (noise > 0.0).then(|| vec![noise; rig.sensors.position_m.len()]),
            name: None,
        },
        runs: runs
            .iter()
            .zip(records)
            .enumerate()
            .map(|(index, run)| measured_run(rig, index, run))
            .collect(),
    })
}

fn measured_run(
    rig: &Rig,
    index: usize,
    ((runs, run), record): (&(&RigRuns, SimulatedRun), SimulatedRecord),
) -> Run {
    Run {
        id: run_id(index),
        label: format!("{} N", run.force_amplitude),
        sampling_rate: rig.sampling.rate_hz,
        excitation_frequency: runs.frequency_hz,
        preload: runs.preload_n,
        lubricated: runs.lubricated,
        temperature: None,
        acceleration: record.acceleration,
        force: record.force,
    }
}

pub(super) fn run_id(index: usize) -> String {
    format!("{:04}", index + 1)
}

pub(super) fn truth(rig: &Rig, records: &[SimulatedRecord]) -> Truth {
    let mut numbers: Vec<(String, f64)> =
        rig.support.parameters.iter().map(|(key, value)| (key.clone(), *value)).collect();
    let mut words = vec![("law".to_owned(), rig.support.law.clone())];
    for effect in &rig.effects {
        numbers.extend(effect.position().map(|x| (format!("{}.position_m", effect.id()), x)));
        numbers.extend(effect.sensor().map(|s| (format!("{}.sensor", effect.id()), s as f64)));
    }
    let rates = records.iter().map(|record| record.marching.rate);
    numbers.push(("march_rate_hz".to_owned(), rates.fold(0.0, f64::max)));
    words.extend(march_note(records).map(|note| ("note".to_owned(), note)));
    let ids: Vec<&str> = rig.effects.iter().map(Effect::id).collect();
    words.push(("effect".to_owned(), if ids.is_empty() { "none".to_owned() } else { ids.join(" ") }));
    let run = |(index, record): (usize, &SimulatedRecord)| RunTruth {
        id: run_id(index),
        friction_force: record.friction_force.clone(),
        normal_force: record.normal_force.clone(),
        slip_displacement: record.slip.clone(),
        slip_velocity: record.slip_velocity.clone(),
        second_support_force: record.second_support_force.clone(),
    };
    Truth { numbers, words, runs: records.iter().enumerate().map(run).collect() }
}

/// What of the runs the march did not settle: steps that were not short enough, modes that were left out, motions that are one of many.
fn march_note(records: &[SimulatedRecord]) -> Option<String> {
    let about = |what: &str, of_run: &dyn Fn(&Marching) -> Option<String>| {
        let runs = records.iter().enumerate().filter_map(|(index, record)| {
            of_run(&record.marching).map(|words| format!("run {}{words}", run_id(index)))
        });
        let runs: Vec<String> = runs.collect();
        (!runs.is_empty()).then(|| format!("{what} ({})", runs.join("; ")))
    };
    let changes = about("accelerations still change with the steps of the march", &|marching| {
        let Marching { rate, change, tolerance, .. } = *marching;
        let change = change.filter(|change| change.is_finite() && *change > tolerance)?;
        Some(format!(": {change:.2e} m/s² at {rate:.0} steps a second, {tolerance:.2e} wanted"))
    });
    let chatters = about(
        "the contact chatters faster than the march can follow: what is recorded is one of many such motions",
        &|marching| marching.change.filter(|change| change.is_infinite()).map(|_| String::new()),
    );
    let fewer = about(
        "with all modes the contact chatters beyond what is recorded: the others follow their loads without ringing",
        &|marching| (marching.modes < MODES).then(|| format!(": {} of {MODES} modes", marching.modes)),
    );
    let notes: Vec<String> = [changes, chatters, fewer].into_iter().flatten().collect();
    (!notes.is_empty()).then(|| notes.join(". "))
}
