//! The contact forces of one run: Newton's method on `f − Φ(R_e F_e − R f) = 0`.

use super::balance::recover;
use super::linear::Tangent;
use super::run::{Evaluation, State, coefficient};
use super::structure::Layout;
use num_complex::Complex64;
use std::sync::Arc;

pub(super) type Factor = Arc<faer::linalg::solvers::PartialPivLu<f64>>;

/// What is kept between evaluations, one a run.
#[derive(Clone, Default)]
pub struct RunMemory {
    pub(super) unknowns: Vec<f64>,
    /// Factor of the derivative of the imbalance, and the unknowns it was taken at.
    pub(super) factor: Option<(Factor, Arc<Vec<f64>>)>,
}

impl RunMemory {
    /// The solution with one more port, after `ports` others and the contact, that exerts nothing.
    pub(super) fn with_idle_port(&self, ports: usize) -> Self {
        let mut unknowns = self.unknowns.clone();
        unknowns.resize(self.unknowns.len() / (1 + ports) * (2 + ports), 0.0);
        Self { unknowns, factor: None }
    }

    /// Whether the factor still belongs to the unknowns: within `1e-3` of their size.
    pub(super) fn current(&self) -> Option<Factor> {
        let (factor, at) = self.factor.as_ref()?;
        let (mut change, mut size) = (0.0, 0.0);
        for (x, old) in self.unknowns.iter().zip(at.iter()) {
            change += (x - old) * (x - old);
            size += x * x;
        }
        (at.len() == self.unknowns.len() && change <= 1e-6 * size).then(|| factor.clone())
    }
}

/// Largest effect of an imbalance of the forces on any line, in standard deviations.
fn imbalance(e: &Evaluation<'_>, difference: &[f64]) -> f64 {
    let mut worst: f64 = 0.0;
    for s in 0..e.layout.sensors {
        for h in 1..=e.lines.order() {
            let at = h as f64 * e.lines.omega;
            let mut sum = Complex64::ZERO;
            for port in 0..=e.layout.ports {
                sum += e.block.at(h, Layout::sensor_row(s), 1 + port)
                    * coefficient(difference, e.order(), port, h);
            }
            worst = worst.max(sum.norm() * at * at / e.lines.deviation[s][h]);
        }
    }
    worst
}

/// Share of the tolerance that a rigid contact is held to: there the imbalance is of held forces and velocities.
const RIGID: f64 = 0.1;

/// Steps without a smaller imbalance after which a balance has no answer from here.
const PATIENCE: usize = 8;

/// Newton's method with a kept factor, renewed where it no longer contracts.
pub(super) fn solve(e: &Evaluation<'_>, kept: &mut RunMemory, tolerance: f64) -> Result<(), f64> {
    let mut scratch = e.grid.scratch();
    if kept.unknowns.len() != e.width() {
        kept.factor = None;
        kept.unknowns = recover(e);
    }
    let tolerance = if e.rigid() { RIGID * tolerance } else { tolerance };
    let mut best = f64::INFINITY;
    let mut fresh = false;
    let mut stale = 0;
    for _ in 0..40 {
        let state = e.evaluate(&kept.unknowns, &mut scratch);
        let answer = e.answer(&state, &mut scratch);
        let difference: Vec<f64> = kept.unknowns.iter().zip(&answer).map(|(x, a)| x - a).collect();
        let left = imbalance(e, &difference);
        if !left.is_finite() {
            kept.unknowns.clear();
            return Err(left);
        }
        if left < tolerance {
            return Ok(());
        }
        let slow = left > 0.3 * best;
        stale = if left < best { 0 } else { stale + 1 };
        if stale > PATIENCE {
            break;
        }
        best = best.min(left);
        if kept.factor.is_none() || (slow && !fresh) {
            let factor = factorise(e, &state, &mut scratch);
            kept.factor = Some((factor, Arc::new(kept.unknowns.clone())));
            fresh = true;
        } else {
            fresh = false;
        }
        let Some((factor, _)) = &kept.factor else { return Err(left) };
        let right = faer::Col::from_fn(difference.len(), |i| difference[i]);
        let step = faer::linalg::solvers::Solve::solve(factor.as_ref(), &right);
        descend(e, kept, &step, left, &mut scratch);
    }
    kept.unknowns.clear();
    Err(best)
}

fn factorise(e: &Evaluation<'_>, state: &State, scratch: &mut frettrace_fourier::GridScratch) -> Factor {
    Arc::new(Tangent::new(e, state, &[]).jacobian(scratch).partial_piv_lu())
}

/// Goes along the step as far as the imbalance does not grow.
fn descend(
    e: &Evaluation<'_>,
    kept: &mut RunMemory,
    step: &faer::Col<f64>,
    left: f64,
    scratch: &mut frettrace_fourier::GridScratch,
) {
    let from = kept.unknowns.clone();
    let mut share = 1.0;
    for _ in 0..6 {
        for (i, (x, old)) in kept.unknowns.iter_mut().zip(&from).enumerate() {
            *x = old - share * step[i];
        }
        let state = e.evaluate(&kept.unknowns, scratch);
        let answer = e.answer(&state, scratch);
        let difference: Vec<f64> = kept.unknowns.iter().zip(&answer).map(|(x, a)| x - a).collect();
        if imbalance(e, &difference) < 1.5 * left {
            return;
        }
        share *= 0.4;
    }
}
