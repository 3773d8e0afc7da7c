//! Further forces that the balance does not show: ranked by the tangents of the whole model.
//!
//! Where a force acts near the shape that a contact force makes, the recovered contact force takes most of it and the balance
//! closes; no law then answers the contact. With the tangent `c = ∂a/∂κ` of the prediction at `κ = 0`, the whitened residual `r`
//! and `P` the projector beside the tangents of everything that is free already, adding the force takes `(cᵀPr)²/cᵀPc` from χ² to
//! first order, at `κ = cᵀPr/cᵀPc`.

use crate::balance_fit::BalanceCandidate;
use crate::effects::{ALL, FREE};
use crate::fitting::AccelerationFit;
use crate::search::Explained;
use crate::study::merge;
use crate::{Study, Unknown, signed};
use frettrace_forward::accelerations::{COEFFICIENTS, Port, PortLaw, PortPlace, Quantity};
use frettrace_identify::Model;
use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

/// Places along the beam, as shares of its length: no two neighbours are farther apart than half a wave of its fourth mode.
const PLACES: [f64; 6] = [0.3, 0.42, 0.54, 0.66, 0.78, 0.9];
/// Lines of the contact force up to which a run is asked: with two forces of so many, one place takes half a second.
const MOST_LINES: usize = 200;
/// Effects whose force is smooth, with their coefficients of the polynomial.
const SMOOTH: [(&str, &[usize]); 3] = [
    ("structure.cubic-stiffness", &[2]),
    ("structure.quadratic-damping", &[3]),
    ("structure.second-support", &[0, 1]),
];

/// Share of χ² above the noise that a tangent must promise to take: the first step towards a strong force takes a fifth.
const WORTH: f64 = 0.1;

/// What a force would take from χ², and its coefficients then.
struct Promise {
    place: PortPlace,
    effect: usize,
    free: &'static [usize],
    /// χ² that it takes, in all and as a share of what nothing free takes above the noise.
    gain: f64,
    share: f64,
    coefficients: [f64; COEFFICIENTS],
}

impl Study<'_> {
    /// Smooth forces on the beam by what their tangents promise, best first, one place each.
    pub(crate) fn tangent_candidates(&self, current: &Explained) -> Vec<BalanceCandidate> {
        let places: Vec<PortPlace> =
            PLACES.iter().map(|share| PortPlace::At(share * self.scales.length)).collect();
        let few = |run: &usize| self.model.runs[*run].contact_order <= MOST_LINES;
        let runs: Vec<usize> = self.training.iter().copied().filter(few).collect();
        // The jumps of a force that is set-valued at rest move with everything: no tangent reaches far.
        if runs.is_empty() || current.fitted.setting.holds_rigidly() {
            return Vec::new();
        }
        let Some(known) = self.known(current, runs) else { return Vec::new() };
        let mut promised: Vec<Promise> =
            places.par_iter().filter_map(|&place| self.promises(current, place, &known)).flatten().collect();
        promised.retain(|promise| promise.share > WORTH);
        promised.sort_by(|a, b| b.gain.total_cmp(&a.gain));
        let count = self.residual_count() as f64;
        let mut found: Vec<BalanceCandidate> = Vec::new();
        for promise in promised {
            if found.iter().any(|other| other.effect == promise.effect) {
                continue;
            }
            let port =
                Port { place: promise.place, law: PortLaw::Polynomial, coefficients: promise.coefficients };
            let form = self.form(&current.fitted.setting, port, (promise.free, None));
            let left = current.fitted.fit.cost - promise.gain;
            found.push(BalanceCandidate {
                effect: promise.effect,
                sensor: None,
                setting: form.setting,
                criterion: left + form.unknowns.len() as f64 * count.ln(),
                reduced: left / count,
                unknowns: form.unknowns,
            });
        }
        found
    }

    /// What is free already, at the present values; `None` where the model has no answer there.
    fn known(&self, current: &Explained, runs: Vec<usize>) -> Option<Known> {
        let setting = current.fitted.setting.clone();
        let free = merge(&self.case.unknowns(), &current.added);
        let free: Vec<Unknown> = free.into_iter().filter(|u| setting.get(u.quantity).is_some()).collect();
        let warm = current.fitted.memory.clone();
        let (residual, jacobian) =
            linearised(&AccelerationFit::new(&self.model, setting, &free, runs.clone(), warm))?;
        let priors: Vec<(usize, f64)> = (free.iter().enumerate())
            .filter_map(|(j, u)| u.parameter.prior.map(|prior| (j, prior.std.recip())))
            .collect();
        let lines = residual.len();
        let rows = lines + priors.len();
        let mut tangents = jacobian.resize_vertically(rows, 0.0);
        for (row, &(j, weight)) in priors.iter().enumerate() {
            tangents[(lines + row, j)] = weight;
        }
        let beside = Beside::new(tangents);
        let left = beside.of(&residual.resize_vertically(rows, 0.0));
        let excess = (left.norm_squared() - lines as f64).max(f64::MIN_POSITIVE);
        Some(Known { runs, beside, left, excess })
    }

    /// What each smooth force at a place promises; `None` where the model has no answer there.
    fn promises(&self, current: &Explained, place: PortPlace, known: &Known) -> Option<Vec<Promise>> {
        let mut setting = current.fitted.setting.clone();
        setting.ports.push(Port { place, law: PortLaw::Polynomial, coefficients: [0.0; COEFFICIENTS] });
        let index = setting.ports.len() - 1;
        let unknowns: Vec<Unknown> = (0..COEFFICIENTS)
            .map(|k| signed(Quantity::Port(index, k), ("coefficient", ""), 1.0, FREE))
            .collect();
        let warm = current.fitted.memory.with_idle_port(index);
        let (_, jacobian) =
            linearised(&AccelerationFit::new(&self.model, setting, &unknowns, known.runs.clone(), warm))?;
        let tangents = jacobian.resize_vertically(known.left.len(), 0.0);
        let promise = |&(id, free): &(&str, &'static [usize])| {
            let effect = ALL.iter().position(|e| e.id() == id)?;
            if !self.case.allows(id) || current.effects.contains(&effect) {
                return None;
            }
            let columns: Vec<DVector<f64>> =
                free.iter().map(|&k| known.beside.of(&tangents.column(k).into_owned())).collect();
            let (gain, values) = explained(&columns, &known.left)?;
            let mut coefficients = [0.0; COEFFICIENTS];
            free.iter().zip(&values).for_each(|(&k, value)| coefficients[k] = *value);
            Some(Promise { place, effect, free, gain, share: gain / known.excess, coefficients })
        };
        Some(SMOOTH.iter().filter_map(promise).collect())
    }
}

/// What is free already, on the runs that are asked.
struct Known {
    runs: Vec<usize>,
    /// Projector beside its tangents.
    beside: Beside,
    /// The residual beside them: lines, and a row for each prior.
    left: DVector<f64>,
    /// χ² of that above the noise.
    excess: f64,
}

/// Residual and derivatives of a model at its start.
fn linearised(problem: &AccelerationFit<'_>) -> Option<(DVector<f64>, DMatrix<f64>)> {
    let (start, rows) = (problem.start(), problem.residual_count());
    let mut residual = DVector::zeros(rows);
    let mut jacobian = DMatrix::zeros(rows, start.len());
    let target = (residual.as_mut_slice(), &mut jacobian);
    problem.linearise(&start, &vec![true; start.len()], &mut problem.memory(), target).ok()?;
    Some((residual, jacobian))
}

/// The projector beside some directions.
struct Beside(DMatrix<f64>);

impl Beside {
    /// Columns that tell nothing of their own are left out.
    fn new(mut columns: DMatrix<f64>) -> Self {
        for mut column in columns.column_iter_mut() {
            let size = column.norm();
            if size > 0.0 {
                column /= size;
            }
        }
        let decomposition = columns.col_piv_qr();
        let (basis, triangle) = (decomposition.q(), decomposition.r());
        let kept = (0..triangle.nrows()).take_while(|&k| triangle[(k, k)].abs() > LEAST).count();
        Self(basis.columns(0, kept).into_owned())
    }

    fn of(&self, vector: &DVector<f64>) -> DVector<f64> {
        vector - &self.0 * (self.0.transpose() * vector)
    }
}

/// Share of a direction that must be its own.
const LEAST: f64 = 1e-10;

/// χ² that columns take from `left`, and their coefficients; `None` where they are nothing beside each other.
fn explained(columns: &[DVector<f64>], left: &DVector<f64>) -> Option<(f64, Vec<f64>)> {
    let matrix = DMatrix::from_columns(columns);
    let scale = matrix.column_iter().map(|c| c.norm()).fold(0.0, f64::max);
    if !scale.is_finite() || scale <= 0.0 {
        return None;
    }
    let sizes: Vec<f64> = matrix.column_iter().map(|c| c.norm().max(f64::MIN_POSITIVE)).collect();
    let mut scaled = matrix;
    scaled.column_iter_mut().zip(&sizes).for_each(|(mut column, size)| column /= *size);
    // The residual is measured minus predicted, its derivative minus the tangent: the step takes the residual away.
    let gradient = -(scaled.transpose() * left);
    let step = (scaled.transpose() * &scaled).cholesky()?.solve(&gradient);
    Some((gradient.dot(&step), step.iter().zip(&sizes).map(|(s, size)| s / size).collect()))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Beside `b = (1, 1, 1, 1)/2` only what has mean zero counts. Residual `(1, 2, 3, 4)` with the
    /// derivative `(0, −1, −2, −3)`: beside the mean it is gone with coefficient 1, and takes `Σ(x − x̄)² = 5`.
    #[test]
    fn a_tangent_takes_what_is_beside_the_known() {
        let beside = Beside::new(DMatrix::from_column_slice(4, 1, &[2.0; 4]));
        let left = beside.of(&DVector::from_row_slice(&[1.0, 2.0, 3.0, 4.0]));
        let column = beside.of(&DVector::from_row_slice(&[0.0, -1.0, -2.0, -3.0]));
        let (gain, values) = explained(&[column], &left).unwrap();
        assert!((gain - 5.0).abs() < 1e-12 && (values[0] - 1.0).abs() < 1e-12, "{gain} {values:?}");
    }
}
