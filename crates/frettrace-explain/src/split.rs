//! Which runs are fitted, and which are held out.

use crate::Case;

/// Which runs are held out.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Split {
    /// What an explanation begins with.
    First,
    /// Others than in the first: where those contradict what was fitted.
    Second,
    /// A single one: where the others contradict it too.
    One,
}

impl Split {
    /// Which of the runs, ranked by level, are held out: the second highest and, of six or more, an interior one; each the next lower
    /// one; one in the middle. Three runs or fewer are all fitted.
    pub(crate) fn held_out(self, ranked: &[usize]) -> Vec<usize> {
        let n = ranked.len();
        let places = match (self, n) {
            (_, 0..=3) => Vec::new(),
            (Self::First, 4 | 5) => vec![n - 2],
            (Self::First, _) => vec![n / 2 - 1, n - 2],
            (Self::Second, 4 | 5) => vec![n - 3],
            (Self::Second, _) => vec![n / 2 - 2, n - 3],
            (Self::One, _) => vec![n / 2],
        };
        places.into_iter().map(|place| ranked[place]).collect()
    }
}

/// The runs by level, the lowest first.
pub(crate) fn by_level(case: &Case, runs: &[usize]) -> Vec<usize> {
    let level = |k: usize| case.records[k].power.iter().sum::<f64>();
    let mut ranked = runs.to_vec();
    ranked.sort_by(|&a, &b| level(a).total_cmp(&level(b)));
    ranked
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The first two splits have no run in common, and the highest level is always fitted, so that none is extrapolated; nor is the lowest of
    /// six or more.
    #[test]
    fn splits_hold_out_other_runs() {
        for n in 4..12 {
            let ranked: Vec<usize> = (0..n).map(|k| 10 + k).collect();
            let [first, second, one] =
                [Split::First, Split::Second, Split::One].map(|split| split.held_out(&ranked));
            assert_eq!([first.len(), second.len(), one.len()], if n < 6 { [1, 1, 1] } else { [2, 2, 1] });
            assert!(first.iter().all(|run| !second.contains(run)), "{n}");
            let all = || first.iter().chain(&second).chain(&one);
            assert!(all().all(|run| *run < 10 + n - 1), "{n}");
            assert!(n < 6 || all().all(|run| *run > 10), "{n}");
        }
        assert_eq!(Split::First.held_out(&[1, 2, 3]), []);
    }
}
