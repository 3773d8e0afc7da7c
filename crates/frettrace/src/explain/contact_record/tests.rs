//! A contact record through the whole explanation: what the contract promises of its file, and files nobody can explain.

use super::super::{ExplainOptions, explain};
use crate::results::{Explanation, NoiseFloorSource, Verdict};
use crate::{Progress, StudyError, report, store};
use frettrace_measurement::{ContactRecord, ContactRun, Recording, SlipUnit, Source};
use std::f64::consts::TAU;
use std::path::Path;

const SAMPLES: usize = 300;
/// Parts of a sample in which the truth is marched; the fit takes one step a sample.
const PARTS: usize = 100;
/// Friction (N), sliding distance (m), noise of the force (N).
const TRUTH: (f64, f64, f64) = (20.0, 10e-6, 0.1);

/// Three cycles of Dahl's bristle with exponent 1 and a viscous part (N·s/m), by explicit Euler steps.
fn run(number: usize, (amplitude, frequency): (f64, f64), viscous: f64) -> ContactRun {
    let dt = 3.0 / frequency / (SAMPLES * PARTS) as f64;
    let (mut bristle, mut force, mut slip) = (0.0, Vec::new(), Vec::new());
    let mut seed = number as u64;
    for part in 0..SAMPLES * PARTS {
        let (sine, cosine) = (TAU * frequency * part as f64 * dt).sin_cos();
        let v = amplitude * TAU * frequency * cosine;
        if part % PARTS == 0 {
            seed = seed.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            // Uniform with the deviation of the noise: its half-width is √3 times that.
            let noise = ((seed >> 11) as f64 / (1u64 << 53) as f64 - 0.5) * 2.0 * 3f64.sqrt() * TRUTH.2;
            force.push(TRUTH.0 * bristle + viscous * v + noise);
            slip.push(amplitude * sine);
        }
        bristle += dt * v / TRUTH.1 * (1.0 - bristle * v.signum());
    }
    let rate = SAMPLES as f64 * frequency / 3.0;
    ContactRun {
        id: format!("{number:04}"),
        label: format!("{frequency} Hz"),
        preload: None,
        time: (0..SAMPLES).map(|k| k as f64 / rate).collect(),
        sampling_rate: Some(rate),
        force,
        slip_displacement: slip,
        slip_velocity: None,
        slip_acceleration: None,
        normal_force: None,
        force_noise_std: Some(TRUTH.2),
    }
}

fn record(viscous: f64) -> ContactRecord {
    let levels = [(30e-6, 1.0), (60e-6, 2.0), (80e-6, 1.5), (100e-6, 1.0), (120e-6, 3.0)];
    ContactRecord {
        title: "A rig".to_owned(),
        source: Source::Simulated,
        law: "dahl".to_owned(),
        slip_unit: SlipUnit::Metre,
        moving_mass: None,
        runs: levels.iter().enumerate().map(|(k, level)| run(k + 1, *level, viscous)).collect(),
    }
}

fn explained(record: ContactRecord) -> Result<Explanation, StudyError> {
    explain(&Recording::Contact(record), &ExplainOptions::default(), &Progress::silent())
}

#[test]
fn a_missing_effect_is_named_with_errors_before_and_after() {
    let found = explained(record(1500.0)).unwrap();
    assert_eq!(found.verdict, Verdict::Explained);
    assert_eq!(found.effects[0].id, "friction.viscous");
    let held_out = found.held_out.as_ref().unwrap();
    assert_eq!((held_out.runs.len(), held_out.noise_floor_source), (1, NoiseFloorSource::Given));
    // 1.2 of the floor is the score's own limit; the missing part has up to 3.4 N beside 20 N.
    assert!(held_out.after < 1.2 * held_out.noise_floor && held_out.before > 5.0 * held_out.after);
    // The truth: 20 N of friction, in newtons since no normal force is given.
    let level = &found.model.parameters["friction_level"];
    assert!((level.value / TRUTH.0 - 1.0).abs() < 0.01 && level.unit == "N", "{level:?}");
    let json = store::to_json(Path::new("explain.json"), &found).unwrap();
    for key in
        ["verdict", "effects", "place", "error", "held_out", "candidates", "baseline", "model", "noise_floor"]
    {
        assert!(json.contains(&format!("\"{key}\"")), "{key}");
    }
    assert_eq!(serde_json::from_str::<Explanation>(&json).unwrap().effects, found.effects);
    // The measured loop's own work is that of its force: four friction levels times the way, less the presliding.
    let drawn = &found.exhibits.loops[0];
    let (measured, modelled) = (drawn.measured.energy_per_cycle_j, drawn.after.energy_per_cycle_j);
    assert!(measured > 0.0 && (modelled / measured - 1.0).abs() < 0.01, "{measured} {modelled}");
    let page = report::html("A rig", &found);
    assert!(page.contains("friction.viscous") && !page.contains("accelerometers"));
}

/// Records nobody can explain end in an error or an honest answer.
#[test]
fn poor_records_end_in_words() {
    let poor: [fn(&mut ContactRun); 5] = [
        |run| run.slip_displacement.fill(1e-3),
        |run| run.force.fill(0.0),
        |run| {
            run.force.fill(0.0);
            run.slip_displacement.fill(0.0);
        },
        |run| run.force.iter_mut().for_each(|f| *f *= 1e-6),
        |run| {
            run.time.truncate(9);
            run.force.truncate(9);
            run.slip_displacement.truncate(9);
        },
    ];
    for (k, spoil) in poor.into_iter().enumerate() {
        for stated in [None, Some(TRUTH.2)] {
            let mut record = record(0.0);
            for run in &mut record.runs {
                spoil(run);
                run.force_noise_std = stated;
            }
            match explained(record) {
                Ok(found) => assert!(found.effects.is_empty(), "{k} {stated:?}: {:?}", found.effects),
                Err(error) => assert!(!error.to_string().is_empty()),
            }
        }
    }
    let empty = ContactRecord { runs: Vec::new(), ..record(0.0) };
    assert!(!explained(empty).unwrap_err().to_string().is_empty());
}
