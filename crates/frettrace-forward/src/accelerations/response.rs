//! Answer of the friction force to small changes over a settled period, step by step.
//!
//! A step's derivatives are kept side by side, only those of states that the law uses: a balance asks for hundreds of
//! answers, and reading the derivatives is most of their cost.

use super::contact::{Local, MOTIONS, STATES};

/// Derivatives of all steps of a period, and what the period does to its initial state.
pub(super) struct Response {
    used: usize,
    /// One step after the other: the force's derivatives by motion and states, then those of each new state.
    rows: Vec<f64>,
    /// Change of the force at each sample by each initial state.
    initial: Vec<[f64; STATES]>,
    /// Change of the final state by each initial state.
    period: [[f64; STATES]; STATES],
}

/// Change of one value of a step: derivatives by motion, then by the `M` states, with the changes of both.
fn dot<const M: usize>(gradient: &[f64], motion: &[f64; MOTIONS], state: &[f64; M]) -> f64 {
    let (by_motion, by_state) = gradient.split_at(MOTIONS);
    let sum: f64 = by_motion.iter().zip(motion).map(|(a, b)| a * b).sum();
    sum + by_state.iter().zip(state).map(|(a, b)| a * b).sum::<f64>()
}

impl Response {
    /// The response of a law that uses the first `used` states.
    pub fn new(locals: &[Local], used: usize) -> Self {
        let mut rows = Vec::with_capacity(locals.len() * (1 + used) * (MOTIONS + used));
        for local in locals {
            for gradient in std::iter::once(&local.force).chain(local.state.iter().take(used)) {
                rows.extend_from_slice(&gradient[Local::MOTION..Local::MOTION + MOTIONS]);
                rows.extend_from_slice(&gradient[..used]);
            }
        }
        let mut response =
            Self { used, rows, initial: vec![[0.0; STATES]; locals.len()], period: [[0.0; STATES]; STATES] };
        match used {
            1 => response.run_through::<1>(),
            2 => response.run_through::<2>(),
            3 => response.run_through::<3>(),
            _ => response.run_through::<STATES>(),
        }
        response
    }

    /// What each initial state alone does over the period.
    fn run_through<const M: usize>(&mut self) {
        let samples = self.initial.len();
        let still = [0.0; MOTIONS];
        for i in 0..M {
            let mut state = [0.0; M];
            state[i] = 1.0;
            for k in 0..samples {
                let force = self.step(k, &still, &mut state);
                let next = if k + 1 == samples { 0 } else { k + 1 };
                self.initial[next][i] = force;
            }
            self.period[i][..M].copy_from_slice(&state);
        }
    }

    /// Change of the force after step `k`; moves the change of the state. `M` states are used: known when compiled, their loops
    /// are unrolled.
    fn step<const M: usize>(&self, k: usize, motion: &[f64; MOTIONS], state: &mut [f64; M]) -> f64 {
        let width = MOTIONS + M;
        let at = k * (1 + M) * width;
        let rows = &self.rows[at..at + (1 + M) * width];
        let old = *state;
        for (new, row) in state.iter_mut().zip(rows[width..].chunks_exact(width)) {
            *new = dot(row, motion, &old);
        }
        dot(&rows[..width], motion, &old)
    }

    /// Change of the force over the period: `motion` gives the changes of a step's motion, `by_hook` what a parameter adds to
    /// its force and to its new states.
    pub fn answer(
        &self,
        motion: impl Fn(usize, usize) -> [f64; MOTIONS],
        by_hook: impl Fn(usize) -> Option<[f64; STATES + 1]>,
    ) -> Vec<f64> {
        match self.used {
            1 => self.answer_of::<1>(motion, by_hook),
            2 => self.answer_of::<2>(motion, by_hook),
            3 => self.answer_of::<3>(motion, by_hook),
            _ => self.answer_of::<STATES>(motion, by_hook),
        }
    }

    fn answer_of<const M: usize>(
        &self,
        motion: impl Fn(usize, usize) -> [f64; MOTIONS],
        by_hook: impl Fn(usize) -> Option<[f64; STATES + 1]>,
    ) -> Vec<f64> {
        let samples = self.initial.len();
        let mut force = vec![0.0; samples];
        let mut state = [0.0; M];
        for k in 0..samples {
            let next = if k + 1 == samples { 0 } else { k + 1 };
            force[next] = self.step(k, &motion(k, next), &mut state);
            if let Some(added) = by_hook(k) {
                force[next] += added[0];
                state.iter_mut().zip(&added[1..]).for_each(|(s, a)| *s += a);
            }
        }
        let mut reached = [0.0; STATES];
        reached[..M].copy_from_slice(&state);
        let start = self.close(&reached);
        for (f, by_start) in force.iter_mut().zip(&self.initial) {
            *f += by_start.iter().zip(&start).map(|(a, b)| a * b).sum::<f64>();
        }
        force
    }

    /// `(I − Φ)⁻¹ g` for the period map `Φ`; a state that never forgets stays where it started.
    fn close(&self, reached: &[f64; STATES]) -> [f64; STATES] {
        let m = self.used;
        let mut matrix = nalgebra::SMatrix::<f64, STATES, STATES>::identity();
        let mut right = nalgebra::SVector::<f64, STATES>::zeros();
        for i in 0..m {
            right[i] = reached[i];
            for j in 0..m {
                matrix[(i, j)] -= self.period[j][i];
            }
            if matrix[(i, i)].abs() < 1e-7 {
                right[i] = 0.0;
                for j in 0..m {
                    matrix[(i, j)] = f64::from(u8::from(i == j));
                }
            }
        }
        let solution = matrix.lu().solve(&right).unwrap_or_default();
        std::array::from_fn(|i| solution[i])
    }
}
