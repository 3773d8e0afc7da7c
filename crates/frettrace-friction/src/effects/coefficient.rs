//! The friction coefficient of the modified law at one end of a stretch.

use super::hooks::Hook;
use super::kernel::decay_mean;
use super::modified::{Circumstance, End, ModifiedLaw};
use crate::bristle::{stribeck, stribeck_power};
use crate::decay::decay;
use crate::law::Scalar;
use crate::lift::lift;

/// Smallest share of the sliding coefficient that a modification may leave: a law whose forces carry no normal force has it in
/// newtons, of any size.
const LEAST_FRICTION: f64 = 1e-6;

/// `value/(1 + x^p)^{1/p}`, `x ≥ 0`.
pub(super) fn ended<T: Scalar>(value: T, x: T, power: T) -> T {
    let grown = (power * (x + 1e-9).ln()).exp();
    value * (-(grown.ln_1p() / power)).exp()
}

/// `(1 + b y)₊^{−1/b}`, `y ≥ 0`, also for `b → 0`, where it is `e^{−y}`: up to `b y = 10⁻⁴` by the series of `ln(1 + b y)/b`, whose next term is
/// `b³y⁴/4`.
fn bent<T: Scalar>(y: T, bend: T) -> T {
    let grown = y * bend;
    if grown.re() <= -1.0 {
        return T::from(0.0);
    }
    let falls = if grown.re().abs() < 1e-4 {
        y * (grown * grown / 3.0 - grown * 0.5 + 1.0)
    } else {
        grown.ln_1p() / bend
    };
    (-falls).exp()
}

impl<T: Scalar> ModifiedLaw<T> {
    /// Stribeck weight `w(x)`, `x = |v|/v_s`: 1 at rest, 0 at speed; `exp(−x^δ)`, of which a share may be `1/(1 + x^δ)`, or Tsallis' exponential of
    /// `−x^δ`, which has both and curves that end.
    pub(super) fn weight(&self, speed: T) -> T {
        let stated = self.on(Hook::StribeckExponent);
        let delta = if stated { self.at(Hook::StribeckExponent) } else { T::from(2.0) };
        let velocity = self.at(Hook::StribeckVelocity);
        if self.on(Hook::StribeckBend) {
            let power = (delta * (speed / velocity + 1e-9).ln()).exp();
            return bent(power, self.at(Hook::StribeckBend) - 1.0);
        }
        if !self.on(Hook::RationalShare) {
            return stribeck(speed, [T::from(1.0), T::from(0.0), velocity, delta]);
        }
        let share = self.at(Hook::RationalShare);
        let x = speed.re() / velocity.re() + 1e-9;
        let power = stribeck_power(x, delta.re());
        let (fading, rational) = (decay(power), (power + 1.0).recip());
        let value = fading + (rational - fading) * share.re();
        if T::NDERIV == 0 {
            return T::from(value);
        }
        let slope = -fading + (fading - rational * rational) * share.re();
        let by_speed = slope * power * delta.re() / x / velocity.re();
        let partials =
            [by_speed, -by_speed * speed.re() / velocity.re(), slope * power * x.ln(), rational - fading];
        lift(value, partials, [speed, velocity, delta, share])
    }

    /// Film thickness that belongs to a steady speed, `min(x, 1)^{2/3}` with `x = |v|/v_b`, or `1 − exp(−x^p)`, of which a share may be
    /// `x^p/(1 + x^p)`.
    pub(super) fn steady_film(&self, speed: T) -> T {
        let x = speed / self.at(Hook::FilmVelocity) + 1e-9;
        if self.on(Hook::FilmExponent) {
            let power = (x.ln() * self.at(Hook::FilmExponent)).exp();
            let missing = (-power).exp();
            if !self.on(Hook::FilmRational) {
                return -missing + 1.0;
            }
            let rational = (power + 1.0).recip();
            return -(missing + (rational - missing) * self.at(Hook::FilmRational)) + 1.0;
        }
        if x.re() < 1.0 { (x.ln() * (2.0 / 3.0)).exp() } else { T::from(1.0) }
    }

    /// The friction coefficient at one end of a stretch that moves with the sign `sign`.
    pub(super) fn friction(&self, end: &End<T>, sign: f64, circumstance: &Circumstance) -> T {
        let mut mu = self.at(Hook::MuKinetic);
        if self.on(Hook::StribeckRise) {
            let weight = if self.on(Hook::LagTime) {
                self.behind(end, sign)
            } else if self.on(Hook::SpeedLag) || self.on(Hook::VelocityLag) {
                self.weight(self.behind(end, sign).abs())
            } else {
                self.weight(end.speed)
            };
            mu += self.at(Hook::StribeckRise) * weight;
        }
        if self.on(Hook::FilmLoss) {
            mu *= -(self.at(Hook::FilmLoss) * end.memory) + 1.0;
        } else if self.on(Hook::AgeingGain) {
            let age = end.memory / self.at(Hook::AgeingTime);
            let mut strength = age.ln_1p();
            if self.on(Hook::AgeingPower) {
                // ((1 + a)^p − 1)/p = l (e^y − 1)/y with y = p l, l = ln(1 + a).
                strength *= decay_mean(-(self.at(Hook::AgeingPower) * strength));
            }
            if self.on(Hook::AgeingSaturation) {
                let ending = -(-age).exp() + 1.0;
                strength += (ending - strength) * self.at(Hook::AgeingSaturation);
            }
            mu *= self.at(Hook::AgeingGain) * strength + 1.0;
        }
        if self.on(Hook::Asymmetry) {
            let mut turned = T::from(sign);
            if self.on(Hook::AsymmetryVelocity) {
                turned *= self.turned(end.speed / self.at(Hook::AsymmetryVelocity));
            }
            mu *= self.at(Hook::Asymmetry) * turned + 1.0;
        }
        mu *= self.place_factor(end.slip);
        if self.on(Hook::NormalExponent) && !self.on(Hook::NormalWhole) {
            mu *= self.normal_factor(end.normal, circumstance.preload);
        }
        if self.on(Hook::Wear) {
            let mut course = T::from(circumstance.progress);
            if self.on(Hook::WearWork) {
                let [before, after] = circumstance.worked;
                let own = if self.on(Hook::WearOwn) { self.at(Hook::WearOwn) } else { T::from(0.5) };
                let worked = own * (after - before) + before;
                course += self.at(Hook::WearWork) * (worked - circumstance.progress);
            }
            if self.on(Hook::WearExponent) && course.re() > 0.0 {
                course = (self.at(Hook::WearExponent) * course.ln()).exp();
            }
            if self.on(Hook::WearSettling) {
                let rate = self.at(Hook::WearSettling);
                course *= decay_mean(rate * course) / decay_mean(rate);
            }
            mu *= self.at(Hook::Wear) * course + 1.0;
        }
        let least = self.at(Hook::MuKinetic).re().abs() * LEAST_FRICTION + f64::MIN_POSITIVE;
        if mu.re() > least { mu } else { T::from(least) }
    }

    /// Turn-over of an asymmetry, `y/√(1 + y²)` or `y/(1 + |y|^p)^{1/p}`.
    pub(super) fn turned(&self, y: T) -> T {
        if self.on(Hook::AsymmetryPower) {
            ended(y, y.abs(), self.at(Hook::AsymmetryPower))
        } else {
            y / (y * y + 1.0).sqrt()
        }
    }

    /// What a lag sets at one end of a stretch.
    fn behind(&self, end: &End<T>, sign: f64) -> T {
        if !self.on(Hook::LagDelay) {
            return end.memory;
        }
        end.memory + self.at(Hook::LagDelay) * (end.memory - self.target(end.speed, sign))
    }

    /// `1 − n(x^q − 1)/q`, `q = s − n`, `x = N/N₀`, which is `x^{−n}` at `s = 0`; 1 where the contact is all but open.
    pub(super) fn normal_factor(&self, normal: T, preload: f64) -> T {
        let stated = self.on(Hook::NormalReference);
        let reference = if stated { self.at(Hook::NormalReference) } else { T::from(preload) };
        let ratio = normal / reference;
        if reference.re() <= 0.0 || ratio.re() <= 0.02 {
            return T::from(1.0);
        }
        let l = ratio.ln();
        let exponent = self.at(Hook::NormalExponent);
        if self.on(Hook::NormalPower) {
            let y = (self.at(Hook::NormalPower) - exponent) * l;
            return -(exponent * l * decay_mean(-y)) + 1.0;
        }
        (-(exponent * l)).exp()
    }

    fn place_factor(&self, slip: T) -> T {
        let mut factor = T::from(1.0);
        if self.on(Hook::Position) {
            let mut along = slip;
            if self.on(Hook::PositionScale) {
                let x = slip / self.at(Hook::PositionScale);
                along = if self.on(Hook::PositionPower) {
                    ended(slip, x.abs(), self.at(Hook::PositionPower))
                } else {
                    slip / (x * x + 1.0).sqrt()
                };
            }
            factor += self.at(Hook::Position) * along;
        }
        if self.on(Hook::PositionSquare) {
            factor += self.at(Hook::PositionSquare) * slip * slip;
        }
        if self.on(Hook::PositionCube) {
            factor += self.at(Hook::PositionCube) * slip * slip * slip;
        }
        if self.on(Hook::PeriodicNumber) {
            let (sine, cosine) = (self.at(Hook::PeriodicNumber) * slip).sin_cos();
            let [along, across] = [Hook::PeriodicCosine, Hook::PeriodicSine].map(|hook| self.at(hook));
            let mut wave = along * cosine + across * sine;
            let size = (along * along + across * across).sqrt();
            if self.on(Hook::PeriodicSharpness) && size.re() > 0.0 {
                let sharpness = self.at(Hook::PeriodicSharpness);
                wave = size * (sharpness * wave / size).asin() / sharpness.asin();
            }
            if self.on(Hook::PeriodicSteepness) && size.re() > 0.0 {
                let steepness = self.at(Hook::PeriodicSteepness);
                let corner =
                    if self.on(Hook::PeriodicCorner) { self.at(Hook::PeriodicCorner) } else { T::from(2.0) };
                let level = |x: T| ended(x, x.abs(), corner);
                wave = size * level(steepness * wave / size) / level(steepness);
            }
            factor += wave;
            if self.on(Hook::PeriodicSine2) {
                let (sine2, cosine2) = (sine * cosine * 2.0, cosine * cosine * 2.0 - 1.0);
                let (sine3, cosine3) = (sine2 * cosine + cosine2 * sine, cosine2 * cosine - sine2 * sine);
                factor += self.at(Hook::PeriodicCosine2) * cosine2 + self.at(Hook::PeriodicSine2) * sine2;
                factor += self.at(Hook::PeriodicCosine3) * cosine3 + self.at(Hook::PeriodicSine3) * sine3;
            }
        }
        factor
    }

    /// Whether the friction force depends on where the contact is, and not only on how it moves: a coefficient that depends on the
    /// place on the path, or a bristle that is elastic up to its breakaway and keeps what it came to from rest, `σ₀` times the mean
    /// slip, which a modulated preload turns into a force on the modulation's line.
    #[must_use]
    pub fn depends_on_place(&self) -> bool {
        let along = [Hook::Position, Hook::PositionSquare, Hook::PositionCube, Hook::PeriodicNumber];
        let keeps = self.on(Hook::Breakaway) && self.on(Hook::ModulationCosine);
        keeps || along.into_iter().any(|hook| self.on(hook))
    }

    /// Whether the friction coefficient changes along a stretch.
    pub(super) fn varies(&self) -> bool {
        [Hook::StribeckRise, Hook::FilmLoss, Hook::AgeingGain, Hook::Position, Hook::PositionSquare]
            .into_iter()
            .chain([Hook::AsymmetryVelocity, Hook::PositionCube, Hook::PeriodicNumber, Hook::NormalExponent])
            .any(|hook| self.on(hook))
    }
}
