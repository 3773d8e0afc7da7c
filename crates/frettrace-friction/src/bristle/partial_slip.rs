//! Partial slip of the hybrid law: elastic up to `r = b`, then `dp/dτ = U (1 − α(r) r)` along a stroke.

use std::f64::consts::{FRAC_1_PI, PI};

use crate::Scalar;
use crate::lift::{in_pairs, lift};

/// Relaxation lengths after which a bristle has forgotten: exp(−20) = 2e-9 of what it was off by.
const FORGOTTEN: f64 = 20.0;
/// Relaxation lengths of a stroke that are followed at most: whatever μ does, exp(−30) = 9e-14 of its beginning is left.
const FAR: f64 = 30.0;
/// Relaxation lengths before the end at which a stroke that forgets is started from its quasi-static loading, which is off
/// by a second power of the change of μ in one of them, and …
const SETTLED: f64 = 14.0;
/// … the Runge-Kutta step there, in the same lengths.
const SETTLED_STRIDE: f64 = 0.4;
/// Relaxation lengths in one Runge-Kutta step of the partial-slip zone: 0.15⁵/120 = 6e-7 of what relaxes in it is lost.
const STRIDE: f64 = 0.15;

/// `μ(τ) = start + τ (lean + bend (τ − 1))`.
#[derive(Clone, Copy)]
pub(super) struct Parabola<T> {
    pub start: T,
    pub lean: T,
    pub bend: T,
}

impl<T: Scalar> Parabola<T> {
    /// The parabola through the three values, the second one at the share `middle` of the travel. Slip and velocities of a guess
    /// may contradict each other: where it would leave half the smallest to twice the largest, it is put into the middle, and
    /// where that is not enough, a straight line remains.
    #[inline(always)]
    pub fn new(mu: [T; 3], middle: T) -> Self {
        let lean = mu[2] - mu[0];
        let through = |middle: T| {
            let bend = (mu[1] - mu[0] - middle * lean) / (middle * (middle - 1.0));
            Self { start: mu[0], lean, bend }
        };
        let [first, second, third] = mu.map(|m| m.re());
        let range = 0.5 * first.min(second).min(third)..=2.0 * first.max(second).max(third);
        let within = |parabola: &Self| {
            let vertex = 0.5 * (1.0 - parabola.lean.re() / parabola.bend.re());
            !(vertex > 0.0 && vertex < 1.0) || range.contains(&parabola.real_at(vertex))
        };
        let plain = through(middle);
        if within(&plain) {
            return plain;
        }
        let centred = through(T::from(0.5));
        if within(&centred) { centred } else { Self { bend: T::from(0.0), ..plain } }
    }

    #[inline(always)]
    pub fn at(&self, tau: T) -> T {
        self.start + tau * (self.lean + self.bend * (tau - 1.0))
    }

    #[inline(always)]
    pub fn real_at(&self, tau: f64) -> f64 {
        self.start.re() + tau * (self.lean.re() + self.bend.re() * (tau - 1.0))
    }

    #[inline(always)]
    pub fn real_slope_at(&self, tau: f64) -> f64 {
        self.lean.re() + self.bend.re() * (2.0 * tau - 1.0)
    }
}

/// Runge-Kutta of order four from the fraction `tau` of the travel to its end, in steps that follow the local rate.
/// Arguments: `p`, `U`, `τ`, the parabola of μ (start, lean, bend) and `b`.
///
/// Where the stroke is long enough to forget where it began, it starts from the quasi-static loading shortly before the end.
pub(super) fn partial_slip<D: Scalar>(arguments: [D; 7]) -> D {
    let [mut loading, push, mut tau, start, lean, bend, breakaway] = arguments;
    let mu = Parabola { start, lean, bend };
    let inverse_zone = (-breakaway + 1.0).recip();
    // Motion of a guess that is far off may be of any length; only its end is remembered.
    let left = push.re() * (1.0 - tau.re()) / mu.real_at(tau.re()).max(mu.real_at(1.0));
    if left > FAR {
        tau = D::from(1.0 - FAR / left * (1.0 - tau.re()));
        loading = mu.at(tau);
    }
    let rate = |loading: D, inverse_mu: D| rate([push, loading, inverse_mu, inverse_zone]);
    let mut longer = 1.0;
    if let Some((from, ratio)) = quasi_static(&mu, push.re(), breakaway.re(), (tau.re(), loading.re())) {
        tau = D::from(from);
        loading = mu.at(tau) * ratio;
        longer = SETTLED_STRIDE / STRIDE;
    }
    let inverse_push = push.re().recip();
    let mut inverse = mu.at(tau).recip();
    while tau.re() < 1.0 {
        let r = loading.re() * inverse.re();
        // A relaxation length in shares of the travel.
        let length = mu.real_at(tau.re()) * inverse_push;
        // μ rises fastest at one of the two ends of the step.
        let ahead = (tau.re() + STRIDE * length).min(1.0);
        let rise = mu.real_slope_at(tau.re()).max(mu.real_slope_at(ahead)) * inverse_push;
        let stride = longer * stride(rise.max(0.0), r, inverse_zone.re()) * length;
        let last = tau.re() + stride >= 1.0;
        let step = if last { -tau + 1.0 } else { D::from(stride) };
        let half = mu.at(tau + step * 0.5).recip();
        tau = if last { D::from(1.0) } else { tau + stride };
        let end = mu.at(tau).recip();
        let k1 = rate(loading, inverse);
        let k2 = rate(loading + step * k1 * 0.5, half);
        let k3 = rate(loading + step * k2 * 0.5, half);
        let k4 = rate(loading + step * k3, end);
        loading += step * (k1 + (k2 + k3) * 2.0 + k4) * (1.0 / 6.0);
        inverse = end;
    }
    loading
}

/// Where a stroke that forgets its beginning may start, and the quasi-static `r` there; `None` where it does not forget.
///
/// Around the quasi-static state, `1 − s(r) = μ′/U`, a difference shrinks by `e^{−λX}`, `λ = −d(1 − s)/dr ≥ 1`. From below it is
/// reached at least so fast once the zone `1 − b` is crossed; from above it first falls to `r = 1` at the rate 1 and then by
/// `m = μ′/U` in each relaxation length.
fn quasi_static<T: Scalar>(
    mu: &Parabola<T>,
    push: f64,
    breakaway: f64,
    (tau, loading): (f64, f64),
) -> Option<(f64, f64)> {
    let (here, end) = (mu.real_at(tau), mu.real_at(1.0));
    let left = push * (1.0 - tau) / here.max(end);
    let zone = 1.0 - breakaway;
    if left * (1.0 + 0.5 * PI / zone) < FORGOTTEN {
        return None;
    }
    let at = |tau: f64| slow(mu.real_slope_at(tau) / push, zone);
    let ((first, slow_here), (_, slow_end)) = (at(tau)?, at(1.0)?);
    let contraction = slow_here.min(slow_end);
    let r = loading / here;
    let reach = if r <= first {
        2.0 * zone
    } else if contraction > 1.0 {
        let m = (mu.real_slope_at(tau).min(mu.real_slope_at(1.0)) / push).max(f64::MIN_POSITIVE);
        5.0 * zone / m.sqrt() + (1.0 + (r - 1.0).max(0.0) / m).ln()
    } else {
        0.0
    };
    if (left - reach) * contraction < FORGOTTEN {
        return None;
    }
    let from = 1.0 - SETTLED * end / (push * contraction);
    if from <= tau { None } else { at(from).map(|(ratio, _)| (from, ratio)) }
}

/// The root of `1 − s(r) = m` and `λ` there; `None` where μ changes too fast for a quasi-static state.
fn slow(m: f64, zone: f64) -> Option<(f64, f64)> {
    if m <= 0.0 {
        return (m > -0.5).then_some((1.0 - m, 1.0));
    }
    if m > 0.5 {
        return None;
    }
    let mut x = m.sqrt() * 2.0 * FRAC_1_PI;
    let mut slope = zone;
    for _ in 0..5 {
        let (sine, cosine) = (0.5 * PI * x).sin_cos();
        let square = cosine * cosine;
        slope = PI * sine * cosine * (1.0 - zone * x) + zone * square;
        x = (x - (1.0 - square * (1.0 - zone * x) - m) / slope).clamp(0.0, 0.6);
    }
    Some((1.0 - zone * x, slope / zone))
}

/// Length of a Runge-Kutta step: [`STRIDE`] divided by a bound of the local slope of `1 − s`. Where `r` may fall through 1
/// within a step, by the relative change `rise` of μ in a relaxation length, the bound is that of the quasi-static state.
#[inline(always)]
fn stride(rise: f64, r: f64, inverse_zone: f64) -> f64 {
    let settled = if r < 1.0 + 2.0 * STRIDE * rise { rise.sqrt() * 2.0 * FRAC_1_PI } else { 0.0 };
    let depth = ((1.0 - r) * inverse_zone).max(settled).clamp(0.0, FRAC_1_PI);
    STRIDE / (1.0 + 0.5 * PI * PI * depth * inverse_zone)
}

/// `1 − α(r) r` with `α = cos²(π ρ / 2)`, `ρ = (1 − r)/(1 − b)` clipped to 0 … 1.
#[inline(always)]
pub fn breakaway_share<D: Scalar>(r: D, breakaway: D) -> D {
    rate([D::from(1.0), r, D::from(1.0), (-breakaway + 1.0).recip()])
}

/// `U (1 − α(r) r)` of `U`, `p`, `1/μ` and `1/(1 − b)`; `r = p/μ`.
#[inline(always)]
fn rate<D: Scalar>(arguments: [D; 4]) -> D {
    let [push, loading, inverse_mu, inverse_zone] = arguments.map(|argument| argument.re());
    let share = PartialShare::at(loading * inverse_mu, inverse_zone);
    let value = push * share.value();
    if D::NDERIV == 0 {
        return D::from(value);
    }
    let [by_r, by_zone] = share.slopes();
    let pushed = push * by_r;
    lift(value, [share.value(), pushed * inverse_mu, pushed * loading, push * by_zone], arguments)
}

/// `1 − α r = u + r sin²(π ρ / 2)`, `u = 1 − r`, `ρ = u/(1 − b)`.
struct PartialShare {
    r: f64,
    inverse_zone: f64,
    /// `ρ`, unclipped.
    rho: f64,
}

impl PartialShare {
    #[inline(always)]
    fn at(r: f64, inverse_zone: f64) -> Self {
        Self { r, inverse_zone, rho: (1.0 - r) * inverse_zone }
    }

    #[inline(always)]
    fn value(&self) -> f64 {
        if self.rho >= 1.0 {
            1.0
        } else if self.rho <= 0.0 {
            1.0 - self.r
        } else {
            1.0 - self.r + self.r * sine_square(self.rho)
        }
    }

    /// Derivatives by `r` and by `1/(1 − b)`.
    #[inline(always)]
    fn slopes(&self) -> [f64; 2] {
        if self.rho >= 1.0 {
            [0.0; 2]
        } else if self.rho <= 0.0 {
            [-1.0, 0.0]
        } else {
            let (sine, along) = (sine_square(self.rho), self.r * sine_square_slope(self.rho));
            [sine - 1.0 - along * self.inverse_zone, along * (1.0 - self.r)]
        }
    }
}

/// `sin²(π ρ / 2) = (1 + sin(π(ρ − ½)))/2` of `ρ` between 0 and 1. Taylor's series up to the 15th power of
/// `|y| ≤ π/2`; what is cut off is below `(π/2)¹⁷/17! = 6e-12`.
#[inline(always)]
fn sine_square(rho: f64) -> f64 {
    const SINE: [f64; 8] = [
        1.0,
        -1.0 / 6.0,
        1.0 / 120.0,
        -1.0 / 5_040.0,
        1.0 / 362_880.0,
        -1.0 / 39_916_800.0,
        1.0 / 6_227_020_800.0,
        -1.0 / 1_307_674_368_000.0,
    ];
    let y = (rho - 0.5) * PI;
    y * in_pairs(&SINE, y * y) * 0.5 + 0.5
}

/// Its derivative `½ π cos(π(ρ − ½))`, up to the 16th power; what is cut off is below `(π/2)¹⁸/18! = 5e-13`.
#[inline(always)]
fn sine_square_slope(rho: f64) -> f64 {
    const COSINE: [f64; 8] = [
        -1.0 / 2.0,
        1.0 / 24.0,
        -1.0 / 720.0,
        1.0 / 40_320.0,
        -1.0 / 3_628_800.0,
        1.0 / 479_001_600.0,
        -1.0 / 87_178_291_200.0,
        1.0 / 20_922_789_888_000.0,
    ];
    let y = (rho - 0.5) * PI;
    let square = y * y;
    0.5 * PI * (1.0 + square * in_pairs(&COSINE, square))
}

#[cfg(test)]
mod tests {
    use super::{Parabola, breakaway_share, partial_slip, sine_square, sine_square_slope};
    use std::f64::consts::PI;

    /// The series are `sin²(πρ/2)` and its derivative `½π sin(πρ)`.
    #[test]
    fn series_are_the_square_of_a_sine_and_its_slope() {
        for k in 0..=100 {
            let rho = 0.01 * f64::from(k);
            assert!((sine_square(rho) - (0.5 * PI * rho).sin().powi(2)).abs() < 6e-12, "{rho}");
            assert!((sine_square_slope(rho) - 0.5 * PI * (PI * rho).sin()).abs() < 1e-12, "{rho}");
        }
    }

    /// Runge-Kutta in steps of a thirtieth of the shortest relaxation.
    fn fine([p, push, tau, start, lean, bend, b]: [f64; 7]) -> f64 {
        let mu = Parabola { start, lean, bend };
        let steps = (30.0 * push * (1.0 - tau) / start * (1.0 + 1.6 / (1.0 - b))).ceil();
        let h = (1.0 - tau) / steps;
        let rate = |p: f64, t: f64| push * breakaway_share(p / mu.at(t), b);
        let mut p = p;
        for n in 0..steps as usize {
            let t = tau + h * n as f64;
            let k1 = rate(p, t);
            let k2 = rate(p + 0.5 * h * k1, t + 0.5 * h);
            let k3 = rate(p + 0.5 * h * k2, t + 0.5 * h);
            let k4 = rate(p + h * k3, t + h);
            p += h * (k1 + 2.0 * (k2 + k3) + k4) / 6.0;
        }
        p
    }

    /// Values that no velocity can have at the stated share of the travel: straight through them the parabola would reach
    /// 1.46, −0.31, −0.20 and below −0.5; the last one leaves its range from the middle too (−0.04).
    #[test]
    fn a_parabola_stays_between_its_values() {
        for (mu, middle) in [
            ([0.1, 0.55, 0.56], 0.1),
            ([0.5, 0.1, 0.4], 0.15),
            ([0.56, 0.31, 0.3], 0.1),
            ([0.3, 0.001, 0.0005], 0.1),
        ] {
            let parabola = Parabola::new(mu, middle);
            let [least, most] =
                [mu.iter().fold(1.0, |m: f64, x| m.min(*x)), mu.iter().fold(0.0, |m: f64, x| m.max(*x))];
            assert!((parabola.real_at(0.0) - mu[0]).abs() + (parabola.real_at(1.0) - mu[2]).abs() < 1e-15);
            for k in 0..=100 {
                let value = parabola.real_at(0.01 * f64::from(k));
                assert!((0.5 * least..=2.0 * most).contains(&value), "{mu:?} {middle}: {value}");
            }
        }
    }

    /// Short and long strokes, narrow and wide zones, μ that rises, falls and bends by up to an eighth of itself in a
    /// relaxation length, from below and from above. Steps of 0.15 of a relaxation are good to 0.15⁵/120 of what relaxes in
    /// each; passing the corner at `r = 1` into a narrow zone costs the most.
    #[test]
    fn agrees_with_small_steps() {
        for push in [0.05_f64, 1.0, 8.0, 40.0] {
            for b in [0.1, 0.6, 0.95, 0.995] {
                for (lean, bend) in [(0.0, 0.0), (0.03, 0.0), (-0.03, 0.01), (0.01, -0.05)] {
                    for loading in [b, 0.5 * (1.0 + b), 1.0, 1.2] {
                        let change = push.min(1.0);
                        let arguments = [0.4 * loading, push, 0.1, 0.4, lean * change, bend * change, b];
                        let (found, reference) = (partial_slip(arguments), fine(arguments));
                        assert!(
                            (found - reference).abs() < 5e-6 * 0.4,
                            "{arguments:?}: {found} {reference} {:.1e}",
                            found - reference
                        );
                    }
                }
            }
        }
    }
}
