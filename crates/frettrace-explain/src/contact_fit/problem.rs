//! The fit of a law to recovered contacts.

use super::{Contacts, Recovered};
use crate::effects::FREE;
use crate::fitting::to_rank;
use crate::series_fit::SeriesContact;
use frettrace_forward::accelerations::{FrequencyRatio, Quantity};
use frettrace_friction::effects::{Hook, ModifiedLaw, ModifiedState};
use frettrace_identify::{Fit, FitSettings, IdentifyError, Model, NoSolution, Parameter, Transform, fit};
use nalgebra::DMatrix;
use std::borrow::Cow;
use std::ops::Range;

/// A law with some of its hooks free, against recovered contacts. Where its friction depends on the contact's place, the mean slip of
/// every run is free too, the periodic ones first: values behind those of the hooks.
pub(crate) struct ContactProblem<'a> {
    recovered: &'a Contacts,
    law: ModifiedLaw<f64>,
    modulation: FrequencyRatio,
    hooks: Vec<Hook>,
    parameters: Vec<Parameter>,
}

/// Scale of a mean slip that is to be fitted, over the RMS of the slip.
const MEAN_SCALE: f64 = 0.1;
/// Step, in that scale, of differences by it.
const MEAN_STEP: f64 = 1e-3;

impl<'a> ContactProblem<'a> {
    /// A law, with the frequency of the modulation of its preload, whose hooks are free as the parameters say.
    pub fn new(
        recovered: &'a Contacts,
        (law, modulation): (ModifiedLaw<f64>, FrequencyRatio),
        (hooks, mut parameters): (Vec<Hook>, Vec<Parameter>),
    ) -> Self {
        if law.depends_on_place() {
            parameters.extend(recovered.strokes().map(|(_, stroke)| Parameter {
                transform: Transform::Linear { scale: MEAN_SCALE * stroke },
                ..Parameter::positive("mean_slip", "m", FREE)
            }));
        }
        Self { recovered, law, modulation, hooks, parameters }
    }

    pub fn at(&self, values: &[f64]) -> ModifiedLaw<f64> {
        let mut law = self.law;
        for (&hook, &value) in self.hooks.iter().zip(values) {
            law.set(hook, value);
        }
        law
    }

    /// Fits it in at most so many steps, from the given mean slips (m), nothing where none is given.
    pub fn solve(&self, most: usize, means: &[f64]) -> Result<Fit, IdentifyError> {
        let values = self.hooks.iter().map(|h| self.law.get(*h).unwrap_or_default());
        let means = means.iter().copied().chain(std::iter::repeat(0.0));
        let start: Vec<f64> = values.chain(means).take(self.parameters.len()).collect();
        let settings = FitSettings { secant: true, ..to_rank(most) };
        fit(self, &start, &settings)
    }

    /// Whether a value that a hook in question has is on its bound.
    pub fn is_bound(&self, fit: &Fit, asked: impl Fn(&Hook) -> bool) -> bool {
        self.hooks.iter().zip(&fit.at_bound).any(|(hook, bound)| *bound && asked(hook))
    }

    /// Mean slips (m) among values; none where friction does not depend on the place.
    pub(super) fn means<'b>(&self, values: &'b [f64]) -> &'b [f64] {
        &values[self.hooks.len()..]
    }

    /// The same, each with the index of its run.
    pub fn mean_slips(&self, values: &[f64]) -> Vec<(usize, f64)> {
        self.recovered.strokes().map(|(run, _)| run).zip(self.means(values).iter().copied()).collect()
    }

    /// Mean slips (m) of all runs to begin from: of runs without a period where none is known that of the periodic one which slips most, else
    /// nothing.
    pub fn means_from(&self, known: &[(usize, f64)]) -> Vec<f64> {
        if !self.law.depends_on_place() {
            return Vec::new();
        }
        let before = |run: usize| known.iter().find(|(other, _)| *other == run).map(|(_, mean)| *mean);
        let most = self.recovered.periodic.iter().max_by(|a, b| a.stroke().total_cmp(&b.stroke()));
        let beside = most.and_then(|most| before(most.run)).unwrap_or_default();
        let periodic = self.recovered.periodic.iter().map(|one| before(one.run).unwrap_or_default());
        let others = self.recovered.series.iter().map(|(run, _)| before(*run).unwrap_or(beside));
        periodic.chain(others).collect()
    }

    /// Rows of the lines of periodic runs: counted without means, and in the residual.
    pub(super) fn rows(&self) -> impl Iterator<Item = (usize, usize)> {
        let means = if self.law.depends_on_place() { 2 } else { 0 };
        let runs = self.recovered.periodic.iter().map(Recovered::count).enumerate();
        runs.flat_map(move |(run, count)| (0..count).map(move |_| (run + 1) * means))
            .enumerate()
            .map(|(own, before)| (own, own + before))
    }

    /// The structure that goes with some values, where it leaves anything open.
    pub fn structure(&self, values: &[f64]) -> Vec<(Quantity, f64)> {
        let Some(leeway) = &self.recovered.leeway else { return Vec::new() };
        let mut residual = vec![0.0; self.residual_count()];
        match self.left(values, &mut Vec::new(), &mut residual) {
            Ok(()) => leeway.likely(self, &residual),
            Err(NoSolution) => Vec::new(),
        }
    }

    /// What the law leaves at some values, the structure as it is declared; the states in which the settled periods of the runs begin.
    fn left(
        &self,
        values: &[f64],
        states: &mut Vec<ModifiedState<f64>>,
        residual: &mut [f64],
    ) -> Result<(), NoSolution> {
        let law = self.at(values);
        let mut at = 0;
        states.clear();
        for (recovered, rows) in self.placed(values) {
            at = rows.end;
            states.push(recovered.residual(&law, self.modulation, &mut residual[rows]));
        }
        for (series, _) in self.placed_series(values) {
            series.residual(&law, &mut residual[at..at + series.count()]);
            at += series.count();
        }
        if residual.iter().all(|r| r.is_finite()) { Ok(()) } else { Err(NoSolution) }
    }

    /// Periodic runs with the mean slips that the values hold, each with its rows in the residual.
    fn placed(&self, values: &[f64]) -> impl Iterator<Item = (Cow<'a, Recovered>, Range<usize>)> {
        let means = self.means(values).to_vec();
        let mut at = 0;
        self.recovered.periodic.iter().enumerate().map(move |(k, run)| {
            let run = means.get(k).map_or(Cow::Borrowed(run), |mean| Cow::Owned(run.around(*mean)));
            let rows = at..at + run.count();
            at = rows.end;
            (run, rows)
        })
    }

    /// The others with theirs, each with the place of its mean slip among the values.
    fn placed_series(&self, values: &[f64]) -> impl Iterator<Item = (Cow<'a, SeriesContact>, usize)> {
        let first = self.hooks.len() + self.recovered.periodic.len();
        let means = values.get(first..).unwrap_or_default().to_vec();
        self.recovered.series.iter().enumerate().map(move |(k, (_, series))| {
            let around = |mean: &f64| Cow::Owned(series.around(*mean));
            (means.get(k).map_or(Cow::Borrowed(&**series), around), first + k)
        })
    }
}

/// Writes the derivative of some rows by a mean slip into its column: what is `left` of them so far (m) away, less what they are.
fn differ(
    left: impl Fn(&mut [f64]),
    residual: &[f64],
    (jacobian, first, column): (&mut DMatrix<f64>, usize, usize),
    distance: f64,
) {
    let mut moved = vec![0.0; residual.len()];
    left(&mut moved);
    for (k, (moved, residual)) in moved.iter().zip(residual).enumerate() {
        jacobian[(first + k, column)] = (moved - residual) / distance;
    }
}

/// The residual at some values, with the states in which the settled periods of the runs begin: what derivatives begin from.
#[derive(Clone, Default)]
pub(crate) struct Settled {
    values: Vec<f64>,
    residual: Vec<f64>,
    states: Vec<ModifiedState<f64>>,
}

impl Model for ContactProblem<'_> {
    type Memory = Settled;

    fn parameters(&self) -> &[Parameter] {
        &self.parameters
    }

    fn residual_count(&self) -> usize {
        // A run around a mean slip compares its mean as well.
        let placed = self.law.depends_on_place();
        let lines = |run: &Recovered| run.count() + if placed { 2 } else { 0 };
        let periodic: usize = self.recovered.periodic.iter().map(lines).sum();
        periodic + self.recovered.series.iter().map(|(_, series)| series.count()).sum::<usize>()
    }

    fn memory(&self) -> Settled {
        Settled::default()
    }

    fn residual(&self, values: &[f64], memory: &mut Settled, residual: &mut [f64]) -> Result<(), NoSolution> {
        self.left(values, &mut memory.states, residual)?;
        memory.values = values.to_vec();
        memory.residual = residual.to_vec();
        if let Some(leeway) = &self.recovered.leeway {
            leeway.whiten(self, residual);
        }
        Ok(())
    }

    fn linearise(
        &self,
        values: &[f64],
        free: &[bool],
        memory: &mut Settled,
        target: (&mut [f64], &mut DMatrix<f64>),
    ) -> Result<(), NoSolution> {
        let (residual, jacobian) = target;
        if memory.values != values {
            self.residual(values, memory, residual)?;
        }
        residual.copy_from_slice(&memory.residual);
        let law = self.at(values);
        let hooks: Vec<(usize, Hook)> =
            self.hooks.iter().copied().enumerate().filter(|(j, _)| free[*j]).collect();
        let mut at = 0;
        for (k, (recovered, rows)) in self.placed(values).enumerate() {
            let part = (memory.states[k], jacobian.rows_mut(rows.start, rows.len()));
            recovered.linearise((&law, self.modulation), &hooks, part);
            let column = self.hooks.len() + k;
            if let Some(mean) = values.get(column).filter(|_| free[column]) {
                let plain = &self.recovered.periodic[k];
                let distance = MEAN_STEP * MEAN_SCALE * plain.stroke();
                let moved = plain.around(mean + distance);
                let left = |out: &mut [f64]| {
                    moved.residual(&law, self.modulation, out);
                };
                differ(left, &residual[rows.clone()], (jacobian, rows.start, column), distance);
            }
            at = rows.end;
        }
        for (series, column) in self.placed_series(values) {
            let rows = at..at + series.count();
            let part = (&mut residual[rows.clone()], jacobian.rows_mut(rows.start, rows.len()));
            series.linearise(&law, &hooks, part);
            if free.get(column).is_some_and(|free| *free) {
                let distance = MEAN_STEP * MEAN_SCALE * series.stroke();
                let moved = series.around(distance);
                let left = |out: &mut [f64]| moved.residual(&law, out);
                differ(left, &residual[rows.clone()], (jacobian, rows.start, column), distance);
            }
            at = rows.end;
        }
        if let Some(leeway) = &self.recovered.leeway {
            leeway.whiten(self, residual);
            let columns = jacobian.as_mut_slice().chunks_exact_mut(residual.len());
            columns.zip(free).filter(|(_, free)| **free).for_each(|(column, _)| leeway.whiten(self, column));
        }
        let finite = residual.iter().chain(jacobian.iter()).all(|value| value.is_finite());
        if finite { Ok(()) } else { Err(NoSolution) }
    }
}
