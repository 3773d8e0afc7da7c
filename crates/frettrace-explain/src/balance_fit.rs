//! Structure, excitation and sensors on the balance of the runs: no friction law takes part.

use crate::contact_search::{few_of_each, within_reach};
use crate::effects::{ALL, StructureForm};
use crate::fitting::to_rank;
use crate::search::Explained;
use crate::study::merge;
use crate::{Study, Unknown};
use frettrace_forward::accelerations::{AccelerationModel, Balance, Beside, Quantity, Setting};
use frettrace_identify::{FitSettings, Model, NoSolution, Parameter, fit};
use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;
use std::cmp::Ordering;

/// Balance of selected runs with some quantities free.
pub(crate) struct BalanceProblem<'a> {
    model: &'a AccelerationModel,
    runs: &'a [usize],
    setting: Setting,
    quantities: Vec<Quantity>,
    parameters: Vec<Parameter>,
    beside: Beside,
}

/// A structure form on the balance, with what it costs.
#[derive(Clone)]
pub(crate) struct BalanceCandidate {
    pub effect: usize,
    pub sensor: Option<usize>,
    pub setting: Setting,
    pub unknowns: Vec<Unknown>,
    /// `χ² + k ln n`.
    pub criterion: f64,
    /// χ² over its degrees of freedom.
    pub reduced: f64,
}

impl BalanceCandidate {
    /// The order of two by what they cost, the nearer one first.
    pub(crate) fn by_criterion(&self, other: &Self) -> Ordering {
        self.criterion.total_cmp(&other.criterion)
    }

    /// A form of an effect that no balance was fitted with, for the whole model to be asked with it.
    pub fn unfitted(effect: usize, form: StructureForm, criterion: f64) -> Self {
        let StructureForm { setting, unknowns, sensor } = form;
        Self { effect, sensor, setting, unknowns, criterion, reduced: f64::NAN }
    }

    /// What forms have in common that only the whole model tells apart: the effect, whether it moves one mode or all of them, and
    /// whether a drift settles.
    pub fn kind(&self) -> (usize, [bool; 2]) {
        let all = |u: &Unknown| matches!(u.quantity, Quantity::FrequencyScale | Quantity::DampingScale);
        let settles = |u: &Unknown| u.quantity == Quantity::DriftRate;
        (self.effect, [self.unknowns.iter().any(all), self.unknowns.iter().any(settles)])
    }

    /// Leaves the first of each [`kind`](Self::kind), in the order that they have.
    pub fn leave_one_of_each_kind(candidates: &mut Vec<Self>) {
        let mut seen = Vec::new();
        candidates.retain(|candidate| {
            let new = !seen.contains(&candidate.kind());
            seen.push(candidate.kind());
            new
        });
    }
}

impl<'a> BalanceProblem<'a> {
    fn new(study: &'a Study<'_>, setting: Setting, unknowns: &[Unknown]) -> Self {
        Self {
            model: &study.model,
            runs: &study.training,
            setting,
            quantities: unknowns.iter().map(|u| u.quantity).collect(),
            parameters: unknowns.iter().map(|u| u.parameter.clone()).collect(),
            beside: Beside::Nothing,
        }
    }

    fn at(&self, values: &[f64]) -> Setting {
        let mut setting = self.setting.clone();
        for (&quantity, &value) in self.quantities.iter().zip(values) {
            setting.set(quantity, value);
        }
        setting
    }

    /// The residual and its derivatives where no port answers.
    fn slopes(
        &self,
        setting: &Setting,
        free: &[bool],
        (residual, jacobian): (&mut [f64], &mut DMatrix<f64>),
    ) -> Result<(), NoSolution> {
        let (places, quantities): (Vec<usize>, Vec<Quantity>) =
            self.quantities.iter().enumerate().filter(|(j, _)| free[*j]).unzip();
        let found = self.model.balance_slopes(setting, &quantities, self.runs).map_err(|_| NoSolution)?;
        let mut at = 0;
        for (balance, columns) in &found {
            for (s, lines) in balance.left.iter().enumerate() {
                for (h, left) in lines.iter().enumerate().skip(1) {
                    (residual[at], residual[at + 1]) = (left.re, left.im);
                    for (column, &j) in columns.iter().zip(&places) {
                        (jacobian[(at, j)], jacobian[(at + 1, j)]) = (column[s][h].re, column[s][h].im);
                    }
                    at += 2;
                }
            }
        }
        let finite = residual.iter().chain(jacobian.iter()).all(|value| value.is_finite());
        if finite { Ok(()) } else { Err(NoSolution) }
    }

    fn start(&self) -> Vec<f64> {
        self.quantities.iter().map(|&q| self.setting.get(q).unwrap_or_default()).collect()
    }
}

/// Lines from the first on: no structure accelerates on the mean, and the one that a bent reading has would hide all that a structure changes.
fn flatten(balances: &[Balance], residual: &mut [f64]) {
    let mut at = 0;
    for left in balances.iter().flat_map(|b| b.left.iter().flat_map(|lines| lines.iter().skip(1))) {
        residual[at] = left.re;
        residual[at + 1] = left.im;
        at += 2;
    }
}

impl Model for BalanceProblem<'_> {
    type Memory = ();

    fn parameters(&self) -> &[Parameter] {
        &self.parameters
    }

    fn residual_count(&self) -> usize {
        self.runs
            .iter()
            .map(|&run| {
                let lines = &self.model.runs[run];
                2 * lines.acceleration.len() * lines.order()
            })
            .sum()
    }

    fn memory(&self) {}

    fn residual(&self, values: &[f64], _memory: &mut (), residual: &mut [f64]) -> Result<(), NoSolution> {
        let balances =
            self.model.balance_beside(&self.at(values), self.runs, self.beside).map_err(|_| NoSolution)?;
        flatten(&balances, residual);
        if residual.iter().all(|r| r.is_finite()) { Ok(()) } else { Err(NoSolution) }
    }

    fn linearise(
        &self,
        values: &[f64],
        free: &[bool],
        memory: &mut (),
        target: (&mut [f64], &mut DMatrix<f64>),
    ) -> Result<(), NoSolution> {
        let (residual, jacobian) = target;
        let setting = self.at(values);
        if setting.ports.is_empty() && self.beside == Beside::Nothing {
            return self.slopes(&setting, free, (residual, jacobian));
        }
        self.residual(values, memory, residual)?;
        let mut beside = vec![0.0; residual.len()];
        for j in (0..values.len()).filter(|&j| free[j]) {
            let distance = 1e-3 * self.parameters[j].transform.size(values[j]);
            let mut moved = values.to_vec();
            moved[j] += distance;
            self.residual(&moved, memory, &mut beside)?;
            for (row, (new, old)) in beside.iter().zip(residual.iter()).enumerate() {
                jacobian[(row, j)] = (new - old) / distance;
            }
        }
        Ok(())
    }
}

/// Steps of a fit of two effects on the balance.
const TOGETHER: usize = 12;

impl Study<'_> {
    /// χ² of the balance over its degrees of freedom: all training runs, and the worst of them.
    pub(crate) fn balance_reduced(&self, setting: &Setting) -> (f64, f64) {
        let Ok(balances) = self.model.balance(setting, &self.training) else {
            return (f64::INFINITY, f64::INFINITY);
        };
        let over = |(chi, freedom): (f64, usize)| chi / freedom.max(1) as f64;
        let worst = balances.iter().map(|balance| over(balance.chi_squared())).fold(0.0, f64::max);
        (over(Balance::chi_squared_of(&balances)), worst)
    }

    /// Share of what a model leaves on its lines, beside their noise, that no contact force takes: what its balance leaves, with the structure
    /// anywhere within what is declared of it.
    pub(crate) fn share_of_balance(&self, model: &Explained) -> f64 {
        let (_, structural) = Unknown::parted(&model.added);
        let calibrated = self.balance_base(&model.fitted.setting, &structural).setting;
        let Ok(balances) = self.model.balance(&calibrated, &self.training) else { return 0.0 };
        let (chi_squared, freedom) = Balance::chi_squared_of(&balances);
        let left = model.left();
        (chi_squared - freedom as f64) / (left.excess() * left.count)
    }

    fn structure_unknowns(&self) -> Vec<Unknown> {
        let modal = |q: Quantity| matches!(q, Quantity::ModeFrequency(_) | Quantity::ModeDamping(_));
        self.case.unknowns().into_iter().filter(|u| modal(u.quantity)).collect()
    }

    /// The structure calibrated on the balance alone, beside the unknowns of effects.
    pub(crate) fn balance_base(&self, setting: &Setting, added: &[Unknown]) -> BalanceCandidate {
        let form = StructureForm { setting: setting.clone(), unknowns: Vec::new(), sensor: None };
        let unknowns = merge(&self.structure_unknowns(), added);
        self.balance_fit(usize::MAX, &form, &unknowns, 6)
    }

    /// The structure calibrated on what the free values beside the contact force leave of the balance.
    pub(crate) fn calibrated_beside(&self, setting: &Setting, beside: Beside) -> Setting {
        self.calibrated_with(setting, beside, (&[], 4))
    }

    /// The same with further values free, in so many steps at most.
    pub(crate) fn calibrated_with(
        &self,
        setting: &Setting,
        beside: Beside,
        (added, most): (&[Unknown], usize),
    ) -> Setting {
        let unknowns = merge(&self.structure_unknowns(), added);
        let mut problem = BalanceProblem::new(self, setting.clone(), &unknowns);
        problem.beside = beside;
        let settings = FitSettings {
            max_iterations: most,
            relative_tolerance: 1e-3,
            secant: true,
            ..FitSettings::default()
        };
        fit(&problem, &problem.start(), &settings).map_or_else(|_| setting.clone(), |f| problem.at(&f.values))
    }

    /// A candidate on the balance with its values, and those of effects beside it, free together.
    pub(crate) fn balance_together(&self, found: &BalanceCandidate, added: &[Unknown]) -> BalanceCandidate {
        let form =
            StructureForm { setting: found.setting.clone(), unknowns: Vec::new(), sensor: found.sensor };
        let unknowns = merge(&self.structure_unknowns(), &merge(added, &found.unknowns));
        self.balance_fit(found.effect, &form, &unknowns, TOGETHER)
    }

    fn balance_fit(
        &self,
        effect: usize,
        form: &StructureForm,
        unknowns: &[Unknown],
        most: usize,
    ) -> BalanceCandidate {
        let problem = BalanceProblem::new(self, form.setting.clone(), unknowns);
        let count = problem.residual_count() as f64;
        let settings = FitSettings { secant: true, ..to_rank(most) };
        let (setting, cost) = match fit(&problem, &problem.start(), &settings) {
            Ok(found) => (problem.at(&found.values), found.cost),
            Err(_) => (form.setting.clone(), f64::INFINITY),
        };
        let sensors = self.case.rig.sensors.len() as f64;
        let freedom = count * (sensors - 1.0) / sensors;
        BalanceCandidate {
            effect,
            sensor: form.sensor,
            setting,
            criterion: cost + unknowns.len() as f64 * count.ln(),
            reduced: cost / freedom,
            unknowns: unknowns.to_vec(),
        }
    }

    /// Every effect outside the friction law on the balance, best first, one form each: further forces on the beam by their laws where
    /// `by_law`.
    pub(crate) fn balance_candidates(
        &self,
        setting: &Setting,
        added: &[Unknown],
        (taken, by_law): (&[usize], bool),
    ) -> Vec<BalanceCandidate> {
        let forms: Vec<(usize, StructureForm)> = ALL
            .iter()
            .enumerate()
            .filter(|(index, effect)| !taken.contains(index) && self.case.allows(effect.id()))
            .flat_map(|(index, effect)| {
                effect
                    .structure_forms(self.case, setting, &self.scales)
                    .into_iter()
                    .filter(|form| by_law || !form.adds_a_force(setting))
                    .map(move |form| (index, form))
            })
            .collect();
        let mut order: Vec<(f64, usize)> = forms
            .par_iter()
            .enumerate()
            .filter_map(|(k, (_, form))| self.promise(form).map(|left| (left, k)))
            .collect();
        order.sort_by(|a, b| a.0.total_cmp(&b.0));
        few_of_each(&mut order, PROMISING, |k| (forms[k].0, ()));
        let base = merge(&self.structure_unknowns(), added);
        // The effect's own values first, then, where that comes near, the structure beside them.
        let own: Vec<(BalanceCandidate, &StructureForm)> = order
            .par_iter()
            .map(|(_, k)| {
                let (effect, form) = &forms[*k];
                (self.balance_fit(*effect, form, &form.unknowns, 12), form)
            })
            .collect();
        let least = own.iter().map(|(one, _)| one.criterion).fold(f64::INFINITY, f64::min);
        let mut found: Vec<BalanceCandidate> = own
            .into_par_iter()
            .map(|(own, form)| {
                if !within_reach(own.criterion, least) {
                    return own;
                }
                let again = StructureForm { setting: own.setting, ..form.clone() };
                self.balance_fit(own.effect, &again, &merge(&base, &form.unknowns), 6)
            })
            .collect();
        found.sort_by(BalanceCandidate::by_criterion);
        BalanceCandidate::leave_one_of_each_kind(&mut found);
        found
    }

    /// χ² that a form leaves to first order.
    fn promise(&self, form: &StructureForm) -> Option<f64> {
        let problem = BalanceProblem::new(self, form.setting.clone(), &form.unknowns);
        let count = problem.residual_count();
        let width = form.unknowns.len();
        let mut residual = vec![0.0; count];
        let mut jacobian = DMatrix::zeros(count, width);
        let start = problem.start();
        problem.linearise(&start, &vec![true; width], &mut (), (&mut residual, &mut jacobian)).ok()?;
        for (j, u) in form.unknowns.iter().enumerate() {
            jacobian.column_mut(j).scale_mut(u.parameter.transform.slope(start[j].abs().max(1e-300)));
        }
        let right = DVector::from_vec(residual);
        let normal = jacobian.transpose() * &jacobian;
        let largest = normal.diagonal().max();
        let ridge = DMatrix::from_diagonal_element(width, width, 1e-9 * largest + f64::MIN_POSITIVE);
        let gradient = jacobian.transpose() * &right;
        let step = (normal + ridge).cholesky()?.solve(&gradient);
        Some(right.norm_squared() - gradient.dot(&step))
    }
}

/// Forms that are fitted on the balance.
const PROMISING: usize = 8;
