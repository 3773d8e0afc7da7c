//! Evidence between models fitted to the same data.

/// A fitted model in a comparison.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Candidate<T> {
    /// Which.
    pub name: T,
    /// Bayesian information criterion: smaller is better.
    pub criterion: f64,
    /// Error on what nothing was fitted to.
    pub held_out: f64,
}

/// Models in the order of their evidence.
#[derive(Clone, Debug, PartialEq)]
pub struct Ranking<T> {
    /// Best first.
    pub candidates: Vec<Candidate<T>>,
    /// How many of the first cannot be told from the best: ΔBIC under 10 and held-out errors within 5 %.
    pub alike: usize,
}

/// ΔBIC from which a preference is strong (Kass and Raftery 1995: posterior odds above 150).
pub const STRONG: f64 = 10.0;

/// Orders candidates by their criterion; those without one (not finite) come last.
#[must_use]
pub fn rank<T: Copy>(mut candidates: Vec<Candidate<T>>) -> Ranking<T> {
    candidates.sort_by(|a, b| a.criterion.total_cmp(&b.criterion));
    let alike = match candidates.first() {
        None => 0,
        Some(best) => candidates
            .iter()
            .take_while(|c| c.criterion - best.criterion < STRONG && c.held_out < 1.05 * best.held_out)
            .count()
            .max(1),
    };
    Ranking { candidates, alike }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn close_criteria_are_not_told_apart() {
        let candidate = |name, criterion, held_out| Candidate { name, criterion, held_out };
        let ranking =
            rank(vec![candidate('b', 13.0, 1.02), candidate('a', 10.0, 1.0), candidate('c', 25.0, 1.0)]);
        assert_eq!((ranking.candidates[0].name, ranking.alike), ('a', 2));
        let ranking = rank(vec![candidate('a', 10.0, 1.0), candidate('b', 13.0, 1.2)]);
        assert_eq!(ranking.alike, 1, "the held-out error tells them apart");
    }
}
