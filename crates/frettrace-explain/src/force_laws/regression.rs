//! Coefficients of a law on recovered histories: linear ones by least squares, a threshold or power by a scan around it.

use super::{History, Shape};
use crate::effects::FREE;
use frettrace_forward::accelerations::{COEFFICIENTS, PortLaw, SHARP};
use nalgebra::{DMatrix, DVector};
use num_complex::Complex64;

/// Thresholds tried between nothing and the largest motion.
const THRESHOLDS: usize = 24;
/// Powers of the velocity that are nearer to its square than to the velocity itself or its cube: with a power of 1 damping is
/// viscous, whatever its name.
const POWERS: (f64, f64) = (1.5, 2.5);
/// A spring that does not yield below this many of the largest displacement is a cubic one.
pub(crate) const CUBIC_BELOW: f64 = 3.0;

/// What a law makes of recovered forces.
pub(crate) struct Answer {
    /// χ² of recovered minus answered force.
    pub chi: f64,
    pub coefficients: [f64; COEFFICIENTS],
}

/// χ² of a force that is linear in motion and velocity, whatever the signs.
pub(crate) fn linear(histories: &[History]) -> f64 {
    let shape = Shape { id: "", law: PortLaw::Polynomial, free: &[0, 1], linear: &[0, 1], side: 0.0 };
    solve(histories, &shape, (&vec![0.0; histories.len()], 0.0), shape.linear)
        .map_or(f64::INFINITY, |answer| answer.chi)
}

/// Largest size of a motion.
fn largest(histories: &[History], of: impl Fn(&History) -> &Vec<f64>) -> f64 {
    histories.iter().flat_map(|h| of(h).iter()).fold(0.0, |m: f64, x| m.max(x.abs()))
}

/// Range of the second coefficient of a law in which the law is what its name says; `None` where every value will do.
pub(crate) fn thresholds(histories: &[History], law: PortLaw) -> Option<(f64, f64)> {
    Some(match law {
        PortLaw::Yielding => {
            // A spring that yields in every run is a linear one: half of them must be left to show the cube.
            let mut peaks: Vec<f64> =
                histories.iter().map(|h| largest(std::slice::from_ref(h), |h| &h.displacement)).collect();
            peaks.sort_by(f64::total_cmp);
            let middle = peaks.get(peaks.len() / 2).copied().unwrap_or_default();
            (middle, CUBIC_BELOW * largest(histories, |h| &h.displacement))
        }
        PortLaw::Power => POWERS,
        PortLaw::Friction => {
            // Friction that never reaches its level is viscous. How it comes there is told by the run that moves least.
            let speeds = histories.iter().map(|h| largest(std::slice::from_ref(h), |h| &h.velocity));
            let (slowest, fastest) = speeds.fold((f64::INFINITY, 0.0_f64), |(a, b), v| (a.min(v), b.max(v)));
            (1e-2 * slowest, fastest)
        }
        PortLaw::Gap => (0.0, f64::INFINITY),
        _ => return None,
    })
}

/// Range of a coefficient about a value: nothing gives energy away or pulls where it should carry, and a corner stays on its side.
pub(crate) fn range(
    law: PortLaw,
    (coefficient, value): (usize, f64),
    thresholds: Option<(f64, f64)>,
) -> (f64, f64) {
    match thresholds {
        Some(range) if coefficient == 1 => range,
        _ if coefficient == 3 && law.has_corner() => {
            if value < 0.0 {
                (f64::NEG_INFINITY, -SHARP)
            } else {
                (SHARP, f64::INFINITY)
            }
        }
        _ if dissipates(law, coefficient) || carries(law, coefficient) => (0.0, f64::INFINITY),
        _ => FREE,
    }
}

/// Coefficients of a law on recovered histories; `None` where it cannot be fitted.
pub(crate) fn regress(histories: &[History], shape: &Shape) -> Option<Answer> {
    let reach = match shape.law {
        PortLaw::Gap | PortLaw::Stop | PortLaw::Round | PortLaw::Yielding => {
            largest(histories, |h| &h.displacement)
        }
        PortLaw::Friction | PortLaw::Power => largest(histories, |h| &h.velocity),
        _ => return linear_fit(histories, shape, (0.0, 0.0)),
    };
    // A stop may be pressed on at rest.
    let ladder: Vec<f64> = match thresholds(histories, shape.law) {
        None => about(reach),
        Some((low, high)) if high.is_finite() => {
            let share = |k: usize| k as f64 / (THRESHOLDS - 1) as f64;
            (0..THRESHOLDS).map(|k| high * (low / high).powf(share(k))).collect()
        }
        Some(_) => falling(reach).collect(),
    };
    let fitted = |c: f64| linear_fit(histories, shape, (c, reach));
    let best = scanned(&ladder, |c| fitted(c).map_or(f64::INFINITY, |a| a.chi))?;
    fitted(best)
}

fn falling(top: f64) -> impl Iterator<Item = f64> {
    (0..THRESHOLDS).map(move |k| top * 0.97 * (0.82_f64).powi(k as i32))
}

/// Sizes of either sign, falling.
fn about(reach: f64) -> Vec<f64> {
    falling(reach).chain(falling(-reach).collect::<Vec<_>>().into_iter().rev()).collect()
}

/// The threshold that leaves least: a scan over a ladder of sizes, then golden section between the neighbours of the best.
fn scanned(ladder: &[f64], chi: impl Fn(f64) -> f64) -> Option<f64> {
    let values: Vec<f64> = ladder.iter().map(|&c| chi(c)).collect();
    let best = (0..ladder.len()).min_by(|&a, &b| values[a].total_cmp(&values[b]))?;
    let (mut low, mut high) = (ladder[(best + 1).min(ladder.len() - 1)], ladder[best.saturating_sub(1)]);
    let golden = 0.5 * (5.0_f64.sqrt() - 1.0);
    for _ in 0..12 {
        let (a, b) = (high - golden * (high - low), low + golden * (high - low));
        if chi(a) < chi(b) {
            high = b;
        } else {
            low = a;
        }
    }
    let refined = 0.5 * (low + high);
    Some(if chi(refined) < values[best] { refined } else { ladder[best] })
}

/// Rounds in which gaps and the values that all runs share agree.
const ROUNDS: usize = 4;

/// A stop on recovered histories in which every run rests elsewhere: the mean of the friction that holds the beam away from the stop, or
/// presses it on, is seen by no accelerometer, so that every run has a gap of its own in its recovered motion. The gap of the answer is that of
/// the run that tells most of the stop, as if friction had no mean there. `None` where the law is no stop or cannot be fitted.
pub(crate) fn regress_resting(histories: &[History], shape: &Shape) -> Option<Answer> {
    if !shape.law.one_sided() {
        return None;
    }
    let alone: Vec<Option<Answer>> =
        histories.iter().map(|h| regress(std::slice::from_ref(h), shape)).collect();
    let told = |k: usize| alone[k].as_ref().map_or(0.0, |answer| histories[k].chi() - answer.chi);
    let clearest = (0..histories.len()).max_by(|&a, &b| told(a).total_cmp(&told(b)))?;
    let mut answer = Answer { chi: f64::INFINITY, ..*alone[clearest].as_ref()? };
    for _ in 0..ROUNDS {
        let gaps = histories.iter().map(|h| Some(stopped(h, shape.law, &answer.coefficients)?.0));
        let gaps = gaps.collect::<Option<Vec<f64>>>()?;
        let mut next = linear_fit_each(histories, shape, (&gaps, 0.0))?;
        let at = with_gap(&next.coefficients, gaps[clearest]);
        let run = &histories[clearest];
        next.coefficients[1] = gaps[clearest] - run.compliance * mean_force(run, shape.law, &at);
        let settled = next.chi > 0.99 * answer.chi;
        answer = next;
        if settled {
            break;
        }
    }
    Some(answer)
}

/// Gap of a stop of known coefficients in the recovered motion of a run, and the χ² that it leaves there.
pub(super) fn stopped(history: &History, law: PortLaw, at: &[f64; COEFFICIENTS]) -> Option<(f64, f64)> {
    let left = |gap: f64| left_by(history, law, &with_gap(at, gap));
    let gap = scanned(&about(largest(std::slice::from_ref(history), |h| &h.displacement)), left)?;
    Some((gap, left(gap)))
}

pub(super) fn with_gap(coefficients: &[f64; COEFFICIENTS], gap: f64) -> [f64; COEFFICIENTS] {
    let mut at = *coefficients;
    at[1] = gap;
    at
}

/// Forces (N) that a law answers to the recovered motion of a run, sample by sample.
fn answered(history: &History, law: PortLaw, at: &[f64; COEFFICIENTS]) -> Vec<f64> {
    let motion = history.displacement.iter().zip(&history.velocity);
    motion.map(|(d, v)| law.force(at, *d, *v).force).collect()
}

/// Their mean.
pub(super) fn mean_force(history: &History, law: PortLaw, at: &[f64; COEFFICIENTS]) -> f64 {
    answered(history, law, at).iter().sum::<f64>() / history.displacement.len().max(1) as f64
}

/// χ² that a law with given coefficients leaves of a recovered force.
pub(super) fn left_by(history: &History, law: PortLaw, at: &[f64; COEFFICIENTS]) -> f64 {
    let mut lines = vec![Complex64::ZERO; history.force.len() + 1];
    history.grid.project(&answered(history, law, at), &mut lines, &mut history.grid.scratch());
    let pairs = history.force.iter().zip(&history.deviation).zip(&lines[1..]);
    pairs.map(|((force, deviation), line)| (force - line / deviation).norm_sqr()).sum()
}

/// Whether a coefficient dissipates, so that it cannot be negative.
fn dissipates(law: PortLaw, coefficient: usize) -> bool {
    match law {
        PortLaw::Polynomial => matches!(coefficient, 1 | 3),
        PortLaw::Gap | PortLaw::Stop | PortLaw::Rough => coefficient == 2,
        PortLaw::Friction | PortLaw::Power => coefficient == 0,
        _ => false,
    }
}

/// Whether a coefficient is the stiffness of a support, which cannot be negative.
fn carries(law: PortLaw, coefficient: usize) -> bool {
    match law {
        PortLaw::Polynomial | PortLaw::Gap | PortLaw::Stop | PortLaw::Rough | PortLaw::Round => {
            coefficient == 0
        }
        PortLaw::Friction => coefficient == 2,
        _ => false,
    }
}

/// Linear coefficients by least squares at a threshold, none of them against physics: a negative dashpot is left out, a
/// negative spring is no support. One that rubs need not carry: its spring is left out too.
fn linear_fit(histories: &[History], shape: &Shape, (threshold, reach): (f64, f64)) -> Option<Answer> {
    linear_fit_each(histories, shape, (&vec![threshold; histories.len()], reach))
}

/// The same with a threshold in each history.
fn linear_fit_each(histories: &[History], shape: &Shape, threshold: (&[f64], f64)) -> Option<Answer> {
    let mut linear = shape.linear.to_vec();
    loop {
        let found = solve(histories, shape, threshold, &linear)?;
        let against = |k: usize| {
            let spare = dissipates(shape.law, k) || shape.law == PortLaw::Friction;
            spare && found.coefficients[k] < 0.0
        };
        match linear.iter().position(|&k| against(k)) {
            Some(place) if linear.len() > 1 => drop(linear.remove(place)),
            Some(_) => return None,
            None if linear.iter().any(|&k| carries(shape.law, k) && found.coefficients[k] < 0.0) => {
                return None;
            }
            None => return Some(found),
        }
    }
}

fn solve(
    histories: &[History],
    shape: &Shape,
    (thresholds, reach): (&[f64], f64),
    linear: &[usize],
) -> Option<Answer> {
    let at = |threshold: f64| match shape.law {
        PortLaw::Power => [1.0, threshold, reach, 0.0],
        PortLaw::Polynomial | PortLaw::Stiffening | PortLaw::LiftOff => [0.0; COEFFICIENTS],
        _ => [1.0, threshold, 0.0, shape.side],
    };
    let rows: usize = histories.iter().map(History::count).sum();
    let width = linear.len();
    let mut matrix = DMatrix::zeros(rows, width);
    let mut right = DVector::zeros(rows);
    let mut row = 0;
    for (history, threshold) in histories.iter().zip(thresholds) {
        let columns = history.columns(shape.law, &at(*threshold), linear);
        for (h, force) in history.force.iter().enumerate() {
            right[row] = force.re;
            right[row + 1] = force.im;
            for (c, column) in columns.iter().enumerate() {
                matrix[(row, c)] = column[h].re;
                matrix[(row + 1, c)] = column[h].im;
            }
            row += 2;
        }
    }
    let scale: Vec<f64> = (0..width).map(|c| matrix.column(c).norm()).collect();
    if scale.iter().any(|s| !s.is_finite() || *s <= 0.0) {
        return None;
    }
    for (c, s) in scale.iter().enumerate() {
        matrix.column_mut(c).unscale_mut(*s);
    }
    let normal = matrix.transpose() * &matrix + DMatrix::from_diagonal_element(width, width, 1e-12);
    let solution = normal.cholesky()?.solve(&(matrix.transpose() * &right));
    let chi = (&right - &matrix * &solution).norm_squared();
    let mut coefficients = at(thresholds.first().copied().unwrap_or_default());
    for (c, &k) in linear.iter().enumerate() {
        coefficients[k] = solution[c] / scale[c];
    }
    Some(Answer { chi, coefficients })
}
