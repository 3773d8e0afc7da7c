//! Sensors that break off or are cut in runs without a period.
//!
//! No period fills what such a channel lost, so that the contact is recovered without the sensor. What is found in its samples is named where the
//! balance of all runs bears it out: open with the sensor, closed without it.

use super::motion::WholeRun;
use super::{WholeOutcome, balance};
use crate::Case;
use crate::channels::ChannelFault;
use crate::effects::EffectPlace;
use crate::verdict::{Tried, Verdict, faulty};

/// An outcome of runs that were recovered without the sensors that break off, with the faults of these named where the rest is explained; where one
/// may not be named, the measurement is the place of what is missing. `balances` are those of the runs with these sensors and without them.
/// Errors are those of the accelerations then, as these have them.
#[must_use]
pub fn with_faults(
    case: &Case,
    balances: [&[Option<WholeRun>]; 2],
    mut outcome: WholeOutcome,
) -> WholeOutcome {
    let found: Vec<&ChannelFault> = case.faults.iter().filter(|fault| fault.breaks_off()).collect();
    let [with, without] = balances.map(|runs| runs.iter().flatten().collect::<Vec<_>>());
    if found.is_empty() || balance::closed(&with) || !balance::closed(&without) {
        return outcome;
    }
    let tried = |fault: &&ChannelFault| Tried { id: fault.id, error: f64::NAN, evidence: fault.evidence };
    outcome.tried.splice(0..0, found.iter().map(tried));
    if outcome.verdict == Verdict::Unexplained {
        return outcome;
    }
    let [(open, _), (closed, _)] = [&with, &without].map(|runs| balance::reduced(runs));
    if found.iter().any(|fault| !case.allows(fault.id)) {
        let note = format!(
            "a sensor breaks off: without it the balance closes (χ² per degree of freedom {closed:.2}, {open:.2} with it)"
        );
        outcome.left_open(EffectPlace::Measurement, note);
        return outcome;
    }
    for fault in &found {
        outcome.notes.push(format!(
            "{} of sensor {}: the contact is recovered without it, and the balance closes (χ² per degree of freedom {closed:.2}, {open:.2} with it)",
            fault.id, fault.sensor
        ));
    }
    outcome.verdict = Verdict::Explained;
    outcome.place = outcome.place.or(Some(EffectPlace::Measurement));
    outcome.effects.splice(0..0, found.iter().map(|fault| faulty(fault)));
    outcome.of_balances(case, balances);
    outcome
}
