//! Effects of a planned size, scaled by the motion of the rig they act on.
//!
//! Size 1 is what a careful person might overlook, size 2 what they should not.

mod chain;
mod third;

use super::rigs::Drawn;
use frettrace::rig::Effect;
use frettrace::simulate::Simulation;
use rand::{Rng, RngExt};
use std::f64::consts::TAU;

/// Sizes of the motion of a plain rig: geometric means of the middle and the highest level, and the highest.
#[derive(Clone, Debug)]
pub struct Scale {
    /// Slip amplitude (m), mean and highest.
    pub slip: f64,
    /// See `slip`.
    pub largest_slip: f64,
    /// Slip velocity (m/s), mean and highest.
    pub velocity: f64,
    /// See `velocity`.
    pub largest_velocity: f64,
    /// Root mean square acceleration (m/s²) at the middle level and at the highest.
    pub middle_level: f64,
    /// See `middle_level`.
    pub largest_level: f64,
    /// Largest acceleration of every sensor (m/s²).
    pub peak: Vec<f64>,
    /// Dynamic normal force over preload at the highest level.
    pub opening: f64,
    /// Dynamic normal force at the highest level (N).
    pub dynamic_normal: f64,
}

fn largest(values: &[f64]) -> f64 {
    values.iter().fold(0.0, |most, value| most.max(value.abs()))
}

/// Share of the largest size that the typical one has at least.
const STICKS: f64 = 0.03;

impl Scale {
    /// Reads the sizes off a simulation.
    #[must_use]
    pub fn new(made: &Simulation) -> Self {
        let truth = &made.truth.runs;
        let mean = |of: &dyn Fn(usize) -> f64| (0..truth.len()).map(of).map(f64::ln).sum::<f64>();
        let mean = |of: &dyn Fn(usize) -> f64| (mean(of) / truth.len() as f64).exp();
        let slip = |k: usize| largest(&truth[k].slip_displacement);
        let velocity = |k: usize| largest(&truth[k].slip_velocity);
        let last = truth.len() - 1;
        // A rigid contact that sticks at one of the levels has no size there.
        let typical = |of: &dyn Fn(usize) -> f64| mean(of).max(STICKS * of(last));
        let level = |k: usize| {
            let channels = &made.measurement.runs[k].acceleration;
            let squares: f64 = channels.iter().flatten().map(|a| a * a).sum();
            (squares / channels.iter().map(Vec::len).sum::<usize>() as f64).sqrt()
        };
        let preload = made.measurement.runs[last].preload;
        let dynamic: Vec<f64> = truth[last].normal_force.iter().map(|n| n - preload).collect();
        let sensors = made.measurement.sensors.position.len();
        let peak =
            |s: usize| made.measurement.runs.iter().map(|r| largest(&r.acceleration[s])).fold(0.0, f64::max);
        Self {
            slip: typical(&slip),
            largest_slip: slip(last),
            velocity: typical(&velocity),
            largest_velocity: velocity(last),
            middle_level: level(0),
            largest_level: level(last),
            peak: (0..sensors).map(peak).collect(),
            opening: largest(&dynamic) / preload,
            dynamic_normal: largest(&dynamic),
        }
    }

    /// Largest displacement anywhere on the beam (m), from the accelerations.
    fn displacement(&self, frequency: f64) -> f64 {
        largest(&self.peak) / (TAU * frequency).powi(2)
    }
}

/// What the size of an effect is taken from.
struct Basis<'a> {
    drawn: &'a Drawn,
    scale: &'a Scale,
    size: f64,
}

impl Basis<'_> {
    fn parameter(&self, key: &str) -> f64 {
        self.drawn.rig.support.parameters.get(key).copied().unwrap_or_default()
    }

    fn friction(&self) -> f64 {
        self.parameter("mu_k") * self.drawn.rig.runs[0].preload_n
    }

    fn period(&self) -> f64 {
        1.0 / self.drawn.frequency
    }

    fn length(&self) -> f64 {
        self.drawn.rig.beam.length_m
    }

    /// `3EI/L³` (N/m): stiffness of the beam as a cantilever.
    fn stiffness(&self) -> f64 {
        3.0 * self.drawn.bending / self.length().powi(3)
    }

    fn place(&self, random: &mut impl Rng) -> f64 {
        self.length() * random.random_range(0.3..0.85)
    }

    fn sensor(&self, random: &mut impl Rng) -> usize {
        random.random_range(0..self.drawn.rig.sensors.position_m.len())
    }

    fn displacement(&self) -> f64 {
        self.scale.displacement(self.drawn.frequency)
    }

    fn loudest(&self) -> (usize, f64) {
        let peak = self.scale.peak.iter().copied().enumerate();
        peak.max_by(|a, b| a.1.total_cmp(&b.1)).unwrap_or((0, 1.0))
    }
}

fn sign(random: &mut impl Rng) -> f64 {
    if random.random_bool(0.5) { 1.0 } else { -1.0 }
}

/// The effect with a formula's id in RIG.toml; `None` for an unknown one.
#[must_use]
pub fn build(
    formula: &str,
    random: &mut impl Rng,
    drawn: &Drawn,
    scale: &Scale,
    size: f64,
) -> Option<Effect> {
    let basis = Basis { drawn, scale, size };
    friction(formula, random, &basis)
        .or_else(|| history(formula, random, &basis))
        .or_else(|| contact(formula, &basis))
        .or_else(|| structure(formula, random, &basis))
        .or_else(|| linear_structure(formula, random, &basis))
        .or_else(|| chain::excitation(formula, random, &basis))
        .or_else(|| chain::measurement(formula, random, &basis))
        .or_else(|| chain::channel(formula, random, &basis))
        .or_else(|| third::friction(formula, random, &basis))
        .or_else(|| third::beside(formula, random, &basis))
}

/// Friction against speed, direction and deflection.
fn friction(formula: &str, random: &mut impl Rng, b: &Basis<'_>) -> Option<Effect> {
    let mu_s = b.parameter("mu_k") * (1.0 + 0.3 * b.size);
    let v_s_m_per_s = b.scale.velocity * random.random_range(0.3..1.0);
    let delta = random.random_range(1.0..2.0);
    let viscous = 0.15 * b.size * b.friction();
    let sigma1_s_per_m = 0.12 * b.size * b.parameter("sigma0_per_m") * b.period() / TAU;
    let v_d_m_per_s = b.scale.velocity * random.random_range(0.5..2.0);
    let share = 0.08 * b.size * sign(random);
    let breakaway = (0.25 + 0.15 * b.size).min(0.9);
    let power = random.random_range(1.2..1.6);
    Some(match formula {
        "friction.stribeck" => Effect::Stribeck { mu_s, v_s_m_per_s, delta },
        "friction.stribeck/rational" => Effect::RationalStribeck { mu_s, v_s_m_per_s, delta },
        "friction.viscous" => Effect::Viscous { sigma2_n_s_per_m: viscous / b.scale.largest_velocity },
        "friction.viscous/power" => Effect::PowerViscous {
            force_at_1_m_per_s_n: viscous / b.scale.largest_velocity.powf(power),
            power,
        },
        "friction.presliding-damping" => Effect::PreslidingDamping { sigma1_s_per_m, v_d_m_per_s },
        "friction.presliding-damping/rational" => Effect::RationalDamping { sigma1_s_per_m, v_d_m_per_s },
        "friction.asymmetry" => Effect::Asymmetry { share },
        "friction.asymmetry/smooth" => {
            Effect::SmoothAsymmetry { share, velocity_m_per_s: 0.2 * b.scale.velocity }
        }
        "friction.breakaway" => Effect::Breakaway { breakaway },
        "friction.breakaway/straight" => Effect::StraightBreakaway { breakaway },
        "friction.exponent" => Effect::Exponent { exponent: 2.0_f64.powf(0.6 * b.size * sign(random)) },
        "friction.exponent/power" => {
            Effect::PowerBristle { power: 2.0_f64.powf(0.7 * b.size * sign(random)) }
        }
        "friction.wear" => Effect::Wear { relative_change: 1.2 * share },
        "friction.wear/settling" => Effect::SettlingWear { relative_change: 1.2 * share },
        "unlisted:contact/speed-square" => Effect::SpeedSquare {
            coefficient_n_s2_per_m2: 0.12 * b.size * b.friction() / b.scale.largest_velocity.powi(2),
        },
        _ => return None,
    })
}

/// Friction against time, place and normal force.
fn history(formula: &str, random: &mut impl Rng, b: &Basis<'_>) -> Option<Effect> {
    let (mu_s, v_s_m_per_s) = (b.parameter("mu_s"), b.parameter("v_s_m_per_s"));
    let delta = b.parameter("delta");
    let time_s = 0.04 * b.size * b.period();
    let loss = (0.2 * b.size).min(0.7);
    let rise_time_s = random.random_range(0.3..1.5) * b.period();
    let fall_time_s = random.random_range(0.1..0.8) * b.period();
    let velocity_m_per_s = b.scale.velocity * random.random_range(0.5..1.5);
    let share = 0.12 * b.size * sign(random);
    let wavelength_m = b.scale.largest_slip * random.random_range(0.3..1.2);
    let distance_m = b.scale.slip * random.random_range(0.03..0.15);
    let age = random.random_range(0.003..0.02) * b.period();
    let preloads: f64 = b.drawn.rig.runs.iter().map(|r| r.preload_n).sum();
    Some(match formula {
        "friction.lag" => Effect::Lag { time_s, mu_s, v_s_m_per_s, delta },
        "friction.lag/saturating" => Effect::SaturatingLag { time_s, mu_s, v_s_m_per_s, delta },
        "friction.film" => Effect::Film { loss, rise_time_s, fall_time_s, velocity_m_per_s },
        "friction.film/rational" => Effect::RationalFilm { loss, rise_time_s, fall_time_s, velocity_m_per_s },
        "friction.ageing" => Effect::Ageing { gain: 0.08 * b.size, distance_m, time_s: age },
        "friction.ageing/saturating" => {
            Effect::SaturatingAgeing { gain: 0.25 * b.size, distance_m, time_s: 2.0 * age }
        }
        "friction.position" => Effect::Position { slope_per_m: share / b.scale.largest_slip },
        "friction.position/saturating" => Effect::SaturatingPosition {
            share,
            distance_m: b.scale.largest_slip * random.random_range(0.4..1.0),
        },
        "friction.position-periodic" => Effect::PositionPeriodic { share: share.abs(), wavelength_m },
        "friction.position-periodic/triangle" => {
            Effect::TrianglePosition { share: share.abs(), wavelength_m }
        }
        "friction.normal-dependence" => Effect::NormalDependence { exponent: share.abs() },
        "friction.normal-dependence/straight" => Effect::StraightNormalDependence {
            slope: share.abs(),
            reference_n: preloads / b.drawn.rig.runs.len() as f64,
        },
        "unlisted:contact/normal-memory" => Effect::NormalMemory { time_s: 2.0 * time_s },
        _ => return None,
    })
}

/// Normal and tangential contact.
fn contact(formula: &str, b: &Basis<'_>) -> Option<Effect> {
    let stiffness = b.drawn.rig.support.normal_stiffness_n_per_m.unwrap_or_default();
    let approach = b.scale.dynamic_normal / stiffness;
    let series_stiffness_n_per_m = 3.0 * b.drawn.tangential / b.size;
    let half_play_m = 0.15 * b.size * b.scale.slip;
    Some(match formula {
        "contact.lift-off" => Effect::LiftOff,
        "contact.normal-stiffening" => {
            Effect::NormalStiffening { cubic_n_per_m3: 0.3 * b.size * stiffness / approach.powi(2) }
        }
        "contact.normal-stiffening/exponential" => Effect::ExponentialStiffening { sharpness: 0.3 * b.size },
        "contact.tangential-stiffness" => Effect::TangentialStiffness { series_stiffness_n_per_m },
        "contact.tangential-stiffness/series" => Effect::SeriesSpring { series_stiffness_n_per_m },
        "contact.tangential-stiffness/parallel" => {
            Effect::ParallelSpring { stiffness_n_per_m: 0.03 * b.size * b.drawn.tangential }
        }
        "contact.backlash" => Effect::Backlash { half_play_m },
        "contact.backlash/gradual" => Effect::GradualBacklash { half_play_m },
        _ => return None,
    })
}

/// Loads on the beam that are no straight function of its motion.
fn structure(formula: &str, random: &mut impl Rng, b: &Basis<'_>) -> Option<Effect> {
    let position_m = b.place(random);
    let displacement = b.displacement();
    let speed = TAU * b.drawn.frequency * displacement;
    let cubic = 0.05 * b.size * b.stiffness() / displacement.powi(2);
    let damping = 2e-3 * b.size * b.drawn.mass * TAU * b.drawn.frequency;
    let power = random.random_range(1.7..2.4);
    let gap_m = if random.random_bool(0.3) { 0.2 * displacement } else { 0.0 };
    let highest = b.drawn.rig.runs.iter().flat_map(|r| &r.force_amplitude_n).fold(0.0, |m: f64, f| m.max(*f));
    Some(match formula {
        "structure.cubic-stiffness" => Effect::CubicStiffness { position_m, stiffness_n_per_m3: cubic },
        "structure.cubic-stiffness/yielding" => Effect::YieldingCubic {
            position_m,
            stiffness_n_per_m3: 2.0 * cubic,
            scale_m: displacement * random.random_range(0.5..1.5),
        },
        "structure.quadratic-damping" => {
            Effect::QuadraticDamping { position_m, damping_n_s2_per_m2: damping / speed }
        }
        "structure.quadratic-damping/power" => Effect::PowerDamping {
            position_m,
            force_at_1_m_per_s_n: damping * speed.powf(1.0 - power),
            power,
        },
        "structure.second-support" => {
            Effect::SecondSupport { position_m, stiffness_n_per_m: 10.0 * b.size * b.stiffness(), gap_m }
        }
        "structure.second-support/round" => Effect::RoundSupport {
            position_m,
            stiffness_n_per_m_3_2: 10.0 * b.size * b.stiffness() / displacement.sqrt(),
            gap_m,
        },
        "structure.second-support/rubbing" => Effect::RubbingSupport {
            position_m,
            level_n: 0.05 * b.size * highest,
            velocity_m_per_s: 0.05 * speed,
        },
        "unlisted:structure/even-stiffness" => Effect::EvenStiffness {
            position_m,
            stiffness_n_per_m2: 0.1 * b.size * b.stiffness() / displacement,
        },
        _ => return None,
    })
}

/// Changes of the linear structure.
fn linear_structure(formula: &str, random: &mut impl Rng, b: &Basis<'_>) -> Option<Effect> {
    let stiffness = b.drawn.bending / b.length();
    Some(match formula {
        "structure.clamp-compliance" => {
            Effect::ClampCompliance { rotational_stiffness_n_m_per_rad: 800.0 * stiffness / b.size.powi(2) }
        }
        "structure.added-mass" => {
            Effect::AddedMass { position_m: b.place(random), mass_kg: 4e-3 * b.size * b.drawn.mass }
        }
        "structure.modal-frequency" => Effect::ModalFrequency {
            mode: random.random_range(1..=3),
            relative_change: 2e-3 * b.size * sign(random),
        },
        "structure.modal-damping" => Effect::ModalDamping {
            mode: b.drawn.mode,
            relative_change: (0.15 * b.size).min(0.5) * sign(random),
        },
        "structure.frequency-drift" => {
            Effect::FrequencyDrift { relative_change: 1e-3 * b.size * sign(random) }
        }
        "structure.frequency-drift/settling" => {
            Effect::SettlingDrift { relative_change: 1e-3 * b.size * sign(random) }
        }
        _ => return None,
    })
}
