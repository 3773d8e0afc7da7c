//! Effects in formulas that neither the model that explains nor the first sweep has: what is found of them is what can be expected of a
//! laboratory that nobody here has read.

use super::{Basis, sign};
use frettrace::rig::Effect;
use rand::{Rng, RngExt};
use std::f64::consts::TAU;

/// Friction.
pub(super) fn friction(formula: &str, random: &mut impl Rng, b: &Basis<'_>) -> Option<Effect> {
    let mu_s = b.parameter("mu_k") * (1.0 + 0.3 * b.size);
    let share = 0.12 * b.size * sign(random);
    let velocity_m_per_s = b.scale.velocity * random.random_range(0.3..1.0);
    let distance_m = b.scale.slip * random.random_range(0.03..0.15);
    let length_m = b.scale.largest_slip * random.random_range(0.3..1.2);
    let age = random.random_range(0.003..0.02) * b.period();
    let preloads: f64 = b.drawn.rig.runs.iter().map(|r| r.preload_n).sum();
    Some(match formula {
        "friction.stribeck/straight" => {
            Effect::StraightStribeck { mu_s, v_s_m_per_s: 2.0 * velocity_m_per_s }
        }
        "friction.viscous/eyring" => Effect::EyringViscous {
            force_n: 0.1 * b.size * b.friction(),
            velocity_m_per_s: b.scale.largest_velocity * random.random_range(0.2..0.6),
        },
        "friction.ageing/power" => {
            let power = random.random_range(0.2..0.5);
            Effect::PowerAgeing { gain: 0.1 * b.size, distance_m, time_s: age, power }
        }
        "friction.presliding-damping/exponential" => Effect::ExponentialDamping {
            sigma1_s_per_m: 0.12 * b.size * b.parameter("sigma0_per_m") * b.period() / TAU,
            v_d_m_per_s: b.scale.velocity * random.random_range(0.5..2.0),
        },
        "friction.position/parabola" => Effect::ParabolicPosition { share, distance_m: b.scale.largest_slip },
        "friction.position-periodic/square" => {
            Effect::SquarePosition { share: share.abs(), wavelength_m: length_m }
        }
        "friction.normal-dependence/adhesion" => {
            Effect::Adhesion { share: share.abs(), reference_n: preloads / b.drawn.rig.runs.len() as f64 }
        }
        "friction.wear/root" => Effect::RootWear { relative_change: 0.8 * share },
        _ => return None,
    })
}

/// Normal contact, structure, excitation and measurement chain.
pub(super) fn beside(formula: &str, random: &mut impl Rng, b: &Basis<'_>) -> Option<Effect> {
    let position_m = b.place(random);
    let displacement = b.displacement();
    let frequency_ratio = [0.5, 1.0, 1.0, 2.0][random.random_range(0..4)];
    let phase_rad = random.random_range(-3.0..3.0);
    let (sensor, level) = (b.sensor(random), b.scale.middle_level);
    let (loudest, peak) = b.loudest();
    Some(match formula {
        "contact.normal-stiffening/round" => Effect::RoundContact { power: 1.0 + 0.25 * b.size },
        "structure.cubic-stiffness/hyperbolic" => Effect::HyperbolicCubic {
            position_m,
            stiffness_n_per_m3: 0.03 * b.size * b.stiffness() / displacement.powi(2),
            scale_m: displacement * random.random_range(0.3..1.0),
        },
        "structure.second-support/smooth" => Effect::SmoothSupport {
            position_m,
            stiffness_n_per_m: 10.0 * b.size * b.stiffness(),
            gap_m: 0.2 * displacement,
            smoothness_m: displacement * random.random_range(0.05..0.3),
        },
        "excitation.preload-modulation/skewed" => {
            Effect::SkewedModulation { share: (0.1 * b.size).min(0.9), frequency_ratio, phase_rad }
        }
        "measurement.delay/two-low-passes" => {
            Effect::TwoLowPasses { sensor, time_s: 2e-3 * b.size * b.period() }
        }
        "measurement.clipping/one-sided" => {
            Effect::OneSidedClipping { sensor: loudest, limit_m_per_s2: peak * 0.9_f64.powf(2.0 * b.size) }
        }
        "measurement.offset/settling" => {
            Effect::SettlingOffset { sensor, offset_m_per_s2: 0.15 * b.size * level }
        }
        _ => return None,
    })
}
