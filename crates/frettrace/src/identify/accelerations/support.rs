//! The force of a declared second support: unknown in every line, whatever law holds in the contact.
//!
//! A change `δ` of its lines moves the whitened prediction of a run by `B δ`, the answer of the contact included. With
//! `B = Q₁R` the residuals fall into those that a support force takes, `Q₁ᵀr`, and the rest `Q₂ᵀr`, which none explains. Law
//! and structure are fitted to the rest, and the support force follows as `R⁻¹Q₁ᵀr` (variable projection: Golub and Pereyra,
//! SIAM J. Numer. Anal. 10 (1973) 413). A force recovered once and then held would count its errors as those of the law.

use crate::StudyError;
use frettrace_explain::{ExplainError, Fitted, Study};
use frettrace_forward::accelerations::{
    AccelerationModel, Beside, COEFFICIENTS, Memory, Port, PortLaw, PortPlace, Setting,
};
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

/// What a support force does to the residuals of the training runs, one factor a run.
pub(super) struct Support {
    factors: Vec<QR<f64, Dyn, Dyn>>,
}

/// Recovers the force of a declared second support with the contact's, without a law, where the structure has been
/// calibrated; whether there is one.
pub(super) fn recover(study: &mut Study<'_>, setting: &Setting) -> bool {
    let Some(position) = study.case.rig.known_support else { return false };
    let port =
        Port { place: PortPlace::At(position), law: PortLaw::Polynomial, coefficients: [0.0; COEFFICIENTS] };
    let beside = Setting { ports: vec![port], ..setting.clone() };
    let runs: Vec<usize> = (0..study.model.runs.len()).collect();
    let Ok(found) = study.model.balance_beside(&beside, &runs, Beside::Ports) else { return false };
    for (run, change) in study.model.runs.iter_mut().zip(&found) {
        let more = change.beside.iter().flatten();
        run.known_force.iter_mut().zip(more).for_each(|(force, more)| *force += more);
    }
    set_means(study);
    true
}

/// Sets the means of the support forces, which no accelerometer sees though they load the contact: where a force rests on
/// one level for a good part of the period the support is open, and that level is zero.
fn set_means(study: &mut Study<'_>) {
    for run in &mut study.model.runs {
        let (mean, _) = mean(&run.known_force);
        if let Some(line) = run.known_force.first_mut() {
            *line = Complex64::from(mean);
        }
    }
}

/// Mean of a force from its other lines, and its standard deviation: that of a uniform distribution over the level it rests
/// on, or over the whole range where it rests nowhere.
fn mean(lines: &[Complex64]) -> (f64, f64) {
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

/// Largest relative standard deviation that unknown means of the support forces give the normal force of a training run.
pub(super) fn doubt(study: &mut Study<'_>, fitted: &Fitted) -> f64 {
    if study.case.rig.known_support.is_none() {
        return 0.0;
    }
    let normal = |study: &Study<'_>, run: usize| {
        let contact = study.model.contact(&fitted.setting, run, &mut fitted.memory.clone()).ok()?;
        Some(contact.normal.iter().sum::<f64>() / contact.normal.len().max(1) as f64)
    };
    let mut largest = 0.0_f64;
    for run in study.training.clone() {
        let deviation = mean(&study.model.runs[run].known_force).1;
        let plain = normal(study, run);
        let Some(line) = study.model.runs[run].known_force.first_mut() else { continue };
        let held = std::mem::replace(line, *line + deviation);
        let moved = normal(study, run);
        study.model.runs[run].known_force[0] = held;
        if let (Some(plain), Some(moved)) = (plain, moved) {
            largest = largest.max(((moved - plain) / plain).abs());
        }
    }
    largest
}

impl Support {
    /// Differences the predictions of the training runs by the support force; `None` without a second support.
    ///
    /// # Errors
    /// [`StudyError`] where a run does not balance.
    pub(super) fn new(study: &Study<'_>, fitted: &Fitted) -> Result<Option<Self>, StudyError> {
        if study.case.rig.known_support.is_none() {
            return Ok(None);
        }
        let factor = |run: &usize| {
            let model = study.model.with_runs(study.model.runs.clone())?;
            derivative(model, (&fitted.setting, *run, fitted.memory.clone())).map(nalgebra::Matrix::qr)
        };
        let factors = study.training.par_iter().map(factor).collect::<Result<Vec<_>, ExplainError>>()?;
        Ok(Some(Self { factors }))
    }

    /// Residuals of each run that the support force takes.
    pub(super) fn taken(&self) -> impl Iterator<Item = usize> {
        self.factors.iter().map(|factor| factor.qr_internal().ncols())
    }

    /// What is left of columns of all residuals where no support force reaches.
    pub(super) fn rest(&self, mut all: DMatrix<f64>) -> DMatrix<f64> {
        let taken: usize = self.taken().sum();
        let mut out = DMatrix::zeros(all.nrows() - taken, all.ncols());
        let (mut from, mut to) = (0, 0);
        for factor in &self.factors {
            let (rows, taken) = factor.qr_internal().shape();
            let left = rows - taken;
            factor.q_tr_mul(&mut all.rows_mut(from, rows));
            out.rows_mut(to, left).copy_from(&all.rows(from + taken, left));
            from += rows;
            to += left;
        }
        out
    }

    /// Moves the support force of the training runs to where it leaves least of `residual`.
    pub(super) fn renew(&self, study: &mut Study<'_>, residual: &[f64]) {
        let mut row = 0;
        for (run, factor) in study.training.iter().zip(&self.factors) {
            let (rows, columns) = factor.qr_internal().shape();
            let mut rest = DVector::from_column_slice(&residual[row..row + rows]);
            row += rows;
            factor.q_tr_mul(&mut rest);
            let head = rest.rows(0, columns).into_owned();
            let Some(change) = factor.r().solve_upper_triangular(&head) else { continue };
            let lines = study.model.runs[*run].known_force.iter_mut().skip(1);
            for (line, pair) in lines.zip(change.as_slice().chunks(2)) {
                *line += Complex64::new(pair[0], pair[1]);
            }
        }
        set_means(study);
    }
}

/// Derivative of the whitened prediction of a run by real and imaginary parts of the lines of the support force.
fn derivative(
    mut model: AccelerationModel,
    (setting, run, mut memory): (&Setting, usize, Memory),
) -> Result<DMatrix<f64>, ExplainError> {
    let plain = model.predict(setting, &[run], &mut memory)?;
    let lines = &model.runs[run];
    let deviation = lines.deviation.clone();
    let order = lines.order();
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
