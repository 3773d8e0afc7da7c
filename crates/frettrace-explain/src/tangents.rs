//! What lies outside the contact and the balance does not show: ranked by the tangents of the whole model.
//!
//! Where a force acts near the shape that a contact force makes, the recovered contact force takes most of it and the balance
//! closes; no law then answers the contact. So it does where one mode, which a force on its own line can stand for, is all that
//! changes. With the tangent `c = ∂a/∂κ` of the prediction at `κ = 0`, the whitened residual `r`
//! and `P` the projector beside the tangents of everything that is free already, adding the effect takes `(cᵀPr)²/cᵀPc` from χ² to
//! first order, at `κ = cᵀPr/cᵀPc`.

use crate::balance_fit::BalanceCandidate;
use crate::effects::{ALL, FREE, StructureForm, few_places, listed};
use crate::fitting::AccelerationFit;
use crate::search::Explained;
use crate::study::merge;
use crate::{Study, Unknown, signed};
use frettrace_forward::accelerations::{COEFFICIENTS, Memory, Port, PortLaw, PortPlace, Quantity, Setting};
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

/// Effects that change the structure itself, the same at every level. A mode that is free within what was declared is asked what it
/// would take without that.
const STEADY: [&str; 5] = [
    "structure.frequency-drift",
    "structure.clamp-compliance",
    "structure.added-mass",
    "structure.modal-frequency",
    "structure.modal-damping",
];
/// Candidates that are worth a fit of the whole model.
const ASKED: usize = 3;

/// Share of χ² above the noise that a tangent must promise to take: the first step towards a strong force takes a fifth.
const WORTH: f64 = 0.1;

impl Study<'_> {
    /// Smooth forces on the beam, and changes of the structure, by what their tangents promise: best first, one of each effect.
    pub(crate) fn tangent_candidates(&self, current: &Explained) -> Vec<BalanceCandidate> {
        let few = |run: &usize| self.model.runs[*run].contact_order <= MOST_LINES;
        let runs: Vec<usize> = self.training.iter().copied().filter(few).collect();
        // The jumps of a force that is set-valued at rest move with everything: no tangent reaches far.
        if runs.is_empty() || current.fitted.setting.holds_rigidly() {
            return Vec::new();
        }
        let Some(known) = self.known(current, runs) else { return Vec::new() };
        // Two forces beside the contact's are not told apart by their tangents.
        let places: &[f64] = if current.fitted.setting.ports.is_empty() { &PLACES } else { &[] };
        let places = places.par_iter().map(|share| PortPlace::At(share * self.scales.length));
        let forces = places.flat_map_iter(|place| self.forces(current, place, &known));
        let steady = STEADY.par_iter().flat_map_iter(|id| self.changes(current, id, &known));
        let mut found: Vec<BalanceCandidate> = forces.chain(steady).collect();
        found.sort_by(BalanceCandidate::by_criterion);
        BalanceCandidate::leave_one_of_each_kind(&mut found);
        let mut effects = Vec::new();
        found.retain(|candidate| {
            if !effects.contains(&candidate.effect) {
                effects.push(candidate.effect);
            }
            effects.len() <= ASKED
        });
        found
    }

    /// The index of an effect that may be asked for.
    fn asked(&self, current: &Explained, id: &str) -> Option<usize> {
        let effect = listed(id)?;
        (self.case.allows(id) && !current.effects.contains(&effect)).then_some(effect)
    }

    /// A form of an effect as a candidate, where the share of χ² above the noise that it promises to take is worth it.
    fn promising(
        &self,
        (current, known): (&Explained, &Known),
        (effect, form): (usize, StructureForm),
        gain: f64,
    ) -> Option<BalanceCandidate> {
        let count = self.residual_count() as f64;
        let left = current.fitted.fit.cost - gain;
        (gain > WORTH * known.excess).then(|| BalanceCandidate {
            effect,
            sensor: None,
            criterion: left + form.unknowns.len() as f64 * count.ln(),
            reduced: left / count,
            setting: form.setting,
            unknowns: form.unknowns,
        })
    }

    /// Some runs as something to fit.
    fn problem(
        &self,
        setting: Setting,
        unknowns: &[Unknown],
        (runs, warm): (Vec<usize>, Memory),
    ) -> AccelerationFit<'_> {
        AccelerationFit::new(&self.model, setting, unknowns, runs, warm).beside(self.support.as_deref())
    }

    /// The forms of a change of the structure.
    fn changes(&self, current: &Explained, id: &str, known: &Known) -> Vec<BalanceCandidate> {
        let Some(effect) = self.asked(current, id) else { return Vec::new() };
        let forms = ALL[effect].structure_forms(self.case, &current.fitted.setting, &self.scales);
        let candidate = |mut form: StructureForm| {
            // Its size; shapes and places mean nothing without one.
            let size = form.unknowns.first()?.clone();
            let tangent = known.tangent(size.quantity).or_else(|| {
                let (warm, runs) = (current.fitted.memory.clone(), known.runs.clone());
                let own = std::slice::from_ref(&size);
                let problem = self.problem(form.setting.clone(), own, (runs, warm));
                linearised(&problem).map(|(_, jacobian)| jacobian.column(0).into_owned())
            })?;
            let tangent = tangent.resize_vertically(known.left.len(), 0.0);
            let (gain, values) = explained(&[known.beside.of(&tangent)], &known.left)?;
            let (lowest, highest) = size.parameter.bounds;
            let start = form.setting.get(size.quantity).unwrap_or_default();
            form.setting.set(size.quantity, (start + values[0]).clamp(lowest, highest));
            self.promising((current, known), (effect, form), gain)
        };
        few_places(forms).into_iter().filter_map(candidate).collect()
    }

    /// What is free already, at the present values; `None` where the model has no answer there.
    fn known(&self, current: &Explained, runs: Vec<usize>) -> Option<Known> {
        let setting = current.fitted.setting.clone();
        let free = merge(&self.case.unknowns(), &current.added);
        let free: Vec<Unknown> = free.into_iter().filter(|u| setting.get(u.quantity).is_some()).collect();
        let warm = current.fitted.memory.clone();
        let (residual, jacobian) = linearised(&self.problem(setting, &free, (runs.clone(), warm)))?;
        let priors: Vec<(usize, f64)> = (free.iter().enumerate())
            .filter_map(|(j, u)| u.parameter.prior.map(|prior| (j, prior.std.recip())))
            .collect();
        let lines = residual.len();
        let rows = lines + priors.len();
        let free = free.into_iter().map(|u| u.quantity).collect();
        let mut tangents = jacobian.clone().resize_vertically(rows, 0.0);
        for (row, &(j, weight)) in priors.iter().enumerate() {
            tangents[(lines + row, j)] = weight;
        }
        let beside = Beside::new(tangents);
        let left = beside.of(&residual.resize_vertically(rows, 0.0));
        let excess = (left.norm_squared() - lines as f64).max(f64::MIN_POSITIVE);
        Some(Known { runs, free, jacobian, beside, left, excess })
    }

    /// The smooth forces at a place; none where the model has no answer there.
    fn forces(&self, current: &Explained, place: PortPlace, known: &Known) -> Vec<BalanceCandidate> {
        let mut setting = current.fitted.setting.clone();
        setting.ports.push(Port { place, law: PortLaw::Polynomial, coefficients: [0.0; COEFFICIENTS] });
        let index = setting.ports.len() - 1;
        let unknowns: Vec<Unknown> = (0..COEFFICIENTS)
            .map(|k| signed(Quantity::Port(index, k), ("coefficient", ""), 1.0, FREE))
            .collect();
        let warm = current.fitted.memory.with_idle_port(index);
        let problem = self.problem(setting, &unknowns, (known.runs.clone(), warm));
        let Some((_, jacobian)) = linearised(&problem) else { return Vec::new() };
        let tangents = jacobian.resize_vertically(known.left.len(), 0.0);
        let candidate = |&(id, free): &(&str, &'static [usize])| {
            let effect = self.asked(current, id)?;
            let columns: Vec<DVector<f64>> =
                free.iter().map(|&k| known.beside.of(&tangents.column(k).into_owned())).collect();
            let (gain, values) = explained(&columns, &known.left)?;
            let mut coefficients = [0.0; COEFFICIENTS];
            free.iter().zip(&values).for_each(|(&k, value)| coefficients[k] = *value);
            let port = Port { place, law: PortLaw::Polynomial, coefficients };
            let form = self.form(&current.fitted.setting, port, (free, None));
            self.promising((current, known), (effect, form), gain)
        };
        SMOOTH.iter().filter_map(candidate).collect()
    }
}

/// What is free already, on the runs that are asked.
struct Known {
    runs: Vec<usize>,
    free: Vec<Quantity>,
    /// Tangents of the lines, a column for each of these.
    jacobian: DMatrix<f64>,
    /// Projector beside its tangents.
    beside: Beside,
    /// The residual beside them: lines, and a row for each prior.
    left: DVector<f64>,
    /// χ² of that above the noise.
    excess: f64,
}

impl Known {
    /// Tangent of what is free already; beside itself it is what its prior holds back.
    fn tangent(&self, quantity: Quantity) -> Option<DVector<f64>> {
        let place = self.free.iter().position(|free| *free == quantity)?;
        Some(self.jacobian.column(place).into_owned())
    }
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
