//! The law on recovered motion: the contact without the structure around it.
//!
//! Residuals are recovered minus answered force lines over `σ_F·|1 + σ0 N R|`: an error of the recovered force moves the
//! recovered slip by `R` times as much, and that moves the law's answer by its stiffness. A law without a presliding range
//! answers by its limit and, where it sticks, by the recovered force itself: what is left there is the velocity.

mod leeway;
mod march;
mod mean;
mod problem;
mod sizes;

use crate::series_fit::SeriesContact;
use crate::study::soften;
use frettrace_forward::accelerations::{
    AccelerationError, AccelerationModel, Balance, Beside, FrequencyRatio,
};
use frettrace_fourier::{Grid, GridError};
use frettrace_friction::effects::{Hook, ModifiedLaw, ModifiedState};
pub(crate) use leeway::{Leeway, Moved};
pub(crate) use march::{LANES, columns};
pub(crate) use mean::{mean_force, places};
use nalgebra::DMatrixViewMut;
use num_complex::Complex64;
pub(crate) use problem::ContactProblem;
use std::sync::Arc;

/// Recovered motion and force lines of one run.
#[derive(Clone)]
pub(crate) struct Recovered {
    /// Index of the run.
    run: usize,
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
    worked: [f64; 2],
    /// Line of the excitation.
    driven: usize,
    /// Phase at the first sample of a base line that follows the excitation (rad).
    base_phase: f64,
    /// Static compliance of the structure at the contact (m/N).
    give: f64,
    /// First line compared: the mean, where the slip has one.
    first: usize,
}

/// Highest line (of the excitation) of the force that is compared, …
const LINES: usize = 24;
/// … and of the motion: what a corner of stick and slip sends above the last line comes back on the lines just below it.
const MOTION_LINES: usize = 5 * LINES;
/// Relative accuracy of a recovered force line: what is left of the structure's errors.
const RELATIVE_ACCURACY: f64 = 3e-4;

/// Share of a line to which a force counts in [`Contacts::softened`].
const SOFT: f64 = 0.02;

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
        let stiffness_of_end = model.rig().lever.map_or(0.0, |_| model.rig().boundary.support_stiffness);
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
            .collect::<Vec<_>>();
        let mean_deviation = deviation.get(1).copied().unwrap_or(f64::INFINITY);
        let deviation = std::iter::once(mean_deviation).chain(deviation.into_iter().skip(1)).collect();
        let dt = std::f64::consts::TAU / lines.omega / samples as f64;
        Ok(Self {
            run,
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
            worked: lines.worked,
            driven: lines.driven(),
            base_phase: lines.base_phase,
            give: balance.slip_gain[0].re,
            first: 1,
        })
    }

    /// The same motion around a mean slip (m) that no accelerometer sees. The structure holds it there: `F̄ = −ū/R₀` with its static
    /// compliance `R₀`, to the accuracy of the first line.
    pub fn around(&self, mean: f64) -> Self {
        let held = -mean / self.give;
        let mut moved = Self { first: 0, ..self.clone() };
        moved.slip.iter_mut().for_each(|u| *u += mean);
        moved.trial.iter_mut().for_each(|trial| *trial += held);
        moved.force[0] = Complex64::from(held);
        moved
    }

    /// The same on every second sample, where enough are left for the lines compared: for a first look.
    fn coarse(&self) -> Self {
        let compared = self.force.len() - 1;
        let samples = self.slip.len() / 2;
        let grid = if samples < 8 * compared { None } else { Grid::new(compared, samples).ok() };
        // Where a rigid contact's force jumps is known to a part of a sample.
        let Some(grid) = grid.filter(|_| self.trial.is_empty()) else { return self.clone() };
        let thin = |x: &[f64]| x.iter().step_by(2).copied().collect();
        Self {
            slip: thin(&self.slip),
            velocity: thin(&self.velocity),
            normal: thin(&self.normal),
            grid,
            dt: 2.0 * self.dt,
            ..self.clone()
        }
    }

    /// The same with lines that count by their size.
    fn softened(&self) -> Self {
        let mut softened = self.clone();
        soften(&mut softened.deviation, &self.force, SOFT);
        softened
    }

    /// RMS of the slip (m).
    fn stroke(&self) -> f64 {
        (self.slip.iter().map(|u| u * u).sum::<f64>() / self.slip.len() as f64).sqrt()
    }

    fn residual(
        &self,
        law: &ModifiedLaw<f64>,
        modulation: FrequencyRatio,
        out: &mut [f64],
    ) -> ModifiedState<f64> {
        let (state, force) = self.settled(law, modulation);
        self.left(&force, out);
        state
    }

    /// Derivatives of the residual by the hooks of a law, a column each, with the `state` in which its settled period begins.
    fn linearise(
        &self,
        (law, modulation): (&ModifiedLaw<f64>, FrequencyRatio),
        hooks: &[(usize, Hook)],
        (state, jacobian): (ModifiedState<f64>, DMatrixViewMut<'_, f64>),
    ) {
        let whitened = |samples: &[f64]| {
            let lines = self.lines(samples);
            (self.first..self.force.len()).map(|h| lines[h] / self.deviation[h]).collect()
        };
        let lanes = LANES - law.states();
        columns((law, hooks), (jacobian, lanes), |law| self.slopes(law, modulation, state), whitened);
    }

    /// Recovered less answered force over the deviations.
    fn left(&self, answered: &[f64], out: &mut [f64]) {
        let lines = self.lines(answered);
        for (pair, h) in out.chunks_exact_mut(2).zip(self.first..self.force.len()) {
            let left = (self.force[h] - lines[h]) / self.deviation[h];
            pair.copy_from_slice(&[left.re, left.im]);
        }
    }

    /// Lines of a period.
    fn lines(&self, samples: &[f64]) -> Vec<Complex64> {
        let mut lines = vec![Complex64::ZERO; self.grid.order() + 1];
        self.grid.project(samples, &mut lines, &mut self.grid.scratch());
        lines
    }

    fn count(&self) -> usize {
        2 * (self.force.len() - self.first)
    }
}

/// Recovered contacts of periodic runs, line by line, and of the others, bin by bin.
#[derive(Clone)]
pub(crate) struct Contacts {
    pub periodic: Vec<Recovered>,
    /// The others, each with the index of its run.
    pub series: Vec<(usize, Arc<SeriesContact>)>,
    /// What the structure leaves open in the periodic ones.
    pub leeway: Option<Arc<Leeway>>,
}

impl Contacts {
    /// The same where the structure leaves open what it does around another law.
    pub fn around(&self, law: &ModifiedLaw<f64>, modulation: FrequencyRatio) -> Self {
        let leeway = self.leeway.as_ref().and_then(|leeway| leeway.around((law, modulation)));
        Self { leeway: leeway.map(Arc::new), ..self.clone() }
    }

    /// What is quick to march, for a first look: the periodic runs on fewer samples – all of them, since a single one may be what shows
    /// an effect – and the others where the periodic ones are the fewer.
    pub fn quick(&self) -> Self {
        let steady = self.steady();
        Self { periodic: steady.periodic.iter().map(Recovered::coarse).collect(), ..steady }
    }

    /// The same with every line of a periodic run known to two parts in a hundred of itself: where it is known to one in 1e4, χ² of a
    /// law far from it is a narrow bent valley that a step of any length leaves; this is a bowl around the same minimum.
    pub fn softened(&self) -> Self {
        Self { periodic: self.periodic.iter().map(Recovered::softened).collect(), ..self.clone() }
    }

    /// RMS of the slip (m) of every run, each with the index of its run.
    fn strokes(&self) -> impl Iterator<Item = (usize, f64)> {
        let periodic = self.periodic.iter().map(|run| (run.run, run.stroke()));
        periodic.chain(self.series.iter().map(|(run, series)| (*run, series.stroke())))
    }

    /// The periodic runs; the others too, where the periodic ones are the fewer.
    pub fn steady(&self) -> Self {
        let few = self.periodic.len() < self.series.len();
        let series = if few { self.series.clone() } else { Vec::new() };
        Self { periodic: self.periodic.clone(), series, leeway: self.leeway.clone() }
    }
}

/// Recovers the contact of the selected runs.
pub(crate) fn recover(
    model: &AccelerationModel,
    setting: &frettrace_forward::accelerations::Setting,
    (selected, beside): (&[(usize, usize)], Beside),
) -> Result<Vec<Recovered>, AccelerationError> {
    let runs: Vec<usize> = selected.iter().map(|s| s.0).collect();
    let balances = model.balance_beside(setting, &runs, beside)?;
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
