//! The law on recovered motion: the contact without the structure around it.
//!
//! Residuals are recovered minus answered force lines over `σ_F·|1 + σ0 N R|`: an error of the recovered force moves the
//! recovered slip by `R` times as much, and that moves the law's answer by its stiffness. A law without a presliding range
//! answers by its limit and, where it sticks, by the recovered force itself: what is left there is the velocity.

mod march;

use crate::series_fit::SeriesContact;
use frettrace_forward::accelerations::{AccelerationError, AccelerationModel, Balance};
use frettrace_fourier::{Grid, GridError};
use frettrace_friction::effects::{Hook, ModifiedLaw};
use frettrace_identify::{Fit, FitSettings, IdentifyError, Model, NoSolution, Parameter, fit};
pub(crate) use march::{LANES, columns};
use nalgebra::{DMatrix, DMatrixViewMut};
use num_complex::Complex64;
use std::sync::Arc;

/// Recovered motion and force lines of one run.
#[derive(Clone)]
pub(crate) struct Recovered {
    pub slip: Vec<f64>,
    pub velocity: Vec<f64>,
    pub normal: Vec<f64>,
    pub force: Vec<Complex64>,
    pub deviation: Vec<f64>,
    /// Recovered force with the velocity's share, which a rigid contact takes as long as it holds; empty where the contact
    /// yields.
    trial: Vec<f64>,
    grid: Grid,
    dt: f64,
    preload: f64,
    progress: f64,
}

/// Highest line (of the excitation) of the force that is compared, …
const LINES: usize = 24;
/// … and of the motion: what a corner of stick and slip sends above the last line comes back on the lines just below it.
const MOTION_LINES: usize = 5 * LINES;
/// Relative accuracy of a recovered force line: what is left of the structure's errors.
const RELATIVE_ACCURACY: f64 = 3e-4;

/// Part of a sample by which the jump of a rigid contact's force may be misplaced.
const JUMP: f64 = 0.25;

/// How a law answers to recovered motion.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Answer {
    /// By the stiffness (N/m) of its presliding range.
    Yielding(f64),
    /// Set-valued at rest: where it sticks it takes the recovered force.
    Rigid,
}

/// Mean impedance of the structure at the contact (N·s/m).
fn resistance(balance: &Balance, omega: f64, order: usize) -> f64 {
    let impedance = |h: usize| -(balance.slip_gain[h].norm() * h as f64 * omega).ln();
    ((1..=order).map(impedance).sum::<f64>() / order.max(1) as f64).exp()
}

impl Recovered {
    pub fn new(
        model: &AccelerationModel,
        (run, subharmonic): (usize, usize),
        balance: &Balance,
        answer: Answer,
    ) -> Result<Self, GridError> {
        let lines = &model.runs[run];
        let order = lines.order().min(MOTION_LINES * subharmonic);
        let compared = order.min(LINES * subharmonic);
        // Enough for every line of the motion; beyond that 512 do.
        let wanted = (4 * order).max(8 * compared).next_power_of_two().clamp(128, 512);
        let samples = wanted.max((2 * order + 1).next_power_of_two());
        let grid = Grid::new(order, samples)?;
        let mut scratch = grid.scratch();
        let mut sampled = |of: &dyn Fn(usize) -> Complex64| {
            let lines: Vec<Complex64> =
                (0..=order).map(|h| if h == 0 { Complex64::ZERO } else { of(h) }).collect();
            let mut out = vec![0.0; samples];
            grid.evaluate(&lines, &mut out, &mut scratch);
            out
        };
        let slip = sampled(&|h| balance.slip[h]);
        let velocity = sampled(&|h| balance.slip[h] * Complex64::new(0.0, h as f64 * lines.omega));
        let end = sampled(&|h| balance.end[h]);
        let turns = model.rig().lever.is_some();
        let stiffness_of_end = if turns && model.rig().boundary.support_stiffness.is_finite() {
            model.rig().boundary.support_stiffness
        } else {
            0.0
        };
        let normal = end.iter().map(|w| lines.preload - stiffness_of_end * w).collect();
        let resistance = match answer {
            Answer::Rigid => resistance(balance, lines.omega, order),
            Answer::Yielding(_) => 0.0,
        };
        let mut trial = Vec::new();
        if matches!(answer, Answer::Rigid) {
            trial = sampled(&|h| balance.force[h]);
            trial.iter_mut().zip(&velocity).for_each(|(trial, v)| *trial += resistance * v);
        }
        let peak = balance.force.iter().map(|f| f.norm()).fold(0.0, f64::max);
        // A force that jumps where the slip turns is late or early by a part of a sample: the same on every line.
        let jump = JUMP * std::f64::consts::TAU / samples as f64;
        let accuracy = |h: usize| match answer {
            Answer::Rigid => jump,
            Answer::Yielding(_) => RELATIVE_ACCURACY / (1.0 + h as f64),
        };
        let deviation = (0..=compared)
            .map(|h| {
                let answer = match answer {
                    Answer::Yielding(stiffness) => 1.0 + balance.slip_gain[h] * stiffness,
                    Answer::Rigid => {
                        1.0 + balance.slip_gain[h] * Complex64::new(0.0, resistance * h as f64 * lines.omega)
                    }
                };
                (balance.force_deviation[h] * answer.norm()).hypot(accuracy(h) * peak)
            })
            .collect();
        let dt = std::f64::consts::TAU / lines.omega / samples as f64;
        Ok(Self {
            slip,
            velocity,
            normal,
            force: balance.force[..=compared].to_vec(),
            deviation,
            trial,
            grid,
            dt,
            preload: lines.preload,
            progress: lines.progress,
        })
    }

    fn residual(&self, law: &ModifiedLaw<f64>, modulation: usize, out: &mut [f64]) {
        self.left(&self.answer(law, modulation), out);
    }

    /// The residual, and its derivatives by the hooks of a law, a column each.
    fn linearise(
        &self,
        (law, modulation): (&ModifiedLaw<f64>, usize),
        hooks: &[(usize, Hook)],
        (residual, jacobian): (&mut [f64], DMatrixViewMut<'_, f64>),
    ) {
        let (state, force) = self.settled(law, modulation);
        self.left(&force, residual);
        let whitened = |samples: &[f64]| {
            let lines = self.lines(samples);
            (1..self.force.len()).map(|h| lines[h] / self.deviation[h]).collect()
        };
        let lanes = LANES - law.states();
        columns((law, hooks), (jacobian, lanes), |law| self.slopes(law, modulation, state), whitened);
    }

    /// Recovered less answered force over the deviations.
    fn left(&self, answered: &[f64], out: &mut [f64]) {
        let lines = self.lines(answered);
        for h in 1..self.force.len() {
            let left = (self.force[h] - lines[h]) / self.deviation[h];
            out[2 * h - 2] = left.re;
            out[2 * h - 1] = left.im;
        }
    }

    /// Lines of a period.
    fn lines(&self, samples: &[f64]) -> Vec<Complex64> {
        let mut lines = vec![Complex64::ZERO; self.grid.order() + 1];
        self.grid.project(samples, &mut lines, &mut self.grid.scratch());
        lines
    }

    fn count(&self) -> usize {
        2 * (self.force.len() - 1)
    }

    /// RMS of the friction force over the mean normal force, and that over the RMS of the slip (1/m).
    fn sizes(&self) -> [f64; 2] {
        let samples = self.slip.len() as f64;
        let force = (0.5 * self.force.iter().skip(1).map(Complex64::norm_sqr).sum::<f64>()).sqrt();
        let slip = (self.slip.iter().map(|u| u * u).sum::<f64>() / samples).sqrt();
        let share = force / (self.normal.iter().sum::<f64>() / samples).max(f64::MIN_POSITIVE);
        [share, share / slip.max(f64::MIN_POSITIVE)]
    }
}

/// Recovered contacts of periodic runs, line by line, and of the others, bin by bin.
#[derive(Clone)]
pub(crate) struct Contacts {
    pub periodic: Vec<Recovered>,
    pub series: Vec<Arc<SeriesContact>>,
}

impl Contacts {
    /// Friction coefficient and presliding stiffness (1/m) by their sizes: the largest RMS of `F/N`, where the contact slides most,
    /// and of `F/(N u)`, where it sticks most. `None` without periodic runs.
    pub fn sizes(&self) -> Option<[f64; 2]> {
        let larger = |[a, b]: [f64; 2], [c, d]: [f64; 2]| [a.max(c), b.max(d)];
        self.periodic.iter().map(Recovered::sizes).reduce(larger).filter(|s| s.iter().all(|x| x.is_normal()))
    }

    /// What is quick to march: the periodic runs, where they are not the fewer.
    pub fn quick(&self) -> Self {
        let few = self.periodic.len() < self.series.len();
        let series = if few { self.series.clone() } else { Vec::new() };
        Self { periodic: self.periodic.clone(), series }
    }
}

/// A law with some of its hooks free, against recovered contacts.
pub(crate) struct ContactProblem<'a> {
    pub recovered: &'a Contacts,
    pub law: ModifiedLaw<f64>,
    pub modulation: usize,
    pub hooks: Vec<Hook>,
    pub parameters: Vec<Parameter>,
}

impl ContactProblem<'_> {
    pub fn at(&self, values: &[f64]) -> ModifiedLaw<f64> {
        let mut law = self.law;
        for (&hook, &value) in self.hooks.iter().zip(values) {
            law.set(hook, value);
        }
        law
    }

    pub fn solve(&self, most: usize) -> Result<Fit, IdentifyError> {
        let start: Vec<f64> = self.hooks.iter().map(|h| self.law.get(*h).unwrap_or_default()).collect();
        let settings = FitSettings {
            max_iterations: most,
            relative_tolerance: 1e-3,
            absolute_tolerance: 0.5,
            secant: true,
            ..FitSettings::default()
        };
        fit(self, &start, &settings)
    }
}

impl Model for ContactProblem<'_> {
    type Memory = ();

    fn parameters(&self) -> &[Parameter] {
        &self.parameters
    }

    fn residual_count(&self) -> usize {
        let lines: usize = self.recovered.periodic.iter().map(Recovered::count).sum();
        lines + self.recovered.series.iter().map(|s| s.count()).sum::<usize>()
    }

    fn memory(&self) {}

    fn residual(&self, values: &[f64], _memory: &mut (), residual: &mut [f64]) -> Result<(), NoSolution> {
        let law = self.at(values);
        let mut at = 0;
        for recovered in &self.recovered.periodic {
            recovered.residual(&law, self.modulation, &mut residual[at..at + recovered.count()]);
            at += recovered.count();
        }
        for series in &self.recovered.series {
            series.residual(&law, &mut residual[at..at + series.count()]);
            at += series.count();
        }
        if residual.iter().all(|r| r.is_finite()) { Ok(()) } else { Err(NoSolution) }
    }

    fn linearise(
        &self,
        values: &[f64],
        free: &[bool],
        _memory: &mut (),
        target: (&mut [f64], &mut DMatrix<f64>),
    ) -> Result<(), NoSolution> {
        let (residual, jacobian) = target;
        let law = self.at(values);
        let hooks: Vec<(usize, Hook)> =
            self.hooks.iter().copied().enumerate().filter(|(j, _)| free[*j]).collect();
        let mut at = 0;
        for recovered in &self.recovered.periodic {
            let rows = at..at + recovered.count();
            let part = (&mut residual[rows.clone()], jacobian.rows_mut(rows.start, rows.len()));
            recovered.linearise((&law, self.modulation), &hooks, part);
            at = rows.end;
        }
        for series in &self.recovered.series {
            let rows = at..at + series.count();
            let part = (&mut residual[rows.clone()], jacobian.rows_mut(rows.start, rows.len()));
            series.linearise(&law, &hooks, part);
            at = rows.end;
        }
        let finite = residual.iter().chain(jacobian.iter()).all(|value| value.is_finite());
        if finite { Ok(()) } else { Err(NoSolution) }
    }
}

/// Recovers the contact of the selected runs.
pub(crate) fn recover(
    model: &AccelerationModel,
    setting: &frettrace_forward::accelerations::Setting,
    selected: &[(usize, usize)],
) -> Result<Vec<Recovered>, AccelerationError> {
    let runs: Vec<usize> = selected.iter().map(|s| s.0).collect();
    let balances = model.balance(setting, &runs)?;
    selected
        .iter()
        .zip(&balances)
        .map(|(&run, balance)| {
            let sigma0 = setting.law.get(Hook::Sigma0).unwrap_or(1e5);
            let yielding = Answer::Yielding(sigma0 * model.runs[run.0].preload);
            let answer = if setting.rigid { Answer::Rigid } else { yielding };
            Ok(Recovered::new(model, run, balance, answer)?)
        })
        .collect()
}

#[cfg(test)]
mod tests;
