//! Sets that were answered wrong once and are right now: none may be wrong again.

use super::CLEAN;
use super::plan::{Planned, pairs, plan, thirds, wide};
use serde::Deserialize;
use std::collections::BTreeMap;

/// Which plan, its seed, and the name in it.
const LIST: &str = include_str!("../../cases/verify_sweep/mended.csv");

#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Deserialize)]
#[serde(rename_all = "lowercase")]
enum Plan {
    Singles,
    Pairs,
    Thirds,
    Wide,
}

#[derive(Deserialize)]
struct Entry {
    plan: Plan,
    seed: u64,
    name: String,
}

/// All of them in the order in which they were met, each under its seed and its name, since names repeat from seed to seed.
///
/// # Errors
/// Where the list is no table, or names a set that is in no plan.
pub fn mended() -> anyhow::Result<Vec<Planned>> {
    let mut drawn = BTreeMap::new();
    let entries = csv::Reader::from_reader(LIST.as_bytes()).into_deserialize();
    let found = |entry: Result<Entry, csv::Error>| {
        let Entry { plan: kind, seed, name } = entry?;
        let sets = drawn.entry((kind, seed)).or_insert_with(|| match kind {
            Plan::Singles => plan(seed, CLEAN),
            Plan::Pairs => pairs(seed),
            Plan::Thirds => thirds(seed),
            Plan::Wide => wide(seed),
        });
        let set = sets.iter().find(|set| set.name == name);
        let set =
            set.ok_or_else(|| anyhow::anyhow!("mended.csv: no set \"{name}\" in the plan of seed {seed}"))?;
        Ok(Planned { name: format!("{seed} {name}"), ..set.clone() })
    };
    entries.map(found).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeSet;

    /// Every line of the list is a set, and none is there twice.
    #[test]
    fn the_list_names_sets() {
        let sets = mended().unwrap();
        assert_eq!(sets.len() + 1, LIST.lines().count());
        let names: BTreeSet<&str> = sets.iter().map(|set| set.name.as_str()).collect();
        assert_eq!(names.len(), sets.len());
    }
}
