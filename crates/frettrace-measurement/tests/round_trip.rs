//! What is written is read back as it was, by ourselves and by h5py.
#![allow(clippy::unwrap_used, clippy::print_stdout, reason = "a test")]

use frettrace_measurement::{
    Beam, Coefficients, ContactRecord, ContactRun, DataFile, Estimate, Exciter, Form, HarmonicTable,
    MeasuredModes, Measurement, ReconstructedRun, Reconstruction, Recording, Run, RunTruth, SecondSupport,
    Sensors, SlipKind, SlipUnit, Source, Support, Truth, read, read_contact_record, read_measurement,
    write_contact_record, write_measurement, write_reconstruction,
};
use num_complex::Complex64;

fn beam() -> Beam {
    Beam {
        length: 0.7,
        width: 0.03,
        thickness: 0.006,
        youngs_modulus: 2.0e11,
        density: 7800.0,
        area: Some(1.8e-4),
        second_moment: None,
    }
}

fn signal(samples: usize, phase: f64) -> Vec<f64> {
    (0..samples).map(|k| (0.05 * k as f64 + phase).sin()).collect()
}

fn run(id: &str, samples: usize) -> Run {
    Run {
        id: id.into(),
        label: format!("level {id}"),
        sampling_rate: 8192.0,
        excitation_frequency: 50.0,
        preload: 75.0,
        lubricated: Some(true),
        temperature: Some(293.0),
        acceleration: vec![signal(samples, 0.0), signal(samples, 1.0), signal(samples, 2.0)],
        force: signal(samples, 3.0),
    }
}

fn measurement() -> Measurement {
    Measurement {
        title: "a rig".into(),
        source: Source::Simulated,
        beam: beam(),
        modes: Some(MeasuredModes {
            frequency: vec![50.0, 160.0],
            frequency_std: vec![0.01, 0.02],
            damping_ratio: vec![0.005, 0.006],
            damping_ratio_std: vec![],
        }),
        support: Support {
            position: 0.7,
            slip: SlipKind::Rotation,
            lever_arm: 0.003,
            normal_stiffness: f64::INFINITY,
            law: "dahl".into(),
        },
        second_support: Some(SecondSupport { position: 0.4 }),
        exciter: Exciter { position: 0.3 },
        sensors: Sensors {
            position: vec![0.2, 0.4, 0.6],
            noise_std: Some(vec![0.05; 3]),
            name: Some(vec!["one".into(), "two".into(), "drei".into()]),
        },
        runs: vec![run("0001", 700), run("0002", 5000)],
    }
}

fn truth() -> Truth {
    Truth {
        numbers: vec![("sigma0".into(), 5.0e5)],
        words: vec![("effect".into(), "friction.stribeck".into())],
        runs: vec![RunTruth {
            id: "0001".into(),
            friction_force: signal(700, 0.5),
            normal_force: vec![75.0; 700],
            slip_displacement: signal(700, 0.1),
            slip_velocity: signal(700, 0.2),
            second_support_force: None,
        }],
    }
}

fn contact_run(id: &str, rate: Option<f64>) -> ContactRun {
    let even: Vec<f64> = (0..300).map(|k| f64::from(k) / 200.0).collect();
    let uneven: Vec<f64> = (0..300).map(|k| 0.01 * f64::from(k) + 0.001 * f64::from(k % 3)).collect();
    ContactRun {
        id: id.into(),
        label: String::new(),
        preload: rate,
        time: if rate.is_some() { even } else { uneven },
        sampling_rate: rate,
        force: signal(300, 0.0),
        slip_displacement: signal(300, 1.0),
        slip_velocity: rate.map(|_| signal(300, 2.0)),
        slip_acceleration: None,
        normal_force: None,
        force_noise_std: rate.map(|_| 0.02),
    }
}

fn contact_record() -> ContactRecord {
    ContactRecord {
        title: "a damper".into(),
        source: Source::Measured,
        law: "lugre".into(),
        slip_unit: SlipUnit::Radian,
        moving_mass: None,
        runs: vec![contact_run("0001", Some(200.0)), contact_run("0002", None)],
    }
}

fn coefficients() -> HarmonicTable {
    HarmonicTable {
        frequency: vec![0.0, 50.1, 100.2],
        quantities: vec![Coefficients {
            name: "friction_force".into(),
            units: "N".into(),
            values: vec![Complex64::new(0.0, 0.0), Complex64::new(1.0, -2.0), Complex64::new(0.5, 0.25)],
            std: vec![0.0, 0.1, 0.1],
        }],
    }
}

fn reconstruction() -> Reconstruction {
    let samples = 1500;
    let estimate = |phase: f64| Estimate { values: signal(samples, phase), std: vec![0.1; samples] };
    let run = ReconstructedRun {
        id: "0001".into(),
        label: "level 1".into(),
        fundamental_frequency: 50.1,
        form: Form::Harmonic,
        subharmonic_order: 1,
        harmonics: 2,
        acceleration_error: 0.011,
        noise_floor: 0.010,
        unobservable: vec!["mean friction_force".into()],
        note: None,
        numbers: vec![("condition".into(), 3.0)],
        time: (0..samples).map(|k| k as f64 / 8192.0).collect(),
        friction_force: estimate(0.0),
        normal_force: estimate(0.1),
        slip_displacement: estimate(0.2),
        slip_velocity: estimate(0.3),
        acceleration_fit: vec![estimate(0.4), estimate(0.5)],
        second_support_force: None,
        coefficients: coefficients(),
    };
    Reconstruction { title: "a rig".into(), sensor_position: vec![0.2, 0.4], runs: vec![run] }
}

#[test]
fn measurement_comes_back() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("rig.h5");
    write_measurement(&path, &measurement(), Some(&truth())).unwrap();
    assert_eq!(read_measurement(&path).unwrap(), measurement());
    let file = DataFile::open(&path).unwrap();
    let friction = file.array("/truth/runs/0001/friction_force").unwrap();
    assert_eq!(friction.values, truth().runs[0].friction_force);
    // Nothing but the file itself is left in the folder.
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
}

#[test]
fn contact_record_comes_back() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("contact.h5");
    write_contact_record(&path, &contact_record()).unwrap();
    assert_eq!(read_contact_record(&path).unwrap(), contact_record());
    assert!(matches!(read(&path).unwrap(), Recording::Contact(_)));
    let message = read_measurement(&path).unwrap_err().to_string();
    assert!(message.ends_with("/: the file is a contact record; give a measurement file here"), "{message}");

    // An unknown moving mass is written as NaN and is still NaN afterwards.
    write_contact_record(&path, &ContactRecord { moving_mass: Some(f64::NAN), ..contact_record() }).unwrap();
    assert!(read_contact_record(&path).unwrap().moving_mass.unwrap().is_nan());
}

#[test]
fn reconstruction_is_readable() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("rec.h5");
    write_reconstruction(&path, &reconstruction()).unwrap();
    let file = DataFile::open(&path).unwrap();
    let fit = file.array("/runs/0001/acceleration_fit").unwrap();
    assert_eq!(fit.shape, [1500, 2]);
    assert_eq!(fit.columns()[1], reconstruction().runs[0].acceleration_fit[1].values);
    let (real, imaginary) = file.complex("/runs/0001/harmonics/friction_force").unwrap();
    assert_eq!((real.values, imaginary.values), (vec![0.0, 1.0, 0.5], vec![0.0, -2.0, 0.25]));
}

/// The reference library is the judge of what we write, where it is installed.
#[test]
fn h5py_opens_every_file() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    write_measurement(path("rig.h5"), &measurement(), Some(&truth())).unwrap();
    write_contact_record(path("contact.h5"), &contact_record()).unwrap();
    write_reconstruction(path("rec.h5"), &reconstruction()).unwrap();
    let script = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/check_with_h5py.py");
    let files = [path("rig.h5"), path("contact.h5"), path("rec.h5")];
    let Ok(output) = std::process::Command::new("python3").arg(script).args(files).output() else {
        println!("skipped: there is no python3");
        return;
    };
    let text = String::from_utf8_lossy(&output.stdout);
    if output.status.code() == Some(3) {
        println!("skipped: {text}");
        return;
    }
    assert!(output.status.success() && text.matches(": well").count() == 3, "{text}");
}

#[test]
fn a_failed_write_leaves_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("missing").join("rig.h5");
    let message = write_measurement(&path, &measurement(), None).unwrap_err().to_string();
    assert!(message.contains("cannot be written"), "{message}");
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
}
