//! From a planned set to a measurement whose truth is known.

use super::effects::{Scale, build};
use super::plan::Planned;
use super::rigs::{Choice, Drawn, draw};
use anyhow::bail;
use frettrace::Progress;
use frettrace::rig::{Effect, Rig, RigRuns, RigSlip};
use frettrace::simulate::{MODES, Simulation, simulate};
use frettrace_forward::march::Settling;
use rand::{Rng, RngExt, SeedableRng};
use rand_pcg::Pcg64;

/// A made set.
#[derive(Clone, Debug)]
pub struct Made {
    /// What the program is given, and the truth.
    pub simulation: Simulation,
    /// The rig with its effects.
    pub rig: Rig,
    /// `√(1 + mean of (change/noise)²)` over the runs: error over noise floor of the model with true parameters and without an effect, that
    /// one of its effects which is seen least.
    pub visible: f64,
}

/// Rigs drawn before a planned set is given up.
const ATTEMPTS: usize = 12;
/// Error over noise floor from which an effect counts as large enough to be looked for.
const LARGE_ENOUGH: f64 = 2.0;
/// Times that the size of an effect is doubled until it is.
const DOUBLINGS: usize = 3;

/// Makes a planned set; everything comes from its seed.
///
/// # Errors
/// Where no rig that can be simulated is found.
pub fn make(planned: &Planned) -> anyhow::Result<Made> {
    let mut random = Pcg64::seed_from_u64(planned.seed);
    for _ in 0..ATTEMPTS {
        let drawn = draw(&mut random, &planned.choice)?;
        if let Some((drawn, scale)) = settled(&mut random, drawn, &planned.choice)?
            && let Some(made) = with_effect(&mut random, drawn, &scale, planned)?
        {
            return Ok(made);
        }
    }
    bail!("{}: no rig settles", planned.name)
}

/// Whether the accelerations of a run still change with the steps of the march, by more than is wanted where they have a period and by
/// more than the noise where not: a rig that no step is fine enough for has no truth to compare with. Contacts that chatter
/// beyond the sensors' band do, and those that were marched without the modes that chatter are not quite the beam that is declared.
fn unresolved(simulation: &Simulation, rig: &Rig) -> bool {
    let noise = rig.sensors.noise_std_m_per_s2;
    simulation.marching.iter().zip(&simulation.settled).any(|(run, settled)| {
        let aperiodic = matches!(settled, Settling::NotPeriodic { .. });
        let limit = if aperiodic { noise } else { run.tolerance };
        run.modes < MODES || run.change.is_some_and(|change| change > limit)
    })
}

/// Runs the plain rig at two levels: sizes of the motion, from which the rest is scaled. `None` where the rig will not do.
fn settled(random: &mut Pcg64, mut drawn: Drawn, choice: &Choice) -> anyhow::Result<Option<(Drawn, Scale)>> {
    let made = simulate(&probe(&drawn), &Progress::silent())?;
    if made.settled.iter().any(|run| matches!(run, Settling::NotPeriodic { .. })) {
        return Ok(None);
    }
    let mut scale = Scale::new(&made);
    // A rigid contact that holds at both levels has no speed from which its law is scaled.
    if scale.largest_level > 3e3 || scale.velocity <= 0.0 {
        return Ok(None);
    }
    if choice.slip == RigSlip::Rotation {
        // A contact that opens is an effect of its own; a soft support is wanted for what the normal force does.
        let wanted = if choice.soft { random.random_range(0.3..0.9) } else { scale.opening.min(0.6) };
        load(&mut drawn, &mut scale, wanted);
    }
    finish_law(random, &mut drawn, choice.law, &scale);
    drawn.rig.sensors.noise_std_m_per_s2 = drawn.noise_share * scale.middle_level;
    drawn.rig.sensors.noise_correlation = if choice.coloured { random.random_range(0.5..0.95) } else { 0.0 };
    Ok(Some((drawn, scale)))
}

/// The plain rig at the middle and the highest level, short and without noise.
fn probe(drawn: &Drawn) -> Rig {
    let mut rig = drawn.rig.clone();
    let mut forces: Vec<f64> = rig.runs.iter().flat_map(|r| r.force_amplitude_n.iter().copied()).collect();
    forces.sort_by(f64::total_cmp);
    let ends = [forces[forces.len() / 2], forces[forces.len() - 1]];
    rig.runs = vec![RigRuns { force_amplitude_n: ends.to_vec(), ..rig.runs[0].clone() }];
    rig.sampling.samples = (4.0 * rig.sampling.rate_hz / drawn.frequency).ceil().max(512.0) as usize;
    let memoryless = !rig.support.parameters.contains_key("sigma0_per_m");
    rig.support.law = if memoryless { "coulomb" } else { "dahl" }.to_owned();
    if !memoryless {
        rig.support.parameters.insert("exponent".to_owned(), 1.0);
    }
    rig
}

/// Changes the preload so that the dynamic normal force is the wanted share of it, with friction and stiffness as they are.
fn load(drawn: &mut Drawn, scale: &mut Scale, wanted: f64) {
    let factor = scale.opening / wanted;
    for run in &mut drawn.rig.runs {
        run.preload_n *= factor;
    }
    for key in ["mu_k", "sigma0_per_m"] {
        if let Some(value) = drawn.rig.support.parameters.get_mut(key) {
            *value /= factor;
        }
    }
    scale.opening = wanted;
}

/// The parameters of the declared law that need a scale of speed.
fn finish_law(random: &mut impl Rng, drawn: &mut Drawn, law: &str, scale: &Scale) {
    let preload = drawn.rig.runs[0].preload_n;
    let parameters = &mut drawn.rig.support.parameters;
    let mu_k = parameters.get("mu_k").copied().unwrap_or_default();
    let sigma0 = parameters.get("sigma0_per_m").copied().unwrap_or_default();
    let mut set = |key: &str, value: f64| parameters.insert(key.to_owned(), value);
    if law == "dahl" {
        set("exponent", 1.0);
    }
    if ["stribeck", "lugre", "hybrid"].contains(&law) {
        set("mu_s", mu_k * random.random_range(1.2..1.6));
        set("v_s_m_per_s", scale.velocity * random.random_range(0.2..0.8));
        set("delta", if random.random_bool(0.3) { 1.0 } else { 2.0 });
        let viscous = if random.random_bool(0.5) { 0.1 * mu_k * preload / scale.velocity } else { 0.0 };
        set("sigma2_n_s_per_m", viscous);
    }
    if ["lugre", "hybrid"].contains(&law) {
        let share = random.random_range(0.0..0.2);
        set("sigma1_s_per_m", share * sigma0 / (std::f64::consts::TAU * drawn.frequency));
        set("v_d_m_per_s", scale.velocity * random.random_range(0.3..1.0));
    }
    if law == "hybrid" {
        set("breakaway", random.random_range(0.2..0.6));
    }
}

/// The set with its effects; `None` where no step is fine enough.
fn with_effect(
    random: &mut Pcg64,
    drawn: Drawn,
    scale: &Scale,
    planned: &Planned,
) -> anyhow::Result<Option<Made>> {
    let simulation = simulate(&drawn.rig, &Progress::silent())?;
    if unresolved(&simulation, &drawn.rig) {
        return Ok(None);
    }
    let rig = drawn.rig.clone();
    let mut made = Made { simulation, rig, visible: 1.0 };
    for formula in &planned.formulas {
        let seed = random.random();
        let build = |size| build(formula, &mut Pcg64::seed_from_u64(seed), &drawn, scale, size);
        let Some(with) = enlarged(&made, planned, build)? else { return Ok(None) };
        made = with;
    }
    if planned.formulas.len() > 1 {
        // Beside the second the first one may be seen less than alone.
        let mut other = made.rig.clone();
        other.effects.remove(0);
        let without = simulate(&other, &Progress::silent())?;
        let seen = visible(&without, &made.simulation, other.sensors.noise_std_m_per_s2);
        made.visible = made.visible.min(seen);
    }
    Ok(Some(made))
}

/// With one more effect, doubled until it stands out of the noise; `None` where no step is fine enough.
fn enlarged(
    made: &Made,
    planned: &Planned,
    build: impl Fn(f64) -> Option<Effect>,
) -> anyhow::Result<Option<Made>> {
    let mut size = f64::from(planned.size);
    for doubling in 0..=DOUBLINGS {
        let Some(effect) = build(size) else { bail!("{}: no such effect", planned.name) };
        let mut rig = made.rig.clone();
        rig.effects.push(effect);
        let simulation = simulate(&rig, &Progress::silent())?;
        if unresolved(&simulation, &rig) {
            return Ok(None);
        }
        let visible = visible(&made.simulation, &simulation, rig.sensors.noise_std_m_per_s2);
        if visible > LARGE_ENOUGH || doubling == DOUBLINGS {
            return Ok(Some(Made { simulation, rig, visible }));
        }
        size *= 2.0;
    }
    bail!("{}: no size will do", planned.name)
}

/// Both have the same noise, so that their difference is the effect's.
fn visible(plain: &Simulation, with: &Simulation, noise: f64) -> f64 {
    let runs = plain.measurement.runs.iter().zip(&with.measurement.runs);
    let squares: Vec<f64> = runs
        .map(|(a, b)| {
            let pairs = a.acceleration.iter().flatten().zip(b.acceleration.iter().flatten());
            let (sum, count) = pairs.fold((0.0, 0.0), |(s, n), (x, y)| (s + (x - y).powi(2), n + 1.0));
            sum / count / (noise * noise)
        })
        .collect();
    (1.0 + squares.iter().sum::<f64>() / squares.len() as f64).sqrt()
}
