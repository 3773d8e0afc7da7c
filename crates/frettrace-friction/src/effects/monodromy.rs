//! What one period of a given motion does to a change of the state.

use super::hooks::Hook;
use super::modified::ModifiedLaw;
use crate::law::Scalar;
use nalgebra::{Const, LU, SMatrix, SVector};

/// States that a law may use: deflection, memory, engaged slip, lagged force.
pub const STATES: usize = 4;

/// What a state must forget in a period to settle; one that never forgets stays where it began.
pub(super) const FORGETS: f64 = 1e-7;

/// The map `∂P/∂s` of a period, ready for `x = (I − ∂P/∂s)⁻¹ g`: how the settled state moves when one period alone moves it by `g`.
#[derive(Clone, Debug)]
pub struct Monodromy {
    closing: LU<f64, Const<STATES>, Const<STATES>>,
    stays: [bool; STATES],
}

impl Monodromy {
    /// Of `map(i, j)`, the derivative of the final state `i` by the initial state `j`, for the first `used` states.
    #[must_use]
    pub fn new(used: usize, map: impl Fn(usize, usize) -> f64) -> Self {
        let mut closing = SMatrix::<f64, STATES, STATES>::identity();
        let mut stays = [false; STATES];
        for i in 0..used.min(STATES) {
            stays[i] = (1.0 - map(i, i)).abs() < FORGETS;
            if !stays[i] {
                (0..used.min(STATES)).for_each(|j| closing[(i, j)] -= map(i, j));
            }
        }
        Self { closing: closing.lu(), stays }
    }

    /// The change of the settled state, for the change `g` that one period alone makes; a state that never forgets changes as what
    /// it `began` with.
    #[must_use]
    pub fn settle(&self, mut g: [f64; STATES], began: [f64; STATES]) -> [f64; STATES] {
        for ((g, began), stays) in g.iter_mut().zip(began).zip(self.stays) {
            *g = if stays { began } else { *g };
        }
        let moved = self.closing.solve(&SVector::from(g)).unwrap_or_default();
        std::array::from_fn(|i| moved[i])
    }
}

impl<T: Scalar> ModifiedLaw<T> {
    /// Number of states, in their order, up to the last one that the law uses.
    #[must_use]
    pub fn states(&self) -> usize {
        if self.on(Hook::ForceLag) {
            4
        } else if self.on(Hook::Backlash) {
            3
        } else if self.remembers() {
            2
        } else {
            1
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// `x = Φx + g` with Φ = ((½, ¼), (0, ⅕)) and g = (1, 2): x₂ = 2/0.8 = 2.5, x₁ = (1 + 2.5/4)/0.5 = 3.25. A third state that
    /// keeps all is what it began with.
    #[test]
    fn a_change_settles_where_the_period_reproduces_it() {
        let map = [[0.5, 0.25, 0.0], [0.0, 0.2, 0.0], [0.0, 0.0, 1.0]];
        let settled = Monodromy::new(3, |i, j| map[i][j]).settle([1.0, 2.0, 7.0, 0.0], [0.0, 0.0, 0.3, 0.0]);
        for (found, expected) in settled.iter().zip([3.25, 2.5, 0.3, 0.0]) {
            assert!((found - expected).abs() < 1e-14, "{settled:?}");
        }
    }
}
