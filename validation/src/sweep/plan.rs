//! The plan: which sets a sweep has, from its seed alone.

use super::rigs::{Choice, Modes, RIGID};
use frettrace::rig::RigSlip;

/// A planned set.
#[derive(Clone, Debug, PartialEq)]
pub struct Planned {
    /// Name, unique in the plan.
    pub name: String,
    /// Formula of the effect as RIG.toml writes it; `None` for a clean set.
    pub formula: Option<&'static str>,
    /// Size of the effect, 1 or 2.
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

/// Laws of the clean sets.
const LAWS: [&str; 5] = ["dahl", "hybrid", "lugre", "coulomb", "stribeck"];

/// Every formula × two sizes × its laws × rotation and transverse, every third without its name in the list, and `clean` sets
/// without effect. Noise and modes alternate. The order is drawn, so that any beginning of the plan is a fair sample of it.
#[must_use]
pub fn plan(seed: u64, clean: usize) -> Vec<Planned> {
    let mut sets = with_effects(seed);
    sets.extend((0..clean).map(|index| without_effect(seed, index)));
    sets.sort_by_key(|set| set.seed);
    sets
}

fn with_effects(seed: u64) -> Vec<Planned> {
    let mut sets = Vec::new();
    for formula in FORMULAS.iter().chain(RIGID_FORMULAS) {
        for size in [1, 2] {
            for &law in formula.laws {
                for slip in [RigSlip::Rotation, RigSlip::Transverse] {
                    if formula.needs == Needs::Soft && slip == RigSlip::Transverse {
                        continue;
                    }
                    let index = sets.len();
                    let unnamed = formula.name.starts_with("unlisted:");
                    sets.push(Planned {
                        name: format!("{} {size} {law} {}", formula.name, word(slip)),
                        formula: Some(formula.name),
                        size,
                        left_out: index % 3 == 2 && !unnamed,
                        choice: Choice {
                            law,
                            slip,
                            soft: formula.needs == Needs::Soft,
                            preloads: formula.needs == Needs::Preloads,
                            coloured: index / 2 % 2 == 1,
                            modes: match modes(index) {
                                Modes::Absent if formula.needs == Needs::Modes => Modes::Exact,
                                modes => modes,
                            },
                        },
                        seed: mixed(seed, index as u64),
                    });
                }
            }
        }
    }
    sets
}

fn without_effect(seed: u64, index: usize) -> Planned {
    let law = LAWS[index % LAWS.len()];
    let round = index / LAWS.len();
    let slip = if round.is_multiple_of(2) { RigSlip::Rotation } else { RigSlip::Transverse };
    Planned {
        name: format!("clean {index} {law} {}", word(slip)),
        formula: None,
        size: 0,
        left_out: false,
        choice: Choice {
            law,
            slip,
            soft: false,
            preloads: index % 7 == 6,
            coloured: index / 2 % 2 == 1,
            // Every law meets every kind of modes.
            modes: modes(round / 2),
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

fn modes(index: usize) -> Modes {
    [Modes::Exact, Modes::Off, Modes::Exact, Modes::Off, Modes::Absent][index % 5]
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
    use std::collections::BTreeSet;

    /// As many sets as were asked for, each with its own name, and the same again from the same seed.
    #[test]
    fn the_plan_is_large_enough_and_repeatable() {
        let sets = plan(1, 200);
        let effects = sets.iter().filter(|set| set.formula.is_some()).count();
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
            plan(1, 50).iter().filter(|set| set.formula.is_none()).map(kinds).collect();
        assert_eq!(clean.len(), 5 * 2 * 3);
    }

    /// Every id that `explain` knows is in the sweep.
    #[test]
    fn every_effect_is_swept() {
        for id in frettrace_explain::effect_ids() {
            assert!(FORMULAS.iter().any(|formula| formula.name == id), "{id}");
        }
    }
}
