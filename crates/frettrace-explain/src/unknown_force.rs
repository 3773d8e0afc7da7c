//! A further force on the structure, found without its law: where it acts, and what it answers to.
//!
//! On every line `a = G_e F + G_c f_c + G_x f_x + noise` with both forces free; χ² over the places `x` says where. The laws of
//! [`crate::force_laws`] then answer the recovered motion there. Where the contact's support has a force of its own, that is free as well, so that its
//! law does not matter.

use crate::{Study, Unknown, signed};
use frettrace_forward::accelerations::{Balance, Beside, Port, PortLaw, PortPlace, Quantity, Setting};
use rayon::prelude::*;

mod candidates;
mod open_place;

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
/// Steps of the fit of the structure beside what is free.
const CALIBRATED: usize = 20;
/// Sensors that a contact force and a further one take.
const LEAST_FREE: usize = 2;
/// Places are of equal standing within this factor of the best.
const NEAR: f64 = 1.3;

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

    /// χ² of the balance of the fitted runs with something free beside the contact force.
    pub(crate) fn chi_beside(&self, setting: &Setting, beside: Beside) -> f64 {
        let found = self.model.balance_beside(setting, &self.training, beside);
        found.map_or(f64::INFINITY, |all| Balance::chi_squared_of(&all).0)
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
}

/// A setting with a further port, whose force is free where those of all ports are.
fn with_further(setting: &Setting, place: PortPlace) -> Setting {
    let mut setting = setting.clone();
    setting.ports.push(Port { place, law: PortLaw::Polynomial, coefficients: [0.0; 4] });
    setting
}
