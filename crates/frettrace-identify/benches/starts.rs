//! What do sixteen starts cost? Steps (i) to (iv) of the identification on eight runs, for the laws with most parameters.

use std::f64::consts::TAU;
use std::ops::ControlFlow;

use frettrace_friction::{FrictionLaw, Law, Stretch};
use frettrace_identify::contact::{
    Closure, ContactHistory, ContactSettings, Family, NoiseDraw, identify_contact,
};
use rand::SeedableRng;
use rand_distr::{Distribution, StandardNormal};

/// Samples a period, as the loops recovered from accelerations have them.
const SAMPLES: usize = 256;
/// Draws of the noise beside each run.
const DRAWS: usize = 24;

fn main() {
    divan::main();
}

/// One period of the law's example values at a level, with half a per cent of noise in force and slip.
fn history(law: Law, level: u64) -> Option<ContactHistory> {
    let (frequency, amplitude) = (20.0, 3e-7 * 1.6_f64.powi(level as i32));
    let omega = TAU * frequency;
    let mut generator = rand_pcg::Pcg64::seed_from_u64(level);
    let mut noise = |size: f64| -> Vec<f64> {
        (0..SAMPLES).map(|_| Distribution::<f64>::sample(&StandardNormal, &mut generator) * size).collect()
    };
    let time: Vec<f64> = (0..4 * SAMPLES).map(|k| k as f64 / frequency / SAMPLES as f64).collect();
    let slip: Vec<f64> = time.iter().map(|t| amplitude * (omega * t).sin()).collect();
    let velocity: Vec<f64> = time.iter().map(|t| amplitude * omega * (omega * t).cos()).collect();
    let normal = vec![50.0; time.len()];
    let model = law.with_values(&law.example()).ok()?;
    let stretch = Stretch { slip: &slip, velocity: &velocity, normal: &normal, dt: time[1] };
    let mut force = vec![0.0];
    model.follow(model.rest(), &stretch, |_, _, value| {
        force.push(value);
        ControlFlow::Continue(())
    });
    let last = 3 * SAMPLES..;
    let errors = noise(0.05);
    let mut draw = || {
        let mut smooth = |size: f64| vec![size * noise(1.0)[0]; SAMPLES];
        NoiseDraw { slip: smooth(0.005 * amplitude), velocity: smooth(0.0), force: smooth(0.05) }
    };
    Some(ContactHistory {
        label: level.to_string(),
        draws: (0..DRAWS).map(|_| draw()).collect(),
        force: force[last.clone()].iter().zip(&errors).map(|(f, e)| f + e).collect(),
        slip: slip[last.clone()].to_vec(),
        velocity: velocity[last.clone()].to_vec(),
        acceleration: None,
        normal: normal[last.clone()].to_vec(),
        closure: Closure::Periodic { period: 1.0 / frequency },
        mean_is_seen: false,
        force_std: 0.05,
        first: 0,
        time: time[..SAMPLES].to_vec(),
    })
}

fn sixteen_starts(bencher: divan::Bencher, law: Law, family: Family) {
    let Some(runs) = (0..8).map(|level| history(law, level)).collect::<Option<Vec<_>>>() else { return };
    let used: Vec<&ContactHistory> = runs.iter().collect();
    let settings = ContactSettings { starts: 16, profiles: false, ..ContactSettings::default() };
    bencher.bench(|| identify_contact(family, &used, &settings).map(|fit| fit.error));
}

#[divan::bench(sample_count = 10)]
fn lugre(bencher: divan::Bencher) {
    sixteen_starts(bencher, Law::Lugre, Family::LuGre);
}

#[divan::bench(sample_count = 10)]
fn hybrid(bencher: divan::Bencher) {
    sixteen_starts(bencher, Law::Hybrid, Family::Hybrid);
}
