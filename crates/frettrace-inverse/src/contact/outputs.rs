//! Outputs of one line, and how they move with everything that is uncertain.

use super::{FIRST_SENSOR, Setting, Table};
use crate::balance::LineBalance;
use crate::calibration::{Equations, generalised_force};
use crate::dynamics::{LineReceptances, Load};
use num_complex::Complex64;

/// Standard deviation of the flexibility beyond the beam theory, as a share of what the theory gives: a rigid contact (none of
/// it) and one with as much again from shear and local deformation lie two standard deviations off.
pub(crate) const COMPLIANCE_DOUBT: f64 = 0.5;

/// Outputs of one line and how they move with everything that is uncertain.
pub(super) struct Outputs<'a> {
    setting: &'a Setting<'a>,
    run: &'a Equations<'a>,
    line: &'a LineReceptances,
    balance: &'a LineBalance,
    h: usize,
    /// Outputs per unit of the excitation force.
    exciter: Vec<Complex64>,
    /// Outputs per unit of each unknown force.
    columns: Vec<Vec<Complex64>>,
}

/// A change of the forces, and of the displacements (sensors, slip, end; empty for none) that no force makes.
struct Change<'a> {
    exciter: Complex64,
    forces: &'a [Complex64],
    moved: &'a [Complex64],
}

/// Places of slip and normal force among the outputs.
const SLIP: usize = 1;
const NORMAL: usize = 2;

/// All outputs per unit of a load: friction, slip, normal, second support, sensors.
fn column(setting: &Setting<'_>, line: &LineReceptances, load: Load) -> Vec<Complex64> {
    let own = |wanted: Load| Complex64::from(f64::from(u8::from(load == wanted)));
    let normal = own(Load::NormalDeviation) - line.end(load) * setting.normal_stiffness;
    let contact = [own(Load::Friction), line.slip(load), normal, own(Load::SecondSupport)];
    let sensors = (0..setting.dynamics.sensors()).map(|s| line.acceleration(s, load));
    contact.into_iter().chain(sensors).collect()
}

impl<'a> Outputs<'a> {
    /// Outputs of line `h` of a run under its balance.
    pub(super) fn new(
        (setting, run): (&'a Setting<'a>, &'a Equations<'a>),
        (line, balance, h): (&'a LineReceptances, &'a LineBalance, usize),
    ) -> Self {
        let column = |load: Load| column(setting, line, load);
        let (exciter, columns) =
            (column(Load::Exciter), run.loads.iter().map(|load| column(*load)).collect());
        Self { setting, run, line, balance, h, exciter, columns }
    }

    /// Writes values, variances and shared errors.
    pub(super) fn write(&self, table: &mut Table) {
        let force = self.run.lines.force.coefficients[self.h];
        let here = Change { exciter: force, forces: &self.balance.forces, moved: &[] };
        for (row, value) in table.values.iter_mut().zip(self.of(&here)) {
            row[self.h] = value;
        }
        let mut variances = self.variances();
        let gains = self.parameter_gains();
        let roots = self.setting.roots();
        let mut errors = vec![Complex64::ZERO; variances.len()];
        let mut add = |p: usize, errors: &[Complex64]| {
            variances.iter_mut().zip(errors).for_each(|(variance, error)| *variance += error.norm_sqr());
            table.shared.iter_mut().zip(errors).for_each(|(sources, error)| sources[p][self.h] = *error);
        };
        for (p, root) in roots.iter().enumerate() {
            errors.fill(Complex64::ZERO);
            for (r, gain) in root.iter().zip(gains.chunks_exact(errors.len())) {
                errors.iter_mut().zip(gain).for_each(|(error, g)| *error += g * *r);
            }
            add(p, &errors);
        }
        add(roots.len(), &self.compliance_gain());
        for (row, value) in table.variances.iter_mut().zip(variances) {
            row[self.h] = value;
        }
    }

    /// All outputs for given forces; they are linear in them.
    fn of(&self, change: &Change<'_>) -> Vec<Complex64> {
        let mut outputs: Vec<Complex64> = self.exciter.iter().map(|o| o * change.exciter).collect();
        for (column, force) in self.columns.iter().zip(change.forces) {
            outputs.iter_mut().zip(column).for_each(|(output, o)| *output += o * force);
        }
        let (moved, contact) = change.moved.split_at(change.moved.len().saturating_sub(2));
        if let [slip, end] = contact {
            outputs[SLIP] += slip;
            outputs[NORMAL] -= end * self.setting.normal_stiffness;
        }
        let inertia = -self.line.omega().powi(2);
        outputs[FIRST_SENSOR..].iter_mut().zip(moved).for_each(|(output, m)| *output += m * inertia);
        outputs
    }

    /// Variances from sensor noise and prior, and from the noise of the force.
    fn variances(&self) -> Vec<f64> {
        let unknowns = self.run.loads.len();
        let covariance = self.balance.covariance();
        let columns = &self.columns;
        let mut variances: Vec<f64> = (0..self.exciter.len())
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

    /// Changes of the outputs per unit of `ln ω_1, ln ζ_1, ln ω_2, …`, one after the other, the measurements being given.
    fn parameter_gains(&self) -> Vec<Complex64> {
        let dynamics = self.setting.dynamics;
        let model = &self.setting.structure.model;
        let force = self.run.lines.force.coefficients[self.h];
        let mut gains = Vec::with_capacity(2 * self.setting.structure.modes * self.exciter.len());
        let mut shape = Vec::with_capacity(dynamics.sensors() + 2);
        for mode in 0..self.setting.structure.modes {
            let load = generalised_force(dynamics, mode, force, &self.run.loads, &self.balance.forces);
            let scales = [model.natural_frequency()[mode], model.damping_ratio()[mode]];
            shape.clear();
            shape.extend(dynamics.sensor_shapes(mode).iter().map(|x| Complex64::from(*x)));
            shape.extend(dynamics.contact_shape(mode).map(Complex64::from));
            // Both parameters move the same shape.
            let unit = self.moved(&shape);
            for (gain, scale) in model.modal_receptance_gradient(mode, self.line.omega()).iter().zip(scales) {
                let motion = gain * scale * load;
                gains.extend(unit.iter().map(|u| u * motion));
            }
        }
        gains
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
