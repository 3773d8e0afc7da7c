use std::collections::BTreeMap;
use std::f64::consts::TAU;

use frettrace_beam::{Boundary, Dof, ModalModel, ModalOptions, Receptance, UniformBeam};
use frettrace_friction::Law;
use num_complex::Complex64;
use rand::SeedableRng;

use super::filter::LowPass;
use super::*;
use crate::march::{Characteristic, Settling};

const RATE: f64 = 8192.0;
const SAMPLES: usize = 2048;
/// Periods in the record: whole, so that the discrete Fourier sum is exact.
const PERIODS: usize = 26;
const ARM: f64 = 0.0037;

fn rig() -> SimulatedRig {
    let parameters =
        BTreeMap::from([("sigma0", 5e5), ("mu_k", 0.25), ("exponent", 1.0)].map(|(n, v)| (n.to_owned(), v)));
    let model = Law::Dahl.with_named(&parameters).unwrap();
    SimulatedRig {
        beam: UniformBeam::rectangular(0.5, [0.03, 0.0075], 2.0e11, 7850.0),
        boundary: Boundary::spring(5e6),
        modes: 72,
        natural_frequency: Vec::new(),
        damping_ratio: vec![0.02],
        slip: Slip::Rotation { lever_arm: ARM },
        normal: NormalContact::default(),
        law: SimulatedLaw::Declared(model),
        exciter: 0.23,
        sensors: [0.1, 0.31, 0.46]
            .map(|position| SimulatedSensor { position, chain: Chain::default(), cross_talk: None })
            .to_vec(),
        attached: Vec::new(),
        second_support: None,
        base: None,
        exciter_lever: 0.0,
        second_force: None,
        sampling: Sampling { rate: RATE, samples: SAMPLES, oversampling: 16, steps: Steps::Given(1) },
        seed: 7,
    }
}

fn run() -> SimulatedRun {
    SimulatedRun {
        force_amplitude: 8.0,
        beat: None,
        omega: TAU * RATE * PERIODS as f64 / SAMPLES as f64,
        preload: 70.0,
        modulation: None,
        frequency_factor: 1.0,
        progress: 0.0,
    }
}

/// Line `h` of a record of whole periods.
fn line(signal: &[f64], h: usize) -> Complex64 {
    let step = TAU * (h * PERIODS) as f64 / signal.len() as f64;
    let sum: Complex64 = signal.iter().enumerate().map(|(k, x)| Complex64::cis(-step * k as f64) * x).sum();
    sum * 2.0 / signal.len() as f64
}

/// The linear balance `a = −ω²(H_se F_e − H_st F_t)` between the channels, with another number of modes.
fn check_balance(rig: &SimulatedRig, record: &SimulatedRecord, tolerance: f64) {
    let options =
        ModalOptions { modes: 110, damping_ratio: rig.damping_ratio.clone(), ..ModalOptions::default() };
    let model = ModalModel::new(&rig.beam, &rig.boundary, &options).unwrap();
    let scale = line(&record.acceleration[1], 1).norm();
    for h in [1, 3, 5, 9] {
        let omega = h as f64 * run().omega;
        let (force, friction) = (line(&record.force, h), line(&record.friction_force, h));
        let end = Dof::rotation(rig.beam.length);
        for (sensor, signal) in rig.sensors.iter().zip(&record.acceleration) {
            let place = Dof::displacement(sensor.position);
            let expected = (model.receptance(place, Dof::displacement(rig.exciter), omega) * force
                - model.receptance(place, end, omega) * friction * ARM)
                * -(omega * omega);
            let found = line(signal, h);
            assert!((found - expected).norm() < tolerance * scale, "line {h}: {found} {expected} of {scale}");
        }
        let slip = (model.receptance(end, Dof::displacement(rig.exciter), omega) * force
            - model.receptance(end, end, omega) * friction * ARM)
            * ARM;
        let found = line(&record.slip, h);
        assert!(
            (found - slip).norm() < 10.0 * tolerance * line(&record.slip, 1).norm(),
            "slip {h}: {found} {slip}"
        );
    }
}

#[test]
fn channels_obey_the_balance_of_another_model() {
    let record = simulate(&rig(), &run(), 0).unwrap();
    assert!(matches!(record.settling, Settling::Periodic { multiple: 1, .. }), "{:?}", record.settling);
    // The hold at 131 kHz: (ωΔt)²/12 = 3e-6 at the fundamental of 104 Hz, 2e-4 of the small ninth harmonic.
    check_balance(&rig(), &record, 1e-5);
    let third = line(&record.friction_force, 3).norm() / line(&record.friction_force, 1).norm();
    assert!(third > 0.02, "friction works: {third}");
    let largest = |signal: &[f64]| signal.iter().fold(0.0_f64, |m, f| m.max(f.abs()));
    let (level, pressed) = (largest(&record.friction_force), largest(&record.normal_force));
    // Dahl's force stays below μN at every instant; the filter rings by a few per cent.
    assert!(level < 0.25 * 1.05 * pressed && level > 0.25 * 70.0, "{level} {pressed}");
}

#[test]
fn the_same_seed_gives_the_same_record_and_noise_is_as_declared() {
    let mut noisy = rig();
    noisy.sensors[1].chain = Chain { noise: 0.5, noise_correlation: 0.8, ..Chain::default() };
    let clean = simulate(&rig(), &run(), 3).unwrap();
    let (first, second) = (simulate(&noisy, &run(), 3).unwrap(), simulate(&noisy, &run(), 3).unwrap());
    assert_eq!(first, second);
    assert_eq!(first.acceleration[0], clean.acceleration[0]);
    let noise: Vec<f64> =
        first.acceleration[1].iter().zip(&clean.acceleration[1]).map(|(a, b)| a - b).collect();
    let square = |lag: usize| -> f64 {
        noise.iter().zip(&noise[lag..]).map(|(a, b)| a * b).sum::<f64>() / (SAMPLES - lag) as f64
    };
    // Standard error of the variance of 2048 samples correlated with 0.8 (n_eff ~ 450): 7 %.
    assert!((square(0) / 0.25 - 1.0).abs() < 0.25, "{}", square(0));
    assert!((square(1) / square(0) - 0.8).abs() < 0.06, "{}", square(1) / square(0));
    let other = simulate(&noisy, &run(), 4).unwrap();
    assert_ne!(other.force, first.force);
}

#[test]
fn a_measuring_chain_does_what_it_says() {
    let chain = Chain {
        gain: 2.0,
        offset: 0.5,
        hum: Some(Hum { amplitude: 0.25, frequency: RATE / 4.0, phase: 0.0, third: 0.0 }),
        limit: 2.6,
        dropouts: vec![[0.75, 1.0]],
        ..Chain::default()
    };
    let mut signal = [1.0; 8];
    chain.apply(&mut signal, RATE, &mut rand_pcg::Pcg64::seed_from_u64(1));
    let expected = [2.5, 2.6, 2.5, 2.25, 2.5, 2.6, 0.0, 0.0];
    for (found, expected) in signal.iter().zip(expected) {
        assert!((found - expected).abs() < 1e-12, "{signal:?}");
    }
}

#[test]
fn the_filter_passes_delays_and_stops() {
    let oversampling = 8;
    let tone = |frequency: f64| -> Vec<f64> {
        (0..1200).map(|k| (TAU * frequency * k as f64 / oversampling as f64).sin()).collect()
    };
    for (frequency, gain) in [(0.01, 1.0), (0.2, 1.0), (0.39, 1.0), (0.55, 0.0), (1.7, 0.0)] {
        for shift in [0.0, 3.3] {
            let filter = LowPass::new(oversampling, shift);
            let found = filter.at(&tone(frequency), 600);
            let expected = gain * (TAU * frequency * (600.0 - shift) / oversampling as f64).sin();
            // 100 dB.
            assert!((found - expected).abs() < 3e-5, "{frequency} {shift}: {found} {expected}");
        }
    }
}

#[test]
fn effects_of_the_structure_change_the_record() {
    let plain = simulate(&rig(), &run(), 0).unwrap();
    let difference = |rig: &SimulatedRig, run: &SimulatedRun| {
        let record = simulate(rig, run, 0).unwrap();
        let (a, b) = (line(&record.acceleration[1], 1), line(&plain.acceleration[1], 1));
        (a - b).norm() / b.norm()
    };
    let attach = |what| SimulatedRig { attached: vec![(0.3, what)], ..rig() };
    assert!(difference(&attach(Attached::Mass(0.02)), &run()) > 1e-2);
    assert!(difference(&attach(Attached::Load(Characteristic::CubicSpring(1e10))), &run()) > 1e-3);
    // A mass and a load that are nothing change nothing but rounding.
    assert!(difference(&attach(Attached::Mass(0.0)), &run()) < 1e-9);
    let drifted = SimulatedRun { frequency_factor: 0.99, ..run() };
    assert!(difference(&rig(), &drifted) > 1e-2);
    // The dynamic load is 56 N: below the preload of 70 N, above one of 30 N.
    let lifting =
        SimulatedRig { normal: NormalContact { lifts_off: true, ..NormalContact::default() }, ..rig() };
    // Both are settled to 1e-8 a period of a motion that forgets 12 % a period.
    assert!(difference(&lifting, &run()) < 1e-6);
    let light = SimulatedRun { preload: 30.0, ..run() };
    let (held, open) = (simulate(&rig(), &light, 0).unwrap(), simulate(&lifting, &light, 0).unwrap());
    let distance = line(&held.acceleration[1], 1) - line(&open.acceleration[1], 1);
    assert!(distance.norm() > 1e-4 * line(&held.acceleration[1], 1).norm());
    let (low, high) = open.normal_force.iter().fold((0.0_f64, 0.0_f64), |(l, h), &n| (l.min(n), h.max(n)));
    // The anti-alias filter rings by up to 9 % of a jump.
    assert!(low > -0.1 * high, "{low} {high}");
}

#[test]
fn a_stop_is_reported_as_the_second_support() {
    let stop = Attached::Load(Characteristic::Stop { stiffness: 2e5, gap: 1e-6 });
    let with_stop = SimulatedRig {
        attached: vec![(0.2, Attached::Mass(0.01)), (0.3, stop)],
        second_support: Some(1),
        ..rig()
    };
    let record = simulate(&with_stop, &run(), 0).unwrap();
    let force = record.second_support_force.unwrap();
    let (low, high) = force.iter().fold((0.0_f64, 0.0_f64), |(l, h), &f| (l.min(f), h.max(f)));
    assert!(low < -1.0, "it is struck: {low}");
    // One-sided but for the ringing of the anti-alias filter at the edges of the contact.
    assert!(high < 0.15 * -low, "it never pulls: {high} {low}");
}

/// Filters of a chain against their frequency responses `1/(1 + iωτ)` and `iω/(ω_c + iω)`; distortions against their formulas.
#[test]
fn distortions_do_what_they_say() {
    let tone = |count: usize| -> Vec<f64> { (0..count).map(|k| (TAU * k as f64 / 64.0).sin()).collect() };
    let settled = |distortion: Distortion| {
        let mut signal = tone(64);
        distortion.apply(&mut signal, 64.0, &tone(64 * 40));
        line_of_period(&signal)
    };
    let source = line_of_period(&tone(64));
    let low = source / Complex64::new(1.0, TAU * 0.1);
    // Samples joined by straight lines: (ωΔt)²/12 of the amplitude.
    assert!((settled(Distortion::LowPass(0.1)) - low).norm() < 1e-3);
    let high = source * Complex64::new(0.0, 1.0) / Complex64::new(0.2, 1.0);
    assert!((settled(Distortion::HighPass(0.2)) - high).norm() < 1e-3);
    for (distortion, expected) in
        [(Distortion::Quadratic(0.1), 4.0 * 1.4), (Distortion::SoftLimit(4.0), 4.0 / 2.0_f64.powf(0.125))]
    {
        let mut signal = [4.0];
        distortion.apply(&mut signal, 1.0, &[]);
        assert!((signal[0] - expected).abs() < 1e-12, "{signal:?}");
    }
}

/// Fundamental of one period of samples.
fn line_of_period(signal: &[f64]) -> Complex64 {
    let step = TAU / signal.len() as f64;
    signal.iter().enumerate().map(|(k, x)| Complex64::from_polar(*x, -step * k as f64)).sum::<Complex64>()
        * (2.0 / signal.len() as f64)
}

/// An aluminium beam whose friction falls with slip velocity, so that modes far beyond the recorded band are excited while it slides.
fn chattering(modes: usize) -> SimulatedRig {
    let values = [3.1e4, 9.6, 3.3e-2, 27.7, 3.33e-2, 2.2e-2, 9.9e-3, 2.0, 0.54];
    SimulatedRig {
        beam: UniformBeam::rectangular(0.746, [0.0427, 0.00847], 7.06e10, 2699.0),
        boundary: Boundary::spring(8.8e5),
        modes,
        damping_ratio: vec![0.005],
        slip: Slip::Rotation { lever_arm: 0.00479 },
        law: SimulatedLaw::Declared(Law::Hybrid.with_values(&values).unwrap()),
        exciter: 0.36,
        sampling: Sampling { rate: 4096.0, samples: 1024, oversampling: 15, steps: Steps::Within(0.0146) },
        ..rig()
    }
}

/// Where the modes beyond the recorded band do not chatter, leaving them out, flexibility apart, leaves the record as it is: within the
/// tenth of the noise of 0.15 m/s² that is asked of the steps. Where they do, the record is made without them, and says so.
#[test]
fn a_contact_that_chatters_is_marched_with_the_modes_that_can_be_recorded() {
    let run = |force_amplitude: f64| SimulatedRun {
        force_amplitude,
        beat: None,
        omega: TAU * 54.56,
        preload: 464.7,
        modulation: None,
        frequency_factor: 1.0,
        progress: 0.0,
    };
    let [all, fewer] = [72, 30].map(|modes| simulate(&chattering(modes), &run(0.84), 0).unwrap());
    assert_eq!([all.marching.modes, fewer.marching.modes], [72, 30]);
    for (a, b) in all.acceleration.iter().zip(&fewer.acceleration) {
        let square = a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum::<f64>() / a.len() as f64;
        assert!(square.sqrt() < 0.0146, "{}", square.sqrt());
    }
    let driven = simulate(&chattering(72), &run(2.33), 0).unwrap();
    // 30 modes lie below half the fine rate of 61 kHz.
    assert_eq!(driven.marching.modes, 30);
    assert!(driven.marching.is_met(), "{:?}", driven.marching);
    assert!(matches!(driven.settling, Settling::Periodic { multiple: 1, .. }), "{:?}", driven.settling);
}

/// Falling friction without a presliding range, on the modes that are recorded: nothing settles, no step is short enough, and the answer
/// comes all the same, marked as one of many.
#[test]
fn a_motion_that_cannot_be_resolved_is_recorded_and_marked() {
    let values = [0.36, 0.2, 2e-3, 1.0, 0.0];
    let law = SimulatedLaw::Declared(Law::Stribeck.with_values(&values).unwrap());
    let steps = Steps::Within(1e-3);
    let sampling = Sampling { samples: 512, steps, ..rig().sampling };
    let wild = SimulatedRig { law, sampling, damping_ratio: vec![0.003], ..rig() };
    let record = simulate(&wild, &run(), 0).unwrap();
    assert_eq!(record.marching.change, Some(f64::INFINITY));
    assert!(!record.marching.is_met() && record.marching.rate < 5e6, "{:?}", record.marching);
    assert!(record.acceleration.iter().flatten().all(|a| a.is_finite()));
}
