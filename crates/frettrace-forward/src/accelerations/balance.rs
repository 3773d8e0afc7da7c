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
    let zeros = vec![0.0; e.width()];
    let mut lines = vec![Complex64::ZERO; order + 1];
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
    /// Contact force [N], one value a line.
    pub force: Vec<Complex64>,
    /// Standard deviation of its real and imaginary part [N].
    pub force_deviation: Vec<f64>,
    /// Loss of slip per unit contact force [m/N], one value a line.
    pub slip_gain: Vec<Complex64>,
    /// Slip that belongs to it [m].
    pub slip: Vec<Complex64>,
    /// Displacement of the end [m].
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
