//! The acceleration-level model as something to fit.

use crate::support::SupportForce;
use frettrace_forward::accelerations::{
    AccelerationModel, Linearised, Memory, Prediction, Quantity, Setting,
};
use frettrace_friction::effects::{Hook, ModifiedLaw};
use frettrace_identify::{FitSettings, Model, NoSolution, Parameter, Transform};
use nalgebra::DMatrix;
use num_complex::Complex64;

/// Size of a damping over one that takes the whole friction at the largest slip velocity.
const DAMPING: f64 = 0.1;

/// How a candidate is fitted that is ranked by what it leaves, and begins a fit of the whole model: to a thousandth of χ² or a half, beside
/// which evidence of 10 is told.
pub(crate) fn to_rank(most: usize) -> FitSettings {
    FitSettings {
        max_iterations: most,
        relative_tolerance: 1e-3,
        absolute_tolerance: 0.5,
        ..FitSettings::default()
    }
}

/// A quantity of the acceleration-level model with what is known of it.
#[derive(Clone, Debug, PartialEq)]
pub struct Unknown {
    /// The quantity.
    pub quantity: Quantity,
    /// Name, unit, bounds, prior.
    pub parameter: Parameter,
}

impl Unknown {
    /// Whether it is a value of the contact's law.
    pub(crate) fn is_of_law(&self) -> bool {
        matches!(self.quantity, Quantity::Law(_))
    }

    /// The same with the size that a damping of the contact has: a tenth of what takes the whole friction of a law at the largest slip
    /// velocity (m/s) under a preload (N), or its own. Newtons a second and metre are no measure: a contact that slips by nanometres
    /// may have ten thousand of them, and a fit that takes ten sizes a step would never come there.
    pub(crate) fn sized(&self, law: &ModifiedLaw<f64>, [preload, velocity]: [f64; 2]) -> Self {
        let mut sized = self.clone();
        if let Quantity::Law(hook) = self.quantity {
            let full = law.get(Hook::MuKinetic).unwrap_or(1.0) / velocity;
            let typical = match hook {
                Hook::Viscous => DAMPING * full * preload,
                Hook::Sigma1 => DAMPING * full,
                _ => return sized,
            };
            let scale = typical.max(law.get(hook).unwrap_or_default().abs());
            sized.parameter.transform = Transform::Linear { scale };
        }
        sized
    }

    /// Those that are values of the contact's law, by their hooks, in the sizes that they have there ([`Self::sized`]): the stiffness of a
    /// contact without a presliding range is no value of it.
    pub(crate) fn hooks(
        all: &[Self],
        (law, rigid): (&ModifiedLaw<f64>, bool),
        sizes: [f64; 2],
    ) -> (Vec<Hook>, Vec<Parameter>) {
        let idle = |hook: Hook| rigid && !law.yields() && hook == Hook::Sigma0;
        let of_law = |unknown: &Self| match unknown.quantity {
            Quantity::Law(hook) if !idle(hook) => Some((hook, unknown.sized(law, sizes).parameter)),
            _ => None,
        };
        all.iter().filter_map(of_law).unzip()
    }

    /// Those that are values of the contact's law, and the others.
    pub(crate) fn parted(all: &[Self]) -> (Vec<Self>, Vec<Self>) {
        all.iter().cloned().partition(Self::is_of_law)
    }
}

/// The acceleration-level model of selected runs as a least-squares problem: residuals are measured minus predicted
/// lines over their standard deviations, real and imaginary parts.
pub struct AccelerationFit<'a> {
    model: &'a AccelerationModel,
    setting: Setting,
    quantities: Vec<Quantity>,
    parameters: Vec<Parameter>,
    runs: Vec<usize>,
    warm: Memory,
    support: Option<&'a SupportForce>,
}

impl<'a> AccelerationFit<'a> {
    /// A fit of `unknowns` around `setting` to the runs of the given indices; `warm` holds solutions near it.
    #[must_use]
    pub fn new(
        model: &'a AccelerationModel,
        setting: Setting,
        unknowns: &[Unknown],
        runs: Vec<usize>,
        warm: Memory,
    ) -> Self {
        Self {
            model,
            setting,
            quantities: unknowns.iter().map(|u| u.quantity).collect(),
            parameters: unknowns.iter().map(|u| u.parameter.clone()).collect(),
            runs,
            warm,
            support: None,
        }
    }

    /// The same with the force of a second support free in every line: what of the residuals it takes is left out.
    #[must_use]
    pub fn beside(self, support: Option<&'a SupportForce>) -> Self {
        Self { support, ..self }
    }

    /// Real residuals of all lines of each run.
    fn lines(&self) -> Vec<(usize, usize)> {
        let count =
            |run: &usize| self.model.runs[*run].acceleration.iter().map(|lines| 2 * lines.len()).sum();
        self.runs.iter().map(|run| (*run, count(run))).collect()
    }

    /// Real residuals of each run, without those that the force of a second support takes.
    #[must_use]
    pub fn sizes(&self) -> Vec<usize> {
        let taken = |run| self.support.map_or(0, |support| support.taken(run));
        self.lines().into_iter().map(|(run, count)| count - taken(run)).collect()
    }

    /// What no force of a second support explains of columns of all lines.
    #[must_use]
    pub fn rest(&self, all: DMatrix<f64>) -> DMatrix<f64> {
        match self.support {
            Some(support) => support.rest(&self.lines(), all),
            None => all,
        }
    }

    /// The setting at the given values.
    #[must_use]
    pub fn at(&self, values: &[f64]) -> Setting {
        let mut setting = self.setting.clone();
        for (&quantity, &value) in self.quantities.iter().zip(values) {
            setting.set(quantity, value);
        }
        setting
    }

    /// Values of the quantities in the setting the fit starts from.
    #[must_use]
    pub fn start(&self) -> Vec<f64> {
        self.quantities.iter().map(|&q| self.setting.get(q).unwrap_or_default()).collect()
    }

    /// Visits every line of the selected runs in the order of the residual.
    fn each_line(&self, mut visit: impl FnMut(usize, usize, usize, Complex64, f64)) {
        for (place, &run) in self.runs.iter().enumerate() {
            let lines = &self.model.runs[run];
            for (s, (measured, deviation)) in lines.acceleration.iter().zip(&lines.deviation).enumerate() {
                for (h, (value, std)) in measured.iter().zip(deviation).enumerate() {
                    visit(place, s, h, *value, *std);
                }
            }
        }
    }

    fn whiten(&self, predicted: &[impl AsPrediction], residual: &mut [f64]) {
        if self.support.is_none() {
            return self.whiten_lines(predicted, residual);
        }
        let mut all = DMatrix::zeros(self.lines().iter().map(|(_, count)| count).sum(), 1);
        self.whiten_lines(predicted, all.as_mut_slice());
        residual.copy_from_slice(self.rest(all).as_slice());
    }

    fn whiten_lines(&self, predicted: &[impl AsPrediction], residual: &mut [f64]) {
        let mut at = 0;
        self.each_line(|place, s, h, measured, std| {
            let left = (measured - predicted[place].lines()[s][h]) / std;
            residual[at] = left.re;
            residual[at + 1] = left.im;
            at += 2;
        });
    }
}

trait AsPrediction {
    fn lines(&self) -> &Prediction;
}

impl AsPrediction for Prediction {
    fn lines(&self) -> &Prediction {
        self
    }
}

impl AsPrediction for Linearised {
    fn lines(&self) -> &Prediction {
        &self.prediction
    }
}

impl Model for AccelerationFit<'_> {
    type Memory = Memory;

    fn parameters(&self) -> &[Parameter] {
        &self.parameters
    }

    fn residual_count(&self) -> usize {
        self.sizes().iter().sum()
    }

    fn memory(&self) -> Memory {
        self.warm.clone()
    }

    fn residual(&self, values: &[f64], memory: &mut Memory, residual: &mut [f64]) -> Result<(), NoSolution> {
        let predicted = self.model.predict(&self.at(values), &self.runs, memory).map_err(|_| NoSolution)?;
        self.whiten(&predicted, residual);
        Ok(())
    }

    fn linearise(
        &self,
        values: &[f64],
        free: &[bool],
        memory: &mut Memory,
        target: (&mut [f64], &mut DMatrix<f64>),
    ) -> Result<(), NoSolution> {
        let (residual, jacobian) = target;
        let chosen: Vec<usize> = (0..values.len()).filter(|&j| free[j]).collect();
        let quantities: Vec<Quantity> = chosen.iter().map(|&j| self.quantities[j]).collect();
        let linearised = self
            .model
            .linearise(&self.at(values), &quantities, &self.runs, memory)
            .map_err(|_| NoSolution)?;
        self.whiten(&linearised, residual);
        let write = |target: &mut DMatrix<f64>, column: usize, to: usize| {
            let mut at = 0;
            self.each_line(|place, s, h, _, std| {
                let change = -linearised[place].columns[column][s][h] / std;
                target[(at, to)] = change.re;
                target[(at + 1, to)] = change.im;
                at += 2;
            });
        };
        if self.support.is_none() {
            chosen.iter().enumerate().for_each(|(column, &j)| write(jacobian, column, j));
            return Ok(());
        }
        let rows = self.lines().iter().map(|(_, count)| count).sum();
        let mut all = DMatrix::zeros(rows, chosen.len());
        (0..chosen.len()).for_each(|column| write(&mut all, column, column));
        let rest = self.rest(all);
        chosen.iter().enumerate().for_each(|(column, &j)| jacobian.set_column(j, &rest.column(column)));
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::case::positive;
    use crate::signed;

    /// Friction of 0.3 × 30 N at 0.1 mm/s is 9e4 N·s/m: a tenth of that is the size of a damping, unless its own is larger, and over the
    /// preload that of the bristle's. What is fitted in its logarithm needs none.
    #[test]
    fn dampings_have_the_size_of_their_contact() {
        let scale = |hook, value: f64| {
            let mut law = ModifiedLaw::dahl(1e5, 0.3);
            law.set(hook, value);
            let unknown = signed(Quantity::Law(hook), ("damping", ""), 1.0, (0.0, f64::INFINITY));
            match unknown.sized(&law, [30.0, 1e-4]).parameter.transform {
                Transform::Linear { scale } => scale,
                Transform::Log => f64::NAN,
            }
        };
        assert!((scale(Hook::Viscous, 0.0) - 9e3).abs() < 1e-9);
        assert!((scale(Hook::Viscous, 2e4) - 2e4).abs() < 1e-9);
        assert!((scale(Hook::Sigma1, 0.0) - 300.0).abs() < 1e-9);
        let friction = positive(Hook::MuKinetic, 1e-4, 20.0);
        assert_eq!(friction.sized(&ModifiedLaw::dahl(1e5, 0.3), [30.0, 1e-4]), friction);
    }
}
