//! One monotone stretch of the state equation `db/du = σ0·φ(r)`, `b = σ0·z`, `r = b·sgn(v)/μ`.

use crate::law::Scalar;
use crate::lift::{in_pairs, lift, positive_part};

/// `(1 − e^{−x})/x`, also for `x → 0`.
pub(super) fn decay_mean<T: Scalar>(x: T) -> T {
    if x.re().abs() < 1e-4 {
        // Taylor series; the next term is x³/24 < 5e-14.
        x * x / 6.0 - x * 0.5 + 1.0
    } else {
        -(-x).exp_m1() / x
    }
}

/// `1 − e^{−x}`, and that over `x`: by Taylor's series below 1/16, which costs a quarter of an exponential; what is cut off is below
/// `16⁻⁸/9! = 7e-16`.
#[inline]
fn decayed(x: f64) -> (f64, f64) {
    const MEAN: [f64; 8] =
        [1.0, -1.0 / 2.0, 1.0 / 6.0, -1.0 / 24.0, 1.0 / 120.0, -1.0 / 720.0, 1.0 / 5_040.0, -1.0 / 40_320.0];
    if x.abs() < 0.0625 {
        let mean = in_pairs(&MEAN, x);
        (x * mean, mean)
    } else {
        let gone = -(-x).exp_m1();
        (gone, gone / x)
    }
}

/// Linear relaxation `db = (s·μ − b)·dE` while `μ` runs linearly in `E` from `mu[0]` to `mu(1)`:
/// `b₁ = e^{−E}b₀ + s[μ₁ − (μ₁ − μ₀)D − μ₀e^{−E}]`, `D = (1 − e^{−E})/E`, with `dD/dE = (e^{−E} − D)/E`.
pub(super) fn relax<T: Scalar>(b: T, sign: f64, mu: [T; 2], e: T) -> T {
    let (x, [from, to]) = (e.re(), [mu[0].re(), mu[1].re()]);
    let (gone, mean) = decayed(x);
    let kept = 1.0 - gone;
    let value = kept * b.re() + (to - (to - from) * mean - from * kept) * sign;
    if T::NDERIV == 0 {
        return T::from(value);
    }
    // Taylor series; the next term is x³/30 < 5e-14.
    let falls = if x.abs() < 1e-4 { -0.5 + x / 3.0 - 0.125 * x * x } else { (kept - mean) / x };
    let partials = [
        kept,
        (mean - kept) * sign,
        (1.0 - mean) * sign,
        -kept * b.re() + (from * kept - (to - from) * falls) * sign,
    ];
    lift(value, partials, [b, mu[0], mu[1], e])
}

/// Dahl's exponent form `dr = sgn(1−r)|1−r|^i dξ`, solved in closed form:
/// `|y₁|^{1−i} = |y₀|^{1−i} − (1−i)ξ`, `y = 1 − r`.
pub(super) fn power<T: Scalar>(ratio: T, exponent: T, xi: T) -> T {
    let y = -ratio + 1.0;
    let size = y.abs();
    if size.re() < 1e-12 {
        return ratio;
    }
    let one_less = -exponent + 1.0;
    let growth = xi * ((exponent - 1.0) * size.ln()).exp();
    let w = one_less * growth;
    if w.re() >= 1.0 - 1e-9 {
        return T::from(1.0);
    }
    // −ln(1−w)/w, with its series near 0 (next term w⁵/6).
    let slope = if w.re().abs() < 1e-2 {
        let tail = (w * 0.2 + 0.25) * w + 1.0 / 3.0;
        (tail * w + 0.5) * w + 1.0
    } else {
        -(-w + 1.0).ln() / w
    };
    -(y * (-(growth * slope)).exp()) + 1.0
}

/// Rise `α(r)` of the hybrid law: 0 up to `breakaway`, half a sine up to 1 at `r = 1`; a share `straight` of it along a
/// straight line instead (negative: steeper in the middle).
pub(super) fn rise<T: Scalar>(ratio: T, breakaway: T, straight: T) -> T {
    if ratio.re() <= breakaway.re() {
        T::from(0.0)
    } else if ratio.re() >= 1.0 {
        T::from(1.0)
    } else {
        let place = (ratio - breakaway) / (-breakaway + 1.0);
        let curved = ((place - 0.5) * std::f64::consts::PI).sin() * 0.5 + 0.5;
        curved + (place - curved) * straight
    }
}

/// The classical Runge-Kutta rule: so many steps of the size `h` along a flow.
fn runge_kutta<T: Scalar>(mut value: T, (h, count): (T, f64), flow: impl Fn(T) -> T) -> T {
    for _ in 0..count as usize {
        let k1 = flow(value);
        let k2 = flow(value + k1 * h * 0.5);
        let k3 = flow(value + k2 * h * 0.5);
        let k4 = flow(value + k3 * h);
        value += (k1 + (k2 + k3) * 2.0 + k4) * h / 6.0;
    }
    value
}

/// Relaxations of the width of the rise of an elasto-plastic flow in which it is passed.
const PASSED: f64 = 4.0;

/// Elasto-plastic flow `dr = φ(r)dξ`, `φ = 1` up to the breakaway, by the classical Runge-Kutta rule in steps of at most a quarter, and of a
/// quarter of the rise where that is passed.
pub(super) fn elasto_plastic<T: Scalar>(
    mut ratio: T,
    (breakaway, flow): (T, impl Fn(T) -> T),
    mut xi: T,
) -> T {
    // Purely elastic up to the breakaway: that stretch is exact.
    let room = breakaway - ratio;
    if room.re() > 0.0 {
        if xi.re() <= room.re() {
            return ratio + xi;
        }
        ratio = breakaway;
        xi -= room;
    }
    let width = -breakaway + 1.0;
    let rising = width.re() * PASSED;
    if xi.re() > rising {
        let risen = bent(ratio, (&flow, 0.25 * width.re()), width * PASSED);
        return bent(risen, (&flow, 0.25), xi - width * PASSED);
    }
    bent(ratio, (&flow, 0.25 * width.re()), xi)
}

/// Flow `dr = φ(r)dξ` by the classical Runge-Kutta rule in steps of at most the given size.
pub(super) fn bent<T: Scalar>(ratio: T, (flow, step): (impl Fn(T) -> T, f64), xi: T) -> T {
    let count = (xi.re() / step).ceil().clamp(1.0, 64.0);
    runge_kutta(ratio, (xi / count, count), flow)
}

/// Play `y` that closes gradually, `dy = (1 − max(y, 0)ⁿ)dξ`: exact up to the middle, from there by the classical Runge-Kutta rule in
/// steps of at most a quarter and of `1/n`.
pub(super) fn closing<T: Scalar>(mut place: T, power: T, mut xi: T) -> T {
    if place.re() < 0.0 {
        if xi.re() <= -place.re() {
            return place + xi;
        }
        xi += place;
        place = T::from(0.0);
    }
    // Where it is closed to e⁻⁴⁰ it stays.
    let closed = 1.5 + 40.0 / power.re();
    if xi.re() > closed {
        xi = T::from(closed);
    }
    let count = (xi.re() * power.re().max(4.0)).ceil().max(1.0);
    let h = xi / count;
    let flow = |y: T| -taken(positive_part(y), power) + 1.0;
    runge_kutta(place, (h, count), flow)
}

/// Share of a motion that play hands on where it is closed as far as `place`, `max(y, 0)ⁿ`.
pub(super) fn taken<T: Scalar>(place: T, power: T) -> T {
    if place.re() <= 0.0 { T::from(0.0) } else { (place.ln() * power).exp() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Gradient;
    use num_dual::DualNum;

    /// `n = 1`: `y = 1 − e^{−ξ}` from the middle; `n = 2`: `y = tanh ξ`; before the middle `y = y₀ + ξ`. The rule's error with steps of
    /// a quarter is below 1e-4.
    #[test]
    fn play_closes_as_its_formula_says() {
        for xi in [0.05, 0.4, 1.3, 6.0, 200.0] {
            for (power, expected) in [(1.0, -f64::exp_m1(-xi)), (2.0, xi.tanh())] {
                for from in [0.0, -0.7] {
                    let found = closing(from, power, xi - from);
                    assert!((found - expected).abs() < 1e-4, "{power} {xi}: {found} against {expected}");
                }
            }
        }
        assert_eq!(closing(-0.7, 3.0, 0.5), -0.7 + 0.5);
    }

    /// The relaxation written out operation by operation, value and derivatives, on both sides of its series.
    #[test]
    fn relaxation_is_what_its_formula_says() {
        for x in [1e-9, 9e-5, 1.1e-4, 0.3, 4.0, 40.0] {
            let [b, from, to, e] = [0.2, 0.31, 0.45, x].map(Gradient::<4>::constant);
            let mut all = [b, from, to, e];
            all.iter_mut().enumerate().for_each(|(k, value)| value.slopes[k] = 1.0);
            let [b, from, to, e] = all;
            for sign in [-1.0, 1.0] {
                let kept = (-e).exp();
                let slow = kept * b + (to - (to - from) * decay_mean(e) - from * kept) * sign;
                let fast = relax(b, sign, [from, to], e);
                assert!((fast.re - slow.re).abs() < 1e-14, "{x}: {} {}", fast.re, slow.re);
                for (fast, slow) in fast.slopes.iter().zip(slow.slopes) {
                    // The slow way differentiates its series: x²/8 is missing there, 1e-9 at its border, times μ₁ − μ₀.
                    assert!((fast - slow).abs() < 2e-10, "{x}: {fast} {slow}");
                }
            }
        }
    }
}
