//! Uncertainty is a promise: over many rigs of other sensors, noise, levels and modes that are off as much as declared,
//! the truth lies inside the stated band in 90 to 98 % of the samples. The contact of these rigs yields exactly as beam theory
//! says, so that slip, whose band allows for contacts that do not, is inside nearly always; the validation case
//! `verify_reconstruction_bands` draws the contact's compliance too.
#![allow(clippy::unwrap_used)] // helpers of tests may fail as tests do

mod oracle;

use frettrace_inverse::{Channel, Options, reconstruct};
use oracle::{Loads, Oracle, nothing, saturating};
use rand::SeedableRng;
use rand_distr::Distribution;
use std::f64::consts::TAU;

const RIGS: u64 = 24;

/// Share of samples inside the band, means removed.
fn inside(found: &Channel, truth: &[f64]) -> f64 {
    let n = truth.len() as f64;
    let offset = found.values.iter().zip(truth).map(|(a, b)| a - b).sum::<f64>() / n;
    let hits = found.values.iter().zip(truth).zip(&found.std);
    hits.filter(|((a, b), s)| (*a - *b - offset).abs() <= 1.96 * **s).count() as f64 / n
}

/// One rig: three to eight sensors anywhere on the beam, noise of 0.1 to 5 % of the level, frequencies off by 2e-4.
fn one(seed: u64) -> [f64; 3] {
    let mut random = rand_pcg::Pcg64::seed_from_u64(seed);
    let mut uniform = |low: f64, high: f64| rand_distr::Uniform::new(low, high).unwrap().sample(&mut random);
    let count = uniform(3.0, 8.99) as usize;
    let mut sensors: Vec<f64> = (0..count).map(|_| uniform(0.1, 0.68)).collect();
    sensors.sort_by(f64::total_cmp);
    let frequency = uniform(42.0, 60.0);
    let size = uniform(0.5, 2.0);
    let share = 10.0_f64.powf(uniform(-3.0, -1.3));
    let oracle = Oracle::new(5e6, &sensors);
    let exciter = |t: f64| 0.7 * (TAU * frequency * t).cos();
    let friction = |t: f64| size * saturating(frequency, t);
    let loads =
        Loads { exciter: &exciter, friction: &friction, second: &nothing, normal_deviation: &nothing };
    let mut record = oracle.march(&loads, 2.5, 2048);
    let power: f64 = record.accelerations.iter().flatten().map(|a| a * a).sum();
    let level = (power / (count * 2048) as f64).sqrt();
    record.add_noise(share * level, seed + 1000);
    let off = if seed.is_multiple_of(2) { 2e-4 } else { -2e-4 };
    let rig = oracle.declared(&sensors, share * level, 6, off);
    let found = reconstruct(&rig, &[record.run(frequency)], &Options::default()).unwrap();
    let run = &found.runs[0];
    [
        inside(&run.friction_force, &record.friction),
        inside(&run.slip_displacement, &record.slip),
        inside(&run.slip_velocity, &record.velocity),
    ]
}

#[test]
fn truth_lies_inside_the_stated_band() {
    let all: Vec<[f64; 3]> = (0..RIGS).map(one).collect();
    let mean = |c: usize| all.iter().map(|r| r[c]).sum::<f64>() / RIGS as f64;
    let means = [mean(0), mean(1), mean(2)];
    // The mean of 24 rigs that spread by 0.1 scatters by 0.02.
    assert!((0.88..=0.99).contains(&means[0]), "friction, slip, velocity: {means:?}");
    assert!(means[1..].iter().all(|m| *m > 0.95), "friction, slip, velocity: {means:?}");
}
