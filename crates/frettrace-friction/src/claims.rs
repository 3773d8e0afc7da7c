//! What the laws promise, and are held to by the conformance tests.

use crate::Law;

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
}

impl Claims {
    /// Passive, and nothing else.
    const NONE: Claims = Claims { passive: true, rate_independent: false, masing: false, bounded: false };
}

impl Law {
    /// What the law promises; the conformance tests hold it to it.
    pub fn claims(self) -> Claims {
        let memoryless = Claims { bounded: true, ..Claims::NONE };
        let masing = Claims { rate_independent: true, masing: true, bounded: true, ..Claims::NONE };
        match self {
            Law::Coulomb | Law::Jenkins | Law::Iwan | Law::MaxwellSlip | Law::CattaneoMindlin => masing,
            Law::Dahl | Law::BoucWen => Claims { masing: false, ..masing },
            Law::RegularisedCoulomb(_) | Law::Vlfm | Law::Sdfm => memoryless,
            Law::Fbfm => Claims { passive: false, ..memoryless },
            Law::Stribeck | Law::Lugre | Law::Hybrid | Law::ElastoPlastic | Law::Gms => Claims::NONE,
            Law::FilmStribeck | Law::FilmLugre => Claims::NONE,
        }
    }
}
