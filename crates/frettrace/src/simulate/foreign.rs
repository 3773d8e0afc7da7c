//! Effects in other formulas than the explaining model's, and effects without a name.

use frettrace_forward::march::Characteristic;
use frettrace_forward::simulate::{
    Attached, Bristle, CrossTalk, Distortion, ForeignLaw, Form, Hum, SecondForce, SimulatedRig,
};

use crate::StudyError;
use crate::rig::{Effect, Rig};

/// Effects of the structure, the normal contact and the excitation.
pub(super) fn structure_effect(effect: &Effect, simulated: &mut SimulatedRig) {
    let attached = match *effect {
        Effect::YieldingCubic { position_m, stiffness_n_per_m3: stiffness, scale_m: scale } => {
            (position_m, Characteristic::YieldingCubicSpring { stiffness, scale })
        }
        Effect::PowerDamping { position_m, force_at_1_m_per_s_n: damping, power } => {
            (position_m, Characteristic::PowerDashpot { damping, power })
        }
        Effect::RoundSupport { position_m, stiffness_n_per_m_3_2: stiffness, gap_m: gap } => {
            (position_m, Characteristic::RoundStop { stiffness, gap })
        }
        Effect::RubbingSupport { position_m, level_n: level, velocity_m_per_s: velocity } => {
            (position_m, Characteristic::SmoothCoulomb { level, velocity })
        }
        Effect::HyperbolicCubic { position_m, stiffness_n_per_m3: stiffness, scale_m: scale } => {
            (position_m, Characteristic::HyperbolicSpring { stiffness, scale })
        }
        Effect::SmoothSupport { position_m, stiffness_n_per_m: stiffness, gap_m: gap, smoothness_m } => {
            (position_m, Characteristic::SmoothStop { stiffness, gap, smoothness: smoothness_m })
        }
        Effect::EvenStiffness { position_m, stiffness_n_per_m2 } => {
            (position_m, Characteristic::EvenSpring(stiffness_n_per_m2))
        }
        Effect::ExponentialStiffening { sharpness } => {
            simulated.normal.sharpness = sharpness;
            return;
        }
        Effect::RoundContact { power } => {
            simulated.normal.power = power;
            return;
        }
        Effect::ExciterMoment { lever_m } => {
            simulated.exciter_lever = lever_m;
            return;
        }
        Effect::SecondForce { position_m, amplitude_n, frequency_ratio, phase_rad } => {
            simulated.second_force = Some(SecondForce {
                position: position_m,
                amplitude: amplitude_n,
                frequency_ratio,
                phase: phase_rad,
            });
            return;
        }
        _ => return,
    };
    simulated.attached.push((attached.0, Attached::Load(attached.1)));
}

/// Effects of one measuring chain.
pub(super) fn channel_effect(effect: &Effect, simulated: &mut SimulatedRig) {
    let Some(sensor) = effect.sensor().and_then(|index| simulated.sensors.get_mut(index)) else { return };
    let chain = &mut sensor.chain;
    match *effect {
        Effect::LowPass { time_s, .. } => chain.distortion = Some(Distortion::LowPass(time_s)),
        Effect::TwoLowPasses { time_s, .. } => chain.distortion = Some(Distortion::TwoLowPasses(time_s)),
        Effect::OneSidedClipping { limit_m_per_s2, .. } => chain.upper_limit = limit_m_per_s2,
        Effect::SettlingOffset { offset_m_per_s2, .. } => chain.settling_offset = offset_m_per_s2,
        Effect::HighPass { corner_hz, .. } => chain.distortion = Some(Distortion::HighPass(corner_hz)),
        Effect::SoftClipping { limit_m_per_s2, .. } => {
            chain.distortion = Some(Distortion::SoftLimit(limit_m_per_s2));
        }
        Effect::QuadraticGain { coefficient_s2_per_m, .. } => {
            chain.distortion = Some(Distortion::Quadratic(coefficient_s2_per_m));
        }
        Effect::ThirdHarmonicHum { amplitude_m_per_s2, frequency_hz, third_share, .. } => {
            chain.hum = Some(Hum {
                amplitude: amplitude_m_per_s2,
                frequency: frequency_hz,
                phase: 0.0,
                third: third_share,
            });
        }
        Effect::HeldDropout { start_share, length_share, .. } => {
            chain.dropouts.push([start_share, start_share + length_share]);
            chain.holds = true;
        }
        Effect::OffsetDrift { offset_m_per_s2, .. } => chain.offset_drift = offset_m_per_s2,
        Effect::CrossTalk { from, share, .. } => sensor.cross_talk = Some(CrossTalk { from, share }),
        _ => {}
    }
}

/// The law with its effects in other formulas; `None` where there is none such.
///
/// # Errors
/// [`StudyError::EffectOnLaw`] where the declared law has no bristle, [`StudyError::MixedFormulas`] where an effect of the
/// contact has the usual formula beside, or where there are more than two.
pub(super) fn law(rig: &Rig) -> Result<Option<ForeignLaw>, StudyError> {
    let found: Vec<(&Effect, Form)> =
        rig.effects.iter().filter_map(|effect| form(rig, effect).map(|form| (effect, form))).collect();
    let Some(&(first, _)) = found.first() else { return Ok(None) };
    let usual = rig.effects.iter().find(|effect| !super::law::hooks(rig, effect).is_empty());
    if let Some(effect) = usual.or(found.get(2).map(|(effect, _)| *effect)) {
        return Err(StudyError::MixedFormulas { effect: effect.id() });
    }
    let bristle = bristle(rig)
        .ok_or_else(|| StudyError::EffectOnLaw { effect: first.id(), law: rig.support.law.clone() })?;
    let mut forms = [Form::None; 2];
    for (place, (_, form)) in forms.iter_mut().zip(found) {
        *place = form;
    }
    Ok(Some(ForeignLaw { bristle, forms, progress: 0.0 }))
}

/// The declared law as a bristle.
fn bristle(rig: &Rig) -> Option<Bristle> {
    let get = |key: &str| rig.support.parameters.get(key).copied();
    let mut bristle = Bristle {
        sigma0: get("sigma0_per_m")?,
        mu_k: get("mu_k")?,
        stribeck: [0.0, 1.0, 1.0],
        damping: [0.0, 1.0],
        sigma2: 0.0,
        exponent: get("exponent").unwrap_or(1.0),
        breakaway: get("breakaway").unwrap_or(0.0),
    };
    if let (Some(mu_s), Some(v_s), Some(delta)) = (get("mu_s"), get("v_s_m_per_s"), get("delta")) {
        bristle.stribeck = [mu_s - bristle.mu_k, v_s, delta];
    }
    if let (Some(sigma1), Some(v_d)) = (get("sigma1_s_per_m"), get("v_d_m_per_s")) {
        bristle.damping = [sigma1, v_d];
    }
    bristle.sigma2 = get("sigma2_n_s_per_m").unwrap_or(0.0);
    Some(bristle)
}

/// The form of an effect of the contact.
fn form(rig: &Rig, effect: &Effect) -> Option<Form> {
    let mu_k = rig.support.parameters.get("mu_k").copied().unwrap_or_default();
    Some(match *effect {
        Effect::RationalStribeck { mu_s, v_s_m_per_s, delta } => {
            Form::RationalStribeck([mu_s - mu_k, v_s_m_per_s, delta])
        }
        Effect::PowerViscous { force_at_1_m_per_s_n, power } => {
            Form::ViscousPower([force_at_1_m_per_s_n, power])
        }
        Effect::SaturatingLag { time_s, mu_s, v_s_m_per_s, delta } => {
            Form::SaturatingLag([mu_s - mu_k, v_s_m_per_s, delta, time_s])
        }
        Effect::RationalFilm { loss, rise_time_s, fall_time_s, velocity_m_per_s } => {
            Form::RationalFilm([loss, rise_time_s, fall_time_s, velocity_m_per_s])
        }
        Effect::SaturatingAgeing { gain, distance_m, time_s } => {
            Form::SaturatingAgeing([gain, distance_m, time_s])
        }
        Effect::SmoothAsymmetry { share, velocity_m_per_s } => {
            Form::SmoothAsymmetry([share, velocity_m_per_s])
        }
        Effect::StraightBreakaway { breakaway } => Form::StraightBreakaway(breakaway),
        Effect::PowerBristle { power } => Form::PowerBristle(power),
        Effect::RationalDamping { sigma1_s_per_m, v_d_m_per_s } => {
            Form::RationalDamping([sigma1_s_per_m, v_d_m_per_s])
        }
        Effect::SaturatingPosition { share, distance_m } => Form::SaturatingPosition([share, distance_m]),
        Effect::TrianglePosition { share, wavelength_m } => Form::TrianglePosition([share, wavelength_m]),
        Effect::StraightNormalDependence { slope, reference_n } => {
            Form::StraightNormalDependence([slope, reference_n])
        }
        Effect::SettlingWear { relative_change } => Form::SettlingWear(relative_change),
        Effect::SeriesSpring { series_stiffness_n_per_m } => Form::SeriesSpring(series_stiffness_n_per_m),
        Effect::ParallelSpring { stiffness_n_per_m } => Form::ParallelSpring(stiffness_n_per_m),
        Effect::GradualBacklash { half_play_m } => Form::GradualBacklash(half_play_m),
        Effect::StraightStribeck { mu_s, v_s_m_per_s } => Form::StraightStribeck([mu_s - mu_k, v_s_m_per_s]),
        Effect::EyringViscous { force_n, velocity_m_per_s } => {
            Form::EyringViscous([force_n, velocity_m_per_s])
        }
        Effect::PowerAgeing { gain, distance_m, time_s, power } => {
            Form::PowerAgeing([gain, distance_m, time_s, power])
        }
        Effect::ExponentialDamping { sigma1_s_per_m, v_d_m_per_s } => {
            Form::ExponentialDamping([sigma1_s_per_m, v_d_m_per_s])
        }
        Effect::ParabolicPosition { share, distance_m } => Form::ParabolicPosition([share, distance_m]),
        Effect::SquarePosition { share, wavelength_m } => Form::SquarePosition([share, wavelength_m]),
        Effect::Adhesion { share, reference_n } => Form::Adhesion([share, reference_n]),
        Effect::RootWear { relative_change } => Form::RootWear(relative_change),
        Effect::SpeedSquare { coefficient_n_s2_per_m2 } => Form::SpeedSquare(coefficient_n_s2_per_m2),
        Effect::NormalMemory { time_s } => Form::NormalMemory(time_s),
        _ => return None,
    })
}
