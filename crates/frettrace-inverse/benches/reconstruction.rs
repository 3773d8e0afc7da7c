//! Cost of a whole reconstruction: eight runs of 4096 samples, six sensors; beside it one Fourier transform a channel.

use frettrace_beam::{BeamError, Boundary, ModalModel, ModalOptions, UniformBeam};
use frettrace_inverse::{ModeTrust, Options, Rig, RunData, Sensor, Slip, reconstruct};

fn main() {
    divan::main();
}

const SAMPLES: usize = 4096;
const RATE: f64 = 8192.0;
const FREQUENCY: f64 = 49.8;
const SENSORS: [f64; 6] = [0.11, 0.22, 0.33, 0.45, 0.56, 0.65];

fn rig() -> Result<Rig, BeamError> {
    let beam = UniformBeam::rectangular(0.7, [0.03, 0.006], 2.05e11, 7850.0);
    let options = ModalOptions { modes: 20, damping_ratio: vec![5e-3; 6], ..ModalOptions::default() };
    let structure = ModalModel::new(&beam, &Boundary::spring(5e6), &options)?;
    Ok(Rig {
        structure,
        trust: vec![ModeTrust { frequency: 1e-5, damping: 1e-3 }; 9],
        beam_modes: 38,
        slip: Slip::Rotation { lever_arm: 3e-3 },
        normal_stiffness: 5e6,
        second_support: None,
        exciter: 0.28,
        sensors: SENSORS.iter().map(|&position| Sensor { position, noise_std: Some(0.06) }).collect(),
    })
}

/// A signal with odd harmonics that fall, a share that fits no period, and something like noise.
fn signal(level: f64, place: f64, share: f64) -> Vec<f64> {
    let at = |j: usize| {
        let phase = std::f64::consts::TAU * FREQUENCY * j as f64 / RATE;
        let odd = |h: f64| (h * phase + place * h).cos() / (h * h);
        let beside = share * (2.0_f64.sqrt() * phase + place).cos();
        level * ((1..20).step_by(2).map(|h| odd(f64::from(h))).sum::<f64>() + beside)
            + 0.06 * (1e4 * (j as f64).sin()).sin()
    };
    (0..SAMPLES).map(at).collect()
}

fn channels(share: f64) -> Vec<Vec<Vec<f64>>> {
    let run = |level: f64| SENSORS.iter().chain(&[0.28]).map(|x| signal(level, *x, share)).collect();
    (0..8).map(|run_| run(2.0_f64.powi(run_))).collect()
}

/// All of them periodic, and none.
#[divan::bench(args = [0.0, 0.3])]
fn eight_runs(bencher: divan::Bencher<'_, '_>, share: f64) {
    let (Ok(rig), channels) = (rig(), channels(share)) else { return };
    let runs: Vec<RunData<'_>> = channels
        .iter()
        .map(|run| RunData {
            id: "run",
            sampling_rate: RATE,
            excitation_frequency: FREQUENCY,
            preload: 50.0,
            force: &run[6],
            accelerations: run[..6].iter().map(Vec::as_slice).collect(),
        })
        .collect();
    bencher.bench(|| reconstruct(&rig, &runs, &Options::default()));
}

#[divan::bench]
fn one_transform_a_channel(bencher: divan::Bencher<'_, '_>) {
    let channels = channels(0.0);
    bencher
        .bench(|| channels.iter().flatten().map(|x| frettrace_fourier::spectrum(x)[1]).collect::<Vec<_>>());
}
