//! Newton's method on the balance, with a step length that Newton's own corrections decide.
//!
//! Steps are measured by corrections, not residuals (P. Deuflhard, *Newton Methods for Nonlinear Problems*, 2004,
//! algorithm NLEQ-ERR): the same whatever the units of the balance are, so a stiff stuck contact does not force tiny
//! steps. While corrections shrink fast, the factorised Jacobian is kept.

use super::system::{Problem, System, pack, unpack};
use num_complex::Complex64;

/// How a solution ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Status {
    /// The last correction is below the tolerance.
    Converged,
    /// No step length reduces the correction.
    Stalled,
    /// The iterations ran out.
    IterationLimit,
    /// The balance holds, but the state of a contact does not come back after a period.
    LoopNotClosed,
}

/// Smallest step length tried.
const SHORTEST: f64 = 1e-4;
/// Contraction up to which the Jacobian is kept.
const KEEP: f64 = 0.2;

pub(super) struct Newton<'a> {
    pub problem: Problem<'a>,
    pub tolerance: f64,
    pub limit: usize,
}

/// Vectors of the iteration, `D × (H + 1)`.
#[derive(Default)]
pub(super) struct Vectors {
    pub forces: Vec<Complex64>,
    pub answer: Vec<Complex64>,
    trial: Vec<Complex64>,
    step: Vec<Complex64>,
    next: Vec<Complex64>,
    reals: Vec<f64>,
}

impl Vectors {
    pub fn resize(&mut self, count: usize, order: usize) {
        for vector in [&mut self.forces, &mut self.answer, &mut self.trial, &mut self.step, &mut self.next] {
            vector.resize(count * (order + 1), Complex64::ZERO);
        }
        self.reals.resize(count * (2 * order + 1), 0.0);
    }
}

#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Counts {
    pub linearisations: usize,
    pub evaluations: usize,
    pub correction: f64,
}

impl Newton<'_> {
    /// From `vectors.forces` to the solution there; `vectors.answer` belongs to it.
    pub fn run(&self, system: &mut System, vectors: &mut Vectors, counts: &mut Counts) -> Status {
        system.evaluate(&self.problem, &vectors.forces, &mut vectors.answer);
        counts.evaluations += 1;
        let mut length = 1.0_f64;
        for _ in 0..self.limit {
            system.linearise(&self.problem);
            system.factorise(&self.problem);
            counts.linearisations += 1;
            correction(system, &mut vectors.reals, [&vectors.forces, &vectors.answer], &mut vectors.step);
            let scale = self.scale(vectors);
            let size = norm(&vectors.step, &scale);
            counts.correction = size;
            if !size.is_finite() {
                return Status::Stalled;
            }
            let Some(contraction) = self.damped(system, vectors, counts, (&mut length, size, &scale)) else {
                return Status::Stalled;
            };
            if length == 1.0 && self.settle(system, vectors, counts, (size, contraction, &scale)) {
                let closed = system.closure.closed();
                return if closed { Status::Converged } else { Status::LoopNotClosed };
            }
        }
        Status::IterationLimit
    }

    /// A damped step into `vectors.forces`; gives the contraction `‖next‖/‖step‖`.
    fn damped(
        &self,
        system: &mut System,
        vectors: &mut Vectors,
        counts: &mut Counts,
        (length, size, scale): (&mut f64, f64, &[f64]),
    ) -> Option<f64> {
        *length = length.max(0.1);
        loop {
            advance(&vectors.forces, *length, &vectors.step, &mut vectors.trial);
            self.next(system, vectors, counts);
            let contraction = norm(&vectors.next, scale) / size;
            if size <= self.tolerance || contraction < 1.0 - *length / 4.0 {
                std::mem::swap(&mut vectors.forces, &mut vectors.trial);
                let predicted = self.predicted(vectors, (*length, size, scale));
                if *length < 1.0 {
                    // A full step again as soon as the model holds; settling waits for it.
                    *length = predicted.min(1.0);
                    return Some(1.0);
                }
                return Some(contraction);
            }
            let predicted = self.predicted(vectors, (*length, size, scale));
            *length = predicted.min(*length / 2.0);
            if length.is_nan() || *length < SHORTEST {
                return None;
            }
        }
    }

    /// Step length at which the quadratic model of the correction is least.
    fn predicted(&self, vectors: &Vectors, (length, size, scale): (f64, f64, &[f64])) -> f64 {
        let rest: f64 = {
            let row = vectors.step.len() / scale.len().max(1);
            let parts = vectors.next.iter().zip(&vectors.step).enumerate();
            parts.map(|(i, (n, s))| (n - s * (1.0 - length)).norm_sqr() / scale[i / row].powi(2)).sum()
        };
        0.5 * size * length * length / rest.sqrt().max(f64::MIN_POSITIVE)
    }

    /// Steps with the kept Jacobian while they contract fast; true once a correction is below the tolerance.
    fn settle(
        &self,
        system: &mut System,
        vectors: &mut Vectors,
        counts: &mut Counts,
        (mut size, mut contraction, scale): (f64, f64, &[f64]),
    ) -> bool {
        loop {
            if size <= self.tolerance {
                return true;
            }
            if contraction.is_nan() || contraction > KEEP {
                return false;
            }
            size *= contraction;
            counts.correction = size;
            vectors.step.copy_from_slice(&vectors.next);
            advance(&vectors.forces, 1.0, &vectors.step, &mut vectors.trial);
            self.next(system, vectors, counts);
            let new = norm(&vectors.next, scale) / size;
            if size > self.tolerance && (new.is_nan() || new >= 1.0) {
                system.evaluate(&self.problem, &vectors.forces, &mut vectors.answer);
                counts.evaluations += 1;
                return false;
            }
            contraction = new;
            std::mem::swap(&mut vectors.forces, &mut vectors.trial);
        }
    }

    /// The simplified correction at the trial.
    fn next(&self, system: &mut System, vectors: &mut Vectors, counts: &mut Counts) {
        system.evaluate(&self.problem, &vectors.trial, &mut vectors.answer);
        counts.evaluations += 1;
        correction(system, &mut vectors.reals, [&vectors.trial, &vectors.answer], &mut vectors.next);
    }

    /// Scale of each force: the larger of what is assumed and what is answered.
    fn scale(&self, vectors: &Vectors) -> Vec<f64> {
        let row = vectors.forces.len() / self.problem.lines.forces().max(1);
        let size = |x: &[Complex64]| x.iter().map(Complex64::norm_sqr).sum::<f64>().sqrt();
        let rows = vectors.forces.chunks_exact(row).zip(vectors.answer.chunks_exact(row));
        rows.map(|(f, a)| size(f).max(size(a)).max(f64::MIN_POSITIVE)).collect()
    }
}

fn advance(from: &[Complex64], length: f64, step: &[Complex64], to: &mut [Complex64]) {
    for ((t, f), s) in to.iter_mut().zip(from).zip(step) {
        *t = f + s * length;
    }
}

/// `−K⁻¹ (forces − answer)`.
fn correction(
    system: &mut System,
    reals: &mut [f64],
    [forces, answer]: [&[Complex64]; 2],
    step: &mut [Complex64],
) {
    for ((s, a), f) in step.iter_mut().zip(answer).zip(forces) {
        *s = a - f;
    }
    pack(step, system.order, reals);
    system.dense.solve(reals);
    unpack(reals, system.order, step);
}

fn norm(step: &[Complex64], scale: &[f64]) -> f64 {
    let row = step.len() / scale.len().max(1);
    let rows = step.chunks_exact(row.max(1)).zip(scale);
    rows.map(|(x, s)| x.iter().map(Complex64::norm_sqr).sum::<f64>() / (s * s)).sum::<f64>().sqrt()
}
