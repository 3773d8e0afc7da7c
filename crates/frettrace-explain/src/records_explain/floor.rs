//! The noise floor of a record: what does not repeat from one stroke to the next alike.

use super::RecordRun;
use super::evidence::effective_count;
use std::ops::Range;

/// What does not repeat.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Floor {
    /// Standard deviation of the force about what repeats (N).
    pub std: f64,
    /// Independent differences behind it: its own relative deviation is `1/√(2·count)`.
    pub count: f64,
}

/// Reversals smaller than this share of the range of the slip are noise or a dither, not the end of a stroke.
const REVERSAL: f64 = 0.1;
/// Strokes are alike where their ends agree within this share of the range, and their durations of the duration.
const ALIKE: f64 = 0.05;
/// Most slips at which two strokes are compared.
const PLACES: usize = 400;

/// Strokes from reversal to reversal, those that are cut off at the ends included.
#[must_use]
pub fn strokes(slip: &[f64]) -> Vec<Range<usize>> {
    let (low, high) =
        slip.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), x| (a.min(*x), b.max(*x)));
    let band = REVERSAL * (high - low);
    let (mut found, mut start, mut extreme, mut sense) = (Vec::new(), 0, 0, 0.0);
    for (k, value) in slip.iter().enumerate() {
        let ahead = value - slip[extreme];
        if sense == 0.0 {
            if ahead.abs() > band {
                (sense, extreme) = (ahead.signum(), k);
            }
        } else if ahead * sense > 0.0 {
            extreme = k;
        } else if -ahead * sense > band {
            found.push(start..extreme);
            (start, extreme, sense) = (extreme, k, -sense);
        }
    }
    if !slip.is_empty() {
        found.push(start..slip.len() - 1);
    }
    found
}

/// Differences of two alike strokes at the samples of the first, the second interpolated.
struct Compared {
    /// Differences of the force (N).
    differences: Vec<f64>,
    /// `s(1 − s)` of every interpolation, `s` being its place between two samples.
    between: Vec<f64>,
    /// Whether neighbouring differences share a sample of the second stroke.
    shared: bool,
}

impl Compared {
    /// White part of one stroke's noise (N²), from second differences: those of the first stroke have six times its
    /// variance, those of an interpolated one `6 − 12p`, less `8p` where neighbours share a sample; `p = s(1 − s)`.
    fn white(&self) -> f64 {
        let loss = if self.shared { 20.0 } else { 12.0 };
        let (mut sum, mut weight) = (0.0, 0.0);
        for (d, p) in self.differences.windows(3).zip(self.between.iter().skip(1)) {
            sum += (d[0] - 2.0 * d[1] + d[2]).powi(2);
            weight += 12.0 - loss * p;
        }
        sum / f64::max(weight, 1.0)
    }

    /// Sum of the variances of one stroke's noise (N²): half those of the differences, and what interpolation took
    /// from the white part.
    fn squares(&self) -> f64 {
        let half: f64 = self.differences.iter().map(|d| d * d / 2.0).sum();
        // No more than everything is white: interpolation halves a variance at most, so that the difference keeps 3/4.
        half + (self.white() * self.between.iter().sum::<f64>()).min(half / 3.0)
    }
}

/// The floor from neighbouring strokes of one sense, `σ² = ⟨(F₂ − F₁)²⟩/2` at equal slip: what drifts slowly is no
/// noise. `None` where no two strokes are alike.
#[must_use]
pub fn floor(runs: &[RecordRun]) -> Option<Floor> {
    let (mut square, mut count, mut independent) = (0.0, 0.0, 0.0);
    for run in runs {
        let strokes = strokes(&run.history.slip);
        for pair in strokes.windows(3) {
            let Some(compared) = compared(run, (&pair[0], &pair[2])) else { continue };
            square += compared.squares();
            count += compared.differences.len() as f64;
            independent += effective_count(&[&compared.differences]);
        }
    }
    (count > 0.0).then(|| Floor { std: (square / count).sqrt(), count: independent })
}

/// Two alike strokes at the slips of the first one's samples.
fn compared(run: &RecordRun, (first, second): (&Range<usize>, &Range<usize>)) -> Option<Compared> {
    let history = &run.history;
    let slip = &history.slip;
    let range = (slip[first.end] - slip[first.start]).abs();
    let duration = |s: &Range<usize>| history.time[s.end] - history.time[s.start];
    let apart =
        (slip[first.start] - slip[second.start]).abs().max((slip[first.end] - slip[second.end]).abs());
    let longer = (duration(second) / duration(first) - 1.0).abs();
    let alike = range > 0.0 && apart < ALIKE * range && longer < ALIKE;
    if !alike || first.len() < 8 {
        return None;
    }
    let sense = (slip[first.end] - slip[first.start]).signum();
    let stride = first.len().div_ceil(PLACES);
    let mut found = Compared { differences: Vec::new(), between: Vec::new(), shared: stride == 1 };
    for sample in first.clone().step_by(stride) {
        let place = sense * slip[sample];
        let around = |k: &usize| sense * slip[*k] <= place && sense * slip[*k + 1] >= place;
        let Some(k) = second.clone().find(around) else { continue };
        let step = sense * (slip[k + 1] - slip[k]);
        let share = if step > 0.0 { (place - sense * slip[k]) / step } else { 0.0 };
        let other = history.force[k] + share * (history.force[k + 1] - history.force[k]);
        found.differences.push(other - history.force[sample]);
        found.between.push(share * (1.0 - share));
    }
    Some(found)
}

/// Noise of white samples from second differences, `√(Σ(x₋ − 2x + x₊)²/6n)`: the floor where nothing repeats.
pub(super) fn scatter(runs: &[RecordRun]) -> f64 {
    let (mut sum, mut count) = (0.0, 0.0);
    for run in runs {
        for w in run.history.force.windows(3) {
            sum += (w[0] - 2.0 * w[1] + w[2]).powi(2) / 6.0;
            count += 1.0;
        }
    }
    (sum / f64::max(count, 1.0)).sqrt()
}
