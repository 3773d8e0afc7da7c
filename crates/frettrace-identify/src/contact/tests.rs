//! Histories come from the state equations of the contract by the classical Runge-Kutta rule in fine steps, not from
//! the steps of the laws under test.

use super::{Closure, ContactHistory, ContactSettings, Extras, Family, NoiseDraw, identify_contact};
use rand::SeedableRng;
use rand_distr::{Distribution, StandardNormal};
use std::f64::consts::TAU;

/// The parameters of all laws of the contract's table.
#[derive(Clone, Copy)]
struct Truth {
    sigma0: f64,
    sigma1: f64,
    v_d: f64,
    sigma2: f64,
    mu_s: f64,
    mu_k: f64,
    v_s: f64,
    breakaway: Option<f64>,
}

const DAHL: Truth = Truth {
    sigma0: 4.0e5,
    sigma1: 0.0,
    v_d: 1.0,
    sigma2: 0.0,
    mu_s: 0.3,
    mu_k: 0.3,
    v_s: 1.0,
    breakaway: None,
};

impl Truth {
    fn friction(&self, v: f64) -> f64 {
        self.mu_k + (self.mu_s - self.mu_k) * (-(v / self.v_s).powi(2)).exp()
    }

    fn rate(&self, z: f64, v: f64) -> f64 {
        let r = self.sigma0 * z * v.signum() / self.friction(v);
        let alpha = match self.breakaway {
            None => 1.0,
            Some(low) if r <= low => 0.0,
            Some(_) if r >= 1.0 => 1.0,
            Some(low) => 0.5 + 0.5 * (std::f64::consts::PI * ((r - low) / (1.0 - low) - 0.5)).sin(),
        };
        v * (1.0 - alpha * r)
    }

    fn force(&self, z: f64, v: f64, normal: f64) -> f64 {
        let sigma1 = self.sigma1 * (-(v / self.v_d).powi(2)).exp();
        normal * (self.sigma0 * z + sigma1 * self.rate(z, v)) + self.sigma2 * v
    }
}

/// Twelve periods of `u = A(sin τ + 0.2 sin 3τ)` and the last one kept, `samples` samples of 40 fine steps each.
fn history(truth: &Truth, (amplitude, frequency): (f64, f64), samples: usize) -> ContactHistory {
    let omega = TAU * frequency;
    let fine = 40;
    let dt = 1.0 / (frequency * (samples * fine) as f64);
    let slip = |t: f64| amplitude * ((omega * t).sin() + 0.2 * (3.0 * omega * t).sin());
    let velocity = |t: f64| amplitude * omega * ((omega * t).cos() + 0.6 * (3.0 * omega * t).cos());
    let normal = 50.0;
    let (mut z, mut force) = (0.0, Vec::new());
    for k in 0..12 * samples * fine {
        let t = k as f64 * dt;
        if k >= 11 * samples * fine && k % fine == 0 {
            force.push(truth.force(z, velocity(t), normal));
        }
        let f = |z: f64, t: f64| truth.rate(z, velocity(t));
        let k1 = f(z, t);
        let k2 = f(z + 0.5 * dt * k1, t + 0.5 * dt);
        let k3 = f(z + 0.5 * dt * k2, t + 0.5 * dt);
        let k4 = f(z + dt * k3, t + dt);
        z += dt / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4);
    }
    let time: Vec<f64> = (0..samples).map(|k| (k * fine) as f64 * dt).collect();
    ContactHistory {
        label: format!("{amplitude}"),
        slip: time.iter().map(|t| slip(*t)).collect(),
        velocity: time.iter().map(|t| velocity(*t)).collect(),
        acceleration: None,
        normal: vec![normal; samples],
        force,
        closure: Closure::Periodic { period: 1.0 / frequency },
        mean_is_seen: false,
        force_std: 1e-3,
        draws: Vec::new(),
        first: 0,
        time,
    }
}

/// Levels in a ladder of a factor of two around the sliding distance μ/σ0 = 0.75 µm: from 0.3 to 20 of them.
fn ladder(truth: &Truth, frequency: f64) -> Vec<ContactHistory> {
    (0..7)
        .map(|k| history(truth, (0.3 * truth.mu_k / truth.sigma0 * 2.0_f64.powi(k), frequency), 256))
        .collect()
}

/// A smooth periodic error: eight random lines of the given standard deviation.
fn error(std: f64, frequency: f64, time: &[f64], generator: &mut rand_pcg::Pcg64) -> (Vec<f64>, Vec<f64>) {
    let mut draw = || -> f64 { StandardNormal.sample(generator) };
    let lines: Vec<(f64, f64)> = (0..8).map(|_| (draw(), draw())).collect();
    let scale = std / 8.0_f64.sqrt();
    time.iter()
        .map(|t| {
            lines.iter().enumerate().fold((0.0, 0.0), |(x, v), (h, (a, b))| {
                let omega = TAU * frequency * (h + 1) as f64;
                let (s, c) = (omega * t).sin_cos();
                (x + scale * (a * c + b * s), v + scale * omega * (b * c - a * s))
            })
        })
        .unzip()
}

/// Adds noise to slip and force and gives the history draws of the same noise.
fn noisy(mut history: ContactHistory, (slip_std, force_std): (f64, f64), seed: u64) -> ContactHistory {
    let Closure::Periodic { period } = history.closure else { return history };
    let mut generator = rand_pcg::Pcg64::seed_from_u64(seed);
    let time = history.time.clone();
    let mut draw = || {
        let (slip, velocity) = error(slip_std, 1.0 / period, &time, &mut generator);
        let (force, _) = error(force_std, 1.0 / period, &time, &mut generator);
        NoiseDraw { slip, velocity, force }
    };
    let truth = draw();
    history.draws = (0..24).map(|_| draw()).collect();
    for k in 0..history.len() {
        history.slip[k] += truth.slip[k];
        history.velocity[k] += truth.velocity[k];
        history.force[k] += truth.force[k];
    }
    history.force_std = force_std;
    history
}

fn relative(fit: &super::ContactFit, name: &str, truth: f64) -> f64 {
    (fit.identified.parameter(name).unwrap().value - truth).abs() / truth
}

/// Exact data: what is left is the error of the law's step against fine Runge-Kutta, below 1e-4 at 256 samples.
#[test]
fn dahl_is_found_in_exact_loops() {
    let loops = ladder(&DAHL, 50.0);
    let used: Vec<_> = loops.iter().collect();
    let fit = identify_contact(Family::Dahl, &used, &ContactSettings::default()).unwrap();
    for (name, truth) in [("sigma0", 4.0e5), ("mu_k", 0.3), ("exponent", 1.0)] {
        assert!(relative(&fit, name, truth) < 1e-3, "{name} {:?}", fit.identified.parameters);
    }
    assert!(fit.error < 1e-4, "{}", fit.error);
}

/// What another law makes, the law that contains it makes too, and started there it leaves no more: here what the step of the
/// law leaves (as above).
#[test]
fn a_law_that_contains_another_is_no_worse() {
    let loops = ladder(&DAHL, 50.0);
    let used: Vec<_> = loops.iter().collect();
    let dahl = [4.0e5, 0.3, 1.0];
    let lugre = Family::LuGre.nearest((Family::Dahl, &dahl), &[1.0; 8]);
    assert_eq!(lugre, [4.0e5, 0.3, 0.0, 1.0, 0.0, 0.3, 1.0, 1.0]);
    let back = Family::LuGre.values(&Family::LuGre.law(&lugre));
    assert!(back.iter().zip(&lugre).all(|(a, b)| (a - b).abs() < 1e-12 * b.max(1.0)), "{back:?}");
    let settings = ContactSettings { starts: 1, profiles: false, ..ContactSettings::default() };
    let smaller = identify_contact(Family::Dahl, &used, &settings).unwrap();
    let fitted = vec![(Family::Dahl, smaller.law_values())];
    let larger =
        identify_contact(Family::LuGre, &used, &ContactSettings { fitted, ..settings.clone() }).unwrap();
    assert!(larger.error < 1e-4 && smaller.error < 1e-4, "{} {}", larger.error, smaller.error);
}

#[test]
fn lugre_is_found_in_exact_loops() {
    let truth = Truth { sigma1: 20.0, v_d: 2e-3, sigma2: 40.0, mu_s: 0.4, v_s: 1e-3, ..DAHL };
    let loops = ladder(&truth, 50.0);
    let used: Vec<_> = loops.iter().collect();
    let fit = identify_contact(Family::LuGre, &used, &ContactSettings::default()).unwrap();
    for (name, truth) in [("sigma0", 4.0e5), ("mu_k", 0.3), ("mu_s", 0.4), ("v_s", 1e-3), ("delta", 2.0)] {
        assert!(relative(&fit, name, truth) < 0.02, "{name} {:?}", fit.identified.parameters);
    }
}

#[test]
fn hybrid_is_found_in_exact_loops() {
    let truth = Truth { sigma1: 20.0, v_d: 2e-3, mu_s: 0.4, v_s: 1e-3, breakaway: Some(0.35), ..DAHL };
    let loops = ladder(&truth, 50.0);
    let used: Vec<_> = loops.iter().collect();
    let fit = identify_contact(Family::Hybrid, &used, &ContactSettings::default()).unwrap();
    for (name, truth) in [("sigma0", 4.0e5), ("mu_k", 0.3), ("mu_s", 0.4), ("v_s", 1e-3), ("breakaway", 0.35)]
    {
        assert!(relative(&fit, name, truth) < 0.02, "{name} {:?}", fit.identified.parameters);
    }
}

/// Slip wrong by 1 % of the sliding distance and force by 0.3 %: the intervals of 40 rigs hold the truth in at least
/// 85 % (the binomial standard error of 40 draws of 95 % is 3.4 %).
#[test]
fn intervals_know_of_the_noise_in_slip() {
    let loops = ladder(&DAHL, 50.0);
    let settings = ContactSettings { starts: 1, profiles: false, ..ContactSettings::default() };
    let mut inside = 0;
    for seed in 0..40 {
        let noisy: Vec<_> = loops
            .iter()
            .enumerate()
            .map(|(k, h)| noisy(h.clone(), (7.5e-9, 0.05), 100 * seed + k as u64))
            .collect();
        let used: Vec<_> = noisy.iter().collect();
        let fit = identify_contact(Family::Dahl, &used, &settings).unwrap();
        for (name, truth) in [("sigma0", 4.0e5), ("mu_k", 0.3)] {
            let (low, high) = fit.identified.parameter(name).unwrap().interval95.unwrap();
            inside += i32::from(low <= truth && truth <= high);
        }
    }
    assert!(inside >= 68, "{inside} of 80");
}

/// Loops that slide 160 to 640 sliding distances under noise of a fifth of the force do not show their stiffness (SCIENCE: sensitivity falls as 1/a).
#[test]
fn stiffness_is_not_identifiable_from_wide_loops() {
    let loops: Vec<_> = (0..3)
        .map(|k| {
            let wide = history(&DAHL, (160.0 * 0.75e-6 * 2.0_f64.powi(k), 50.0), 256);
            noisy(wide, (1e-6, 3.0), k as u64)
        })
        .collect();
    let used: Vec<_> = loops.iter().collect();
    let fit = identify_contact(Family::Dahl, &used, &ContactSettings::default()).unwrap();
    assert!(
        !fit.identified.parameter("sigma0").unwrap().is_identifiable(),
        "{:?}",
        fit.identified.parameters
    );
    assert!(fit.identified.parameter("mu_k").unwrap().is_identifiable());
}

/// A mass of 0.02 kg moves with the contact; force = m·a + friction.
#[test]
fn moving_mass_is_found() {
    let mut loops = ladder(&DAHL, 50.0);
    for history in &mut loops {
        let omega = TAU * 50.0;
        let amplitude = history.label.parse::<f64>().unwrap();
        let acceleration =
            |t: f64| -amplitude * omega * omega * ((omega * t).sin() + 1.8 * (3.0 * omega * t).sin());
        history.acceleration = Some(history.time.iter().map(|t| acceleration(*t)).collect());
        for k in 0..history.len() {
            history.force[k] += 20.0 * acceleration(history.time[k]);
        }
    }
    let used: Vec<_> = loops.iter().collect();
    let extras = Extras { wanted_mass: true, ..Extras::default() };
    let fit =
        identify_contact(Family::Dahl, &used, &ContactSettings { extras, ..Default::default() }).unwrap();
    assert!(relative(&fit, "moving_mass", 20.0) < 1e-3, "{:?}", fit.identified.parameters);
    assert!(relative(&fit, "sigma0", 4.0e5) < 2e-3);
}
