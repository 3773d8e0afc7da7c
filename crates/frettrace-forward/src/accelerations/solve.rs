//! The contact forces of one run: Newton's method on `f − Φ(R_e F_e − R f) = 0`.

use super::balance::recover;
use super::factor::Factor;
use super::krylov::{self, inner};
use super::linear::Tangent;
use super::run::{Evaluation, State, coefficient};
use super::structure::Layout;
use frettrace_fourier::GridScratch;
use num_complex::Complex64;
use std::sync::Arc;

/// What is kept between evaluations, one a run.
#[derive(Clone, Default)]
pub struct RunMemory {
    pub(super) unknowns: Vec<f64>,
    /// Factor of the derivative of the imbalance, and the unknowns it was taken at.
    pub(super) factor: Option<(Arc<Factor>, Arc<Vec<f64>>)>,
}

impl RunMemory {
    /// Nothing known but the mean of the friction force (N), which no accelerometer sees.
    pub(super) fn with_mean_force(mean: f64) -> Self {
        Self { unknowns: vec![mean], factor: None }
    }

    pub(super) fn is_begun(&self) -> bool {
        !self.unknowns.is_empty()
    }

    /// Begins anew from the accelerations, and from the mean of the friction force that was known. A factor stays beside a mean alone.
    fn begin(&mut self, e: &Evaluation<'_>) {
        let stays = self.unknowns.len() == 1;
        self.factor = self.factor.take().filter(|(_, at)| stays && at.len() == e.width());
        let mean = self.unknowns.first().copied().unwrap_or_default();
        self.unknowns = recover(e);
        self.unknowns[0] = mean;
    }

    pub(super) fn factor_alone(&self) -> Self {
        Self { unknowns: self.unknowns.first().copied().into_iter().collect(), factor: self.factor.clone() }
    }

    pub(super) fn without_factor(&self) -> Self {
        Self { unknowns: self.unknowns.clone(), factor: None }
    }

    /// The solution with one more port, after `ports` others and the contact, that exerts nothing.
    pub(super) fn with_idle_port(&self, ports: usize) -> Self {
        let mut unknowns = self.unknowns.clone();
        unknowns.resize(self.unknowns.len() / (1 + ports) * (2 + ports), 0.0);
        Self { unknowns, factor: None }
    }

    /// The solution with `ports` ports and the contact on lines up to another order: what it has none of holds nothing.
    pub(super) fn on_lines(&self, ports: usize, order: usize) -> Self {
        let known = self.unknowns.len() / (1 + ports);
        let wanted = if known > 1 { 2 * order + 1 } else { known };
        let port = |forces: &[f64]| {
            let mut forces = forces.to_vec();
            forces.resize(wanted, 0.0);
            forces
        };
        let unknowns = self.unknowns.chunks(known.max(1)).flat_map(port).collect();
        Self { unknowns, factor: None }
    }

    /// Whether the factor still belongs to the unknowns: within `1e-3` of their size.
    pub(super) fn current(&self) -> Option<Arc<Factor>> {
        let (factor, at) = self.factor.as_ref()?;
        let (mut change, mut size) = (0.0, 0.0);
        for (x, old) in self.unknowns.iter().zip(at.iter()) {
            change += (x - old) * (x - old);
            size += x * x;
        }
        (at.len() == self.unknowns.len() && change <= 1e-6 * size).then(|| factor.clone())
    }
}

/// Largest effect of some forces on any line, in standard deviations.
fn effect(e: &Evaluation<'_>, forces: &[f64]) -> f64 {
    let mut worst: f64 = 0.0;
    for s in 0..e.layout.sensors {
        for h in 1..=e.lines.order() {
            let at = h as f64 * e.lines.omega;
            let mut sum = Complex64::ZERO;
            for port in 0..=e.layout.ports {
                sum +=
                    e.block.at(h, Layout::sensor_row(s), 1 + port) * coefficient(forces, e.order(), port, h);
            }
            worst = worst.max(sum.norm() * at * at / e.lines.deviation[s][h]);
        }
    }
    worst
}

/// Largest effect of an imbalance of the forces on any line, in standard deviations. Its mean is seen on none, but moves a contact
/// whose friction depends on its place: by a share of its slip, which counts as that share of all forces.
fn imbalance(e: &Evaluation<'_>, (state, unknowns): (&State, &[f64]), difference: &[f64]) -> f64 {
    let left = effect(e, difference);
    if !e.setting.law.depends_on_place() {
        return left;
    }
    let slip = &state.contact.slip;
    let mean = slip.iter().sum::<f64>() / slip.len() as f64;
    let size = (slip.iter().map(|u| (u - mean) * (u - mean)).sum::<f64>() / slip.len() as f64).sqrt();
    let moved = (e.block.at(0, 0, 1).re * difference[0]).abs();
    left.max(moved / size.max(f64::MIN_POSITIVE) * effect(e, unknowns))
}

/// Share of the tolerance that a rigid contact is held to: there the imbalance is of held forces and velocities.
const RIGID: f64 = 0.1;

/// Steps without a smaller imbalance after which a balance has no answer from here, …
const PATIENCE: usize = 8;
/// … and from the step before on a way of many: a shorter one is less dear than patience.
const ON_THE_WAY: usize = 3;

/// Newton's method with a kept factor, renewed where it no longer contracts.
pub(super) fn solve(e: &Evaluation<'_>, kept: &mut RunMemory, tolerance: f64) -> Result<(), f64> {
    if kept.unknowns.len() != e.width() {
        kept.begin(e);
    }
    newton(&Balanced { e, offset: &[] }, kept, (tolerance, PATIENCE))
}

/// First step of the way from the recovered forces to the balance, and the smallest before it is given up.
const STRIDE: [f64; 2] = [0.25, 0.01];

/// Other runs whose solutions are tried as a start.
const NEIGHBOURS: usize = 3;

/// As [`solve`]; where that fails, from the solutions of other runs, and from the recovered forces `f0` by Newton's homotopy: the
/// imbalance `F` is brought from `F(f0)` to nothing along `F(f) = (1 − λ) F(f0)`, each solution the start of the next. Dear:
/// for first solutions only. Where the solution that was kept of a rig with ports leads nowhere, the recovered forces with what the laws of the ports answer to
/// them may lead to the balance in one go; without one, that was tried first.
pub(super) fn approach<'a>(
    e: &Evaluation<'_>,
    kept: &mut RunMemory,
    (others, tolerance): (impl Iterator<Item = &'a RunMemory>, f64),
) -> Result<(), f64> {
    let mean = kept.unknowns.first().copied();
    let came_solved = kept.unknowns.len() == e.width();
    if solve(e, kept, tolerance).is_ok() {
        return Ok(());
    }
    let balanced = Balanced { e, offset: &[] };
    for other in others.filter(|other| other.unknowns.len() == e.width()).take(NEIGHBOURS) {
        *kept = other.clone();
        if newton(&balanced, kept, (tolerance, PATIENCE)).is_ok() {
            return Ok(());
        }
    }
    let begun_anew = |kept: &mut RunMemory| {
        (kept.unknowns, kept.factor) = (mean.into_iter().collect(), None);
        kept.begin(e);
    };
    begun_anew(kept);
    let Err(left) = along_homotopy(e, kept, tolerance) else { return Ok(()) };
    if e.layout.ports == 0 || !came_solved {
        return Err(left);
    }
    begun_anew(kept);
    newton(&balanced, kept, (tolerance, PATIENCE))
}

/// From the kept forces to the balance by Newton's homotopy; they are cleared where it fails.
fn along_homotopy(e: &Evaluation<'_>, kept: &mut RunMemory, tolerance: f64) -> Result<(), f64> {
    let balanced = Balanced { e, offset: &[] };
    let begun = balanced.at(&kept.unknowns, &mut e.grid.scratch()).difference;
    let (mut level, mut stride) = (0.0, STRIDE[0]);
    let mut last = kept.unknowns.clone();
    while level < 1.0 {
        let next: f64 = f64::min(level + stride, 1.0);
        let offset: Vec<f64> = begun.iter().map(|x| (1.0 - next) * x).collect();
        kept.unknowns.clone_from(&last);
        match newton(&Balanced { e, offset: &offset }, kept, (tolerance, ON_THE_WAY)) {
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

/// State at some forces, their imbalance, and its largest effect in standard deviations.
struct Imbalance {
    state: State,
    difference: Vec<f64>,
    left: f64,
}

impl Balanced<'_, '_> {
    fn at(&self, unknowns: &[f64], scratch: &mut GridScratch) -> Imbalance {
        let state = self.e.evaluate(unknowns, scratch);
        let answer = self.e.answer(&state, scratch);
        let mut difference: Vec<f64> = unknowns.iter().zip(&answer).map(|(x, a)| x - a).collect();
        difference.iter_mut().zip(self.offset).for_each(|(d, offset)| *d -= offset);
        let left = imbalance(self.e, (&state, unknowns), &difference);
        Imbalance { state, difference, left }
    }
}

/// Rank-one updates of a kept factor along the steps of a solve (Broyden's good method): with the step `s` and the change `y` of
/// the imbalance, `H ← (I + u sᵀ) H`, `u = (s − Hy)/(sᵀHy)`, so that `Hy = s`.
#[derive(Default)]
struct Updates(Vec<[Vec<f64>; 2]>);

impl Updates {
    /// Applies them to what the factor made of a vector.
    fn apply(&self, x: &mut [f64]) {
        for [u, s] in &self.0 {
            let along = inner(s, x);
            x.iter_mut().zip(u).for_each(|(x, u)| *x += along * u);
        }
    }

    /// Learns that the step `s` changed what the factor makes of the imbalance by `moved`.
    fn learn(&mut self, s: Vec<f64>, mut moved: Vec<f64>) {
        self.apply(&mut moved);
        let along = inner(&s, &moved);
        // A step that the imbalance hardly answers to says nothing safe of the derivative.
        if along.abs() > LEARNT * inner(&s, &s) {
            let u = s.iter().zip(&moved).map(|(s, h)| (s - h) / along).collect();
            self.0.push([u, s]);
        }
    }
}

/// Share of a step that must be found again in its effect for an update of the factor.
const LEARNT: f64 = 0.1;

/// Newton's method from the kept forces; they are cleared where it fails.
fn newton(
    balanced: &Balanced<'_, '_>,
    kept: &mut RunMemory,
    (tolerance, patience): (f64, usize),
) -> Result<(), f64> {
    let e = balanced.e;
    let mut scratch = e.grid.scratch();
    let tolerance = if e.rigid() { RIGID * tolerance } else { tolerance };
    let mut updates = Updates::default();
    let mut at = balanced.at(&kept.unknowns, &mut scratch);
    let (mut best, mut slow, mut stale) = (f64::INFINITY, 0, 0);
    // What the factor makes of the imbalance before the last step.
    let mut before: Option<(Vec<f64>, Vec<f64>)> = None;
    for _ in 0..40 {
        let left = at.left;
        if !left.is_finite() {
            kept.unknowns.clear();
            return Err(left);
        }
        if left < tolerance {
            return Ok(());
        }
        stale = if left < best { 0 } else { stale + 1 };
        if stale > patience {
            break;
        }
        slow = if left > 0.3 * best { slow + 1 } else { 0 };
        best = best.min(left);
        if slow > SLOW
            && e.width() > WIDE
            && let Some((factor, _)) = &kept.factor
            && let Some(step) = by_products(e, (&at, factor), &mut scratch)
        {
            before = None;
            at = descend(balanced, kept, (&step, left), &mut scratch);
            continue;
        }
        if kept.factor.is_none() || slow > SLOW {
            let factor = factorise(e, &at.state);
            kept.factor = Some((factor, Arc::new(kept.unknowns.clone())));
            (updates, before, slow) = (Updates::default(), None, 0);
        }
        let Some((factor, _)) = &kept.factor else { return Err(left) };
        let plain = factor.solve(&at.difference);
        if let Some((from, made)) = before.take() {
            let s = kept.unknowns.iter().zip(&from).map(|(x, old)| x - old).collect();
            updates.learn(s, plain.iter().zip(&made).map(|(new, old)| new - old).collect());
        }
        let mut step = plain.clone();
        updates.apply(&mut step);
        before = Some((kept.unknowns.clone(), plain));
        at = descend(balanced, kept, (&step, left), &mut scratch);
    }
    kept.unknowns.clear();
    Err(best)
}

/// Steps in a row that leave more than three tenths of the imbalance before the factor is renewed: its updates get that many.
const SLOW: usize = 2;

/// Unknowns from which a derivative is dear: a new factor takes as long as some tens of its products.
const WIDE: usize = 600;
/// Share of the imbalance that a step of [`by_products`] leaves, to first order, and the products it may take.
const PRODUCTS: (f64, usize) = (0.1, 60);

/// Newton's step with the derivative where it stands, whatever the kept factor was taken at; `None` where that is too far away.
fn by_products(
    e: &Evaluation<'_>,
    (at, factor): (&Imbalance, &Factor),
    scratch: &mut GridScratch,
) -> Option<Vec<f64>> {
    let tangent = Tangent::new(e, &at.state, &[]);
    let product = |x: &[f64]| factor.solve(&tangent.product(x, scratch));
    krylov::solve(product, factor.solve(&at.difference), PRODUCTS)
}

fn factorise(e: &Evaluation<'_>, state: &State) -> Arc<Factor> {
    Arc::new(Factor::new(Tangent::new(e, state, &[]).jacobian()))
}

/// Goes along the step as far as the imbalance does not grow.
fn descend(
    balanced: &Balanced<'_, '_>,
    kept: &mut RunMemory,
    (step, left): (&[f64], f64),
    scratch: &mut GridScratch,
) -> Imbalance {
    let from = kept.unknowns.clone();
    let mut share = 1.0;
    loop {
        for ((x, old), step) in kept.unknowns.iter_mut().zip(&from).zip(step) {
            *x = old - share * step;
        }
        let at = balanced.at(&kept.unknowns, scratch);
        if at.left < 1.5 * left || share < SHORTEST {
            return at;
        }
        share *= 0.4;
    }
}

/// Share of a step that is taken whatever comes of it: the sixth.
const SHORTEST: f64 = 0.02;

#[cfg(test)]
mod tests {
    use super::{RunMemory, Updates};

    /// A contact and one port of order 1 on orders 2 and 0; a mean that is known alone stays alone, and is all that a factor alone keeps.
    #[test]
    fn harmonics_stay_on_their_lines() {
        let of = |unknowns: &[f64]| RunMemory { unknowns: unknowns.to_vec(), factor: None };
        let known = of(&[1.0, 2.0, 3.0, 4.0, 5.0, 6.0]);
        assert_eq!(known.on_lines(1, 2).unknowns, [1.0, 2.0, 3.0, 0.0, 0.0, 4.0, 5.0, 6.0, 0.0, 0.0]);
        assert_eq!(known.on_lines(1, 0).unknowns, [1.0, 4.0]);
        assert_eq!(of(&[7.0]).on_lines(0, 2).unknowns, [7.0]);
        assert!(of(&[]).on_lines(1, 2).unknowns.is_empty());
        assert_eq!(known.factor_alone().unknowns, [1.0]);
        assert!(of(&[]).factor_alone().unknowns.is_empty());
    }

    /// With the factor 1 of the derivative A = ((2, 1), (0, 4)): after two steps along the axes the updated inverse is that of A,
    /// `H (A s) = s` for every step.
    #[test]
    fn updates_learn_what_the_steps_show() {
        let derivative = |s: &[f64]| vec![2.0 * s[0] + s[1], 4.0 * s[1]];
        let steps = [[0.3, 0.0], [0.0, -0.2]];
        let mut updates = Updates::default();
        for step in steps {
            updates.learn(step.to_vec(), derivative(&step));
        }
        for step in steps.into_iter().chain([[0.7, -1.1]]) {
            let mut found = derivative(&step);
            updates.apply(&mut found);
            assert!(found.iter().zip(step).all(|(a, b)| (a - b).abs() < 1e-14), "{found:?} {step:?}");
        }
        // A step that the imbalance answers to only across it teaches nothing.
        let mut untaught = Updates::default();
        untaught.learn(vec![1.0, 0.0], vec![0.0, 1.0]);
        assert!(untaught.0.is_empty());
    }
}
