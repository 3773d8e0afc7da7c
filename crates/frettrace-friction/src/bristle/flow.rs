//! One stroke of a bristle: the loading `p = σ0 z sgn(v)` moves towards the friction coefficient μ.
//!
//! With the travel `U = σ0 |Δu|` and the fraction `τ` of it, `dp/dτ = U (1 − s(p/μ(τ)))`. μ is known at the start, the
//! middle and the end in time; between them it is the parabola through the three.

use super::partial_slip::{Parabola, partial_slip};
use crate::decay::decay;
use crate::lift::{lift, sign};
use crate::{Gradient, Scalar, Stroke};

/// Friction coefficient and travel along one stroke.
#[derive(Clone, Copy, Debug)]
pub struct Friction<T> {
    /// `σ0 |Δu|`.
    push: T,
    /// μ at the start, the middle and the end in time.
    mu: [T; 3],
    /// `σ0 |v|` at the same times, multiplied by the duration.
    pace: [T; 3],
}

/// Relaxation `dX = σ0 |du| / μ` along a stroke.
#[derive(Clone, Copy)]
pub(super) struct Relaxation {
    /// 1/μ at the start, the middle and the end in time.
    pub inverses: [f64; 3],
    /// Its rate at the same times, multiplied by the duration.
    f: [f64; 3],
    /// Length X, by Simpson's rule.
    pub whole: f64,
}

/// What a stroke of length X remembers, and the share of X at half time, before and after it is kept harmless.
pub(super) struct Path {
    memory: Memory,
    middle: f64,
    kappa: f64,
}

impl Relaxation {
    /// `pace` is `σ0 |v|` multiplied by the duration.
    #[inline(always)]
    pub fn new(pace: [f64; 3], mu: [f64; 3]) -> Self {
        let inverses = [mu[0].recip(), mu[1].recip(), mu[2].recip()];
        let f = [pace[0] * inverses[0], pace[1] * inverses[1], pace[2] * inverses[2]];
        Self { inverses, f, whole: (f[0] + f[1] * 4.0 + f[2]) * (1.0 / 6.0) }
    }

    /// The loading at the end of the stroke.
    #[inline(always)]
    pub fn linear(&self, loading: f64, mu: [f64; 3]) -> (f64, Path) {
        let memory = Memory::new(self.whole);
        let middle = (self.f[0] * 5.0 + self.f[1] * 8.0 - self.f[2]) * (1.0 / 24.0) * memory.inverse;
        let kappa = middle.clamp(MIDDLE.0, MIDDLE.1);
        let value = loading * (1.0 - memory.moments[0]) + memory.parabola(mu, kappa);
        (value, Path { memory, middle, kappa })
    }
}

/// Where the middle may lie between start and end: motion whose velocities contradict its slip is kept harmless.
pub(super) const MIDDLE: (f64, f64) = (0.1, 0.9);
impl<T: Scalar> Friction<T> {
    /// The stroke seen from a bristle of stiffness `sigma0`; `mu` at its start, middle and end.
    #[inline(always)]
    pub fn new(sigma0: T, stroke: &Stroke<T>, mu: [T; 3]) -> Self {
        let stiffness = sigma0 * stroke.direction;
        let scale = stiffness * stroke.duration;
        let pace = stroke.velocity.map(|velocity| velocity * scale);
        Self { push: stiffness * stroke.travel, mu, pace }
    }

    /// Friction coefficient that does not change along the stroke. For dual numbers this is never said, since equal
    /// values may have different derivatives.
    #[inline(always)]
    fn is_steady(&self) -> bool {
        T::NDERIV == 0 && self.mu[0].re() == self.mu[2].re() && self.mu[1].re() == self.mu[2].re()
    }

    /// `∫ σ0 |du| / μ` over the stroke, by Simpson's rule.
    #[inline(always)]
    fn relaxation(&self) -> T {
        let [f0, f1, f2] = [0, 1, 2].map(|index| self.pace[index] / self.mu[index]);
        (f0 + f1 * 4.0 + f2) * (1.0 / 6.0)
    }

    /// `dp/dX = μ(X) − p` with `dX = σ0 |du| / μ`, exact for a parabola μ(X); the length X of the stroke and of its first
    /// half come from parabolas in time.
    #[inline(always)]
    pub fn linear(&self, loading: T) -> T {
        if self.is_steady() {
            let mu = self.mu[0];
            return mu + (loading - mu) * decay((self.push / mu).re());
        }
        let (mu, pace) = (self.mu.map(|m| m.re()), self.pace.map(|f| f.re()));
        let relaxation = Relaxation::new(pace, mu);
        let Relaxation { inverses, f, whole } = relaxation;
        if whole <= 0.0 {
            return loading + self.push - loading * self.push / self.mu[1];
        }
        let (value, Path { memory, middle, kappa }) = relaxation.linear(loading.re(), mu);
        if T::NDERIV == 0 {
            return T::from(value);
        }
        let kept = 1.0 - memory.moments[0];
        let weights = memory.weights(kappa);
        let sum = |w: [f64; 3]| w[0] * mu[0] + w[1] * mu[1] + w[2] * mu[2];
        let by_kappa = if kappa == middle { sum(memory.weights_by_kappa(kappa)) / whole } else { 0.0 };
        let by_whole = sum(memory.slope().weights(kappa)) - loading.re() * kept - middle * by_kappa;
        let by_f = [
            by_whole * (1.0 / 6.0) + by_kappa * (5.0 / 24.0),
            by_whole * (4.0 / 6.0) + by_kappa * (8.0 / 24.0),
            by_whole * (1.0 / 6.0) - by_kappa * (1.0 / 24.0),
        ];
        let by_pace = [by_f[0] * inverses[0], by_f[1] * inverses[1], by_f[2] * inverses[2]];
        let by_mu = [0, 1, 2].map(|j| weights[j] - by_pace[j] * f[j]);
        let [[p0, p1, p2], [m0, m1, m2]] = [by_pace, by_mu];
        let [[f0, f1, f2], [n0, n1, n2]] = [self.pace, self.mu];
        lift(value, [kept, p0, p1, p2, m0, m1, m2], [loading, f0, f1, f2, n0, n1, n2])
    }

    /// `dr/dX = sgn(1 − r)|1 − r|^i` in closed form; a changing μ is followed to second order.
    #[inline(always)]
    pub fn power(&self, loading: T, exponent: T) -> T {
        if T::NDERIV == 0 && exponent.re() == 1.0 {
            return self.linear(loading);
        }
        if self.is_steady() {
            let mu = self.mu[0];
            return power_flow(loading / mu, self.push / mu, exponent) * mu;
        }
        let mean = (self.mu[0] + self.mu[2]) * 0.5;
        let whole = self.relaxation();
        let memory = Memory::new(whole.re().max(f64::MIN_POSITIVE));
        let lag = lift(memory.follow(), [memory.slope().follow()], [whole]);
        power_flow(loading / mean, whole, exponent) * mean + (self.mu[2] - self.mu[0]) * lag
    }

    /// Elastic up to `r = b`, then Runge-Kutta through the partial-slip zone.
    #[inline(always)]
    pub fn breakaway(&self, loading: T, breakaway: T) -> T {
        // A reversal just beside a sample leaves a stroke whose travel is a rounding error of either sign.
        if self.push.re() <= 0.0 {
            return loading + self.push;
        }
        let parabola = Parabola::new(self.mu, self.middle());
        let Some(start) = self.breakaway_point(loading, breakaway, &parabola) else {
            return loading + self.push;
        };
        let arguments = [
            loading + self.push * start,
            self.push,
            start,
            parabola.start,
            parabola.lean,
            parabola.bend,
            breakaway,
        ];
        if T::NDERIV == 0 {
            return T::from(partial_slip(arguments.map(|argument| argument.re())));
        }
        let seeds: [Gradient<7>; 7] =
            std::array::from_fn(|index| Gradient::variable(arguments[index].re(), index));
        let Gradient { re, slopes } = partial_slip(seeds);
        lift(re, slopes, arguments)
    }

    /// Share of the travel done at half time.
    #[inline(always)]
    fn middle(&self) -> T {
        if self.push.re() == 0.0 {
            return T::from(0.5);
        }
        let middle = (self.pace[0] - self.pace[2]) / self.push * 0.125 + 0.5;
        if middle.re() > MIDDLE.0 && middle.re() < MIDDLE.1 { middle } else { T::from(0.5) }
    }

    /// The fraction of travel where `p` reaches `b μ`; `None` where it does not.
    #[inline(always)]
    fn breakaway_point(&self, loading: T, breakaway: T, mu: &Parabola<T>) -> Option<T> {
        if loading.re() >= breakaway.re() * mu.start.re() {
            return Some(T::from(0.0));
        }
        let excess = |tau: f64| loading.re() + self.push.re() * tau - breakaway.re() * mu.real_at(tau);
        if excess(1.0) <= 0.0 {
            return None;
        }
        let slope = |tau: f64| self.push.re() - breakaway.re() * mu.real_slope_at(tau);
        let mut tau = excess(0.0) / (excess(0.0) - excess(1.0));
        for _ in 0..3 {
            tau = (tau - excess(tau) / slope(tau)).clamp(0.0, 1.0);
        }
        let residual = loading + self.push * tau - breakaway * mu.at(T::from(tau));
        Some(-(residual - residual.re()) / slope(tau) + tau)
    }
}

/// `sgn(1 − r)|1 − r|^i`.
#[inline(always)]
pub fn power_share<T: Scalar>(r: T, exponent: T) -> T {
    let (gap, i) = (1.0 - r.re(), exponent.re());
    if gap == 0.0 {
        return T::from(0.0);
    }
    if T::NDERIV == 0 && i == 1.0 {
        return -r + 1.0;
    }
    let value = gap.abs().powf(i) * sign(gap);
    lift(value, [-i * value / gap, value * gap.abs().ln()], [r, exponent])
}

/// `r` after the relaxation `x` by `dr/dx = sgn(1 − r)|1 − r|^i`: the gap shrinks by exp(−ln(1 + ε w)/ε) with
/// `ε = i − 1`, `w = x |1 − r|^ε`; for `ε < 0` it closes at a finite `x`.
#[inline(always)]
fn power_flow<T: Scalar>(r: T, x: T, exponent: T) -> T {
    let (gap, epsilon) = (1.0 - r.re(), exponent.re() - 1.0);
    if gap == 0.0 {
        return if epsilon >= 0.0 { r } else { T::from(1.0) };
    }
    let scale = if epsilon == 0.0 { 1.0 } else { gap.abs().powf(epsilon) };
    let (w, p) = (x.re() * scale, x.re() * scale * epsilon);
    if p <= -1.0 {
        return T::from(1.0);
    }
    let near = p.abs() < 1e-4;
    let ell = if near { w * (1.0 - p * (0.5 - p * (1.0 / 3.0 - p * 0.25))) } else { p.ln_1p() / epsilon };
    let after = gap * (-ell).exp();
    if T::NDERIV == 0 {
        return T::from(1.0 - after);
    }
    let bracket = if near {
        w * w * (-0.5 + p * (2.0 / 3.0 - p * (0.75 - p * 0.8)))
    } else {
        (p / (1.0 + p) - p.ln_1p()) / (epsilon * epsilon)
    };
    let by_exponent = after * (w * gap.abs().ln() / (1.0 + p) + bracket);
    let pace = after / (1.0 + p);
    lift(1.0 - after, [pace / gap, pace * scale, by_exponent], [r, x, exponent])
}

/// What an exponential memory of length `X` makes of the powers 1, s, s²: `∫₀¹ X exp(−X(1 − s)) sᵏ ds`.
#[derive(Clone, Copy)]
pub(super) struct Memory {
    /// `1/X`.
    inverse: f64,
    pub moments: [f64; 3],
}

/// From here on the recursion of [`Memory`] runs upwards.
pub(super) const LONG: f64 = 0.2;

impl Memory {
    /// By recursion, upwards where that is stable, else from the series of the third moment downwards.
    #[inline(always)]
    fn new(length: f64) -> Self {
        if length > LONG { Self::long(length) } else { Self::short(length) }
    }

    /// Not small: the difference from 1 loses nothing that matters.
    #[inline(always)]
    pub fn long(length: f64) -> Self {
        let inverse = length.recip();
        let zeroth = 1.0 - decay(length);
        let first = 1.0 - zeroth * inverse;
        Self { inverse, moments: [zeroth, first, 1.0 - 2.0 * first * inverse] }
    }

    #[inline(always)]
    pub fn short(length: f64) -> Self {
        let (x, inverse) = (length, length.recip());
        // 2 Σ (−x)ᵏ/(k + 3)!, in pairs, so that no term waits for the last one.
        let x2 = x * x;
        let low = (1.0 / 3.0 - x * (1.0 / 12.0)) + x2 * (1.0 / 60.0 - x * (1.0 / 360.0));
        let series = low + (x2 * x2) * ((1.0 / 2520.0 - x * (1.0 / 20160.0)) + x2 * (1.0 / 181440.0));
        let second = x * series;
        let first = 0.5 * x * (1.0 - second);
        Self { inverse, moments: [x * (1.0 - first), first, second] }
    }

    /// What is made of the parabola through the values at 0, `kappa`, 1: the sum of [`Self::weights`] times them.
    #[inline(always)]
    fn parabola(&self, values: [f64; 3], kappa: f64) -> f64 {
        let [zeroth, first, second] = self.moments;
        let lean = values[2] - values[0];
        let bend = (values[1] - values[0] - kappa * lean) / (kappa * (kappa - 1.0));
        values[0] * zeroth + lean * first + bend * (second - first)
    }

    /// Weights of the values at 0, `kappa`, 1 of the parabola through them.
    #[inline(always)]
    fn weights(&self, kappa: f64) -> [f64; 3] {
        let [zeroth, first, second] = self.moments;
        let rest = 1.0 - kappa;
        let inverse = (kappa * rest).recip();
        [
            (second - (1.0 + kappa) * first + kappa * zeroth) * (rest * inverse),
            (first - second) * inverse,
            (second - kappa * first) * (kappa * inverse),
        ]
    }

    /// The derivatives of the moments with the length, in the place of the moments.
    #[inline(always)]
    fn slope(&self) -> Self {
        let [zeroth, first, second] = self.moments;
        let inverse = self.inverse;
        let moments = [1.0 - zeroth, 1.0 - first * (1.0 + inverse), 1.0 - second * (1.0 + 2.0 * inverse)];
        Self { inverse, moments }
    }

    /// The derivatives of the weights with `kappa`.
    #[inline(always)]
    fn weights_by_kappa(&self, kappa: f64) -> [f64; 3] {
        let [_, first, second] = self.moments;
        let (bend, rest) = (first - second, 1.0 - kappa);
        [bend / (kappa * kappa), bend * (2.0 * kappa - 1.0) / (kappa * rest).powi(2), -bend / (rest * rest)]
    }

    /// How much of a linear change of the target is followed beyond its mean: `(1 + e^{-X})/2 − (1 − e^{-X})/X`.
    #[inline(always)]
    fn follow(&self) -> f64 {
        self.moments[1] - 0.5 * self.moments[0]
    }
}
