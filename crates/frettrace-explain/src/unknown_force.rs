//! A further force on the structure, found without its law: where it acts, and what it answers to.
//!
//! On every line `a = G_e F + G_c f_c + G_x f_x + noise` with both forces free; χ² over the places `x` says where. The laws of
//! [`crate::force_laws`] then answer the recovered motion there. Where the contact's support has a force of its own, that is free as well, so that its
//! law does not matter.

use crate::balance_fit::BalanceCandidate;
use crate::effects::{ALL, EffectPlace, FREE, StructureForm, listed};
use crate::force_laws::{
    Answer, History, driven, linear, nameless, names, range, regress, regress_resting, shapes, thresholds,
};
use crate::verdict::{BALANCE_CLOSED, EVIDENCE};
use crate::{Study, Unknown, signed};
use frettrace_forward::accelerations::{
    Balance, Beside, Port, PortLaw, PortPlace, Quantity, RunLines, Setting,
};
use num_complex::Complex64;
use rayon::prelude::*;
use std::sync::Arc;

/// Where a further force acts, and what is left with it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Located {
    pub place: PortPlace,
    /// χ² with any force there.
    pub chi: f64,
    /// Its degrees of freedom.
    pub freedom: usize,
}

impl Located {
    /// χ² over its degrees of freedom.
    pub fn reduced(&self) -> f64 {
        self.chi / self.freedom.max(1) as f64
    }
}

/// Places tried along the beam before the best is refined.
const PLACES: usize = 48;
/// The first of them: a force nearer the clamp is the clamp's.
const CLAMP: usize = 3;
/// Share of the beam's length by which a place may move beside the structure: as far as the balance falls towards a place.
const BASIN: f64 = 0.1;
/// Modes that may carry a force of their own.
const MODES: usize = 6;
/// Share of the open balance that a force at one place must explain to be worth a law.
const WORTH: f64 = 0.3;
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
/// What closes an open balance best that is told beside a structure of its own, and the steps of its fit.
const NEAREST: usize = 4;
const CALIBRATED: usize = 20;
/// Sensors that a contact force and a further one take.
const LEAST_FREE: usize = 2;
/// Places are of equal standing within this factor of the best.
const NEAR: f64 = 1.3;

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

/// Share of the next one's χ² below which what closes an open balance best stands out.
const STANDS_OUT: f64 = 0.5;

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

fn is_along(located: &Located) -> bool {
    matches!(located.place, PortPlace::At(_))
}

fn is_of_mode(located: &Located) -> bool {
    matches!(located.place, PortPlace::Mode(_))
}

fn is_of_support(located: &Located) -> bool {
    matches!(located.place, PortPlace::Support)
}

impl Study<'_> {
    fn located_at(&self, setting: &Setting, place: PortPlace) -> Option<Located> {
        let single = with_further(setting, place);
        let found = self.model.balance_beside(&single, &self.training, Beside::Ports).ok()?;
        let (chi, freedom) = Balance::chi_squared_of(&found);
        Some(Located { place, chi, freedom })
    }

    /// The places of a further force, best first: along the beam, at the support, on one of the first modes.
    pub(crate) fn locate(&self, setting: &Setting) -> Vec<Located> {
        if !self.locates() {
            return Vec::new();
        }
        let length = self.scales.length;
        let mut places: Vec<PortPlace> =
            (CLAMP..PLACES).map(|k| PortPlace::At(length * k as f64 / PLACES as f64)).collect();
        places.push(PortPlace::Support);
        places.extend((0..setting.frequency.len().min(MODES)).map(PortPlace::Mode));
        let mut found: Vec<Located> =
            places.par_iter().filter_map(|&place| self.located_at(setting, place)).collect();
        found.sort_by(|a, b| a.chi.total_cmp(&b.chi));
        if let Some(best) = found.iter().position(is_along) {
            found[best] = self.refine(setting, found[best]);
        }
        found.sort_by(|a, b| a.chi.total_cmp(&b.chi));
        found
    }

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

    /// A further force beside the structure that fits best with it, and with what else is free.
    fn located_beside(
        &self,
        setting: &Setting,
        place: PortPlace,
        free: &[Unknown],
    ) -> Option<(Located, Setting)> {
        let single = with_further(setting, place);
        let mut own = self.calibrated_with(&single, Beside::Ports, (free, CALIBRATED));
        let place = own.ports.pop()?.place;
        Some((self.located_at(&own, place)?, own))
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

    /// χ² of the balance of the fitted runs with something free beside the contact force.
    pub(crate) fn chi_beside(&self, setting: &Setting, beside: Beside) -> f64 {
        let found = self.model.balance_beside(setting, &self.training, beside);
        found.map_or(f64::INFINITY, |all| Balance::chi_squared_of(&all).0)
    }

    /// A motion of the base of any size and phase on every line, where it closes the balance far better than the plain
    /// structure does: recovered beside the contact force, then an input with a factor.
    pub(crate) fn base_candidate(&self, setting: &Setting, plain: f64) -> Option<BalanceCandidate> {
        let effect = listed("excitation.base-motion")?;
        if setting.base.is_some() || !self.case.allows(ALL[effect].id()) {
            return None;
        }
        let all: Vec<usize> = (0..self.model.runs.len()).collect();
        let found = self.model.balance_beside(setting, &all, Beside::Base).ok()?;
        let (chi, freedom) = Balance::chi_squared_of(self.training.iter().map(|&run| &found[run]));
        if chi > WORTH * plain {
            return None;
        }
        let known: Vec<Vec<Complex64>> = found.iter().map(significant).collect();
        let lines: usize =
            self.training.iter().map(|&run| known[run].iter().filter(|l| l.norm() > 0.0).count()).sum();
        let mut setting = setting.clone();
        setting.base = Some([1.0, 0.0]);
        setting.base_motion = Some(Arc::new(known));
        let factor = |quantity, name| signed(quantity, (name, "1"), 1e-2, FREE);
        let unknowns = vec![
            factor(Quantity::BaseReal, "base_motion_factor_real"),
            factor(Quantity::BaseImaginary, "base_motion_factor_imaginary"),
        ];
        let count = self.residual_count() as f64;
        Some(BalanceCandidate {
            effect,
            sensor: None,
            setting,
            criterion: chi + 2.0 * lines as f64 * count.ln(),
            reduced: chi / freedom.max(1) as f64,
            unknowns,
        })
    }

    /// Golden section around a place.
    fn refine(&self, setting: &Setting, start: Located) -> Located {
        let PortPlace::At(centre) = start.place else { return start };
        let chi = |x: f64| self.located_at(setting, PortPlace::At(x)).map_or(f64::INFINITY, |l| l.chi);
        let step = self.scales.length / PLACES as f64;
        let golden = 0.5 * (5.0_f64.sqrt() - 1.0);
        let (mut low, mut high) = (centre - step, centre + step);
        let (mut a, mut b) = (high - golden * (high - low), low + golden * (high - low));
        let (mut at_a, mut at_b) = (chi(a), chi(b));
        for _ in 0..14 {
            if at_a < at_b {
                (high, b, at_b) = (b, a, at_a);
                a = high - golden * (high - low);
                at_a = chi(a);
            } else {
                (low, a, at_a) = (a, b, at_b);
                b = low + golden * (high - low);
                at_b = chi(b);
            }
        }
        self.located_at(setting, PortPlace::At(0.5 * (low + high)))
            .filter(|l| l.chi < start.chi)
            .unwrap_or(start)
    }

    /// Whether there are sensors enough to locate a further force without its law.
    pub(crate) fn locates(&self) -> bool {
        self.case.rig.sensors.len() > LEAST_FREE
    }

    /// Whether a further force can be located beside the ports that a setting has: one on the beam is not told from another, and every free force takes
    /// a sensor.
    pub(crate) fn locates_beside(&self, setting: &Setting) -> bool {
        let of_support = setting.ports.iter().all(|port| port.place == PortPlace::Support);
        of_support && self.case.rig.sensors.len() > LEAST_FREE + setting.ports.len()
    }

    /// Whether further forces on the beam are asked by their laws: where they cannot be located without one because there are too few sensors, or because the noise alone,
    /// beside χ² per degree of freedom of the balance, leaves more than a force at one place may to be worth a law.
    pub(crate) fn asks_forces_by_law(&self, setting: &Setting, reduced: f64) -> bool {
        !self.locates() || self.locates_beside(setting) && reduced * WORTH < 1.0
    }

    /// Laws of a further force where one closes the balance far better than the plain structure does (χ² `plain`).
    pub(crate) fn force_candidates(&self, setting: &Setting, plain: f64) -> Vec<BalanceCandidate> {
        let mut located = self.locate(setting);
        let mut setting = setting.clone();
        // The structure within its standard deviations and the place of the force, together: where noise is low either one alone comes to rest
        // far from where both are, and the best place along the beam may stand behind a mode until then.
        let of_each_kind = [is_along, is_of_mode, is_of_support].map(|kind| located.iter().find(|l| kind(l)));
        let together = of_each_kind.par_iter().flatten().filter_map(|l| {
            self.located_beside(&setting, l.place, &self.place(setting.ports.len(), l.place))
        });
        if let Some((nearest, own)) = together.min_by(|(a, _), (b, _)| a.chi.total_cmp(&b.chi)) {
            setting = Setting { ports: setting.ports, ..own };
            located = self.locate(&setting);
            if located.first().is_none_or(|l| nearest.chi < l.chi) {
                located.insert(0, nearest);
            }
        }
        let Some(first) = located.first().filter(|l| l.chi < WORTH * plain) else { return Vec::new() };
        let mut found: Vec<BalanceCandidate> = located
            .iter()
            .filter(|l| l.reduced() < NEAR * first.reduced().max(1.0))
            .take(3)
            .flat_map(|place| self.force_laws(&setting, place))
            .collect();
        found.sort_by(|a, b| a.criterion.total_cmp(&b.criterion));
        found
    }

    /// The place of a further force, the port of the given index, as an unknown, where it is one along the beam.
    fn place(&self, port: usize, place: PortPlace) -> Vec<Unknown> {
        let length = self.scales.length;
        let along = |x: f64| (x - BASIN * length, x + BASIN * length);
        match place {
            PortPlace::At(x) => {
                vec![signed(Quantity::PortPosition(port), ("position", "m"), 1e-3 * length, along(x))]
            }
            _ => Vec::new(),
        }
    }

    /// Laws at a place, best first.
    fn force_laws(&self, setting: &Setting, located: &Located) -> Vec<BalanceCandidate> {
        let Some(all) = self.histories(setting, located.place) else { return Vec::new() };
        let histories = &all[..self.training.len()];
        let count = self.residual_count() as f64;
        shapes(located.place)
            .into_iter()
            .filter(|shape| self.case.allows(shape.id))
            .flat_map(|shape| {
                let plain = regress(histories, &shape);
                // Each run is placed by a value of its own.
                let price = EVIDENCE + histories.len() as f64 * count.ln();
                let dear = plain.as_ref().map_or(f64::INFINITY, |plain| plain.chi);
                let resting = regress_resting(histories, &shape).filter(|r| r.chi + price < dear);
                let shape = &shape;
                let candidate = |(answer, rests): (Answer, bool)| {
                    let Answer { chi, coefficients } = answer;
                    let port = Port { place: located.place, law: shape.law, coefficients };
                    let free: Vec<usize> =
                        shape.free.iter().copied().filter(|&k| !(rests && k == 1)).collect();
                    let mut form = self.form(setting, port, (&free, thresholds(histories, shape.law)));
                    if rests {
                        form.setting.rests = (setting.ports.len(), self.resting(&all, &port));
                    }
                    let freedom = located.freedom + histories.iter().map(History::count).sum::<usize>();
                    let values = form.unknowns.len() + if rests { histories.len() } else { 0 };
                    BalanceCandidate {
                        effect: listed(shape.id).unwrap_or_default(),
                        sensor: None,
                        setting: form.setting,
                        criterion: located.chi + chi + values as f64 * count.ln(),
                        reduced: (located.chi + chi) / freedom.max(1) as f64,
                        unknowns: form.unknowns,
                    }
                };
                let answers = plain.map(|it| (it, false)).into_iter().chain(resting.map(|it| (it, true)));
                answers.map(candidate).collect::<Vec<_>>()
            })
            .collect()
    }

    /// Where the only port of a setting, a stop, lets every run rest ([`Setting::rests`]); `None` where that cannot be told.
    pub(crate) fn rests(&self, setting: &Setting) -> Option<Vec<f64>> {
        let [port] = setting.ports[..] else { return None };
        let without = Setting { ports: Vec::new(), ..setting.clone() };
        Some(self.resting(&self.histories(&without, port.place)?, &port))
    }

    /// The same of recovered histories of all runs.
    fn resting(&self, histories: &[History], port: &Port) -> Vec<f64> {
        let mut rests = vec![0.0; self.model.runs.len()];
        for (run, history) in self.all_runs().into_iter().zip(histories) {
            rests[run] = history.rest(port.law, &port.coefficients);
        }
        rests
    }

    /// What a further force at a place and its motion were in every run, those that are fitted first.
    fn histories(&self, setting: &Setting, place: PortPlace) -> Option<Vec<History>> {
        let all = self.all_runs();
        let balances = self.model.balance_beside(&with_further(setting, place), &all, Beside::Ports).ok()?;
        all.iter()
            .zip(&balances)
            .map(|(&run, balance)| History::new(balance, self.model.runs[run].omega))
            .collect()
    }

    /// Amplitudes of displacement (m) and velocity (m/s) on the excitation's line, the largest of any sensor and fitted run.
    pub(crate) fn largest_motion(&self) -> [f64; 2] {
        let runs =
            self.training.iter().map(|&run| (&self.model.runs[run], self.case.records[run].subharmonic));
        let of_run = |(lines, first): (&RunLines, usize)| {
            let sizes = lines.acceleration.iter().filter_map(|sensor| sensor.get(first));
            let omega = first as f64 * lines.omega;
            let fastest = sizes.map(|line| line.norm()).fold(0.0, f64::max) / omega;
            [fastest / omega, fastest]
        };
        let larger = |a: [f64; 2], b: [f64; 2]| [a[0].max(b[0]), a[1].max(b[1])];
        runs.map(of_run).fold([0.0; 2], larger)
    }

    /// A port with its unknowns in the model.
    pub(crate) fn form(
        &self,
        setting: &Setting,
        port: Port,
        (free, thresholds): (&[usize], Option<(f64, f64)>),
    ) -> StructureForm {
        let mut setting = setting.clone();
        setting.ports.push(port);
        let index = setting.ports.len() - 1;
        let modal = matches!(port.place, PortPlace::Mode(_));
        // What was left out has no size that a fit could take steps of.
        let mut unknowns: Vec<Unknown> = free
            .iter()
            .filter(|&&k| port.coefficients[k] != 0.0)
            .map(|&k| {
                let value = port.coefficients[k];
                let (name, unit) = names(port.law, modal)[k];
                let bounds = range(port.law, (k, value), thresholds);
                signed(Quantity::Port(index, k), (name, unit), 0.1 * value.abs(), bounds)
            })
            .collect();
        if matches!(port.place, PortPlace::At(_)) {
            let length = self.scales.length;
            let bounds = (0.05 * length, 0.99 * length);
            unknowns.push(signed(Quantity::PortPosition(index), ("position", "m"), 0.003 * length, bounds));
        }
        StructureForm { setting, unknowns, sensor: None }
    }
}

/// Lines of what was free beside the contact, those within five standard deviations of nothing left out.
fn significant(balance: &Balance) -> Vec<Complex64> {
    let (Some(lines), Some(std)) = (balance.beside.first(), balance.beside_deviation.first()) else {
        return Vec::new();
    };
    lines.iter().zip(std).map(|(l, d)| if l.norm() > 5.0 * d { *l } else { Complex64::ZERO }).collect()
}

/// Whether one more free value a line closes the balance or stands out of the others that might: χ² per degree of freedom of the best, and of
/// the next one.
fn is_told([best, next]: [f64; 2]) -> bool {
    best <= BALANCE_CLOSED || best < STANDS_OUT * next
}

/// A setting with a further port, whose force is free where those of all ports are.
fn with_further(setting: &Setting, place: PortPlace) -> Setting {
    let mut setting = setting.clone();
    setting.ports.push(Port { place, law: PortLaw::Polynomial, coefficients: [0.0; 4] });
    setting
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
