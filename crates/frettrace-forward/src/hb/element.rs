//! A contact law over one period: values, and partial derivatives step by step from dual numbers.

use super::contact::{ContactLaw, Family};
use frettrace_friction::{Gradient, Scalar, Step, Stretch};
use std::ops::ControlFlow;

/// Inputs of a step besides the state: slip, velocity and normal force, each at the old and the new sample.
pub(super) const INPUTS: usize = 6;
/// Width of the dual numbers that carry parameters; more parameters are carried in several passes.
const CHUNK: usize = 8;
/// Width of the dual numbers for laws of four states; of more states as many passes as it takes.
const WIDE: usize = 4 + INPUTS;

/// Motion of a contact, sample by sample over one period.
#[derive(Clone, Debug, Default)]
pub struct Motion {
    /// Slip `u` (m).
    pub slip: Vec<f64>,
    /// Slip velocity `v` (m/s).
    pub velocity: Vec<f64>,
    /// Normal force `N` (N).
    pub normal: Vec<f64>,
    /// Duration of a step (s).
    pub dt: f64,
}

impl Motion {
    pub(super) fn resize(&mut self, samples: usize) {
        self.slip.resize(samples, 0.0);
        self.velocity.resize(samples, 0.0);
        self.normal.resize(samples, 0.0);
    }

    fn step<T: Scalar>(&self, k: usize) -> Step<T> {
        let (old, new) = (k - 1, if k == self.slip.len() { 0 } else { k });
        let pair = |x: &[f64]| [T::from(x[old]), T::from(x[new])];
        Step {
            slip: pair(&self.slip),
            velocity: pair(&self.velocity),
            normal: pair(&self.normal),
            dt: self.dt,
        }
    }

    /// Loading from rest to the motion of sample 0 within one period: where the state starts when nothing fades it.
    fn virgin<T: Scalar>(&self, slip: T, normal: T) -> Step<T> {
        let period = self.dt * self.slip.len() as f64;
        Step { slip: [T::zero(), slip], velocity: [slip / period; 2], normal: [normal; 2], dt: period }
    }
}

/// States and forces over one period: `states[k]` after sample `k = 0..=N`, `forces[k]` at sample `k = 0..N`.
#[derive(Clone, Debug, Default)]
pub struct Orbit {
    pub(super) states: Vec<f64>,
    pub(super) forces: Vec<f64>,
}

impl Orbit {
    /// Notes a state after step `k` and the forces at sample `at`; whether the orbit went through that state before.
    #[inline(always)]
    fn store(&mut self, [k, at]: [usize; 2], state: &[f64], forces: &[f64]) -> bool {
        let slot = &mut self.states[k * state.len()..(k + 1) * state.len()];
        let met = meets(slot, state);
        slot.copy_from_slice(state);
        self.forces[at * forces.len()..(at + 1) * forces.len()].copy_from_slice(forces);
        met
    }
}

/// Partial derivatives step by step: `M + O` rows (new states, forces) of `M + 6` columns (old states, then slip,
/// velocity and normal force at the old and the new sample).
#[derive(Clone, Debug, Default)]
pub struct Partials {
    pub(super) rows: Vec<f64>,
}

/// A contact law as the solver uses it, over whole periods; every [`Family`] is one.
pub trait Element: Sync {
    /// Number of internal states `M`.
    fn states(&self) -> usize;
    /// Number of forces `O`.
    fn forces(&self) -> usize;
    /// Whether the slip velocity matters; without, it is left as it was.
    fn takes_velocity(&self) -> bool {
        true
    }
    /// Number of free parameters `P`.
    fn parameters(&self) -> usize;
    /// The state after loading from rest to sample 0.
    fn start(&self, motion: &Motion, state: &mut [f64]);
    /// Partial derivatives of [`Self::start`] by slip, normal force and the parameters: `M` rows of `2 + P`.
    fn start_partials(&self, motion: &Motion, rows: &mut Vec<f64>);
    /// One period from `states[0]`. With `again`, the orbit holds a former period, and the march ends where it
    /// meets it.
    fn march(&self, motion: &Motion, again: bool, orbit: &mut Orbit);
    /// One period from `states[0]` with its partial derivatives.
    fn linearise(&self, motion: &Motion, orbit: &mut Orbit, partials: &mut Partials);
    /// Partial derivatives by the parameters along an orbit: for each step `M + O` rows of `P`.
    fn parameter_partials(&self, motion: &Motion, orbit: &Orbit, rows: &mut Vec<f64>);
}

type Law<F, T> = <F as Family>::Law<T>;

impl<F: Family> Element for F {
    fn states(&self) -> usize {
        self.law(Family::parameters(self)).rest().as_ref().len()
    }

    fn forces(&self) -> usize {
        <Law<F, f64> as ContactLaw<f64>>::FORCES.clamp(1, 2)
    }

    fn takes_velocity(&self) -> bool {
        <Law<F, f64> as ContactLaw<f64>>::VELOCITY
    }

    fn parameters(&self) -> usize {
        Family::parameters(self).len()
    }

    fn start(&self, motion: &Motion, state: &mut [f64]) {
        let law = self.law(Family::parameters(self));
        let (new, _) = law.step(law.rest(), &motion.virgin(motion.slip[0], motion.normal[0]));
        state.copy_from_slice(new.as_ref());
    }

    fn start_partials(&self, motion: &Motion, rows: &mut Vec<f64>) {
        let (states, width) = (Element::states(self), 2 + Element::parameters(self));
        rows.clear();
        rows.resize(states * width, 0.0);
        for first in (0..width).step_by(CHUNK) {
            let seeded = |value: f64, index: usize| seed::<CHUNK>(value, index.checked_sub(first));
            let parameters: Vec<_> =
                Family::parameters(self).iter().enumerate().map(|(p, &x)| seeded(x, 2 + p)).collect();
            let law = self.law(&parameters);
            let step = motion.virgin(seeded(motion.slip[0], 0), seeded(motion.normal[0], 1));
            let (state, _) = law.step(law.rest(), &step);
            for (row, z) in rows.chunks_exact_mut(width).zip(state.as_ref()) {
                for (slot, d) in row[first..].iter_mut().zip(z.slopes) {
                    *slot = d;
                }
            }
        }
    }

    fn march(&self, motion: &Motion, again: bool, orbit: &mut Orbit) {
        let law = self.law(Family::parameters(self));
        let mut state = law.rest();
        let (m, o) = (state.as_ref().len(), Element::forces(self));
        state.as_mut().copy_from_slice(&orbit.states[..m]);
        let samples = motion.slip.len();
        let Motion { slip, velocity, normal, dt } = motion;
        let mut met = false;
        // Stored where the steps are made: of a law with few operations a call a sample would cost as much as its step.
        state = law.follow(
            state,
            &Stretch { slip, velocity, normal, dt: *dt },
            #[inline(always)]
            |index, new, force| {
                met = orbit.store([index + 1; 2], new.as_ref(), &force[..o]) && again;
                if met { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
            },
        );
        if met {
            return;
        }
        let last = samples - 1;
        let around = [slip, velocity, normal].map(|x| [x[last], x[0]]);
        let [slip, velocity, normal] = &around;
        let end = Stretch { slip, velocity, normal, dt: *dt };
        law.follow(state, &end, |_, new, force| {
            orbit.store([samples, 0], new.as_ref(), &force[..o]);
            ControlFlow::Continue(())
        });
    }

    fn linearise(&self, motion: &Motion, orbit: &mut Orbit, partials: &mut Partials) {
        let states = Element::states(self);
        match states {
            0 | 1 => linearise::<7, F>(self, motion, (orbit, partials), 0),
            2 => linearise::<8, F>(self, motion, (orbit, partials), 0),
            _ => {
                for first in (0..states + INPUTS).step_by(WIDE) {
                    linearise::<WIDE, F>(self, motion, (orbit, partials), first);
                }
            }
        }
    }

    fn parameter_partials(&self, motion: &Motion, orbit: &Orbit, rows: &mut Vec<f64>) {
        let (m, o, p) = (Element::states(self), Element::forces(self), Element::parameters(self));
        let samples = motion.slip.len();
        rows.clear();
        rows.resize(samples * (m + o) * p, 0.0);
        for first in (0..p).step_by(CHUNK) {
            let seeded: Vec<_> = (Family::parameters(self).iter().enumerate())
                .map(|(index, &x)| seed::<CHUNK>(x, index.checked_sub(first)))
                .collect();
            let law = self.law(&seeded);
            let mut state = law.rest();
            for k in 1..=samples {
                for (z, &value) in state.as_mut().iter_mut().zip(&orbit.states[(k - 1) * m..k * m]) {
                    *z = value.into();
                }
                let (new, force) = law.step(state, &motion.step(k));
                let block = &mut rows[(k - 1) * (m + o) * p..k * (m + o) * p];
                for (row, z) in block.chunks_exact_mut(p).zip(new.as_ref().iter().chain(&force[..o])) {
                    for (slot, d) in row[first..].iter_mut().zip(z.slopes) {
                        *slot = d;
                    }
                }
            }
        }
    }
}

/// A dual number; `index` says which derivative part is 1, none where it lies outside.
fn seed<const W: usize>(value: f64, index: Option<usize>) -> Gradient<W> {
    match index {
        Some(index) if index < W => Gradient::variable(value, index),
        _ => Gradient::constant(value),
    }
}

#[inline(always)]
fn meets(old: &[f64], new: &[f64]) -> bool {
    old.iter().zip(new).all(|(a, b)| (a - b).abs() <= 4.0 * f64::EPSILON * b.abs())
}

/// The columns of the partials from `first` on, `W` of them.
#[inline(always)]
fn linearise<const W: usize, F: Family>(
    family: &F,
    motion: &Motion,
    (orbit, partials): (&mut Orbit, &mut Partials),
    first: usize,
) {
    let seed = |value: f64, index: usize| seed::<W>(value, index.checked_sub(first));
    let parameters: Vec<Gradient<W>> =
        Family::parameters(family).iter().map(|&x| Gradient::constant(x)).collect();
    let law = family.law(&parameters);
    let mut state = law.rest();
    let (m, o) = (state.as_ref().len(), Element::forces(family));
    let (samples, width) = (motion.slip.len(), m + INPUTS);
    partials.rows.resize(samples * (m + o) * width, 0.0);
    for k in 1..=samples {
        let (before, after) = orbit.states.split_at_mut(k * m);
        for (index, (z, &value)) in state.as_mut().iter_mut().zip(&before[(k - 1) * m..]).enumerate() {
            *z = seed(value, index);
        }
        let values: Step<f64> = motion.step(k);
        let pair = |x: [f64; 2], at: usize| [seed(x[0], m + at), seed(x[1], m + at + 1)];
        let step = Step {
            slip: pair(values.slip, 0),
            velocity: pair(values.velocity, 2),
            normal: pair(values.normal, 4),
            dt: values.dt,
        };
        let (new, force) = law.step(state, &step);
        for (slot, z) in after.iter_mut().zip(new.as_ref()) {
            *slot = z.re;
        }
        let at = if k == samples { 0 } else { k };
        for (slot, f) in orbit.forces[at * o..].iter_mut().zip(&force[..o]) {
            *slot = f.re;
        }
        let block = &mut partials.rows[(k - 1) * (m + o) * width..k * (m + o) * width];
        for (row, z) in block.chunks_exact_mut(width).zip(new.as_ref().iter().chain(&force[..o])) {
            let row = &mut row[first..];
            let count = row.len().min(W);
            row[..count].copy_from_slice(&z.slopes[..count]);
        }
    }
}
