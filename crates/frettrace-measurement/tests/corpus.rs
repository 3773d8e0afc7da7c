//! The HDF5 corpus: one measurement in every way h5py can store it, and damaged files.
#![allow(clippy::unwrap_used, reason = "a test")]

use std::path::PathBuf;
use std::time::{Duration, Instant};

use frettrace_measurement::{
    Beam, Exciter, Measurement, Run, Sensors, SlipKind, Source, Support, read_measurement,
};

const SAMPLES: usize = 40;
const SENSORS: usize = 3;

fn corpus(prefix: &str) -> Vec<PathBuf> {
    let folder = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("tests/corpus");
    let files = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    let wanted = |path: &PathBuf| {
        let name = path.file_name().unwrap().to_string_lossy();
        name.starts_with(prefix) && name.ends_with(".h5")
    };
    let mut files: Vec<PathBuf> = files.filter(wanted).collect();
    files.sort();
    files
}

/// The run as `make_corpus.py` makes it.
fn run(number: usize) -> Run {
    let acceleration =
        |s: usize| (0..SAMPLES).map(|k| ((7 * k + 3 * s + number) % 64) as f64 / 4.0 - 8.0).collect();
    Run {
        id: format!("{number:04}"),
        label: format!("level {number}"),
        sampling_rate: 4096.0,
        excitation_frequency: 50.0,
        preload: 75.0,
        lubricated: Some(number % 2 == 1),
        temperature: None,
        acceleration: (0..SENSORS).map(acceleration).collect(),
        force: (0..SAMPLES).map(|k| ((5 * k + number) % 32) as f64 / 2.0 - 8.0).collect(),
    }
}

fn expected(runs: usize) -> Measurement {
    Measurement {
        title: "corpus".into(),
        source: Source::Measured,
        beam: Beam {
            length: 0.75,
            width: 0.03125,
            thickness: 0.0078125,
            youngs_modulus: 2.0e11,
            density: 7800.0,
            area: None,
            second_moment: None,
        },
        modes: None,
        support: Support {
            position: 0.75,
            slip: SlipKind::Rotation,
            lever_arm: 0.00390625,
            normal_stiffness: f64::INFINITY,
            law: "dahl".into(),
        },
        second_support: None,
        exciter: Exciter { position: 0.25 },
        sensors: Sensors {
            position: vec![0.25, 0.5, 0.625],
            noise_std: Some(vec![0.0625; SENSORS]),
            name: None,
        },
        runs: (1..=runs).map(run).collect(),
    }
}

#[test]
fn every_good_file_holds_the_same() {
    let files = corpus("good_");
    // As many as `make_corpus.py` writes: none was forgotten in the repository.
    assert_eq!(files.len(), 28);
    let mut failures = Vec::new();
    for path in files {
        let runs = if path.to_string_lossy().contains("many_runs") { 12 } else { 2 };
        match read_measurement(&path) {
            Ok(found) if found == expected(runs) => {}
            Ok(_) => failures.push(format!("{}: read, but other values", path.display())),
            Err(error) => failures.push(error.to_string()),
        }
    }
    assert!(failures.is_empty(), "{failures:#?}");
}

#[test]
fn every_damaged_file_is_refused_in_one_line() {
    let files = corpus("bad_");
    assert_eq!(files.len(), 15);
    for path in files {
        let start = Instant::now();
        let message = read_measurement(&path).unwrap_err().to_string();
        assert!(message.starts_with(&path.display().to_string()), "{message}");
        assert!(!message.contains('\n') && message.contains(';'), "{message}");
        assert!(message.contains("cannot be read") || message.contains("is not an HDF5 file"), "{message}");
        // A hang would be minutes; reading takes milliseconds even on a busy machine.
        assert!(start.elapsed() < Duration::from_secs(10), "{}", path.display());
    }
}
