//! A step without reversal of a bristle with linear saturation, in plain numbers: what alternating frequency-time asks for most.
//!
//! The formulas are those of [`super::flow`]; here they are short enough to be inlined into the loop over the samples, where what
//! does not change from sample to sample is taken out of it.

use super::flow::Relaxation;
use super::{Bristle, Saturation, Steady};
use crate::decay::{self, decay};
use crate::lift::positive_part;
use crate::{Scalar, Step};

/// Deflection \[m\] and force \[N\] after the step; `None` where the general step is needed.
#[inline(always)]
pub(super) fn step<T: Scalar>(law: &Bristle<T>, z: f64, step: &Step<T>) -> Option<(f64, f64)> {
    let power = law.saturation == Saturation::Power && law.exponent.re() == 1.0;
    let reversal = step.velocity[0].re() * step.velocity[1].re() < 0.0;
    if T::NDERIV > 0 || reversal || !(power || law.saturation == Saturation::Linear) {
        return None;
    }
    match law.steady {
        Steady::Constant if law.mu_k.re() > 0.0 && law.sigma1.re() == 0.0 => Some(constant(law, z, step)),
        Steady::Stribeck if law.mu_s.re() > 0.0 && law.mu_k.re() > 0.0 => {
            let delta = law.delta.re();
            if delta == 2.0 {
                stribeck(law, z, step, |ratio| ratio * ratio)
            } else if delta == 1.0 {
                stribeck(law, z, step, |ratio| ratio)
            } else {
                stribeck(law, z, step, |ratio| decay::power(ratio, delta))
            }
        }
        _ => None,
    }
}

#[inline(always)]
fn constant<T: Scalar>(law: &Bristle<T>, z: f64, step: &Step<T>) -> (f64, f64) {
    let (sigma0, mu) = (law.sigma0.re(), law.mu_k.re());
    let travel = step.slip[1].re() - step.slip[0].re();
    let limit = (mu * sigma0.recip()).copysign(travel);
    let z = limit + (z - limit) * decay(travel.abs() * (sigma0 * mu.recip()));
    let normal = positive_part(step.normal[1].re());
    (z, normal * sigma0 * z + law.sigma2.re() * step.velocity[1].re())
}

/// `power` is `(|v|/v_s)^δ` of `|v|/v_s`.
#[inline(always)]
fn stribeck<T: Scalar>(
    law: &Bristle<T>,
    z: f64,
    step: &Step<T>,
    power: impl Fn(f64) -> f64,
) -> Option<(f64, f64)> {
    let (v0, v2) = (step.velocity[0].re(), step.velocity[1].re());
    let (sigma0, mu_k) = (law.sigma0.re(), law.mu_k.re());
    let travel = step.slip[1].re() - step.slip[0].re();
    let v1 = travel * (1.5 / step.dt) - (v0 + v2) * 0.25;
    let sense = if travel == 0.0 { v0 + v2 } else { travel };
    let (slowness, excess) = (law.v_s.re().recip(), law.mu_s.re() - mu_k);
    // Written out: `map` over an array is not always inlined.
    let steady = |v: f64| mu_k + excess * decay(power(v.abs() * slowness));
    let mu = [steady(v0), steady(v1), steady(v2)];
    let scale = sigma0.copysign(sense);
    let pace = scale * step.dt;
    let relaxation = Relaxation::new([v0 * pace, v1 * pace, v2 * pace], mu);
    // No path, or velocities that contradict it.
    if relaxation.whole <= 0.0 {
        return None;
    }
    let (value, _) = relaxation.linear(z * scale, mu);
    let z = value * sigma0.recip().copysign(sense);
    let fading = v2 * law.v_d.re().recip();
    let rate = v2 - v2.abs() * (z * sigma0) * relaxation.inverses[2];
    let damping = law.sigma1.re() * decay(fading * fading) * rate;
    let normal = positive_part(step.normal[1].re());
    Some((z, normal * (sigma0 * z + damping) + law.sigma2.re() * v2))
}
