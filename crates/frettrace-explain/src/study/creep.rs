//! Contacts that have not settled ([`Setting::deflections`]): found in turns with everything else.
//!
//! A bristle that is elastic up to its breakaway keeps the deflection `z₀` that it came to when a run last slid, or creeps from it for thousands
//! of periods, by less than any record shows. Under a preload that does not change that is a constant force, which no accelerometer sees; a
//! modulated one puts it on the modulation's line. `z₀` is then a value of the run, and that run alone tells it: its χ² is nearly a parabola
//! in it. Where the bristle yields at one end of its motion more than at the other for it, it makes even harmonics, which every accelerometer sees.
//! A contact that would lose more of it in a period than a record could hide has settled, whatever χ² says. Along a given motion it
//! loses a share `r` in a period; on the beam, which follows its mean force with the static compliance `R₀`, `r/(1 + R₀ P σ₀)`: what the
//! bristle gives way the beam takes up ([`ModifiedLaw::drift`]), and a soft beam keeps a contact from settling for long.
//!
//! [`ModifiedLaw::drift`]: frettrace_friction::effects::ModifiedLaw::drift

use super::Study;
use crate::search::{Explained, NEAR};
use frettrace_forward::accelerations::{ContactHistory, Setting};
use frettrace_friction::effects::Hook;
use rayon::prelude::*;

/// Turns of the deflections and of everything else.
const TURNS: usize = 8;
/// Distances at which the parabola is taken, as shares of the deflection that breaks away: a look, then two corrections where it is none.
const DISTANCES: [f64; 3] = [0.2, 0.05, 0.02];
/// Farthest step, in these distances.
const FARTHEST: f64 = 5.0;
/// χ² by which a run must tell that its contact has not settled.
const TELLS: f64 = 9.0;
/// χ² per residual from which a model misses a run.
const MISSED: f64 = 1.5;
/// Share of its distance from where it would settle that such a contact loses in a period at most: half of it in seventy …
const CREEPS: f64 = 0.01;
/// … or a part of it in a record, over which its lines are those of the middle.
const LOSES: f64 = 0.5;

/// Deflection at which a law breaks away: what it came to below that it never forgets.
pub(crate) fn breaks_away(setting: &Setting) -> Option<f64> {
    let law = &setting.law;
    let share = law.get(Hook::Breakaway).filter(|share| *share > 0.0)?;
    Some(share * law.get(Hook::MuKinetic)?)
}

impl Study<'_> {
    /// A model in which contacts that have not settled begin their periods with deflections of their own, these and everything else in turns;
    /// the same model where no run tells that its contact has not.
    pub(crate) fn unsettled_contacts(&self, mut model: Explained) -> Explained {
        for _ in 0..TURNS {
            let Some(setting) = self.deflected(&model) else { break };
            let of = |setting: &Setting, run: usize| setting.deflections.get(run).copied().flatten();
            let before = &model.fitted.setting;
            let fitted = self.training.iter().any(|&run| of(before, run) != of(&setting, run));
            let mut other = model.clone();
            other.fitted.setting = setting;
            if !fitted {
                return other;
            }
            match self.polished(&other) {
                Ok(better) if better.criterion + TELLS < model.criterion => model = better,
                _ => break,
            }
        }
        model
    }

    /// The values of a model with the deflections that its runs tell; `None` where none tells another one than it has.
    fn deflected(&self, model: &Explained) -> Option<Setting> {
        let breaks = breaks_away(&model.fitted.setting)?;
        // A modulated preload shows the mean force itself. Without one a run shows no more of it than even harmonics, which other things make too: the
        // model must be near the data there, and miss the run.
        let modulated = model.fitted.setting.law.get(Hook::ModulationCosine).is_some();
        let runs = if modulated { self.all_runs() } else { self.missed_from_near(model) };
        if runs.is_empty() {
            return None;
        }
        let settled = Setting { deflections: Vec::new(), ..model.fitted.setting.clone() };
        let settled: Vec<Option<ContactHistory>> =
            runs.par_iter().map(|&run| self.contact_history(model, &settled, run)).collect();
        let mut setting = model.fitted.setting.clone();
        // Every look begins at the motions that the model has, those of the runs held out among them: what has no answer near them tells nothing.
        let mut known = model.fitted.memory.clone();
        self.begin(&setting, &runs, &mut known);
        self.model.approach_each(&setting, &runs, &mut known).ok()?;
        setting.deflections.resize(self.model.runs.len(), None);
        let left_by = |setting: &Setting| self.chi_squared_near(setting, &runs, &known);
        let mut left = left_by(&setting);
        let mut moved = false;
        for distance in DISTANCES.map(|share| share * breaks) {
            let away = |steps: &dyn Fn(usize) -> f64| {
                let mut other = setting.clone();
                for (k, &run) in runs.iter().enumerate() {
                    let own = setting.deflections[run].or(settled[k].as_ref().map(|one| one.deflection));
                    other.deflections[run] = own.map(|own| own + steps(k) * distance);
                }
                let left = left_by(&other);
                (other, left)
            };
            let [(_, below), (_, above)] = [-1.0, 1.0].map(|step| away(&|_| step));
            let step = |k: usize| vertex([below[k], left[k], above[k]]).clamp(-FARTHEST, FARTHEST);
            let (other, found) = away(&step);
            for (k, &run) in runs.iter().enumerate() {
                if found[k] + TELLS < left[k] && self.stays(model, &other, (run, &settled[k])) {
                    setting.deflections[run] = other.deflections[run];
                    left[k] = found[k];
                    moved = true;
                }
            }
        }
        moved.then_some(setting)
    }

    /// Runs that a model misses by more than their noise, where it is near the data.
    fn missed_from_near(&self, model: &Explained) -> Vec<usize> {
        if model.ratio > NEAR {
            return Vec::new();
        }
        let runs = self.all_runs();
        let left = self.chi_squared(&model.fitted, &runs);
        let missed = |(run, left): &(usize, f64)| *left > MISSED * self.residuals_of(&[*run]) as f64;
        runs.into_iter().zip(left).filter(missed).map(|(run, _)| run).collect()
    }

    /// Whether the contact of a run creeps so slowly from the deflection that a setting gives it that it stays away from where it would settle.
    fn stays(
        &self,
        model: &Explained,
        setting: &Setting,
        (run, settled): (usize, &Option<ContactHistory>),
    ) -> bool {
        let Ok(balances) = self.model.balance(setting, &[run]) else { return false };
        let sigma0 = setting.law.get(Hook::Sigma0).unwrap_or_default();
        let give: f64 = balances.iter().map(|balance| balance.slip_gain[0].re.abs()).sum();
        let (lines, record) = (&self.model.runs[run], &self.case.records[run]);
        let slower = 1.0 + give * lines.preload * sigma0;
        let periods = record.samples as f64 / record.sampling_rate * lines.omega / std::f64::consts::TAU;
        let most = slower * CREEPS.max(LOSES / periods);
        creeping(&self.contact_history(model, setting, run), settled, most)
    }

    /// What the contact does in a run with other values than a fitted model has, from its motions; `None` where the balance does not close.
    fn contact_history(&self, model: &Explained, setting: &Setting, run: usize) -> Option<ContactHistory> {
        self.model.contact(setting, run, &mut model.fitted.memory.clone()).ok()
    }
}

/// Whether a contact that begins its period away from where it would settle loses at most a share of that in a period of a motion that repeats.
fn creeping(away: &Option<ContactHistory>, settled: &Option<ContactHistory>, most: f64) -> bool {
    let Some((away, settled)) = away.as_ref().zip(settled.as_ref()) else { return false };
    away.creep.abs() <= most * (away.deflection - settled.deflection).abs()
}

/// Where a parabola through values at −1, 0 and 1 is lowest; 0 where it is lowest nowhere, or where a value is without bound.
fn vertex([before, at, after]: [f64; 3]) -> f64 {
    let bend = before + after - 2.0 * at;
    if bend > 0.0 && bend.is_finite() { 0.5 * (before - after) / bend } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use frettrace_friction::effects::ModifiedLaw;

    /// `3(x − 0.4)² + 2` is lowest at 0.4; a line and a ridge are lowest nowhere.
    #[test]
    fn a_parabola_has_its_vertex() {
        let at = |of: fn(f64) -> f64| vertex([of(-1.0), of(0.0), of(1.0)]);
        assert!((at(|x| 3.0 * (x - 0.4) * (x - 0.4) + 2.0) - 0.4).abs() < 1e-14);
        assert_eq!(at(|x| 2.0 * x), 0.0);
        assert_eq!(at(|x| -x * x + x), 0.0);
        assert_eq!(vertex([f64::INFINITY, 1.0, 2.0]), 0.0);
    }

    /// A contact 0.01 from where it settles that loses 3 % of that in a period along its motion: on a stiff structure half of it is gone in 23
    /// periods, on a beam with `R₀ P σ₀ = 24` in 580. One that sticks loses nothing.
    #[test]
    fn a_soft_beam_keeps_a_contact_from_settling() {
        let at =
            |deflection: f64, creep: f64| Some(ContactHistory { deflection, creep, ..Default::default() });
        let settled = at(0.15, 0.0);
        let away = at(0.16, -3e-4);
        assert!(!creeping(&away, &settled, CREEPS) && creeping(&away, &settled, 25.0 * CREEPS));
        assert!(creeping(&at(0.14, 0.0), &settled, CREEPS));
        // A contact that forgets within its period has settled, and where no balance closes nothing is known.
        assert!(!creeping(&at(0.16, -0.01), &settled, 25.0 * CREEPS));
        assert!(!creeping(&None, &settled, 25.0 * CREEPS) && !creeping(&away, &None, 25.0 * CREEPS));
    }

    /// Only a bristle that is elastic up to its breakaway keeps what it came to.
    #[test]
    fn a_bristle_with_a_breakaway_keeps_what_it_came_to() {
        let mut setting = Setting::new(Vec::new(), Vec::new(), ModifiedLaw::dahl(1e5, 0.4), 1);
        assert_eq!(breaks_away(&setting), None);
        setting.law.set(Hook::Breakaway, 0.25);
        assert_eq!(breaks_away(&setting), Some(0.1));
        setting.law.set(Hook::Breakaway, 0.0);
        assert_eq!(breaks_away(&setting), None);
    }
}
