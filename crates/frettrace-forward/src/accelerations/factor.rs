//! LU factor of a square matrix in the memory of the matrix: a balance keeps one a run, of thousands of columns.

use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::lu::partial_pivoting::{factor, solve};
use faer::perm::Perm;
use faer::{Conj, Mat, MatMut, get_global_parallelism};

/// `P A = L U`, with partial pivoting.
pub(super) struct Factor {
    /// `U`, and below its diagonal `L`, whose own diagonal is one.
    both: Mat<f64>,
    rows: Perm<usize>,
}

impl Factor {
    pub fn new(mut matrix: Mat<f64>) -> Self {
        let size = matrix.nrows();
        let (mut forward, mut backward) = (vec![0; size], vec![0; size]);
        let parallelism = get_global_parallelism();
        let needed =
            factor::lu_in_place_scratch::<usize, f64>(size, size, parallelism, faer::Spec::default());
        factor::lu_in_place(
            matrix.as_mut(),
            &mut forward,
            &mut backward,
            parallelism,
            MemStack::new(&mut MemBuffer::new(needed)),
            faer::Spec::default(),
        );
        let rows = Perm::new_checked(forward.into_boxed_slice(), backward.into_boxed_slice(), size);
        Self { both: matrix, rows }
    }

    /// `A⁻¹` times every column.
    pub fn solve_in_place(&self, right: MatMut<'_, f64>) {
        let parallelism = get_global_parallelism();
        let needed =
            solve::solve_in_place_scratch::<usize, f64>(self.both.nrows(), right.ncols(), parallelism);
        solve::solve_in_place_with_conj(
            self.both.as_ref(),
            self.both.as_ref(),
            self.rows.as_ref(),
            Conj::No,
            right,
            parallelism,
            MemStack::new(&mut MemBuffer::new(needed)),
        );
    }

    /// `A⁻¹ x`.
    pub fn solve(&self, x: &[f64]) -> Vec<f64> {
        let mut out = x.to_vec();
        self.solve_in_place(MatMut::from_column_major_slice_mut(&mut out, x.len(), 1));
        out
    }
}

#[cfg(test)]
mod tests {
    use super::Factor;
    use faer::Mat;

    /// `A x` of a matrix that has to exchange its rows, `((0, 2, 1), (1, 1, 0), (4, 0, 3))`, times `(1, −2, 3)` is `(−1, −1, 13)`.
    #[test]
    fn a_factor_undoes_its_matrix() {
        let matrix = [[0.0, 2.0, 1.0], [1.0, 1.0, 0.0], [4.0, 0.0, 3.0]];
        let factor = Factor::new(Mat::from_fn(3, 3, |i, j| matrix[i][j]));
        let near = |found: &[f64], expected: [f64; 3]| {
            found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-14)
        };
        assert!(near(&factor.solve(&[-1.0, -1.0, 13.0]), [1.0, -2.0, 3.0]));
        let mut two = Mat::from_fn(3, 2, |i, j| [[-1.0, -1.0, 13.0], [1.0, 0.0, 3.0]][j][i]);
        factor.solve_in_place(two.as_mut());
        assert!(near(two.col_as_slice(0), [1.0, -2.0, 3.0]) && near(two.col_as_slice(1), [0.0, 0.0, 1.0]));
    }
}
