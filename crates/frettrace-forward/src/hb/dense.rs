//! A dense square system, factorised in place, with all its memory kept.

use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::lu::partial_pivoting::{factor, solve};
use faer::perm::PermRef;
use faer::{MatMut, MatRef, Par};

/// `K = P⁻¹ L U` with memory that is reused.
pub(super) struct Dense {
    size: usize,
    /// Column by column.
    pub matrix: Vec<f64>,
    permutation: [Vec<usize>; 2],
    scratch: MemBuffer,
    columns: usize,
}

impl Dense {
    pub fn new() -> Self {
        Self {
            size: 0,
            matrix: Vec::new(),
            permutation: [Vec::new(), Vec::new()],
            scratch: MemBuffer::new(faer::dyn_stack::StackReq::EMPTY),
            columns: 0,
        }
    }

    /// Memory for a system of this size and so many right-hand sides; the matrix becomes the identity.
    pub fn reset(&mut self, size: usize) {
        self.reserve(size, 1);
        self.size = size;
        self.matrix.clear();
        self.matrix.resize(size * size, 0.0);
        (0..size).for_each(|i| self.matrix[i * (size + 1)] = 1.0);
        self.permutation.iter_mut().for_each(|p| p.resize(size, 0));
    }

    fn reserve(&mut self, size: usize, columns: usize) {
        if size > self.size || columns > self.columns {
            let needed = factor::lu_in_place_scratch::<usize, f64>(size, size, Par::Seq, Default::default())
                .or(solve::solve_in_place_scratch::<usize, f64>(size, columns, Par::Seq));
            self.scratch = MemBuffer::new(needed);
            self.columns = columns;
        }
    }

    pub fn size(&self) -> usize {
        self.size
    }

    pub fn factorise(&mut self) {
        let [forward, backward] = &mut self.permutation;
        factor::lu_in_place(
            MatMut::from_column_major_slice_mut(&mut self.matrix, self.size, self.size),
            forward,
            backward,
            Par::Seq,
            MemStack::new(&mut self.scratch),
            Default::default(),
        );
    }

    /// Overwrites `rhs` (column by column) by the solution.
    pub fn solve(&mut self, rhs: &mut [f64]) {
        if self.size == 0 {
            return;
        }
        let columns = rhs.len() / self.size;
        self.reserve(self.size, columns);
        let matrix = MatRef::from_column_major_slice(&self.matrix, self.size, self.size);
        let [forward, backward] = &self.permutation;
        solve::solve_in_place(
            matrix,
            matrix,
            PermRef::new_checked(forward, backward, self.size),
            MatMut::from_column_major_slice_mut(rhs, self.size, columns),
            Par::Seq,
            MemStack::new(&mut self.scratch),
        );
    }
}
