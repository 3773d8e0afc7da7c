//! Lines of a channel that is read in a part of its samples only.

use crate::phasors::Phasors;
use crate::projection::trigonometric;
use faer::linalg::solvers::{Llt, Solve};
use faer::{Col, Mat, Side};
use num_complex::Complex64;

/// Samples that are read, for each unknown.
const OPEN: usize = 3;

/// Projection on some lines of a base frequency, from the samples that are open.
///
/// The lines `x` that leave least of a record `r` there,
///
/// `min_x Σ_open (r(t) − Σ_h Re x_h e^{ihΩt})²`,
///
/// have normal equations as [`crate::Projector`] has them, from the one sum `g(m) = Σ_open e^{imΩt}`.
#[derive(Clone, Debug)]
pub struct OpenLines {
    first: usize,
    last: usize,
    /// One where a sample is read, zero elsewhere.
    open: Vec<f64>,
    phasors: Phasors,
    factor: Llt<f64>,
}

impl OpenLines {
    /// Lines `first ..= last` of a base of `theta` radians a sample, for records with as many samples as `open`; `None` where there are no
    /// lines, or fewer than three open samples an unknown.
    #[must_use]
    pub fn new((first, last): (usize, usize), theta: f64, open: &[bool]) -> Option<Self> {
        let count = (last + 1).checked_sub(first).filter(|count| *count > 0)?;
        if open.iter().filter(|open| **open).count() < OPEN * 2 * count {
            return None;
        }
        let open: Vec<f64> = open.iter().map(|open| f64::from(u8::from(*open))).collect();
        let sums = Phasors::new(theta, 2 * last, open.len()).transform(&open);
        // The transform has the conjugate sums.
        let g = |h: usize, k: usize| if h >= k { sums[h - k].conj() } else { sums[k - h] };
        let normal = Mat::from_fn(2 * count, 2 * count, |i, j| {
            let (h, k) = (first + i % count, first + j % count);
            trigonometric([sums[h + k].conj(), g(h, k)], [i < count, j < count])
        });
        let factor = normal.llt(Side::Lower).ok()?;
        Some(Self { first, last, phasors: Phasors::new(theta, last, open.len()), open, factor })
    }

    /// Samples of the lines that leave least of a record `x` where it is open; what it holds elsewhere is not read.
    #[must_use]
    pub fn of(&self, x: &[f64]) -> Vec<f64> {
        let read: Vec<f64> =
            x.iter().zip(&self.open).map(|(x, open)| if *open > 0.0 { *x } else { 0.0 }).collect();
        let transform = self.phasors.transform(&read);
        let count = self.last + 1 - self.first;
        let line = |i: usize| transform[self.first + i % count];
        let right = Col::from_fn(2 * count, |i| if i < count { line(i).re } else { -line(i).im });
        let found = self.factor.solve(&right);
        let mut lines = vec![Complex64::ZERO; self.first];
        lines.extend((0..count).map(|i| Complex64::new(found[i], -found[count + i])));
        self.phasors.synthesise(&lines, x.len())
    }
}

#[cfg(test)]
mod tests {
    use super::OpenLines;

    /// A wave of the 7th and 9th line, cut off in a fifth of the samples: known exactly from the rest.
    #[test]
    fn lines_are_known_from_the_samples_that_are_open() {
        let angle = 0.0613;
        let open: Vec<bool> = (0..700).map(|k| (angle * k as f64).cos() < 0.8).collect();
        let wave = |k: usize| {
            let t = angle * k as f64;
            0.3 * (7.0 * t).cos() - 0.2 * (9.0 * t + 0.4).sin()
        };
        let rest: Vec<f64> = (0..700).map(|k| if open[k] { wave(k) } else { -55.0 }).collect();
        let lines = OpenLines::new((7, 9), angle, &open).unwrap();
        for (k, found) in lines.of(&rest).into_iter().enumerate() {
            assert!((found - wave(k)).abs() < 1e-12, "{k}: {found}");
        }
    }

    /// Forty lines are not known from a tenth of 700 samples, and none above the last are asked for.
    #[test]
    fn too_few_open_samples_tell_nothing() {
        let open: Vec<bool> = (0..700).map(|k| k % 10 == 0).collect();
        assert!(OpenLines::new((7, 46), 0.0613, &open).is_none());
        assert!(OpenLines::new((7, 6), 0.0613, &open).is_none());
    }
}
