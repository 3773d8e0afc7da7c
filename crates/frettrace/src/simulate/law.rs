//! The true law: the declared one, or the same with effects in it: a bristle with hooks, or, where friction holds rigidly and its curve alone is
//! another, the rigid law that has the curve.

use std::f64::consts::TAU;

use frettrace_forward::simulate::SimulatedLaw;
use frettrace_friction::effects::{Hook, ModifiedLaw};
use frettrace_identify::contact::Family;

use crate::StudyError;
use crate::rig::{Effect, Rig, RigSupport, declared_law};

/// The law that acts.
pub(super) fn true_law(rig: &Rig) -> Result<SimulatedLaw, StudyError> {
    if let Some(law) = super::foreign::law(rig)? {
        return Ok(SimulatedLaw::Foreign(law));
    }
    let Some(first) = rig.effects.iter().find(|effect| !hooks(rig, effect).is_empty()) else {
        return declared(&rig.support);
    };
    if let Some(support) = rigid(rig) {
        return declared(&support);
    }
    let mut law = bristle(rig)
        .ok_or_else(|| StudyError::EffectOnLaw { effect: first.id(), law: rig.support.law.clone() })?;
    for (hook, value) in rig.effects.iter().flat_map(|effect| hooks(rig, effect)) {
        law.set(hook, value);
    }
    Ok(SimulatedLaw::Modified(law))
}

fn declared(support: &RigSupport) -> Result<SimulatedLaw, StudyError> {
    let model = declared_law(support).map_err(|problem| StudyError::RigValue {
        path: std::path::PathBuf::new(),
        place: problem.place,
        found: problem.found,
        allowed: problem.allowed,
    })?;
    Ok(SimulatedLaw::Declared(model))
}

/// Rigid friction with the curve that effects give it, as the law of Stribeck; `None` for another law, or where an effect asks for more than a curve.
fn rigid(rig: &Rig) -> Option<RigSupport> {
    let mut support = rig.support.clone();
    Family::named(&support.law).filter(|family| family.is_static())?;
    let mu_k = *support.parameters.get("mu_k")?;
    // Friction that does not fall with velocity: any velocity and exponent say the same.
    for (key, value) in [("mu_s", mu_k), ("v_s_m_per_s", 1.0), ("delta", 1.0), ("sigma2_n_s_per_m", 0.0)] {
        support.parameters.entry(key.to_owned()).or_insert(value);
    }
    for (hook, value) in rig.effects.iter().flat_map(|effect| hooks(rig, effect)) {
        let (key, value) = match hook {
            Hook::StribeckRise => ("mu_s", mu_k + value),
            Hook::StribeckVelocity => ("v_s_m_per_s", value),
            Hook::StribeckExponent => ("delta", value),
            Hook::Viscous => ("sigma2_n_s_per_m", value),
            _ => return None,
        };
        support.parameters.insert(key.to_owned(), value);
    }
    Family::Stribeck.name().clone_into(&mut support.law);
    Some(support)
}

/// The declared law as a bristle with hooks.
fn bristle(rig: &Rig) -> Option<ModifiedLaw<f64>> {
    let parameters = &rig.support.parameters;
    let get = |key: &str| parameters.get(key).copied();
    let mut law = ModifiedLaw::dahl(get("sigma0_per_m")?, get("mu_k")?);
    match rig.support.law.as_str() {
        "dahl" => {
            let exponent = get("exponent")?;
            if exponent != 1.0 {
                law.set(Hook::Exponent, exponent);
            }
        }
        "lugre" | "hybrid" => {
            law.set(Hook::StribeckRise, get("mu_s")? - get("mu_k")?);
            law.set(Hook::StribeckVelocity, get("v_s_m_per_s")?);
            law.set(Hook::StribeckExponent, get("delta")?);
            law.set(Hook::Sigma1, get("sigma1_s_per_m")?);
            law.set(Hook::DampingVelocity, get("v_d_m_per_s")?);
            law.set(Hook::Viscous, get("sigma2_n_s_per_m")?);
            if rig.support.law == "hybrid" {
                law.set(Hook::Breakaway, get("breakaway")?);
            }
        }
        _ => return None,
    }
    Some(law)
}

/// What an effect sets in the law; nothing where it does not act in the contact.
pub(super) fn hooks(rig: &Rig, effect: &Effect) -> Vec<(Hook, f64)> {
    let mu_k = rig.support.parameters.get("mu_k").copied().unwrap_or_default();
    let stribeck = |mu_s: f64, velocity: f64, delta: f64| {
        vec![
            (Hook::StribeckRise, mu_s - mu_k),
            (Hook::StribeckVelocity, velocity),
            (Hook::StribeckExponent, delta),
        ]
    };
    match *effect {
        Effect::Stribeck { mu_s, v_s_m_per_s, delta } => stribeck(mu_s, v_s_m_per_s, delta),
        Effect::Viscous { sigma2_n_s_per_m } => vec![(Hook::Viscous, sigma2_n_s_per_m)],
        Effect::Lag { time_s, mu_s, v_s_m_per_s, delta } => {
            let mut all = stribeck(mu_s, v_s_m_per_s, delta);
            all.push((Hook::LagTime, time_s));
            all
        }
        Effect::Film { loss, rise_time_s, fall_time_s, velocity_m_per_s } => vec![
            (Hook::FilmLoss, loss),
            (Hook::FilmRise, rise_time_s),
            (Hook::FilmFall, fall_time_s),
            (Hook::FilmVelocity, velocity_m_per_s),
        ],
        Effect::Ageing { gain, distance_m, time_s } => {
            vec![(Hook::AgeingGain, gain), (Hook::AgeingDistance, distance_m), (Hook::AgeingTime, time_s)]
        }
        Effect::Asymmetry { share } => vec![(Hook::Asymmetry, share)],
        Effect::Breakaway { breakaway } => vec![(Hook::Breakaway, breakaway)],
        Effect::Exponent { exponent } => vec![(Hook::Exponent, exponent)],
        Effect::PreslidingDamping { sigma1_s_per_m, v_d_m_per_s } => {
            vec![(Hook::Sigma1, sigma1_s_per_m), (Hook::DampingVelocity, v_d_m_per_s)]
        }
        Effect::Position { slope_per_m } => vec![(Hook::Position, slope_per_m)],
        Effect::PositionPeriodic { share, wavelength_m } => vec![
            (Hook::PeriodicSine, share),
            (Hook::PeriodicCosine, 0.0),
            (Hook::PeriodicNumber, TAU / wavelength_m),
        ],
        Effect::NormalDependence { exponent } => vec![(Hook::NormalExponent, exponent)],
        Effect::Wear { relative_change } => vec![(Hook::Wear, relative_change)],
        Effect::TangentialStiffness { series_stiffness_n_per_m } => {
            vec![(Hook::SeriesCompliance, 1.0 / series_stiffness_n_per_m)]
        }
        Effect::Backlash { half_play_m } => vec![(Hook::Backlash, half_play_m)],
        _ => Vec::new(),
    }
}
