//! How long reading and writing take: a measurement file of eight runs, 4096 samples, seven sensors.

use frettrace_measurement::{
    Beam, Exciter, Measurement, Run, Sensors, SlipKind, Source, Support, read_measurement, write_measurement,
};

fn main() {
    divan::main();
}

/// A signal with noise in its low digits, as measured ones have: it hardly compresses.
fn signal(seed: u64) -> Vec<f64> {
    let mut state = seed;
    let noise = |state: &mut u64| {
        *state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (*state >> 11) as f64 / (1u64 << 53) as f64
    };
    (0..4096).map(|k| (0.04 * f64::from(k)).sin() + 0.01 * noise(&mut state)).collect()
}

fn measurement() -> Measurement {
    let run = |number: u64| Run {
        id: format!("{number:04}"),
        label: format!("level {number}"),
        sampling_rate: 8192.0,
        excitation_frequency: 50.0,
        preload: 75.0,
        lubricated: None,
        temperature: None,
        acceleration: (0..7).map(|sensor| signal(100 * number + sensor)).collect(),
        force: signal(number),
    };
    Measurement {
        title: "benchmark".into(),
        source: Source::Simulated,
        beam: Beam {
            length: 0.7,
            width: 0.03,
            thickness: 0.006,
            youngs_modulus: 2.0e11,
            density: 7800.0,
            area: None,
            second_moment: None,
        },
        modes: None,
        support: Support {
            position: 0.7,
            slip: SlipKind::Transverse,
            lever_arm: 0.0,
            normal_stiffness: 0.0,
            law: "dahl".into(),
        },
        second_support: None,
        exciter: Exciter { position: 0.3 },
        sensors: Sensors {
            position: (1..=7).map(|sensor| 0.1 * f64::from(sensor)).map(|x| x.min(0.69)).collect(),
            noise_std: None,
            name: None,
        },
        runs: (1..=8).map(run).collect(),
    }
}

#[divan::bench]
fn write(bencher: divan::Bencher<'_, '_>) {
    let (folder, rig) = (tempfile::tempdir(), measurement());
    let Ok(folder) = folder else { return };
    bencher.bench(|| write_measurement(folder.path().join("rig.h5"), &rig, None).is_ok());
}

#[divan::bench]
fn read(bencher: divan::Bencher<'_, '_>) {
    let Ok(folder) = tempfile::tempdir() else { return };
    let path = folder.path().join("rig.h5");
    if write_measurement(&path, &measurement(), None).is_ok() {
        bencher.bench(|| read_measurement(&path).map(|rig| rig.runs.len()).unwrap_or(0));
    }
}
