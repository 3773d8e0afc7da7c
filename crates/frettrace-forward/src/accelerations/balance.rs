//! Contact force without a law: what the accelerations of a run say about it, line by line.

use super::model::{AccelerationError, AccelerationModel};
use super::setting::Setting;
use super::structure::Structure;

use super::run::{Evaluation, store};
use super::structure::Layout;
use frettrace_fourier::GridScratch;
use num_complex::Complex64;

/// Force harmonics (all ports) recovered by weighted least squares over the sensors, for a start.
///
/// Only the friction force is recovered; a line whose force is smaller than three standard deviations starts from 0.
pub(super) fn recover(e: &Evaluation<'_>) -> Vec<f64> {
    let order = e.order();
    let width = 2 * order + 1;
    let zeros = vec![0.0; e.width()];
    let mut lines = vec![Complex64::ZERO; order + 1];
    if e.layout.ports > 0 && e.layout.sensors > 2 {
        let found = free_force(e);
        let mut out = zeros;
        let pairs = [(&found.contact, 0), (&found.force, width)];
        for (forces, at) in pairs {
            lines.fill(Complex64::ZERO);
            for (h, line) in lines.iter_mut().enumerate().take(forces.len()) {
                let known = found.force[h].norm() > 3.0 * found.deviation[h] || at == 0;
                *line = if known { forces[h] } else { Complex64::ZERO };
            }
            store(&lines, &mut out[at..at + width]);
        }
        return out;
    }
    for (h, force) in lines.iter_mut().enumerate().take(e.lines.order() + 1).skip(1) {
        let at = h as f64 * e.lines.omega;
        let (mut numerator, mut denominator) = (Complex64::ZERO, 0.0);
        for s in 0..e.layout.sensors {
            let row = Layout::sensor_row(s);
            let gain = -e.block.at(h, row, 1) * (-at * at);
            let left = e.lines.acceleration[s][h] - e.displacement(&zeros, row, h) * (-at * at);
            let weight = e.lines.deviation[s][h].powi(-2);
            numerator += gain.conj() * left * weight;
            denominator += gain.norm_sqr() * weight;
        }
        let estimate = numerator / denominator;
        if estimate.norm() * denominator.sqrt() > 3.0 {
            *force = estimate;
        }
    }
    let mut out = zeros;
    store(&lines, &mut out[..2 * order + 1]);
    out
}

/// The balance of one run without a friction law: on each line one contact force, by least squares over the sensors.
#[derive(Clone, Debug, Default)]
pub struct Balance {
    /// Contact force (N), one value a line.
    pub force: Vec<Complex64>,
    /// Standard deviation of its real and imaginary part (N).
    pub force_deviation: Vec<f64>,
    /// Loss of slip per unit contact force (m/N), one value a line.
    pub slip_gain: Vec<Complex64>,
    /// Slip that belongs to it (m).
    pub slip: Vec<Complex64>,
    /// Displacement of the end (m).
    pub end: Vec<Complex64>,
    /// What no contact force explains, over its standard deviation: `[sensor][line]`.
    pub left: Vec<Vec<Complex64>>,
    /// Acceleration per unit contact force, `[sensor][line]`.
    pub gain: Vec<Vec<Complex64>>,
}

impl Balance {
    /// χ² of what is left, and its degrees of freedom (`2(S − 1)` a line).
    #[must_use]
    pub fn chi_squared(&self) -> (f64, usize) {
        let sum = self.left.iter().flat_map(|lines| lines.iter().skip(1)).map(Complex64::norm_sqr).sum();
        let lines = self.force.len().saturating_sub(1);
        (sum, 2 * lines * self.left.len().saturating_sub(1))
    }
}

impl AccelerationModel {
    /// The balance of the selected runs without a friction law.
    ///
    /// # Errors
    /// [`AccelerationError::Beam`] where the structure cannot be built.
    pub fn balance(&self, setting: &Setting, selected: &[usize]) -> Result<Vec<Balance>, AccelerationError> {
        let structure = Structure::new(&self.rig, setting)?;
        Ok(selected
            .iter()
            .map(|&run| {
                let prepared = self.prepare(&structure, setting, run);
                let evaluation = self.evaluation(structure.layout(), setting, &prepared, run);
                let mut unknowns = vec![0.0; evaluation.width()];
                let mut found = balance(&evaluation, &unknowns);
                if structure.layout().ports > 0 {
                    // The forces of ports follow the recovered motion: a few steps, damped, since each moves the other.
                    let mut scratch = evaluation.grid.scratch();
                    for step in 0..PORT_STEPS {
                        answer_ports(&evaluation, &found, (&mut unknowns, step), &mut scratch);
                        found = balance(&evaluation, &unknowns);
                    }
                }
                found
            })
            .collect())
    }
}

impl AccelerationModel {
    /// The balance of the selected runs beside a free force at the first port: contacts without any law.
    ///
    /// # Errors
    /// [`AccelerationError::Beam`] where the structure cannot be built.
    pub fn balance_beside_port(
        &self,
        setting: &Setting,
        selected: &[usize],
    ) -> Result<Vec<Balance>, AccelerationError> {
        let structure = Structure::new(&self.rig, setting)?;
        Ok(selected
            .iter()
            .map(|&run| {
                let prepared = self.prepare(&structure, setting, run);
                let evaluation = self.evaluation(structure.layout(), setting, &prepared, run);
                let mut unknowns = recover(&evaluation);
                unknowns[..2 * evaluation.order() + 1].fill(0.0);
                balance(&evaluation, &unknowns)
            })
            .collect())
    }
}

/// Two free forces on each line: at the contact and at the first port.
#[derive(Clone, Debug, Default)]
pub struct FreeForce {
    /// Force at the port (N), one value a line; what resists positive motion is positive.
    pub force: Vec<Complex64>,
    /// Standard deviation of its real and imaginary part (N).
    pub deviation: Vec<f64>,
    /// Motion of the port (m).
    pub motion: Vec<Complex64>,
    /// Friction force beside it (N).
    pub contact: Vec<Complex64>,
    /// χ² of what both forces leave, and its degrees of freedom.
    pub chi_squared: (f64, usize),
}

impl AccelerationModel {
    /// What the accelerations say of a force at the place of the first port, whatever its law.
    ///
    /// # Errors
    /// [`AccelerationError::Beam`] where the structure cannot be built.
    pub fn free_force(
        &self,
        setting: &Setting,
        selected: &[usize],
    ) -> Result<Vec<FreeForce>, AccelerationError> {
        let structure = Structure::new(&self.rig, setting)?;
        Ok(selected
            .iter()
            .map(|&run| {
                let prepared = self.prepare(&structure, setting, run);
                free_force(&self.evaluation(structure.layout(), setting, &prepared, run))
            })
            .collect())
    }
}

fn free_force(e: &Evaluation<'_>) -> FreeForce {
    let zeros = vec![0.0; e.width()];
    let sensors = e.layout.sensors;
    let mut out = FreeForce { chi_squared: (0.0, 0), ..FreeForce::default() };
    for h in 0..=e.lines.order() {
        let at = h as f64 * e.lines.omega;
        // Normal equations of two complex unknowns.
        let (mut aa, mut bb, mut ab) = (0.0, 0.0, Complex64::ZERO);
        let (mut ay, mut by, mut yy) = (Complex64::ZERO, Complex64::ZERO, 0.0);
        for s in 0..sensors {
            let row = Layout::sensor_row(s);
            let scale = Complex64::from(-at * at / e.lines.deviation[s][h]);
            let (a, b) = (-e.block.at(h, row, 1) * scale, -e.block.at(h, row, 2) * scale);
            let y =
                e.lines.acceleration[s][h] / e.lines.deviation[s][h] - e.displacement(&zeros, row, h) * scale;
            aa += a.norm_sqr();
            bb += b.norm_sqr();
            ab += a.conj() * b;
            ay += a.conj() * y;
            by += b.conj() * y;
            yy += y.norm_sqr();
        }
        let determinant = aa * bb - ab.norm_sqr();
        if h == 0 || determinant <= 1e-12 * aa * bb {
            out.force.push(Complex64::ZERO);
            out.deviation.push(f64::INFINITY);
            out.motion.push(Complex64::ZERO);
            out.contact.push(Complex64::ZERO);
            continue;
        }
        let contact = (ay * bb - ab * by) / determinant;
        let force = (by * aa - ab.conj() * ay) / determinant;
        out.chi_squared.0 += yy - (contact.conj() * ay).re - (force.conj() * by).re;
        out.chi_squared.1 += 2 * sensors.saturating_sub(2);
        let row = e.layout.port_row(0);
        let moved =
            e.displacement(&zeros, row, h) - e.block.at(h, row, 1) * contact - e.block.at(h, row, 2) * force;
        out.force.push(force);
        out.contact.push(contact);
        out.deviation.push((aa / determinant).sqrt());
        out.motion.push(moved);
    }
    out
}

/// Steps in which the forces of ports and the recovered motion agree.
const PORT_STEPS: usize = 5;

/// Forces that the ports answer to the recovered motion.
fn answer_ports(
    e: &Evaluation<'_>,
    found: &Balance,
    (unknowns, step): (&mut [f64], usize),
    scratch: &mut GridScratch,
) {
    let order = e.order();
    let width = 2 * order + 1;
    let mut lines = vec![Complex64::ZERO; order + 1];
    for (line, force) in lines.iter_mut().zip(&found.force) {
        *line = *force;
    }
    store(&lines, &mut unknowns[..width]);
    let mut new = Vec::with_capacity(e.layout.ports);
    for (p, port) in e.setting.ports.iter().enumerate() {
        let row = e.layout.port_row(p);
        let motion: Vec<Complex64> = (0..=order)
            .map(|h| if h <= e.lines.order() { e.displacement(unknowns, row, h) } else { Complex64::ZERO })
            .collect();
        let speed = super::run::velocity(&motion, e.lines.omega);
        let (mut d, mut v) = (vec![0.0; e.grid.samples()], vec![0.0; e.grid.samples()]);
        e.grid.evaluate(&motion, &mut d, scratch);
        e.grid.evaluate(&speed, &mut v, scratch);
        for (d, v) in d.iter_mut().zip(&v) {
            *d = port.law.force(&port.coefficients, *d, *v).force;
        }
        e.grid.project(&d, &mut lines, scratch);
        let mut reals = vec![0.0; width];
        store(&lines, &mut reals);
        new.push(reals);
    }
    let share = if step == 0 { 1.0 } else { 0.6 };
    for (old, new) in unknowns[width..].chunks_mut(width).zip(&new) {
        old.iter_mut().zip(new).for_each(|(o, n)| *o += share * (n - *o));
    }
    unknowns[..width].fill(0.0);
}

/// Free contact force on each line, beside the given forces of ports.
fn balance(e: &Evaluation<'_>, zeros: &[f64]) -> Balance {
    let lines = e.lines.order() + 1;
    let mut out = Balance {
        left: vec![vec![Complex64::ZERO; lines]; e.layout.sensors],
        gain: vec![vec![Complex64::ZERO; lines]; e.layout.sensors],
        ..Balance::default()
    };
    for h in 0..lines {
        let at = h as f64 * e.lines.omega;
        let (mut numerator, mut denominator) = (Complex64::ZERO, 0.0);
        let free: Vec<Complex64> = (0..e.layout.sensors)
            .map(|s| {
                let row = Layout::sensor_row(s);
                let sensor = e.setting.sensors[s];
                let distortion = Complex64::from_polar(sensor.gain, -at * sensor.delay) * (-at * at);
                let gain = -e.block.at(h, row, 1) * distortion;
                let offset = if h == 0 { sensor.offset } else { 0.0 };
                let left = e.lines.acceleration[s][h] - e.displacement(zeros, row, h) * distortion - offset;
                let weight = e.lines.deviation[s][h].powi(-2);
                numerator += gain.conj() * left * weight;
                denominator += gain.norm_sqr() * weight;
                out.gain[s][h] = gain;
                left
            })
            .collect();
        let force = if denominator > 0.0 { numerator / denominator } else { Complex64::ZERO };
        for (s, left) in free.into_iter().enumerate() {
            out.left[s][h] = (left - out.gain[s][h] * force) / e.lines.deviation[s][h];
        }
        out.force.push(force);
        out.force_deviation.push(if denominator > 0.0 { denominator.sqrt().recip() } else { f64::INFINITY });
        out.slip_gain.push(e.block.at(h, 0, 1));
        out.slip.push(e.displacement(zeros, 0, h) - e.block.at(h, 0, 1) * force);
        out.end.push(e.displacement(zeros, 1, h) - e.block.at(h, 1, 1) * force);
    }
    out
}
