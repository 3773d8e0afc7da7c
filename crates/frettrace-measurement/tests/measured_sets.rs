//! The sets of `data/registry.toml`: the raw files are those registered, and every conversion is plausible.
//! Skipped, with the reason printed, where the raw files are not there.
#![allow(clippy::unwrap_used, clippy::print_stdout, reason = "a test")]

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use frettrace_measurement::{ContactRun, Recording, convert, read_table};
use sha2::{Digest, Sha256};

fn repository() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

/// The folder of the raw files: `FRETTRACE_DATA` (or `measured` in it), or the one beside the repository.
fn raw() -> PathBuf {
    let folder = std::env::var_os("FRETTRACE_DATA").map(PathBuf::from);
    let folder = folder.unwrap_or_else(|| repository().join("../shared/data/measured"));
    let inner = folder.join("measured");
    if inner.is_dir() { inner } else { folder }
}

/// Whether all files are there; where not, the reason why a test leaves them out is printed.
fn present<'a>(names: impl IntoIterator<Item = &'a String>) -> bool {
    let absent = names.into_iter().map(|name| raw().join(name)).find(|path| !path.is_file());
    if let Some(path) = &absent {
        println!("skipped: {} is not there; set FRETTRACE_DATA", path.display());
    }
    absent.is_none()
}

#[derive(serde::Deserialize)]
struct Registry {
    set: Vec<Set>,
}

#[derive(serde::Deserialize)]
struct Set {
    folder: String,
    files: BTreeMap<String, String>,
}

fn registry() -> Vec<Set> {
    let text = std::fs::read_to_string(repository().join("data/registry.toml")).unwrap();
    toml::from_str::<Registry>(&text).unwrap().set
}

#[test]
fn raw_files_are_those_registered() {
    for set in registry().iter().filter(|set| present(set.files.keys())) {
        for (name, registered) in &set.files {
            let digest = Sha256::digest(std::fs::read(raw().join(name)).unwrap());
            let found: String = digest.iter().map(|byte| format!("{byte:02x}")).collect();
            assert_eq!(&found, registered, "{name}");
        }
    }
}

/// Work of the friction per travelled length (N): the mean friction force against the motion.
fn mean_friction(run: &ContactRun) -> f64 {
    let steps = run.force.windows(2).zip(run.slip_displacement.windows(2));
    let (work, way) = steps.fold((0.0, 0.0), |(work, way), (f, u)| {
        let step = u[1] - u[0];
        (work + 0.5 * (f[0] + f[1]) * step, way + step.abs())
    });
    work / way
}

/// Mean friction of the runs of a set (N): the size known from the rig, by which a wrong unit would show.
fn expected_friction(description: &str) -> std::ops::Range<f64> {
    match description {
        // Loops of ±1 to ±3.4 kip: 4 to 15 kN.
        name if name.contains("coble") => 2.0e3..15.0e3,
        // ±2.3 N of gross slip and partial slip at 5 N.
        name if name.contains("christopherson") => 0.8..2.5,
        // 3 to 17 N either way.
        name if name.contains("zillen") => 2.0..20.0,
        // Loops of 160 to 450 N from end to end, so at most ±225 N.
        _ => 30.0..225.0,
    }
}

#[test]
fn every_conversion_is_plausible() {
    let raw = raw();
    for set in registry().iter().filter(|set| present(set.files.keys())) {
        let mut conversions = 0;
        for entry in std::fs::read_dir(repository().join("data").join(&set.folder)).unwrap() {
            let path = entry.unwrap().path();
            if path.extension().is_none_or(|extension| extension != "toml") {
                continue;
            }
            conversions += 1;
            let converted = convert(std::slice::from_ref(&raw), &path).unwrap();
            println!("{}: {:?}", path.display(), converted.remarks);
            let Recording::Contact(record) = converted.recording else { continue };
            // Nothing is doubted: units agree, velocities are derivatives, friction dissipates.
            assert_eq!(converted.remarks, Vec::<String>::new(), "{}", path.display());
            for run in &record.runs {
                let friction = mean_friction(run);
                println!("  {} {}: {friction:.4} N, {} samples", run.id, run.label, run.force.len());
                assert!(
                    expected_friction(&path.to_string_lossy()).contains(&friction),
                    "{}: {friction} N",
                    run.label
                );
            }
        }
        assert!(
            conversions > 0 || set.folder.contains("roller"),
            "{}: no conversion is described",
            set.folder
        );
    }
}

#[test]
fn the_roller_beam_is_read_as_a_table() {
    let name = String::from("dropbear_roller_beam/10steps_test1.txt");
    if !present([&name]) {
        return;
    }
    let table = read_table(raw().join(&name)).unwrap();
    let names: Vec<&str> = table.columns.iter().map(|column| column.name.as_str()).collect();
    assert_eq!(names, ["Low G Accel", "Accel", "PinLoc", "Time"]);
    // 14 s at 5000 Hz, as the set's README says.
    assert!(table.columns.iter().all(|column| column.values.len() == 70_000));
}
