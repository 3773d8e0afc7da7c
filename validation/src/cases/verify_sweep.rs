//! What became of the simulated rigs of a sweep: the stored answers, counted, and some of them asked again.

use super::stored;
use crate::case::{Case, Outcome, Row};
use crate::sweep::judged::{Judged, Worth, judge};
use crate::sweep::plan::{Planned, plan};
use crate::sweep::tables::{Counts, detection};
use crate::sweep::{self, CLEAN, SEED};
use rayon::prelude::*;

/// The case.
pub const CASE: Case = Case { name: "verify_sweep", run };

/// Sets that are made and asked again, …
const AGAIN: usize = 4;
/// … of those whose answer took less than this (s), and their simulation mostly little more.
const QUICK: f64 = 1.0;
/// Of the sets that were answered wrong once those are asked again whose answer took less than this (s).
const SOON: f64 = 30.0;

fn run() -> anyhow::Result<Outcome> {
    let sets: Vec<Judged> = stored("verify_sweep/sweep.jsonl")?;
    let mut rows = counted(&Counts::of(&sets));
    for ([low, high], count, found) in detection(&sets) {
        rows.push(reported(format!("detected, error without it {low} to {high} of the noise"), found, count));
    }
    rows.extend(of_fresh(&Counts::of(&stored("verify_sweep/fresh.jsonl")?)));
    rows.extend(of_two(&Counts::of(&stored("verify_sweep/pairs.jsonl")?)));
    rows.extend(of_thirds(&Counts::of(&stored("verify_sweep/thirds.jsonl")?)));
    rows.push(again(&sets));
    rows.extend(mended()?);
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

/// Of sets that were asked once, before anything was mended that they showed.
fn of_fresh(c: &Counts) -> Vec<Row> {
    let once = |row: Row| Row { quantity: format!("asked once: {}", row.quantity), ..row };
    counted(c).into_iter().map(once).collect()
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

/// What was wrong once: the stored answers of all of it, and those of the quickest sets, made and asked again.
fn mended() -> anyhow::Result<[Row; 2]> {
    let planned = sweep::mended::mended()?;
    let stored: Vec<Judged> = stored("verify_sweep/mended.jsonl")?;
    let answer = |set: &Planned| stored.iter().find(|answer| answer.name == set.name);
    let all = planned.iter().filter_map(answer).filter(|answer| answer.worth() == Worth::Right).count();
    let is_asked = |set: &&Planned| answer(set).is_some_and(|answer| quickest(&stored, answer));
    let asked: Vec<&Planned> = planned.iter().filter(is_asked).collect();
    let again = asked.par_iter().filter(|set| judge(set, None, || {}).worth() == Worth::Right).count();
    let row = |quantity: &str, part, whole| Row {
        expected: Some(1.0),
        tolerance: 0.0,
        source: "the truth of the simulated rigs",
        reason: "answered wrong once",
        ..reported(quantity.to_owned(), part, whole)
    };
    Ok([
        row("answered wrong once: right", all, planned.len()),
        row("answered wrong once, asked again: right", again, asked.len()),
    ])
}

/// Whether an answer came soon, and none with the same effects sooner: all of them would take a third of an hour.
fn quickest(stored: &[Judged], answer: &Judged) -> bool {
    let same = |other: &&Judged| (&other.effect, &other.second) == (&answer.effect, &answer.second);
    answer.seconds < SOON && stored.iter().filter(same).all(|other| answer.seconds <= other.seconds)
}
