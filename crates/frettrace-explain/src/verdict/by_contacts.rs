//! Runs of a rigid contact that no balance answers with the law that their contacts show.
//!
//! A friction that falls with speed more steeply than the structure resists, `−dF/dv > |Z|`, lets the contact jump when it begins to slide, along
//! the line `F + Z v` of what acts on it. A balance of finitely many lines has to pass through the curve between, and may have no answer there; a fit
//! comes to rest at the edge of where it has one, with a flatter curve, and what that leaves is nothing that the law lacks. No waveform is predicted
//! of such a run, as of one that is not periodic: the law is judged by the force and the motion recovered of it.

use super::{BALANCE_CALIBRATED, FORETOLD, Search};
use crate::search::{COMPLETE, Explained};
use frettrace_friction::effects::ModifiedLaw;

impl Search<'_> {
    /// The declared law on the contacts recovered with the declared structure.
    pub(super) fn law_on_contacts(&self) -> Option<ModifiedLaw<f64>> {
        self.on_contacts.as_ref().map(|shown| shown.law)
    }

    /// Runs in which no balance of the declared model answers with the law that the recovered contacts show, where that law meets these, some contact
    /// force closes the balance of the declared structure within the noise, and the fitted model leaves noise in all other runs, those held out
    /// among them; none where any of this fails.
    pub(super) fn told_by_contacts(&self, model: &Explained) -> Vec<usize> {
        let shown =
            self.on_contacts.as_ref().filter(|shown| model.fitted.setting.rigid && shown.reduced <= MET);
        let Some(shown) = shown else { return Vec::new() };
        // A fit at the edge of where it has an answer has bent the structure as well.
        let setting = shown.placed_in(&self.declared_start(model));
        if !self.closed(&setting) || self.study.balance_reduced(&setting).0 > BALANCE_CALIBRATED {
            return Vec::new();
        }
        let as_shown = self.study.blank(setting, &[]);
        let unanswered = as_shown.map_or_else(|_| Vec::new(), |one| self.study.unanswered(&one.fitted));
        let others = |runs: &[usize]| -> Vec<usize> {
            runs.iter().copied().filter(|run| !unanswered.contains(run)).collect()
        };
        let (fitted, held_out) = (others(&self.study.training), others(&self.study.held_out));
        let ratio = |runs: &[usize]| self.study.error(&model.fitted, runs).ratio();
        let follows = !fitted.is_empty()
            && ratio(&fitted) <= COMPLETE
            && self.study.left_in(&model.fitted, &fitted).is_noise();
        let foretells = held_out.is_empty() || ratio(&held_out) <= FORETOLD;
        if follows && foretells { unanswered } else { Vec::new() }
    }
}

/// χ² per residual on the recovered contacts up to which a law meets them: a tenth of the accuracy that is stated of a rigid contact's force, which
/// may jump a quarter of a sample late. Right laws of simulated rigs leave 1e-4 to 8e-3; a preload modulated by 3 %, an asymmetry of
/// 10 % and waves of 5 % along the path 1.5e-2 to 3.5e-2.
const MET: f64 = 0.01;
