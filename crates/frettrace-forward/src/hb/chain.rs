//! The chain rule through a period: how forces answer when the motion, or a parameter, changes a little.
//!
//! The states obey `δz_k = A_k δz_{k−1} + b_k` with `δz_N = δz_0`, the forces `δf_k = C_k δz_{k−1} + d_k`.
//! For a change on one line, `δx_k = Re(ξ e^{ihτ_k})`, states and forces are `Re(ψ_k ξ e^{ihτ_k})` with complex `ψ_k`;
//! the turning factor is taken out, so that a step costs one complex product a state and no table of `e^{ihτ}` is read.

use super::contact::STATE_LIMIT;
use super::element::{INPUTS, Partials};
use super::period::{Memory, Resolvent};
use num_complex::Complex64;
use pulp::{Arch, Simd, WithSimd};

/// Lines carried together: they fill the widest vector registers in use.
pub(super) const LANES: usize = 8;

type Lane = [f64; LANES];

/// Complex numbers, one a line.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Lanes {
    re: Lane,
    im: Lane,
}

impl Lanes {
    pub fn set(&mut self, lane: usize, value: Complex64) {
        self.re[lane] = value.re;
        self.im[lane] = value.im;
    }

    #[inline(always)]
    fn get(&self, lane: usize) -> Complex64 {
        Complex64::new(self.re[lane], self.im[lane])
    }

    /// Adds a multiple; most factors of a stuck or sliding contact are zero.
    #[inline(always)]
    fn add(&mut self, factor: f64, other: &Self) {
        if factor == 0.0 {
            return;
        }
        for i in 0..LANES {
            self.re[i] += factor * other.re[i];
            self.im[i] += factor * other.im[i];
        }
    }

    #[inline(always)]
    fn turned(&self, turn: &Self) -> Self {
        let mut result = Self::default();
        for i in 0..LANES {
            result.re[i] = self.re[i] * turn.re[i] - self.im[i] * turn.im[i];
            result.im[i] = self.re[i] * turn.im[i] + self.im[i] * turn.re[i];
        }
        result
    }
}

/// What a unit of force on each line does to slip, slip velocity and normal force.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Gains {
    pub slip: Lanes,
    pub velocity: Lanes,
    pub normal: Lanes,
    /// `e^{−ihΔτ}`: a sample back.
    pub turn: Lanes,
}

/// The partials of one contact along its orbit, with what closes the period.
#[derive(Clone, Copy)]
pub(super) struct Chain<'a> {
    pub partials: &'a Partials,
    /// States, forces, samples.
    pub shape: [usize; 3],
    pub memory: Memory,
    pub inverse: Resolvent,
    /// Partials of the start from rest: rows of `start_width` columns, slip and normal force first.
    pub start: &'a [f64],
    pub start_width: usize,
}

/// [`Chain::columns`] in the code of each instruction set.
struct Columns<'a, 'b> {
    chain: &'a Chain<'b>,
    gains: &'a Gains,
    columns: &'a mut [Complex64],
}

impl WithSimd for Columns<'_, '_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        self.chain.columns_of(self.gains, self.columns);
    }
}

impl Chain<'_> {
    /// Answers `ψ_k` of the forces that `columns[(o·LANES + lane)·N + k]` has room for, to the gains.
    pub fn columns(&self, gains: &Gains, columns: &mut [Complex64]) {
        Arch::new().dispatch(Columns { chain: self, gains, columns });
    }

    #[inline(always)]
    fn columns_of(&self, gains: &Gains, columns: &mut [Complex64]) {
        match (self.shape[0], self.shape[1]) {
            (0, 1) => self.sweep::<0, 1>(gains, columns),
            (1, 1) => self.sweep::<1, 1>(gains, columns),
            (2, 1) => self.sweep::<2, 1>(gains, columns),
            (3, 1) => self.sweep::<3, 1>(gains, columns),
            (4, 1) => self.sweep::<4, 1>(gains, columns),
            (_, 1) => self.sweep::<STATE_LIMIT, 1>(gains, columns),
            (0, _) => self.sweep::<0, 2>(gains, columns),
            (1, _) => self.sweep::<1, 2>(gains, columns),
            (2, _) => self.sweep::<2, 2>(gains, columns),
            (3, _) => self.sweep::<3, 2>(gains, columns),
            (_, _) => self.sweep::<STATE_LIMIT, 2>(gains, columns),
        }
    }

    /// Number of states, known where it is small; `M` is room for it.
    #[inline(always)]
    fn states<const M: usize>(&self) -> usize {
        if M < STATE_LIMIT { M } else { self.shape[0] }
    }

    #[inline(always)]
    fn sweep<const M: usize, const O: usize>(&self, gains: &Gains, columns: &mut [Complex64]) {
        let mut state = [Lanes::default(); M];
        if M > 0 {
            let first = self.memory.faded.unwrap_or(0);
            self.advance::<M, O, false>(first, gains, &mut state, &mut []);
            if self.memory.faded.is_none() {
                state = self.periodic(&state, gains);
            }
        }
        self.advance::<M, O, true>(0, gains, &mut state, columns);
    }

    /// `ψ_0 = (1 − Π)⁺ α`, in neutral directions what loading from rest gives.
    #[inline(always)]
    fn periodic<const M: usize>(&self, end: &[Lanes; M], gains: &Gains) -> [Lanes; M] {
        let (mut start, m) = ([Lanes::default(); M], self.states::<M>());
        for (i, lane) in start.iter_mut().enumerate().take(m) {
            for (j, other) in end.iter().enumerate().take(m) {
                lane.add(self.inverse.resolvent[(i, j)], other);
                let row = &self.start[j * self.start_width..];
                lane.add(self.inverse.neutral[(i, j)] * row[0], &gains.slip);
                lane.add(self.inverse.neutral[(i, j)] * row[1], &gains.normal);
            }
        }
        start
    }

    #[inline(always)]
    fn advance<const M: usize, const O: usize, const WRITE: bool>(
        &self,
        first: usize,
        gains: &Gains,
        state: &mut [Lanes; M],
        columns: &mut [Complex64],
    ) {
        let (samples, m) = (self.shape[2], self.states::<M>());
        let width = m + INPUTS;
        let blocks = self.partials.rows.chunks_exact((m + O) * width);
        for (k, block) in blocks.enumerate().skip(first) {
            let mut new = [Lanes::default(); M];
            for (value, row) in new.iter_mut().zip(block.chunks_exact(width)).take(m) {
                *value = row_answer(row, &state[..m], gains);
            }
            if WRITE {
                let at = if k + 1 == samples { 0 } else { k + 1 };
                let outputs = block.chunks_exact(width).skip(m);
                for (row, out) in outputs.zip(columns.chunks_exact_mut(LANES * samples)) {
                    let value = row_answer(row, &state[..m], gains);
                    for lane in 0..LANES {
                        out[lane * samples + at] = value.get(lane);
                    }
                }
            }
            *state = new;
        }
    }

    /// Answer of the forces (`N × O`) to given changes of every step (`b`: `N × (M + O)`) and of the start (`M`).
    pub fn real(&self, b: &[f64], start: &[f64], forces: &mut [f64]) {
        let [m, o, samples] = self.shape;
        let width = m + INPUTS;
        let mut state = vec![0.0; m];
        if self.memory.faded.is_none() {
            self.pass(b, &mut state, None);
            let end = state.clone();
            for (i, z) in state.iter_mut().enumerate() {
                let sum = |j: usize| {
                    self.inverse.resolvent[(i, j)] * end[j] + self.inverse.neutral[(i, j)] * start[j]
                };
                *z = (0..m).map(sum).sum();
            }
        } else if m > 0 {
            self.pass(b, &mut state, None);
        }
        debug_assert_eq!(self.partials.rows.len(), samples * (m + o) * width);
        self.pass(b, &mut state, Some(forces));
    }

    fn pass(&self, b: &[f64], state: &mut [f64], mut forces: Option<&mut [f64]>) {
        let [m, o, samples] = self.shape;
        let width = m + INPUTS;
        let mut old = state.to_vec();
        let blocks = self.partials.rows.chunks_exact((m + o) * width).zip(b.chunks_exact(m + o));
        for (k, (block, change)) in blocks.enumerate() {
            old.copy_from_slice(state);
            for (j, row) in block.chunks_exact(width).enumerate() {
                let value = change[j] + row.iter().zip(&old).map(|(a, z)| a * z).sum::<f64>();
                if j < m {
                    state[j] = value;
                } else if let Some(forces) = forces.as_deref_mut() {
                    forces[(if k + 1 == samples { 0 } else { k + 1 }) * o + j - m] = value;
                }
            }
        }
    }
}

#[inline(always)]
fn row_answer(row: &[f64], state: &[Lanes], gains: &Gains) -> Lanes {
    let mut old = Lanes::default();
    for (factor, z) in row.iter().zip(state) {
        old.add(*factor, z);
    }
    let input = &row[state.len()..state.len() + INPUTS];
    old.add(input[0], &gains.slip);
    old.add(input[2], &gains.velocity);
    old.add(input[4], &gains.normal);
    let mut value = old.turned(&gains.turn);
    value.add(input[1], &gains.slip);
    value.add(input[3], &gains.velocity);
    value.add(input[5], &gains.normal);
    value
}
