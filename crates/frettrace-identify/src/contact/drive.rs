//! A law driven along a history.

use super::Family;
use super::history::{Closure, ContactHistory};
use frettrace_friction::effects::ModifiedState;
use frettrace_friction::{FrictionLaw, Gradient, Scalar, Step};

/// Errors of the motion that are added to it.
pub(super) struct Shift<'a> {
    pub(super) slip: &'a [f64],
    pub(super) velocity: &'a [f64],
}

/// Drives a law from the deflection `start` along a history, hands each force to `take`, and returns the last deflection.
fn drive<T: Scalar>(
    (family, values): (Family, &[T]),
    history: &ContactHistory,
    (start, shift): (T, Option<&Shift<'_>>),
    mut take: impl FnMut(usize, T),
) -> T {
    if family.is_static() {
        drive_static((family, values), history, shift, take);
        return start;
    }
    let law = family.law(values);
    let mut state = law.rest();
    set_deflection(&mut state, start);
    let slip = |k: usize| T::from(history.slip[k] + shift.map_or(0.0, |s| s.slip[k]));
    let velocity = |k: usize| T::from(history.velocity[k] + shift.map_or(0.0, |s| s.velocity[k]));
    for (from, to, dt) in history.steps() {
        let step = Step {
            slip: [slip(from), slip(to)],
            velocity: [velocity(from), velocity(to)],
            normal: [T::from(history.normal[from]), T::from(history.normal[to])],
            dt,
        };
        let (next, force) = law.step(state, &step);
        state = next;
        take(to, force);
    }
    state.0[0]
}

fn set_deflection<T>(state: &mut ModifiedState<T>, value: T) {
    state.0[0] = value;
}

/// `F = N⁺ μ(v) sgn v + σ2 v`, and 0 at rest: what a law without memory says of a sample.
fn drive_static<T: Scalar>(
    (family, values): (Family, &[T]),
    history: &ContactHistory,
    shift: Option<&Shift<'_>>,
    mut take: impl FnMut(usize, T),
) {
    let kinetic = values[0];
    for k in 0..history.len() {
        let v = history.velocity[k] + shift.map_or(0.0, |s| s.velocity[k]);
        let normal = history.normal[k].max(0.0);
        let sign = if v == 0.0 { 0.0 } else { v.signum() };
        let force = if family == Family::Stribeck {
            let (viscous, still, speed, delta) = (values[1], values[2], values[3], values[4]);
            let x = speed.recip() * v.abs() + 1e-12;
            let weight = (-(x.ln() * delta).exp()).exp();
            (kinetic + (still - kinetic) * weight) * normal * sign + viscous * v
        } else {
            kinetic * normal * sign
        };
        take(k, force);
    }
}

/// Deflection a history starts from: of the steady loop where it is periodic, from the first force where it is not.
pub(super) fn start_of(family: Family, values: &[f64], history: &ContactHistory, first: f64) -> f64 {
    if family.is_static() {
        return 0.0;
    }
    if history.closure == Closure::Open {
        return opening(family, values, history);
    }
    // The map of a period on the deflection is monotone with slope in [0, 1): a secant on P(b) − b finds its fixed point.
    let most = 2.0 * most_friction(family, values);
    let miss = |b: f64| drive((family, values), history, (b, None), |_, _| ()) - b;
    let (mut a, mut fa) = (first, miss(first));
    let mut b = a + fa;
    for _ in 0..40 {
        let fb = miss(b);
        // 1e-9 of the friction is far below any noise.
        if fb.abs() < 1e-9 * most || fb == fa {
            break;
        }
        let next = b - fb * (b - a) / (fb - fa);
        (a, fa) = (b, fb);
        b = if next.abs() <= most { next } else { b + fb };
    }
    b
}

/// `F/N` of the first sample, within what the law can hold.
fn opening(family: Family, values: &[f64], history: &ContactHistory) -> f64 {
    let most = most_friction(family, values);
    let normal = history.normal.first().copied().unwrap_or(1.0).max(f64::MIN_POSITIVE);
    let force = history.force.first().copied().unwrap_or(0.0);
    (force / normal).clamp(-0.999 * most, 0.999 * most)
}

/// The larger of the friction coefficients.
fn most_friction(family: Family, values: &[f64]) -> f64 {
    let names = family.parameter_names();
    let value = |name: &str| names.iter().position(|n| *n == name).map_or(0.0, |j| values[j]);
    value("mu_s").max(value("mu_k"))
}

/// Forces along a history (N).
pub(super) fn forces(
    (family, values): (Family, &[f64]),
    history: &ContactHistory,
    (start, shift): (f64, Option<&Shift<'_>>),
    out: &mut [f64],
) {
    out.fill(0.0);
    drive((family, values), history, (start, shift), |k, force| out[k] = force);
}

/// Lanes of the dual numbers: nine parameters of the largest law and the deflection at the start.
const LANES: usize = 10;

/// Forces and their derivatives by the law's parameters (row-major, one row a sample).
pub(super) fn tangents(
    (family, values): (Family, &[f64]),
    history: &ContactHistory,
    start: f64,
    (out, slopes): (&mut [f64], &mut [f64]),
) {
    if values.len() < 4 {
        tangents_by::<4>((family, values), history, start, (out, slopes));
    } else {
        tangents_by::<LANES>((family, values), history, start, (out, slopes));
    }
}

fn tangents_by<const N: usize>(
    (family, values): (Family, &[f64]),
    history: &ContactHistory,
    start: f64,
    (out, slopes): (&mut [f64], &mut [f64]),
) {
    let count = values.len();
    let mut duals = [Gradient::<N>::constant(0.0); N];
    for (j, value) in values.iter().enumerate() {
        duals[j] = Gradient::variable(*value, j);
    }
    let opening = Gradient::<N>::variable(start, N - 1);
    let mut by_start = vec![0.0; out.len()];
    out.fill(0.0);
    slopes.fill(0.0);
    let end = drive((family, &duals[..count]), history, (opening, None), |k, force: Gradient<N>| {
        out[k] = force.re;
        by_start[k] = force.slopes[N - 1];
        for j in 0..count {
            slopes[k * count + j] = force.slopes[j];
        }
    });
    if history.closure == Closure::Open || family.is_static() {
        return;
    }
    // b₀ = P(b₀, θ): db₀/dθ = P_θ/(1 − P_b).
    let stay = (1.0 - end.slopes[N - 1]).max(1e-9);
    for j in 0..count {
        let moved = end.slopes[j] / stay;
        for (k, by) in by_start.iter().enumerate() {
            slopes[k * count + j] += by * moved;
        }
    }
}
