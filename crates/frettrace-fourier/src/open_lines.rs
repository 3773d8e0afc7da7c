//! Lines of a channel that is read in a part of its samples only.

use crate::phasors::Phasors;
use crate::projection::trigonometric;
use faer::linalg::solvers::{Llt, Solve};
use faer::{Col, Mat, Side};
use num_complex::Complex64;

/// Samples that are read, for each unknown.
const OPEN: usize = 3;
/// Share of its power that a combination of lines must have in the open samples to be known from them: noise there, in the root mean square over the
/// record, is ten times as much in what is found.
const KNOWN: f64 = 0.01;

/// Projection on some lines of a base frequency, from the samples that are open.
///
/// The lines `x` that leave least of a record `r` there,
///
/// `min_x Σ_open (r(t) − Σ_h Re x_h e^{ihΩt})²`,
///
/// have normal equations as [`crate::Projector`] has them, from the one sum `g(m) = Σ_open e^{imΩt}`. Where the open samples leave gaps, some
/// combinations of lines lie in these for the most part: eigenvectors whose eigenvalue is less than a hundredth of half the number of open
/// samples, which is what a line has that lies in all of them alike. Of them nothing is known, and nothing is found.
#[derive(Clone, Debug)]
pub struct OpenLines {
    first: usize,
    last: usize,
    /// One where a sample is read, zero elsewhere.
    open: Vec<f64>,
    phasors: Phasors,
    inverse: Inverse,
}

/// What solves the normal equations.
#[derive(Clone, Debug)]
enum Inverse {
    /// All combinations of lines are known.
    Whole(Llt<f64>),
    /// `B` with the inverse `B Bᵀ` on those that are.
    Known(Mat<f64>),
}

impl Inverse {
    fn new(normal: &Mat<f64>, open: usize) -> Option<Self> {
        let least = KNOWN * 0.5 * open as f64;
        // Lines that depend on each other leave a small pivot; the least eigenvalue may be somewhat below the least one.
        if let Ok(factor) = normal.llt(Side::Lower)
            && (0..normal.nrows()).all(|i| factor.L()[(i, i)].powi(2) > least)
        {
            return Some(Self::Whole(factor));
        }
        let parts = normal.self_adjoint_eigen(Side::Lower).ok()?;
        let (vectors, values) = (parts.U(), parts.S().column_vector());
        let known: Vec<usize> = (0..values.nrows()).filter(|&k| values[k] > least).collect();
        Some(Self::Known(Mat::from_fn(normal.nrows(), known.len(), |i, k| {
            vectors[(i, known[k])] / values[known[k]].sqrt()
        })))
    }

    fn of(&self, right: &Col<f64>) -> Col<f64> {
        match self {
            Self::Whole(factor) => factor.solve(right),
            Self::Known(root) => root * (root.transpose() * right),
        }
    }
}

impl OpenLines {
    /// Lines `first ..= last` of a base of `theta` radians a sample, for records with as many samples as `open`; `None` where there are no
    /// lines, or fewer than three open samples an unknown.
    #[must_use]
    pub fn new((first, last): (usize, usize), theta: f64, open: &[bool]) -> Option<Self> {
        let count = (last + 1).checked_sub(first).filter(|count| *count > 0)?;
        let read = open.iter().filter(|open| **open).count();
        if read < OPEN * 2 * count {
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
        let inverse = Inverse::new(&normal, read)?;
        Some(Self { first, last, phasors: Phasors::new(theta, last, open.len()), open, inverse })
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
        let found = self.inverse.of(&right);
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

    /// Twelve lines from the 61st on, of samples that are open in two short stretches of each period. With eigenvalues of a hundredth of half the number
    /// `n` of open samples, `|x|² ≤ Σ r²/(n/200)`, the sum over all is no more than `√24 · √200 = 70` times the root mean square of what was read.
    #[test]
    fn lines_that_lie_in_the_gaps_are_not_found() {
        let angle = 0.001 * std::f64::consts::TAU;
        let open: Vec<bool> = (0..5000).map(|k| (angle * f64::from(k)).cos().abs() < 0.12).collect();
        let rest: Vec<f64> = (0..5000).map(|k| f64::from(k * k % 97) / 48.0 - 1.0).collect();
        let lines = OpenLines::new((61, 72), angle, &open).unwrap();
        let found = lines.of(&rest);
        let read = open.iter().filter(|open| **open).count() as f64;
        let size = open.iter().zip(&rest).filter(|(open, _)| **open).map(|(_, r)| r * r).sum::<f64>();
        let bound = (24.0_f64 * 200.0).sqrt() * (size / read).sqrt();
        assert!(found.iter().all(|x| x.abs() < bound), "{bound}");
        // What it finds it finds again.
        for (once, twice) in found.iter().zip(lines.of(&found)) {
            assert!((once - twice).abs() < 1e-9 * bound);
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
