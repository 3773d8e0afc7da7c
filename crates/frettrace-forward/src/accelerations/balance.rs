//! Forces without a law: what the accelerations of a run say of them, line by line.

use super::differentiation::Differentiation;
use super::least_squares::{MOST, solve};
use super::model::{AccelerationError, AccelerationModel, Prediction, Prepared};
use super::run::{Evaluation, store, velocity};
use super::setting::{Quantity, Setting};
use super::structure::{Layout, Structure};
use num_complex::Complex64;

/// What is free on every line beside the contact force.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Beside {
    /// Nothing: the forces of ports follow from their laws.
    Nothing,
    /// The forces of all ports, whatever their laws.
    Ports,
    /// The signal of one sensor.
    Sensor(usize),
    /// A motion of the base.
    Base,
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
    /// What the free forces leave, over its standard deviation: `[sensor][line]`.
    pub left: Vec<Vec<Complex64>>,
    /// Acceleration per unit contact force, `[sensor][line]`.
    pub gain: Vec<Vec<Complex64>>,
    /// What else is free, one a column and line: force of a port (N), acceleration (m/s²) or displacement of the base (m).
    pub beside: Vec<Vec<Complex64>>,
    /// Standard deviation of its real and imaginary part.
    pub beside_deviation: Vec<Vec<f64>>,
    /// Motion of each port (m), one value a line.
    pub motion: Vec<Vec<Complex64>>,
    /// Motion lost per unit force of each port at itself (m/N).
    pub motion_gain: Vec<Vec<Complex64>>,
}

impl Balance {
    /// χ² of what is left, and its degrees of freedom (`2(S − 1)` a line, `2(S − 2)` with one more free value).
    #[must_use]
    pub fn chi_squared(&self) -> (f64, usize) {
        let sum = self.left.iter().flat_map(|lines| lines.iter().skip(1)).map(Complex64::norm_sqr).sum();
        let lines = self.force.len().saturating_sub(1);
        (sum, 2 * lines * self.left.len().saturating_sub(1 + self.beside.len()))
    }

    /// χ² and degrees of freedom of several runs together.
    pub fn chi_squared_of<'a>(all: impl IntoIterator<Item = &'a Self>) -> (f64, usize) {
        all.into_iter().map(Self::chi_squared).fold((0.0, 0), |a, b| (a.0 + b.0, a.1 + b.1))
    }
}

impl AccelerationModel {
    /// The balance of the selected runs without a friction law; the forces of ports follow from their laws.
    ///
    /// # Errors
    /// [`AccelerationError::Beam`] where the structure cannot be built.
    pub fn balance(&self, setting: &Setting, selected: &[usize]) -> Result<Vec<Balance>, AccelerationError> {
        self.balance_beside(setting, selected, Beside::Nothing)
    }

    /// The balance of the selected runs with something free beside the contact force.
    ///
    /// # Errors
    /// [`AccelerationError::Beam`] where the structure cannot be built.
    pub fn balance_beside(
        &self,
        setting: &Setting,
        selected: &[usize],
        beside: Beside,
    ) -> Result<Vec<Balance>, AccelerationError> {
        let mut setting = setting.clone();
        if beside == Beside::Base {
            setting.base.get_or_insert([0.0; 2]);
        }
        let structure = self.structure(&setting)?;
        let one = |&run: &usize| self.balance_of(&structure, &setting, (run, beside));
        Ok(selected.iter().map(one).collect())
    }

    /// The balance of the selected runs, and the derivatives of what it leaves by quantities outside the law: `[quantity][sensor][line]`.
    /// For models without ports, whose forces would answer.
    ///
    /// With the whitened readings `m`, the column `A` of the contact force and `P` the projector beside it, `left = P(m − a(p))`,
    /// where `a` is what the known forces and the contact's make; its derivative at fixed forces, `−P ∂a/∂p`, gives the gradient of
    /// χ² exactly, and Gauss-Newton's matrix to first order in what is left (Kaufman, BIT 15 (1975) 49).
    ///
    /// # Errors
    /// [`AccelerationError::Beam`] where the structure cannot be built.
    pub fn balance_slopes(
        &self,
        setting: &Setting,
        quantities: &[Quantity],
        selected: &[usize],
    ) -> Result<Vec<(Balance, Vec<Prediction>)>, AccelerationError> {
        let structure = self.structure(setting)?;
        let moved = quantities
            .iter()
            .map(|&quantity| self.moved(&structure, setting, quantity))
            .collect::<Result<Vec<_>, _>>()?;
        let one = |&run: &usize| {
            let prepared: Prepared = self.prepare(&structure, setting, run);
            let evaluation = self.evaluation(structure.layout(), setting, &prepared, run);
            let mut unknowns = vec![0.0; evaluation.width()];
            let balance = fit_lines(&evaluation, &unknowns, &Free { beside: Beside::Nothing, moving: &[] });
            let mut force = balance.force.clone();
            force.resize(evaluation.order() + 1, Complex64::ZERO);
            store(&force, &mut unknowns);
            let differentiation = Differentiation {
                evaluation: &evaluation,
                structure: &structure,
                quantities,
                moved: &moved,
                run,
            };
            let mut columns = differentiation.at_fixed_forces(&unknowns);
            for column in &mut columns {
                beside_force(column, &balance, &self.runs[run].deviation);
            }
            (balance, columns)
        };
        Ok(selected.iter().map(one).collect())
    }

    fn balance_of(
        &self,
        structure: &Structure,
        setting: &Setting,
        (run, beside): (usize, Beside),
    ) -> Balance {
        let prepared: Prepared = self.prepare(structure, setting, run);
        let evaluation = self.evaluation(structure.layout(), setting, &prepared, run);
        let lines = &self.runs[run];
        let moving = if beside == Beside::Base {
            structure.transmissibility(lines.omega, lines.order())
        } else {
            Vec::new()
        };
        let free = Free { beside, moving: &moving };
        let mut unknowns = vec![0.0; evaluation.width()];
        if beside != Beside::Ports && structure.layout().ports > 0 {
            answer_ports(&evaluation, &mut unknowns);
        }
        fit_lines(&evaluation, &unknowns, &free)
    }
}

/// Turns a change of the accelerations into that of what the balance leaves: over the deviations, beside what a contact force makes.
fn beside_force(change: &mut Prediction, balance: &Balance, deviation: &[Vec<f64>]) {
    for h in 0..balance.force.len() {
        let gain = |s: usize| balance.gain[s][h] / deviation[s][h];
        let sensors = 0..change.len();
        let power: f64 = sensors.clone().map(|s| gain(s).norm_sqr()).sum();
        let along: Complex64 = sensors.clone().map(|s| gain(s).conj() * change[s][h] / deviation[s][h]).sum();
        let force = if h == 0 || power <= 0.0 { Complex64::ZERO } else { along / power };
        for s in sensors {
            change[s][h] = gain(s) * force - change[s][h] / deviation[s][h];
        }
    }
}

/// Force harmonics of the contact and of all ports from the accelerations, for a start of the full balance. A line within three standard
/// deviations of nothing starts from 0, and so does the mean, which no accelerometer sees: on ports both are what their laws answer to the
/// recovered motion. A stop has a mean, and without it a balance may come to another motion than the one that was measured.
pub(super) fn recover(e: &Evaluation<'_>) -> Vec<f64> {
    let width = 2 * e.order() + 1;
    let mut out = vec![0.0; e.width()];
    let found = beside_ports(e);
    let forces = std::iter::once((&found.force, &found.force_deviation))
        .chain(found.beside.iter().zip(&found.beside_deviation));
    for ((force, deviation), out) in forces.zip(out.chunks_mut(width)) {
        let mut lines = vec![Complex64::ZERO; e.order() + 1];
        for (h, line) in lines.iter_mut().enumerate().take(force.len()).skip(1) {
            if force[h].norm() > 3.0 * deviation[h] {
                *line = force[h];
            }
        }
        store(&lines, out);
    }
    if e.layout.ports > 0 {
        settle_ports(e, &found, &mut out);
    }
    out
}

/// What the accelerations say of the contact force, and of those of the ports where sensors are enough to free them.
fn beside_ports(e: &Evaluation<'_>) -> Balance {
    let free = e.layout.ports > 0 && e.layout.sensors > 1 + e.layout.ports;
    let beside = if free { Beside::Ports } else { Beside::Nothing };
    fit_lines(e, &vec![0.0; e.width()], &Free { beside, moving: &[] })
}

/// Completes forces that were recovered by what the laws of the ports answer to the motion that was.
fn settle_ports(e: &Evaluation<'_>, found: &Balance, forces: &mut [f64]) {
    let mut answered = vec![0.0; e.width()];
    answer_once(e, found, (&mut answered, 1.0));
    let width = 2 * e.order() + 1;
    for (forces, answered) in forces.chunks_mut(width).zip(answered.chunks(width)).skip(1) {
        for (force, answer) in forces.iter_mut().zip(answered).filter(|(force, _)| **force == 0.0) {
            *force = *answer;
        }
    }
}

/// What is free beside the contact force, and the motion of every row with the clamp.
struct Free<'a> {
    beside: Beside,
    moving: &'a [Complex64],
}

impl Free<'_> {
    fn count(&self, e: &Evaluation<'_>) -> usize {
        match self.beside {
            Beside::Nothing => 0,
            Beside::Ports => e.layout.ports.min(MOST - 1),
            Beside::Sensor(_) | Beside::Base => 1,
        }
    }

    /// Acceleration of a sensor by the unit of a free value, before the sensor's own distortion.
    fn column(&self, e: &Evaluation<'_>, k: usize, (s, h): (usize, usize)) -> Complex64 {
        let at = h as f64 * e.lines.omega;
        let row = Layout::sensor_row(s);
        match self.beside {
            Beside::Nothing => Complex64::ZERO,
            Beside::Ports => e.block.at(h, row, 2 + k) * (at * at),
            Beside::Sensor(silent) => Complex64::from(f64::from(u8::from(s == silent))),
            Beside::Base => self.moving[h * e.layout.rows() + row] * (-at * at),
        }
    }
}

/// Steps in which the forces of ports and the recovered motion agree where sensors are too few to free them.
const PORT_STEPS: usize = 5;

/// Forces that the ports answer by their laws to the recovered motion.
///
/// The motion comes with the ports' forces free, so that it does not depend on their laws.
fn answer_ports(e: &Evaluation<'_>, unknowns: &mut [f64]) {
    let zeros = vec![0.0; e.width()];
    if e.layout.sensors > 1 + e.layout.ports && e.layout.ports < MOST {
        let found = fit_lines(e, &zeros, &Free { beside: Beside::Ports, moving: &[] });
        answer_once(e, &found, (unknowns, 1.0));
        return;
    }
    for step in 0..PORT_STEPS {
        let found = fit_lines(e, unknowns, &Free { beside: Beside::Nothing, moving: &[] });
        answer_once(e, &found, (unknowns, if step == 0 { 1.0 } else { 0.6 }));
    }
}

/// Steps in which the mean of a motion and the mean force that it answers to agree.
const MEAN_STEPS: usize = 40;

/// Mean `m` (m) of a motion whose port answers with a force of the mean `f(m)` (N), rising with `m`, that moves it by its compliance `g`
/// (m/N): `m = rest − g f(m)`, by bisection.
pub fn settled_mean(rest: f64, compliance: f64, force: impl Fn(f64) -> f64) -> f64 {
    let beyond = |mean: f64| mean + compliance * force(mean) - rest;
    let first = rest - compliance * force(rest);
    let (mut low, mut high) = (rest.min(first), rest.max(first));
    for _ in 0..MEAN_STEPS {
        let middle = 0.5 * (low + high);
        if beyond(middle) > 0.0 {
            high = middle;
        } else {
            low = middle;
        }
    }
    0.5 * (low + high)
}

/// Moves the forces of the ports by a share towards their laws' answer to a recovered motion. No accelerometer sees its mean: the mean
/// forces of the ports make that.
fn answer_once(e: &Evaluation<'_>, found: &Balance, (unknowns, share): (&mut [f64], f64)) {
    let order = e.order();
    let width = 2 * order + 1;
    let mut scratch = e.grid.scratch();
    let (mut d, mut v) = (vec![0.0; e.grid.samples()], vec![0.0; e.grid.samples()]);
    let mut lines = vec![Complex64::ZERO; order + 1];
    let ports = e.setting.ports.iter().enumerate().zip(&found.motion).zip(&found.motion_gain);
    for ((((p, port), motion), gain), out) in ports.zip(unknowns[width..].chunks_mut(width)) {
        let mut full = motion.clone();
        full.resize(order + 1, Complex64::ZERO);
        if port.law.one_sided() {
            full[0] = Complex64::ZERO;
        }
        e.grid.evaluate(&full, &mut d, &mut scratch);
        e.grid.evaluate(&velocity(&full, e.lines.omega), &mut v, &mut scratch);
        let force = |d: f64, v: f64| port.law.force(&port.coefficients, d, v).force;
        let mean_force =
            |mean: f64| d.iter().zip(&v).map(|(d, v)| force(d + mean, *v)).sum::<f64>() / d.len() as f64;
        let compliance = gain.first().map_or(0.0, |gain| gain.re);
        let mean = if port.law.one_sided() {
            settled_mean(e.rest_of(p).unwrap_or_default(), compliance, mean_force)
        } else {
            0.0
        };
        for (d, v) in d.iter_mut().zip(&v) {
            *d = force(*d + mean, *v);
        }
        e.grid.project(&d, &mut lines, &mut scratch);
        let mut reals = vec![0.0; width];
        store(&lines, &mut reals);
        out.iter_mut().zip(&reals).for_each(|(old, new)| *old += share * (new - *old));
    }
}

/// Free values on each line, beside the given forces of ports.
fn fit_lines(e: &Evaluation<'_>, given: &[f64], free: &Free<'_>) -> Balance {
    let (lines, sensors) = (e.lines.order() + 1, e.layout.sensors);
    let count = free.count(e);
    let mut out = Balance {
        left: vec![vec![Complex64::ZERO; lines]; sensors],
        gain: vec![vec![Complex64::ZERO; lines]; sensors],
        beside: vec![Vec::with_capacity(lines); count],
        beside_deviation: vec![Vec::with_capacity(lines); count],
        motion: vec![Vec::with_capacity(lines); e.layout.ports],
        motion_gain: vec![Vec::with_capacity(lines); e.layout.ports],
        ..Balance::default()
    };
    let mut columns = vec![vec![Complex64::ZERO; sensors]; 1 + count];
    let mut measured = vec![Complex64::ZERO; sensors];
    for h in 0..lines {
        let at = h as f64 * e.lines.omega;
        for s in 0..sensors {
            let sensor = e.setting.sensors[s];
            let distortion = sensor.response(at) / e.lines.deviation[s][h];
            let row = Layout::sensor_row(s);
            columns[0][s] = e.block.at(h, row, 1) * distortion * (at * at);
            for (k, column) in columns.iter_mut().skip(1).enumerate() {
                column[s] = free.column(e, k, (s, h)) * distortion;
            }
            let offset = if h == 0 { sensor.offset } else { 0.0 };
            measured[s] = (e.lines.acceleration[s][h] - offset) / e.lines.deviation[s][h]
                - e.displacement(given, row, h) * distortion * (-at * at);
            out.gain[s][h] = columns[0][s] * e.lines.deviation[s][h];
        }
        let forced = if free.beside == Beside::Ports { count } else { 0 };
        solve_line(e, (given, h, forced), (&columns, &measured), &mut out);
    }
    out
}

fn solve_line(
    e: &Evaluation<'_>,
    (given, h, forced): (&[f64], usize, usize),
    (columns, measured): (&[Vec<Complex64>], &[Complex64]),
    out: &mut Balance,
) {
    let found = if h == 0 { None } else { solve(columns, measured) };
    let value = |k: usize| found.map_or(Complex64::ZERO, |f| f.values[k]);
    let deviation = |k: usize| found.map_or(f64::INFINITY, |f| f.variances[k].sqrt());
    for (s, measured) in measured.iter().enumerate() {
        let explained: Complex64 = columns.iter().enumerate().map(|(k, c)| c[s] * value(k)).sum();
        out.left[s][h] = measured - explained;
    }
    let force = value(0);
    let moved = |row: usize| {
        let mut sum = e.displacement(given, row, h) - e.block.at(h, row, 1) * force;
        for k in 0..forced {
            sum -= e.block.at(h, row, 2 + k) * value(1 + k);
        }
        sum
    };
    out.slip.push(moved(0));
    out.end.push(moved(1));
    for p in 0..e.layout.ports {
        let row = e.layout.port_row(p);
        out.motion[p].push(moved(row));
        out.motion_gain[p].push(e.block.at(h, row, 2 + p));
    }
    out.force.push(force);
    out.force_deviation.push(deviation(0));
    out.slip_gain.push(e.block.at(h, 0, 1));
    for k in 0..out.beside.len() {
        out.beside[k].push(value(1 + k));
        out.beside_deviation[k].push(deviation(1 + k));
    }
}

#[cfg(test)]
mod tests {
    use super::settled_mean;

    /// A spring of 3 N/m whose force moves it by 2 m/N: `m = r − 6 m`, a seventh of where it would rest; a stop that is not reached
    /// leaves it there, and one of 3 N/m from 0.1 m on to `m = r − 6 (m − 0.1)`.
    #[test]
    fn a_mean_force_moves_what_it_answers() {
        assert!((settled_mean(0.7, 2.0, |m| 3.0 * m) - 0.1).abs() < 1e-11);
        assert!((settled_mean(0.05, 2.0, |m| 3.0 * (m - 0.1).max(0.0)) - 0.05).abs() < 1e-11);
        assert!((settled_mean(0.8, 2.0, |m| 3.0 * (m - 0.1).max(0.0)) - 0.2).abs() < 1e-11);
    }
}
