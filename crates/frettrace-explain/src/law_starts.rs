//! Where the fit of a law on recovered contacts may begin.

use crate::Unknown;
use crate::contact_fit::Contacts;
use frettrace_forward::accelerations::Quantity;
use frettrace_friction::effects::{Hook, ModifiedLaw};
use frettrace_identify::Parameter;

/// Starts all about a law.
const ABOUT: usize = 24;
/// Shares of viscous friction in these.
const VISCOUS: [f64; 4] = [0.0, 0.1, 0.3, 1.0];

/// Other starts of a law: Stribeck velocities, breakaways and dampings of other sizes. Friction coefficient, stiffness and velocities are
/// those that the recovered contacts show: a law that ended poorly may have any.
pub(crate) fn starts(
    law: &ModifiedLaw<f64>,
    velocity: f64,
    (recovered, rigid): (&Contacts, bool),
) -> Vec<ModifiedLaw<f64>> {
    let own = [Hook::MuKinetic, Hook::Sigma0].map(|hook| law.get(hook).unwrap_or(0.3));
    let [mu, sigma0] = recovered.sizes().unwrap_or(own);
    let mut law = *law;
    law.set(Hook::MuKinetic, mu);
    if !rigid {
        law.set(Hook::Sigma0, sigma0);
    }
    beside(&law, velocity)
}

/// Starts beside a law whose friction coefficient and stiffness are right in size.
pub(crate) fn beside(law: &ModifiedLaw<f64>, velocity: f64) -> Vec<ModifiedLaw<f64>> {
    let mu = law.get(Hook::MuKinetic).unwrap_or(0.3);
    let mut out = Vec::new();
    for speed in [0.1, 0.4] {
        for breakaway in [0.15, 0.6] {
            let mut other = *law;
            let sizes = [
                (Hook::StribeckVelocity, speed * velocity),
                (Hook::DampingVelocity, speed * velocity),
                (Hook::StribeckRise, 0.3 * mu),
                (Hook::StribeckExponent, 1.5),
                (Hook::Sigma1, 0.05 * mu / velocity),
                (Hook::Viscous, 0.0),
                (Hook::Breakaway, breakaway),
            ];
            for (hook, value) in sizes {
                if law.get(hook).is_some() {
                    other.set(hook, value);
                }
            }
            if law.get(Hook::Breakaway).is_some() || breakaway < 0.5 {
                out.push(other);
            }
        }
    }
    out
}

/// Starts all about a law, in the coordinates of its free values: wide for velocities and dampings, narrow for what a loop shows; each
/// with another share of viscous friction, the full one being that of the whole friction at the largest velocity.
pub(crate) fn scattered(
    centre: &ModifiedLaw<f64>,
    free: &[Unknown],
    (preload, velocity): (f64, f64),
) -> Vec<ModifiedLaw<f64>> {
    let (hooks, parameters): (Vec<Hook>, Vec<Parameter>) = free
        .iter()
        .filter_map(|u| match u.quantity {
            Quantity::Law(hook) => Some((hook, u.parameter.clone())),
            _ => None,
        })
        .unzip();
    let spread = |hook: &Hook| match hook {
        Hook::Sigma0 => 0.3,
        Hook::MuKinetic | Hook::StribeckExponent => 0.7,
        Hook::Breakaway => 1.0,
        Hook::Viscous => 0.0,
        _ => 2.0,
    };
    let values: Vec<f64> = hooks.iter().map(|&hook| centre.get(hook).unwrap_or_default()).collect();
    let spread: Vec<f64> = hooks.iter().map(spread).collect();
    let full = centre.get(Hook::MuKinetic).unwrap_or_default() * preload / velocity;
    let law = |(values, share): (Vec<f64>, &f64)| {
        let mut law = *centre;
        hooks.iter().zip(values).for_each(|(&hook, value)| law.set(hook, value));
        if hooks.contains(&Hook::Viscous) {
            law.set(Hook::Viscous, share * full);
        }
        law
    };
    let about = frettrace_identify::starts(&parameters, &values, &spread, ABOUT);
    about.into_iter().zip(VISCOUS.iter().cycle()).map(law).collect()
}
