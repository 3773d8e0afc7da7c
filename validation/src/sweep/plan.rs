//! The plan: which sets a sweep has, from its seed alone.

use super::rigs::{Choice, Kind, Modes, RIGID};
use frettrace::rig::RigSlip;
use std::collections::BTreeSet;

/// A planned set.
#[derive(Clone, Debug, PartialEq)]
pub struct Planned {
    /// Name, unique in the plan.
    pub name: String,
    /// Formulas of its effects as RIG.toml writes them: one, two in a set of [`pairs`], none in a clean one.
    pub formulas: Vec<&'static str>,
    /// Size of the effects, 1 or 2.
    pub size: u8,
    /// Whether the effect is taken out of the list that is searched.
    pub left_out: bool,
    /// What of the rig is chosen.
    pub choice: Choice,
    /// Everything else is drawn from this.
    pub seed: u64,
}

/// A formula and what its rig must have.
struct Formula {
    name: &'static str,
    laws: &'static [&'static str],
    needs: Needs,
}

#[derive(Clone, Copy, PartialEq)]
enum Needs {
    Nothing,
    /// A support so soft that the normal force varies.
    Soft,
    /// Runs at several preloads.
    Preloads,
    /// Declared modes: where nobody declares a damping ratio none can be another than declared.
    Modes,
}

/// Id of the effect that a formula is one of.
#[must_use]
pub fn effect_id(formula: &str) -> &str {
    formula.split('/').next().unwrap_or(formula)
}

impl Formula {
    fn id(&self) -> &str {
        effect_id(self.name)
    }

    fn is_listed(&self) -> bool {
        !self.name.starts_with("unlisted:")
    }

    /// Whether it is a formula of the bristle that is not the model's own.
    fn is_foreign(&self) -> bool {
        self.name.contains('/') && self.is_in_law()
    }

    fn is_in_law(&self) -> bool {
        let contact = ["contact.tangential-stiffness", "contact.backlash"].contains(&self.id());
        contact || self.name.starts_with("friction.")
    }
}

const DAHL: &[&str] = &["dahl"];
const ELASTIC: &[&str] = &["dahl", "lugre"];
const BRISTLE: &[&str] = &["dahl", "hybrid"];
const FALLING: &[&str] = &["lugre", "hybrid"];
const COULOMB: &[&str] = &["coulomb"];

const fn formula(name: &'static str, laws: &'static [&'static str]) -> Formula {
    Formula { name, laws, needs: Needs::Nothing }
}

const fn needing(name: &'static str, laws: &'static [&'static str], needs: Needs) -> Formula {
    Formula { name, laws, needs }
}

/// All formulas: those of the model that explains, those that are not, and those without a name.
const FORMULAS: &[Formula] = &[
    formula("friction.stribeck", DAHL),
    formula("friction.stribeck/rational", DAHL),
    formula("friction.viscous", DAHL),
    formula("friction.viscous/power", DAHL),
    formula("friction.lag", FALLING),
    formula("friction.lag/saturating", FALLING),
    formula("friction.film", DAHL),
    formula("friction.film/rational", DAHL),
    formula("friction.ageing", DAHL),
    formula("friction.ageing/saturating", DAHL),
    formula("friction.asymmetry", BRISTLE),
    formula("friction.asymmetry/smooth", BRISTLE),
    formula("friction.breakaway", ELASTIC),
    formula("friction.breakaway/straight", ELASTIC),
    formula("friction.exponent", DAHL),
    formula("friction.exponent/power", DAHL),
    formula("friction.presliding-damping", DAHL),
    formula("friction.presliding-damping/rational", DAHL),
    formula("friction.position", BRISTLE),
    formula("friction.position/saturating", BRISTLE),
    formula("friction.position-periodic", BRISTLE),
    formula("friction.position-periodic/triangle", BRISTLE),
    needing("friction.normal-dependence", DAHL, Needs::Soft),
    needing("friction.normal-dependence/straight", DAHL, Needs::Preloads),
    formula("friction.wear", BRISTLE),
    formula("friction.wear/settling", BRISTLE),
    needing("contact.lift-off", BRISTLE, Needs::Soft),
    needing("contact.normal-stiffening", BRISTLE, Needs::Soft),
    needing("contact.normal-stiffening/exponential", BRISTLE, Needs::Soft),
    formula("contact.tangential-stiffness", ELASTIC),
    formula("contact.tangential-stiffness/series", ELASTIC),
    formula("contact.tangential-stiffness/parallel", ELASTIC),
    formula("contact.backlash", ELASTIC),
    formula("contact.backlash/gradual", ELASTIC),
    formula("structure.cubic-stiffness", BRISTLE),
    formula("structure.cubic-stiffness/yielding", BRISTLE),
    formula("structure.quadratic-damping", BRISTLE),
    formula("structure.quadratic-damping/power", BRISTLE),
    formula("structure.clamp-compliance", BRISTLE),
    formula("structure.added-mass", BRISTLE),
    formula("structure.second-support", BRISTLE),
    formula("structure.second-support/round", BRISTLE),
    formula("structure.second-support/rubbing", BRISTLE),
    needing("structure.modal-frequency", BRISTLE, Needs::Modes),
    needing("structure.modal-damping", BRISTLE, Needs::Modes),
    formula("structure.frequency-drift", BRISTLE),
    formula("structure.frequency-drift/settling", BRISTLE),
    formula("excitation.preload-modulation", BRISTLE),
    formula("excitation.preload-modulation/square", BRISTLE),
    formula("excitation.base-motion", BRISTLE),
    formula("measurement.gain", BRISTLE),
    formula("measurement.delay", BRISTLE),
    formula("measurement.delay/low-pass", BRISTLE),
    formula("measurement.hum", BRISTLE),
    formula("measurement.hum/third-harmonic", BRISTLE),
    formula("measurement.clipping", BRISTLE),
    formula("measurement.clipping/soft", BRISTLE),
    formula("measurement.position", BRISTLE),
    formula("measurement.dropout", BRISTLE),
    formula("measurement.dropout/hold", BRISTLE),
    formula("measurement.offset", BRISTLE),
    formula("measurement.offset/drift", BRISTLE),
    formula("unlisted:contact/speed-square", DAHL),
    needing("unlisted:contact/normal-memory", DAHL, Needs::Soft),
    formula("unlisted:structure/even-stiffness", BRISTLE),
    formula("unlisted:excitation/moment", BRISTLE),
    formula("unlisted:excitation/second-force", BRISTLE),
    formula("unlisted:measurement/quadratic-gain", BRISTLE),
    formula("unlisted:measurement/high-pass", BRISTLE),
    formula("unlisted:measurement/cross-talk", BRISTLE),
];

/// The same on a contact that holds rigidly, where only its curve may be another.
const RIGID_FORMULAS: &[Formula] = &[
    formula("friction.stribeck", COULOMB),
    formula("friction.viscous", COULOMB),
    needing("contact.lift-off", COULOMB, Needs::Soft),
    needing("contact.normal-stiffening", COULOMB, Needs::Soft),
    formula("structure.cubic-stiffness", RIGID),
    formula("structure.quadratic-damping", RIGID),
    formula("structure.clamp-compliance", RIGID),
    formula("structure.added-mass", RIGID),
    formula("structure.second-support", RIGID),
    formula("structure.frequency-drift", RIGID),
    formula("excitation.preload-modulation", RIGID),
    formula("excitation.base-motion", RIGID),
    formula("measurement.gain", RIGID),
    formula("measurement.delay", RIGID),
    formula("measurement.hum", RIGID),
    formula("measurement.clipping", RIGID),
    formula("measurement.position", RIGID),
    formula("measurement.dropout", RIGID),
    formula("measurement.offset", RIGID),
    formula("unlisted:structure/even-stiffness", COULOMB),
    formula("unlisted:measurement/cross-talk", COULOMB),
];

/// Third formulas of effects.
const THIRD_FORMULAS: &[Formula] = &[
    formula("friction.stribeck/straight", DAHL),
    formula("friction.viscous/eyring", DAHL),
    formula("friction.ageing/power", DAHL),
    formula("friction.presliding-damping/exponential", DAHL),
    formula("friction.position/parabola", BRISTLE),
    formula("friction.position-periodic/square", BRISTLE),
    needing("friction.normal-dependence/adhesion", DAHL, Needs::Preloads),
    formula("friction.wear/root", BRISTLE),
    needing("contact.normal-stiffening/round", BRISTLE, Needs::Soft),
    formula("structure.cubic-stiffness/hyperbolic", BRISTLE),
    formula("structure.second-support/smooth", BRISTLE),
    formula("excitation.preload-modulation/skewed", BRISTLE),
    formula("measurement.delay/two-low-passes", BRISTLE),
    formula("measurement.clipping/one-sided", BRISTLE),
    formula("measurement.offset/settling", BRISTLE),
];

/// Laws of the clean sets.
const LAWS: [&str; 5] = ["dahl", "hybrid", "lugre", "coulomb", "stribeck"];

/// Every formula × two sizes × its laws × rotation and transverse, every third without its name in the list, and `clean` sets
/// without effect. Noise and modes alternate. The order is drawn, so that any beginning of the plan is a fair sample of it.
#[must_use]
pub fn plan(seed: u64, clean: usize) -> Vec<Planned> {
    let mut sets = with_effects(FORMULAS.iter().chain(RIGID_FORMULAS), 0, seed);
    sets.extend((0..clean).map(|index| without_effect(seed, index)));
    sets.sort_by_key(|set| set.seed);
    sets
}

/// The same of the third formulas of effects, without clean sets.
#[must_use]
pub fn thirds(seed: u64) -> Vec<Planned> {
    let mut sets = with_effects(THIRD_FORMULAS.iter(), 4_000_000, seed);
    sets.sort_by_key(|set| set.seed);
    sets
}

/// Sets with one effect, drawn from the numbers of a seed from a first one on.
fn with_effects<'a>(formulas: impl Iterator<Item = &'a Formula>, first: u64, seed: u64) -> Vec<Planned> {
    let mut sets = Vec::new();
    for formula in formulas {
        for size in [1, 2] {
            for &law in formula.laws {
                for slip in [RigSlip::Rotation, RigSlip::Transverse] {
                    if formula.needs == Needs::Soft && slip == RigSlip::Transverse {
                        continue;
                    }
                    let index = sets.len();
                    sets.push(Planned {
                        name: format!("{} {size} {law} {}", formula.name, word(slip)),
                        formulas: vec![formula.name],
                        size,
                        left_out: index % 3 == 2 && formula.is_listed(),
                        choice: Choice {
                            kind: Kind::Bench,
                            law,
                            slip,
                            soft: formula.needs == Needs::Soft,
                            preloads: formula.needs == Needs::Preloads,
                            coloured: index / 2 % 2 == 1,
                            modes: modes(index, formula.needs == Needs::Modes),
                        },
                        seed: mixed(seed, first + index as u64),
                    });
                }
            }
        }
    }
    sets
}

/// Sets of a wide plan.
const WIDE: usize = 600;
/// … of which one in so many has no effect.
const CLEAN_OF_WIDE: usize = 6;

/// Rigs of any kind ([`Kind::Wide`]), each with one effect of the list in any of its formulas, on any law that can have it, or with none.
#[must_use]
pub fn wide(seed: u64) -> Vec<Planned> {
    let formulas: Vec<&Formula> = [FORMULAS, RIGID_FORMULAS, THIRD_FORMULAS]
        .into_iter()
        .flatten()
        .filter(|formula| formula.is_listed())
        .collect();
    let ids: BTreeSet<&str> = formulas.iter().map(|formula| formula.id()).collect();
    let ids: Vec<&str> = ids.into_iter().collect();
    let set = |index: usize| {
        let first = 5_000_000 + 10 * index as u64;
        let drawn = |what: u64, of: usize| (mixed(seed, first + 1 + what) % of as u64) as usize;
        let formula = (drawn(0, CLEAN_OF_WIDE) > 0).then(|| {
            let id = ids[drawn(1, ids.len())];
            let of_id: Vec<&Formula> = formulas.iter().copied().filter(|f| f.id() == id).collect();
            of_id[drawn(2, of_id.len())]
        });
        // What is not in the law can stand beside any.
        let laws = formula.filter(|formula| formula.is_in_law()).map_or(&LAWS[..], |formula| formula.laws);
        let needs = formula.map_or(Needs::Nothing, |formula| formula.needs);
        let (law, soft) = (laws[drawn(3, laws.len())], needs == Needs::Soft);
        let slip = if soft || drawn(4, 2) == 0 { RigSlip::Rotation } else { RigSlip::Transverse };
        let size = 1 + drawn(5, 2) as u8;
        Planned {
            name: format!("{index} {} {law} {}", formula.map_or("clean", |f| f.name), word(slip)),
            formulas: formula.map(|formula| formula.name).into_iter().collect(),
            size,
            left_out: false,
            choice: Choice {
                kind: Kind::Wide,
                law,
                slip,
                soft,
                preloads: needs == Needs::Preloads || drawn(6, 3) == 0,
                coloured: drawn(7, 3) == 0,
                modes: Modes::Off,
            },
            seed: mixed(seed, first),
        }
    };
    (0..WIDE).map(set).collect()
}

/// Every two effects of the list that can be on one rig, a set each; formulas, size, law, slip and noise are drawn, and the order is.
#[must_use]
pub fn pairs(seed: u64) -> Vec<Planned> {
    let pairs = [FORMULAS, RIGID_FORMULAS].into_iter().flat_map(|formulas| {
        let listed: Vec<&Formula> = formulas.iter().filter(|formula| formula.is_listed()).collect();
        let pair =
            |(k, &first)| listed[k + 1..].iter().map(move |&second| [first, second]).collect::<Vec<_>>();
        listed.iter().enumerate().flat_map(pair).collect::<Vec<_>>()
    });
    // Every number that is drawn of a set has an index of its own.
    let sets = pairs.enumerate().filter_map(|(k, pair)| of_two(pair, 2_000_000 + 10 * k as u64, seed));
    let mut sets: Vec<Planned> = sets.collect();
    sets.sort_by_key(|set| set.seed);
    sets
}

/// A set with two effects; `None` for two formulas of one effect, of which no law can have both, or which no bristle has together: the simulator
/// knows effects of the law in the model's own formulas or all in other ones.
fn of_two(pair: [&Formula; 2], index: u64, seed: u64) -> Option<Planned> {
    let [first, second] = pair;
    let laws: Vec<&str> = first.laws.iter().copied().filter(|law| second.laws.contains(law)).collect();
    let mixed_law =
        pair.iter().all(|formula| formula.is_in_law()) && first.is_foreign() != second.is_foreign();
    if laws.is_empty() || first.id() == second.id() || mixed_law {
        return None;
    }
    let drawn = |what: u64, of: usize| (mixed(seed, index + 1 + what) % of as u64) as usize;
    let law = laws[drawn(0, laws.len())];
    let [soft, preloads, declared] = [Needs::Soft, Needs::Preloads, Needs::Modes]
        .map(|needs| pair.iter().any(|formula| formula.needs == needs));
    let slip = if soft || drawn(1, 2) == 0 { RigSlip::Rotation } else { RigSlip::Transverse };
    let size = 1 + drawn(2, 2) as u8;
    Some(Planned {
        name: format!("{} + {} {size} {law} {}", first.name, second.name, word(slip)),
        formulas: pair.map(|formula| formula.name).to_vec(),
        size,
        left_out: false,
        choice: Choice {
            kind: Kind::Bench,
            law,
            slip,
            soft,
            preloads,
            coloured: drawn(4, 2) == 1,
            modes: modes(drawn(3, 5), declared),
        },
        seed: mixed(seed, index),
    })
}

fn without_effect(seed: u64, index: usize) -> Planned {
    let law = LAWS[index % LAWS.len()];
    let round = index / LAWS.len();
    let slip = if round.is_multiple_of(2) { RigSlip::Rotation } else { RigSlip::Transverse };
    Planned {
        name: format!("clean {index} {law} {}", word(slip)),
        formulas: Vec::new(),
        size: 0,
        left_out: false,
        choice: Choice {
            kind: Kind::Bench,
            law,
            slip,
            soft: false,
            preloads: index % 7 == 6,
            coloured: index / 2 % 2 == 1,
            // Every law meets every kind of modes.
            modes: modes(round / 2, false),
        },
        seed: mixed(seed, 1_000_000 + index as u64),
    }
}

fn word(slip: RigSlip) -> &'static str {
    match slip {
        RigSlip::Rotation => "rotation",
        RigSlip::Transverse => "transverse",
    }
}

/// The kind with a number, where some may have to be declared.
fn modes(index: usize, declared: bool) -> Modes {
    let last = if declared { Modes::Exact } else { Modes::Absent };
    [Modes::Exact, Modes::Off, Modes::Exact, Modes::Off, last][index % 5]
}

/// A seed of its own for every set: the finalising step of SplitMix64 (Steele, Lea and Flood 2014).
fn mixed(seed: u64, index: u64) -> u64 {
    let mut z = seed.wrapping_add((index + 1).wrapping_mul(0x9E37_79B9_7F4A_7C15));
    z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    z ^ (z >> 31)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// As many sets as were asked for, each with its own name, and the same again from the same seed.
    #[test]
    fn the_plan_is_large_enough_and_repeatable() {
        let sets = plan(1, 200);
        let effects = sets.iter().filter(|set| !set.formulas.is_empty()).count();
        assert!(effects >= 400, "{effects} sets with an effect");
        assert_eq!(sets.len() - effects, 200);
        let names: BTreeSet<&str> = sets.iter().map(|set| set.name.as_str()).collect();
        assert_eq!(names.len(), sets.len());
        assert_eq!(sets, plan(1, 200));
        assert_ne!(sets, plan(2, 200));
    }

    /// The clean sets have every law with either slip and every kind of modes.
    #[test]
    fn clean_sets_mix_laws_slips_and_modes() {
        let kinds =
            |set: &Planned| format!("{} {:?} {:?}", set.choice.law, set.choice.slip, set.choice.modes);
        let clean: BTreeSet<String> =
            plan(1, 50).iter().filter(|set| set.formulas.is_empty()).map(kinds).collect();
        assert_eq!(clean.len(), 5 * 2 * 3);
    }

    /// No effect stands beside itself, every other one of the list beside some; the same again from the same seed.
    #[test]
    fn pairs_have_two_effects() {
        let sets = pairs(1);
        let differ = |[a, b]: [&str; 2]| effect_id(a) != effect_id(b);
        assert!(sets.iter().all(|set| <[&str; 2]>::try_from(&set.formulas[..]).is_ok_and(differ)));
        let names: BTreeSet<&str> = sets.iter().map(|set| set.name.as_str()).collect();
        assert_eq!(names.len(), sets.len());
        let formulas = sets.iter().flat_map(|set| &set.formulas);
        let swept: BTreeSet<&str> = formulas.map(|formula| effect_id(formula)).collect();
        assert!(frettrace_explain::effect_ids().all(|known| swept.contains(known)));
        assert_eq!(sets, pairs(1));
    }

    /// The wide plan has every effect, every law with either slip, and clean sets; the same again from the same seed.
    #[test]
    fn the_wide_plan_has_all_of_them() {
        let sets = wide(1);
        assert_eq!(sets, wide(1));
        let swept: BTreeSet<&str> = sets.iter().flat_map(|set| &set.formulas).map(|f| effect_id(f)).collect();
        assert!(frettrace_explain::effect_ids().all(|known| swept.contains(known)));
        let kinds: BTreeSet<String> =
            sets.iter().map(|set| format!("{} {:?}", set.choice.law, set.choice.slip)).collect();
        assert_eq!(kinds.len(), 5 * 2);
        let clean = sets.iter().filter(|set| set.formulas.is_empty()).count();
        assert!((60..140).contains(&clean), "{clean}");
        let names: BTreeSet<&str> = sets.iter().map(|set| set.name.as_str()).collect();
        assert_eq!(names.len(), sets.len());
    }

    /// Third formulas are formulas of effects that the list has, with names of their own; the same again from the same seed.
    #[test]
    fn third_formulas_are_of_the_list() {
        let sets = thirds(1);
        assert_eq!(sets, thirds(1));
        let first: BTreeSet<&str> = FORMULAS.iter().map(|formula| formula.name).collect();
        for set in &sets {
            assert!(set.formulas.iter().all(|formula| !first.contains(formula)), "{}", set.name);
            assert!(first.contains(effect_id(set.formulas[0])), "{}", set.name);
        }
        let names: BTreeSet<&str> = sets.iter().map(|set| set.name.as_str()).collect();
        assert_eq!(names.len(), sets.len());
    }

    /// Every id that `explain` knows is in the sweep.
    #[test]
    fn every_effect_is_swept() {
        for id in frettrace_explain::effect_ids() {
            assert!(FORMULAS.iter().any(|formula| formula.name == id), "{id}");
        }
    }
}
