//! The mean slip of a recovered run, which no accelerometer sees: it matters where friction depends on the contact's place.

use super::{ContactProblem, Contacts, Recovered};
use frettrace_forward::accelerations::FrequencyRatio;
use frettrace_friction::effects::{Hook, ModifiedLaw};

/// Distance between mean slips that are tried, as a share of the wave of a periodic friction, …
const OF_WAVE: f64 = 0.125;
/// … or, where it is not periodic, of the RMS of the slip, …
const OF_STROKE: f64 = 0.6;
/// … waves (or RMS of the slip) to either side in which the mean is sought, places that are fitted, and steps each gets.
const SOUGHT: f64 = 2.0;
const PLACES: usize = 3;
const MEAN_STEPS: usize = 8;

/// Mean slips (m) that are tried for a motion of so large a slip (m, RMS).
pub(crate) fn places(law: &ModifiedLaw<f64>, stroke: f64) -> impl Iterator<Item = f64> {
    let wave = law.get(Hook::PeriodicNumber).map(|number| std::f64::consts::TAU / number);
    let (size, share) = wave.map_or((stroke, OF_STROKE), |wave| (wave, OF_WAVE));
    let most = (SOUGHT / share).floor() as i32;
    (-most..=most).map(move |k| f64::from(k) * share * size)
}

impl Recovered {
    /// Mean slips (m), those that a law answers best first.
    fn places(&self, (law, modulation): (ModifiedLaw<f64>, FrequencyRatio)) -> Vec<f64> {
        let mut left = vec![0.0; self.around(0.0).count()];
        let mut tried: Vec<(f64, f64)> = places(&law, self.stroke())
            .map(|mean| {
                self.around(mean).residual(&law, modulation, &mut left);
                (left.iter().map(|r| r * r).sum(), mean)
            })
            .collect();
        tried.sort_by(|a: &(f64, f64), b| a.0.total_cmp(&b.0));
        tried.into_iter().map(|(_, mean)| mean).collect()
    }
}

/// Mean slip (m) around which a law whose friction depends on the contact's place answers a recovered run best.
pub(super) fn mean_slip(recovered: &Recovered, law: (ModifiedLaw<f64>, FrequencyRatio)) -> Option<f64> {
    let one = Contacts { periodic: vec![recovered.clone()], series: Vec::new(), leeway: None };
    let problem = ContactProblem::new(&one, law, (Vec::new(), Vec::new()));
    let places = recovered.places(law).into_iter().take(PLACES);
    let found = places.filter_map(|mean| problem.solve(MEAN_STEPS, &[mean]).ok());
    let best = found.min_by(|a, b| a.cost.total_cmp(&b.cost))?;
    problem.means(&best.values).first().copied()
}

/// Mean of the friction force (N) that a law whose friction depends on the contact's place has in a recovered run: of the places
/// where it may be, the one that the run was recovered from.
pub(crate) fn mean_force(recovered: &Recovered, law: (ModifiedLaw<f64>, FrequencyRatio)) -> Option<f64> {
    mean_slip(recovered, law).map(|mean| -mean / recovered.give)
}
