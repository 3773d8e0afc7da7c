//! What a residual follows: the share of its power that a short filter of a candidate input explains.

use super::RecordRun;
use nalgebra::{SMatrix, SVector};

/// A candidate input and the share of the residual's power that follows it linearly.
#[derive(Clone, Debug, PartialEq)]
pub struct Follows {
    /// Name of the input.
    pub input: &'static str,
    /// Share between 0 and 1, on runs the filter was not fitted to.
    pub share: f64,
}

/// Coefficients of the filter on each side of the present sample.
const REACH: usize = 3;

/// An input at a sample.
type Input = fn(&RecordRun, usize) -> f64;

/// Runs with residuals of their last samples.
type Left<'a> = (&'a [RecordRun], &'a [Vec<f64>]);

/// Coherence of a residual with what may drive it (Pan et al. 2018): slip, velocity, acceleration, normal force. A filter
/// of seven coefficients spread over a sixteenth of a stroke on each side is found on the fitted runs and judged on the
/// others: what it explains there is no chance.
#[must_use]
pub fn follows(fitted: Left<'_>, judged: Left<'_>) -> Vec<Follows> {
    let inputs: [(&'static str, Input); 4] = [
        ("slip", |run, k| run.history.slip[k]),
        ("slip velocity", |run, k| run.history.velocity[k]),
        ("slip acceleration", |run, k| run.history.acceleration.as_ref().map_or(0.0, |a| a[k])),
        ("normal force", |run, k| run.history.normal[k]),
    ];
    let mut found: Vec<Follows> = inputs
        .iter()
        .filter_map(|(input, of)| Some(Follows { input, share: share(fitted, judged, *of)? }))
        .collect();
    found.sort_by(|a, b| b.share.total_cmp(&a.share));
    found
}

const COLUMNS: usize = 2 * REACH + 1;
type Row = SVector<f64, COLUMNS>;

/// Gives each sample's inputs at the lags of the filter, with its residual; means removed run by run.
fn rows((runs, residuals): Left<'_>, of: Input, mut take: impl FnMut(Row, f64)) {
    for (run, residual) in runs.iter().zip(residuals) {
        let samples = run.history.len();
        let strokes = super::strokes(&run.history.slip).len().max(1);
        let lag = (samples / strokes / 16 / REACH).max(1);
        let offset = samples - residual.len();
        let input: Vec<f64> = (0..samples).map(|k| of(run, k)).collect();
        let mean = input.iter().sum::<f64>() / samples as f64;
        let middle = residual.iter().sum::<f64>() / residual.len().max(1) as f64;
        for (k, r) in residual.iter().enumerate() {
            let at = |j: usize| {
                let place = (k + offset + j * lag).saturating_sub(REACH * lag).min(samples - 1);
                input[place] - mean
            };
            take(Row::from_fn(|j, _| at(j)), r - middle);
        }
    }
}

/// `1 − Σ(r − filtered)²/Σr²` on the judged runs, not below zero; `None` where the input does not vary.
fn share(fitted: Left<'_>, judged: Left<'_>, of: Input) -> Option<f64> {
    let mut matrix = SMatrix::<f64, COLUMNS, COLUMNS>::zeros();
    let mut right = Row::zeros();
    rows(fitted, of, |row, r| {
        right += row * r;
        matrix += row * row.transpose();
    });
    let size = matrix.diagonal().max();
    if size.is_nan() || size <= 0.0 {
        return None;
    }
    // A filter of neighbouring samples is badly conditioned: a ridge of 1e-9 bounds it.
    let filter = (matrix + SMatrix::identity() * (1e-9 * size)).cholesky()?.solve(&right);
    let (mut left, mut power) = (0.0, 0.0);
    rows(judged, of, |row, r| {
        left += (r - filter.dot(&row)).powi(2);
        power += r * r;
    });
    Some((1.0 - left / f64::max(power, f64::MIN_POSITIVE)).max(0.0))
}
