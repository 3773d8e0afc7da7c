//! Effects of the excitation and of the measurement chain.

use super::{Basis, sign};
use frettrace::rig::Effect;
use rand::{Rng, RngExt};

pub(super) fn excitation(formula: &str, random: &mut impl Rng, b: &Basis<'_>) -> Option<Effect> {
    let frequency_ratio = [0.5, 1.0, 1.0, 2.0][random.random_range(0..4)];
    let phase_rad = random.random_range(-3.0..3.0);
    let share = (0.1 * b.size).min(0.9);
    let lowest = b.drawn.rig.runs[0].force_amplitude_n[0];
    Some(match formula {
        "excitation.preload-modulation" => Effect::PreloadModulation { share, frequency_ratio, phase_rad },
        "excitation.preload-modulation/square" => {
            Effect::SquareModulation { share, frequency_ratio, phase_rad }
        }
        "excitation.base-motion" => Effect::BaseMotion {
            acceleration_m_per_s2: 0.05 * b.size * b.scale.middle_level,
            frequency_ratio,
            phase_rad,
        },
        "unlisted:excitation/moment" => Effect::ExciterMoment { lever_m: 0.02 * b.size * b.length() },
        "unlisted:excitation/second-force" => Effect::SecondForce {
            position_m: b.place(random),
            amplitude_n: 0.2 * b.size * lowest,
            frequency_ratio: f64::from(random.random_range(1..=3)),
            phase_rad,
        },
        _ => return None,
    })
}

/// One channel: what has a name.
pub(super) fn measurement(formula: &str, random: &mut impl Rng, b: &Basis<'_>) -> Option<Effect> {
    let sensor = b.sensor(random);
    let level = b.scale.middle_level;
    let (amplitude_m_per_s2, frequency_hz) = (0.02 * b.size * level, [50.0, 60.0][random.random_range(0..2)]);
    let (start_share, length_share) = (random.random_range(0.2..0.6), 0.03 * b.size);
    let (loudest, peak) = b.loudest();
    Some(match formula {
        "measurement.gain" => Effect::Gain { sensor, factor: 1.0 + 0.03 * b.size * sign(random) },
        "measurement.delay" => Effect::Delay { sensor, delay_s: 3e-3 * b.size * b.period() },
        "measurement.delay/low-pass" => Effect::LowPass { sensor, time_s: 3e-3 * b.size * b.period() },
        "measurement.hum" => Effect::Hum { sensor, amplitude_m_per_s2, frequency_hz },
        "measurement.hum/third-harmonic" => {
            let third_share = random.random_range(0.2..0.8);
            Effect::ThirdHarmonicHum { sensor, amplitude_m_per_s2, frequency_hz, third_share }
        }
        "measurement.clipping" => {
            Effect::Clipping { sensor: loudest, limit_m_per_s2: peak * 0.9_f64.powf(2.0 * b.size) }
        }
        "measurement.clipping/soft" => {
            Effect::SoftClipping { sensor: loudest, limit_m_per_s2: 1.1 * peak * 0.9_f64.powf(2.0 * b.size) }
        }
        "measurement.position" => {
            Effect::SensorPosition { sensor, shift_m: 7e-3 * b.size * b.length() * sign(random) }
        }
        "measurement.dropout" => Effect::Dropout { sensor, start_share, length_share },
        "measurement.dropout/hold" => Effect::HeldDropout { sensor, start_share, length_share },
        "measurement.offset" => Effect::Offset { sensor, offset_m_per_s2: 0.05 * b.size * level },
        "measurement.offset/drift" => Effect::OffsetDrift { sensor, offset_m_per_s2: 0.1 * b.size * level },
        _ => return None,
    })
}

/// One channel: what has no name.
pub(super) fn channel(formula: &str, random: &mut impl Rng, b: &Basis<'_>) -> Option<Effect> {
    let sensor = b.sensor(random);
    let count = b.drawn.rig.sensors.position_m.len();
    Some(match formula {
        "unlisted:measurement/quadratic-gain" => {
            Effect::QuadraticGain { sensor, coefficient_s2_per_m: 0.05 * b.size / b.loudest().1 }
        }
        "unlisted:measurement/high-pass" => {
            Effect::HighPass { sensor, corner_hz: 0.03 * b.size * b.drawn.frequency }
        }
        "unlisted:measurement/cross-talk" => {
            let from = (sensor + random.random_range(1..count)) % count;
            Effect::CrossTalk { sensor, from, share: 0.03 * b.size }
        }
        _ => return None,
    })
}
