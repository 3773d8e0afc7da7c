//! Records made by another method than the fit's (explicit Euler in two hundred parts of a sample, other functional
//! forms), one effect at a time, and clean ones.

use super::floor::floor;
use super::follows::follows;
use super::{MovingMass, RecordCase, RecordOutcome, RecordQuantity, RecordRun, explain_record, strokes};
use crate::Verdict;
use frettrace_identify::contact::{Closure, ContactHistory, Family, FloorSource};
use std::f64::consts::TAU;

/// Presliding stiffness over the normal force (1/m) and friction coefficient of every record.
const SIGMA0: f64 = 4e4;
const MU: f64 = 0.4;
/// Normal force (N) and the deviation of the force's noise: one part in two hundred of the friction.
const NORMAL: f64 = 50.0;
const NOISE: f64 = 0.1;
/// Speed (m/s) at which a film is as thick as it can be, and the times (s) in which it builds up and drains.
const FILM_SPEED: f64 = 4e-4;
const FILM_TIMES: [f64; 2] = [0.04, 0.15];
const SAMPLES: usize = 400;
const CYCLES: f64 = 4.0;
const PARTS: usize = 200;

/// What the truth has beside Dahl's law with exponent 1.
#[derive(Clone, Copy, Default)]
struct Truth {
    /// Factor on the friction coefficient by speed, position, sense and course.
    factor: Option<fn(f64, f64, f64) -> f64>,
    wear: f64,
    /// Share of the friction that a full film takes; 0 for none.
    film: f64,
    viscous: f64,
    mass: f64,
    half_gap: f64,
    offset: f64,
}

/// A small generator, so that equal seeds give equal records.
struct Noise(u64);

impl Noise {
    fn uniform(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (self.0 >> 11) as f64 / (1u64 << 53) as f64
    }

    /// Sum of twelve uniform numbers: mean 0, deviation 1.
    fn normal(&mut self) -> f64 {
        (0..12).map(|_| self.uniform()).sum::<f64>() - 6.0
    }
}

fn run((amplitude, frequency): (f64, f64), place: [f64; 2], truth: &Truth, noise: &mut Noise) -> RecordRun {
    let duration = CYCLES / frequency;
    let dt = duration / (SAMPLES * PARTS) as f64;
    let motion = |t: f64| {
        let (sine, cosine) = (TAU * frequency * t).sin_cos();
        let pace = TAU * frequency;
        (amplitude * sine, amplitude * pace * cosine, -amplitude * pace * pace * sine)
    };
    let mut history = ContactHistory {
        label: String::new(),
        time: Vec::new(),
        slip: Vec::new(),
        velocity: Vec::new(),
        acceleration: Some(Vec::new()),
        normal: vec![NORMAL; SAMPLES],
        force: Vec::new(),
        closure: Closure::Open,
        mean_is_seen: true,
        force_std: NOISE,
        draws: Vec::new(),
        first: 1,
    };
    // The bristle with its play unfolded: the force is the stretch beyond the play.
    let stretch = |y: f64| y.signum() * (y.abs() - SIGMA0 * truth.half_gap).max(0.0);
    let (mut bristle, mut film) = (0.0, 0.0);
    // A cycle of running in comes before the record.
    let before = (1.0 / frequency / dt).round() as i64;
    for part in -before..(SAMPLES * PARTS) as i64 {
        let t = part as f64 * dt;
        let (u, v, a) = motion(t);
        let course = place[0] + (place[1] - place[0]) * t / duration;
        let factor = truth.factor.map_or(1.0, |factor| factor(v, u, amplitude));
        let mu = MU * factor * (1.0 + truth.wear * course) * (1.0 - truth.film * film);
        if part >= 0 && part % PARTS as i64 == 0 {
            let force = NORMAL * stretch(bristle) + truth.viscous * v + truth.mass * a + truth.offset;
            history.time.push(t);
            history.slip.push(u);
            history.velocity.push(v);
            history.acceleration.iter_mut().for_each(|list| list.push(a));
            history.force.push(force + NOISE * noise.normal());
        }
        let steady = (v.abs() / FILM_SPEED).min(1.0).powf(2.0 / 3.0);
        let time = if steady > film { FILM_TIMES[0] } else { FILM_TIMES[1] };
        // After a pause there is none: how much of it a record begins with cannot be seen.
        film = if part < 0 { 0.0 } else { film + dt * (steady - film) / time };
        bristle += dt * SIGMA0 * v * (1.0 - stretch(bristle) * v.signum() / mu);
    }
    RecordRun { history, progress: place, stated: Some(NOISE) }
}

/// Five runs of other amplitudes and frequencies, the third held out; sliding distance `μ/σ0` = 10 µm.
fn record(truth: &Truth, mass: MovingMass) -> RecordCase {
    let levels = [(20e-6, 1.0), (50e-6, 2.0), (80e-6, 1.5), (100e-6, 1.0), (120e-6, 3.0)];
    let mut noise = Noise(7);
    let mut runs: Vec<RecordRun> = levels
        .iter()
        .enumerate()
        .map(|(k, level)| run(*level, [k as f64 / 5.0, (k + 1) as f64 / 5.0], truth, &mut noise))
        .collect();
    let held_out = vec![runs.remove(2)];
    RecordCase { law: Family::Dahl, training: runs, held_out, mass, without: Vec::new() }
}

fn told(truth: Truth) -> RecordOutcome {
    explain_record(&record(&truth, MovingMass::None)).unwrap()
}

/// Names found, those that may stand for them included.
fn names(found: &RecordOutcome) -> Vec<&'static str> {
    found
        .effects
        .iter()
        .flat_map(|e| std::iter::once(e.id).chain(e.indistinguishable.iter().copied()))
        .collect()
}

/// Error of the held-out run over its floor.
fn left(found: &RecordOutcome) -> f64 {
    let residual: Vec<f64> = found.model.held_out.concat();
    let mean = residual.iter().map(|r| r * r).sum::<f64>() / residual.len() as f64;
    mean.sqrt() / found.floor[1]
}

#[track_caller]
fn explained_by(id: &str, truth: Truth) {
    let found = told(truth);
    assert_eq!(found.verdict, Verdict::Explained, "{:?}", names(&found));
    assert_eq!(found.effects.len(), 1, "{:?}", names(&found));
    assert!(names(&found).contains(&id), "{:?}", names(&found));
    // The score's own limit for an explained set.
    assert!(left(&found) < 1.2, "{}", left(&found));
}

#[test]
fn a_clean_record_lacks_nothing() {
    let found = told(Truth::default());
    assert_eq!((found.verdict, found.source), (Verdict::NothingMissing, FloorSource::Given));
    assert!(found.effects.is_empty());
}

/// A load cell that drifted is a nuisance, no effect.
#[test]
fn an_offset_is_no_effect() {
    let found = told(Truth { offset: 0.7, ..Truth::default() });
    assert_eq!(found.verdict, Verdict::NothingMissing);
    assert!((found.baseline.setting.get(RecordQuantity::Offset).unwrap() - 0.7).abs() < 0.02);
}

#[test]
fn viscous_friction_is_found() {
    explained_by("friction.viscous", Truth { viscous: 1500.0, ..Truth::default() });
}

/// Rational decay, `1 + 0.25/(1 + (v/v_s)²)`.
#[test]
fn falling_friction_is_found() {
    let factor = |v: f64, _: f64, _: f64| 1.0 + 0.25 / (1.0 + (v / 4e-4).powi(2));
    explained_by("friction.stribeck", Truth { factor: Some(factor), ..Truth::default() });
}

/// A film that drains four times as slowly as it builds up: its thickness lags behind `min(v/v_f, 1)^(2/3)`.
#[test]
fn a_film_is_found() {
    explained_by("friction.film", Truth { film: 0.4, ..Truth::default() });
}

#[test]
fn friction_that_differs_between_the_senses_is_found() {
    let factor = |v: f64, _: f64, _: f64| if v > 0.0 { 1.2 } else { 0.8 };
    explained_by("friction.asymmetry", Truth { factor: Some(factor), ..Truth::default() });
}

/// A hyperbolic tangent of the place, where the candidate has a straight line or a parabola; over ±0.6 of its argument
/// it leaves a straight line by less than the noise.
#[test]
fn friction_that_depends_on_the_place_is_found() {
    let factor = |_: f64, u: f64, _: f64| 1.0 + 0.15 * (u / 200e-6).tanh();
    explained_by("friction.position", Truth { factor: Some(factor), ..Truth::default() });
}

#[test]
fn wear_is_found() {
    explained_by("friction.wear", Truth { wear: 0.15, ..Truth::default() });
}

#[test]
fn play_in_series_is_found() {
    explained_by("contact.backlash", Truth { half_gap: 3e-6, ..Truth::default() });
}

/// The mass that is wanted is estimated with the law: 30 kg that move with up to 0.043 m/s² take 1.3 N beside 20 N of friction.
#[test]
fn a_moving_mass_is_estimated_with_the_law() {
    let truth = Truth { mass: 30.0, ..Truth::default() };
    let found = explain_record(&record(&truth, MovingMass::Wanted)).unwrap();
    assert_eq!(found.verdict, Verdict::NothingMissing);
    // Noise 0.1 N over the 1600 training samples and an rms of 0.02 m/s²: a deviation of 0.1/(0.02·√1600) = 0.13 kg.
    let mass = found.baseline.setting.get(RecordQuantity::Mass).unwrap();
    assert!((mass - 30.0).abs() < 0.5, "{mass}");
}

/// A normal force that wanders without regard to the motion, and a residual that is a tenth of it with noise of a third of that
/// share's size: `1/(1 + 1/9) = 0.9` of its power follows the normal force, and nothing follows the motion.
#[test]
fn what_a_residual_follows_is_told_by_its_share() {
    let mut noise = Noise(5);
    let case = record(&Truth::default(), MovingMass::None);
    let mut made = |run: &RecordRun| {
        let mut run = run.clone();
        run.history.normal = (0..SAMPLES).map(|_| NORMAL + noise.normal()).collect();
        let residual = run.history.normal.iter().map(|n| 0.1 * (n - NORMAL) + 0.1 / 3.0 * noise.normal());
        let residual = residual.collect::<Vec<_>>();
        (run, residual)
    };
    let (fitted, of_fitted): (Vec<_>, Vec<_>) = case.training.iter().map(&mut made).unzip();
    let (judged, of_judged): (Vec<_>, Vec<_>) = case.held_out.iter().map(&mut made).unzip();
    let found = follows((&fitted, &of_fitted), (&judged, &of_judged));
    assert_eq!(found[0].input, "normal force");
    // 400 samples tell a share of 0.9 to 0.1·√(4·0.9/400) = 0.01.
    assert!((found[0].share - 0.9).abs() < 0.03, "{}", found[0].share);
    assert!(found[1..].iter().all(|f| f.share < 0.03), "{found:?}");
}

#[test]
fn strokes_run_from_reversal_to_reversal() {
    let slip: Vec<f64> = (0..=400).map(|k| (TAU * f64::from(k) / 100.0).sin()).collect();
    let found = strokes(&slip);
    assert_eq!(found[1..4], [25..75, 75..125, 125..175]);
}

/// Repeats tell the noise although interpolation between samples smooths it: a spring moved by a sine whose period is no
/// whole number of samples. White noise, and noise that drifts within a stroke of which interpolation takes nothing.
#[test]
fn the_floor_from_repeats_is_the_noise() {
    let case = record(&Truth::default(), MovingMass::None);
    let mut noise = Noise(11);
    let mut run = case.training[3].clone();
    let samples = 4000;
    let phase = |k: usize| TAU * k as f64 / 131.7;
    run.history.time = (0..samples).map(|k| k as f64 * 1e-3).collect();
    run.history.slip = (0..samples).map(|k| 1e-4 * phase(k).sin()).collect();
    let of = |noise: &mut dyn FnMut(usize) -> f64| {
        let mut run = run.clone();
        run.history.force = (0..samples).map(|k| 20.0 * phase(k).sin() + noise(k)).collect();
        floor(&[run]).unwrap().std
    };
    let white = of(&mut |_| NOISE * noise.normal());
    // About 4000 differences: a deviation of 1/√8000 = 0.011 of the value.
    assert!((white / NOISE - 1.0).abs() < 0.04, "{white}");
    // A sine of an irrational number of strokes: neighbouring strokes of one sense see it 131.7/97.3 turns apart, so
    // that half the squared difference is `2 sin²(π·131.7/97.3)` times its own mean square.
    let slow = of(&mut |k| NOISE * (TAU * k as f64 / 97.3).sin());
    let expected = NOISE * (std::f64::consts::PI * 131.7 / 97.3).sin().abs();
    assert!((slow / expected - 1.0).abs() < 0.1, "{slow} {expected}");
}

/// Without a stated noise the floor comes from repeats, and a clean record still lacks nothing.
#[test]
fn a_clean_record_of_unknown_noise_lacks_nothing() {
    let mut case = record(&Truth::default(), MovingMass::None);
    case.training.iter_mut().chain(&mut case.held_out).for_each(|run| run.stated = None);
    let found = explain_record(&case).unwrap();
    assert_eq!((found.verdict, found.source), (Verdict::NothingMissing, FloorSource::Repeats));
}

/// What no candidate has: friction that follows a product of place and sense of the motion, with three waves.
#[test]
fn what_is_in_no_list_stays_open() {
    let factor = |v: f64, u: f64, amplitude: f64| 1.0 + 0.2 * v.signum() * (9.0 * u / amplitude).sin();
    let found = told(Truth { factor: Some(factor), ..Truth::default() });
    assert_eq!(found.verdict, Verdict::Unexplained, "{:?}", names(&found));
    assert!(!found.follows.is_empty() && left(&found) > 1.2, "{}", left(&found));
}
