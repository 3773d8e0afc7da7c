//! What a contact record's residual depends on, over two quantities at once.

use super::figures::{Shown, rounded};
use crate::results::ResidualMap;

/// Cells along each quantity.
const CELLS: usize = 24;

/// A place on a map, each coordinate between 0 and 1, and the residuals there.
type Point = ([f64; 2], [f64; 2]);

/// Maps over slip and slip velocity, and over the time in a run and the run; in units of the floor.
pub(super) fn maps(shown: &[Shown<'_>], floor: f64, unit: &str) -> Vec<ResidualMap> {
    let floor = floor.max(f64::MIN_POSITIVE);
    let slip = reach(shown, |s| &s.run.history.slip);
    let velocity = reach(shown, |s| &s.run.history.velocity);
    let mut found = Vec::new();
    if let (Some(slip), Some(velocity)) = (slip, velocity) {
        let points = shown.iter().flat_map(|s| {
            samples(s).map(move |(k, residual)| {
                let history = &s.run.history;
                ([share(history.slip[k], slip), share(history.velocity[k], velocity)], residual)
            })
        });
        let [before, after] = cells(points, [CELLS, CELLS], floor);
        found.push(ResidualMap {
            across: "slip".into(),
            across_unit: unit.into(),
            x: centres(slip),
            up: "slip velocity".into(),
            up_unit: format!("{unit}/s"),
            y: centres(velocity),
            before,
            after,
        });
    }
    if shown.len() > 1 {
        let points = shown.iter().enumerate().flat_map(|(row, s)| {
            let length = s.run.history.len() as f64;
            let up = (row as f64 + 0.5) / shown.len() as f64;
            samples(s).map(move |(k, residual)| ([k as f64 / length, up], residual))
        });
        let [before, after] = cells(points, [CELLS, shown.len()], floor);
        found.push(ResidualMap {
            across: "time in the run".into(),
            across_unit: "share of it".into(),
            x: centres([0.0, 1.0]),
            up: "run".into(),
            up_unit: "fitted ones first".into(),
            y: (1..=shown.len()).map(|run| run as f64).collect(),
            before,
            after,
        });
    }
    found
}

/// Samples that count, with their residuals before and after.
fn samples<'a>(shown: &'a Shown<'_>) -> impl Iterator<Item = (usize, [f64; 2])> + 'a {
    (shown.first..shown.run.history.len())
        .map(|k| (k, shown.residual.map(|residual| residual[k - shown.first])))
}

/// Least and largest of what counts; none where it does not move.
fn reach<'a>(shown: &[Shown<'a>], of: fn(&Shown<'a>) -> &'a Vec<f64>) -> Option<[f64; 2]> {
    let values = shown.iter().flat_map(|s| &of(s)[s.first..]);
    let (low, high) =
        values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| (low.min(*x), high.max(*x)));
    (high - low > 1e-9 * high.abs()).then_some([low, high])
}

fn share(value: f64, [low, high]: [f64; 2]) -> f64 {
    (value - low) / (high - low)
}

fn centres([low, high]: [f64; 2]) -> Vec<f64> {
    (0..CELLS).map(|k| rounded(low + (high - low) * (k as f64 + 0.5) / CELLS as f64)).collect()
}

/// Quadratic means in cells, a row for each cell upwards; a cell that nothing falls in is NaN.
fn cells(points: impl Iterator<Item = Point>, [across, up]: [usize; 2], floor: f64) -> [Vec<Vec<f64>>; 2] {
    let mut sums = vec![vec![([0.0; 2], 0.0); across]; up];
    for (place, residual) in points {
        let at = |k: usize, count: usize| ((place[k] * count as f64) as usize).min(count - 1);
        let (sum, count) = &mut sums[at(1, up)][at(0, across)];
        *count += 1.0;
        for (sum, r) in sum.iter_mut().zip(residual) {
            *sum += r * r;
        }
    }
    [0, 1].map(|side| {
        let cell = |(sum, count): &([f64; 2], f64)| rounded((sum[side] / count).sqrt() / floor);
        sums.iter().map(|row| row.iter().map(cell).collect()).collect()
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two points in one cell are their quadratic mean; a cell without points is not known.
    #[test]
    fn cells_hold_quadratic_means() {
        let points = [([0.1, 0.9], [3.0, 1.0]), ([0.2, 1.0], [4.0, 1.0]), ([0.9, 0.1], [2.0, 1.0])];
        let [before, after] = cells(points.into_iter(), [2, 2], 0.5);
        // √((3² + 4²)/2) over the floor of one half.
        assert_eq!(before[1][0], rounded(2.0 * 12.5_f64.sqrt()));
        assert_eq!((before[0][1], after[0][1]), (4.0, 2.0));
        assert!(before[0][0].is_nan() && after[1][1].is_nan());
    }
}
