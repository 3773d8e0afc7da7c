//! Bytes changed at random in good files: data or an error, never a panic, never a hang.
#![allow(clippy::unwrap_used, reason = "a test")]

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use frettrace_measurement::{read, read_table};

/// Damaged copies of every file. Enough to meet each part of a header; a thousand times as many were tried once.
const COPIES: u64 = 30;

/// Knuth's linear congruential generator (TAOCP 2, 3.3.4, table 1, line 26): only spread is asked of it.
fn next(state: &mut u64) -> usize {
    *state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
    (*state >> 33) as usize
}

fn damaged(bytes: &[u8], seed: u64) -> Vec<u8> {
    let mut state = seed;
    let mut copy = bytes.to_vec();
    for _ in 0..1 + next(&mut state) % 4 {
        // Half of the changes in the first part, where the headers are.
        let reach = if next(&mut state).is_multiple_of(2) { copy.len().min(4096) } else { copy.len() };
        let place = next(&mut state) % reach;
        copy[place] = match next(&mut state) % 4 {
            0 => 0xff,
            1 => 0,
            2 => copy[place] ^ (1 << (next(&mut state) % 8)),
            _ => next(&mut state) as u8,
        };
    }
    copy
}

fn try_all(folder: &str, attempt: impl Fn(&Path)) {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests").join(folder);
    let scratch = tempfile::tempdir().unwrap();
    let mut files: Vec<PathBuf> =
        std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    files.retain(|path| path.file_name().unwrap().to_string_lossy().starts_with("good_"));
    assert!(files.len() > 10);
    for file in files {
        let bytes = std::fs::read(&file).unwrap();
        let copy = scratch.path().join(file.file_name().unwrap());
        for seed in 0..COPIES {
            std::fs::write(&copy, damaged(&bytes, seed)).unwrap();
            let start = Instant::now();
            attempt(&copy);
            // Milliseconds, on a busy machine a second: a loop would be minutes.
            assert!(start.elapsed() < Duration::from_secs(20), "{} seed {seed}", file.display());
        }
    }
}

#[test]
fn damaged_hdf5_is_data_or_an_error() {
    try_all("corpus", |path| {
        if let Err(error) = read(path) {
            assert!(!error.to_string().contains('\n'), "{error}");
        }
    });
}

#[test]
fn damaged_laboratory_files_are_data_or_an_error() {
    try_all("formats", |path| {
        if let Err(error) = read_table(path) {
            assert!(!error.to_string().contains('\n'), "{error}");
        }
    });
}
