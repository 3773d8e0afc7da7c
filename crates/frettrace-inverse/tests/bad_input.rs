//! What cannot be used is refused, with the place.
#![allow(clippy::unwrap_used)] // helpers of tests may fail as tests do

mod oracle;

use frettrace_inverse::{Finding, InverseError, Options, Rig, RunData, reconstruct};
use oracle::{Loads, Oracle, Record, nothing, saturating};
use std::f64::consts::TAU;

const SENSORS: [f64; 3] = [0.1, 0.3, 0.5];

fn rig() -> Rig {
    Oracle::new(1e6, &SENSORS).declared(&SENSORS, 0.1, 3, 0.0)
}

fn solve(rig: &Rig, force: &[f64], accelerations: Vec<&[f64]>) -> InverseError {
    let run = RunData {
        id: "0007",
        sampling_rate: 1000.0,
        excitation_frequency: 50.0,
        preload: 1.0,
        force,
        accelerations,
    };
    reconstruct(rig, &[run], &Options::default()).unwrap_err()
}

#[test]
fn each_fault_has_its_error() {
    let good = vec![1.0; 400];
    let three = || vec![good.as_slice(); 3];
    assert!(matches!(solve(&rig(), &vec![0.0; 400], three()), InverseError::NoForce { .. }));
    assert!(matches!(
        solve(&rig(), &good, vec![&good; 2]),
        InverseError::Shape { found: 2, expected: 3, .. }
    ));
    assert!(matches!(solve(&rig(), &good, vec![&good, &good, &good[1..]]), InverseError::Shape { .. }));
    let mut broken = good.clone();
    broken[17] = f64::NAN;
    let found = solve(&rig(), &good, vec![&good, &broken, &good]);
    assert!(found.to_string().contains("0007") && found.to_string().contains("sample 17"), "{found}");
    let mut outside = rig();
    outside.sensors[2].position = 0.9;
    assert!(matches!(solve(&outside, &good, three()), InverseError::OffTheBeam { .. }));
    assert_eq!(reconstruct(&rig(), &[], &Options::default()).unwrap_err(), InverseError::NoRuns);
}

#[test]
fn one_sensor_cannot_see_two_contacts() {
    let mut rig = rig();
    rig.sensors.truncate(1);
    rig.second_support = Some(0.4);
    let good = vec![1.0; 400];
    assert_eq!(solve(&rig, &good, vec![&good]), InverseError::TooFewSensors { sensors: 1, unknowns: 2 });
}

const SIX: [f64; 6] = [0.11, 0.22, 0.33, 0.45, 0.56, 0.65];
const FREQUENCY: f64 = 45.7;

fn healthy() -> (Rig, Record) {
    let oracle = Oracle::new(5e6, &SIX);
    let exciter = |t: f64| 1.5 * (TAU * FREQUENCY * t).cos();
    let friction = |t: f64| saturating(FREQUENCY, t);
    let loads =
        Loads { exciter: &exciter, friction: &friction, second: &nothing, normal_deviation: &nothing };
    let mut record = oracle.march(&loads, 2.5, 1024);
    record.add_noise(0.05, 9);
    (oracle.declared(&SIX, 0.05, 6, 0.0), record)
}

fn findings(rig: &Rig, record: &Record) -> Vec<Finding> {
    let runs = [record.run(FREQUENCY), record.run(FREQUENCY)];
    reconstruct(rig, &runs, &Options::default()).unwrap().findings
}

#[test]
fn healthy_sensors_have_no_findings() {
    let (rig, record) = healthy();
    assert_eq!(findings(&rig, &record), []);
    let one = reconstruct(&rig, &[record.run(FREQUENCY)], &Options::default()).unwrap();
    assert_eq!(one.findings, [Finding::SingleRun]);
}

#[test]
fn sensor_faults_are_named() {
    let (rig, record) = healthy();
    let with = |change: &dyn Fn(&mut Vec<Vec<f64>>)| {
        let mut spoilt =
            Record { accelerations: record.accelerations.clone(), force: record.force.clone(), ..empty() };
        change(&mut spoilt.accelerations);
        findings(&rig, &spoilt)
    };
    assert_eq!(with(&|a| a[2].fill(0.0)).first(), Some(&Finding::DeadSensor { sensor: 2 }));
    assert!(with(&|a| a.swap(1, 4)).contains(&Finding::SwappedSensors { sensors: [1, 4] }));
    assert!(with(&|a| a[3] = a[2].clone()).contains(&Finding::DuplicatedSensors { sensors: [2, 3] }));
    let clipped = with(&|a| a[1].iter_mut().for_each(|v| *v = v.clamp(-2.0, 2.0)));
    assert!(clipped.iter().any(|f| matches!(f, Finding::ClippedSensor { sensor: 1, .. })), "{clipped:?}");
    // What is clipped has no gain besides.
    assert!(!clipped.iter().any(|f| matches!(f, Finding::SensorGain { sensor: 1, .. })), "{clipped:?}");
    // In units of g: 1/9.80665 of the value in m/s².
    let scaled = with(&|a| a[4].iter_mut().for_each(|v| *v /= 9.80665));
    let gain = scaled.iter().find_map(|f| match f {
        Finding::SensorGain { sensor: 4, gain } => Some(*gain),
        _ => None,
    });
    assert!(gain.is_some_and(|g| (g * 9.80665 - 1.0).abs() < 0.01), "{scaled:?}");
    // All of them in g: the force tells, whatever the noise is said to be.
    let all = with(&|a| a.iter_mut().flatten().for_each(|v| *v /= 9.80665));
    let gain = all.iter().find_map(|f| if let Finding::CommonGain { gain } = f { Some(*gain) } else { None });
    assert!(gain.is_some_and(|g| (g * 9.80665 - 1.0).abs() < 0.05), "{all:?}");
}

fn empty() -> Record {
    Record {
        force: Vec::new(),
        accelerations: Vec::new(),
        friction: Vec::new(),
        slip: Vec::new(),
        velocity: Vec::new(),
        normal: Vec::new(),
    }
}
