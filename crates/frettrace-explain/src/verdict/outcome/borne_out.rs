//! Whether runs that nothing was fitted to bear out what is named.

use super::super::rules::{helps, is_as_near, is_followed, takes_its_own};
use super::super::{BORNE_OUT, FORETOLD, HELD_OUT, Search};
use crate::left::LeftLines;
use crate::search::{Explained, excess};

impl Search<'_> {
    /// Whether runs held out bear out the names of a model, which are asked on a finer grid where they do not, or where what is left speaks against a
    /// name, and the lines hold more than their noise: values that were bent to what a grid cuts short follow the fitted runs alone.
    pub(super) fn borne_out_on_its_grid(&mut self, baseline: &Explained, model: &mut Explained) -> bool {
        let (said, grid) = (self.notes.len(), self.refined);
        let found = self.borne_out(baseline, model);
        let stands = found && self.takes_all(baseline, model) && self.tells_both(baseline, model);
        if stands || self.claimed(model) == 0 || !model.complete() {
            return found;
        }
        *model = self.sharpened(model.clone(), LeftLines::is_noise, |_, sharper| sharper.complete());
        if self.refined == grid {
            return found;
        }
        self.notes.truncate(said);
        self.borne_out(baseline, model)
    }

    /// Whether runs that nothing was fitted to bear out what is named: by its standard error, and by a real share of what was
    /// missing in them.
    fn borne_out(&mut self, baseline: &Explained, model: &Explained) -> bool {
        let held_out = &self.study.held_out;
        if held_out.is_empty() {
            return true;
        }
        if self.deviates {
            self.notes.push(
                "no error shows what is named: a natural frequency lies farther from the declared one than its deviation lets it be by chance".into(),
            );
            return self.study.error(&model.fitted, held_out).ratio() <= BORNE_OUT;
        }
        if self.claimed(model) == 0 {
            let error = self.study.error(&model.fitted, held_out);
            if self.of_one_law {
                self.notes.push(of_one(error.ratio()));
                return true;
            }
            let by_curve = model.left().is_noise() && self.is_trace_of_a_curve(1, excess(error.ratio()));
            return error.ratio() <= BORNE_OUT
                || by_curve
                || self.within_method && self.by_method(model, held_out);
        }
        let ratio = |of: &Explained| self.study.error(&of.fitted, held_out).ratio();
        let unbent = self.unbent_baseline(baseline).filter(|unbent| ratio(unbent) < ratio(baseline));
        // The error of all samples may be the noise of a weak run: what the lines hold must be so, too, or the balance's.
        let foretells = |unbent: &Explained| ratio(unbent) <= FORETOLD && self.by_method(unbent, held_out);
        if unbent.as_ref().is_some_and(foretells) {
            self.notes.push(
                "the declared law as the recovered contacts show it foretells the runs held out within the noise: they bear out no effect".into(),
            );
            return false;
        }
        let baseline = unbent.as_ref().unwrap_or(baseline);
        let found = self.study.improvement(&baseline.fitted, &model.fitted, held_out);
        self.notes
            .push(format!("held-out runs improve by {found:.1} standard errors; a claim needs {HELD_OUT}"));
        let [before, after] = [baseline, model].map(ratio);
        // Where the formula is another one, these runs must be as near as those that were fitted.
        if !helps(found, [before, after]) {
            return false;
        }
        match self.other_formula {
            true => is_as_near(before, after),
            false => {
                (is_followed(before, after) || self.is_of_one_model(model, after))
                    && self.needs_each(model, after)
            }
        }
    }

    /// Whether each of two effects takes what the runs held out miss without it, by the error over the noise that both leave there. That the stronger one
    /// took nearly all of what was missing says nothing of the other.
    fn needs_each(&self, model: &Explained, after: f64) -> bool {
        let two = model.effects.len() > 1 && !self.lifts_off;
        // What cannot be taken out, or leaves a run without an answer, is needed.
        let taken = |place: usize| {
            let Some(without) = self.study.without(model, place) else { return true };
            let before = self.study.error(&without.fitted, &self.study.held_out).ratio();
            takes_its_own(before, after)
        };
        !two || after <= FORETOLD || (0..model.effects.len()).all(taken)
    }

    /// The declared model of a rigid contact as its recovered contacts and the balance show it, without a fit: where the balance of one fitted run
    /// has no answer, or another one, than was measured, a fit bends the model, and any effect that mends this improves runs that the
    /// unbent model foretells.
    fn unbent_baseline(&self, baseline: &Explained) -> Option<Explained> {
        if !baseline.fitted.setting.rigid {
            return None;
        }
        let mut setting = self.declared_start(baseline);
        setting.law = self.law_on_contacts().unwrap_or(setting.law);
        self.study.blank(setting, &[]).ok()
    }

    /// Whether one set of values of a model, by which held-out runs are helped but not followed, follows all runs, and leaves no more beside
    /// the noise of their lines than that is: what was missed is what the fitted runs do not tell of the values. Two effects have enough values to
    /// follow what is neither.
    fn is_of_one_model(&mut self, model: &Explained, after: f64) -> bool {
        let joint = || self.study.jointly(model);
        let single = self.claimed(model) == 1;
        let follows = single && model.complete() && joint().is_some_and(|joint| joint.left().is_near_noise());
        if follows {
            self.notes.push(of_one(after));
        }
        follows
    }
}

/// What is said of runs held out that are missed by so many times the noise, where one set of values follows all runs.
fn of_one(missed: f64) -> String {
    format!(
        "the fitted runs leave the values too uncertain to foretell those held out ({missed:.2} times the noise): one set of values follows all of them within the noise"
    )
}
