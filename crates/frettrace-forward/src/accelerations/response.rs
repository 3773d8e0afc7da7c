//! Answer of the friction force to small changes over a settled period, step by step.
//!
//! A step's derivatives are kept side by side, only those of states that the law uses: a balance asks for hundreds of
//! answers, and reading the derivatives is most of their cost.

use super::contact::{Begun, Local, MOTIONS};
use frettrace_friction::effects::{Monodromy, STATES};

/// Derivatives of all steps of a period, and what the period does to its initial state.
pub(super) struct Response {
    used: usize,
    /// One step after the other: the force's derivatives by motion and states, then those of each new state.
    rows: Vec<f64>,
    /// Change of the force at each sample by each initial state. The first of them is held where the contact has not settled: in its place stands
    /// the slip gained in the period, which brings it back to what it was.
    initial: Vec<[f64; STATES]>,
    /// What the period does to each initial state.
    period: Monodromy,
    /// Derivatives of each initial state by the motion at the first sample, where the period keeps it.
    begun: [[f64; MOTIONS]; STATES],
}

/// Motion of a contact in `L` directions side by side, one value a sample; what does not move is empty.
#[derive(Clone, Copy)]
pub(super) struct Moves<'a, const L: usize> {
    pub slip: &'a [[f64; L]],
    pub velocity: &'a [[f64; L]],
    pub normal: &'a [[f64; L]],
    pub trial: &'a [[f64; L]],
}

/// Adds a multiple of values side by side.
fn add<const L: usize>(sum: &mut [f64; L], factor: f64, values: &[f64; L]) {
    sum.iter_mut().zip(values).for_each(|(sum, value)| *sum += factor * value);
}

impl<const L: usize> Moves<'_, L> {
    const STILL: Self = Self { slip: &[], velocity: &[], normal: &[], trial: &[] };

    /// Change of one value of step `k`: its derivatives by motion, then by the `M` states, with the changes of both.
    fn change<const M: usize>(
        &self,
        gradient: &[f64],
        (k, next): (usize, usize),
        state: &[[f64; L]; M],
    ) -> [f64; L] {
        let mut sum = [0.0; L];
        for (series, by) in [self.slip, self.velocity, self.normal].into_iter().zip(gradient.chunks_exact(2))
        {
            if !series.is_empty() {
                add(&mut sum, by[0], &series[k]);
                add(&mut sum, by[1], &series[next]);
            }
        }
        if !self.trial.is_empty() {
            add(&mut sum, gradient[MOTIONS - 1], &self.trial[next]);
        }
        gradient[MOTIONS..].iter().zip(state).for_each(|(by, state)| add(&mut sum, *by, state));
        sum
    }
}

impl Response {
    /// The response of a law that uses the first `used` states; the first of them may be `held` at the start.
    pub fn new(locals: &[Local], begun: &Begun, (used, held, dt): (usize, bool, f64)) -> Self {
        let mut rows = Vec::with_capacity(locals.len() * (1 + used) * (MOTIONS + used));
        for local in locals {
            for gradient in std::iter::once(&local.force).chain(local.state.iter().take(used)) {
                rows.extend_from_slice(&gradient[Local::MOTION..Local::MOTION + MOTIONS]);
                rows.extend_from_slice(&gradient[..used]);
            }
        }
        let initial = vec![[0.0; STATES]; locals.len()];
        let by_motion = |state: &[f64]| std::array::from_fn(|i| state[Local::MOTION + i]);
        let begun = std::array::from_fn(|i| by_motion(&begun[i]));
        let mut response = Self { used, rows, initial, period: Monodromy::new(0, |_, _| 0.0), begun };
        response.period = match used {
            1 => response.run_through::<1>((held, dt)),
            2 => response.run_through::<2>((held, dt)),
            3 => response.run_through::<3>((held, dt)),
            _ => response.run_through::<STATES>((held, dt)),
        };
        response
    }

    /// What each initial state alone, a direction each, does over the period. The change of one that is held at the start ends as it began, at nothing,
    /// by the slip that is gained: the step `x₀ = x₀ + D₀δ + Σ P₀ⱼxⱼ` of a state whose map by itself were `1 + D₀`.
    fn run_through<const M: usize>(&mut self, (held, dt): (bool, f64)) -> Monodromy {
        let samples = self.initial.len();
        let unit = |i: usize, j: usize| f64::from(u8::from(i == j && !(held && i == 0)));
        let mut state: [[f64; M]; M] = std::array::from_fn(|i| std::array::from_fn(|j| unit(i, j)));
        for k in 0..samples {
            let next = if k + 1 == samples { 0 } else { k + 1 };
            let mut force = self.step(k, next, &Moves::STILL, &mut state);
            if held {
                let (by_force, by_state) = self.by_gained_slip::<M>(k, dt);
                force[0] += by_force;
                state.iter_mut().zip(by_state).for_each(|(state, by)| state[0] += by);
            }
            self.initial[next][..M].copy_from_slice(&force);
        }
        Monodromy::new(M, |i, j| state[i][j] + f64::from(u8::from(held && i == 0 && j == 0)))
    }

    /// Change of the force after step `k`; moves the change of the state. `M` states are used, in `L` directions: known when
    /// compiled, their loops are unrolled.
    fn step<const M: usize, const L: usize>(
        &self,
        k: usize,
        next: usize,
        moves: &Moves<'_, L>,
        state: &mut [[f64; L]; M],
    ) -> [f64; L] {
        let (by_force, by_state) = self.of_step::<M>(k);
        let old = *state;
        for (new, row) in state.iter_mut().zip(by_state) {
            *new = moves.change(row, (k, next), &old);
        }
        moves.change(by_force, (k, next), &old)
    }

    /// Derivatives of the force in step `k`, and of each of `M` states after it.
    fn of_step<const M: usize>(&self, k: usize) -> (&[f64], impl Iterator<Item = &[f64]>) {
        let width = MOTIONS + M;
        let at = k * (1 + M) * width;
        let (by_force, by_state) = self.rows[at..at + (1 + M) * width].split_at(width);
        (by_force, by_state.chunks_exact(width))
    }

    /// What a slip that is gained evenly over the period adds in step `k` of duration `dt` to the force, and to each of `M` states after it.
    fn by_gained_slip<const M: usize>(&self, k: usize, dt: f64) -> (f64, [f64; M]) {
        let samples = self.initial.len() as f64;
        let faster = 1.0 / (samples * dt);
        let moved = [k as f64 / samples, (k + 1) as f64 / samples, faster, faster];
        let by_slip = |row: &[f64]| row.iter().zip(moved).map(|(by, moved)| by * moved).sum::<f64>();
        let (by_force, by_state) = self.of_step::<M>(k);
        let mut states = [0.0; M];
        states.iter_mut().zip(by_state).for_each(|(state, row)| *state = by_slip(row));
        (by_slip(by_force), states)
    }

    /// Change of the force over the period by the given motion, and by what a parameter adds (`by_hook`) to the force and to the
    /// new states of each step, and to the states that a contact which keeps them begins with.
    pub fn answer<const L: usize>(
        &self,
        moves: &Moves<'_, L>,
        by_hook: (impl Fn(usize) -> Option<[f64; STATES + 1]>, [f64; STATES]),
    ) -> Vec<[f64; L]> {
        match self.used {
            1 => self.answer_of::<1, L>(moves, by_hook),
            2 => self.answer_of::<2, L>(moves, by_hook),
            3 => self.answer_of::<3, L>(moves, by_hook),
            _ => self.answer_of::<STATES, L>(moves, by_hook),
        }
    }

    fn answer_of<const M: usize, const L: usize>(
        &self,
        moves: &Moves<'_, L>,
        (by_hook, begun_by_hook): (impl Fn(usize) -> Option<[f64; STATES + 1]>, [f64; STATES]),
    ) -> Vec<[f64; L]> {
        let samples = self.initial.len();
        let mut force = vec![[0.0; L]; samples];
        let mut state = [[0.0; L]; M];
        for k in 0..samples {
            let next = if k + 1 == samples { 0 } else { k + 1 };
            force[next] = self.step(k, next, moves, &mut state);
            if let Some([by_force, by_state @ ..]) = by_hook(k) {
                force[next].iter_mut().for_each(|force| *force += by_force);
                for (state, by) in state.iter_mut().zip(by_state) {
                    state.iter_mut().for_each(|state| *state += by);
                }
            }
        }
        // The first sample's motion alone, as if it were both ends of a step.
        let mut kept = self.begun.map(|by| moves.change::<0>(&by, (0, 0), &[]));
        for (kept, by) in kept.iter_mut().zip(begun_by_hook) {
            kept.iter_mut().for_each(|kept| *kept += by);
        }
        let mut start = [[0.0; L]; STATES];
        for lane in 0..L {
            let reached = std::array::from_fn(|i| if i < M { state[i][lane] } else { 0.0 });
            let settled = self.period.settle(reached, kept.map(|state| state[lane]));
            start.iter_mut().zip(settled).for_each(|(start, settled)| start[lane] = settled);
        }
        for (force, by_start) in force.iter_mut().zip(&self.initial) {
            by_start.iter().zip(&start).for_each(|(by, start)| add(force, *by, start));
        }
        force
    }
}
