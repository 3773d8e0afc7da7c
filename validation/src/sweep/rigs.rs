//! Rigs at random: beam, supports, law, sensors, sampling, levels.
//!
//! Everything is drawn from the physics: friction against the beam's bending, excitation near a mode of the free or of the
//! stuck beam, levels from sticking to sliding. No value is taken from any data set.

mod wide;

use frettrace::rig::{
    Rig, RigBeam, RigClamp, RigExciter, RigModes, RigRuns, RigSampling, RigSensors, RigSlip, RigSupport,
};
use frettrace_beam::{Boundary, UniformBeam, mode_shapes};
use rand::seq::IndexedRandom;
use rand::{Rng, RngExt};
use std::collections::BTreeMap;
use std::f64::consts::TAU;

/// Laws that are set-valued at rest, so that the contact holds rigidly.
pub(super) const RIGID: &[&str] = &["coulomb", "stribeck"];

/// What of a rig is chosen and not drawn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Choice {
    /// Which kind of rig.
    pub kind: Kind,
    /// Name of the declared law.
    pub law: &'static str,
    /// Kind of slip.
    pub slip: RigSlip,
    /// Whether the support is soft, so that the normal force varies as much as the preload.
    pub soft: bool,
    /// Whether the runs have several preloads.
    pub preloads: bool,
    /// Whether the noise is coloured.
    pub coloured: bool,
    /// What the file says of the modes.
    pub modes: Modes,
}

/// Kinds of rigs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Strips near a resonance, in records of twelve periods and more.
    Bench,
    /// Tubes and strips, ends on pins and springs, excitation beside the resonances, short records.
    Wide,
}

/// What a file says of the modes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Modes {
    /// Frequencies to 1e-5, damping to 1e-3.
    Exact,
    /// Frequencies to 5e-4, damping to 5e-3.
    Off,
    /// Nothing.
    Absent,
}

/// A rig with the quantities its effects are scaled by.
#[derive(Clone, Debug)]
pub struct Drawn {
    /// The rig, without speed-dependent parameters, noise and effects.
    pub rig: Rig,
    /// Bending stiffness (N·m²).
    pub bending: f64,
    /// Mass of the beam (kg).
    pub mass: f64,
    /// Excitation frequency (Hz), that of the first run.
    pub frequency: f64,
    /// Mode that is excited, from 1.
    pub mode: usize,
    /// Tangential stiffness of the stuck contact (N/m).
    pub tangential: f64,
    /// Noise over the level at the middle of the ladder.
    pub noise_share: f64,
}

/// Young's modulus (Pa) and density (kg/m³) of steel, aluminium, titanium, stainless steel, brass.
const MATERIALS: [[f64; 2]; 5] =
    [[2.05e11, 7850.0], [7.0e10, 2700.0], [1.1e11, 4430.0], [1.95e11, 7900.0], [1.0e11, 8500.0]];

/// Draws a rig.
///
/// # Errors
/// Where the beam has no modes.
pub fn draw(random: &mut impl Rng, choice: &Choice) -> anyhow::Result<Drawn> {
    if choice.kind == Kind::Wide {
        return wide::draw(random, choice);
    }
    let turns = choice.slip == RigSlip::Rotation;
    let beam = beam(random);
    let uniform = UniformBeam::rectangular(
        beam.length_m,
        [beam.width_m, beam.thickness_m],
        beam.youngs_modulus_pa,
        beam.density_kg_per_m3,
    );
    let (length, bending) = (beam.length_m, uniform.bending_stiffness);
    let exponent = if choice.soft { random.random_range(1.8..2.3) } else { random.random_range(3.3..4.3) };
    let stiffness = if turns { bending / length.powi(3) * 10.0_f64.powf(exponent) } else { 0.0 };
    let lever = beam.thickness_m * random.random_range(0.4..0.6);
    let mu_k = random.random_range(0.15..0.45);
    let preload = if turns { random.random_range(25.0..90.0) } else { random.random_range(4.0..25.0) };
    let tangential = if turns {
        10.0_f64.powf(random.random_range(-0.4..0.5)) * bending / length / (lever * lever)
    } else {
        10.0_f64.powf(random.random_range(1.7..2.8)) * bending / length.powi(3)
    };
    let mode = if random.random_bool(0.75) { 1 } else { 2 };
    let end = if turns { stiffness } else { tangential };
    let near = mode_shapes(&uniform, &Boundary::spring(end), mode)?[mode - 1].natural_frequency() / TAU;
    let frequency = near * off_resonance(random, turns);
    let friction = if turns { mu_k * preload * lever / length } else { mu_k * preload };
    let sampling = sampling(random, frequency);
    let rig = Rig {
        title: "a rig of the sweep".to_owned(),
        seed: random.random_range(1..1 << 31),
        exciter: RigExciter { position_m: length * random.random_range(0.25..0.6) },
        sensors: sensors(random, length),
        runs: runs(random, choice, [frequency, preload, friction]),
        modes: modes(random, choice.modes),
        clamp: RigClamp::default(),
        second_support: None,
        effects: Vec::new(),
        support: support(choice, [lever, stiffness], [mu_k, tangential / preload]),
        beam,
        sampling,
    };
    let mass = uniform.mass_per_length * length;
    let noise_share = 10.0_f64.powf(random.random_range(-3.0..-2.0));
    Ok(Drawn { rig, bending, mass, frequency, mode, tangential, noise_share })
}

/// A support with its lever arm (m) and normal stiffness (N/m), where the slip is a rotation; friction and, where the law has one, the stiffness of the
/// bristles over the preload (1/m).
fn support(choice: &Choice, [lever, stiffness]: [f64; 2], [mu_k, sigma0]: [f64; 2]) -> RigSupport {
    let turns = choice.slip == RigSlip::Rotation;
    let mut parameters = BTreeMap::from([("mu_k".to_owned(), mu_k)]);
    if !RIGID.contains(&choice.law) {
        parameters.insert("sigma0_per_m".to_owned(), sigma0);
    }
    RigSupport {
        slip: choice.slip,
        lever_arm_m: turns.then_some(lever),
        normal_stiffness_n_per_m: turns.then_some(stiffness),
        law: choice.law.to_owned(),
        parameters,
    }
}

fn beam(random: &mut impl Rng) -> RigBeam {
    let [modulus, density] = MATERIALS.choose(random).copied().unwrap_or(MATERIALS[0]);
    let length = random.random_range(0.4..1.1);
    RigBeam {
        length_m: length,
        width_m: random.random_range(0.015..0.045),
        thickness_m: length * random.random_range(0.007..0.014),
        youngs_modulus_pa: modulus * random.random_range(0.97..1.03),
        density_kg_per_m3: density * random.random_range(0.99..1.01),
        area_m2: None,
        second_moment_m4: None,
    }
}

/// Excitation over natural frequency: the beam that turns on its support is met within half a per cent to four, the one
/// that slides within eight (its stuck frequency is only reached at the lowest levels).
fn off_resonance(random: &mut impl Rng, turns: bool) -> f64 {
    if turns {
        let off = 10.0_f64.powf(random.random_range(-2.3..-1.4));
        1.0 + if random.random_bool(0.5) { off } else { -off }
    } else {
        random.random_range(0.92..1.08)
    }
}

fn sampling(random: &mut impl Rng, frequency: f64) -> RigSampling {
    let mut rate: f64 =
        [4096.0, 5000.0, 8192.0, 10_000.0, 16_384.0].choose(random).copied().unwrap_or(8192.0);
    while rate < 40.0 * frequency {
        rate *= 2.0;
    }
    let mut samples = [2048, 4096, 6000].choose(random).copied().unwrap_or(4096);
    while (samples as f64) * frequency < 12.0 * rate {
        samples *= 2;
    }
    RigSampling { rate_hz: rate, samples, march_rate_hz: None }
}

fn sensors(random: &mut impl Rng, length: f64) -> RigSensors {
    let count = random.random_range(4..=8);
    let place = |k: usize, random: &mut _| {
        let even = 0.14 + 0.79 * k as f64 / (count - 1) as f64;
        length * (even + RngExt::random_range(random, -0.03..0.03))
    };
    RigSensors {
        position_m: (0..count).map(|k| place(k, random)).collect(),
        noise_std_m_per_s2: 0.0,
        noise_correlation: 0.0,
    }
}

/// Modes beyond the declared ones have the beam's frequencies and the last declared ratio, as the file says.
fn modes(random: &mut impl Rng, declared: Modes) -> RigModes {
    let accuracy = if declared == Modes::Off { [5e-4, 5e-3] } else { [1e-5, 1e-3] };
    let count = if declared == Modes::Absent { 0 } else { random.random_range(4..=7) };
    RigModes {
        damping_ratio: (0..count.max(1)).map(|_| random.random_range(0.003..0.008)).collect(),
        natural_frequency_hz: Vec::new(),
        declared: count,
        frequency_relative_std: accuracy[0],
        damping_relative_std: accuracy[1],
    }
}

/// A ladder of levels that begins where friction begins to give way.
fn runs(random: &mut impl Rng, choice: &Choice, [frequency, preload, friction]: [f64; 3]) -> Vec<RigRuns> {
    let turns = choice.slip == RigSlip::Rotation;
    let count: usize = random.random_range(6..=10);
    let lowest =
        friction * if turns { random.random_range(1.2..3.0) } else { random.random_range(0.1..0.25) };
    let span: f64 = if turns { random.random_range(1.1..2.0) } else { random.random_range(1.1..1.5) };
    let force = |k: usize| lowest * 10.0_f64.powf(span * k as f64 / (count - 1) as f64);
    let second = random.random_bool(0.3).then(|| frequency * random.random_range(0.97..1.03));
    let tables: Vec<[f64; 2]> = if choice.preloads {
        [1.0, 2.0, 0.6].map(|factor| [frequency, preload * factor]).to_vec()
    } else {
        [Some(frequency), second].into_iter().flatten().map(|f| [f, preload]).collect()
    };
    let forces = |table: usize| (table..count).step_by(tables.len()).map(force).collect();
    let table = |(index, &[frequency_hz, preload_n]): (usize, &[f64; 2])| RigRuns {
        frequency_hz,
        preload_n,
        force_amplitude_n: forces(index),
        lubricated: None,
        beat_share: 0.0,
        beat_frequency_ratio: 0.0,
    };
    tables.iter().enumerate().map(table).collect()
}
