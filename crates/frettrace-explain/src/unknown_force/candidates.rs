//! Laws of a force that was located on the structure, and a motion of the base, as candidates on the balance.

use super::{Located, NEAR, is_along, is_of_mode, is_of_support, with_further};
use crate::balance_fit::BalanceCandidate;
use crate::effects::{ALL, FREE, StructureForm, listed};
use crate::force_laws::{Answer, History, names, range, regress, regress_resting, shapes, thresholds};
use crate::verdict::EVIDENCE;
use crate::{Study, Unknown, signed};
use frettrace_forward::accelerations::{Balance, Beside, Port, PortPlace, Quantity, RunLines, Setting};
use num_complex::Complex64;
use rayon::prelude::*;
use std::sync::Arc;

/// Share of the open balance that a force at one place must explain to be worth a law.
const WORTH: f64 = 0.3;

/// Places of equal standing whose laws are asked, …
const BEST: usize = 3;
/// … and others along the beam.
const ALONG: usize = 6;

impl Study<'_> {
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
        let equal = located.iter().filter(|l| l.reduced() < NEAR * first.reduced().max(1.0));
        let mut found: Vec<BalanceCandidate> = some_of(&equal.copied().collect::<Vec<_>>())
            .par_iter()
            .flat_map_iter(|place| self.force_laws(&setting, place))
            .collect();
        found.sort_by(BalanceCandidate::by_criterion);
        found
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

/// Of places of equal standing, best first, the best [`BEST`], and others evenly along the beam: where no sensor stands between a force and the contact, the
/// two are told apart by their laws alone.
fn some_of(equal: &[Located]) -> Vec<Located> {
    let (best, rest) = equal.split_at(equal.len().min(BEST));
    let along = |located: &Located| match located.place {
        PortPlace::At(x) => x,
        _ => f64::NAN,
    };
    let mut rest: Vec<Located> = rest.iter().copied().filter(is_along).collect();
    rest.sort_by(|a, b| along(a).total_cmp(&along(b)));
    let few = rest.len().min(ALONG);
    let spread = (0..few).map(|k| rest[k * (rest.len() - 1) / (few - 1).max(1)]);
    best.iter().copied().chain(spread).collect()
}

/// Lines of what was free beside the contact, those within five standard deviations of nothing left out.
fn significant(balance: &Balance) -> Vec<Complex64> {
    let (Some(lines), Some(std)) = (balance.beside.first(), balance.beside_deviation.first()) else {
        return Vec::new();
    };
    lines.iter().zip(std).map(|(l, d)| if l.norm() > 5.0 * d { *l } else { Complex64::ZERO }).collect()
}

#[cfg(test)]
mod tests {
    use super::{ALONG, BEST, Located, some_of};
    use frettrace_forward::accelerations::PortPlace;

    /// Twenty-one places from 0.5 m to 0.7 m, of which 0.7 m is the best and each other one worse the farther it is away: the three next to the contact, and
    /// six from one end of the others to the other. Of a mode there is one place; of few places all are asked.
    #[test]
    fn places_of_equal_standing_are_asked_from_end_to_end() {
        let at = |place: PortPlace, chi: f64| Located { place, chi, freedom: 1 };
        let along: Vec<Located> = (0..=20)
            .map(|k| at(PortPlace::At(0.7 - 0.01 * f64::from(k)), 1.0 + 1e-6 * f64::from(k)))
            .collect();
        let asked = some_of(&along);
        assert_eq!(asked.len(), BEST + ALONG);
        let place = |located: &Located| match located.place {
            PortPlace::At(x) => (100.0 * x).round(),
            _ => 0.0,
        };
        assert_eq!(
            asked.iter().map(place).collect::<Vec<_>>(),
            [70.0, 69.0, 68.0, 50.0, 53.0, 56.0, 60.0, 63.0, 67.0]
        );
        assert_eq!(some_of(&along[..5]).len(), 5);
        assert_eq!(some_of(&along[..1]).len(), 1);
        let modes: Vec<Located> = (0..5).map(|mode| at(PortPlace::Mode(mode), 1.0)).collect();
        assert_eq!(some_of(&modes).len(), BEST);
    }
}
