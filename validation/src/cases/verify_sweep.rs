//! What became of the simulated rigs of a sweep: the stored answers, counted, and some of them asked again.

use super::stored;
use crate::case::{Case, Outcome, Row};
use crate::sweep::judged::{Judged, Worth, judge};
use crate::sweep::plan::{Planned, pairs, plan, thirds};
use crate::sweep::tables::{Counts, detection};
use crate::sweep::{CLEAN, SEED};
use rayon::prelude::*;

/// The case.
pub const CASE: Case = Case { name: "verify_sweep", run };

/// Sets that are made and asked again, …
const AGAIN: usize = 4;
/// … of those whose answer took less than this (s), and their simulation mostly little more.
const QUICK: f64 = 1.0;
/// Sets of any seed that were answered wrong once, and one whose right name leaves the most beside the noise: declared law in another
/// valley (a film was named), two stand-ins for what is not in the list, dampings far from their start, a film for a Stribeck curve with another
/// formula, a drift whose settling form was not asked, a formula behind three starts of another, a law far from the contacts; runs without a period
/// whose law was bent to what it lacks, damping by another power than two, the same within the noise of all samples, and a weak one for which friction stood in; a modulation that the
/// weakest runs hide, a name given up for a law that missed the runs held out, a rigid contact that chatters; a hum beside a third of the excitation,
/// lines near half the sampling rate of a channel that clips, a lag of which a film stood in the way; a second support in a contact that slides
/// sideways, a frequency whose deviation no error shows, a grid that was made finer once where twice was needed, a law bent by a resonance, a cube that dampings had
/// taken up, one that yields, a support that rubs, a damping that a coarse grid bent, a bent reading whose mean hid a structure that was off; friction along the
/// path with another formula, twice, in runs without a period that rest elsewhere, and a lag on its way that a film was ahead of; two contacts
/// that snap, and a wear whose course the runs held out had to tell; modulations of the preload that the mean of a bristle carries, twice, and one without a
/// line in the quietest run; a stop that only a run without a period reaches, one whose gap was held to where recovered runs rest, a support whose
/// curve four terms carry from where two have come to, and a wear that the fitted runs did not tell from an ageing; a play whose formula a lag mended that was
/// none, a damping that the phase grid bent, a film that foretold what an ageing did not, and a contact that sticks and slips over four periods.
const MENDED: [(u64, &str); 79] = [
    (251, "clean 2 lugre rotation"),
    (251, "structure.quadratic-damping 1 hybrid transverse"),
    (251, "unlisted:structure/even-stiffness 1 dahl transverse"),
    (251, "friction.asymmetry/smooth 1 hybrid rotation"),
    (241, "structure.quadratic-damping/power 2 hybrid rotation"),
    (261, "friction.stribeck/rational 1 dahl rotation"),
    (261, "structure.frequency-drift/settling 1 hybrid rotation"),
    (261, "friction.ageing/saturating 1 dahl transverse"),
    (261, "contact.backlash 1 lugre transverse"),
    (261, "contact.backlash/gradual 1 dahl transverse"),
    (261, "structure.quadratic-damping/power 1 dahl rotation"),
    (261, "structure.quadratic-damping/power 1 hybrid transverse"),
    (261, "structure.modal-damping 1 dahl transverse"),
    (261, "excitation.preload-modulation 1 dahl rotation"),
    (261, "friction.lag 1 lugre rotation"),
    (261, "clean 39 stribeck transverse"),
    (261, "measurement.hum 2 dahl rotation"),
    (261, "measurement.clipping 1 hybrid transverse"),
    (261, "friction.lag/saturating 1 hybrid transverse"),
    (261, "structure.second-support/round 2 hybrid transverse"),
    (301, "structure.second-support 1 hybrid transverse"),
    (301, "excitation.preload-modulation 1 hybrid transverse"),
    (301, "measurement.dropout/hold 2 dahl rotation"),
    (301, "measurement.position 2 dahl transverse"),
    (301, "measurement.hum/third-harmonic 1 hybrid rotation"),
    (301, "measurement.clipping/soft 2 hybrid rotation"),
    (301, "friction.lag 2 lugre transverse"),
    (261, "structure.second-support/rubbing 2 dahl rotation"),
    (261, "clean 22 lugre rotation"),
    (301, "structure.modal-frequency 1 hybrid rotation"),
    (302, "friction.asymmetry 2 hybrid rotation"),
    (302, "structure.modal-damping 2 hybrid rotation"),
    (302, "structure.cubic-stiffness 2 dahl transverse"),
    (302, "structure.cubic-stiffness/yielding 2 dahl rotation"),
    (302, "measurement.clipping/soft 1 hybrid transverse"),
    (303, "structure.frequency-drift/settling 1 dahl rotation"),
    (303, "clean 27 lugre transverse"),
    (303, "clean 53 coulomb rotation"),
    (303, "clean 99 stribeck transverse"),
    (303, "friction.position-periodic/triangle 1 hybrid transverse"),
    (303, "measurement.clipping/soft 2 hybrid transverse"),
    (304, "structure.frequency-drift/settling 1 dahl rotation"),
    (304, "structure.frequency-drift/settling 1 hybrid transverse"),
    (305, "structure.modal-frequency 1 hybrid transverse"),
    (305, "friction.position-periodic 1 hybrid transverse"),
    (305, "friction.breakaway/straight 2 lugre transverse"),
    (261, "friction.position/saturating 2 hybrid transverse"),
    (306, "friction.position/saturating 2 hybrid transverse"),
    (306, "friction.lag/saturating 2 hybrid transverse"),
    (306, "measurement.delay/low-pass 1 hybrid rotation"),
    (307, "measurement.clipping/soft 2 hybrid rotation"),
    (307, "friction.wear/settling 2 hybrid rotation"),
    (302, "excitation.preload-modulation 2 hybrid rotation"),
    (308, "excitation.preload-modulation 2 hybrid transverse"),
    (309, "excitation.preload-modulation/square 2 dahl rotation"),
    (310, "structure.second-support/round 2 hybrid transverse"),
    (311, "excitation.preload-modulation 2 hybrid transverse"),
    (313, "structure.second-support 2 dahl transverse"),
    (313, "contact.normal-stiffening/exponential 2 dahl rotation"),
    (313, "friction.wear/settling 2 hybrid rotation"),
    (314, "measurement.gain 2 coulomb transverse"),
    (314, "measurement.position 1 stribeck transverse"),
    (314, "friction.wear 2 hybrid transverse"),
    (314, "contact.backlash 1 dahl transverse"),
    (315, "measurement.dropout 2 stribeck transverse"),
    (313, "friction.lag/saturating 1 lugre rotation"),
    (315, "friction.wear/settling 1 hybrid rotation"),
    (315, "structure.modal-damping 1 dahl rotation"),
    (313, "contact.tangential-stiffness/parallel 1 lugre rotation"),
    (314, "structure.cubic-stiffness 2 dahl transverse"),
    (314, "friction.viscous 1 coulomb rotation"),
    (315, "structure.cubic-stiffness 1 hybrid transverse"),
    (316, "friction.film/rational 1 dahl rotation"),
    (316, "measurement.clipping 2 hybrid rotation"),
    (316, "contact.backlash/gradual 1 lugre rotation"),
    (317, "clean 82 lugre rotation"),
    (317, "friction.film/rational 1 dahl rotation"),
    (318, "structure.cubic-stiffness 2 dahl transverse"),
    (318, "clean 19 stribeck transverse"),
];

/// The same with two effects: a structure that the first one's fit had bent, a run that told of friction alone and was set aside, and two that
/// neither one alone led to.
const MENDED_PAIRS: [(u64, &str); 3] = [
    (403, "friction.stribeck + friction.presliding-damping 1 dahl transverse"),
    (403, "friction.viscous + measurement.delay 2 coulomb transverse"),
    (403, "friction.viscous/power + friction.position-periodic/triangle 2 dahl transverse"),
];

/// The same with third formulas: a viscous force that thins, a channel of two stages, a damping that fades slowly, a curve that is straight, a spring
/// on the beam that hardens less and less, stops that touch softly, a preload that rises faster than it falls, grooves across the path.
const MENDED_THIRDS: [(u64, &str); 11] = [
    (501, "friction.viscous/eyring 1 dahl rotation"),
    (501, "friction.viscous/eyring 2 dahl transverse"),
    (502, "measurement.delay/two-low-passes 1 dahl transverse"),
    (502, "measurement.delay/two-low-passes 2 dahl rotation"),
    (503, "friction.presliding-damping/exponential 1 dahl rotation"),
    (503, "friction.stribeck/straight 1 dahl rotation"),
    (503, "structure.cubic-stiffness/hyperbolic 2 dahl rotation"),
    (504, "structure.second-support/smooth 2 dahl transverse"),
    (504, "structure.second-support/smooth 2 hybrid transverse"),
    (504, "excitation.preload-modulation/skewed 2 dahl transverse"),
    (504, "friction.position-periodic/square 1 dahl transverse"),
];

fn run() -> anyhow::Result<Outcome> {
    let sets: Vec<Judged> = stored("verify_sweep/sweep.jsonl")?;
    let mut rows = counted(&Counts::of(&sets));
    for ([low, high], count, found) in detection(&sets) {
        rows.push(reported(format!("detected, error without it {low} to {high} of the noise"), found, count));
    }
    rows.extend(of_two(&Counts::of(&stored("verify_sweep/pairs.jsonl")?)));
    rows.extend(of_thirds(&Counts::of(&stored("verify_sweep/thirds.jsonl")?)));
    rows.push(again(&sets));
    rows.push(mended());
    Ok(Outcome::Ran(rows))
}

fn counted(c: &Counts) -> Vec<Row> {
    let some = |quantity: &str, part, whole| reported(quantity.to_owned(), part, whole);
    vec![
        some("sets that were made and answered", c.sets - c.failed, c.sets),
        some("clean: an effect named (target 0)", c.false_alarms, c.clean),
        some("clean: called unexplained", c.false_unexplained, c.clean),
        some("listed: the right name (target 0.95)", c.right, c.named),
        some("listed: the right name or its class", c.right + c.class, c.named),
        some("listed: a wrong name (target 0.02)", c.wrong, c.named),
        some("listed: nothing missing", c.missed, c.named),
        some("listed: unexplained", c.unexplained, c.named),
        some("named right: error left at most 1.2 of the noise", c.complete, c.right + c.class),
        some("named right: the interval of the size holds it", c.sizes[1], c.sizes[0]),
        some("not in the list: unexplained, the right place", c.placed, c.nameless),
        some("not in the list: a wrong name (target 0.02)", c.misnamed, c.nameless),
    ]
}

/// Of sets with two effects that are both seen.
fn of_two(c: &Counts) -> Vec<Row> {
    let some = |quantity: &str, part| reported(format!("two effects: {quantity}"), part, c.named);
    vec![
        some("both names (target 0.95)", c.right),
        some("both names or their classes", c.right + c.class),
        some("one of two, and no other name", c.half),
        some("a wrong name (target 0.02)", c.wrong),
        some("unexplained", c.unexplained),
    ]
}

/// Of sets whose effect is in the list and has a third formula.
fn of_thirds(c: &Counts) -> Vec<Row> {
    let some = |quantity: &str, part, whole| reported(format!("third formulas: {quantity}"), part, whole);
    vec![
        some("the right name or its class (target 0.95)", c.right + c.class, c.named),
        some("a wrong name (target 0.02)", c.wrong, c.named),
        some("unexplained", c.unexplained, c.named),
        some("nothing missing", c.missed, c.named),
        some("not in the list: unexplained, the right place", c.placed, c.nameless),
    ]
}

/// A share that has no expected value: its target is in its name, and whether it is met is for the reader.
fn reported(quantity: String, part: usize, whole: usize) -> Row {
    Row {
        quantity: format!("{quantity}, of {whole}"),
        unit: "1",
        source: "the plan of the seed",
        expected: None,
        found: part as f64 / whole.max(1) as f64,
        tolerance: 0.02,
        reason: "counted, not measured",
    }
}

/// The quick ones among the first sets, asked again: a file that another program wrote tells nothing of this one.
fn again(sets: &[Judged]) -> Row {
    let plan = plan(SEED, CLEAN);
    let quick = sets.iter().filter(|set| set.verdict.is_some() && set.seconds < QUICK);
    let known = |set: &Judged| plan.iter().find(|planned| planned.name == set.name).cloned();
    let asked: Vec<(&Judged, Option<Planned>)> = quick.take(AGAIN).map(|set| (set, known(set))).collect();
    let same = |(set, planned): &&(&Judged, Option<Planned>)| {
        let now = planned.as_ref().map(|planned| judge(planned, None, || {}));
        now.is_some_and(|now| now.verdict == set.verdict && now.named == set.named && now.place == set.place)
    };
    let same = asked.par_iter().filter(same).count();
    Row {
        expected: Some(1.0),
        tolerance: 0.0,
        source: "the same sets, made and asked again",
        reason: "the same program on the same samples",
        ..reported("asked again: the stored answer".into(), same, asked.len())
    }
}

/// What was wrong once, made and asked again.
fn mended() -> Row {
    let right = |(plan, name): &(Vec<Planned>, &str)| {
        let planned = plan.iter().find(|planned| planned.name == *name);
        planned.is_some_and(|planned| judge(planned, None, || {}).worth() == Worth::Right)
    };
    let singles = MENDED.par_iter().map(|&(seed, name)| (plan(seed, CLEAN), name));
    let of_two = MENDED_PAIRS.par_iter().map(|&(seed, name)| (pairs(seed), name));
    let of_thirds = MENDED_THIRDS.par_iter().map(|&(seed, name)| (thirds(seed), name));
    let right = singles.chain(of_two).chain(of_thirds).filter(right).count();
    let count = MENDED.len() + MENDED_PAIRS.len() + MENDED_THIRDS.len();
    Row {
        expected: Some(1.0),
        tolerance: 0.0,
        source: "the truth of the simulated rigs",
        reason: "answered wrong once",
        ..reported("answered wrong once: right".into(), right, count)
    }
}
