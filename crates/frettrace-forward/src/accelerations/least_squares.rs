//! Complex least squares with a handful of unknowns.

use num_complex::Complex64;

/// Most unknowns of a line.
pub(super) const MOST: usize = 4;
/// Smallest share of a column that must be left when the columns before it are taken out.
const INDEPENDENT: f64 = 1e-12;

/// Values of the unknowns, and the variances of their real and imaginary parts for unit weights.
#[derive(Clone, Copy, Debug)]
pub(super) struct Solution {
    pub values: [Complex64; MOST],
    pub variances: [f64; MOST],
}

/// Least squares of `y ≈ Σ_k x_k c_k` by the Cholesky factor of the normal equations; `None` where the columns are dependent.
pub(super) fn solve(columns: &[Vec<Complex64>], y: &[Complex64]) -> Option<Solution> {
    let n = columns.len();
    if n == 0 || n > MOST || y.len() < n {
        return None;
    }
    let dot =
        |a: &[Complex64], b: &[Complex64]| a.iter().zip(b).map(|(a, b)| a.conj() * b).sum::<Complex64>();
    let mut lower = [[Complex64::ZERO; MOST]; MOST];
    for i in 0..n {
        for j in 0..=i {
            let mut sum = dot(&columns[i], &columns[j]);
            let whole = sum.re;
            sum -= (0..j).map(|k| lower[i][k] * lower[j][k].conj()).sum::<Complex64>();
            lower[i][j] = if i == j {
                if sum.re <= INDEPENDENT * whole || sum.re <= 0.0 {
                    return None;
                }
                Complex64::from(sum.re.sqrt())
            } else {
                sum / lower[j][j].re
            };
        }
    }
    let right: Vec<Complex64> = columns.iter().map(|c| dot(c, y)).collect();
    let values = substitute(&lower, n, &right);
    let mut variances = [0.0; MOST];
    for (k, variance) in variances.iter_mut().enumerate().take(n) {
        let mut unit = vec![Complex64::ZERO; n];
        unit[k] = Complex64::ONE;
        *variance = substitute(&lower, n, &unit)[k].re;
    }
    Some(Solution { values, variances })
}

/// `(L Lᴴ)⁻¹ b`.
fn substitute(lower: &[[Complex64; MOST]; MOST], n: usize, right: &[Complex64]) -> [Complex64; MOST] {
    let mut x = [Complex64::ZERO; MOST];
    for i in 0..n {
        let mut sum = right[i];
        sum -= (0..i).map(|k| lower[i][k] * x[k]).sum::<Complex64>();
        x[i] = sum / lower[i][i].re;
    }
    for i in (0..n).rev() {
        let mut sum = x[i];
        sum -= (i + 1..n).map(|k| lower[k][i].conj() * x[k]).sum::<Complex64>();
        x[i] = sum / lower[i][i].re;
    }
    x
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Three unknowns of five exact equations come back to rounding; the variance of a lone column is the inverse of its norm.
    #[test]
    fn exact_equations_come_back() {
        let value =
            |i: usize, k: usize| Complex64::new(((3 * i + 5 * k) % 7) as f64, ((i * i + k) % 5) as f64);
        let columns: Vec<Vec<Complex64>> = (0..3).map(|k| (0..5).map(|i| value(i, k)).collect()).collect();
        let x = [Complex64::new(1.0, -2.0), Complex64::new(0.5, 0.25), Complex64::new(-3.0, 1.0)];
        let y: Vec<Complex64> = (0..5).map(|i| (0..3).map(|k| columns[k][i] * x[k]).sum()).collect();
        let found = solve(&columns, &y).unwrap();
        for (found, expected) in found.values.iter().zip(&x) {
            assert!((found - expected).norm() < 1e-12, "{found} {expected}");
        }
        let lone = solve(&columns[..1], &y).unwrap();
        let norm: f64 = columns[0].iter().map(Complex64::norm_sqr).sum();
        assert!((lone.variances[0] * norm - 1.0).abs() < 1e-12);
        assert!(solve(&[columns[0].clone(), columns[0].clone()], &y).is_none());
    }
}
