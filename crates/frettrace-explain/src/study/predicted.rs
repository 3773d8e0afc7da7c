//! Predictions of a fitted model, kept: a run that nothing was fitted to may be hard to balance, and its error is asked for again and again.

use frettrace_forward::accelerations::{OnGrids, Prediction, Setting};
use std::sync::{Arc, Mutex, PoisonError};

/// What a prediction is told by: the grids of the model, its values, and whether a run without a solution to start from is approached by a
/// longer way.
#[derive(Clone, PartialEq)]
pub(super) struct By {
    pub grids: OnGrids,
    pub setting: Setting,
    pub approached: bool,
}

/// A prediction of a run, `None` where its balance does not close.
struct Known {
    by: By,
    run: usize,
    prediction: Option<Prediction>,
}

/// Known predictions. Copies share them.
#[derive(Clone, Default)]
pub(crate) struct Predicted(Arc<Mutex<Vec<Known>>>);

impl Predicted {
    /// What is known of a run; `None` where nothing is.
    pub(super) fn of(&self, by: &By, run: usize) -> Option<Option<Prediction>> {
        let known = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        known.iter().find(|one| one.run == run && one.by == *by).map(|one| one.prediction.clone())
    }

    /// Keeps what was found of a run.
    pub(super) fn keep(&self, by: By, run: usize, prediction: Option<Prediction>) {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).push(Known { by, run, prediction });
    }
}

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
        let by = |model: &AccelerationModel, mu: f64, approached: bool| By {
            grids: model.on_grids(),
            setting: Setting::new(Vec::new(), Vec::new(), ModifiedLaw::dahl(1e5, mu), 1),
            approached,
        };
        let own = by(&model, 0.3, false);
        let lines = Some(vec![vec![Complex64::new(0.0, 2.0)]]);
        let predicted = Predicted::default();
        predicted.clone().keep(own.clone(), 2, lines.clone());
        predicted.keep(own.clone(), 3, None);
        assert_eq!(predicted.of(&own, 2), Some(lines.clone()));
        assert_eq!(predicted.of(&by(&model.clone(), 0.3, false), 2), Some(lines));
        assert_eq!(predicted.of(&own, 3), Some(None));
        let others = [
            (own, 1),
            (by(&model, 0.4, false), 2),
            (by(&model, 0.3, true), 2),
            (by(&model.with_runs(Vec::new()).unwrap(), 0.3, false), 2),
        ];
        assert!(others.iter().all(|(by, run)| predicted.of(by, *run).is_none()));
    }
}
