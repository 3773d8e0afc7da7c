//! One monotone stretch of the state equation `db/du = σ0·φ(r)`, `b = σ0·z`, `r = b·sgn(v)/μ`.

use crate::law::Scalar;

/// `(1 − e^{−x})/x`, also for `x → 0`.
pub(super) fn decay_mean<T: Scalar>(x: T) -> T {
    if x.re().abs() < 1e-4 {
        // Taylor series; the next term is x³/24 < 5e-14.
        x * x / 6.0 - x * 0.5 + 1.0
    } else {
        -(-x).exp_m1() / x
    }
}

/// Linear relaxation `db = (s·μ − b)·dE` while `μ` runs linearly in `E` from `mu[0]` to `mu(1)`:
/// `b₁ = e^{−E}b₀ + s[μ₁ − (μ₁ − μ₀)(1 − e^{−E})/E − μ₀e^{−E}]`.
pub(super) fn relax<T: Scalar>(b: T, sign: f64, mu: [T; 2], e: T) -> T {
    let kept = (-e).exp();
    kept * b + (mu[1] - (mu[1] - mu[0]) * decay_mean(e) - mu[0] * kept) * sign
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

/// Elasto-plastic flow `dr = (1 − α(r)·r)dξ` by the classical Runge-Kutta rule in steps of at most a quarter.
pub(super) fn elasto_plastic<T: Scalar>(mut ratio: T, (breakaway, straight): (T, T), mut xi: T) -> T {
    // Purely elastic up to the breakaway: that stretch is exact.
    let room = breakaway - ratio;
    if room.re() > 0.0 {
        if xi.re() <= room.re() {
            return ratio + xi;
        }
        ratio = breakaway;
        xi -= room;
    }
    let count = (xi.re() / 0.25).ceil().clamp(1.0, 64.0);
    let h = xi / count;
    let flow = |r: T| -(rise(r, breakaway, straight) * r) + 1.0;
    for _ in 0..count as usize {
        let k1 = flow(ratio);
        let k2 = flow(ratio + k1 * h * 0.5);
        let k3 = flow(ratio + k2 * h * 0.5);
        let k4 = flow(ratio + k3 * h);
        ratio += (k1 + (k2 + k3) * 2.0 + k4) * h / 6.0;
    }
    ratio
}

/// Flow `dr = (1 − r|r|^{n−1})dξ` by the classical Runge-Kutta rule in steps of at most a quarter.
pub(super) fn powered<T: Scalar>(mut ratio: T, exponent: T, xi: T) -> T {
    let count = (xi.re() / 0.25).ceil().clamp(1.0, 64.0);
    let h = xi / count;
    let flow = |r: T| {
        let size = r.abs() + 1e-12;
        let power = (size.ln() * exponent).exp();
        if r.re() < 0.0 { power + 1.0 } else { -power + 1.0 }
    };
    for _ in 0..count as usize {
        let k1 = flow(ratio);
        let k2 = flow(ratio + k1 * h * 0.5);
        let k3 = flow(ratio + k2 * h * 0.5);
        let k4 = flow(ratio + k3 * h);
        ratio += (k1 + (k2 + k3) * 2.0 + k4) * h / 6.0;
    }
    ratio
}
