//! Ranges of the values of a rig.

mod foreign;

use super::effect::Effect;
use super::{Rig, RigSlip};

/// A value out of range: where, what, what is allowed.
#[derive(Debug)]
pub(crate) struct Problem {
    pub(crate) place: String,
    pub(crate) found: String,
    pub(crate) allowed: String,
}

type Checked = Result<(), Problem>;

/// A value must lie between two others, both allowed.
fn within(place: impl Into<String>, value: f64, [low, high]: [f64; 2]) -> Checked {
    if (low..=high).contains(&value) {
        return Ok(());
    }
    Err(Problem { place: place.into(), found: value.to_string(), allowed: format!("{low} to {high}") })
}

/// Widest ranges in which the quantities of a beam on a friction support make sense.
const LENGTH: [f64; 2] = [1e-2, 100.0];
const SECTION: [f64; 2] = [1e-4, 1.0];
const STIFFNESS: [f64; 2] = [1.0, 1e12];
const RATIO: [f64; 2] = [1e-6, 0.3];
const SMALL_CHANGE: [f64; 2] = [-0.5, 0.5];
/// Least distance of the exciter from the clamp, over the length.
const LEAST_ARM: f64 = 1e-3;
/// Most steps of the march in a fine sample.
const MOST_STEPS: f64 = 256.0;

pub(super) fn check(rig: &Rig) -> Checked {
    let beam = &rig.beam;
    within("beam.length_m", beam.length_m, LENGTH)?;
    within("beam.width_m", beam.width_m, SECTION)?;
    within("beam.thickness_m", beam.thickness_m, SECTION)?;
    within("beam.youngs_modulus_pa", beam.youngs_modulus_pa, [1e6, 2e12])?;
    within("beam.density_kg_per_m3", beam.density_kg_per_m3, [10.0, 3e4])?;
    within("beam.area_m2", beam.area_m2.unwrap_or(1e-4), [1e-8, 1.0])?;
    within("beam.second_moment_m4", beam.second_moment_m4.unwrap_or(1e-8), [1e-16, 1.0])?;
    let clamp = rig.clamp.rotational_stiffness_n_m_per_rad;
    within("clamp.rotational_stiffness_n_m_per_rad", clamp, [1.0, f64::INFINITY])?;
    modes(rig)?;
    support(rig)?;
    places(rig)?;
    sampling(rig)?;
    rig.effects.iter().enumerate().try_for_each(|(index, e)| effect(rig, index, e))
}

fn modes(rig: &Rig) -> Checked {
    let modes = &rig.modes;
    let count = modes.damping_ratio.len().max(modes.natural_frequency_hz.len());
    within("modes.damping_ratio, number of values", modes.damping_ratio.len() as f64, [1.0, 40.0])?;
    within("modes, number of values", count as f64, [1.0, 40.0])?;
    within("modes.declared", modes.declared as f64, [0.0, 20.0])?;
    modes.damping_ratio.iter().try_for_each(|&ratio| within("modes.damping_ratio", ratio, RATIO))?;
    modes
        .natural_frequency_hz
        .iter()
        .try_for_each(|&f| within("modes.natural_frequency_hz", f, [0.1, 1e5]))?;
    within("modes.frequency_relative_std", modes.frequency_relative_std, [0.0, 0.1])?;
    within("modes.damping_relative_std", modes.damping_relative_std, [0.0, 1.0])
}

fn support(rig: &Rig) -> Checked {
    let support = &rig.support;
    super::declared_law(support)?;
    let missing = |key: &str, allowed: &str| Problem {
        place: format!("support.{key}"),
        found: "missing".to_owned(),
        allowed: allowed.to_owned(),
    };
    match support.slip {
        RigSlip::Rotation => {
            let arm = support
                .lever_arm_m
                .ok_or_else(|| missing("lever_arm_m", "1e-5 to 1 for slip = \"rotation\""))?;
            within("support.lever_arm_m", arm, [1e-5, 1.0])?;
            let stiffness = support.normal_stiffness_n_per_m.ok_or_else(|| {
                missing("normal_stiffness_n_per_m", "1 to inf (pinned) for slip = \"rotation\"")
            })?;
            within("support.normal_stiffness_n_per_m", stiffness, [1.0, f64::INFINITY])
        }
        RigSlip::Transverse => match support.normal_stiffness_n_per_m {
            None | Some(0.0) => Ok(()),
            Some(stiffness) => Err(Problem {
                place: "support.normal_stiffness_n_per_m".to_owned(),
                found: stiffness.to_string(),
                allowed: "none with slip = \"transverse\": the end slides, its normal force is the preload"
                    .to_owned(),
            }),
        },
    }
}

fn places(rig: &Rig) -> Checked {
    let on_beam = [0.0, rig.beam.length_m];
    // A force at the clamp moves nothing.
    within("exciter.position_m", rig.exciter.position_m, [LEAST_ARM * rig.beam.length_m, rig.beam.length_m])?;
    within("sensors.position_m, number of values", rig.sensors.position_m.len() as f64, [1.0, 64.0])?;
    rig.sensors.position_m.iter().try_for_each(|&x| within("sensors.position_m", x, on_beam))?;
    within("sensors.noise_std_m_per_s2", rig.sensors.noise_std_m_per_s2, [0.0, 1e4])?;
    within("sensors.noise_correlation", rig.sensors.noise_correlation, [0.0, 0.999])?;
    let Some(second) = &rig.second_support else { return Ok(()) };
    within("second_support.position_m", second.position_m, on_beam)?;
    within("second_support.stiffness_n_per_m", second.stiffness_n_per_m, STIFFNESS)?;
    within("second_support.gap_m", second.gap_m, [-0.1, 0.1])
}

fn sampling(rig: &Rig) -> Checked {
    within("sampling.rate_hz", rig.sampling.rate_hz, [10.0, 1e6])?;
    within("sampling.samples", rig.sampling.samples as f64, [64.0, 1e6])?;
    let fine = rig.sampling.fine_rate_hz();
    let march = rig.sampling.march_rate_hz.unwrap_or(fine);
    within("sampling.march_rate_hz", march, [fine, MOST_STEPS * fine])?;
    within("run, number of tables", rig.runs.len() as f64, [1.0, 999.0])?;
    for (index, run) in rig.runs.iter().enumerate() {
        let place = |key: &str| format!("run {}: {key}", index + 1);
        let highest = 0.2 * rig.sampling.rate_hz;
        within(
            place("frequency_hz"),
            run.frequency_hz,
            [rig.sampling.rate_hz / rig.sampling.samples as f64, highest],
        )?;
        within(place("preload_n"), run.preload_n, [1e-3, 1e6])?;
        within(place("beat_share"), run.beat_share, [0.0, 1.0])?;
        within(place("beat_frequency_ratio"), run.beat_frequency_ratio, [0.0, 1.0])?;
        within(
            place("force_amplitude_n, number of values"),
            run.force_amplitude_n.len() as f64,
            [1.0, 999.0],
        )?;
        for &force in &run.force_amplitude_n {
            within(place("force_amplitude_n"), force, [1e-6, 1e6])?;
        }
    }
    Ok(())
}

/// Keys of an effect with their values and ranges.
fn ranges(rig: &Rig, effect: &Effect) -> Vec<(&'static str, f64, [f64; 2])> {
    let period = [1e-6, 10.0];
    let velocity = [1e-6, 10.0];
    let delta = [0.1, 10.0];
    let on_beam = [0.0, rig.beam.length_m];
    let mut list = match *effect {
        Effect::Stribeck { mu_s, v_s_m_per_s, delta: d } => {
            vec![("mu_s", mu_s, [0.0, 10.0]), ("v_s_m_per_s", v_s_m_per_s, velocity), ("delta", d, delta)]
        }
        Effect::Viscous { sigma2_n_s_per_m } => vec![("sigma2_n_s_per_m", sigma2_n_s_per_m, [0.0, 1e6])],
        Effect::Lag { time_s, mu_s, v_s_m_per_s, delta: d } => vec![
            ("time_s", time_s, period),
            ("mu_s", mu_s, [0.0, 10.0]),
            ("v_s_m_per_s", v_s_m_per_s, velocity),
            ("delta", d, delta),
        ],
        Effect::Film { loss, rise_time_s, fall_time_s, velocity_m_per_s } => vec![
            ("loss", loss, [0.0, 0.99]),
            ("rise_time_s", rise_time_s, period),
            ("fall_time_s", fall_time_s, period),
            ("velocity_m_per_s", velocity_m_per_s, velocity),
        ],
        Effect::Ageing { gain, distance_m, time_s } => {
            vec![
                ("gain", gain, [0.0, 5.0]),
                ("distance_m", distance_m, [1e-9, 1.0]),
                ("time_s", time_s, period),
            ]
        }
        Effect::Asymmetry { share } => vec![("share", share, [-0.9, 0.9])],
        Effect::Breakaway { breakaway } => vec![("breakaway", breakaway, [0.0, 0.99])],
        Effect::Exponent { exponent } => vec![("exponent", exponent, [0.0, 10.0])],
        Effect::PreslidingDamping { sigma1_s_per_m, v_d_m_per_s } => {
            vec![("sigma1_s_per_m", sigma1_s_per_m, [0.0, 1e9]), ("v_d_m_per_s", v_d_m_per_s, velocity)]
        }
        Effect::Position { slope_per_m } => vec![("slope_per_m", slope_per_m, [-1e7, 1e7])],
        Effect::PositionPeriodic { share, wavelength_m } => {
            vec![("share", share, [-0.9, 0.9]), ("wavelength_m", wavelength_m, [1e-9, 1.0])]
        }
        Effect::NormalDependence { exponent } => vec![("exponent", exponent, [-2.0, 2.0])],
        Effect::Wear { relative_change } | Effect::FrequencyDrift { relative_change } => {
            vec![("relative_change", relative_change, SMALL_CHANGE)]
        }
        _ => ranges_beyond_friction(rig, effect),
    };
    list.extend(effect.position().map(|x| ("position_m", x, on_beam)));
    list.extend(
        effect.sensor().map(|s| ("sensor", s as f64, [0.0, rig.sensors.position_m.len() as f64 - 1.0])),
    );
    list
}

fn ranges_beyond_friction(rig: &Rig, effect: &Effect) -> Vec<(&'static str, f64, [f64; 2])> {
    let turn = [-7.0, 7.0];
    let ratio = [1e-3, 100.0];
    match *effect {
        Effect::NormalStiffening { cubic_n_per_m3 } => vec![("cubic_n_per_m3", cubic_n_per_m3, [0.0, 1e24])],
        Effect::TangentialStiffness { series_stiffness_n_per_m } => {
            vec![("series_stiffness_n_per_m", series_stiffness_n_per_m, STIFFNESS)]
        }
        Effect::Backlash { half_play_m } => vec![("half_play_m", half_play_m, [0.0, 0.1])],
        Effect::CubicStiffness { stiffness_n_per_m3, .. } => {
            vec![("stiffness_n_per_m3", stiffness_n_per_m3, [-1e18, 1e18])]
        }
        Effect::QuadraticDamping { damping_n_s2_per_m2, .. } => {
            vec![("damping_n_s2_per_m2", damping_n_s2_per_m2, [0.0, 1e6])]
        }
        Effect::ClampCompliance { rotational_stiffness_n_m_per_rad } => {
            vec![("rotational_stiffness_n_m_per_rad", rotational_stiffness_n_m_per_rad, [1.0, 1e12])]
        }
        Effect::AddedMass { mass_kg, .. } => vec![("mass_kg", mass_kg, [0.0, 1e3])],
        Effect::SecondSupport { stiffness_n_per_m, gap_m, .. } => {
            vec![("stiffness_n_per_m", stiffness_n_per_m, STIFFNESS), ("gap_m", gap_m, [-0.1, 0.1])]
        }
        Effect::ModalFrequency { mode, relative_change } | Effect::ModalDamping { mode, relative_change } => {
            vec![("mode", mode as f64, [1.0, 20.0]), ("relative_change", relative_change, SMALL_CHANGE)]
        }
        Effect::PreloadModulation { share, frequency_ratio, phase_rad } => vec![
            ("share", share, [-0.95, 0.95]),
            ("frequency_ratio", frequency_ratio, ratio),
            ("phase_rad", phase_rad, turn),
        ],
        Effect::BaseMotion { acceleration_m_per_s2, frequency_ratio, phase_rad } => vec![
            ("acceleration_m_per_s2", acceleration_m_per_s2, [0.0, 1e4]),
            ("frequency_ratio", frequency_ratio, ratio),
            ("phase_rad", phase_rad, turn),
        ],
        Effect::Gain { factor, .. } => vec![("factor", factor, [-10.0, 10.0])],
        Effect::Delay { delay_s, .. } => vec![("delay_s", delay_s, [-0.1, 0.1])],
        Effect::Hum { amplitude_m_per_s2, frequency_hz, .. } => vec![
            ("amplitude_m_per_s2", amplitude_m_per_s2, [0.0, 1e4]),
            ("frequency_hz", frequency_hz, [0.1, 0.5 * rig.sampling.rate_hz]),
        ],
        Effect::Clipping { limit_m_per_s2, .. } => vec![("limit_m_per_s2", limit_m_per_s2, [1e-6, 1e6])],
        Effect::SensorPosition { sensor, shift_m } => {
            let x = rig.sensors.position_m.get(sensor).copied().unwrap_or(0.0);
            vec![("shift_m", shift_m, [-x, rig.beam.length_m - x])]
        }
        Effect::Dropout { start_share, length_share, .. } => {
            vec![("start_share", start_share, [0.0, 1.0]), ("length_share", length_share, [0.0, 1.0])]
        }
        Effect::Offset { offset_m_per_s2, .. } => vec![("offset_m_per_s2", offset_m_per_s2, [-1e4, 1e4])],
        _ => foreign::ranges(rig, effect),
    }
}

fn effect(rig: &Rig, index: usize, effect: &Effect) -> Checked {
    ranges(rig, effect).into_iter().try_for_each(|(key, value, range)| {
        within(format!("effect {} ({}): {key}", index + 1, effect.id()), value, range)
    })
}
