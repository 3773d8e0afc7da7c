//! Counts over the finished sets.

use super::judged::{Judged, Worth};
use std::collections::{BTreeMap, BTreeSet};

/// Counts of a sweep.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Counts {
    /// Sets that count: clean, or with an effect that stands out.
    pub sets: usize,
    /// Sets with an effect whose name is in the list.
    pub named: usize,
    /// Of these: right, right through a class, a wrong name, missed, unexplained.
    pub right: usize,
    /// See `right`.
    pub class: usize,
    /// Of two effects one, and no other name.
    pub half: usize,
    /// See `right`.
    pub wrong: usize,
    /// See `right`.
    pub missed: usize,
    /// See `right`.
    pub unexplained: usize,
    /// Sets whose effect has no name in the list.
    pub nameless: usize,
    /// Of these: unexplained with the right place.
    pub placed: usize,
    /// Of these: given a name.
    pub misnamed: usize,
    /// Clean sets.
    pub clean: usize,
    /// Of these: an effect named.
    pub false_alarms: usize,
    /// Of these: called unexplained.
    pub false_unexplained: usize,
    /// Sets without an answer.
    pub failed: usize,
    /// Sets that could not be made, in no other count.
    pub unmade: usize,
    /// Intervals of an effect's size that can be compared, and those that hold the truth.
    pub sizes: [usize; 2],
    /// Sets named right in which the error left is at most 1.2 noise floors.
    pub complete: usize,
}

impl Counts {
    /// Counts finished sets.
    #[must_use]
    pub fn of(sets: &[Judged]) -> Self {
        let mut counts = Self::default();
        for set in sets.iter().filter(|set| set.counts() || set.failure.is_some()) {
            counts.add(set);
        }
        counts
    }

    fn add(&mut self, set: &Judged) {
        if set.unmade {
            self.unmade += 1;
            return;
        }
        let worth = set.worth();
        self.sets += 1;
        if worth == Worth::Failed {
            self.failed += 1;
        } else if set.effect.is_none() {
            self.clean += 1;
            self.false_alarms += usize::from(worth == Worth::Wrong);
            self.false_unexplained += usize::from(worth == Worth::Unexplained);
        } else if set.nameless() {
            self.nameless += 1;
            self.placed += usize::from(worth == Worth::Right);
            self.misnamed += usize::from(worth == Worth::Wrong);
        } else {
            self.named += 1;
            let counter = match worth {
                Worth::Right => &mut self.right,
                Worth::Class => &mut self.class,
                Worth::Half => &mut self.half,
                Worth::Wrong => &mut self.wrong,
                Worth::Missed => &mut self.missed,
                Worth::Unexplained | Worth::Failed => &mut self.unexplained,
            };
            *counter += 1;
            self.complete += usize::from(worth <= Worth::Class && set.over_floor[1] <= 1.2);
            self.sizes[0] += usize::from(set.size_inside.is_some());
            self.sizes[1] += usize::from(set.size_inside == Some(true));
        }
    }
}

/// Edges of the bins of visibility in the detection curve.
const EDGES: [f64; 6] = [1.0, 1.3, 2.0, 5.0, 20.0, f64::INFINITY];

/// The detection curve: for each bin of error over noise floor (true parameters, without the effect) its edges, the sets whose
/// effect has a name, and those of them whose name is found (alone or in a class).
#[must_use]
pub fn detection(sets: &[Judged]) -> Vec<([f64; 2], usize, usize)> {
    let listed: Vec<&Judged> =
        sets.iter().filter(|set| set.effect.is_some() && !set.nameless() && set.failure.is_none()).collect();
    let bin = |pair: &[f64]| {
        let inside = listed.iter().filter(|set| (pair[0]..pair[1]).contains(&set.visible));
        let (count, found) =
            inside.fold((0, 0), |(n, f), set| (n + 1, f + usize::from(set.worth() <= Worth::Class)));
        ([pair[0], pair[1]], count, found)
    };
    EDGES.windows(2).map(bin).collect()
}

/// The sweep in Markdown: counts, confusion, detection.
#[must_use]
pub fn markdown(title: &str, sets: &[Judged]) -> String {
    let c = Counts::of(sets);
    let share = |part: usize, whole: usize| format!("{part} of {whole}");
    let mut text = format!("# {title}\n\n| what | found |\n|---|---|\n");
    for (what, found) in [
        ("sets that count", c.sets.to_string()),
        ("the right name", share(c.right, c.named)),
        ("the right name or its class", share(c.right + c.class, c.named)),
        ("of two effects one", share(c.half, c.named)),
        ("a wrong name", share(c.wrong, c.named)),
        ("nothing missing although something is", share(c.missed, c.named)),
        ("unexplained although the name is in the list", share(c.unexplained, c.named)),
        ("named, and error left at most 1.2 noise floors", share(c.complete, c.right + c.class)),
        ("interval of the size holds the truth", share(c.sizes[1], c.sizes[0])),
        ("name not in the list: unexplained with the right place", share(c.placed, c.nameless)),
        ("name not in the list: a wrong name", share(c.misnamed, c.nameless)),
        ("false alarms on clean sets", share(c.false_alarms, c.clean)),
        ("clean sets called unexplained", share(c.false_unexplained, c.clean)),
        ("no answer", c.failed.to_string()),
        ("sets that could not be made, not counted", c.unmade.to_string()),
    ] {
        text += &format!("| {what} | {found} |\n");
    }
    text += "\n## How large must an effect be?\n\n| error over noise floor without it | sets | name found |\n|---|---|---|\n";
    for ([low, high], count, found) in detection(sets) {
        text += &format!("| {low} to {high} | {count} | {found} |\n");
    }
    text + "\n## What was answered\n\n" + &confusion(sets)
}

/// One row an effect: how often which answer.
fn confusion(sets: &[Judged]) -> String {
    let mut rows: BTreeMap<(String, bool), BTreeMap<String, usize>> = BTreeMap::new();
    for set in sets.iter().filter(|set| set.counts()) {
        let effects: Vec<&str> = set.effect.iter().chain(&set.second).map(String::as_str).collect();
        let truth = if effects.is_empty() { "(clean)".to_owned() } else { effects.join(" + ") };
        *rows.entry((truth, set.left_out)).or_default().entry(answer(set)).or_default() += 1;
    }
    let mut text = String::from("| truth | answers |\n|---|---|\n");
    for ((truth, left_out), answers) in rows {
        let mut answers: Vec<(String, usize)> = answers.into_iter().collect();
        answers.sort_by_key(|(_, count)| std::cmp::Reverse(*count));
        let list: Vec<String> = answers.iter().map(|(answer, count)| format!("{count} × {answer}")).collect();
        let note = if left_out { ", left out of the list" } else { "" };
        text += &format!("| {truth}{note} | {} |\n", list.join(", "));
    }
    text
}

fn answer(set: &Judged) -> String {
    use frettrace::results::Verdict;
    match set.verdict {
        None => "no answer".to_owned(),
        Some(Verdict::NothingMissing) => "nothing missing".to_owned(),
        Some(Verdict::Unexplained) if set.named.is_empty() => {
            let place = set.place.map_or("nowhere".to_owned(), |place| format!("{place:?}").to_lowercase());
            format!("unexplained: {place}")
        }
        _ => {
            let ids: BTreeSet<&str> =
                set.named.iter().filter_map(|c| c.first()).map(String::as_str).collect();
            let in_class = set.worth() == Worth::Class;
            ids.into_iter().collect::<Vec<_>>().join(" + ") + if in_class { " (class)" } else { "" }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use frettrace::results::Verdict;

    fn set(effect: Option<&str>, verdict: Verdict, named: &[&str], visible: f64) -> Judged {
        Judged {
            effect: effect.map(str::to_owned),
            verdict: Some(verdict),
            named: named.iter().map(|id| vec![(*id).to_owned()]).collect(),
            visible,
            ..Judged::default()
        }
    }

    /// A sweep of five sets counted by hand.
    #[test]
    fn a_small_sweep_is_counted() {
        let sets = [
            set(None, Verdict::NothingMissing, &[], 1.0),
            set(None, Verdict::Explained, &["friction.wear"], 1.0),
            set(Some("friction.wear"), Verdict::Explained, &["friction.wear"], 3.0),
            set(Some("friction.film"), Verdict::Explained, &["friction.wear"], 30.0),
            set(Some("friction.lag"), Verdict::NothingMissing, &[], 1.2),
        ];
        let counts = Counts::of(&sets);
        // The last stands less than 1.3 out of the noise and does not count.
        assert_eq!((counts.sets, counts.clean, counts.false_alarms), (4, 2, 1));
        assert_eq!((counts.named, counts.right, counts.wrong, counts.missed), (2, 1, 1, 0));
        let found: Vec<[usize; 2]> = detection(&sets).iter().map(|(_, n, f)| [*n, *f]).collect();
        assert_eq!(found, [[1, 0], [0, 0], [1, 1], [0, 0], [1, 0]]);
        assert!(markdown("Sweep", &sets).contains("| friction.film | 1 × friction.wear |"));
    }
}
