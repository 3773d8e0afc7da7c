//! The force of a declared second support: unknown in every line, whatever law holds in the contact.
//!
//! A change `δ` of its lines moves the whitened prediction of a run by `B δ`, the answer of the contact included. With
//! `B = Q₁R` the residuals fall into those that a support force takes, `Q₁ᵀr`, and the rest `Q₂ᵀr`, which none explains. Law
//! and structure are fitted to the rest, and the support force follows as `R⁻¹Q₁ᵀr` (variable projection: Golub and Pereyra,
//! SIAM J. Numer. Anal. 10 (1973) 413). A force recovered once and then held would count its errors as those of the law.
//!
//! Of `n` residuals whose deviation is one, the rest of a right model has the sum of squares `n − rank B`, and of each residual
//! `Q₁Q₁ᵀ` has on its diagonal what the support force takes of its noise.

use crate::{ExplainError, Fitted, Study};
use frettrace_forward::accelerations::{AccelerationModel, Memory, Prediction, RunLines, Setting};
use frettrace_fourier::Grid;
use nalgebra::{DMatrix, DVector, Dyn, QR};
use num_complex::Complex64;
use rayon::prelude::*;

/// Step of a difference quotient in standard deviations of the line: far above the tolerance of the contact's balance …
const STEP: f64 = 10.0;
/// … and at most this share of the largest line.
const MOST_STEP: f64 = 1e-2;

/// Share of a period for which a force must rest on one level for that level to be none: a contact with clearance is open.
const RESTING: f64 = 0.4;
/// Width of such a level as a share of the range of the force; 40 % of a sine's period take a third of it.
const LEVEL: f64 = 0.08;
/// Samples of a period on which the level is looked for.
const SAMPLES: usize = 1024;

/// What a support force does to the residuals of some runs.
pub struct SupportForce {
    /// Of each run of the model; `None` of runs that were not asked.
    runs: Vec<Option<Taken>>,
}

struct Taken {
    factor: QR<f64, Dyn, Dyn>,
    /// `Q₁`.
    basis: DMatrix<f64>,
}

/// Sets the means of the support forces, which no accelerometer sees though they load the contact: where a force rests on
/// one level for a good part of the period the support is open, and that level is zero.
pub fn set_means<'a>(runs: impl IntoIterator<Item = &'a mut RunLines>) {
    for run in runs {
        let (mean, _) = mean(&run.known_force);
        if let Some(line) = run.known_force.first_mut() {
            *line = Complex64::from(mean);
        }
    }
}

/// Mean (N) of a force from its other lines, and its standard deviation: that of a uniform distribution over the level it rests
/// on, or over the whole range where it rests nowhere.
#[must_use]
pub fn mean(lines: &[Complex64]) -> (f64, f64) {
    let order = lines.len().saturating_sub(1);
    let Ok(grid) = Grid::new(order, SAMPLES.max((4 * order).next_power_of_two())) else { return (0.0, 0.0) };
    let mut varying = lines.to_vec();
    varying.iter_mut().take(1).for_each(|line| *line = Complex64::ZERO);
    let mut force = vec![0.0; grid.samples()];
    grid.evaluate(&varying, &mut force, &mut grid.scratch());
    force.sort_by(f64::total_cmp);
    let inside = (RESTING * force.len() as f64) as usize;
    let range = force[force.len() - 1] - force[0];
    let width = |k: &usize| force[k + inside] - force[*k];
    let level = (0..force.len() - inside).min_by(|a, b| width(a).total_cmp(&width(b))).unwrap_or(0);
    if width(&level) > LEVEL * range {
        return (0.0, range / 12.0_f64.sqrt());
    }
    (-force[level + inside / 2], width(&level) / 12.0_f64.sqrt())
}

impl Taken {
    fn new(derivative: DMatrix<f64>) -> Self {
        let factor = derivative.qr();
        Self { basis: factor.q(), factor }
    }
}

impl SupportForce {
    /// Differences the predictions of some runs by the force of the declared second support; `None` without one.
    ///
    /// # Errors
    /// [`ExplainError::Model`] where a run does not balance.
    pub fn new(study: &Study<'_>, fitted: &Fitted, selected: &[usize]) -> Result<Option<Self>, ExplainError> {
        if study.case.rig.known_support.is_none() {
            return Ok(None);
        }
        let taken = |run: &usize| {
            let model = study.model.with_runs(study.model.runs.clone())?;
            Ok((*run, Taken::new(derivative(model, (&fitted.setting, *run, fitted.memory.clone()))?)))
        };
        let found = selected.par_iter().map(taken).collect::<Result<Vec<_>, ExplainError>>()?;
        let mut runs: Vec<Option<Taken>> = study.model.runs.iter().map(|_| None).collect();
        found.into_iter().for_each(|(run, taken)| runs[run] = Some(taken));
        Ok(Some(Self { runs }))
    }

    fn of(&self, run: usize) -> Option<&Taken> {
        self.runs.get(run)?.as_ref()
    }

    /// Number of residuals of a run that the support force takes.
    #[must_use]
    pub fn taken(&self, run: usize) -> usize {
        self.of(run).map_or(0, |taken| taken.basis.ncols())
    }

    /// What is left, where no support force reaches, of columns of the residuals of some runs, one run below the other with so many
    /// rows each.
    #[must_use]
    pub fn rest(&self, runs: &[(usize, usize)], mut all: DMatrix<f64>) -> DMatrix<f64> {
        let taken: usize = runs.iter().map(|(run, _)| self.taken(*run)).sum();
        let mut out = DMatrix::zeros(all.nrows() - taken, all.ncols());
        let (mut from, mut to) = (0, 0);
        for &(run, rows) in runs {
            if let Some(taken) = self.of(run) {
                taken.factor.q_tr_mul(&mut all.rows_mut(from, rows));
            }
            let taken = self.taken(run);
            let left = rows - taken;
            out.rows_mut(to, left).copy_from(&all.rows(from + taken, left));
            from += rows;
            to += left;
        }
        out
    }

    /// The prediction of a run with the support force that leaves least of the lines.
    pub(crate) fn completed(&self, run: usize, lines: &RunLines, mut predicted: Prediction) -> Prediction {
        let Some(taken) = self.of(run) else { return predicted };
        let change = &taken.basis * taken.basis.tr_mul(&whitened(lines, &predicted));
        let own = predicted.iter_mut().flatten().zip(lines.deviation.iter().flatten());
        for ((line, std), pair) in own.zip(change.as_slice().chunks(2)) {
            *line += Complex64::new(pair[0], pair[1]) * *std;
        }
        predicted
    }

    /// What the support force takes of the noise of each sensor in a run, as a mean square ((m/s²)²); nothing where none was asked.
    pub(crate) fn noise_taken(&self, run: usize, lines: &RunLines) -> Vec<f64> {
        let Some(taken) = self.of(run) else { return vec![0.0; lines.deviation.len()] };
        let mut rows = taken.basis.row_iter().map(|row| row.norm_squared());
        let mut of_line = |std: &f64| {
            let share: f64 = rows.by_ref().take(2).sum();
            // A line of amplitude `a` has the mean square `a²/2`.
            0.5 * std * std * share
        };
        lines.deviation.iter().map(|lines| lines.iter().map(&mut of_line).sum()).collect()
    }

    /// Moves the support force of each run that was asked to where it leaves least of what `fitted` predicts of it.
    pub fn renew(&self, study: &mut Study<'_>, fitted: &Fitted) {
        for (run, taken) in self.runs.iter().enumerate() {
            let Some(taken) = taken else { continue };
            let predicted = study.model.predict(&fitted.setting, &[run], &mut fitted.memory.clone());
            let Some(predicted) = predicted.ok().and_then(|all| all.into_iter().next()) else { continue };
            let lines = &mut study.model.runs[run];
            let head = taken.basis.tr_mul(&whitened(lines, &predicted));
            let Some(change) = taken.factor.r().solve_upper_triangular(&head) else { continue };
            for (line, pair) in lines.known_force.iter_mut().skip(1).zip(change.as_slice().chunks(2)) {
                *line += Complex64::new(pair[0], pair[1]);
            }
        }
        set_means(&mut study.model.runs);
    }
}

/// Measured minus predicted lines over their deviations, real and imaginary parts.
fn whitened(lines: &RunLines, predicted: &Prediction) -> DVector<f64> {
    let all = lines.acceleration.iter().flatten().zip(predicted.iter().flatten());
    let left = all.zip(lines.deviation.iter().flatten()).flat_map(|((measured, predicted), std)| {
        let left = (measured - predicted) / std;
        [left.re, left.im]
    });
    DVector::from_iterator(2 * lines.deviation.iter().map(Vec::len).sum::<usize>(), left)
}

/// Derivative of the whitened prediction of a run by real and imaginary parts of the lines of the support force.
fn derivative(
    mut model: AccelerationModel,
    (setting, run, mut memory): (&Setting, usize, Memory),
) -> Result<DMatrix<f64>, ExplainError> {
    let plain = model.predict(setting, &[run], &mut memory)?;
    let lines = &model.runs[run];
    let deviation = lines.deviation.clone();
    let order = lines.order().min(lines.known_force.len().saturating_sub(1));
    let largest = lines.known_force.iter().map(|force| force.norm()).fold(0.0, f64::max);
    let rows: usize = deviation.iter().map(|lines| 2 * lines.len()).sum();
    let mut matrix = DMatrix::zeros(rows, 2 * order);
    for column in 0..2 * order {
        let line = 1 + column / 2;
        let unit = if column % 2 == 0 { Complex64::ONE } else { Complex64::I };
        let held = model.runs[run].known_force[line];
        let mut step = MOST_STEP * largest;
        for _ in 0..2 {
            model.runs[run].known_force[line] = held + unit * step;
            let moved = model.predict(setting, &[run], &mut memory.clone())?;
            let mut row = 0;
            let mut size = 0.0_f64;
            for ((moved, plain), deviation) in moved[0].iter().zip(&plain[0]).zip(&deviation) {
                for ((moved, plain), deviation) in moved.iter().zip(plain).zip(deviation) {
                    let change = (moved - plain) / (step * deviation);
                    matrix[(row, column)] = change.re;
                    matrix[(row + 1, column)] = change.im;
                    size = size.max(change.norm());
                    row += 2;
                }
            }
            let wanted = STEP / size.max(f64::MIN_POSITIVE);
            if wanted >= step {
                break;
            }
            step = wanted;
        }
        model.runs[run].known_force[line] = held;
    }
    Ok(matrix)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two sensors with three lines each, and a support force of two lines: 12 residuals, of which 4 are taken.
    fn run() -> (RunLines, SupportForce) {
        let line = |k: usize| Complex64::new((1.3 * k as f64).sin(), (0.7 * k as f64).cos());
        let lines = RunLines {
            omega: 1.0,
            preload: 1.0,
            progress: 0.0,
            worked: [0.0; 2],
            force: vec![Complex64::ZERO; 3],
            acceleration: vec![(0..3).map(line).collect(), (3..6).map(line).collect()],
            deviation: vec![vec![0.1, 0.2, 0.3], vec![0.4, 0.5, 0.6]],
            base_phase: 0.0,
            known_force: vec![Complex64::ZERO; 3],
            contact_order: 2,
            samples: 16,
        };
        let derivative = DMatrix::from_fn(12, 4, |i, j| ((i * i + 3 * j * i + j) as f64).sin());
        (lines, SupportForce { runs: vec![None, Some(Taken::new(derivative))] })
    }

    /// What is left of a change that the support force makes is nothing, of any other no more than itself; a run that was not asked keeps
    /// everything. The prediction with the support force leaves as much of the lines as the rest of the residuals.
    #[test]
    fn the_rest_is_what_no_support_force_makes() {
        let (lines, support) = run();
        let derivative = support.of(1).unwrap().factor.q() * support.of(1).unwrap().factor.r();
        assert!(support.rest(&[(1, 12)], derivative).abs().max() < 1e-12);
        let other = DMatrix::from_fn(12, 1, |i, _| (i as f64 + 0.5).cos());
        assert!(support.rest(&[(0, 12)], other.clone()) == other);
        let none: Prediction = vec![vec![Complex64::ZERO; 3]; 2];
        let before = whitened(&lines, &none);
        let rest = support.rest(&[(1, 12)], DMatrix::from_column_slice(12, 1, before.as_slice()));
        assert_eq!(rest.nrows(), 8);
        let after = whitened(&lines, &support.completed(1, &lines, none));
        assert!((after.norm() - rest.norm()).abs() < 1e-12 && after.norm() < 0.95 * before.norm());
    }

    /// The trace of `Q₁Q₁ᵀ` is the number of its columns: with all deviations one, half of the four taken residuals in mean squares.
    #[test]
    fn noise_taken_counts_the_unknowns() {
        let (mut lines, support) = run();
        lines.deviation = vec![vec![1.0; 3]; 2];
        let taken: f64 = support.noise_taken(1, &lines).iter().sum();
        assert!((taken - 2.0).abs() < 1e-12, "{taken}");
        assert_eq!(support.noise_taken(0, &lines), vec![0.0; 2]);
    }

    /// A blow `max(sin θ − c, 0)` rests two thirds of its period at zero: its mean `(√(1−c²) − c·acos c)/π` comes back from the
    /// other lines within the width of the level, which the cut series makes; a sine rests nowhere, and its mean is anywhere.
    #[test]
    fn a_force_with_pauses_has_a_mean() {
        let c = 0.5_f64;
        let grid = Grid::new(40, 512).unwrap();
        let at = |k: usize| (std::f64::consts::TAU * k as f64 / 512.0).sin();
        let blow: Vec<f64> = (0..512).map(|k| 30.0 * (at(k) - c).max(0.0)).collect();
        let mut lines = vec![Complex64::ZERO; 41];
        grid.project(&blow, &mut lines, &mut grid.scratch());
        let true_mean = 30.0 * ((1.0 - c * c).sqrt() - c * c.acos()) / std::f64::consts::PI;
        let (found, deviation) = mean(&lines);
        assert!(
            (found - true_mean).abs() < 3.0 * deviation && deviation < 0.03 * 15.0,
            "{found} {deviation}"
        );
        let sine = [Complex64::ZERO, Complex64::I];
        let (found, deviation) = mean(&sine);
        // A uniform distribution of width 2.
        assert!(found == 0.0 && (deviation - 2.0 / 12.0_f64.sqrt()).abs() < 1e-3, "{found} {deviation}");
    }
}
