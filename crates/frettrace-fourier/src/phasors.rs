//! Sums over `e^{ihθj}` for many lines `h` and samples `j`, in blocks.
//!
//! With `j = 64a + b`, `Σ_j x_j e^{−ihθj} = Σ_a e^{−ih64θa} Σ_b e^{−ihθb} x_{64a+b}`: only two small tables of phasors
//! are needed, and the inner sum is a plain product of matrices. Base frequencies need not fit the record.

use num_complex::Complex64;

const BLOCK: usize = 64;

/// Tables of phasors for `lines + 1` lines over a record.
#[derive(Clone, Debug)]
pub(crate) struct Phasors {
    lines: usize,
    /// `cos hθb` and `sin hθb`, one row of `2(H + 1)` a sample `b` of the block.
    inner: Vec<f64>,
    /// `e^{ih64θa}`, one row of `H + 1` a block `a`.
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
        let mut block = vec![0.0; 2 * self.lines];
        for (part, turn) in x.chunks(BLOCK).zip(self.outer.chunks(self.lines)) {
            block.fill(0.0);
            for (value, row) in part.iter().zip(self.inner.chunks(2 * self.lines)) {
                for (sum, phasor) in block.iter_mut().zip(row) {
                    *sum += value * phasor;
                }
            }
            let (cosine, sine) = block.split_at(self.lines);
            for (((sum, c), s), z) in sums.iter_mut().zip(cosine).zip(sine).zip(turn) {
                *sum += Complex64::new(*c, -*s) * z.conj();
            }
        }
        sums
    }

    /// `x_j = Re Σ_h X_h e^{ihθj}`; coefficients beyond the lines of the table are left out.
    pub(crate) fn synthesise(&self, coefficients: &[Complex64], x: &mut [f64]) {
        let mut turned = vec![0.0; 2 * self.lines];
        for (part, turn) in x.chunks_mut(BLOCK).zip(self.outer.chunks(self.lines)) {
            let (cosine, sine) = turned.split_at_mut(self.lines);
            for (((c, s), z), value) in cosine.iter_mut().zip(sine).zip(turn).zip(coefficients) {
                let here = value * z;
                (*c, *s) = (here.re, -here.im);
            }
            for (value, row) in part.iter_mut().zip(self.inner.chunks(2 * self.lines)) {
                *value = dot(&turned, row);
            }
        }
    }
}

/// `e^{ihφ}` for `h = 0 … lines − 1` by products of one turn, anew from the definition every sixteen: rounding stays below a
/// hundred times that of one product.
fn powers(phi: f64, lines: usize) -> impl Iterator<Item = Complex64> {
    const ANEW: usize = 16;
    let turn = Complex64::cis(phi);
    let mut now = Complex64::ONE;
    (0..lines).map(move |h| {
        now = if h % ANEW == 0 { Complex64::cis(phi * h as f64) } else { now * turn };
        now
    })
}

/// Scalar product with four partial sums, which the compiler keeps in registers.
fn dot(a: &[f64], b: &[f64]) -> f64 {
    let mut sums = [0.0; 4];
    let (a4, b4) = (a.chunks_exact(4), b.chunks_exact(4));
    let tail: f64 = a4.remainder().iter().zip(b4.remainder()).map(|(x, y)| x * y).sum();
    for (x, y) in a4.zip(b4) {
        for i in 0..4 {
            sums[i] += x[i] * y[i];
        }
    }
    sums.iter().sum::<f64>() + tail
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
        let mut back = vec![0.0; n];
        phasors.synthesise(&sums, &mut back);
        for (j, value) in back.iter().enumerate() {
            let plain: f64 =
                sums.iter().enumerate().map(|(h, c)| (c * Complex64::cis(theta * (h * j) as f64)).re).sum();
            assert!((value - plain).abs() < 1e-10, "sample {j}");
        }
    }
}
