//! Predictions of a fitted model, kept: a run that nothing was fitted to may be hard to balance, and its error is asked for again and again.

use crate::kept::Kept;
use frettrace_forward::accelerations::{OnGrids, Prediction, Setting};

/// What a prediction is told by: the run, the grids of the model, its values, and whether a run without a solution to start from is approached by a
/// longer way.
#[derive(Clone, PartialEq)]
pub(crate) struct By {
    pub run: usize,
    pub grids: OnGrids,
    pub setting: Setting,
    pub approached: bool,
}

/// Known predictions of runs, `None` where a balance does not close.
pub(crate) type Predicted = Kept<By, Option<Prediction>>;

#[cfg(test)]
mod tests {
    use super::*;
    use frettrace_beam::{Boundary, UniformBeam};
    use frettrace_forward::accelerations::{AccelerationModel, Rig};
    use frettrace_friction::effects::ModifiedLaw;
    use num_complex::Complex64;

    /// A prediction is known to copies of the fitted model, by the same grids and values: not to a run that was not asked, to another law, to a
    /// model with grids of its own, nor to one that would have approached the run.
    #[test]
    fn a_prediction_is_known_by_what_it_was_told_by() {
        let rig = Rig {
            beam: UniformBeam::rectangular(1.0, [0.04, 0.005], 2e11, 7800.0),
            boundary: Boundary::spring(1e6),
            exciter: 0.3,
            sensors: vec![0.8],
            lever: None,
            known_support: None,
            modes: 5,
        };
        let model = AccelerationModel::new(rig, Vec::new()).unwrap();
        let by = |model: &AccelerationModel, run: usize, mu: f64, approached: bool| By {
            run,
            grids: model.on_grids(),
            setting: Setting::new(Vec::new(), Vec::new(), ModifiedLaw::dahl(1e5, mu), 1),
            approached,
        };
        let own = |run: usize| by(&model, run, 0.3, false);
        let lines = Some(vec![vec![Complex64::new(0.0, 2.0)]]);
        let predicted = Predicted::default();
        predicted.clone().keep(own(2), lines.clone());
        predicted.keep(own(3), None);
        assert_eq!(predicted.of(&own(2)), Some(lines.clone()));
        assert_eq!(predicted.of(&by(&model.clone(), 2, 0.3, false)), Some(lines));
        assert_eq!(predicted.of(&own(3)), Some(None));
        let others = [
            own(1),
            by(&model, 2, 0.4, false),
            by(&model, 2, 0.3, true),
            by(&model.with_runs(Vec::new()).unwrap(), 2, 0.3, false),
        ];
        assert!(others.iter().all(|by| predicted.of(by).is_none()));
    }
}
