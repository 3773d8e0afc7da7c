//! Whole models that were asked already: a search that is made again without a name asks what lies outside the contact from the same declared
//! model.

use crate::kept::Kept;
use crate::search::{Asked, Explained};
use crate::{ExplainError, Study, Unknown};
use frettrace_forward::accelerations::{OnGrids, Setting};

/// What the answer to an effect is told by: the grids of the study, which belong to its split too, the model that it is asked beside, and where it begins.
#[derive(PartialEq)]
struct By {
    grids: OnGrids,
    beside: (Setting, Vec<usize>, Vec<Unknown>),
    begins: (usize, Setting, Vec<Unknown>),
}

/// Known answers. Copies share them.
#[derive(Clone, Default)]
pub(super) struct Known(Kept<By, Result<Explained, ExplainError>>);

impl Known {
    /// The answer to an effect that is asked beside a model from a setting with some unknowns, asked if it is not known. A rigid contact's deviations are
    /// doubted by its grids, and others than these tell its answers.
    pub(super) fn asked(
        &self,
        study: &Study<'_>,
        beside: &Explained,
        (effect, setting, unknowns): (usize, &Setting, &[Unknown]),
        ask: impl FnOnce() -> Result<Explained, ExplainError>,
    ) -> Asked {
        if setting.rigid {
            return Asked { effect, answer: ask() };
        }
        let by = By {
            grids: study.model.on_grids(),
            beside: (beside.fitted.setting.clone(), beside.effects.clone(), beside.added.clone()),
            begins: (effect, setting.clone(), unknowns.to_vec()),
        };
        if let Some(answer) = self.0.of(&by) {
            return Asked { effect, answer };
        }
        let answer = ask();
        let mut kept = answer.clone();
        if let Ok(model) = &mut kept {
            model.fitted.memory = model.fitted.memory.without_factors();
        }
        self.0.keep(by, kept);
        Asked { effect, answer }
    }
}
