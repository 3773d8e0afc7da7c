//! Ranges of the effects in other formulas and of those without a name.

use super::{Effect, Rig, STIFFNESS};

const TIME: [f64; 2] = [1e-6, 10.0];
const VELOCITY: [f64; 2] = [1e-6, 10.0];
const LENGTH: [f64; 2] = [1e-9, 1.0];
const POWER: [f64; 2] = [0.1, 10.0];
const SHARE: [f64; 2] = [-0.95, 0.95];
const FORCE: [f64; 2] = [0.0, 1e9];
const REFERENCE: [f64; 2] = [1e-3, 1e6];
const ACCELERATION: [f64; 2] = [1e-6, 1e6];

/// Keys of an effect with their values and ranges.
pub(super) fn ranges(rig: &Rig, effect: &Effect) -> Vec<(&'static str, f64, [f64; 2])> {
    match *effect {
        Effect::StraightStribeck { mu_s, v_s_m_per_s } => {
            vec![("mu_s", mu_s, [0.0, 5.0]), ("v_s_m_per_s", v_s_m_per_s, VELOCITY)]
        }
        Effect::RationalStribeck { mu_s, v_s_m_per_s, delta } => stribeck(mu_s, v_s_m_per_s, delta),
        Effect::SaturatingLag { time_s, mu_s, v_s_m_per_s, delta } => {
            let mut list = stribeck(mu_s, v_s_m_per_s, delta);
            list.push(("time_s", time_s, TIME));
            list
        }
        Effect::EyringViscous { force_n, velocity_m_per_s } => {
            vec![("force_n", force_n, FORCE), ("velocity_m_per_s", velocity_m_per_s, VELOCITY)]
        }
        Effect::PowerViscous { force_at_1_m_per_s_n, power } => {
            vec![("force_at_1_m_per_s_n", force_at_1_m_per_s_n, FORCE), ("power", power, POWER)]
        }
        Effect::RationalFilm { loss, rise_time_s, fall_time_s, velocity_m_per_s } => vec![
            ("loss", loss, [0.0, 0.99]),
            ("rise_time_s", rise_time_s, TIME),
            ("fall_time_s", fall_time_s, TIME),
            ("velocity_m_per_s", velocity_m_per_s, VELOCITY),
        ],
        Effect::SaturatingAgeing { gain, distance_m, time_s } => {
            vec![("gain", gain, [0.0, 5.0]), ("distance_m", distance_m, LENGTH), ("time_s", time_s, TIME)]
        }
        Effect::PowerAgeing { gain, distance_m, time_s, power } => vec![
            ("gain", gain, [0.0, 5.0]),
            ("distance_m", distance_m, LENGTH),
            ("time_s", time_s, TIME),
            ("power", power, [0.01, 1.0]),
        ],
        Effect::SmoothAsymmetry { share, velocity_m_per_s } => {
            vec![("share", share, SHARE), ("velocity_m_per_s", velocity_m_per_s, VELOCITY)]
        }
        Effect::StraightBreakaway { breakaway } => vec![("breakaway", breakaway, [0.0, 0.99])],
        Effect::PowerBristle { power } => vec![("power", power, POWER)],
        Effect::RationalDamping { sigma1_s_per_m, v_d_m_per_s }
        | Effect::ExponentialDamping { sigma1_s_per_m, v_d_m_per_s } => {
            vec![("sigma1_s_per_m", sigma1_s_per_m, FORCE), ("v_d_m_per_s", v_d_m_per_s, VELOCITY)]
        }
        Effect::SaturatingPosition { share, distance_m }
        | Effect::ParabolicPosition { share, distance_m } => {
            vec![("share", share, SHARE), ("distance_m", distance_m, LENGTH)]
        }
        Effect::TrianglePosition { share, wavelength_m } | Effect::SquarePosition { share, wavelength_m } => {
            vec![("share", share, SHARE), ("wavelength_m", wavelength_m, LENGTH)]
        }
        Effect::Adhesion { share, reference_n } => {
            vec![("share", share, SHARE), ("reference_n", reference_n, REFERENCE)]
        }
        Effect::StraightNormalDependence { slope, reference_n } => {
            vec![("slope", slope, [-2.0, 2.0]), ("reference_n", reference_n, REFERENCE)]
        }
        Effect::SettlingWear { relative_change }
        | Effect::RootWear { relative_change }
        | Effect::SettlingDrift { relative_change } => {
            vec![("relative_change", relative_change, super::SMALL_CHANGE)]
        }
        _ => beyond_friction(rig, effect),
    }
}

fn stribeck(mu_s: f64, velocity: f64, delta: f64) -> Vec<(&'static str, f64, [f64; 2])> {
    vec![("mu_s", mu_s, [0.0, 5.0]), ("v_s_m_per_s", velocity, VELOCITY), ("delta", delta, POWER)]
}

fn beyond_friction(rig: &Rig, effect: &Effect) -> Vec<(&'static str, f64, [f64; 2])> {
    let signed = |name, value| (name, value, [-1e18, 1e18]);
    let gap = |value| ("gap_m", value, [-0.1, 0.1]);
    match *effect {
        Effect::ExponentialStiffening { sharpness } => vec![("sharpness", sharpness, [0.0, 10.0])],
        Effect::SeriesSpring { series_stiffness_n_per_m: value } => {
            vec![("series_stiffness_n_per_m", value, STIFFNESS)]
        }
        Effect::ParallelSpring { stiffness_n_per_m: value } => vec![("stiffness_n_per_m", value, STIFFNESS)],
        Effect::GradualBacklash { half_play_m } => vec![("half_play_m", half_play_m, LENGTH)],
        Effect::RoundContact { power } => vec![("power", power, [1.0, 10.0])],
        Effect::SmoothSupport { stiffness_n_per_m, gap_m, smoothness_m, .. } => vec![
            ("stiffness_n_per_m", stiffness_n_per_m, STIFFNESS),
            gap(gap_m),
            ("smoothness_m", smoothness_m, LENGTH),
        ],
        Effect::YieldingCubic { stiffness_n_per_m3, scale_m, .. }
        | Effect::HyperbolicCubic { stiffness_n_per_m3, scale_m, .. } => {
            vec![signed("stiffness_n_per_m3", stiffness_n_per_m3), ("scale_m", scale_m, LENGTH)]
        }
        Effect::PowerDamping { force_at_1_m_per_s_n, power, .. } => {
            vec![("force_at_1_m_per_s_n", force_at_1_m_per_s_n, FORCE), ("power", power, POWER)]
        }
        Effect::RoundSupport { stiffness_n_per_m_3_2, gap_m, .. } => {
            vec![("stiffness_n_per_m_3_2", stiffness_n_per_m_3_2, [0.0, 1e18]), gap(gap_m)]
        }
        Effect::RubbingSupport { level_n, velocity_m_per_s, .. } => {
            vec![("level_n", level_n, FORCE), ("velocity_m_per_s", velocity_m_per_s, VELOCITY)]
        }
        Effect::SquareModulation { share, frequency_ratio, phase_rad }
        | Effect::SkewedModulation { share, frequency_ratio, phase_rad } => vec![
            ("share", share, SHARE),
            ("frequency_ratio", frequency_ratio, [1e-3, 100.0]),
            ("phase_rad", phase_rad, [-7.0, 7.0]),
        ],
        Effect::SpeedSquare { coefficient_n_s2_per_m2: value } => {
            vec![signed("coefficient_n_s2_per_m2", value)]
        }
        Effect::NormalMemory { time_s } => vec![("time_s", time_s, TIME)],
        Effect::EvenStiffness { stiffness_n_per_m2, .. } => {
            vec![signed("stiffness_n_per_m2", stiffness_n_per_m2)]
        }
        Effect::ExciterMoment { lever_m } => vec![("lever_m", lever_m, [-1.0, 1.0])],
        Effect::SecondForce { amplitude_n, frequency_ratio, phase_rad, .. } => vec![
            ("amplitude_n", amplitude_n, FORCE),
            ("frequency_ratio", frequency_ratio, [1e-3, 100.0]),
            ("phase_rad", phase_rad, [-7.0, 7.0]),
        ],
        _ => of_a_channel(rig, effect),
    }
}

fn of_a_channel(rig: &Rig, effect: &Effect) -> Vec<(&'static str, f64, [f64; 2])> {
    let last = rig.sensors.position_m.len() as f64 - 1.0;
    match *effect {
        Effect::LowPass { time_s, .. } | Effect::TwoLowPasses { time_s, .. } => {
            vec![("time_s", time_s, TIME)]
        }
        Effect::ThirdHarmonicHum { amplitude_m_per_s2, frequency_hz, third_share, .. } => vec![
            ("amplitude_m_per_s2", amplitude_m_per_s2, [0.0, 1e4]),
            ("frequency_hz", frequency_hz, [0.1, 0.5 * rig.sampling.rate_hz]),
            ("third_share", third_share, [-2.0, 2.0]),
        ],
        Effect::SoftClipping { limit_m_per_s2, .. } | Effect::OneSidedClipping { limit_m_per_s2, .. } => {
            vec![("limit_m_per_s2", limit_m_per_s2, ACCELERATION)]
        }
        Effect::HeldDropout { start_share, length_share, .. } => {
            vec![("start_share", start_share, [0.0, 1.0]), ("length_share", length_share, [0.0, 1.0])]
        }
        Effect::OffsetDrift { offset_m_per_s2, .. } | Effect::SettlingOffset { offset_m_per_s2, .. } => {
            vec![("offset_m_per_s2", offset_m_per_s2, [-1e4, 1e4])]
        }
        Effect::QuadraticGain { coefficient_s2_per_m, .. } => {
            vec![("coefficient_s2_per_m", coefficient_s2_per_m, [-1e3, 1e3])]
        }
        Effect::HighPass { corner_hz, .. } => {
            vec![("corner_hz", corner_hz, [1e-3, 0.5 * rig.sampling.rate_hz])]
        }
        Effect::CrossTalk { from, share, .. } => {
            vec![("from", from as f64, [0.0, last]), ("share", share, SHARE)]
        }
        _ => Vec::new(),
    }
}
