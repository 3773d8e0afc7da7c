//! Whether the law's parameters are the same over preload, frequency, level, lubrication and temperature.

use super::Joint;
use crate::results::{Dependence, GroupEstimate};
use frettrace_forward::accelerations::Quantity;
use frettrace_friction::effects::Hook;
use frettrace_identify::evidence::STRONG;
use frettrace_identify::{GroupTest, IdentifiedParameter};
use frettrace_measurement::{Measurement, Run};
use std::collections::BTreeMap;

/// Values of a condition closer than this to each other are one.
const ALIKE: f64 = 0.02;
/// A condition with more values than this is cut into its lower and its upper half.
const MOST_GROUPS: usize = 4;

/// A condition of the runs, and the group of each of them.
pub(super) struct Condition {
    name: &'static str,
    labels: Vec<String>,
    pub(super) group: Vec<usize>,
}

/// The conditions that differ between the runs of a measurement.
pub(super) fn conditions(measurement: &Measurement) -> Vec<Condition> {
    let runs = &measurement.runs;
    let of = |value: &dyn Fn(&Run) -> Option<f64>| runs.iter().map(value).collect::<Option<Vec<f64>>>();
    let rms = |run: &Run| {
        let (sum, count) = run.acceleration.iter().flatten().fold((0.0, 0), |(s, n), a| (s + a * a, n + 1));
        (sum / f64::from(count.max(1))).sqrt()
    };
    let all = [
        ("preload", "N", of(&|r| Some(r.preload))),
        ("excitation frequency", "Hz", of(&|r| Some(r.excitation_frequency))),
        ("level", "m/s^2", of(&|r| Some(rms(r)))),
        ("lubrication", "", of(&|r| r.lubricated.map(|l| f64::from(u8::from(l))))),
        ("temperature", "K", of(&|r| r.temperature)),
    ];
    all.into_iter().filter_map(|(name, unit, values)| condition(name, unit, &values?)).collect()
}

/// Groups of equal values, or the lower and the upper half where there are many; `None` where all are equal.
fn condition(name: &'static str, unit: &str, values: &[f64]) -> Option<Condition> {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let mut levels: Vec<f64> = Vec::new();
    for value in &sorted {
        if levels.last().is_none_or(|last| value - last > ALIKE * last.abs()) {
            levels.push(*value);
        }
    }
    if levels.len() < 2 {
        return None;
    }
    let named = |from: f64, to: f64| {
        if from == to { format!("{from} {unit}") } else { format!("{from:.4} to {to:.4} {unit}") }
    };
    let halves = levels.len() > MOST_GROUPS;
    let starts = if halves { vec![sorted[0], sorted[sorted.len() / 2]] } else { levels };
    let group_of = |value: f64| starts.iter().rposition(|start| value >= *start).unwrap_or(0);
    let group: Vec<usize> = values.iter().map(|v| group_of(*v)).collect();
    let labels = (0..starts.len()).map(|g| {
        let inside = || sorted.iter().copied().filter(|v| group_of(*v) == g);
        named(inside().fold(f64::INFINITY, f64::min), inside().fold(f64::NEG_INFINITY, f64::max))
    });
    Some(Condition { name, labels: labels.map(|l| l.trim().to_owned()).collect(), group })
}

/// Indices of the parameters whose dependence is tested: friction and stiffness.
pub(super) fn tested(quantities: impl Iterator<Item = Quantity>) -> Vec<usize> {
    let wanted = [Quantity::Law(Hook::MuKinetic), Quantity::Law(Hook::Sigma0)];
    quantities.enumerate().filter(|(_, q)| wanted.contains(q)).map(|(j, _)| j).collect()
}

/// What the tests say, for the result file, with a sentence for each parameter that differs.
pub(super) fn described(
    joint: &Joint,
    conditions: &[Condition],
    tests: &[Vec<GroupTest>],
) -> (Vec<Dependence>, Vec<String>) {
    let mut notes = Vec::new();
    let mut found = Vec::new();
    for (condition, tests) in conditions.iter().zip(tests).filter(|(_, tests)| !tests.is_empty()) {
        let mut parameters = BTreeMap::new();
        for test in tests {
            let shared = &joint.identified.parameters[test.parameter];
            let name = shared.name.clone();
            let estimate = GroupEstimate {
                differs: test.evidence > STRONG && beyond(test, shared),
                evidence: test.evidence,
                values: test.values.iter().map(|(value, _)| *value).collect(),
                std: test.values.iter().map(|(_, std)| *std).collect(),
            };
            if estimate.differs {
                notes.push(format!(
                    "{name} depends on the {}: {:.4?} in the groups {} (ΔBIC {:.0} against one value)",
                    condition.name,
                    estimate.values,
                    condition.labels.join(", "),
                    estimate.evidence
                ));
            }
            parameters.insert(name, estimate);
        }
        let (condition, groups) = (condition.name.to_owned(), condition.labels.clone());
        found.push(Dependence { condition, groups, parameters });
    }
    (found, notes)
}

/// Whether the groups lie further apart than the interval of the shared value, which knows what the model itself is off by: series
/// that are cut off, and runs that pull in different directions.
fn beyond(test: &GroupTest, shared: &IdentifiedParameter) -> bool {
    let values = || test.values.iter().map(|(value, _)| *value);
    let apart = values().fold(f64::NEG_INFINITY, f64::max) - values().fold(f64::INFINITY, f64::min);
    shared.interval95.is_none_or(|(low, high)| apart > 0.5 * (high - low))
}

#[cfg(test)]
mod tests {
    use super::{beyond, condition};
    use frettrace_identify::{GroupTest, HALF_INTERVAL95, Identifiability, IdentifiedParameter};

    /// Values 1 % apart under an interval of ±2 % and of ±0.5 %; without an interval nothing speaks against them.
    #[test]
    fn groups_that_differ_by_less_than_is_known_do_not_differ() {
        let test = GroupTest { parameter: 0, evidence: 42.0, values: vec![(1.005, 1e-4), (0.995, 1e-4)] };
        let shared = |half: Option<f64>| IdentifiedParameter {
            name: "sigma0".to_owned(),
            unit: "1/m".to_owned(),
            value: 1.0,
            std: half.map(|h| h / HALF_INTERVAL95),
            interval95: half.map(|h| (1.0 - h, 1.0 + h)),
            identifiability: Identifiability::Identifiable,
        };
        assert!(!beyond(&test, &shared(Some(0.02))));
        assert!(beyond(&test, &shared(Some(0.005))) && beyond(&test, &shared(None)));
    }

    #[test]
    fn equal_values_are_one_group_and_many_values_two() {
        assert!(condition("preload", "N", &[50.0, 50.1, 50.0]).is_none(), "within two per cent");
        let two = condition("preload", "N", &[80.0, 50.0, 50.0]).unwrap();
        assert_eq!((two.group, two.labels), (vec![1, 0, 0], vec!["50 N".to_owned(), "80 N".to_owned()]));
        let many = condition("level", "", &[1.0, 2.0, 4.0, 8.0, 16.0, 32.0]).unwrap();
        assert_eq!(many.group, [0, 0, 0, 1, 1, 1]);
    }
}
