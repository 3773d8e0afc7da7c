//! Runs without a period whose balance no contact force closes, beside periodic runs that lack nothing.
//!
//! A beam may reach a stop in its loudest run alone, and bounce there without a period. No waveform is predicted of such a run, and a law judges
//! only the contact that was recovered of it; what that recovery leaves is judged here. One more free force at a place along the beam,
//! ```text
//! a = G_e F + G_c f_c + G_x f_x + noise,
//! ```
//! closes the balance of all such runs where it is a second support that does it, and `f_x` rests while the beam is off it. No law is asked of
//! either force.

use super::{Named, Outcome, Place, Verdict};
use crate::Case;
use crate::effects::{ALL, EffectPlace, listed};

/// A support along the beam as runs without a period show it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SeenSupport {
    /// Its place (m), with a standard deviation.
    pub position: [f64; 2],
    /// Largest force (N) from where it rests, with a standard deviation.
    pub force: [f64; 2],
}

/// Share of the time in which a force rests …
const HALF: f64 = 0.5;
/// … and of its range within which it does: half of the values of a sine's square, cube and fifth power lie within 0.5, 0.35 and 0.18 of theirs.
const STILL: f64 = 0.1;

/// The largest force of a support away from where it rests, by its samples; `None` where it does not rest for half of the time. The mean of a
/// recovered force is not known.
#[must_use]
pub fn peak_from_rest(force: &[f64]) -> Option<f64> {
    let mut sorted = force.to_vec();
    sorted.sort_by(f64::total_cmp);
    let (least, most) = (*sorted.first()?, *sorted.last()?);
    let half = (HALF * sorted.len() as f64).ceil() as usize;
    let narrowest = sorted
        .windows(half.max(1))
        .min_by(|a, b| (a[a.len() - 1] - a[0]).total_cmp(&(b[b.len() - 1] - b[0])))?;
    let (from, to) = (narrowest[0], narrowest[narrowest.len() - 1]);
    let rest = 0.5 * (from + to);
    (to - from <= STILL * (most - least) && most > least).then(|| (most - rest).max(rest - least))
}

impl Outcome {
    /// Whether the structure, the excitation and the channels are as they were declared, and nothing more is said to be missing.
    #[must_use]
    pub fn leaves_the_balance(&self, case: &Case) -> bool {
        let in_contact =
            self.effects.iter().all(|e| listed(e.id).is_none_or(|e| ALL[e].place() == EffectPlace::Contact));
        self.verdict != Verdict::Unexplained && in_contact && case.faults.is_empty() && case.shaken.is_none()
    }

    /// Names a second support that runs without a period show; where it is not asked for, the structure lacks what has no name.
    pub fn with_support(&mut self, case: &Case, seen: SeenSupport, note: String) {
        let Some(effect) = listed(SECOND_SUPPORT).map(|e| ALL[e]).filter(|effect| case.allows(effect.id()))
        else {
            return self.left_open(EffectPlace::Structure, note);
        };
        let [[position, about], [force, accuracy]] = [seen.position, seen.force];
        self.effects.push(Named {
            id: effect.id(),
            probability: 1.0,
            position: Some(position),
            sensor: None,
            parameters: vec![
                ("position".into(), "m".into(), position, about),
                ("peak_force".into(), "N".into(), force, accuracy),
            ],
            indistinguishable: Vec::new(),
            experiment: effect.experiment(),
        });
        self.verdict = Verdict::Explained;
        self.place = self.place.or(Some(effect.place()));
        self.notes.push(note);
    }

    /// Something is missing there that has no name.
    pub fn left_open(&mut self, place: Place, note: String) {
        self.verdict = Verdict::Unexplained;
        self.effects.clear();
        self.place = Some(place);
        self.notes.push(note);
    }
}

const SECOND_SUPPORT: &str = "structure.second-support";

#[cfg(test)]
mod tests {
    use super::peak_from_rest;

    fn sampled(of: impl Fn(f64) -> f64) -> Vec<f64> {
        (0..4000).map(|k| of((f64::from(k) * 0.0537).sin())).collect()
    }

    /// A stop that a sine reaches from 0.8 on takes `0.2 k` at most, whatever mean is lost; springs and powers of a sine rest nowhere.
    #[test]
    fn a_stop_rests_and_a_spring_does_not() {
        let stop = |x: f64| 50.0 * (x - 0.8_f64).max(0.0) - 7.0;
        let peak = peak_from_rest(&sampled(stop)).unwrap();
        assert!((peak - 10.0).abs() < 0.02, "{peak}");
        let both = |x: f64| stop(x) - stop(-x);
        assert!((peak_from_rest(&sampled(both)).unwrap() - 10.0).abs() < 0.02);
        for power in [1, 2, 3, 5] {
            assert_eq!(peak_from_rest(&sampled(|x| x.powi(power))), None, "{power}");
        }
        assert_eq!(peak_from_rest(&[]), None);
        assert_eq!(peak_from_rest(&[1.0; 8]), None);
    }
}
