//! `identify --law auto`: which law the data speak for, and when they do not.
//!
//! Records come from state equations in steps much finer than the samples, and the accelerations from a time march of 72 modes at
//! 120 kHz: neither the steps of the laws nor the harmonic balance that are fitted to them made the data.

use std::f64::consts::TAU;
use std::path::Path;

use frettrace::Progress;
use frettrace::identify::{IdentifyOptions, identify};
use frettrace::results::Identification;
use frettrace::rig::parse_rig;
use frettrace::simulate::simulate;
use frettrace_measurement::{ContactRecord, ContactRun, Recording, SlipUnit, Source};
use rand::SeedableRng;
use rand_distr::{Distribution, StandardNormal};

fn auto(recording: &Recording) -> anyhow::Result<Identification> {
    let options = IdentifyOptions { law: Some("auto".to_owned()) };
    Ok(identify(recording, &options, &Progress::silent())?)
}

/// ΔBIC of a law against the best one, from the note of the comparison.
fn evidence(found: &Identification, law: &str) -> Option<f64> {
    let note = found.notes.iter().find(|note| note.contains("has the best evidence"))?;
    let (_, rest) = note.split_once(&format!("{law} ΔBIC "))?;
    rest.split_once(',')?.0.parse().ok()
}

/// What a bench measures: four levels, 50 N, `u = A (sin ωt + 0.2 sin 3ωt)`.
struct Bench {
    /// Smallest amplitude \[m\]; each level has twice that of the last.
    amplitude: f64,
    /// Samples a period, and periods.
    samples: usize,
    periods: usize,
    /// Noise of the force \[N\].
    noise: f64,
}

/// Place of the first sample: no reversal of the motion falls on a sample, where a force that jumps has no value.
const PLACE: f64 = 0.3;

/// Motion and force of the bench; `force` goes from slip velocity and time step to the friction coefficient.
fn record<F: FnMut(f64, f64) -> f64>(bench: &Bench, mut law: impl FnMut() -> F) -> ContactRecord {
    let mut generator = rand_pcg::Pcg64::seed_from_u64(3);
    let (omega, fine) = (TAU * 50.0, 40);
    let interval = 1.0 / (50.0 * bench.samples as f64);
    let mut run = |level: u32| {
        let amplitude = bench.amplitude * 2.0_f64.powi(level as i32);
        let phase = |t: f64| omega * (t + PLACE * interval);
        let velocity = |t: f64| amplitude * omega * (phase(t).cos() + 0.6 * (3.0 * phase(t)).cos());
        let (mut law, mut force) = (law(), Vec::new());
        let dt = interval / f64::from(fine);
        // Three periods are over before the first sample.
        for k in 0..(3 + bench.periods) * bench.samples {
            let mut coefficient = 0.0;
            for j in 0..fine {
                coefficient = law(velocity(k as f64 * interval + (f64::from(j) + 0.5) * dt), dt);
            }
            let error: f64 = StandardNormal.sample(&mut generator);
            force.push(50.0 * coefficient + bench.noise * error);
        }
        let time: Vec<f64> = (1..=force.len()).skip(3 * bench.samples).map(|k| k as f64 * interval).collect();
        let slip = |t: f64| amplitude * (phase(t).sin() + 0.2 * (3.0 * phase(t)).sin());
        ContactRun {
            id: format!("{level:04}"),
            label: format!("level {level}"),
            preload: Some(50.0),
            sampling_rate: Some(interval.recip()),
            slip_displacement: time.iter().map(|t| slip(*t)).collect(),
            slip_velocity: Some(time.iter().map(|t| velocity(*t)).collect()),
            slip_acceleration: None,
            normal_force: None,
            force: force.split_off(3 * bench.samples),
            force_noise_std: Some(bench.noise),
            time,
        }
    };
    ContactRecord {
        title: "bench".to_owned(),
        source: Source::Simulated,
        law: "coulomb".to_owned(),
        slip_unit: SlipUnit::Metre,
        moving_mass: None,
        runs: (0..4).map(&mut run).collect(),
    }
}

/// Half to four sliding distances of a bristle (σ0 = 4e5, μ = 0.3). LuGre has the damping, the viscous and the static friction more
/// than Dahl, each of which costs the logarithm of the number of samples; laws without a bristle miss most of the force.
#[test]
fn dahl_wins_on_dahl_data() {
    let bench = Bench { amplitude: 3.75e-7, samples: 128, periods: 2, noise: 0.1 };
    let made = record(&bench, || {
        let mut z = 0.0;
        move |v: f64, dt: f64| {
            let steady = 0.3_f64.copysign(v);
            z = steady + (z - steady) * (-4e5 * v.abs() * dt / 0.3).exp();
            z
        }
    });
    let found = auto(&Recording::Contact(made)).unwrap();
    assert_eq!(found.law, "dahl", "{:?}", found.notes);
    for law in ["coulomb", "stribeck"] {
        assert!(evidence(&found, law).is_some_and(|e| e > 100.0), "{law}: {:?}", found.notes);
    }
    for law in ["lugre", "hybrid"] {
        assert!(evidence(&found, law).is_some_and(|e| e > 10.0), "{law}: {:?}", found.notes);
    }
}

/// Sliding without a visible bristle: a stiff Dahl is Coulomb, and no number of samples tells them apart. The stiffness is then not
/// identifiable.
#[test]
fn laws_that_are_one_on_the_data_are_said_to_be() {
    let bench = Bench { amplitude: 1e-4, samples: 128, periods: 1, noise: 0.5 };
    let made = record(&bench, || |v: f64, _: f64| 0.3_f64.copysign(v));
    let found = auto(&Recording::Contact(made)).unwrap();
    let note = found.notes.iter().find(|note| note.contains("cannot be told apart"));
    assert!(note.is_some_and(|n| n.contains("coulomb") && n.contains("dahl")), "{:?}", found.notes);
    assert!(evidence(&found, "lugre").is_some_and(|e| e > 10.0), "{:?}", found.notes);
}

/// A Dahl contact under a beam, seen by accelerometers alone.
#[test]
fn dahl_wins_on_accelerations() {
    let rig = r#"
title = "rig of the test"
seed = 11
[beam]
length_m = 0.44
width_m = 0.025
thickness_m = 0.006
youngs_modulus_pa = 2.0e11
density_kg_per_m3 = 7850.0
[modes]
damping_ratio = [0.006, 0.005, 0.005]
declared = 4
frequency_relative_std = 2e-5
damping_relative_std = 2e-3
[support]
slip = "rotation"
lever_arm_m = 0.003
normal_stiffness_n_per_m = 5.0e6
law = "dahl"
[support.parameters]
sigma0_per_m = 5.0e5
mu_k = 0.3
exponent = 1.0
[exciter]
position_m = 0.18
[sensors]
position_m = [0.07, 0.15, 0.24, 0.35]
noise_std_m_per_s2 = 0.2
[sampling]
rate_hz = 4096.0
samples = 768
[[run]]
frequency_hz = 113.0
preload_n = 60.0
force_amplitude_n = [0.7, 1.1, 1.8, 2.9, 4.6]
"#;
    let rig = parse_rig(rig, Path::new("rig.toml")).unwrap();
    let made = simulate(&rig, &Progress::silent()).unwrap();
    let found = auto(&Recording::Measurement(made.measurement)).unwrap();
    assert_eq!(found.law, "dahl", "{:?}", found.notes);
    for law in ["coulomb", "stribeck"] {
        let ruled_out = found.notes.iter().any(|note| note.starts_with(&format!("{law} is ruled out")));
        assert!(ruled_out || evidence(&found, law).is_some_and(|e| e > 100.0), "{law}: {:?}", found.notes);
    }
    for law in ["lugre", "hybrid"] {
        let ruled_out = found.notes.iter().any(|note| note.starts_with(&format!("{law} is ruled out")));
        assert!(ruled_out || evidence(&found, law).is_some_and(|e| e > 10.0), "{law}: {:?}", found.notes);
    }
    let sigma0 = &found.parameters["sigma0"];
    assert!(sigma0.identifiable && (sigma0.value / 5e5 - 1.0).abs() < 0.02, "{sigma0:?}");
}
