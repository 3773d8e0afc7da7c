//! What the laws promise, each in its file, and are held to by the conformance tests.

/// What a law promises under constant normal force.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Claims {
    /// No closed cycle gives energy.
    pub passive: bool,
    /// The force depends on the path of the slip, not on its speed.
    pub rate_independent: bool,
    /// Branches are the virgin curve magnified twice, and loops close.
    pub masing: bool,
    /// The force never exceeds the normal force times the largest friction coefficient.
    pub bounded: bool,
    /// The force jumps along a smooth motion, by a rule from sample to sample: first order in the step, in the mean, where the
    /// others are second order.
    pub jumps: bool,
}

impl Claims {
    /// Passive, and nothing else.
    pub(crate) const PASSIVE: Claims =
        Claims { passive: true, rate_independent: false, masing: false, bounded: false, jumps: false };
    /// Passive and bounded.
    pub(crate) const BOUNDED: Claims = Claims { bounded: true, ..Claims::PASSIVE };
    /// All but Masing's rule.
    pub(crate) const RATE_INDEPENDENT: Claims = Claims { rate_independent: true, ..Claims::BOUNDED };
    /// All of it.
    pub(crate) const MASING: Claims = Claims { masing: true, ..Claims::RATE_INDEPENDENT };
}
