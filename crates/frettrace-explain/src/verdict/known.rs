//! What was asked already: a search that is made again without a name asks what lies outside the contact from the same declared model, and of the contact
//! on the same recovered contacts, as one that looks for a pair does.

use super::contact_rounds::Recovered;
use crate::contact_search::ContactCandidate;
use crate::kept::Kept;
use crate::search::{Asked, Explained};
use crate::{ExplainError, Study, Unknown};
use frettrace_forward::accelerations::{OnGrids, Setting};
use frettrace_friction::effects::ModifiedLaw;
use std::sync::Arc;

/// What the answer to an effect is told by: the grids of the study, which belong to its split too, the model that it is asked beside, and where it begins.
#[derive(PartialEq)]
struct By {
    grids: OnGrids,
    beside: (Setting, Vec<usize>, Vec<Unknown>),
    begins: (usize, Setting, Vec<Unknown>),
}

/// What recovered contacts are told by: the model that they were recovered with, and another law that its own is compared with there.
#[derive(PartialEq)]
struct With {
    grids: OnGrids,
    setting: Setting,
    effects: Vec<usize>,
    added: Vec<Unknown>,
    other: Option<ModifiedLaw<f64>>,
}

/// What the effects of the contact on recovered contacts are told by: those themselves, which are of one model and beside what it has, whether the search began on
/// softened lines, and the names that are left out.
struct On {
    recovered: Arc<Recovered>,
    softened: bool,
    without: Vec<String>,
}

impl PartialEq for On {
    fn eq(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.recovered, &other.recovered)
            && self.softened == other.softened
            && self.without == other.without
    }
}

/// What a model that no finer grid corrects is told by: the grids, what counts as noise on the lines, which a rigid contact's grid adds to, and the model.
#[derive(PartialEq)]
struct Uncorrected {
    grids: OnGrids,
    deviations: Vec<Vec<Vec<f64>>>,
    setting: Setting,
    effects: Vec<usize>,
}

impl Uncorrected {
    fn new(study: &Study<'_>, model: &Explained) -> Self {
        Self {
            grids: study.model.on_grids(),
            deviations: study.model.runs.iter().map(|run| run.deviation.clone()).collect(),
            setting: model.fitted.setting.clone(),
            effects: model.effects.clone(),
        }
    }
}

/// Known answers. Copies share them.
#[derive(Clone, Default)]
pub(super) struct Known {
    models: Kept<By, Result<Explained, ExplainError>>,
    recovered: Kept<With, Arc<Recovered>>,
    candidates: Kept<On, Vec<ContactCandidate>>,
    uncorrected: Kept<Uncorrected, ()>,
}

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
        if let Some(answer) = self.models.of(&by) {
            return Asked { effect, answer };
        }
        let answer = ask();
        let mut kept = answer.clone();
        if let Ok(model) = &mut kept {
            model.fitted.memory = model.fitted.memory.without_factors();
        }
        self.models.keep(by, kept);
        Asked { effect, answer }
    }

    /// A model corrected to a finer grid; `None` without asking where that is known to lead nowhere.
    pub(super) fn corrected<T>(
        &self,
        study: &Study<'_>,
        model: &Explained,
        correct: impl FnOnce() -> Option<T>,
    ) -> Option<T> {
        let by = Uncorrected::new(study, model);
        if self.uncorrected.of(&by).is_some() {
            return None;
        }
        let found = correct();
        if found.is_none() {
            self.uncorrected.keep(by, ());
        }
        found
    }

    /// The contacts that are recovered with a model, recovered if they are not known. Those of a rigid contact count by deviations that its grids doubt.
    pub(super) fn recovered(
        &self,
        study: &Study<'_>,
        (model, other): (&Explained, Option<ModifiedLaw<f64>>),
        recover: impl FnOnce() -> Result<Recovered, ExplainError>,
    ) -> Result<Arc<Recovered>, ExplainError> {
        if model.fitted.setting.rigid {
            return recover().map(Arc::new);
        }
        let by = With {
            grids: study.model.on_grids(),
            setting: model.fitted.setting.clone(),
            effects: model.effects.clone(),
            added: model.added.clone(),
            other,
        };
        if let Some(known) = self.recovered.of(&by) {
            return Ok(known);
        }
        let found = Arc::new(recover()?);
        self.recovered.keep(by, found.clone());
        Ok(found)
    }

    /// The effects of the contact on recovered contacts, asked if they are not known.
    pub(super) fn candidates(
        &self,
        recovered: &Arc<Recovered>,
        (softened, without): (bool, &[String]),
        ask: impl FnOnce() -> Vec<ContactCandidate>,
    ) -> Vec<ContactCandidate> {
        let by = On { recovered: recovered.clone(), softened, without: without.to_vec() };
        if let Some(known) = self.candidates.of(&by) {
            return known;
        }
        let found = ask();
        self.candidates.keep(by, found.clone());
        found
    }
}
