//! The periodic state of a contact: fixed point of its period map.

use super::contact::STATE_LIMIT;
use super::element::{Element, INPUTS, Motion, Orbit, Partials};
use nalgebra::{DMatrix, SMatrix};

pub(super) type Square = SMatrix<f64, STATE_LIMIT, STATE_LIMIT>;

/// Plain periods marched before Newton takes over: a sliding contact forgets its state within one.
const PLAIN_PERIODS: usize = 3;
/// Newton steps on the period map.
const NEWTON_LIMIT: usize = 25;
/// Below this a direction of the state neither fades nor grows over a period: it stays where loading left it.
const NEUTRAL: f64 = 1e-9;
/// Below this the memory of a state is gone: rounding hides it.
const FADED: f64 = 1e-17;

/// How well a period closes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Closure {
    /// Largest change of a state over the period, relative to the largest state.
    pub mismatch: f64,
}

impl Closure {
    /// Rounding of a march of a few hundred steps.
    const TOLERANCE: f64 = 1e-12;

    pub fn closed(self) -> bool {
        self.mismatch <= Self::TOLERANCE
    }
}

/// Marches from rest until the period closes; Newton on the period map where memory fades slowly.
pub(super) fn close(
    element: &dyn Element,
    motion: &Motion,
    orbit: &mut Orbit,
    partials: &mut Partials,
) -> Closure {
    let (m, samples) = (element.states(), motion.slip.len());
    orbit.states.resize((samples + 1) * m, 0.0);
    orbit.forces.resize(samples * element.forces(), 0.0);
    element.start(motion, &mut orbit.states[..m]);
    let mut closure = Closure { mismatch: f64::INFINITY };
    element.march(motion, false, orbit);
    for _ in 1..PLAIN_PERIODS {
        // A period that has closed is met at its first step.
        restart(orbit, m, samples);
        element.march(motion, true, orbit);
        closure = mismatch(orbit, m, samples);
        if closure.closed() {
            return closure;
        }
    }
    for _ in 0..NEWTON_LIMIT {
        element.linearise(motion, orbit, partials);
        closure = mismatch(orbit, m, samples);
        if closure.closed() {
            break;
        }
        correct(orbit, m, Memory::of(partials, [m, element.forces(), samples]));
    }
    closure
}

fn restart(orbit: &mut Orbit, m: usize, samples: usize) {
    orbit.states.copy_within(samples * m..(samples + 1) * m, 0);
}

fn mismatch(orbit: &Orbit, m: usize, samples: usize) -> Closure {
    let (first, last) = (&orbit.states[..m], &orbit.states[samples * m..]);
    let mut worst = 0.0_f64;
    for j in 0..m {
        let change = (last[j] - first[j]).abs();
        if change == 0.0 {
            continue;
        }
        let scale = orbit.states.iter().skip(j).step_by(m).fold(0.0_f64, |a, z| a.max(z.abs()));
        // NaN must not pass as closed.
        let relative = change / scale;
        worst = if relative.is_nan() { f64::INFINITY } else { worst.max(relative) };
    }
    Closure { mismatch: worst }
}

/// `z_0 ← z_0 + (1 − Π)⁺ (z_N − z_0)`.
fn correct(orbit: &mut Orbit, m: usize, memory: Memory) {
    let last = orbit.states.len() - m;
    let inverse = memory.inverse();
    let change: Vec<f64> = (0..m).map(|j| orbit.states[last + j] - orbit.states[j]).collect();
    for j in 0..m {
        orbit.states[j] += (0..m).map(|i| inverse.resolvent[(j, i)] * change[i]).sum::<f64>();
    }
}

/// What is left of a state after a period.
#[derive(Clone, Copy, Debug)]
pub(super) struct Memory {
    /// Step from which on the state decides the end of the period: what was before is forgotten. `None`: it lasts.
    pub faded: Option<usize>,
    /// Derivative of the period map `Π`, padded with zeros; of memory that lasts.
    product: Square,
    states: usize,
}

/// `(1 − Π)⁺` and the projector on the neutral directions.
#[derive(Clone, Copy, Debug)]
pub(super) struct Resolvent {
    pub resolvent: Square,
    pub neutral: Square,
}

impl Memory {
    fn faded(since: usize) -> Self {
        Self { faded: Some(since), product: Square::zeros(), states: 0 }
    }

    pub fn of(partials: &Partials, [m, o, samples]: [usize; 3]) -> Self {
        if m == 0 {
            return Self::faded(samples);
        }
        let (width, block) = (m + INPUTS, (m + o) * (m + INPUTS));
        if m == 1 {
            return Self::of_one(partials, block, samples);
        }
        let mut product = Square::zeros();
        (0..m).for_each(|j| product[(j, j)] = 1.0);
        for k in (0..samples).rev() {
            let rows = &partials.rows[k * block..];
            let old = product;
            let mut largest = 0.0_f64;
            for i in 0..m {
                for j in 0..m {
                    let value = (0..m).map(|l| old[(i, l)] * rows[l * width + j]).sum::<f64>();
                    product[(i, j)] = value;
                    largest = largest.max(value.abs());
                }
            }
            if largest < FADED {
                return Self::faded(k);
            }
        }
        Self { faded: None, product, states: m }
    }

    fn of_one(partials: &Partials, block: usize, samples: usize) -> Self {
        let mut product = 1.0;
        for k in (0..samples).rev() {
            product *= partials.rows[k * block];
            if f64::abs(product) < FADED {
                return Self::faded(k);
            }
        }
        let mut square = Square::zeros();
        square[(0, 0)] = product;
        Self { faded: None, product: square, states: 1 }
    }

    /// `(1 − Π)⁺` by singular values.
    pub fn inverse(self) -> Resolvent {
        let mut result = Resolvent { resolvent: Square::zeros(), neutral: Square::zeros() };
        let Self { faded, product, states } = self;
        if faded.is_some() {
            result.resolvent.fill_diagonal(1.0);
            return result;
        }
        if states == 1 {
            let value = 1.0 - product[(0, 0)];
            let neutral = value.abs() <= NEUTRAL;
            result.resolvent[(0, 0)] = if neutral { 0.0 } else { value.recip() };
            result.neutral[(0, 0)] = f64::from(neutral);
            return result;
        }
        let identity = DMatrix::identity(states, states);
        let svd = (identity - product.view((0, 0), (states, states))).svd(true, true);
        let (Some(u), Some(v)) = (svd.u, svd.v_t) else {
            result.resolvent.fill_diagonal(1.0);
            return result;
        };
        let mut resolvent = result.resolvent.view_mut((0, 0), (states, states));
        let mut neutral = result.neutral.view_mut((0, 0), (states, states));
        for (i, &value) in svd.singular_values.iter().enumerate() {
            let right = v.row(i).transpose();
            if value > NEUTRAL {
                resolvent += &right * u.column(i).transpose() / value;
            } else {
                neutral += &right * right.transpose();
            }
        }
        result
    }
}
