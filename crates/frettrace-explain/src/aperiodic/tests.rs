//! Records made of a law along a motion of two incommensurable tones, marched in other steps than those of the search.

use super::balance::{frequencies_apart, is_shared, stretched};
use super::exhibit::exhibit;
use super::motion::{Motion, WholeRun};
use super::problem::OpenProblem;
use super::run::{Open, OpenRun, Wave};
use crate::records::RunSamples;
use frettrace_friction::Step;
use frettrace_friction::effects::{Circumstance, Hook, ModifiedLaw};
use frettrace_identify::{Model, Parameter};
use nalgebra::{DMatrix, DVector};
use num_complex::Complex64;
use std::f64::consts::TAU;
use std::sync::Arc;

const RATE: f64 = 4096.0;
const SAMPLES: usize = 2048;
/// Steps of the truth in a sample.
const STEPS: usize = 16;
const PRELOAD: f64 = 20.0;
/// Tones of the slip (Hz).
const TONES: [f64; 2] = [40.0, 27.4];

/// Slip (m) and slip velocity (m/s).
fn motion(t: f64) -> [f64; 2] {
    let [a, b] = TONES.map(|tone| TAU * tone);
    let size = 1e-4;
    [size * ((a * t).sin() + 0.6 * (b * t).cos()), size * (a * (a * t).cos() - 0.6 * b * (b * t).sin())]
}

/// A drift that no sensor sees: half a period in the record.
fn drift(t: f64) -> [f64; 2] {
    let rate = std::f64::consts::PI * RATE / SAMPLES as f64;
    [1e-4 * (rate * t).cos(), -1e-4 * rate * (rate * t).sin()]
}

fn dahl() -> ModifiedLaw<f64> {
    ModifiedLaw::dahl(4e4, 0.3)
}

/// Force of a law along the motion with so much of the drift, its preload modulated by `share` at `omega`.
fn force(law: &ModifiedLaw<f64>, drifted: f64, wave: Wave) -> Vec<f64> {
    let dt = 1.0 / (RATE * STEPS as f64);
    let place = |k: usize| {
        let t = k as f64 * dt;
        let ([u, v], [du, dv]) = (motion(t), drift(t));
        [u + drifted * du, v + drifted * dv]
    };
    let phase = |k: usize| {
        let (sine, cosine) = (wave.omega * k as f64 * dt + wave.phase).sin_cos();
        [cosine, sine]
    };
    let mut state = law.rest_at(place(0)[0]);
    let mut out = vec![0.0];
    for k in 1..SAMPLES * STEPS {
        let ends = |i: usize| [place(k - 1)[i], place(k)[i]];
        let step = Step { slip: ends(0), velocity: ends(1), normal: [PRELOAD; 2], dt };
        let circumstance =
            Circumstance { preload: PRELOAD, phase: [phase(k - 1), phase(k)], ..Circumstance::default() };
        let force;
        (state, force) = law.advance(state, &step, &circumstance);
        if k % STEPS == 0 {
            out.push(force);
        }
    }
    out
}

/// The run as it is recovered: without the drift, which is an error of unit size, and with one that only the force has.
fn recovered(force: Vec<f64>) -> OpenRun {
    let sampled = |of: &dyn Fn(f64) -> f64| (0..SAMPLES).map(|k| of(k as f64 / RATE)).collect::<Vec<f64>>();
    let found = Motion {
        force,
        slip: sampled(&|t| motion(t)[0]),
        velocity: sampled(&|t| motion(t)[1]),
        normal: vec![PRELOAD; SAMPLES],
    };
    let still = vec![0.0; SAMPLES];
    let drifting = Motion {
        force: still.clone(),
        slip: sampled(&|t| drift(t)[0]),
        velocity: sampled(&|t| drift(t)[1]),
        normal: still.clone(),
    };
    let off = Motion { force: found.slip.iter().map(|u| 1e3 * u).collect(), ..Motion::nothing(SAMPLES) };
    let bins = SAMPLES / 2 + 1;
    let whole = WholeRun {
        dt: 1.0 / RATE,
        found,
        shared: vec![drifting, off],
        own: vec![1e-4; bins],
        own_normal: vec![0.0; bins],
        left: Vec::new(),
        balance: [1.0, 1.0],
    };
    let circumstance = Circumstance { preload: PRELOAD, ..Circumstance::default() };
    let gain = Arc::new(vec![Complex64::ZERO; bins]);
    OpenRun::new(0, (Arc::new(whole), gain), (circumstance, false, TAU * TONES[0])).unwrap()
}

/// A law that is right leaves less than the accuracy of a force (χ² of 1) once the drift it was marched with is found, and finds that to an
/// eighth; without it, it misses more than twice that accuracy (χ² of 5).
#[test]
fn a_drift_that_no_sensor_sees_is_found_by_the_law() {
    let law = dahl();
    let run = recovered(force(&law, 0.8, Wave::default())).refined(2);
    let blind = run.left(&law, &DVector::zeros(2)).norm_squared() / run.count() as f64;
    assert!(blind > 5.0, "{blind}");
    let mut open = run.begin(&law).unwrap();
    for _ in 0..8 {
        run.settle(&law, &mut open);
        open = run.open(&law, open.xi.clone()).unwrap();
    }
    let (left, _) = run.settle(&law, &mut open);
    assert!(left.norm_squared() < run.count() as f64, "{}", left.norm_squared() / run.count() as f64);
    assert!((open.xi[0] - 0.8).abs() < 0.1, "{}", open.xi);
}

/// Turned errors span what the plain ones do: the cost at its minimum is the same.
#[test]
fn turned_errors_cost_the_same() {
    let law = dahl();
    let plain = recovered(force(&law, 0.3, Wave::default()));
    let cost = |run: &OpenRun| {
        let mut open = run.begin(&law).unwrap();
        for _ in 0..4 {
            run.settle(&law, &mut open);
            open = run.open(&law, open.xi.clone()).unwrap();
        }
        run.settle(&law, &mut open).1
    };
    let mut turned = plain.clone();
    turned.turn(&plain.begin(&law).unwrap());
    let [before, after] = [&plain, &turned].map(cost);
    // Where they begin differs, so that the march does in its last digits; directions that do less than a twentieth of a deviation are left.
    assert!((before - after).abs() < 0.02 * (1.0 + before), "{before} {after}");
}

/// The derivatives of the residual at errors that follow the law are those of differences.
#[test]
fn errors_follow_a_law() {
    let run = recovered(force(&dahl(), 0.3, Wave::default()));
    let parameter = |name: &str| Parameter::positive(name, "", (1e-9, 1e9));
    let problem = OpenProblem {
        runs: std::slice::from_ref(&run),
        law: dahl(),
        hooks: vec![Hook::Sigma0, Hook::MuKinetic],
        parameters: vec![parameter("sigma0"), parameter("mu_k")],
        held: false,
    };
    let (rows, values) = (problem.residual_count(), [4.2e4, 0.29]);
    let settled = |values: &[f64], memory: &mut Vec<Open>| {
        let mut residual = vec![0.0; rows];
        for _ in 0..4 {
            problem.residual(values, memory, &mut residual).unwrap();
            let law = problem.at(values);
            memory[0] = run.open(&law, memory[0].xi.clone()).unwrap();
        }
        problem.residual(values, memory, &mut residual).unwrap();
        residual
    };
    let mut memory = problem.memory();
    settled(&values, &mut memory);
    let (mut residual, mut jacobian) = (vec![0.0; rows], DMatrix::zeros(rows, 2));
    problem.linearise(&values, &[true; 2], &mut memory, (&mut residual, &mut jacobian)).unwrap();
    // Of the cost `|r|² + |ξ|²`, whose slope does not see that the errors follow to first order only.
    let slope = |j: usize| 2.0 * jacobian.column(j).dot(&DVector::from_vec(residual.clone()));
    for j in 0..2 {
        let step = 1e-3 * values[j];
        let cost = |side: f64| {
            let mut moved = values;
            moved[j] += side * step;
            settled(&moved, &mut memory.clone()).iter().map(|r| r * r).sum::<f64>()
        };
        let expected = (cost(1.0) - cost(-1.0)) / (2.0 * step);
        // Second differences of the cost bend the quotient by a thousandth of it; the settling ends within one too.
        assert!((slope(j) / expected - 1.0).abs() < 0.01, "{} {expected}", slope(j));
    }
}

/// A preload that is modulated by 0.3 with 9.3 Hz shows that frequency in what the law leaves, to a tenth of a bin (2 Hz), and
/// its phase.
#[test]
fn a_modulation_of_the_preload_shows_its_frequency() {
    let mut law = dahl();
    law.set(Hook::ModulationCosine, 0.3);
    law.set(Hook::ModulationSine, 0.0);
    let wave = Wave { omega: TAU * 9.3, phase: 0.7 };
    let run = recovered(force(&law, 0.0, wave));
    let fitted = super::search::Fitted {
        law: dahl(),
        unknowns: Vec::new(),
        effects: Vec::new(),
        added: Vec::new(),
        waves: Vec::new(),
        cost: 0.0,
        values: 0.0,
        open: vec![run.begin(&dahl()).unwrap()],
    };
    let found = super::wave::candidates(std::slice::from_ref(&run), &fitted);
    let first = found[0][0];
    assert!((first.omega / TAU - 9.3).abs() < 0.2, "{}", first.omega / TAU);
    let middle = 0.5 * SAMPLES as f64 / RATE;
    let apart = (first.omega * middle + first.phase) - (wave.omega * middle + wave.phase);
    assert!(apart.sin().abs() < 0.2 && apart.cos() > 0.0, "{apart}");
}

/// A parabola between its neighbours is a parabola.
#[test]
fn finer_motions_are_cubic() {
    let parabola: Vec<f64> = (0..20).map(|k| f64::from(k * k)).collect();
    let fine = Motion { slip: parabola, ..Motion::nothing(20) }.refined(4);
    for (k, value) in fine.slip.iter().enumerate().skip(8).take(60) {
        assert!((value - (k as f64 / 4.0).powi(2)).abs() < 1e-9, "{k} {value}");
    }
}

/// White numbers of mean square one third.
fn noise(seed: &mut u64) -> f64 {
    *seed = seed.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
    (*seed >> 11) as f64 / (1u64 << 52) as f64 - 1.0
}

/// What each sensor has of its own is not shared, however large; a motion that all sensors have, twice as large as that, is.
#[test]
fn a_shared_motion_is_told_from_noise() {
    let seed = &mut 7;
    let run = |common: f64, seed: &mut u64| {
        let left = (0..640)
            .map(|_| {
                let motion = Complex64::new(noise(seed), noise(seed)) * common;
                (0..6).map(|s| motion + Complex64::new(noise(seed), noise(seed)) * (1.0 + s as f64)).collect()
            })
            .collect();
        WholeRun { left, ..WholeRun::default() }
    };
    assert!(!is_shared(&[&run(0.0, seed)]));
    assert!(is_shared(&[&run(8.0, seed)]));
}

/// A clock that is 800 ppm ahead: told by the frequencies of force and accelerations, and undone by reading the force with it.
#[test]
fn another_clock_is_told_by_its_frequency() {
    let tone = |ahead: f64, phase: f64| -> Vec<f64> {
        (0..SAMPLES).map(|k| (TAU * 57.3 * (1.0 + ahead) * k as f64 / RATE + phase).sin()).collect()
    };
    let seed = &mut 3;
    let noisy =
        |x: Vec<f64>, seed: &mut u64| -> Vec<f64> { x.iter().map(|x| x + 1e-3 * noise(seed)).collect() };
    let force = noisy(tone(0.0, 0.2), seed);
    let acceleration = vec![noisy(tone(8e-4, 1.1), seed), noisy(tone(8e-4, 2.0), seed)];
    let run = RunSamples {
        sampling_rate: RATE,
        excitation_frequency: 57.3,
        preload: PRELOAD,
        force: &force,
        acceleration: &acceleration,
    };
    let (apart, std) = frequencies_apart(&run).unwrap();
    // Cramér and Rao: √6 σ/(π f T A √n) ≈ √6·6e-4/(π·29·√2048) = 4e-7.
    assert!((apart - 8e-4).abs() < 5.0 * std && std < 1e-6, "{apart} {std}");
    let read = stretched(&tone(0.0, 0.0), 8e-4);
    let expected = tone(8e-4, 0.0);
    // Slopes from neighbours h = 2π/71 of a period apart err by h³/6, the cubic between by a tenth of that; beyond the ends samples are held.
    let inner = read.iter().zip(&expected).skip(2).take(SAMPLES - 6);
    assert!(inner.into_iter().all(|(a, b)| (a - b).abs() < 3e-5));
}

/// The law that made the record answers with the recovered force, to the accuracy of two steps a sample, and takes the energy that was recovered; half its
/// friction takes about half of it. The recovered force that is drawn is the one of the record, its mean removed.
#[test]
fn what_is_drawn_is_the_recovered_cycle_and_what_both_laws_make_of_it() {
    let law = dahl();
    let half = ModifiedLaw::dahl(4e4, 0.15);
    let given = force(&law, 0.0, Wave::default());
    let run = recovered(given.clone()).refined(2);
    let still = DVector::zeros(2);
    let drawn = exhibit(true, [(&run, &half, &still), (&run, &law, &still)]);
    let first = (drawn.time[0] * RATE).round() as usize;
    assert!(first >= SAMPLES / 10 && drawn.time.len() > 20, "{:?}", drawn.time);
    let part = &given[first..first + drawn.time.len()];
    let mean = part.iter().sum::<f64>() / part.len() as f64;
    assert!(part.iter().zip(&drawn.recovered.force).all(|(f, shown)| (f - mean - shown).abs() < 1e-9));
    let size = |x: &[f64]| x.iter().map(|x| x * x).sum::<f64>().sqrt();
    let left =
        |of: &[f64]| -> Vec<f64> { of.iter().zip(&drawn.recovered.force).map(|(a, b)| a - b).collect() };
    let errors = drawn.modelled.each_ref().map(|of| size(&left(&of.force)) / size(&drawn.recovered.force));
    assert!(errors[0] > 0.3 && errors[1] < 0.02, "{errors:?}");
    let taken = drawn.modelled.each_ref().map(|of| of.energy / drawn.recovered.energy);
    assert!((0.4..0.7).contains(&taken[0]) && (taken[1] - 1.0).abs() < 0.02, "{taken:?}");
}
