//! Where an open balance is open: at a sensor, in the excitation, at the contact or in the structure.

use super::{CALIBRATED, Located, NEAR, is_of_support, with_further};
use crate::effects::EffectPlace;
use crate::force_laws::{History, driven, linear, nameless, regress, shapes};
use crate::verdict::BALANCE_CLOSED;
use crate::{Study, Unknown};
use frettrace_forward::accelerations::{Balance, Beside, PortPlace, Setting};
use num_complex::Complex64;
use rayon::prelude::*;

/// The exciter's own place competes with any other by its χ² times this: a refined place is always a little better.
const EXCITER: f64 = 0.9;
/// Share of a further force's χ² that may be left where it is told by the excitation or by the motion, …
const DEAF: f64 = 0.05;
/// … χ² a value, over that of the balance beside the force, that may be left in any case, …
const DEAF_NOISE: f64 = 1.5;
/// … what that leaves beside the noise over what the other of the two leaves, …
const DEAF_RIVAL: f64 = 0.5;
/// … and runs it takes to tell.
const DEAF_RUNS: usize = 3;
/// What closes an open balance best that is told beside a structure of its own.
const NEAREST: usize = 4;
/// Share of the next one's χ² below which what closes an open balance best stands out.
const STANDS_OUT: f64 = 0.5;

/// χ² of a recovered force.
struct Asks {
    /// All of it, …
    all: f64,
    /// … what is left where it is the same beside the excitation's phase in all runs, or in proportion to the excitation, …
    driven: f64,
    /// … and what is left of the best law of the motion.
    lawful: f64,
    /// Real values that these are sums over.
    count: f64,
    /// χ² per degree of freedom of the balance beside the force: where that is off by more than the noise, so is the force.
    reduced: f64,
}

impl Asks {
    fn told(&self, left: f64, other: f64) -> bool {
        let over = |chi: f64| (chi - self.count).max(0.0);
        let told = left < DEAF * self.all || left < DEAF_NOISE * self.reduced * self.count;
        told && over(left) < DEAF_RIVAL * over(other)
    }

    /// Whether it does not ask what the structure does: no law of motion describes it as well as the excitation.
    fn excitation(&self) -> bool {
        self.told(self.driven, self.lawful)
    }

    /// Whether a law of the motion describes it, and the excitation far worse.
    fn motion(&self) -> bool {
        self.told(self.lawful, self.driven)
    }
}

/// What may close an open balance.
#[derive(Clone, Copy)]
enum Source {
    /// A sensor, or a motion of the base: the place is told by itself.
    Of(EffectPlace, Beside),
    /// A force or a moment at the exciter.
    Exciter(Located),
    /// A force elsewhere.
    Elsewhere(Located),
}

/// The same beside a structure, and the χ² by which it is ranked.
#[derive(Clone)]
struct Told {
    source: Source,
    setting: Setting,
    chi: f64,
}

impl Told {
    fn excites(&self) -> bool {
        matches!(self.source, Source::Of(EffectPlace::Excitation, _) | Source::Exciter(_))
    }

    fn by(source: Source, setting: Setting, chi: f64) -> Self {
        let weight = if matches!(source, Source::Exciter(_)) { EXCITER } else { 1.0 };
        Self { source, setting, chi: weight * chi }
    }
}

impl Study<'_> {
    /// Where an open balance is open: one more free value a line closes it best at one sensor, as a motion of the base, as a force
    /// or a moment at the exciter, or as a force elsewhere on the beam. All have the same number of unknowns, so χ² alone decides;
    /// that over its degrees of freedom is given with the place. Where none stands out it is the structure, which may be another one
    /// everywhere. The structure within its deviations may do what a free value does, so those that are best are told beside the one that fits them.
    pub(crate) fn open_place(&self, setting: &Setting) -> (EffectPlace, f64) {
        let sensors = self.case.rig.sensors.len();
        let mut plain = setting.clone();
        plain.ports.clear();
        let free = |place, beside| {
            let chi = self.chi_beside(&plain, beside);
            Told { source: Source::Of(place, beside), setting: plain.clone(), chi }
        };
        let sensed = (0..sensors).map(|s| free(EffectPlace::Measurement, Beside::Sensor(s)));
        let mut tried: Vec<Told> = sensed.chain([free(EffectPlace::Excitation, Beside::Base)]).collect();
        let located = |source: fn(Located) -> Source, located: Option<Located>| {
            located.map(|l| Told::by(source(l), plain.clone(), l.chi))
        };
        let exciter = self.case.rig.exciter;
        for place in [PortPlace::At(exciter), PortPlace::Turn(exciter)] {
            tried.extend(located(Source::Exciter, self.located_at(&plain, place)));
        }
        tried.extend(located(Source::Elsewhere, self.locate(&plain).first().copied()));
        tried.sort_by(|a, b| a.chi.total_cmp(&b.chi));
        let fitted: Vec<Told> =
            tried.par_iter().take(NEAREST).map(|told| self.beside_its_own(told)).collect();
        tried.splice(..fitted.len(), fitted);
        tried.sort_by(|a, b| a.chi.total_cmp(&b.chi));
        let freedom = self.residuals_of(&self.training) * sensors.saturating_sub(2) / sensors.max(1);
        let freedom = freedom.max(1) as f64;
        let Some((first, others)) = tried.split_first() else {
            return (EffectPlace::Structure, f64::INFINITY);
        };
        let rival = others.iter().find(|other| !(first.excites() && other.excites()));
        let told =
            is_told([first.chi, rival.map_or(f64::INFINITY, |rival| rival.chi)].map(|chi| chi / freedom));
        let place = if told { self.place_of(first) } else { EffectPlace::Structure };
        (place, first.chi / freedom)
    }

    /// The same beside the structure, within its deviations, that fits best with it.
    fn beside_its_own(&self, told: &Told) -> Told {
        let by = |source: fn(Located) -> Source, place, free: &[Unknown]| {
            let (located, own) = self.located_beside(&told.setting, place, free)?;
            Some(Told::by(source(located), own, located.chi))
        };
        let own = match told.source {
            Source::Of(_, beside) => {
                let setting = self.calibrated_with(&told.setting, beside, (&[], CALIBRATED));
                let chi = self.chi_beside(&setting, beside);
                Some(Told { source: told.source, setting, chi })
            }
            Source::Exciter(l) => by(Source::Exciter, l.place, &[]),
            Source::Elsewhere(l) => by(Source::Elsewhere, l.place, &self.place(0, l.place)),
        };
        own.filter(|own| own.chi < told.chi).unwrap_or_else(|| told.clone())
    }

    /// What acts on the beam is the excitation's or the structure's by what its force answers to; by its place where neither is told. A force
    /// at the exciter does to a single mode what one on that mode does: where one at a place of equal standing answers to its motion,
    /// it is the structure's. One across the beam at its support, as far as the sensors tell, is the contact's normal force.
    fn place_of(&self, told: &Told) -> EffectPlace {
        let setting = &told.setting;
        let located = match told.source {
            Source::Of(..) => Vec::new(),
            _ => self.locate(setting),
        };
        let equal: Vec<&Located> = located.iter().filter(|l| l.chi < NEAR * told.chi).collect();
        let answers = |located: &Located| self.asks(setting, located).is_some_and(|asks| asks.motion());
        match &told.source {
            Source::Of(place, _) => *place,
            Source::Exciter(located) => match self.asks(setting, located) {
                Some(asks) if asks.excitation() => EffectPlace::Excitation,
                Some(asks) if asks.motion() || equal.par_iter().any(|other| answers(other)) => {
                    EffectPlace::Structure
                }
                _ => EffectPlace::Excitation,
            },
            Source::Elsewhere(located) => match self.asks(setting, located) {
                Some(asks) if asks.excitation() => EffectPlace::Excitation,
                _ if equal.iter().any(|other| is_of_support(other) && answers(other)) => EffectPlace::Contact,
                _ => EffectPlace::Structure,
            },
        }
    }

    /// What a further force asks for: the excitation, or the motion where it acts.
    fn asks(&self, setting: &Setting, located: &Located) -> Option<Asks> {
        let harmonic: Vec<usize> =
            self.training.iter().copied().filter(|&run| self.case.records[run].subharmonic == 1).collect();
        let single = with_further(setting, located.place);
        let balances = self.model.balance_beside(&single, &harmonic, Beside::Ports).ok()?;
        let histories = |of: fn(&Balance, f64) -> Option<History>| -> Option<Vec<History>> {
            let runs = harmonic.iter().zip(&balances);
            runs.map(|(&run, balance)| of(balance, self.model.runs[run].omega)).collect()
        };
        let inertial = histories(History::inertial)?;
        let histories = histories(History::new)?;
        if histories.len() < DEAF_RUNS {
            return None;
        }
        let drives: Vec<Complex64> = harmonic.iter().map(|&run| self.model.runs[run].force[1]).collect();
        let lawful = shapes(located.place)
            .iter()
            .chain(&nameless())
            .filter_map(|shape| regress(&histories, shape))
            .map(|answer| answer.chi)
            // A spring or a mass of the structure, too much of it or too little.
            .chain([linear(&histories), linear(&inertial)])
            .fold(f64::INFINITY, f64::min);
        Some(Asks {
            all: histories.iter().map(History::chi).sum(),
            driven: driven(&histories, &drives),
            lawful,
            count: histories.iter().map(History::count).sum::<usize>() as f64,
            reduced: located.reduced().max(1.0),
        })
    }
}

/// Whether one more free value a line closes the balance or stands out of the others that might: χ² per degree of freedom of the best, and of
/// the next one.
fn is_told([best, next]: [f64; 2]) -> bool {
    best <= BALANCE_CLOSED || best < STANDS_OUT * next
}

#[cfg(test)]
mod tests {
    use super::{Asks, is_told};

    /// χ² per degree of freedom of the balance with the best and the next free value a line, of simulated rigs that have lost the name of
    /// what they have: a late sensor and one out of place, the modes not exact; a second exciter; clamps that give, which are neither a
    /// sensor's fault nor a motion of the base.
    #[test]
    fn what_does_not_stand_out_is_the_structures() {
        for told in [[12.0, 1952.5], [7.28, 168.5], [0.97, 7.95]] {
            assert!(is_told(told), "{told:?}");
        }
        for untold in [[157.6, 191.1], [36.1, 37.4]] {
            assert!(!is_told(untold), "{untold:?}");
        }
    }

    /// χ² of the forces recovered on four simulated rigs: a second exciter (weak beside the noise), a spring that answers to the square
    /// of the displacement, and the same where the balance is off by more than the noise and neither tells the force.
    #[test]
    fn a_force_asks_for_the_excitation_or_for_the_motion() {
        let asked = |[all, driven, lawful, count, reduced]: [f64; 5]| {
            let asks = Asks { all, driven, lawful, count, reduced };
            (asks.excitation(), asks.motion())
        };
        assert_eq!(asked([774.4, 415.7, 762.7, 308.0, 1.0]), (true, false));
        assert_eq!(asked([25_782.3, 692.4, 271.4, 332.0, 1.024]), (false, true));
        assert_eq!(asked([46_302.4, 2771.9, 3152.5, 332.0, 1.299]), (false, false));
        // A mode with another frequency, as a force at the exciter and as one on that mode, which close the balance as well.
        assert_eq!(asked([2799.0, 1076.7, 1743.1, 224.0, 1.0]), (false, false));
        assert_eq!(asked([2494.5, 914.6, 295.8, 224.0, 1.02]), (false, true));
    }
}
