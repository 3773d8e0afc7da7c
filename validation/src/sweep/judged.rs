//! What became of a set.

use super::Finished;
use super::apart::NotMade;
use super::kept::{Asked, asked};
use super::plan::{Planned, effect_id};
use frettrace::Progress;
use frettrace::explain::{ExplainOptions, explain};
use frettrace::results::{Explanation, Place, Verdict};
use frettrace::rig::Effect;
use frettrace_measurement::Recording;
use serde::{Deserialize, Serialize};
use std::path::Path;
use std::time::Instant;

/// One finished set: one line of the file of a sweep.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Judged {
    /// Name in the plan.
    pub name: String,
    /// Id of the true effect; `None` for a clean set.
    pub effect: Option<String>,
    /// Id of the second one, in a set with two.
    #[serde(default)]
    pub second: Option<String>,
    /// Whether its id was taken out of the list.
    pub left_out: bool,
    /// Error over noise floor of the model with true parameters and without an effect, that of two which is seen least.
    pub visible: f64,
    /// The verdict's word; `None` where the set failed.
    pub verdict: Option<Verdict>,
    /// Place named.
    pub place: Option<Place>,
    /// Ids named, each with those it cannot be told from.
    pub named: Vec<Vec<String>>,
    /// Distance between the named position and the true one over the beam's length.
    pub position_error: Option<f64>,
    /// Whether the right sensor is named.
    pub sensor_right: Option<bool>,
    /// Whether the interval of the effect's size holds the true one, where both are the same quantity.
    pub size_inside: Option<bool>,
    /// Error over noise floor before and after, held out where there are such runs.
    pub over_floor: [f64; 2],
    /// Why it failed.
    pub failure: Option<String>,
    /// Whether it could not be made: no rig settles, or not in time.
    #[serde(default)]
    pub unmade: bool,
    /// What `explain` took on one core (s).
    #[serde(default)]
    pub seconds: f64,
}

impl Finished for Judged {
    fn name(&self) -> &str {
        &self.name
    }
}

/// What the answer was worth.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Worth {
    /// The true effects and nothing else; nothing on a clean set; `unexplained` with the right place where the name is not in the list.
    Right,
    /// Right only through `indistinguishable_from`.
    Class,
    /// One of two effects, and nothing else.
    Half,
    /// `unexplained` where the name is in the list, or with another place.
    Unexplained,
    /// `nothing-missing` although something is.
    Missed,
    /// An effect that is not there.
    Wrong,
    /// No answer.
    Failed,
}

impl Judged {
    /// Whether the effect stands far enough out of the noise to count.
    #[must_use]
    pub fn counts(&self) -> bool {
        self.effect.is_none() || self.visible > 1.3
    }

    /// Whether the true effect has no name in the list.
    #[must_use]
    pub fn nameless(&self) -> bool {
        self.left_out || self.effect.as_ref().is_some_and(|id| id.starts_with("unlisted:"))
    }

    /// Worth of the answer.
    #[must_use]
    pub fn worth(&self) -> Worth {
        let Some(verdict) = self.verdict else { return Worth::Failed };
        let Some(effect) = &self.effect else {
            return match verdict {
                Verdict::NothingMissing => Worth::Right,
                _ if self.named.is_empty() => Worth::Unexplained,
                _ => Worth::Wrong,
            };
        };
        if verdict == Verdict::NothingMissing {
            return Worth::Missed;
        }
        if self.nameless() {
            return match (self.named.is_empty(), self.place == place(effect)) {
                (true, true) => Worth::Right,
                (true, false) => Worth::Unexplained,
                (false, _) => Worth::Wrong,
            };
        }
        let truth: Vec<&String> = std::iter::once(effect).chain(&self.second).collect();
        let held = |class: &Vec<String>| truth.iter().any(|id| class.contains(id));
        let first = |class: &Vec<String>| truth.iter().any(|id| class.first() == Some(id));
        let told = |id: &&&String| self.named.iter().any(|class| class.contains(id));
        let told = truth.iter().filter(told).count();
        match &self.named[..] {
            [] => Worth::Unexplained,
            named if !named.iter().all(held) || named.len() > told => Worth::Wrong,
            named if named.len() < truth.len() => Worth::Half,
            named if named.iter().all(first) => Worth::Right,
            _ => Worth::Class,
        }
    }
}

/// Where an effect lives, from its id or what stands in for one.
fn place(effect: &str) -> Option<Place> {
    let word = effect.trim_start_matches("unlisted:");
    Some(match word.split('.').next()? {
        "friction" | "contact" => Place::Contact,
        "structure" => Place::Structure,
        "excitation" => Place::Excitation,
        "measurement" => Place::Measurement,
        _ => return None,
    })
}

impl Judged {
    /// A set without an answer; that is one too.
    #[must_use]
    pub fn failed(planned: &Planned, error: &anyhow::Error) -> Self {
        let id = |k: usize| planned.formulas.get(k).map(|formula| effect_id(formula).to_owned());
        Self {
            name: planned.name.clone(),
            effect: id(0),
            second: id(1),
            left_out: planned.left_out,
            failure: Some(format!("{error:#}")),
            unmade: error.is::<NotMade>(),
            ..Self::default()
        }
    }
}

/// Makes a planned set, or takes it from the folder that keeps it, and asks what it lacks; `is_made` is called between the two.
#[must_use]
pub fn judge(planned: &Planned, folder: Option<&Path>, is_made: impl FnOnce()) -> Judged {
    let set = match asked(planned, folder) {
        Ok(set) => set,
        Err(error) => return Judged { unmade: true, ..Judged::failed(planned, &error) },
    };
    is_made();
    answered(planned, set).unwrap_or_else(|error| Judged::failed(planned, &error))
}

fn answered(planned: &Planned, Asked { measurement, known }: Asked) -> anyhow::Result<Judged> {
    let length = measurement.beam.length;
    let truth = known.effects.first();
    let id = |k: usize| known.effects.get(k).map(|effect| effect.id().to_owned());
    let (effect, second) = (id(0), id(1));
    let without = effect.iter().filter(|_| planned.left_out).cloned().collect();
    let options = ExplainOptions { without, ..ExplainOptions::default() };
    let recording = Recording::Measurement(measurement);
    let begun = Instant::now();
    let found = explain(&recording, &options, &Progress::silent())?;
    let seconds = begun.elapsed().as_secs_f64();
    let error = found.held_out.as_ref().unwrap_or(&found.error);
    Ok(Judged {
        name: planned.name.clone(),
        left_out: planned.left_out,
        visible: known.visible,
        verdict: Some(found.verdict),
        place: found.place,
        named: found.effects.iter().map(class).collect(),
        position_error: position_error(truth, &found).map(|error| error / length),
        sensor_right: sensor_right(truth, &found),
        size_inside: size_inside(truth, &found),
        over_floor: [error.before, error.after].map(|value| value / error.noise_floor),
        failure: None,
        unmade: false,
        seconds,
        effect,
        second,
    })
}

fn class(effect: &frettrace::results::Effect) -> Vec<String> {
    std::iter::once(&effect.id).chain(effect.indistinguishable_from.iter().take(2)).cloned().collect()
}

/// The effect named where it is the true one.
fn named<'a>(truth: &Effect, found: &'a Explanation) -> Option<&'a frettrace::results::Effect> {
    found.effects.iter().find(|effect| effect.id == truth.id())
}

/// In m.
fn position_error(truth: Option<&Effect>, found: &Explanation) -> Option<f64> {
    let position = truth?.position()?;
    Some((named(truth?, found)?.position_m? - position).abs())
}

fn sensor_right(truth: Option<&Effect>, found: &Explanation) -> Option<bool> {
    let sensor = truth?.sensor()?;
    Some(named(truth?, found)?.sensor? == sensor)
}

/// Only where the truth and the model have the same parameter by the same name.
fn size_inside(truth: Option<&Effect>, found: &Explanation) -> Option<bool> {
    let (name, size) = match *truth? {
        Effect::Viscous { sigma2_n_s_per_m } => ("sigma2", sigma2_n_s_per_m),
        Effect::Stribeck { v_s_m_per_s, .. } => ("v_s", v_s_m_per_s),
        Effect::Asymmetry { share } => ("asymmetry", share),
        Effect::Breakaway { breakaway } => ("breakaway", breakaway),
        Effect::Exponent { exponent } => ("exponent", exponent),
        Effect::PreslidingDamping { sigma1_s_per_m, .. } => ("sigma1", sigma1_s_per_m),
        Effect::Wear { relative_change } => ("wear", relative_change),
        Effect::Backlash { half_play_m } => ("half_play", half_play_m),
        _ => return None,
    };
    let estimate = named(truth?, found)?.parameters.get(name)?;
    let [low, high] = estimate.interval95;
    Some(low <= size && size <= high)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn answer(effect: Option<&str>, verdict: Verdict, named: &[&[&str]]) -> Judged {
        Judged {
            effect: effect.map(str::to_owned),
            verdict: Some(verdict),
            named: named.iter().map(|c| c.iter().map(|&id| id.to_owned()).collect()).collect(),
            place: Some(Place::Contact),
            ..Judged::default()
        }
    }

    /// The definitions of the worth of an answer, one by one.
    #[test]
    fn answers_have_their_worth() {
        let lag = Some("friction.lag");
        let wear: &[&[&str]] = &[&["friction.wear"]];
        assert_eq!(answer(None, Verdict::NothingMissing, &[]).worth(), Worth::Right);
        assert_eq!(answer(None, Verdict::Explained, wear).worth(), Worth::Wrong);
        assert_eq!(answer(lag, Verdict::NothingMissing, &[]).worth(), Worth::Missed);
        assert_eq!(answer(lag, Verdict::Unexplained, &[]).worth(), Worth::Unexplained);
        assert_eq!(answer(lag, Verdict::Explained, &[&["friction.lag"]]).worth(), Worth::Right);
        assert_eq!(
            answer(lag, Verdict::Explained, &[&["friction.film", "friction.lag"]]).worth(),
            Worth::Class
        );
        assert_eq!(answer(lag, Verdict::Explained, wear).worth(), Worth::Wrong);
        let out = Judged { left_out: true, ..answer(lag, Verdict::Unexplained, &[]) };
        assert_eq!(out.worth(), Worth::Right);
        let elsewhere = Judged { place: Some(Place::Structure), ..out.clone() };
        assert_eq!(elsewhere.worth(), Worth::Unexplained);
        assert_eq!(Judged { named: vec![vec!["friction.film".into()]], ..out }.worth(), Worth::Wrong);
        assert_eq!(Judged::default().worth(), Worth::Failed);
        let both = |named| {
            let second = Some("friction.wear".into());
            Judged { second, ..answer(lag, Verdict::Explained, named) }.worth()
        };
        assert_eq!(both(&[&["friction.wear"], &["friction.lag"]]), Worth::Right);
        assert_eq!(both(&[&["friction.wear"], &["friction.film", "friction.lag"]]), Worth::Class);
        assert_eq!(both(wear), Worth::Half);
        assert_eq!(both(&[&["friction.wear", "friction.lag"]]), Worth::Half);
        assert_eq!(both(&[&["friction.wear"], &["friction.film"]]), Worth::Wrong);
    }
}
