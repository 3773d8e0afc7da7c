//! One effect more in the contact.

use super::{EASED, EVIDENCE, Search, Tried};
use crate::effects::ALL;
use crate::search::Explained;
use crate::study::merge;
use crate::{ExplainError, Unknown};
use frettrace_forward::accelerations::{Quantity, Setting};
use frettrace_friction::effects::Hook;

/// χ² per residual on the recovered contacts below which a law is one that the contact may have.
const FITS: f64 = 4.0;

impl Search<'_> {
    /// The same model from the law that the contacts recovered with it show, where that ends nearer: the fit of the whole rig may
    /// have come to rest in another valley, and an effect may not be named for that.
    pub(super) fn restarted(&self, current: &Explained) -> Option<Explained> {
        let unknowns = merge(&self.study.case.unknowns(), &current.added);
        let (law, _) = Unknown::parted(&unknowns);
        let mut setting = current.fitted.setting.clone();
        if !self.closed(&setting) {
            return None;
        }
        let recovered = self.study.recovered(&setting).ok()?;
        let mut base = self.study.contact_base(&recovered, &setting, &law)?;
        if current.effects.is_empty() && base.reduced < FITS {
            // Every effect would stand in for what the declared law does with other values.
            base = self.study.contact_base_from_all_about(&recovered, &setting, &law, base)?;
        }
        if base.reduced >= FITS {
            return None;
        }
        setting.law = base.law;
        let named = (current.effects.clone(), current.added.clone());
        let mut found = self.study.whole(setting, &unknowns, named, 15).ok()?;
        found.sensors.clone_from(&current.sensors);
        found.counts.clone_from(&current.counts);
        (found.criterion + EVIDENCE < current.criterion).then_some(found)
    }

    fn contact_round(&mut self, current: &Explained) -> Result<Option<Explained>, ExplainError> {
        let unknowns = merge(&self.study.case.unknowns(), &current.added);
        let (law, _) = Unknown::parted(&unknowns);
        let mut setting = current.fitted.setting.clone();
        let recovered = self.study.recovered(&setting)?;
        // A fit of the whole rig that lacks an effect may have driven the law away from what the contact shows.
        let other = self.recovered_law.filter(|_| current.effects.is_empty());
        let base = [Some(setting.law), other]
            .into_iter()
            .flatten()
            .filter_map(|start| {
                self.study.contact_base(&recovered, &Setting { law: start, ..setting.clone() }, &law)
            })
            .min_by(|a, b| a.criterion.total_cmp(&b.criterion));
        let plain = base.as_ref().map_or(f64::INFINITY, |b| b.criterion);
        if let Some(base) = &base {
            setting.law = base.law;
        }
        let reduced = base.as_ref().map_or(f64::INFINITY, |base| base.reduced);
        let taken = (&current.effects[..], reduced);
        let candidates = self.study.contact_candidates(&recovered, &setting, &law, taken);
        self.tried.extend(candidates.iter().map(|c| Tried {
            id: ALL[c.effect].id(),
            error: f64::NAN,
            evidence: plain - c.criterion,
        }));
        let found = self.study.contact_round(current, &candidates);
        Ok(self.take_best(current, found))
    }

    /// The declared model with the compliance of the contact that is declared, where a large one was fitted. The balance does not
    /// see it, and it eases a law that lacks an effect: what is recovered with it hides what the law lacks.
    fn stiffened(&self, current: &Explained) -> Option<Explained> {
        let mut stiff = current.clone();
        let setting = &mut stiff.fitted.setting;
        let compliance = |of: &Setting| of.get(Quantity::ContactCompliance).unwrap_or_default();
        let declared = compliance(&self.study.case.setting(setting.law));
        let preload = self.study.model.runs.iter().map(|run| run.preload).fold(0.0, f64::max);
        let own = setting.law.get(Hook::Sigma0).map_or(0.0, |sigma0| sigma0 * preload);
        let eased = (compliance(setting) - declared).abs() * own > EASED;
        setting.set(Quantity::ContactCompliance, declared);
        (eased && current.effects.is_empty()).then_some(stiff)
    }

    /// A round over the contact, fitted to its end; another one on contacts recovered with the declared compliance, where that
    /// leaves something.
    pub(super) fn contact(&mut self, current: &Explained) -> Result<Option<Explained>, ExplainError> {
        let found = self.contact_round(current)?.map(|found| self.further(found, current.excess()));
        let found = found.map(|found| self.shaped(found, current.excess()));
        if found.as_ref().is_some_and(Explained::complete) {
            return Ok(found);
        }
        let Some(stiff) = self.stiffened(current) else { return Ok(found) };
        let rivals = std::mem::take(&mut self.rivals);
        let other = self.contact_round(&stiff)?.map(|found| self.further(found, stiff.excess()));
        let least = found.as_ref().map_or(f64::INFINITY, |found| found.criterion);
        if other.as_ref().is_some_and(|other| other.criterion < least) {
            return Ok(other);
        }
        self.rivals = rivals;
        Ok(found)
    }
}
