//! Contact forces, slip and fit of one run, with covariance.

use crate::balance::LineBalance;
use crate::calibration::{CalibratedStructure, Equations, generalised_force};
use crate::dynamics::{Dynamics, LineReceptances, Load};
use crate::splines::PeriodicSpline;
use frettrace_fourier::Harmonics;
use num_complex::Complex64;

/// The prior variance of an insignificant line is at least this share of its own variance: what hides below the noise
/// stays possible.
const HIDDEN: f64 = 0.05;

/// What was recovered in the contact, line by line; line 0 is zero throughout, for accelerations do not see means.
#[derive(Clone, Debug)]
pub struct ContactHarmonics {
    /// Friction force (N).
    pub friction: Harmonics,
    /// Slip (m).
    pub slip: Harmonics,
    /// Slip velocity (m/s).
    pub slip_velocity: Harmonics,
    /// Normal force less the preload (N).
    pub normal: Harmonics,
    /// Force of the second support on the beam (N), where one is declared.
    pub second_support: Option<Harmonics>,
    /// Accelerations that the structure makes of all forces (m/s²).
    pub acceleration_fit: Vec<Harmonics>,
}

/// What no contact force at the declared places can explain: the structure or a sensor is at fault, never a friction law.
#[derive(Clone, Debug, Default)]
pub struct BalanceResidual {
    /// Chi-square of each line `1..=H`.
    pub chi_square: Vec<f64>,
    /// Degrees of freedom of each line.
    pub freedom: Vec<usize>,
    /// Residual of each line in standard deviations, one vector of `S` a line.
    pub whitened: Vec<Vec<Complex64>>,
}

impl BalanceResidual {
    /// Chi-square over degrees of freedom of all lines; 1 where the structure explains all but the noise.
    #[must_use]
    pub fn reduced(&self) -> f64 {
        self.chi_square.iter().sum::<f64>() / self.freedom.iter().sum::<usize>().max(1) as f64
    }

    /// The sensor that holds the largest share of the residual, and its share.
    #[must_use]
    pub fn worst_sensor(&self) -> Option<(usize, f64)> {
        let sensors = self.whitened.first()?.len();
        let power = |s: usize| self.whitened.iter().map(|line| line[s].norm_sqr()).sum::<f64>();
        let total: f64 = (0..sensors).map(power).sum();
        let worst = (0..sensors).max_by(|a, b| power(*a).total_cmp(&power(*b)))?;
        Some((worst, power(worst) / total.max(f64::MIN_POSITIVE)))
    }
}

/// The balance of a run.
#[derive(Clone, Debug)]
pub(crate) struct RunBalance {
    pub(crate) contact: ContactHarmonics,
    pub(crate) residual: BalanceResidual,
    /// Lines on which the prior outweighs the data, or a force cannot be told from another.
    pub(crate) regularised: Vec<usize>,
}

/// What a run's balance is made with.
pub(crate) struct Setting<'a> {
    pub(crate) structure: &'a CalibratedStructure,
    pub(crate) dynamics: &'a Dynamics,
    pub(crate) normal_stiffness: f64,
    /// Whether the friction force is smoothed by a periodic spline instead of line by line.
    pub(crate) splines: bool,
}

impl Setting<'_> {
    /// Residual of the balance without any prior on the forces.
    pub(crate) fn residual(&self, run: &Equations<'_>) -> BalanceResidual {
        self.free(run).0
    }

    /// Balance without prior: residual, and force and variance of each unknown and line.
    fn free(&self, run: &Equations<'_>) -> (BalanceResidual, Vec<Vec<(Complex64, f64)>>) {
        let unknowns = run.loads.len();
        let none = vec![f64::INFINITY; unknowns];
        let mut found = BalanceResidual::default();
        let mut powers = vec![Vec::with_capacity(run.order()); unknowns];
        let mut line = LineReceptances::default();
        for h in 1..=run.order() {
            self.dynamics.fill(&self.structure.model, run.lines.force.omega(h), &mut line);
            let balance = LineBalance::solve(&line, &run.data(h), &run.loads, &none);
            let covariance = balance.covariance();
            for (u, power) in powers.iter_mut().enumerate() {
                power.push((balance.forces[u], covariance[u * unknowns + u].re));
            }
            found.chi_square.push(balance.chi_square());
            found.freedom.push(balance.freedom());
            found.whitened.push(balance.residual);
        }
        (found, powers)
    }

    /// Balance with the regularisation: each force of each line has a prior variance drawn from the spectrum itself.
    pub(crate) fn balance(&self, run: &Equations<'_>) -> RunBalance {
        let (residual, powers) = self.free(run);
        let stride = 2 * run.lines.subharmonic_order;
        let priors: Vec<Vec<f64>> = powers.iter().map(|p| prior_variances(p, stride)).collect();
        let smooth = if self.splines { smoothed(run, &powers[0]) } else { None };
        let mut table = Table::new(run, self.dynamics.sensors());
        let mut line = LineReceptances::default();
        let mut regularised = Vec::new();
        for h in 1..=run.order() {
            self.dynamics.fill(&self.structure.model, run.lines.force.omega(h), &mut line);
            let prior: Vec<f64> = priors.iter().map(|p| p[h - 1]).collect();
            let mut balance = LineBalance::solve(&line, &run.data(h), &run.loads, &prior);
            if let Some(smooth) = &smooth {
                balance.forces[0] = smooth.coefficients[h];
            }
            let friction = powers[0][h - 1].1;
            if balance.degenerate || priors[0][h - 1] < friction {
                regularised.push(h);
            }
            let outputs = Outputs { setting: self, run, line: &line, balance: &balance, h };
            outputs.write(&mut table);
        }
        RunBalance { contact: table.finish(run), residual, regularised }
    }
}

/// The lines of the periodic smoothing spline through the friction force.
fn smoothed(run: &Equations<'_>, friction: &[(Complex64, f64)]) -> Option<Harmonics> {
    let base = run.lines.force.base;
    let zero = || std::iter::once((Complex64::ZERO, 0.0));
    let (coefficients, variance) = zero().chain(friction.iter().copied()).unzip();
    PeriodicSpline::from_lines(&Harmonics { base, coefficients, variance })?.lines(run.order(), base)
}

/// Prior variance of each line: the power of the line and of the next two of its parity (friction forces fall with the
/// line and hold odd or even lines), less the noise in it (empirical Bayes).
fn prior_variances(found: &[(Complex64, f64)], stride: usize) -> Vec<f64> {
    (0..found.len())
        .map(|h| {
            let near = || (0..3).filter_map(|i| found.get(h + i * stride)).filter(|(_, v)| v.is_finite());
            let weight = |v: f64| 1.0 / (v * v).max(f64::MIN_POSITIVE);
            let total: f64 = near().map(|(_, v)| weight(*v)).sum();
            let excess: f64 = near().map(|(f, v)| weight(*v) * (f.norm_sqr() - v)).sum();
            let power = if total > 0.0 { excess / total } else { 0.0 };
            // A line that stands out by itself speaks for itself.
            let own = found[h].0.norm_sqr() - found[h].1;
            let alone = if own > 4.0 * found[h].1 { own } else { 0.0 };
            power.max(alone).max(HIDDEN * found[h].1).max(f64::MIN_POSITIVE)
        })
        .collect()
}

/// Values and variances of all outputs, line by line: friction, slip, normal, second support, sensors.
struct Table {
    values: Vec<Vec<Complex64>>,
    variances: Vec<Vec<f64>>,
}

/// Outputs before the sensors: friction, slip, normal, second support.
const FIRST_SENSOR: usize = 4;

impl Table {
    fn new(run: &Equations<'_>, sensors: usize) -> Self {
        let lines = run.order() + 1;
        Self {
            values: vec![vec![Complex64::ZERO; lines]; FIRST_SENSOR + sensors],
            variances: vec![vec![0.0; lines]; FIRST_SENSOR + sensors],
        }
    }

    fn finish(self, run: &Equations<'_>) -> ContactHarmonics {
        let base = run.lines.force.base;
        let mut all = self.values.into_iter().zip(self.variances).map(|(coefficients, variance)| Harmonics {
            base,
            coefficients,
            variance,
        });
        let mut next = || all.next().unwrap_or_else(|| Harmonics::exact(base, Vec::new()));
        let (friction, slip, normal, second) = (next(), next(), next(), next());
        ContactHarmonics {
            slip_velocity: slip.derivative(),
            friction,
            slip,
            normal,
            second_support: run.loads.contains(&Load::SecondSupport).then_some(second),
            acceleration_fit: all.collect(),
        }
    }
}

/// Outputs of one line and how they move with everything that is uncertain.
struct Outputs<'a> {
    setting: &'a Setting<'a>,
    run: &'a Equations<'a>,
    line: &'a LineReceptances,
    balance: &'a LineBalance,
    h: usize,
}

/// A change of the forces and of one mode's coordinate.
struct Change<'a> {
    exciter: Complex64,
    forces: &'a [Complex64],
    mode: Option<(usize, Complex64)>,
}

impl Outputs<'_> {
    fn write(&self, table: &mut Table) {
        let force = self.run.lines.force.coefficients[self.h];
        let here = Change { exciter: force, forces: &self.balance.forces, mode: None };
        for (row, value) in table.values.iter_mut().zip(self.of(&here)) {
            row[self.h] = value;
        }
        let variances = self.variances();
        for (row, value) in table.variances.iter_mut().zip(variances) {
            row[self.h] = value;
        }
    }

    /// All outputs for given forces; they are linear in them.
    fn of(&self, change: &Change<'_>) -> Vec<Complex64> {
        let loads = &self.run.loads;
        let sum = |response: &dyn Fn(Load) -> Complex64| {
            response(Load::Exciter) * change.exciter
                + loads.iter().zip(change.forces).map(|(load, f)| response(*load) * f).sum::<Complex64>()
        };
        let own = |wanted: Load| {
            loads.iter().zip(change.forces).find(|(l, _)| **l == wanted).map_or(Complex64::ZERO, |(_, f)| *f)
        };
        let (mode, motion) = change.mode.unwrap_or((0, Complex64::ZERO));
        let [slip_shape, end_shape] = self.setting.dynamics.contact_shape(mode);
        let slip = sum(&|load| self.line.slip(load)) + motion * slip_shape;
        let end = sum(&|load| self.line.end(load)) + motion * end_shape;
        let normal = own(Load::NormalDeviation) - end * self.setting.normal_stiffness;
        let mut outputs = vec![own(Load::Friction), slip, normal, own(Load::SecondSupport)];
        let inertia = -self.line.omega().powi(2);
        outputs.extend((0..self.setting.dynamics.sensors()).map(|s| {
            sum(&|load| self.line.acceleration(s, load))
                + motion * (inertia * self.setting.dynamics.sensor_shape(mode, s))
        }));
        outputs
    }

    /// Variances from sensor noise and prior, from the noise of the force, and from the structure.
    fn variances(&self) -> Vec<f64> {
        let unknowns = self.run.loads.len();
        let covariance = self.balance.covariance();
        let unit = |u: usize| -> Vec<Complex64> {
            (0..unknowns).map(|i| Complex64::from(f64::from(u8::from(i == u)))).collect()
        };
        let columns: Vec<Vec<Complex64>> = (0..unknowns)
            .map(|u| self.of(&Change { exciter: Complex64::ZERO, forces: &unit(u), mode: None }))
            .collect();
        let mut variances: Vec<f64> = (0..columns[0].len())
            .map(|o| {
                (0..unknowns * unknowns)
                    .map(|e| {
                        let (i, k) = (e / unknowns, e % unknowns);
                        (columns[i][o] * covariance[e] * columns[k][o].conj()).re
                    })
                    .sum()
            })
            .collect();
        let force_variance = self.run.lines.force.variance[self.h];
        for (variance, gain) in variances.iter_mut().zip(self.force_gain()) {
            *variance += gain.norm_sqr() * force_variance;
        }
        self.add_structure(&mut variances);
        variances
    }

    /// Change of the outputs per unit of the excitation force's line, the accelerations being given.
    fn force_gain(&self) -> Vec<Complex64> {
        let sensors = self.setting.dynamics.sensors();
        let change: Vec<Complex64> =
            (0..sensors).map(|s| -self.line.acceleration(s, Load::Exciter)).collect();
        let forces = self.balance.response(&change);
        self.of(&Change { exciter: Complex64::ONE, forces: &forces, mode: None })
    }

    fn add_structure(&self, variances: &mut [f64]) {
        let structure = self.setting.structure;
        let gains: Vec<Vec<Complex64>> =
            (0..2 * structure.modes).map(|p| self.parameter_gain(p / 2, p % 2)).collect();
        let n = gains.len();
        for (o, variance) in variances.iter_mut().enumerate() {
            for (p, gain) in gains.iter().enumerate() {
                let row = &structure.covariance[p * n..(p + 1) * n];
                let along: Complex64 = row.iter().zip(&gains).map(|(c, g)| g[o] * *c).sum();
                *variance += (gain[o].conj() * along).re;
            }
        }
    }

    /// Change of the outputs per unit of `ln ω_n` (`kind` 0) or `ln ζ_n` (1), the measurements being given.
    fn parameter_gain(&self, mode: usize, kind: usize) -> Vec<Complex64> {
        let dynamics = self.setting.dynamics;
        let model = &self.setting.structure.model;
        let force = self.run.lines.force.coefficients[self.h];
        let load = generalised_force(dynamics, mode, force, &self.run.loads, &self.balance.forces);
        let scale = [model.natural_frequency()[mode], model.damping_ratio()[mode]][kind];
        let motion = model.modal_receptance_gradient(mode, self.line.omega())[kind] * scale * load;
        let inertia = self.line.omega().powi(2);
        let change: Vec<Complex64> =
            (0..dynamics.sensors()).map(|s| motion * (inertia * dynamics.sensor_shape(mode, s))).collect();
        let forces = self.balance.response(&change);
        self.of(&Change { exciter: Complex64::ZERO, forces: &forces, mode: Some((mode, motion)) })
    }
}
