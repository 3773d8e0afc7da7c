//! What a person looks at of a run without a period: the cycle of the largest slip, as recovered without a law and as both laws answer it.

use super::motion::Motion;
use super::run::OpenRun;
use crate::exhibit::Loop;
use crate::records_explain::strokes;
use crate::series::Series;
use frettrace_friction::effects::ModifiedLaw;
use nalgebra::DVector;
use std::ops::Range;

/// Most points of a curve: as many as a drawing shows.
const POINTS: usize = 400;

/// One run: the contact as recovered, and the forces with which the two laws answer its motion.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct WholeExhibit {
    /// Index of the run.
    pub run: usize,
    /// Whether nothing was fitted to it.
    pub held_out: bool,
    /// Times of the points (s), from the first sample of the record.
    pub time: Vec<f64>,
    /// The contact recovered without a law, with the errors of the recovery that go with the second law.
    pub recovered: Loop,
    /// The contact under the declared law and under the law with the effects. All energies are means over the cycles of the record.
    pub modelled: [Loop; 2],
}

/// A run under the declared law and under the one with the effects, each with the errors of the recovery that go with it.
pub(super) fn exhibit(
    held_out: bool,
    sides: [(&OpenRun, &ModifiedLaw<f64>, &DVector<f64>); 2],
) -> WholeExhibit {
    let [before, after] = sides.map(|(run, law, xi)| run.answered(law, xi));
    let run = sides[1].0;
    let dt = run.whole.dt;
    let slip = run.faster(&after.0.slip);
    let settled = Series::settling(slip.len());
    let (cycle, cycles) = largest_cycle(&slip[settled..]);
    let drawn = settled + cycle.start..settled + cycle.end;
    let stride = drawn.len().div_ceil(POINTS).max(1);
    let of = |motion: &Motion, slip: &[f64], force: &[f64]| {
        let part = |signal: &[f64]| without_mean(&signal[drawn.clone()]).step_by(stride).collect();
        let power = force.iter().zip(&motion.velocity).skip(settled).map(|(force, v)| force * v);
        Loop {
            slip: part(slip),
            velocity: part(&motion.velocity),
            force: part(force),
            energy: dt * power.sum::<f64>() / cycles,
        }
    };
    WholeExhibit {
        run: run.index,
        held_out,
        time: drawn.clone().step_by(stride).map(|k| k as f64 * dt).collect(),
        recovered: of(&after.0, &slip, &after.0.force),
        modelled: [of(&before.0, &run.faster(&before.0.slip), &before.1), of(&after.0, &slip, &after.1)],
    }
}

/// Samples of the two strokes in a row that go farthest, and the cycles of the whole; all of it where there are no two.
fn largest_cycle(slip: &[f64]) -> (Range<usize>, f64) {
    let strokes = strokes(slip);
    let far = |stroke: &Range<usize>| (slip[stroke.end] - slip[stroke.start]).abs();
    let pairs = strokes.windows(2).map(|pair| (far(&pair[0]) + far(&pair[1]), pair[0].start..pair[1].end));
    let largest = pairs.max_by(|a, b| a.0.total_cmp(&b.0));
    let whole = || 0..slip.len();
    (largest.map_or_else(whole, |(_, cycle)| cycle), 0.5 * strokes.len().max(2) as f64)
}

fn without_mean(signal: &[f64]) -> impl Iterator<Item = f64> + '_ {
    let mean = signal.iter().sum::<f64>() / signal.len().max(1) as f64;
    signal.iter().map(move |x| x - mean)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A cosine that grows for three periods and falls for two more goes farthest about its top: the strokes from one crest to the next.
    #[test]
    fn the_largest_cycle_is_about_the_top() {
        let period = 100;
        let swell = |k: usize| 1.0 - (k as f64 / 300.0 - 1.0).abs();
        let slip: Vec<f64> = (0..501)
            .map(|k| swell(k) * (std::f64::consts::TAU * k as f64 / f64::from(period)).cos())
            .collect();
        let (cycle, cycles) = largest_cycle(&slip);
        assert!(cycle.contains(&300) && cycle.len().abs_diff(100) <= 2, "{cycle:?}");
        assert!((cycles - 5.0).abs() < 0.6, "{cycles}");
        assert_eq!(largest_cycle(&[0.0; 4]).0, 0..4);
    }
}
