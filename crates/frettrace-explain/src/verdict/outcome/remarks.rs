//! What a reader must know.

use super::super::finer::RIGID_ACCURACY;
use super::super::{EVIDENCE, Search};
use super::Tried;
use crate::effects::ALL;
use crate::search::Explained;
use crate::study::as_declared;
use frettrace_forward::accelerations::Quantity;
use frettrace_friction::effects::Hook;

impl Search<'_> {
    /// What a reader must know: of the runs, of the model's contact, and of how it was judged.
    pub(super) fn remark(&mut self, baseline: &Explained, model: &Explained) {
        let remarks = [
            self.of_untrusted_lines(),
            self.of_a_shaken_beam(),
            self.of_unsettled_runs(),
            self.of_the_structure_of_aperiodic_runs(model),
            self.of_aperiodic_runs(baseline, model),
            of_rests(model),
            of_unsettled_contacts(model),
            self.of_another_formula(baseline, model),
            self.of_a_rigid_balance(baseline),
            of_given(baseline, model),
            self.of_its_grid(),
        ];
        self.notes.extend(remarks.into_iter().flatten());
        self.notes
            .push("mean friction, preload, mean position and drift cannot be seen by accelerometers".into());
        self.remark_refused();
    }

    fn of_untrusted_lines(&self) -> Option<String> {
        let untrusted = self.study.case.records.iter().map(|r| r.untrusted).fold(0.0, f64::max);
        (untrusted > 0.0).then(|| {
            format!(
                "lines above 0.8 of half the sampling rate, where anti-alias filters bend every channel, and above the 160th of the excitation are in no error: at most {:.1e} of a run's amplitude",
                untrusted.sqrt()
            )
        })
    }

    fn of_a_shaken_beam(&self) -> Option<String> {
        let frequency = self.study.case.shaken?;
        Some(format!(
            "the beam moves at {frequency} Hz in every run, which no declared force makes: another machine shakes it; that motion is taken out of the runs"
        ))
    }

    fn of_unsettled_runs(&self) -> Option<String> {
        let unsettled = self.study.case.records.iter().map(|r| r.unsettled).filter(|u| *u > 0.0);
        let (count, most) =
            unsettled.fold((0, 0.0), |(count, most): (usize, f64), u| (count + 1, most.max(u)));
        (count > 0).then(|| {
            format!(
                "{count} runs have not quite settled: what does not repeat in them, up to {most:.2} times the power of the noise, counts as noise there"
            )
        })
    }

    fn aperiodic_runs(&self) -> usize {
        self.study.case.records.iter().filter(|r| !r.periodic).count()
    }

    fn of_the_structure_of_aperiodic_runs(&self, model: &Explained) -> Option<String> {
        (self.aperiodic_runs() > 0 && !as_declared(&model.fitted.setting)).then(|| {
            "forces of runs that are not periodic were recovered with what is declared: the model has another structure, excitation or sensor, and its law is not judged by them".into()
        })
    }

    fn of_aperiodic_runs(&self, baseline: &Explained, model: &Explained) -> Option<String> {
        let count = self.aperiodic_runs();
        let entered = self.study.series.len();
        let missed = |of: &Explained| format!("{:.1} %", 100.0 * self.series_error(of));
        let misses = || match as_declared(&model.fitted.setting) {
            true => format!("the law misses by {} before and {} after", missed(baseline), missed(model)),
            false => format!("the declared law misses by {}", missed(baseline)),
        };
        (count > 0).then(|| {
            format!(
                "{count} runs are not periodic: no waveform is predicted for them; {entered} of them entered through the recovered force, which {}",
                misses()
            )
        })
    }

    fn of_another_formula(&self, baseline: &Explained, model: &Explained) -> Option<String> {
        self.other_formula.then(|| {
            format!(
                "the named effect leaves {:.2} times the noise in the worst training run: its formula here is another one, but it takes {:.2} % of what was missing and every rival leaves ten times as much",
                model.worst,
                100.0 * (1.0 - model.excess() / baseline.excess())
            )
        })
    }

    fn of_a_rigid_balance(&self, baseline: &Explained) -> Option<String> {
        let left = baseline.ratio;
        self.within_method.then(|| {
            if self.unresolved {
                return format!(
                    "no phase grid that the balance of a rigid contact gets resolves any run, nor does the sampling rate: what the declared model leaves, {left:.2} times the noise, is no more than its own may be wrong by, and no effect is looked for below it; quieter sensors would not tell more, a lower excitation frequency or a contact that yields would"
                );
            }
            format!(
                "what the declared model leaves, {left:.2} times the noise, is within the accuracy of a rigid contact's balance, {RIGID_ACCURACY:.0e} of the amplitude or what its phase grid may be wrong by: no effect is looked for below it"
            )
        })
    }

    fn of_its_grid(&self) -> Option<String> {
        (self.refined > 0)
            .then(|| format!("the model was fitted on a phase grid {} times as fine", 1 << self.refined))
    }

    /// Effects with evidence for them that could not be judged: the whole model has no answer with them.
    fn remark_refused(&mut self) {
        let mut seen = Vec::new();
        for (effect, reason) in &self.refused {
            let id = ALL[*effect].id();
            let unjudged = |t: &Tried| t.id == id && t.error.is_nan() && t.evidence > EVIDENCE;
            if !seen.contains(&id) && self.tried.iter().any(unjudged) {
                seen.push(id);
                self.notes.push(format!("{id} could not be judged: with it, {reason}"));
            }
        }
    }
}

/// Where the runs of a model with a stop rest.
fn of_rests(model: &Explained) -> Option<String> {
    let (port, rests) = &model.fitted.setting.rests;
    let stop = model.fitted.setting.ports.get(*port).filter(|_| !rests.is_empty())?;
    let low = rests.iter().copied().fold(f64::INFINITY, f64::min);
    let high = rests.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    Some(format!(
        "the mean of the friction, which no accelerometer sees, holds the beam off by {low:.1e} to {high:.1e} m at the stop: found run by run from the force recovered there; the gap is {:.1e} m if friction has no mean in the run that tells most",
        stop.coefficients[1]
    ))
}

fn of_unsettled_contacts(model: &Explained) -> Option<String> {
    let count = model.fitted.setting.deflections.iter().flatten().count();
    (count > 0).then(|| {
        format!(
            "contacts that stick or creep and had not come to their steady state, by the runs they are in: {count}; the deflection with which its period begins is a value of each, told by that run alone, in runs held out too"
        )
    })
}

/// Values of the law that the forms of a model's effects brought with them and no fit moved: which formula it was.
fn of_given(baseline: &Explained, model: &Explained) -> Option<String> {
    let [declared, law] = [baseline, model].map(|m| &m.fitted.setting.law);
    let fitted = |hook| model.fitted.unknowns.iter().any(|u| u.quantity == Quantity::Law(hook));
    let brought = Hook::ALL.into_iter().filter(|&hook| declared.get(hook).is_none() && !fitted(hook));
    let told = |hook: Hook| {
        let value = law.get(hook).filter(|&value| value != 0.0)?;
        let (name, unit) = hook.name_and_unit();
        Some(if unit == "1" { format!("{name} {value}") } else { format!("{name} {value:.4e} {unit}") })
    };
    let given: Vec<String> = brought.filter_map(told).collect();
    (!given.is_empty())
        .then(|| format!("the form that did best sets, and does not fit, {}", given.join(", ")))
}
