//! Calibration of the structure on the balance residual of all runs, with the declared values as priors.

use crate::balance::{LineBalance, LineData};
use crate::dynamics::{Dynamics, FixedReceptances, LineReceptances, Load};
use crate::{ModeTrust, RunLines};
use faer::prelude::Solve;
use faer::{Col, Mat, Side};
use frettrace_beam::ModalModel;
use num_complex::Complex64;
use rayon::prelude::*;

/// Degrees of freedom of the Student distribution of a line's residual: a line the structure cannot explain (lift-off, a
/// wrong sensor) loses its weight instead of bending the structure.
const HEAVY_TAIL: f64 = 4.0;
const MOST_STEPS: usize = 20;
/// Steps smaller than this share of the standard deviation of every parameter end the calibration.
const CONVERGED: f64 = 1e-3;

/// The structure after calibration.
///
/// Parameters are ordered `ln ω_1, ln ζ_1, ln ω_2, …` of the trusted modes.
#[derive(Clone, Debug)]
pub struct CalibratedStructure {
    /// The beam with calibrated modes.
    pub model: ModalModel,
    /// Covariance of the parameters, row-major.
    pub covariance: Vec<f64>,
    /// Number of calibrated modes.
    pub modes: usize,
    /// Whether the calibration converged.
    pub converged: bool,
}

impl CalibratedStructure {
    /// The structure as declared, as uncertain as declared.
    #[must_use]
    pub fn declared(model: ModalModel, trust: &[ModeTrust]) -> Self {
        let n = 2 * trust.len();
        let mut covariance = vec![0.0; n * n];
        for (i, std) in trust.iter().flat_map(|t| [t.frequency, t.damping]).enumerate() {
            covariance[i * n + i] = std * std;
        }
        Self { model, covariance, modes: trust.len(), converged: true }
    }

    /// Relative standard deviation of the natural frequency of a mode, 0 where it is not calibrated.
    #[must_use]
    pub fn frequency_std(&self, mode: usize) -> f64 {
        self.relative_std(2 * mode)
    }

    /// Relative standard deviation of the damping ratio of a mode, 0 where it is not calibrated.
    #[must_use]
    pub fn damping_std(&self, mode: usize) -> f64 {
        self.relative_std(2 * mode + 1)
    }

    /// Independent sources of the parameters' errors: `δθ = Σ_p ξ_p r_p` with standard normal `ξ_p`, `Σ_p r_p r_pᵀ` the covariance.
    #[must_use]
    pub fn roots(&self) -> Vec<Vec<f64>> {
        let n = 2 * self.modes;
        if n == 0 {
            return Vec::new();
        }
        let Ok(eigen) = Mat::from_fn(n, n, |i, k| self.covariance[i * n + k]).self_adjoint_eigen(Side::Lower)
        else {
            return Vec::new();
        };
        let root = |p: usize| (0..n).map(|i| eigen.U()[(i, p)] * eigen.S()[p].max(0.0).sqrt()).collect();
        (0..n).map(root).collect()
    }

    fn relative_std(&self, parameter: usize) -> f64 {
        let n = 2 * self.modes;
        if parameter < n { self.covariance[parameter * n + parameter].max(0.0).sqrt() } else { 0.0 }
    }
}

/// Lines of a run with the loads that are unknown in it.
pub(crate) struct Equations<'a> {
    pub(crate) lines: &'a RunLines,
    pub(crate) fixed: &'a FixedReceptances,
    pub(crate) loads: Vec<Load>,
    /// Data of the lines `1..=H`: asked for in every step of a calibration.
    data: Vec<LineData>,
    /// Share `ε²` of a sensor's power that an imperfect structure adds to its variance; `None` until it is known.
    doubt: Option<f64>,
}

impl<'a> Equations<'a> {
    /// Equations of a perfect structure.
    pub(crate) fn new((lines, fixed): (&'a RunLines, &'a FixedReceptances), loads: Vec<Load>) -> Self {
        let data = (1..=lines.force.order()).map(|h| LineData::of(lines, h)).collect();
        Self { lines, fixed, loads, data, doubt: None }
    }

    /// The same run with other loads, of a perfect structure.
    pub(crate) fn with_loads(&self, loads: Vec<Load>) -> Self {
        Self::new((self.lines, self.fixed), loads)
    }

    /// Receptances of all lines `1..=H`.
    pub(crate) fn receptances(&self, dynamics: &Dynamics, model: &ModalModel) -> Vec<LineReceptances> {
        let line = |h: usize| {
            let mut line = LineReceptances::default();
            dynamics.fill_upon(model, self.fixed, h, &mut line);
            line
        };
        (1..=self.order()).map(line).collect()
    }

    /// Adds the share `ε²` of the powers of each sensor of each line `1..=H` to their variances.
    pub(crate) fn doubt(&mut self, share: f64, powers: &[Vec<f64>]) {
        self.doubt = Some(share);
        for (data, powers) in self.data.iter_mut().zip(powers) {
            data.variances.iter_mut().zip(powers).for_each(|(v, p)| *v += share * p);
        }
    }

    /// Share `ε²` of a sensor's power that an imperfect structure adds to its variance.
    pub(crate) fn share(&self) -> f64 {
        self.doubt.unwrap_or(0.0)
    }

    /// Whether the data hold no doubt of the structure.
    pub(crate) fn is_plain(&self) -> bool {
        self.doubt.is_none()
    }

    /// Data of a line `h ≥ 1`.
    pub(crate) fn data(&self, line: usize) -> &LineData {
        &self.data[line - 1]
    }

    pub(crate) fn order(&self) -> usize {
        self.lines.force.order()
    }
}

impl LineData {
    /// Data of a line `h ≥ 1` of a run.
    pub(crate) fn of(lines: &RunLines, line: usize) -> Self {
        Self {
            force: lines.force.coefficients[line],
            force_variance: lines.force.variance[line],
            accelerations: lines.accelerations.iter().map(|a| a.coefficients[line]).collect(),
            variances: lines.accelerations.iter().map(|a| a.variance[line]).collect(),
        }
    }
}

/// Normal equations of one step, and the cost they start from.
#[derive(Clone)]
pub(crate) struct Step {
    cost: f64,
    pub(crate) matrix: Vec<f64>,
    pub(crate) gradient: Vec<f64>,
}

impl Step {
    pub(crate) fn zero(parameters: usize) -> Self {
        Self { cost: 0.0, matrix: vec![0.0; parameters * parameters], gradient: vec![0.0; parameters] }
    }

    pub(crate) fn add(mut self, other: &Self) -> Self {
        self.cost += other.cost;
        self.matrix.iter_mut().zip(&other.matrix).for_each(|(a, b)| *a += b);
        self.gradient.iter_mut().zip(&other.gradient).for_each(|(a, b)| *a += b);
        self
    }

    /// The triangle below the diagonal from the one above.
    fn mirrored(mut self) -> Self {
        let n = self.gradient.len();
        for p in 0..n {
            for q in 0..p {
                self.matrix[p * n + q] = self.matrix[q * n + p];
            }
        }
        self
    }
}

/// The covariance of the parameters at a calibrated structure, row-major; as declared where the runs determine none.
pub(crate) fn covariance(
    (declared, at): (&CalibratedStructure, &CalibratedStructure),
    dynamics: &Dynamics,
    runs: &[&Equations<'_>],
) -> Vec<f64> {
    let problem = Problem { declared, dynamics, runs };
    let known = problem.weighted(&problem.parameters(&at.model), &|weight| weight.min(1.0));
    inverse(&known).unwrap_or_else(|| declared.covariance.clone())
}

/// Calibrates the trusted modes by Gauss-Newton on the projected residual (variable projection, Kaufman's form).
///
/// Minimises `Σ_lines (4 + d) ln(1 + χ²/4) + Σ_p (θ_p/s_p)²` over `θ = ln(ω_n/ω_n0), ln(ζ_n/ζ_n0)`; the contact forces of
/// every line are eliminated by [`LineBalance`], so that no friction law is needed. Begins at the parameters `from`. The covariance is left
/// as declared: [`covariance`] takes another pass, and only the last calibration needs it.
pub(crate) fn calibrate(
    (declared, from): (&CalibratedStructure, &CalibratedStructure),
    dynamics: &Dynamics,
    runs: &[&Equations<'_>],
) -> CalibratedStructure {
    let problem = Problem { declared, dynamics, runs };
    let mut theta = problem.parameters(&from.model);
    let mut step = problem.step(&theta);
    let mut converged = false;
    for _ in 0..MOST_STEPS {
        let Some(change) = solve(&step) else { break };
        let Some((next, better)) = problem.descend(&theta, &step, &change) else {
            converged = true;
            break;
        };
        let small = change
            .iter()
            .enumerate()
            .all(|(p, d)| d.abs() < CONVERGED * step.matrix[p * theta.len() + p].sqrt().recip());
        (theta, step) = (next, better);
        if small {
            converged = true;
            break;
        }
    }
    CalibratedStructure { model: problem.model(&theta), converged, ..declared.clone() }
}

/// Calibrates the trusted modes in a few Gauss-Newton steps on the normal equations that `slopes` gives of a structure, the values that are known as
/// priors with their own deviations. No step is shortened: what comes of it must be asked of the balance.
pub(crate) fn calibrate_by(
    known: &CalibratedStructure,
    dynamics: &Dynamics,
    slopes: impl Fn(&CalibratedStructure) -> Step,
) -> Option<CalibratedStructure> {
    let problem = Problem { declared: known, dynamics, runs: &[] };
    let mut at = known.clone();
    for _ in 0..FEW_STEPS {
        let mut theta = problem.parameters(&at.model);
        let step = problem.beside_prior(&theta, slopes(&at));
        let change = solve(&step)?;
        let n = theta.len();
        let moves = |(p, d): (usize, &f64)| d.abs() > SETTLED * step.matrix[p * n + p].sqrt().recip();
        let converged = !change.iter().enumerate().any(moves);
        theta.iter_mut().zip(&change).for_each(|(theta, d)| *theta += d);
        let covariance = inverse(&step)?;
        at = CalibratedStructure { model: problem.model(&theta), covariance, converged, modes: known.modes };
        if converged {
            break;
        }
    }
    Some(at)
}

/// Most steps of a calibration on whole spectra, …
const FEW_STEPS: usize = 4;
/// … and the share of every parameter's deviation below which a step ends it.
const SETTLED: f64 = 0.1;

struct Problem<'a> {
    declared: &'a CalibratedStructure,
    dynamics: &'a Dynamics,
    runs: &'a [&'a Equations<'a>],
}

impl Problem<'_> {
    /// Parameters of a model: logarithms over what is declared.
    fn parameters(&self, model: &ModalModel) -> Vec<f64> {
        let declared = &self.declared.model;
        let mode = |n: usize| {
            let frequency = model.natural_frequency()[n] / declared.natural_frequency()[n];
            let damping = model.damping_ratio()[n] / declared.damping_ratio()[n];
            // A mode without damping has none to calibrate.
            [frequency.ln(), if damping > 0.0 && damping.is_finite() { damping.ln() } else { 0.0 }]
        };
        (0..self.declared.modes).flat_map(mode).collect()
    }

    fn model(&self, theta: &[f64]) -> ModalModel {
        let mut model = self.declared.model.clone();
        for mode in 0..self.declared.modes {
            let frequency = model.natural_frequency()[mode] * theta[2 * mode].exp();
            // Beyond critical damping there is no mode to calibrate.
            let damping = (model.damping_ratio()[mode] * theta[2 * mode + 1].exp()).min(0.9);
            model.set_mode(mode, frequency, damping);
        }
        model
    }

    /// The first of the full, halved, … steps that lowers the cost.
    fn descend(&self, theta: &[f64], from: &Step, change: &[f64]) -> Option<(Vec<f64>, Step)> {
        let mut share = 1.0;
        for _ in 0..6 {
            let next: Vec<f64> = theta.iter().zip(change).map(|(t, d)| t + share * d).collect();
            let step = self.step(&next);
            if step.cost < from.cost {
                return Some((next, step));
            }
            share *= 0.5;
        }
        None
    }

    fn step(&self, theta: &[f64]) -> Step {
        self.weighted(theta, &|weight| weight)
    }

    /// Normal equations with other weights of the lines. A line that fits better than it need is not known better: the covariance is that
    /// of weights of at most one.
    fn weighted(&self, theta: &[f64], weight: &(dyn Fn(f64) -> f64 + Sync)) -> Step {
        let model = self.model(theta);
        let parts: Vec<Step> = self.runs.par_iter().map(|run| self.run_step(&model, run, weight)).collect();
        self.beside_prior(theta, parts.iter().fold(Step::zero(theta.len()), Step::add))
    }

    /// With what is declared.
    fn beside_prior(&self, theta: &[f64], mut total: Step) -> Step {
        for (p, value) in theta.iter().enumerate() {
            let precision = 1.0 / self.declared.covariance[p * theta.len() + p];
            total.cost += precision * value * value;
            total.gradient[p] += precision * value;
            total.matrix[p * theta.len() + p] += precision;
        }
        total
    }

    fn run_step(&self, model: &ModalModel, run: &Equations<'_>, weight: &dyn Fn(f64) -> f64) -> Step {
        let modes = self.declared.modes;
        let mut step = Step::zero(2 * modes);
        let (mut line, mut balance) = (LineReceptances::default(), LineBalance::default());
        let mut tangents = Tangents::new(self.dynamics, modes, run.loads.len());
        let free = vec![f64::INFINITY; run.loads.len()];
        for h in 1..=run.order() {
            self.dynamics.fill_sensors_upon(model, run.fixed, h, &mut line);
            let data = run.data(h);
            balance.renew(&line, data, &run.loads, &free);
            let (chi, freedom) = (balance.chi_square(), balance.freedom() as f64);
            if freedom == 0.0 {
                continue;
            }
            step.cost += (HEAVY_TAIL + freedom) * (chi / HEAVY_TAIL).ln_1p();
            let weight = weight((HEAVY_TAIL + freedom) / (HEAVY_TAIL + chi));
            tangents.fill(self.dynamics, &balance);
            let omega = line.omega();
            for mode in 0..modes {
                let load = generalised_force(self.dynamics, mode, data.force, &run.loads, &balance.forces);
                let scales = [model.natural_frequency()[mode], model.damping_ratio()[mode]];
                let gains = model.modal_receptance_gradient(mode, omega);
                for kind in 0..2 {
                    tangents.amplitudes[2 * mode + kind] =
                        gains[kind] * scales[kind] * load * (omega * omega);
                }
            }
            tangents.accumulate(&mut step, 2.0 * weight);
        }
        step.mirrored()
    }
}

/// Tangents of one line's residual: `z_p ψ_n`, with the part `ψ_n` of a shape that the forces cannot take up, and the amplitude
/// `z = ω² ∂g_n p_n` by `ln ω_n` or `ln ζ_n` under the generalised force `p_n`. Both parameters of a mode share its shape, so that
/// products are formed of shapes, and scaled.
struct Tangents {
    modes: usize,
    loads: usize,
    /// Shapes at the sensors under the weights of the line, a row each mode.
    shapes: Vec<f64>,
    /// Coordinates of the shapes along the forces, a row each mode.
    taken: Vec<Complex64>,
    /// Products `ψ_nᴴ ψ_m` for `m ≥ n`, and `ψ_nᴴ r` with the residual.
    products: Vec<Complex64>,
    along: Vec<Complex64>,
    amplitudes: Vec<Complex64>,
}

impl Tangents {
    fn new(dynamics: &Dynamics, modes: usize, loads: usize) -> Self {
        let zero = |n: usize| vec![Complex64::ZERO; n];
        Self {
            modes,
            loads,
            shapes: vec![0.0; modes * dynamics.sensors()],
            taken: zero(modes * loads),
            products: zero(modes * modes),
            along: zero(modes),
            amplitudes: zero(2 * modes),
        }
    }

    /// Products of the shapes under the weights of a line.
    fn fill(&mut self, dynamics: &Dynamics, balance: &LineBalance) {
        let (loads, sensors) = (self.loads, dynamics.sensors());
        for n in 0..self.modes {
            let shape = &mut self.shapes[n * sensors..(n + 1) * sensors];
            let plain = dynamics.sensor_shapes(n).iter().zip(balance.weights());
            shape.iter_mut().zip(plain).for_each(|(whitened, (x, w))| *whitened = x * w);
            balance.taken_up(shape, &mut self.taken[n * loads..(n + 1) * loads]);
            self.along[n] = shape.iter().zip(&balance.residual).map(|(x, r)| r * x).sum();
        }
        let parts = || self.shapes.chunks_exact(sensors).zip(self.taken.chunks_exact(loads));
        let rows = self.products.chunks_exact_mut(self.modes.max(1));
        for (n, (row, (shape, taken))) in rows.zip(parts()).enumerate() {
            for (entry, (other, along)) in row.iter_mut().zip(parts()).skip(n) {
                let along: Complex64 = taken.iter().zip(along).map(|(a, b)| a.conj() * b).sum();
                *entry = inner(shape, other) - along;
            }
        }
    }

    /// Adds a line to the blocks of two rows and two columns a pair of modes on the diagonal and above it.
    fn accumulate(&self, step: &mut Step, weight: f64) {
        let (pairs, _) = self.amplitudes.as_chunks::<2>();
        let rows = step.matrix.chunks_exact_mut(2 * self.amplitudes.len().max(1));
        for (n, (rows, pair)) in rows.zip(pairs).enumerate() {
            let scaled = pair.map(|z| z.conj() * weight);
            for (gradient, z) in step.gradient[2 * n..].iter_mut().zip(scaled) {
                *gradient += (z * self.along[n]).re;
            }
            let (first, second) = rows.split_at_mut(self.amplitudes.len());
            let products = self.products[n * self.modes..].iter().zip(pairs).skip(n);
            let entries = first[2 * n..].chunks_exact_mut(2).zip(second[2 * n..].chunks_exact_mut(2));
            for ((product, others), (first, second)) in products.zip(entries) {
                for (q, other) in others.iter().enumerate() {
                    let right = product * other;
                    first[q] += scaled[0].re * right.re - scaled[0].im * right.im;
                    second[q] += scaled[1].re * right.re - scaled[1].im * right.im;
                }
            }
        }
    }
}

/// `Σ x_s y_s` of a few sensors, two at a time.
fn inner(x: &[f64], y: &[f64]) -> f64 {
    let ((pairs, x), (others, y)) = (x.as_chunks::<2>(), y.as_chunks::<2>());
    let [first, second] =
        pairs.iter().zip(others).fold([0.0; 2], |sum, (x, y)| [sum[0] + x[0] * y[0], sum[1] + x[1] * y[1]]);
    first + second + x.iter().zip(y).map(|(x, y)| x * y).sum::<f64>()
}

/// Generalised force `φ_e F_e + Σ_u φ_u f_u` of a mode.
pub(crate) fn generalised_force(
    dynamics: &Dynamics,
    mode: usize,
    force: Complex64,
    loads: &[Load],
    forces: &[Complex64],
) -> Complex64 {
    let exciter = force * dynamics.load_shape(mode, Load::Exciter);
    loads.iter().zip(forces).map(|(load, f)| f * dynamics.load_shape(mode, *load)).sum::<Complex64>()
        + exciter
}

fn factor(step: &Step) -> Option<faer::linalg::solvers::Llt<f64>> {
    let n = step.gradient.len();
    if n == 0 {
        return None;
    }
    Mat::from_fn(n, n, |i, k| step.matrix[i * n + k]).llt(Side::Lower).ok()
}

fn solve(step: &Step) -> Option<Vec<f64>> {
    let change = factor(step)?.solve(Col::from_fn(step.gradient.len(), |i| -step.gradient[i]));
    Some((0..change.nrows()).map(|i| change[i]).collect())
}

fn inverse(step: &Step) -> Option<Vec<f64>> {
    let n = step.gradient.len();
    let inverse = factor(step)?.solve(Mat::<f64>::identity(n, n));
    Some((0..n * n).map(|e| inverse[(e / n, e % n)]).collect())
}
