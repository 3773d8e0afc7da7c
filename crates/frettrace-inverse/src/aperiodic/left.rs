//! Products of what the forces leave in all bins: normal equations of whatever moves the accelerations of each.

use super::bins::Solved;
use super::{Round, Whole};
use faer::linalg::matmul::triangular::{BlockStructure, matmul};
use faer::{Accum, Mat, MatMut, Par};
use num_complex::Complex64;
use rayon::prelude::*;
use std::ops::Range;

/// Bins whose products are added up together.
const PART: usize = 64;

/// What moves the accelerations of a bin: the index of a vector of its own, and by how much of it.
pub(super) type Column = (usize, Complex64);

impl Whole<'_> {
    /// Products (lower triangle) of what the forces leave, over all bins, of `count` columns and then of the measured accelerations, less what the common
    /// unknowns of a round, the first columns, make of them where one is given. `columns` appends those of a bin.
    pub(super) fn products_left(
        &self,
        solved: &[Solved],
        count: usize,
        columns: impl Fn(usize, &mut Vec<Column>) + Sync,
        round: Option<&Round>,
    ) -> Mat<f64> {
        let part = |first: usize| {
            let bins = first..(first + PART).min(self.bins.len());
            let mut rows = self.rows_left(bins, solved, (count, &columns));
            if let Some(round) = round {
                less_common(rows.as_mut(), &round.common);
            }
            let mut products = Mat::zeros(count + 1, count + 1);
            let whole = BlockStructure::Rectangular;
            let (into, half) = (products.as_mut(), BlockStructure::TriangularLower);
            matmul(into, half, Accum::Replace, rows.transpose(), whole, rows.as_ref(), whole, 1.0, Par::Seq);
            products
        };
        // Parts of one size, added in order: the sum is the same to the last digit however the work is shared out.
        let parts: Vec<Mat<f64>> =
            (0..self.bins.len().div_ceil(PART)).into_par_iter().map(|p| part(p * PART)).collect();
        parts.iter().fold(Mat::zeros(count + 1, count + 1), |sum, part| sum + part)
    }

    /// What the forces leave in some bins, real and imaginary parts in a row each, the columns beside each other and the measured accelerations last.
    fn rows_left(
        &self,
        bins: Range<usize>,
        solved: &[Solved],
        (count, columns): (usize, &(impl Fn(usize, &mut Vec<Column>) + Sync)),
    ) -> Mat<f64> {
        let each = self.bins.first().map_or(0, |bin| bin.rows());
        let mut rows = Mat::zeros(2 * each * bins.len(), count + 1);
        let (mut vectors, mut measured, mut moved) = (Vec::new(), Vec::new(), Vec::with_capacity(count));
        for (place, k) in bins.enumerate() {
            self.bins[k].leave(&solved[k], &mut vectors, &mut measured);
            moved.clear();
            columns(k, &mut moved);
            let mut fill = |column: usize, of: &[Complex64], by: Complex64| {
                let own = &mut rows.col_as_slice_mut(column)[2 * each * place..][..2 * each];
                for (pair, left) in own.chunks_exact_mut(2).zip(of) {
                    let left = left * by;
                    pair.copy_from_slice(&[left.re, left.im]);
                }
            };
            // A bin's real and imaginary parts have half the variance each.
            let scale = std::f64::consts::SQRT_2;
            for (column, (vector, by)) in moved.iter().enumerate() {
                fill(column, &vectors[vector * each..][..each], by * scale);
            }
            fill(count, &measured, scale.into());
        }
        rows
    }
}

/// Takes what the first columns make with some values off the last one.
fn less_common(mut rows: MatMut<'_, f64>, values: &[f64]) {
    let last = rows.ncols() - 1;
    for (column, value) in values.iter().enumerate() {
        for row in 0..rows.nrows() {
            rows[(row, last)] -= rows[(row, column)] * value;
        }
    }
}
