//! Outputs of one line, and how they move with everything that is uncertain.

use super::{Setting, Table};
use crate::balance::LineBalance;
use crate::calibration::{Equations, generalised_force};
use crate::dynamics::{LineReceptances, Load};
use num_complex::Complex64;

/// Standard deviation of the flexibility beyond the beam theory, as a share of what the theory gives: a rigid contact (none of
/// it) and one with as much again from shear and local deformation lie two standard deviations off.
pub(crate) const COMPLIANCE_DOUBT: f64 = 0.5;

/// Outputs of one line and how they move with everything that is uncertain.
pub(super) struct Outputs<'a> {
    pub(super) setting: &'a Setting<'a>,
    pub(super) run: &'a Equations<'a>,
    pub(super) line: &'a LineReceptances,
    pub(super) balance: &'a LineBalance,
    pub(super) h: usize,
}

/// A change of the forces, and of the displacements (sensors, slip, end; empty for none) that no force makes.
struct Change<'a> {
    exciter: Complex64,
    forces: &'a [Complex64],
    moved: &'a [Complex64],
}

impl Outputs<'_> {
    /// Writes values, variances and shared errors; `roots` are those of [`crate::CalibratedStructure::roots`].
    pub(super) fn write(&self, roots: &[Vec<f64>], table: &mut Table) {
        let force = self.run.lines.force.coefficients[self.h];
        let here = Change { exciter: force, forces: &self.balance.forces, moved: &[] };
        for (row, value) in table.values.iter_mut().zip(self.of(&here)) {
            row[self.h] = value;
        }
        let mut variances = self.variances();
        let gains: Vec<Vec<Complex64>> =
            (0..2 * self.setting.structure.modes).map(|p| self.parameter_gain(p / 2, p % 2)).collect();
        let compliance = self.compliance_gain();
        for (o, variance) in variances.iter_mut().enumerate() {
            let along = |root: &Vec<f64>| root.iter().zip(&gains).map(|(r, g)| g[o] * *r).sum::<Complex64>();
            let errors = roots.iter().map(along).chain(std::iter::once(compliance[o]));
            for (p, error) in errors.enumerate() {
                *variance += error.norm_sqr();
                if let Some(sources) = table.shared.get_mut(o) {
                    sources[p][self.h] = error;
                }
            }
        }
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
        let sensors = self.setting.dynamics.sensors();
        let moved = |output: usize| change.moved.get(output).copied().unwrap_or(Complex64::ZERO);
        let slip = sum(&|load| self.line.slip(load)) + moved(sensors);
        let end = sum(&|load| self.line.end(load)) + moved(sensors + 1);
        let normal = own(Load::NormalDeviation) - end * self.setting.normal_stiffness;
        let mut outputs = vec![own(Load::Friction), slip, normal, own(Load::SecondSupport)];
        let inertia = -self.line.omega().powi(2);
        outputs
            .extend((0..sensors).map(|s| sum(&|load| self.line.acceleration(s, load)) + moved(s) * inertia));
        outputs
    }

    /// Variances from sensor noise and prior, and from the noise of the force.
    fn variances(&self) -> Vec<f64> {
        let unknowns = self.run.loads.len();
        let covariance = self.balance.covariance();
        let unit = |u: usize| -> Vec<Complex64> {
            (0..unknowns).map(|i| Complex64::from(f64::from(u8::from(i == u)))).collect()
        };
        let columns: Vec<Vec<Complex64>> = (0..unknowns)
            .map(|u| self.of(&Change { exciter: Complex64::ZERO, forces: &unit(u), moved: &[] }))
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
        variances
    }

    /// Change of the outputs per unit of the excitation force's line, the accelerations being given.
    fn force_gain(&self) -> Vec<Complex64> {
        let sensors = self.setting.dynamics.sensors();
        let change: Vec<Complex64> =
            (0..sensors).map(|s| -self.line.acceleration(s, Load::Exciter)).collect();
        let forces = self.balance.response(&change);
        self.of(&Change { exciter: Complex64::ONE, forces: &forces, moved: &[] })
    }

    /// Change of the outputs per unit of `ln ω_n` (`kind` 0) or `ln ζ_n` (1), the measurements being given.
    fn parameter_gain(&self, mode: usize, kind: usize) -> Vec<Complex64> {
        let dynamics = self.setting.dynamics;
        let model = &self.setting.structure.model;
        let force = self.run.lines.force.coefficients[self.h];
        let load = generalised_force(dynamics, mode, force, &self.run.loads, &self.balance.forces);
        let scale = [model.natural_frequency()[mode], model.damping_ratio()[mode]][kind];
        let motion = model.modal_receptance_gradient(mode, self.line.omega())[kind] * scale * load;
        let [slip, end] = dynamics.contact_shape(mode);
        let shapes = (0..dynamics.sensors()).map(|s| dynamics.sensor_shape(mode, s)).chain([slip, end]);
        self.moved(&shapes.map(|shape| motion * shape).collect::<Vec<_>>())
    }

    /// Change of the outputs per standard deviation of the flexibility that the beam theory does not hold for.
    fn compliance_gain(&self) -> Vec<Complex64> {
        let dynamics = self.setting.dynamics;
        let exciter = self.run.lines.force.coefficients[self.h];
        let moved = |output: usize| {
            let contact = self.run.loads.iter().zip(&self.balance.forces);
            let sum = contact.map(|(load, f)| f * dynamics.doubtful(output, *load)).sum::<Complex64>();
            (sum + exciter * dynamics.doubtful(output, Load::Exciter)) * COMPLIANCE_DOUBT
        };
        self.moved(&(0..dynamics.sensors() + 2).map(moved).collect::<Vec<_>>())
    }

    /// Change of the outputs when the structure moves by so much more, the measurements being given.
    fn moved(&self, moved: &[Complex64]) -> Vec<Complex64> {
        let inertia = self.line.omega().powi(2);
        let sensors = self.setting.dynamics.sensors();
        let change: Vec<Complex64> = moved.iter().take(sensors).map(|m| m * inertia).collect();
        let forces = self.balance.response(&change);
        self.of(&Change { exciter: Complex64::ZERO, forces: &forces, moved })
    }
}
