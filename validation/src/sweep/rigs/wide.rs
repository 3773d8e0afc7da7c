//! Rigs farther from each other than those of the first sweep: tubes and strips, ends on a pin or on a spring of any stiffness, small lever arms,
//! excitation beside the resonances, short records, levels from holding to sliding all the way, sensors anywhere.

use super::{Choice, Drawn, MATERIALS, support};
use frettrace::rig::{
    Rig, RigBeam, RigClamp, RigExciter, RigModes, RigRuns, RigSampling, RigSensors, RigSlip,
};
use frettrace_beam::{Boundary, mode_shapes};
use rand::seq::IndexedRandom;
use rand::{Rng, RngExt};
use std::f64::consts::{PI, TAU};

/// Draws a rig.
///
/// # Errors
/// Where the beam has no modes.
pub(super) fn draw(random: &mut impl Rng, choice: &Choice) -> anyhow::Result<Drawn> {
    let turns = choice.slip == RigSlip::Rotation;
    let beam = beam(random);
    let uniform = beam.uniform();
    let (length, bending) = (beam.length_m, uniform.bending_stiffness);
    let end = match (turns, choice.soft) {
        (false, _) => 0.0,
        (true, true) => bending / length.powi(3) * between(random, [60.0, 400.0]),
        (true, false) if random.random_bool(0.3) => f64::INFINITY,
        (true, false) => bending / length.powi(3) * between(random, [5e2, 5e4]),
    };
    let lever = random.random_range(0.002..0.008);
    let mu_k = random.random_range(0.12..0.5);
    let preload = between(random, [10.0, 120.0]);
    let boundary = if end.is_infinite() { Boundary::pinned() } else { Boundary::spring(end) };
    let near = mode_shapes(&uniform, &boundary, 1)?[0].natural_frequency() / TAU;
    let frequency = near * beside(random);
    // What moves the contact: the beam's bending to its limit of friction, some times over.
    let friction = if turns { mu_k * preload * lever / length } else { mu_k * preload };
    let largest = friction * between(random, if turns { [3.0, 150.0] } else { [2.0, 20.0] });
    let bent = largest * length.powi(3) / (3.0 * bending);
    let slip = if turns { 3.0 * bent / length * lever } else { bent };
    let tangential = mu_k * preload / (slip * between(random, [0.02, 0.3]));
    let rig = Rig {
        title: "a rig of the wide sweep".to_owned(),
        seed: random.random_range(1..1 << 31),
        exciter: RigExciter { position_m: length * random.random_range(0.25..0.65) },
        sensors: sensors(random, length),
        runs: runs(random, choice, [frequency, preload, largest]),
        modes: modes(random),
        clamp: RigClamp::default(),
        second_support: None,
        effects: Vec::new(),
        support: support(choice, [lever, end], [mu_k, tangential / preload]),
        sampling: sampling(random, frequency),
        beam,
    };
    let mass = uniform.mass_per_length * length;
    let noise_share = between(random, [1e-3, 2e-2]);
    Ok(Drawn { rig, bending, mass, frequency, mode: 1, tangential, noise_share })
}

/// A number of any size between two.
fn between(random: &mut impl Rng, [from, to]: [f64; 2]) -> f64 {
    random.random_range(from.ln()..to.ln()).exp()
}

fn beam(random: &mut impl Rng) -> RigBeam {
    let [youngs_modulus_pa, density_kg_per_m3] = MATERIALS.choose(random).copied().unwrap_or(MATERIALS[0]);
    let length_m = random.random_range(0.3..0.9);
    let strip = RigBeam {
        length_m,
        width_m: random.random_range(0.015..0.05),
        thickness_m: length_m * random.random_range(0.008..0.025),
        youngs_modulus_pa,
        density_kg_per_m3,
        area_m2: None,
        second_moment_m4: None,
    };
    if random.random_bool(2.0 / 3.0) {
        return strip;
    }
    // A heat exchanger's tube, with a wall of a twentieth of its diameter.
    let outer = random.random_range(0.012..0.022);
    let inner = 0.9 * outer;
    RigBeam {
        width_m: outer,
        thickness_m: outer,
        area_m2: Some(PI / 4.0 * (outer * outer - inner * inner)),
        second_moment_m4: Some(PI / 64.0 * (outer.powi(4) - inner.powi(4))),
        ..strip
    }
}

/// Excitation over natural frequency: well below, or well above.
fn beside(random: &mut impl Rng) -> f64 {
    if random.random_bool(0.5) { random.random_range(0.7..0.95) } else { random.random_range(1.08..1.35) }
}

/// Thirty to sixty samples a period, in a record of some periods.
fn sampling(random: &mut impl Rng, frequency: f64) -> RigSampling {
    let rate_hz = 2.0_f64.powf((frequency * random.random_range(30.0..60.0)).log2().round());
    let samples = if random.random_bool(0.5) { 1024 } else { 2048 };
    RigSampling { rate_hz, samples, march_rate_hz: None }
}

fn sensors(random: &mut impl Rng, length: f64) -> RigSensors {
    let count = random.random_range(4..=8);
    let mut position_m: Vec<f64> = (0..count).map(|_| length * random.random_range(0.1..0.95)).collect();
    position_m.sort_by(f64::total_cmp);
    RigSensors { position_m, noise_std_m_per_s2: 0.0, noise_correlation: 0.0 }
}

fn modes(random: &mut impl Rng) -> RigModes {
    RigModes {
        damping_ratio: (0..3).map(|_| between(random, [2e-3, 1.5e-2])).collect(),
        natural_frequency_hz: Vec::new(),
        declared: random.random_range(3..=8),
        frequency_relative_std: between(random, [1e-5, 5e-4]),
        damping_relative_std: between(random, [1e-3, 3e-2]),
    }
}

/// A ladder of levels that ends at the largest force, at one or two preloads and sometimes at another frequency as well.
fn runs(random: &mut impl Rng, choice: &Choice, [frequency, preload, largest]: [f64; 3]) -> Vec<RigRuns> {
    let count: usize = random.random_range(6..=9);
    let span = between(random, [6.0, 20.0]);
    let force = |k: usize| largest * span.powf(k as f64 / (count - 1) as f64 - 1.0);
    let mut tables = vec![[frequency, preload]];
    if choice.preloads {
        tables.push([frequency, preload * random.random_range(1.4..2.0)]);
    }
    if random.random_bool(0.3) {
        tables.push([frequency * random.random_range(0.6..1.5), preload]);
    }
    let table = |&[frequency_hz, preload_n]: &[f64; 2]| RigRuns {
        frequency_hz,
        preload_n,
        force_amplitude_n: (0..count).map(|k| force(k) * preload_n / preload).collect(),
        lubricated: None,
        beat_share: 0.0,
        beat_frequency_ratio: 0.0,
    };
    tables.iter().map(table).collect()
}

#[cfg(test)]
mod tests {
    use super::super::{Kind, Modes};
    use super::*;
    use rand::SeedableRng;
    use rand_pcg::Pcg64;

    /// A tube of diameter `D` and wall `D/20` has `I/A = (D² + (0.9 D)²)/16`; strips and tubes are drawn, pins and springs.
    #[test]
    fn tubes_and_pins_are_drawn() {
        let choice = Choice {
            kind: Kind::Wide,
            law: "dahl",
            slip: RigSlip::Rotation,
            soft: false,
            preloads: true,
            coloured: false,
            modes: Modes::Off,
        };
        let mut random = Pcg64::seed_from_u64(1);
        let rigs: Vec<Rig> = (0..40).map(|_| draw(&mut random, &choice).unwrap().rig).collect();
        let tubes = rigs
            .iter()
            .filter_map(|rig| Some((rig.beam.width_m, rig.beam.area_m2?, rig.beam.second_moment_m4?)));
        for (outer, area, moment) in tubes.clone() {
            let expected = outer * outer * 1.81 / 16.0;
            assert!((moment / area / expected - 1.0).abs() < 1e-12, "{outer}");
        }
        let pins = rigs.iter().filter(|rig| rig.support.normal_stiffness_n_per_m == Some(f64::INFINITY));
        for found in [tubes.count(), pins.count()] {
            assert!((5..25).contains(&found), "{found}");
        }
    }
}
