//! Sums over `e^{ihθj}` for many lines `h` and samples `j`, in blocks.
//!
//! With `j = 96a + b`, `Σ_j x_j e^{−ihθj} = Σ_a e^{−ih96θa} Σ_b e^{−ihθb} x_{96a+b}`: only two small tables of phasors
//! are needed, and the inner sums are one product of matrices. Base frequencies need not fit the record.

use faer::linalg::matmul::matmul;
use faer::{Accum, MatMut, MatRef, Par};
use num_complex::Complex64;

/// Samples of a block: a multiple of the rows that products of matrices take at once, and about the root of a usual record times 1.5,
/// so that both tables are small.
const BLOCK: usize = 96;

/// Tables of phasors for `lines + 1` lines over a record.
#[derive(Clone, Debug)]
pub(crate) struct Phasors {
    lines: usize,
    /// `cos hθb` and `sin hθb`, one row of `2(H + 1)` a sample `b` of the block.
    inner: Vec<f64>,
    /// `e^{ih96θa}`, one row of `H + 1` a block `a`.
    outer: Vec<Complex64>,
}

impl Phasors {
    /// Phasors of the lines `0..=order` of the step `theta` (rad) for `samples` samples.
    pub(crate) fn new(theta: f64, order: usize, samples: usize) -> Self {
        let lines = order + 1;
        let mut inner = Vec::with_capacity(2 * lines * BLOCK);
        for b in 0..BLOCK {
            let row = powers(theta * b as f64, lines).collect::<Vec<_>>();
            inner.extend(row.iter().map(|z| z.re));
            inner.extend(row.iter().map(|z| z.im));
        }
        let outer =
            (0..samples.div_ceil(BLOCK)).flat_map(|a| powers(theta * (a * BLOCK) as f64, lines)).collect();
        Self { lines, inner, outer }
    }

    /// `X_h = Σ_j x_j e^{−ihθj}` for all lines.
    pub(crate) fn transform(&self, x: &[f64]) -> Vec<Complex64> {
        let mut sums = vec![Complex64::ZERO; self.lines];
        let mut blocks = vec![0.0; x.len().div_ceil(BLOCK) * 2 * self.lines];
        let whole = x.len() / BLOCK * BLOCK;
        let (first, last) = blocks.split_at_mut(whole / BLOCK * 2 * self.lines);
        product(self.inner(), blocks_of(&x[..whole], BLOCK), first);
        if !last.is_empty() {
            let mut rest = [0.0; BLOCK];
            rest[..x.len() - whole].copy_from_slice(&x[whole..]);
            product(self.inner(), blocks_of(&rest, BLOCK), last);
        }
        for (block, turn) in blocks.chunks(2 * self.lines).zip(self.outer.chunks(self.lines)) {
            let (cosine, sine) = block.split_at(self.lines);
            for (((sum, c), s), z) in sums.iter_mut().zip(cosine).zip(sine).zip(turn) {
                *sum += Complex64::new(*c, -*s) * z.conj();
            }
        }
        sums
    }

    /// `x_j = Re Σ_h X_h e^{ihθj}` for so many samples; coefficients beyond the lines of the table are left out.
    pub(crate) fn synthesise(&self, coefficients: &[Complex64], samples: usize) -> Vec<f64> {
        let count = samples.div_ceil(BLOCK);
        let mut turned = vec![0.0; count * 2 * self.lines];
        for (turned, turn) in turned.chunks_mut(2 * self.lines).zip(self.outer.chunks(self.lines)) {
            let (cosine, sine) = turned.split_at_mut(self.lines);
            for (((c, s), z), value) in cosine.iter_mut().zip(sine).zip(turn).zip(coefficients) {
                let here = value * z;
                (*c, *s) = (here.re, -here.im);
            }
        }
        let mut x = vec![0.0; count * BLOCK];
        product(self.inner().transpose(), blocks_of(&turned, 2 * self.lines), &mut x);
        x.truncate(samples);
        x
    }

    /// The phasors within a block: cosines and sines of all lines, a column each sample.
    fn inner(&self) -> MatRef<'_, f64> {
        MatRef::from_column_major_slice(&self.inner, 2 * self.lines, BLOCK)
    }
}

/// Values as columns of the given length.
fn blocks_of(values: &[f64], length: usize) -> MatRef<'_, f64> {
    MatRef::from_column_major_slice(values, length, values.len() / length)
}

/// Product of two matrices into columns one after the other.
fn product(a: MatRef<'_, f64>, b: MatRef<'_, f64>, out: &mut [f64]) {
    let into = MatMut::from_column_major_slice_mut(out, a.nrows(), b.ncols());
    matmul(into, Accum::Replace, a, b, 1.0, Par::Seq);
}

/// `e^{ihφ}` for `h = 0 … lines − 1` by products of one turn, anew from the definition every sixteen: rounding stays below a
/// hundred times that of one product.
fn powers(phi: f64, lines: usize) -> impl Iterator<Item = Complex64> {
    const ANEW: usize = 16;
    let turn = Complex64::cis(phi);
    let mut now = Complex64::ONE;
    (0..lines).map(move |h| {
        now = match h {
            0 => Complex64::ONE,
            h if h % ANEW == 0 => Complex64::cis(phi * h as f64),
            _ => now * turn,
        };
        now
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Against the sums as they stand in the definition, for a record that is no multiple of the block.
    #[test]
    fn blocked_sums_are_the_plain_sums() {
        let (theta, order, n) = (0.0437, 9, 301);
        let x: Vec<f64> = (0..n).map(|j| ((j * j) as f64 * 0.013).sin()).collect();
        let phasors = Phasors::new(theta, order, n);
        let sums = phasors.transform(&x);
        for (h, sum) in sums.iter().enumerate() {
            let plain: Complex64 =
                x.iter().enumerate().map(|(j, v)| v * Complex64::cis(-theta * (h * j) as f64)).sum();
            assert!((sum - plain).norm() < 1e-11, "line {h}");
        }
        let back = phasors.synthesise(&sums, n);
        for (j, value) in back.iter().enumerate() {
            let plain: f64 =
                sums.iter().enumerate().map(|(h, c)| (c * Complex64::cis(theta * (h * j) as f64)).re).sum();
            assert!((value - plain).abs() < 1e-10, "sample {j}");
        }
    }
}
