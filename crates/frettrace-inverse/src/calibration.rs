//! Calibration of the structure on the balance residual of all runs, with the declared values as priors.

use crate::balance::{LineBalance, LineData};
use crate::dynamics::{Dynamics, LineReceptances, Load};
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
    pub(crate) loads: Vec<Load>,
    /// Variance that an imperfect structure adds to each sensor of each line `1..=H`; empty for none.
    pub(crate) doubt: Vec<Vec<f64>>,
    /// Share `ε²` of a sensor's power that it adds.
    pub(crate) share: f64,
}

impl<'a> Equations<'a> {
    /// Equations of a perfect structure.
    pub(crate) fn new(lines: &'a RunLines, loads: Vec<Load>) -> Self {
        Self { lines, loads, doubt: Vec::new(), share: 0.0 }
    }

    /// Data of a line `h ≥ 1`.
    pub(crate) fn data(&self, line: usize) -> LineData {
        let mut data = LineData {
            force: self.lines.force.coefficients[line],
            force_variance: self.lines.force.variance[line],
            accelerations: self.lines.accelerations.iter().map(|a| a.coefficients[line]).collect(),
            variances: self.lines.accelerations.iter().map(|a| a.variance[line]).collect(),
        };
        if let Some(doubt) = self.doubt.get(line - 1) {
            data.variances.iter_mut().zip(doubt).for_each(|(v, d)| *v += d);
        }
        data
    }

    pub(crate) fn order(&self) -> usize {
        self.lines.force.order()
    }
}

/// Normal equations of one step, and the cost they start from.
struct Step {
    cost: f64,
    matrix: Vec<f64>,
    gradient: Vec<f64>,
}

impl Step {
    fn zero(parameters: usize) -> Self {
        Self { cost: 0.0, matrix: vec![0.0; parameters * parameters], gradient: vec![0.0; parameters] }
    }

    fn add(mut self, other: &Self) -> Self {
        self.cost += other.cost;
        self.matrix.iter_mut().zip(&other.matrix).for_each(|(a, b)| *a += b);
        self.gradient.iter_mut().zip(&other.gradient).for_each(|(a, b)| *a += b);
        self
    }
}

/// Calibrates the trusted modes by Gauss-Newton on the projected residual (variable projection, Kaufman's form).
///
/// Minimises `Σ_lines (4 + d) ln(1 + χ²/4) + Σ_p (θ_p/s_p)²` over `θ = ln(ω_n/ω_n0), ln(ζ_n/ζ_n0)`; the contact forces of
/// every line are eliminated by [`LineBalance`], so that no friction law is needed.
pub(crate) fn calibrate(
    declared: &CalibratedStructure,
    dynamics: &Dynamics,
    runs: &[&Equations<'_>],
) -> CalibratedStructure {
    let problem = Problem { declared, dynamics, runs };
    let mut theta = vec![0.0; 2 * declared.modes];
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
    let known = problem.weighted(&theta, &|weight| weight.min(1.0));
    let covariance = inverse(&known).unwrap_or_else(|| declared.covariance.clone());
    CalibratedStructure { model: problem.model(&theta), covariance, modes: declared.modes, converged }
}

struct Problem<'a> {
    declared: &'a CalibratedStructure,
    dynamics: &'a Dynamics,
    runs: &'a [&'a Equations<'a>],
}

impl Problem<'_> {
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
        let mut total = parts.iter().fold(Step::zero(theta.len()), Step::add);
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
        let mut line = LineReceptances::default();
        let mut columns = vec![vec![Complex64::ZERO; self.dynamics.sensors()]; 2 * modes];
        let free = vec![f64::INFINITY; run.loads.len()];
        for h in 1..=run.order() {
            self.dynamics.fill(model, run.lines.force.omega(h), &mut line);
            let data = run.data(h);
            let balance = LineBalance::solve(&line, &data, &run.loads, &free);
            let (chi, freedom) = (balance.chi_square(), balance.freedom() as f64);
            if freedom == 0.0 {
                continue;
            }
            step.cost += (HEAVY_TAIL + freedom) * (chi / HEAVY_TAIL).ln_1p();
            let weight = weight((HEAVY_TAIL + freedom) / (HEAVY_TAIL + chi));
            let motion = Motion { dynamics: self.dynamics, model, omega: line.omega(), data: &data, run };
            for mode in 0..modes {
                motion.tangents(mode, &balance, &mut columns);
            }
            accumulate(&mut step, &columns, &balance.residual, 2.0 * weight);
        }
        step
    }
}

/// Tangents of one line.
struct Motion<'a> {
    dynamics: &'a Dynamics,
    model: &'a ModalModel,
    omega: f64,
    data: &'a LineData,
    run: &'a Equations<'a>,
}

impl Motion<'_> {
    /// Derivative of the residual with respect to `ln ω_n` and `ln ζ_n`: what the forces cannot take up of
    /// `ω² φ_s ∂g_n p_n`, with the generalised force `p_n` of all loads.
    fn tangents(&self, mode: usize, balance: &LineBalance, columns: &mut [Vec<Complex64>]) {
        let load = generalised_force(self.dynamics, mode, self.data.force, &self.run.loads, &balance.forces);
        let gains = self.model.modal_receptance_gradient(mode, self.omega);
        let scales = [self.model.natural_frequency()[mode], self.model.damping_ratio()[mode]];
        for (kind, (gain, scale)) in gains.into_iter().zip(scales).enumerate() {
            let column = &mut columns[2 * mode + kind];
            let amplitude = gain * scale * load * (self.omega * self.omega);
            for (s, entry) in column.iter_mut().enumerate() {
                *entry = amplitude * self.dynamics.sensor_shape(mode, s);
            }
            balance.leave(column);
        }
    }
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

fn accumulate(step: &mut Step, columns: &[Vec<Complex64>], residual: &[Complex64], weight: f64) {
    let real = |a: &[Complex64], b: &[Complex64]| -> f64 {
        a.iter().zip(b).map(|(x, y)| x.re * y.re + x.im * y.im).sum()
    };
    let n = columns.len();
    for (p, column) in columns.iter().enumerate() {
        step.gradient[p] += weight * real(column, residual);
        for (q, other) in columns.iter().enumerate().skip(p) {
            let product = weight * real(column, other);
            step.matrix[p * n + q] += product;
            if q != p {
                step.matrix[q * n + p] += product;
            }
        }
    }
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
