//! The model of all runs: prediction of the accelerations' lines from the excitation alone, and its derivatives.

use super::balance::recover;
use super::linear::{Direction, Tangent};
use super::run::{Evaluation, RunLines, State, coefficient};
use super::setting::{Quantity, Rig, Setting};
use super::structure::{Block, Layout, Structure};
use frettrace_beam::BeamError;
use frettrace_fourier::{Grid, GridError};
use frettrace_friction::effects::Hook;
use num_complex::Complex64;
use rayon::prelude::*;
use std::sync::Arc;

/// Why the model cannot be evaluated.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum AccelerationError {
    /// The beam cannot be modelled.
    #[error(transparent)]
    Beam(#[from] BeamError),
    /// The phase grid cannot carry the lines.
    #[error(transparent)]
    Grid(#[from] GridError),
    /// The contact forces of a run were not found.
    #[error(
        "run {run}: the balance of the contact forces does not close (left {left:.3} standard deviations)"
    )]
    NotBalanced {
        /// Index of the run.
        run: usize,
        /// What is left, in standard deviations of the lines.
        left: f64,
    },
}

/// Predicted lines of all sensors of one run: `[sensor][line]`.
pub type Prediction = Vec<Vec<Complex64>>;

/// A prediction with its derivatives by physical values.
#[derive(Clone, Debug, Default)]
pub struct Linearised {
    /// The prediction.
    pub prediction: Prediction,
    /// Its derivatives, one a quantity, in the order asked for.
    pub columns: Vec<Prediction>,
}

type Factor = Arc<faer::linalg::solvers::PartialPivLu<f64>>;

/// What is kept between evaluations, one a run.
#[derive(Clone, Default)]
pub struct RunMemory {
    unknowns: Vec<f64>,
    /// Factor of the derivative of the imbalance, and the unknowns it was taken at.
    factor: Option<(Factor, Arc<Vec<f64>>)>,
}

impl RunMemory {
    /// Whether the factor still belongs to the unknowns: within `1e-3` of their size.
    fn current(&self) -> Option<Factor> {
        let (factor, at) = self.factor.as_ref()?;
        let (mut change, mut size) = (0.0, 0.0);
        for (x, old) in self.unknowns.iter().zip(at.iter()) {
            change += (x - old) * (x - old);
            size += x * x;
        }
        (at.len() == self.unknowns.len() && change <= 1e-6 * size).then(|| factor.clone())
    }
}

/// What is kept between evaluations.
#[derive(Clone, Default)]
pub struct Memory {
    runs: Vec<RunMemory>,
}

/// Accelerations of a rig under known forces.
pub struct AccelerationModel {
    /// The declared rig.
    pub rig: Rig,
    /// The runs.
    pub runs: Vec<RunLines>,
    grids: Vec<Grid>,
    /// Largest imbalance of a line that still counts as balanced, in standard deviations of the line.
    pub tolerance: f64,
}

/// What the laws and the structure of one run are at given values.
pub(super) struct Prepared {
    block: Block,
    base: Vec<Complex64>,
}

impl AccelerationModel {
    /// A model of the given runs.
    ///
    /// # Errors
    /// [`AccelerationError::Grid`] where a phase grid would alias.
    pub fn new(rig: Rig, runs: Vec<RunLines>) -> Result<Self, AccelerationError> {
        let grids =
            runs.iter().map(|r| Grid::new(r.contact_order, r.samples)).collect::<Result<Vec<_>, _>>()?;
        Ok(Self { rig, runs, grids, tolerance: 0.02 })
    }

    /// Fresh memory: nothing known of any run.
    #[must_use]
    pub fn memory(&self) -> Memory {
        Memory { runs: vec![RunMemory::default(); self.runs.len()] }
    }

    pub(super) fn prepare(&self, structure: &Structure, setting: &Setting, run: usize) -> Prepared {
        let lines = &self.runs[run];
        let block = structure.block(lines.omega, lines.contact_order, lines.progress);
        let base = setting.base.map_or_else(Vec::new, |[re, im]| {
            let rows = structure.layout().rows();
            let factor = Complex64::new(re, im);
            structure
                .transmissibility(lines.omega, lines.contact_order, self.rig.lever.is_some())
                .into_iter()
                .enumerate()
                .map(|(k, t)| t * factor * setting.clamp_unit(lines, (run, k / rows)))
                .collect()
        });
        Prepared { block, base }
    }

    pub(super) fn evaluation<'a>(
        &'a self,
        layout: Layout,
        setting: &'a Setting,
        prepared: &'a Prepared,
        run: usize,
    ) -> Evaluation<'a> {
        let stiffness = self.rig.boundary.support_stiffness;
        Evaluation {
            lines: &self.runs[run],
            setting,
            block: &prepared.block,
            layout,
            base: &prepared.base,
            support_stiffness: if stiffness.is_finite() { stiffness } else { 0.0 },
            rotation: self.rig.lever.is_some(),
            grid: &self.grids[run],
        }
    }

    /// Predicted lines of the selected runs.
    ///
    /// # Errors
    /// [`AccelerationError`] where the structure cannot be built or a run's balance does not close.
    pub fn predict(
        &self,
        setting: &Setting,
        selected: &[usize],
        memory: &mut Memory,
    ) -> Result<Vec<Prediction>, AccelerationError> {
        let structure = Structure::new(&self.rig, setting)?;
        self.each(selected, memory, |run, kept| {
            let prepared = self.prepare(&structure, setting, run);
            let evaluation = self.evaluation(structure.layout(), setting, &prepared, run);
            solve(&evaluation, kept, self.tolerance).map_err(|left| not_balanced(run, left))?;
            Ok(distort(evaluation.accelerations(&kept.unknowns), setting, self.runs[run].omega))
        })
    }

    fn each<T: Send>(
        &self,
        selected: &[usize],
        memory: &mut Memory,
        work: impl Fn(usize, &mut RunMemory) -> Result<T, AccelerationError> + Sync,
    ) -> Result<Vec<T>, AccelerationError> {
        memory.runs.resize_with(self.runs.len(), RunMemory::default);
        let mut kept: Vec<(usize, RunMemory)> =
            selected.iter().map(|&run| (run, std::mem::take(&mut memory.runs[run]))).collect();
        let results: Vec<_> = kept.par_iter_mut().map(|(run, kept)| work(*run, kept)).collect();
        for (run, kept) in kept {
            memory.runs[run] = kept;
        }
        results.into_iter().collect()
    }

    /// Predicted lines of the selected runs and their derivatives.
    ///
    /// # Errors
    /// As [`Self::predict`].
    pub fn linearise(
        &self,
        setting: &Setting,
        quantities: &[Quantity],
        selected: &[usize],
        memory: &mut Memory,
    ) -> Result<Vec<Linearised>, AccelerationError> {
        let structure = Structure::new(&self.rig, setting)?;
        let moved = quantities
            .iter()
            .map(|&quantity| self.moved(&structure, setting, quantity))
            .collect::<Result<Vec<_>, _>>()?;
        self.each(selected, memory, |run, kept| {
            let prepared = self.prepare(&structure, setting, run);
            let evaluation = self.evaluation(structure.layout(), setting, &prepared, run);
            solve(&evaluation, kept, self.tolerance).map_err(|left| not_balanced(run, left))?;
            Ok(self.differentiate(
                &Differentiation {
                    evaluation: &evaluation,
                    structure: &structure,
                    quantities,
                    moved: &moved,
                    run,
                },
                kept,
            ))
        })
    }

    /// For a quantity whose effect on the structure is differenced: the structure beside it, and the distance.
    fn moved(
        &self,
        structure: &Structure,
        setting: &Setting,
        quantity: Quantity,
    ) -> Result<Option<(Structure, f64)>, AccelerationError> {
        let length = self.rig.beam.length;
        let distance = match quantity {
            Quantity::ModeFrequency(n) if !structure.plain() => 1e-6 * setting.frequency[n],
            Quantity::ModeDamping(n) if !structure.plain() => 1e-4 * setting.damping[n],
            Quantity::PortPosition(_) | Quantity::MassPosition | Quantity::Shift(_) => 1e-5 * length,
            Quantity::ClampCompliance => 1e-6,
            Quantity::AddedMass => 1e-6 * self.rig.beam.mass_per_length * length,
            Quantity::Drift => 1e-7,
            Quantity::ContactCompliance => 1e-6 * length / self.rig.beam.bending_stiffness,
            _ => return Ok(None),
        };
        let mut beside = setting.clone();
        beside.set(quantity, setting.get(quantity).unwrap_or_default() + distance);
        if Structure::rebuilds(quantity) {
            return Ok(Some((Structure::new(&self.rig, &beside)?, distance)));
        }
        let mut other = structure.clone();
        other.retune(&beside);
        Ok(Some((other, distance)))
    }

    fn differentiate(&self, what: &Differentiation<'_>, kept: &mut RunMemory) -> Linearised {
        let evaluation = what.evaluation;
        let mut scratch = evaluation.grid.scratch();
        let hooks: Vec<Hook> = what
            .quantities
            .iter()
            .filter_map(|q| if let Quantity::Law(hook) = q { Some(*hook) } else { None })
            .collect();
        let state = evaluation.evaluate(&kept.unknowns, &mut scratch);
        let tangent = Tangent::new(evaluation, &state, &hooks);
        let factor = kept.current().unwrap_or_else(|| {
            let factor: Factor = Arc::new(tangent.jacobian(&mut scratch).partial_piv_lu());
            kept.factor = Some((factor.clone(), Arc::new(kept.unknowns.clone())));
            factor
        });
        let plain = evaluation.accelerations(&kept.unknowns);
        let columns = what
            .quantities
            .iter()
            .enumerate()
            .map(|(index, &quantity)| {
                what.column(self, (index, quantity), &hooks, (&tangent, &factor, kept, &plain), &mut scratch)
            })
            .collect();
        let setting = evaluation.setting;
        Linearised { prediction: distort(plain, setting, evaluation.lines.omega), columns }
    }

    /// Recovered motions and forces of a run: the settled state at the current memory, for plots and shapes.
    ///
    /// # Errors
    /// As [`Self::predict`].
    pub fn contact(
        &self,
        setting: &Setting,
        run: usize,
        memory: &mut Memory,
    ) -> Result<ContactHistory, AccelerationError> {
        let structure = Structure::new(&self.rig, setting)?;
        let histories = self.each(&[run], memory, |run, kept| {
            let prepared = self.prepare(&structure, setting, run);
            let evaluation = self.evaluation(structure.layout(), setting, &prepared, run);
            solve(&evaluation, kept, self.tolerance).map_err(|left| not_balanced(run, left))?;
            let state = evaluation.evaluate(&kept.unknowns, &mut evaluation.grid.scratch());
            Ok(ContactHistory {
                slip: state.contact.slip,
                velocity: state.contact.velocity,
                normal: state.contact.normal,
                force: state.forces.into_iter().next().unwrap_or_default(),
            })
        })?;
        Ok(histories.into_iter().next().unwrap_or_default())
    }
}

/// Motion and force of the contact over one period, on the phase grid.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ContactHistory {
    /// Slip (m).
    pub slip: Vec<f64>,
    /// Slip velocity (m/s).
    pub velocity: Vec<f64>,
    /// Normal force (N).
    pub normal: Vec<f64>,
    /// Friction force (N).
    pub force: Vec<f64>,
}

fn not_balanced(run: usize, left: f64) -> AccelerationError {
    AccelerationError::NotBalanced { run, left }
}

struct Differentiation<'a> {
    evaluation: &'a Evaluation<'a>,
    structure: &'a Structure,
    quantities: &'a [Quantity],
    moved: &'a [Option<(Structure, f64)>],
    run: usize,
}

type Solved<'a> = (&'a Tangent<'a>, &'a Factor, &'a RunMemory, &'a Prediction);

impl Differentiation<'_> {
    /// Derivative of the prediction by one quantity.
    fn column(
        &self,
        model: &AccelerationModel,
        (index, quantity): (usize, Quantity),
        hooks: &[Hook],
        (tangent, factor, kept, plain): Solved<'_>,
        scratch: &mut frettrace_fourier::GridScratch,
    ) -> Prediction {
        let e = self.evaluation;
        let direct = self.motion(index, quantity, kept);
        let direction = match quantity {
            Quantity::Law(hook) => {
                Direction { hook: hooks.iter().position(|h| *h == hook), ..Direction::default() }
            }
            Quantity::Port(p, c) => Direction { coefficient: Some((p, c)), ..Direction::default() },
            _ => match &direct {
                Some(lines) => {
                    let rows = e.layout.rows();
                    tangent.direction(|row| (0..=e.order()).map(|h| lines[h * rows + row]).collect(), scratch)
                }
                None => return sensor_column(quantity, e, plain),
            },
        };
        let answer = tangent.answer(&direction, scratch);
        let right = faer::Col::from_fn(answer.len(), |i| answer[i]);
        let forces = faer::linalg::solvers::Solve::solve(factor.as_ref(), &right);
        let forces: Vec<f64> = (0..forces.nrows()).map(|i| forces[i]).collect();
        let _ = model;
        let rows = e.layout.rows();
        let change = (0..e.layout.sensors)
            .map(|s| {
                (0..=e.lines.order())
                    .map(|h| {
                        let at = h as f64 * e.lines.omega;
                        let row = Layout::sensor_row(s);
                        let mut sum = direct.as_ref().map_or(Complex64::ZERO, |d| d[h * rows + row]);
                        for port in 0..=e.layout.ports {
                            sum -= e.block.at(h, row, 1 + port) * coefficient(&forces, e.order(), port, h);
                        }
                        sum * (-at * at)
                    })
                    .collect()
            })
            .collect();
        distort_change(change, e.setting, e.lines.omega)
    }

    /// Change of the motion of every row at fixed contact forces: `∂R_e F − ∂R_f f`, `rows` values a line.
    fn motion(&self, index: usize, quantity: Quantity, kept: &RunMemory) -> Option<Vec<Complex64>> {
        let e = self.evaluation;
        let (omega, order) = (e.lines.omega, e.order());
        let derivative = match (&self.moved[index], quantity) {
            (Some((beside, distance)), _) => {
                let mut block = beside.block(omega, order, e.lines.progress);
                for (value, plain) in block.values.iter_mut().zip(&e.block.values) {
                    *value = (*value - plain) / *distance;
                }
                block
            }
            (None, Quantity::ModeFrequency(n)) => self.structure.mode_gradient(n, false, omega, order),
            (None, Quantity::ModeDamping(n)) => self.structure.mode_gradient(n, true, omega, order),
            (None, Quantity::BaseReal | Quantity::BaseImaginary) => return Some(self.base_motion(quantity)),
            _ => return None,
        };
        let changed = Evaluation { block: &derivative, base: &[], ..*e };
        let rows = e.layout.rows();
        Some(
            (0..=order)
                .flat_map(|h| (0..rows).map(move |row| (h, row)))
                .map(|(h, row)| changed.displacement(&kept.unknowns, row, h))
                .collect(),
        )
    }

    fn base_motion(&self, quantity: Quantity) -> Vec<Complex64> {
        let e = self.evaluation;
        let unit = if quantity == Quantity::BaseReal { Complex64::ONE } else { Complex64::I };
        let rows = e.layout.rows();
        self.structure
            .transmissibility(e.lines.omega, e.order(), e.rotation)
            .into_iter()
            .enumerate()
            .map(|(k, t)| t * unit * e.setting.clamp_unit(e.lines, (self.run, k / rows)))
            .collect()
    }
}

/// Sensors distort: gain, delay and offset.
fn distort(mut plain: Prediction, setting: &Setting, omega: f64) -> Prediction {
    for (lines, sensor) in plain.iter_mut().zip(&setting.sensors) {
        for (h, line) in lines.iter_mut().enumerate() {
            let phase = Complex64::from_polar(sensor.gain, -(h as f64) * omega * sensor.delay);
            *line = *line * phase + if h == 0 { sensor.offset } else { 0.0 };
        }
    }
    plain
}

fn distort_change(mut change: Prediction, setting: &Setting, omega: f64) -> Prediction {
    for (lines, sensor) in change.iter_mut().zip(&setting.sensors) {
        for (h, line) in lines.iter_mut().enumerate() {
            *line *= Complex64::from_polar(sensor.gain, -(h as f64) * omega * sensor.delay);
        }
    }
    change
}

/// Derivative by what only a sensor does.
fn sensor_column(quantity: Quantity, e: &Evaluation<'_>, plain: &Prediction) -> Prediction {
    let mut column: Prediction = plain.iter().map(|lines| vec![Complex64::ZERO; lines.len()]).collect();
    let omega = e.lines.omega;
    match quantity {
        Quantity::Gain(s) | Quantity::Delay(s) if s < column.len() => {
            let sensor = e.setting.sensors[s];
            for (h, (out, a)) in column[s].iter_mut().zip(&plain[s]).enumerate() {
                let turn = Complex64::from_polar(1.0, -(h as f64) * omega * sensor.delay);
                *out = a * turn;
                if matches!(quantity, Quantity::Delay(_)) {
                    *out *= Complex64::new(0.0, -(h as f64) * omega) * sensor.gain;
                }
            }
        }
        Quantity::Offset(s) if s < column.len() => column[s][0] = Complex64::ONE,
        _ => {}
    }
    column
}

/// Largest effect of an imbalance of the forces on any line, in standard deviations.
fn imbalance(e: &Evaluation<'_>, difference: &[f64]) -> f64 {
    let mut worst: f64 = 0.0;
    for s in 0..e.layout.sensors {
        for h in 1..=e.lines.order() {
            let at = h as f64 * e.lines.omega;
            let mut sum = Complex64::ZERO;
            for port in 0..=e.layout.ports {
                sum += e.block.at(h, Layout::sensor_row(s), 1 + port)
                    * coefficient(difference, e.order(), port, h);
            }
            worst = worst.max(sum.norm() * at * at / e.lines.deviation[s][h]);
        }
    }
    worst
}

/// Share of the tolerance that a rigid contact is held to: there the imbalance is of held forces and velocities.
const RIGID: f64 = 0.1;

/// Newton's method with a kept factor, renewed where it no longer contracts.
fn solve(e: &Evaluation<'_>, kept: &mut RunMemory, tolerance: f64) -> Result<(), f64> {
    let mut scratch = e.grid.scratch();
    if kept.unknowns.len() != e.width() {
        kept.factor = None;
        kept.unknowns = recover(e);
    }
    let tolerance = if e.rigid() { RIGID * tolerance } else { tolerance };
    let mut best = f64::INFINITY;
    let mut fresh = false;
    for _ in 0..40 {
        let state = e.evaluate(&kept.unknowns, &mut scratch);
        let answer = e.answer(&state, &mut scratch);
        let difference: Vec<f64> = kept.unknowns.iter().zip(&answer).map(|(x, a)| x - a).collect();
        let left = imbalance(e, &difference);
        if !left.is_finite() {
            kept.unknowns.clear();
            return Err(left);
        }
        if left < tolerance {
            return Ok(());
        }
        let slow = left > 0.3 * best;
        best = best.min(left);
        if kept.factor.is_none() || (slow && !fresh) {
            let factor = factorise(e, &state, &mut scratch);
            kept.factor = Some((factor, Arc::new(kept.unknowns.clone())));
            fresh = true;
        } else {
            fresh = false;
        }
        let Some((factor, _)) = &kept.factor else { return Err(left) };
        let right = faer::Col::from_fn(difference.len(), |i| difference[i]);
        let step = faer::linalg::solvers::Solve::solve(factor.as_ref(), &right);
        descend(e, kept, &step, left, &mut scratch);
    }
    kept.unknowns.clear();
    Err(best)
}

fn factorise(e: &Evaluation<'_>, state: &State, scratch: &mut frettrace_fourier::GridScratch) -> Factor {
    Arc::new(Tangent::new(e, state, &[]).jacobian(scratch).partial_piv_lu())
}

/// Goes along the step as far as the imbalance does not grow.
fn descend(
    e: &Evaluation<'_>,
    kept: &mut RunMemory,
    step: &faer::Col<f64>,
    left: f64,
    scratch: &mut frettrace_fourier::GridScratch,
) {
    let from = kept.unknowns.clone();
    let mut share = 1.0;
    for _ in 0..6 {
        for (i, (x, old)) in kept.unknowns.iter_mut().zip(&from).enumerate() {
            *x = old - share * step[i];
        }
        let state = e.evaluate(&kept.unknowns, scratch);
        let answer = e.answer(&state, scratch);
        let difference: Vec<f64> = kept.unknowns.iter().zip(&answer).map(|(x, a)| x - a).collect();
        if imbalance(e, &difference) < 1.5 * left {
            return;
        }
        share *= 0.4;
    }
}
