//! The contact forces of one run: Newton's method on `f − Φ(R_e F_e − R f) = 0`.

use super::balance::recover;
use super::linear::Tangent;
use super::run::{Evaluation, State, coefficient};
use super::structure::Layout;
use frettrace_fourier::GridScratch;
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
    if kept.unknowns.len() != e.width() {
        kept.factor = None;
        kept.unknowns = recover(e);
    }
    newton(&Balanced { e, offset: &[] }, kept, tolerance)
}

/// First step of the way from the recovered forces to the balance, and the smallest before it is given up.
const STRIDE: [f64; 2] = [0.25, 0.01];

/// Other runs whose solutions are tried as a start.
const NEIGHBOURS: usize = 3;

/// As [`solve`]; where that fails, from the solutions of other runs, and from the recovered forces `f0` by Newton's homotopy: the
/// imbalance `F` is brought from `F(f0)` to nothing along `F(f) = (1 − λ) F(f0)`, each solution the start of the next. Dear:
/// for first solutions only.
pub(super) fn approach<'a>(
    e: &Evaluation<'_>,
    kept: &mut RunMemory,
    (others, tolerance): (impl Iterator<Item = &'a RunMemory>, f64),
) -> Result<(), f64> {
    if solve(e, kept, tolerance).is_ok() {
        return Ok(());
    }
    let balanced = Balanced { e, offset: &[] };
    for other in others.filter(|other| other.unknowns.len() == e.width()).take(NEIGHBOURS) {
        *kept = other.clone();
        if newton(&balanced, kept, tolerance).is_ok() {
            return Ok(());
        }
    }
    kept.factor = None;
    kept.unknowns = recover(e);
    let begun = balanced.at(&kept.unknowns, &mut e.grid.scratch()).1;
    let (mut level, mut stride) = (0.0, STRIDE[0]);
    let mut last = kept.unknowns.clone();
    while level < 1.0 {
        let next: f64 = f64::min(level + stride, 1.0);
        let offset: Vec<f64> = begun.iter().map(|x| (1.0 - next) * x).collect();
        kept.unknowns.clone_from(&last);
        match newton(&Balanced { e, offset: &offset }, kept, tolerance) {
            Ok(()) => {
                (level, stride) = (next, 1.5 * stride);
                last.clone_from(&kept.unknowns);
            }
            Err(left) if stride < STRIDE[1] => {
                kept.unknowns.clear();
                return Err(left);
            }
            Err(_) => stride /= 3.0,
        }
    }
    Ok(())
}

/// An imbalance that is to be as large as stated; balanced where nothing is.
struct Balanced<'a, 'b> {
    e: &'a Evaluation<'b>,
    offset: &'a [f64],
}

impl Balanced<'_, '_> {
    /// State and imbalance at the given forces.
    fn at(&self, unknowns: &[f64], scratch: &mut GridScratch) -> (State, Vec<f64>) {
        let state = self.e.evaluate(unknowns, scratch);
        let answer = self.e.answer(&state, scratch);
        let mut difference: Vec<f64> = unknowns.iter().zip(&answer).map(|(x, a)| x - a).collect();
        difference.iter_mut().zip(self.offset).for_each(|(d, offset)| *d -= offset);
        (state, difference)
    }
}

/// Newton's method from the kept forces; they are cleared where it fails.
fn newton(balanced: &Balanced<'_, '_>, kept: &mut RunMemory, tolerance: f64) -> Result<(), f64> {
    let e = balanced.e;
    let mut scratch = e.grid.scratch();
    let tolerance = if e.rigid() { RIGID * tolerance } else { tolerance };
    let mut best = f64::INFINITY;
    let mut fresh = false;
    let mut stale = 0;
    for _ in 0..40 {
        let (state, difference) = balanced.at(&kept.unknowns, &mut scratch);
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
        descend(balanced, kept, (&step, left), &mut scratch);
    }
    kept.unknowns.clear();
    Err(best)
}

fn factorise(e: &Evaluation<'_>, state: &State, scratch: &mut GridScratch) -> Factor {
    Arc::new(Tangent::new(e, state, &[]).jacobian(scratch).partial_piv_lu())
}

/// Goes along the step as far as the imbalance does not grow.
fn descend(
    balanced: &Balanced<'_, '_>,
    kept: &mut RunMemory,
    (step, left): (&faer::Col<f64>, f64),
    scratch: &mut GridScratch,
) {
    let from = kept.unknowns.clone();
    let mut share = 1.0;
    for _ in 0..6 {
        for (i, (x, old)) in kept.unknowns.iter_mut().zip(&from).enumerate() {
            *x = old - share * step[i];
        }
        let (_, difference) = balanced.at(&kept.unknowns, scratch);
        if imbalance(balanced.e, &difference) < 1.5 * left {
            return;
        }
        share *= 0.4;
    }
}
