//! Contact records: what a friction law lacks, told by motion and force of the contact itself.
//!
//! The force is predicted from the motion alone. The declared law is fitted to the training runs with an offset as
//! nuisance, candidate effects are put inside the law and everything is fitted again, one effect after the other, as
//! long as the residual lies above the floor, the evidence holds and runs that were held out agree.

mod candidates;
mod drive;
mod evidence;
mod floor;
mod follows;
mod model;
mod search;
mod setting;
#[cfg(test)]
mod tests;

pub use evidence::effective_count;
pub use floor::{Floor, strokes};
pub use follows::{Follows, follows};
pub use search::{RecordEffect, RecordFit, RecordOutcome, RecordTried, explain_record};
pub use setting::{RecordQuantity, RecordSetting, RecordUnknown};

use frettrace_identify::contact::{ContactHistory, Family, FloorSource};

/// One run, or a part of one, of a contact record.
#[derive(Clone, Debug)]
pub struct RecordRun {
    /// Motion and force.
    pub history: ContactHistory,
    /// Place of the run's first and last sample in the whole record, from 0 to 1.
    pub progress: [f64; 2],
    /// Standard deviation of the force's noise (N), where the file states it.
    pub stated: Option<f64>,
}

/// The mass that moves with the contact.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum MovingMass {
    /// None is declared.
    None,
    /// It is known (kg).
    Known(f64),
    /// It is unknown and wanted.
    Wanted,
}

/// A contact record to be explained.
#[derive(Clone, Debug)]
pub struct RecordCase {
    /// The declared law.
    pub law: Family,
    /// Runs that are fitted.
    pub training: Vec<RecordRun>,
    /// Runs that nothing is fitted to.
    pub held_out: Vec<RecordRun>,
    /// The moving mass.
    pub mass: MovingMass,
    /// Ids of effects that are left out of the search.
    pub without: Vec<String>,
}

/// What the record is like: sizes from which starts and bounds of the candidates follow.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct RecordScales {
    /// Largest slip from the middle (m).
    pub slip: f64,
    /// Middle of the slip (m).
    pub middle: f64,
    /// Largest speed (m/s).
    pub velocity: f64,
    /// Largest acceleration (m/s²).
    pub acceleration: f64,
    /// Time of two strokes (s).
    pub period: f64,
    /// Mean normal force (N).
    pub normal: f64,
    /// Whether normal forces differ between runs or within them by more than a hundredth.
    pub loads_differ: bool,
    /// Root mean square of the force (N).
    pub force: f64,
}

impl RecordScales {
    fn of(runs: &[RecordRun]) -> Self {
        let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
        let (mut lightest, mut heaviest) = (f64::INFINITY, f64::NEG_INFINITY);
        let mut scales = Self {
            slip: 0.0,
            middle: 0.0,
            velocity: 0.0,
            acceleration: 0.0,
            period: 0.0,
            normal: 0.0,
            loads_differ: false,
            force: 0.0,
        };
        let (mut square, mut count, mut periods) = (0.0, 0.0, Vec::new());
        for RecordRun { history, .. } in runs {
            for k in 0..history.len() {
                (low, high) = (low.min(history.slip[k]), high.max(history.slip[k]));
                square += history.force[k].powi(2);
                count += 1.0;
            }
            let normal = history.mean_normal();
            (lightest, heaviest) = (lightest.min(normal), heaviest.max(normal));
            scales.normal += normal / runs.len() as f64;
            scales.velocity = scales.velocity.max(history.top_speed());
            let accelerations = history.acceleration.iter().flatten();
            scales.acceleration = accelerations.fold(scales.acceleration, |m, a| m.max(a.abs()));
            let duration = history.time.last().unwrap_or(&0.0) - history.time.first().unwrap_or(&0.0);
            periods.push(2.0 * duration / (strokes(&history.slip).len().max(1) as f64));
        }
        periods.sort_by(f64::total_cmp);
        scales.period = periods.get(periods.len() / 2).copied().unwrap_or(1.0).max(f64::MIN_POSITIVE);
        scales.slip = (0.5 * (high - low)).max(f64::MIN_POSITIVE);
        scales.middle = 0.5 * (high + low);
        scales.velocity = scales.velocity.max(f64::MIN_POSITIVE);
        scales.force = (square / f64::max(count, 1.0)).sqrt().max(f64::MIN_POSITIVE);
        scales.loads_differ = heaviest > 1.01 * lightest;
        scales
    }
}

/// Where the floor of a record comes from: stated only where every run states it.
fn floor_source(runs: &[RecordRun], found: Option<&Floor>) -> FloorSource {
    if runs.iter().all(|run| run.stated.is_some_and(|std| std > 0.0)) {
        FloorSource::Given
    } else if found.is_some() {
        FloorSource::Repeats
    } else {
        FloorSource::Estimated
    }
}
