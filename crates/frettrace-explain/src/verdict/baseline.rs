//! The declared model: what everything is measured against.

use super::{BALANCE_CALIBRATED, BALANCE_WIDE, Search};
use crate::search::{Explained, NEAR};
use crate::support::SupportForce;
use crate::{ExplainError, Unknown};
use frettrace_forward::accelerations::Setting;
use frettrace_friction::effects::{Hook, ModifiedLaw};
use rayon::prelude::*;
use std::sync::Arc;

/// Shares of a contact's stiffness that a fit begins from, until one has a steady answer.
const SOFTER: [f64; 4] = [1.0, 0.2, 0.04, 0.008];

/// Times that the force of a second support is told anew with the law, until the model closes.
const RENEWALS: usize = 2;

impl Search<'_> {
    /// The declared model: the law on the recovered contacts, then the whole.
    pub(super) fn baseline(&mut self, mut setting: Setting) -> Result<Explained, ExplainError> {
        let unknowns = self.study.case.unknowns();
        let (law, _) = Unknown::parted(&unknowns);
        if self.study.case.loosely_known() || self.study.balance_reduced(&setting).0 > BALANCE_CALIBRATED {
            // Modes that are known loosely, beside the noise, are calibrated on the balance before any force is recovered.
            let calibrated = self.study.balance_base(&setting, &[]);
            if calibrated.reduced.is_finite() {
                setting = calibrated.setting;
            }
        }
        let recovered = self.study.recovered(&setting)?;
        if let Some(base) = self.study.contact_base_from_many(&recovered, &setting, &law) {
            // The structure that goes with a law which misses the contacts may be any.
            setting =
                if base.meets() { base.placed_in(&setting) } else { Setting { law: base.law, ..setting } };
            self.on_contacts = Some(base);
        }
        // No law closes a balance that is wide open: a few steps show how far the declared model is.
        let wide = self.study.balance_reduced(&setting).0 > BALANCE_WIDE;
        let steps = if wide { 4 } else { 10 };
        let begun = |law: ModifiedLaw<f64>| {
            let setting = Setting { law, ..setting.clone() };
            self.study.whole(setting, &unknowns, (Vec::new(), Vec::new()), steps).ok()
        };
        let found = if setting.holds_rigidly() {
            let slid = begun(setting.law);
            let mut others = Vec::new();
            let follows = |model: &Explained| {
                model.complete() || model.ratio <= NEAR && self.study.within_doubt(model) == Some(true)
            };
            if !slid.as_ref().is_some_and(follows) {
                others = self.study.breakaways(&recovered, &setting, &law);
                others.push(self.held(&setting));
            }
            let others: Vec<Explained> = others.into_par_iter().filter_map(begun).collect();
            slid.into_iter().chain(others).min_by(Explained::by_criterion)
        } else {
            // Where a stiff contact has no steady answer from a cold start, a softer one leads to it.
            SOFTER.into_iter().find_map(|share| {
                let mut law = setting.law;
                law.set(Hook::Sigma0, share * law.get(Hook::Sigma0).unwrap_or(1.0));
                begun(law)
            })
        };
        // A declared model without a steady answer is still a model: it explains nothing.
        found.map_or_else(|| self.study.blank(setting.clone(), &unknowns), Ok)
    }

    /// The declared model with the force of a declared second support free in every line. Recovered without a law it is known worse
    /// than with the right one: where that closes the model it is renewed, and otherwise stays, so that it does not bend to what
    /// the model lacks.
    pub(super) fn beside_support(&mut self, model: Explained) -> Explained {
        let Some(first) = self.freed(&model) else { return model };
        let (study, mut latest) = (self.study.clone(), first.clone());
        for _ in 0..RENEWALS {
            if latest.complete() {
                return latest;
            }
            let Some(support) = self.study.support.clone() else { break };
            support.renew(&mut self.study, &latest.fitted);
            let Some(renewed) = self.freed(&latest) else { break };
            latest = renewed;
        }
        if latest.complete() {
            return latest;
        }
        self.study = study;
        first
    }

    /// A model fitted with the support force free around where it predicts; `None` where no second support is declared or the model
    /// has no answer.
    fn freed(&mut self, model: &Explained) -> Option<Explained> {
        let support = SupportForce::new(&self.study, &model.fitted, &self.study.all_runs()).ok()??;
        self.study.support = Some(Arc::new(support));
        self.study.polished(model).ok()
    }

    /// The law with so much friction that no run slides: a rigid contact that held all the time tells nothing of its law but
    /// that, and a law fitted to the noise of its slip slides.
    fn held(&self, setting: &Setting) -> ModifiedLaw<f64> {
        let mut law = setting.law;
        let Ok(balances) = self.study.model.balance(setting, &self.study.training) else { return law };
        let loads = balances.iter().zip(&self.study.training).map(|(balance, &run)| {
            // No less than the largest force: the sum of its lines.
            let largest: f64 = balance.force.iter().map(|line| line.norm()).sum();
            largest / self.study.model.runs[run].preload
        });
        law.set(Hook::MuKinetic, 2.0 * loads.fold(0.0, f64::max));
        law
    }
}
