//! What the structure leaves open in recovered contacts.
//!
//! With natural frequencies, dampings and a compliance that are `δ` of their deviations off, the contacts of all runs are recovered off
//! together, and what a law leaves moves by `r(δ) = r(0) + D δ`. The nearest resonance alone may be worth a hundred deviations of
//! the lines, the same for every law. With `δ ~ N(0, 1)` the residual has the covariance `I + D Dᵀ`, so that
//! ```text
//! r̃ = (I + D Dᵀ)^(−1/2) r        δ̂ = −Dᵀ (I + D Dᵀ)⁻¹ r        D = U S Vᵀ
//! ```
//! has the unit one: what the structure may do counts for no law and against none, and the structure that goes with a law comes with it.

use super::{ContactProblem, Recovered};
use frettrace_forward::accelerations::{FrequencyRatio, Quantity};
use frettrace_friction::effects::ModifiedLaw;
use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;
use std::sync::Arc;

/// Deviations that a declared value may be off by: beyond them it is an effect with a name.
const FARTHEST: f64 = 5.0;

/// A value of the structure that is known to its deviation only, and the contacts recovered with it one deviation higher.
pub(crate) struct Moved {
    pub quantity: Quantity,
    pub value: f64,
    pub std: f64,
    /// Values that it may have: a damping ratio known to a third of itself is positive all the same.
    pub bounds: (f64, f64),
    pub contacts: Vec<Recovered>,
}

/// Contacts as they are recovered, and with each value of the structure moved.
struct Open {
    plain: Vec<Recovered>,
    moved: Vec<Moved>,
}

/// The directions of the residual that the structure leaves open.
#[derive(Clone)]
pub(crate) struct Leeway {
    open: Arc<Open>,
    /// `U`: rows run by run and line by line, real and imaginary part.
    basis: DMatrix<f64>,
    /// `S`.
    sizes: DVector<f64>,
    /// `Vᵀ`.
    turned: DMatrix<f64>,
}

impl Leeway {
    /// Of contacts and those recovered with each value moved, around a law; `None` where they have no finite answer.
    pub fn new(
        plain: Vec<Recovered>,
        moved: Vec<Moved>,
        law: (&ModifiedLaw<f64>, FrequencyRatio),
    ) -> Option<Self> {
        Self::of(Arc::new(Open { plain, moved }), law)
    }

    /// The same around another law.
    pub fn around(&self, law: (&ModifiedLaw<f64>, FrequencyRatio)) -> Option<Self> {
        Self::of(self.open.clone(), law)
    }

    fn of(open: Arc<Open>, law: (&ModifiedLaw<f64>, FrequencyRatio)) -> Option<Self> {
        let base = left_by(law, &open.plain, &open.plain);
        let columns: Vec<DVector<f64>> =
            open.moved.par_iter().map(|moved| left_by(law, &moved.contacts, &open.plain) - &base).collect();
        if columns.is_empty() || columns.iter().any(|column| column.iter().any(|value| !value.is_finite())) {
            return None;
        }
        let parts = DMatrix::from_columns(&columns).svd(true, true);
        Some(Self { open, basis: parts.u?, sizes: parts.singular_values, turned: parts.v_t? })
    }

    /// Multiplies a residual, or a column of its derivatives, by `(I + D Dᵀ)^(−1/2)`.
    pub fn whiten(&self, problem: &ContactProblem<'_>, residual: &mut [f64]) {
        let mut shares = self.along(problem, residual);
        for (share, size) in shares.iter_mut().zip(self.sizes.iter()) {
            *share *= (1.0 + size * size).sqrt().recip() - 1.0;
        }
        for (own, row) in problem.rows() {
            for (k, share) in shares.iter().enumerate() {
                residual[row] += self.basis[(own, k)] * share;
            }
        }
    }

    /// The structure that goes with a residual that is not whitened: each quantity with its most likely value, within the deviations it may
    /// be off by and the values it may have.
    pub fn likely(&self, problem: &ContactProblem<'_>, residual: &[f64]) -> Vec<(Quantity, f64)> {
        let mut shares = DVector::from_vec(self.along(problem, residual));
        shares
            .iter_mut()
            .zip(self.sizes.iter())
            .for_each(|(share, size)| *share *= -size / (1.0 + size * size));
        let off = self.turned.tr_mul(&shares);
        let known = self.open.moved.iter().zip(off.iter());
        let likely = |one: &Moved, off: f64| {
            (one.value + one.std * off.clamp(-FARTHEST, FARTHEST)).max(one.bounds.0).min(one.bounds.1)
        };
        known.map(|(one, off)| (one.quantity, likely(one, *off))).collect()
    }

    /// `Uᵀ r`.
    fn along(&self, problem: &ContactProblem<'_>, residual: &[f64]) -> Vec<f64> {
        let mut shares = vec![0.0; self.sizes.len()];
        for (own, row) in problem.rows() {
            for (k, share) in shares.iter_mut().enumerate() {
                *share += self.basis[(own, k)] * residual[row];
            }
        }
        shares
    }
}

/// What a law leaves on contacts, over the deviations of others.
fn left_by(
    (law, modulation): (&ModifiedLaw<f64>, FrequencyRatio),
    contacts: &[Recovered],
    known: &[Recovered],
) -> DVector<f64> {
    let mut left = DVector::zeros(known.iter().map(Recovered::count).sum());
    let mut at = 0;
    for (contact, known) in contacts.iter().zip(known) {
        let (_, force) = contact.settled(law, modulation);
        let rows = at..at + known.count();
        let compared = Recovered { deviation: known.deviation.clone(), ..contact.clone() };
        compared.left(&force, &mut left.as_mut_slice()[rows.clone()]);
        at = rows.end;
    }
    left
}
