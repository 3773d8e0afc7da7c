//! Contact forces, slip and fit of one run, with covariance.

mod outputs;
mod prior;

use crate::balance::LineBalance;
use crate::calibration::{CalibratedStructure, Equations};
use crate::dynamics::{Dynamics, LineReceptances, Load};
use crate::splines::PeriodicSpline;
use frettrace_fourier::Harmonics;
use num_complex::Complex64;
pub(crate) use outputs::COMPLIANCE_DOUBT;
use outputs::Outputs;
use std::sync::OnceLock;

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
    /// Errors that the lines of a quantity have in common.
    pub shared: SharedErrors,
}

/// Errors that all lines of a quantity have in common, for they come from the structure: `Σ_p ξ_p Re Σ_h g_ph e^{ihΩt}` with
/// independent standard normal `ξ_p`. They are part of the variances of the lines; in a time series they make a band that
/// breathes with the signal. One vector of `H + 1` coefficients a source `p`.
#[derive(Clone, Debug, Default)]
pub struct SharedErrors {
    /// Of the friction force (N).
    pub friction: Vec<Vec<Complex64>>,
    /// Of the slip (m).
    pub slip: Vec<Vec<Complex64>>,
    /// Of the slip velocity (m/s).
    pub slip_velocity: Vec<Vec<Complex64>>,
    /// Of the normal force (N).
    pub normal: Vec<Vec<Complex64>>,
    /// Of the force of the second support (N).
    pub second_support: Vec<Vec<Complex64>>,
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
    /// What [`CalibratedStructure::roots`] says: the same for all runs.
    pub(crate) roots: OnceLock<Vec<Vec<f64>>>,
}

impl Setting<'_> {
    /// Independent sources of the errors of the structure's parameters.
    pub(crate) fn roots(&self) -> &[Vec<f64>] {
        self.roots.get_or_init(|| self.structure.roots())
    }

    /// Residual of the balance without any prior on the forces.
    pub(crate) fn residual(&self, run: &Equations<'_>) -> BalanceResidual {
        self.free(run, &run.receptances(self.dynamics, &self.structure.model)).0
    }

    /// Balance without prior: residual, and force and variance of each unknown and line.
    fn free(
        &self,
        run: &Equations<'_>,
        receptances: &[LineReceptances],
    ) -> (BalanceResidual, Vec<Vec<(Complex64, f64)>>) {
        let unknowns = run.loads.len();
        let none = vec![f64::INFINITY; unknowns];
        let mut found = BalanceResidual::default();
        let mut powers = vec![Vec::with_capacity(run.order()); unknowns];
        let mut balance = LineBalance::default();
        for (line, h) in receptances.iter().zip(1..) {
            balance.renew(line, run.data(h), &run.loads, &none);
            let covariance = balance.covariance();
            for (u, power) in powers.iter_mut().enumerate() {
                power.push((balance.forces[u], covariance[u * unknowns + u].re));
            }
            found.chi_square.push(balance.chi_square());
            found.freedom.push(balance.freedom());
            found.whitened.push(balance.residual.clone());
        }
        (found, powers)
    }

    /// Balance with the regularisation: each force of each line has a prior variance drawn from the spectrum itself.
    pub(crate) fn balance(&self, run: &Equations<'_>) -> RunBalance {
        let receptances = run.receptances(self.dynamics, &self.structure.model);
        let (residual, plain, powers) = if run.is_plain() {
            let (residual, plain) = self.free(run, &receptances);
            (residual, plain.clone(), plain)
        } else {
            let (residual, plain) = self.free(&run.with_loads(run.loads.clone()), &receptances);
            (residual, plain, self.free(run, &receptances).1)
        };
        let stride = 2 * run.lines.subharmonic_order;
        let priors: Vec<Vec<f64>> = plain
            .iter()
            .zip(&powers)
            .map(|(plain, doubted)| prior::widened(plain, doubted, stride))
            .collect();
        let smooth = if self.splines { smoothed(run, &powers[0]) } else { None };
        let mut table = Table::new(run, self.dynamics.sensors(), self.roots().len() + 1);
        let mut regularised = Vec::new();
        let mut balance = LineBalance::default();
        for (line, h) in receptances.iter().zip(1..) {
            let prior: Vec<f64> = priors.iter().map(|p| p[h - 1]).collect();
            balance.renew(line, run.data(h), &run.loads, &prior);
            if let Some(smooth) = &smooth {
                balance.forces[0] = smooth.coefficients[h];
            }
            let friction = powers[0][h - 1].1;
            if balance.degenerate || priors[0][h - 1] < friction {
                regularised.push(h);
            }
            Outputs::new((self, run), (line, &balance, h)).write(&mut table);
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

/// Values and variances of all outputs, line by line: friction, slip, normal, second support, sensors.
struct Table {
    values: Vec<Vec<Complex64>>,
    variances: Vec<Vec<f64>>,
    /// Shared errors of the outputs before the sensors: one vector of sources an output.
    shared: [Vec<Vec<Complex64>>; FIRST_SENSOR],
}

/// Outputs before the sensors: friction, slip, normal, second support.
const FIRST_SENSOR: usize = 4;

impl Table {
    fn new(run: &Equations<'_>, sensors: usize, sources: usize) -> Self {
        let lines = run.order() + 1;
        Self {
            shared: std::array::from_fn(|_| vec![vec![Complex64::ZERO; lines]; sources]),
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
        let [shared_friction, shared_slip, shared_normal, shared_second] = self.shared;
        let turned = |source: &Vec<Complex64>| -> Vec<Complex64> {
            source.iter().enumerate().map(|(h, g)| g * Complex64::new(0.0, base * h as f64)).collect()
        };
        ContactHarmonics {
            shared: SharedErrors {
                friction: shared_friction,
                slip_velocity: shared_slip.iter().map(turned).collect(),
                slip: shared_slip,
                normal: shared_normal,
                second_support: shared_second,
            },
            slip_velocity: slip.derivative(),
            friction,
            slip,
            normal,
            second_support: run.loads.contains(&Load::SecondSupport).then_some(second),
            acceleration_fit: all.collect(),
        }
    }
}
