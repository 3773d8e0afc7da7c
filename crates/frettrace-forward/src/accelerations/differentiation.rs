//! Derivatives of one run's prediction by the implicit function theorem, and what sensors make of it.

use super::factor::Factor;
use super::linear::{Direction, Tangent};
use super::model::{Linearised, Prediction};
use super::run::{Evaluation, coefficient};
use super::setting::{Quantity, Setting};
use super::solve::RunMemory;
use super::structure::{Layout, Structure};
use frettrace_friction::effects::Hook;
use num_complex::Complex64;
use std::sync::Arc;

pub(super) struct Differentiation<'a> {
    pub evaluation: &'a Evaluation<'a>,
    pub structure: &'a Structure,
    pub quantities: &'a [Quantity],
    pub moved: &'a [Option<(Structure, f64)>],
    pub run: usize,
}

/// What a quantity changes while the contact forces stay as they are.
struct Direct {
    /// Motion (m) of every row, `rows` values a line; `None` where the structure stays as it is.
    motion: Option<Vec<Complex64>>,
    /// Force harmonics with which the contacts answer to it; `None` where only a sensor changes.
    answer: Option<Vec<f64>>,
}

impl Differentiation<'_> {
    /// The prediction of the run and its derivatives by every quantity.
    pub fn at(&self, kept: &mut RunMemory) -> Linearised {
        let evaluation = self.evaluation;
        let mut scratch = evaluation.grid.scratch();
        let hooks: Vec<Hook> = self
            .quantities
            .iter()
            .filter_map(|q| if let Quantity::Law(hook) = q { Some(*hook) } else { None })
            .collect();
        let state = evaluation.evaluate(&kept.unknowns, &mut scratch);
        let tangent = Tangent::new(evaluation, &state, &hooks);
        let factor = kept.current().unwrap_or_else(|| {
            let factor = Arc::new(Factor::new(tangent.jacobian()));
            kept.factor = Some((factor.clone(), Arc::new(kept.unknowns.clone())));
            factor
        });
        let plain = evaluation.accelerations(&kept.unknowns);
        // What each quantity changes at fixed contact forces, and the forces that answer to it: all of them from one solution, which
        // reads the factor once.
        let direct: Vec<Direct> = self
            .quantities
            .iter()
            .enumerate()
            .map(|(index, &quantity)| self.direct((index, quantity), &hooks, (&tangent, kept), &mut scratch))
            .collect();
        let answers: Vec<&Vec<f64>> = direct.iter().filter_map(|d| d.answer.as_ref()).collect();
        let mut forces = faer::Mat::from_fn(evaluation.width(), answers.len(), |row, j| answers[j][row]);
        factor.solve_in_place(forces.as_mut());
        let mut solved = forces.col_iter();
        let columns = self
            .quantities
            .iter()
            .zip(&direct)
            .map(|(&quantity, direct)| match direct.answer.as_ref().and_then(|_| solved.next()) {
                Some(forces) => {
                    let forces: Vec<f64> = forces.iter().copied().collect();
                    self.column(direct.motion.as_deref(), &forces)
                }
                None => sensor_column(quantity, evaluation, &plain),
            })
            .collect();
        let setting = evaluation.setting;
        Linearised { prediction: distort(plain, setting, evaluation.lines.omega), columns }
    }

    /// Derivatives of the prediction by every quantity while all forces stay as they are.
    pub fn at_fixed_forces(&self, unknowns: &[f64]) -> Vec<Prediction> {
        let plain = self.evaluation.accelerations(unknowns);
        let still = vec![0.0; unknowns.len()];
        let column = |(index, &quantity): (usize, &Quantity)| match self.motion(index, quantity, unknowns) {
            Some(motion) => self.column(Some(&motion), &still),
            None => sensor_column(quantity, self.evaluation, &plain),
        };
        self.quantities.iter().enumerate().map(column).collect()
    }

    /// What one quantity changes at fixed contact forces.
    fn direct(
        &self,
        (index, quantity): (usize, Quantity),
        hooks: &[Hook],
        (tangent, kept): (&Tangent<'_>, &RunMemory),
        scratch: &mut frettrace_fourier::GridScratch,
    ) -> Direct {
        let e = self.evaluation;
        let motion = self.motion(index, quantity, &kept.unknowns);
        let direction = match quantity {
            Quantity::Law(hook) => {
                Direction { hook: hooks.iter().position(|h| *h == hook), ..Direction::default() }
            }
            Quantity::Port(p, c) => Direction { coefficient: Some((p, c)), ..Direction::default() },
            _ => match &motion {
                Some(lines) => {
                    let rows = e.layout.rows();
                    tangent.direction(|row| (0..=e.order()).map(|h| lines[h * rows + row]).collect(), scratch)
                }
                None => return Direct { motion: None, answer: None },
            },
        };
        let [answer] = tangent.answer(&direction, scratch);
        Direct { motion, answer: Some(answer) }
    }

    /// Derivative of the accelerations by a quantity that moves the rows by `motion` and to which the contact answers with `forces`.
    fn column(&self, motion: Option<&[Complex64]>, forces: &[f64]) -> Prediction {
        let e = self.evaluation;
        let rows = e.layout.rows();
        let change = (0..e.layout.sensors)
            .map(|s| {
                (0..=e.lines.order())
                    .map(|h| {
                        let at = h as f64 * e.lines.omega;
                        let row = Layout::sensor_row(s);
                        let mut sum = motion.map_or(Complex64::ZERO, |moved| moved[h * rows + row]);
                        for port in 0..=e.layout.ports {
                            sum -= e.block.at(h, row, 1 + port) * coefficient(forces, e.order(), port, h);
                        }
                        sum * (-at * at)
                    })
                    .collect()
            })
            .collect();
        distort_change(change, e.setting, e.lines.omega)
    }

    /// Change of the motion of every row at fixed contact forces: `∂R_e F − ∂R_f f`, and of what moves with the base; `rows`
    /// values a line.
    fn motion(&self, index: usize, quantity: Quantity, unknowns: &[f64]) -> Option<Vec<Complex64>> {
        let e = self.evaluation;
        let (omega, order) = (e.lines.omega, e.order());
        let mut base = Vec::new();
        let derivative = match (&self.moved[index], quantity) {
            (Some((beside, distance)), _) => {
                let mut block = beside.block(omega, order, e.lines.progress);
                for (value, plain) in block.values.iter_mut().zip(&e.block.values) {
                    *value = (*value - plain) / *distance;
                }
                base = beside.base_lines(e.setting, (e.lines, self.run));
                base.iter_mut().zip(e.base).for_each(|(moved, plain)| *moved = (*moved - plain) / *distance);
                block
            }
            (None, Quantity::ModeFrequency(n)) => self.structure.mode_gradient(n, false, omega, order),
            (None, Quantity::ModeDamping(n)) => self.structure.mode_gradient(n, true, omega, order),
            (None, Quantity::BaseReal | Quantity::BaseImaginary) => return Some(self.base_motion(quantity)),
            _ => return None,
        };
        let changed = Evaluation { block: &derivative, base: &base, ..*e };
        let rows = e.layout.rows();
        Some(
            (0..=order)
                .flat_map(|h| (0..rows).map(move |row| (h, row)))
                .map(|(h, row)| changed.displacement(unknowns, row, h))
                .collect(),
        )
    }

    fn base_motion(&self, quantity: Quantity) -> Vec<Complex64> {
        let e = self.evaluation;
        let unit = if quantity == Quantity::BaseReal { Complex64::ONE } else { Complex64::I };
        let rows = e.layout.rows();
        self.structure
            .transmissibility(e.lines.omega, e.order())
            .into_iter()
            .enumerate()
            .map(|(k, t)| t * unit * e.setting.clamp_unit(e.lines, (self.run, k / rows)))
            .collect()
    }
}

/// Sensors distort: gain, delay, low pass and offset.
pub(super) fn distort(mut plain: Prediction, setting: &Setting, omega: f64) -> Prediction {
    for (lines, sensor) in plain.iter_mut().zip(&setting.sensors) {
        for (h, line) in lines.iter_mut().enumerate() {
            *line = *line * sensor.response(h as f64 * omega) + if h == 0 { sensor.offset } else { 0.0 };
        }
    }
    plain
}

fn distort_change(mut change: Prediction, setting: &Setting, omega: f64) -> Prediction {
    for (lines, sensor) in change.iter_mut().zip(&setting.sensors) {
        for (h, line) in lines.iter_mut().enumerate() {
            *line *= sensor.response(h as f64 * omega);
        }
    }
    change
}

/// Derivative by what only a sensor does.
fn sensor_column(quantity: Quantity, e: &Evaluation<'_>, plain: &Prediction) -> Prediction {
    let mut column: Prediction = plain.iter().map(|lines| vec![Complex64::ZERO; lines.len()]).collect();
    let omega = e.lines.omega;
    match quantity {
        Quantity::Gain(s) | Quantity::Delay(s) | Quantity::Lag(s) if s < column.len() => {
            let sensor = e.setting.sensors[s];
            for (h, (out, a)) in column[s].iter_mut().zip(&plain[s]).enumerate() {
                let line = h as f64 * omega;
                let rate = Complex64::new(0.0, line);
                let slope = match quantity {
                    Quantity::Gain(_) => Complex64::from(sensor.gain.recip()),
                    Quantity::Delay(_) => -rate,
                    _ => -rate / sensor.stage(line),
                };
                *out = a * sensor.response(line) * slope;
            }
        }
        Quantity::Offset(s) if s < column.len() => column[s][0] = Complex64::ONE,
        _ => {}
    }
    column
}
