//! The declared law on recovered contacts: from its own values, and from others where these end poorly.

use super::{ALL_STEPS, BEGIN, ContactCandidate};
use crate::contact_fit::Contacts;
use crate::effects::ContactForm;
use crate::law_starts::{scattered, starts};
use crate::{ExplainError, Study, Unknown};
use frettrace_forward::accelerations::{Quantity, Setting};
use frettrace_friction::effects::{Hook, ModifiedLaw};
use rayon::prelude::*;

/// Rises of the static friction over the sliding one, as shares of it, that are tried where the contacts do not bound it.
const RISES: [f64; 3] = [0.15, 0.5, 1.5];
/// Other starts of the declared law that get all.
const ENDED: usize = 2;
/// Values from which a law is tried from all about.
const MANY_VALUES: usize = 6;

impl Study<'_> {
    /// The law of a setting on the recovered contacts.
    pub(crate) fn contact_base(
        &self,
        recovered: &Contacts,
        setting: &Setting,
        law_unknowns: &[Unknown],
    ) -> Option<ContactCandidate> {
        self.contact_base_from(recovered, setting, law_unknowns, &[setting.law])
    }

    /// The same from several values of the law.
    pub(crate) fn contact_base_from(
        &self,
        recovered: &Contacts,
        setting: &Setting,
        law_unknowns: &[Unknown],
        laws: &[ModifiedLaw<f64>],
    ) -> Option<ContactCandidate> {
        let plain = ContactForm::new(Vec::new());
        let from = |law: &ModifiedLaw<f64>| {
            let setting = Setting { law: *law, ..setting.clone() };
            self.contact_candidate(recovered, &setting, law_unknowns, (usize::MAX, &plain), 20)
        };
        let first = laws.par_iter().filter_map(from).min_by(ContactCandidate::by_criterion)?;
        // Where a rigid contact's force jumps is known to a part of a sample only: χ² does not tell a poor end there.
        let few = law_unknowns.len() < 3;
        if first.meets() && (few || !setting.rigid) {
            return Some(first);
        }
        // A law of many values has several minima, and what a fit of the whole rig that lacks an effect made of one with few may be in none:
        // other starts, where the first end is poor, and the best of them goes on. The contacts tell these, whatever law it was.
        let others = starts(&setting.law, self.fastest(recovered), (recovered, setting.rigid));
        self.better_end(recovered, setting, law_unknowns, (others, first))
    }

    /// The law of a setting on the recovered contacts, from starts all about where that leaves a law of many values poor: what the
    /// declared law comes to decides whether anything is missing.
    pub(crate) fn contact_base_from_many(
        &self,
        recovered: &Contacts,
        setting: &Setting,
        law_unknowns: &[Unknown],
    ) -> Option<ContactCandidate> {
        let first = self.contact_base(recovered, setting, law_unknowns)?;
        if first.meets() {
            return Some(first);
        }
        self.contact_base_from_all_about(recovered, setting, law_unknowns, first)
    }

    /// The law of a setting on the recovered contacts from starts all about, or `first` where none leads further or the law has few
    /// values: a valley may pass there that the whole model tells from the right one.
    pub(crate) fn contact_base_from_all_about(
        &self,
        recovered: &Contacts,
        setting: &Setting,
        law_unknowns: &[Unknown],
        first: ContactCandidate,
    ) -> Option<ContactCandidate> {
        if setting.rigid || law_unknowns.len() < MANY_VALUES {
            return Some(first);
        }
        let fastest = self.fastest(recovered);
        let centres = starts(&setting.law, fastest, (recovered, setting.rigid));
        let sizes = (self.scales.preload, fastest);
        let others = centres.first().map_or_else(Vec::new, |law| scattered(law, law_unknowns, sizes));
        self.better_end(recovered, setting, law_unknowns, (others, first))
    }

    /// Largest slip velocity (m/s), that of the declared structure where none was recovered.
    pub(super) fn fastest(&self, recovered: &Contacts) -> f64 {
        recovered.fastest().unwrap_or(self.scales.velocity)
    }

    /// Whether the law of a setting misses recovered contacts even where their lines count by their size: a search from it begins there.
    pub(crate) fn is_far(&self, recovered: &Contacts, setting: &Setting, law_unknowns: &[Unknown]) -> bool {
        // Where a rigid contact sticks it takes the recovered force: its χ² is no valley.
        if setting.rigid {
            return false;
        }
        let plain = ContactForm::new(Vec::new());
        let softened = recovered.steady().softened();
        self.contact_steps(&softened, setting, law_unknowns, (usize::MAX, &plain), (None, 0))
            .is_none_or(|left| left.reduced > 1.0)
    }

    /// Where the law of a setting ends on the recovered contacts from the best of some starts, or `first` where that is better.
    fn better_end(
        &self,
        recovered: &Contacts,
        setting: &Setting,
        law_unknowns: &[Unknown],
        (starts, first): (Vec<ModifiedLaw<f64>>, ContactCandidate),
    ) -> Option<ContactCandidate> {
        let plain = ContactForm::new(Vec::new());
        let form = (usize::MAX, &plain);
        let quick = recovered.quick();
        let begin = |law| {
            let setting = Setting { law, ..setting.clone() };
            self.contact_steps(&quick, &setting, law_unknowns, form, (None, BEGIN))
        };
        let end = |begun: &ContactCandidate| {
            let recovered = recovered.around(&begun.law, begun.modulation);
            self.contact_steps(&recovered, setting, law_unknowns, form, (Some(begun), ALL_STEPS))
        };
        let mut begun: Vec<ContactCandidate> = starts.into_par_iter().filter_map(begin).collect();
        begun.sort_by(ContactCandidate::by_criterion);
        begun.truncate(ENDED);
        let ended: Vec<ContactCandidate> = begun.par_iter().filter_map(end).collect();
        ended.into_iter().chain([first]).min_by(ContactCandidate::by_criterion)
    }

    /// The law of a setting, fitted already, on the recovered contacts again for each of some static frictions below its own: a
    /// contact without a presliding range shows its friction where it slides, and what it would hold at rest only as far as its
    /// motion is resolved there. Where it is not, the fit may hold any force, and the whole model has no answer with it.
    pub(crate) fn breakaways(
        &self,
        recovered: &Contacts,
        setting: &Setting,
        law_unknowns: &[Unknown],
    ) -> Vec<ModifiedLaw<f64>> {
        let others: Vec<Unknown> = law_unknowns
            .iter()
            .filter(|u| u.quantity != Quantity::Law(Hook::StribeckRise))
            .cloned()
            .collect();
        let plain = ContactForm::new(Vec::new());
        let [rise, sliding] =
            [Hook::StribeckRise, Hook::MuKinetic].map(|h| setting.law.get(h).unwrap_or_default());
        let at = |share: f64| {
            let mut setting = setting.clone();
            setting.law.set(Hook::StribeckRise, share * sliding);
            self.contact_candidate(recovered, &setting, &others, (usize::MAX, &plain), ALL_STEPS)
        };
        let lower = RISES.into_par_iter().filter(|share| share * sliding < rise);
        lower.filter_map(at).map(|found| found.law).collect()
    }

    /// The law of a setting fitted to the recovered contacts, from starts all about where its own leads to a poor end; one without a
    /// presliding range also for each of some static frictions below what it comes to.
    ///
    /// # Errors
    /// [`ExplainError::Model`] where the structure cannot be built.
    pub fn laws_on_contacts(&self, setting: &Setting) -> Result<Vec<ModifiedLaw<f64>>, ExplainError> {
        let (unknowns, _) = Unknown::parted(&self.case.unknowns());
        let recovered = self.recovered(setting)?;
        let Some(base) = self.contact_base_from_many(&recovered, setting, &unknowns) else {
            return Ok(Vec::new());
        };
        let mut laws = vec![base.law];
        if setting.rigid {
            let fitted = Setting { law: base.law, ..setting.clone() };
            laws.extend(self.breakaways(&recovered, &fitted, &unknowns));
        }
        Ok(laws)
    }
}
