//! The loads that depend on the motion they cause.

use frettrace_friction::{FrictionLaw, Step};

use super::assembly::{Assembly, Characteristic, Normal};
use super::engine::March;
use super::root::{Guess, rising_root};
use super::stick::Branch;

/// An implicit load: what it is, …
#[derive(Clone, Copy, Debug)]
pub(super) enum Kind {
    Friction,
    Normal,
    Local(Characteristic),
}

/// … where it acts, and the slope of its equation last seen.
#[derive(Clone, Copy, Debug)]
pub(super) struct Unknown {
    pub(super) port: usize,
    pub(super) kind: Kind,
    pub(super) slope: f64,
}

/// Sweeps over several implicit loads before they are taken as they are.
const SWEEPS: usize = 60;
/// Relative residual of an implicit load that counts as zero.
const TOLERANCE: f64 = 1e-13;
/// Place of the friction force among the implicit loads.
pub(super) const FRICTION: usize = 0;

/// Motion of a load's own port on the value of that load.
pub(super) struct Line {
    pub(super) value: f64,
    /// Displacement and velocity with the value, …
    motion: [f64; 2],
    /// … and what one more newton adds.
    gain: [f64; 2],
}

impl Line {
    pub(super) fn at(&self, value: f64) -> [f64; 2] {
        [0, 1].map(|k| self.motion[k] + self.gain[k] * (value - self.value))
    }

    /// The value that leaves no velocity.
    pub(super) fn resting(&self) -> f64 {
        self.value - self.motion[1] / self.gain[1]
    }
}

/// The implicit loads of an assembly, friction first.
pub(super) fn unknowns<L>(assembly: &Assembly<L>) -> Vec<Unknown> {
    let unknown = |port, kind| Unknown { port, kind, slope: 1.0 };
    let contact = assembly.friction.iter().flat_map(|contact| {
        let normal = contact.normal.port.filter(|_| contact.normal.deviates());
        [Some(unknown(contact.slip_port, Kind::Friction)), normal.map(|port| unknown(port, Kind::Normal))]
    });
    let local = assembly.loads.iter().map(|load| unknown(load.port, Kind::Local(load.characteristic)));
    contact.flatten().chain(local).collect()
}

/// Ports read at every step: those of the implicit loads, in their order, and last that of the normal force.
pub(super) fn ports<L>(assembly: &Assembly<L>, unknowns: &[Unknown]) -> Vec<usize> {
    let normal = assembly.friction.as_ref().and_then(|contact| contact.normal.port);
    unknowns.iter().map(|unknown| unknown.port).chain(normal).collect()
}

impl<L: FrictionLaw<f64>> March<'_, L> {
    /// Solves all implicit loads; returns the new state of the law.
    pub(super) fn solve(&mut self) -> Option<L::State> {
        let ahead = self.levels[self.level].dt / self.span;
        let held = self.is_held();
        for (index, value) in self.values.iter_mut().enumerate() {
            let ahead = if held && index == FRICTION { 0.0 } else { ahead };
            let (last, before) = (*value, self.older[index]);
            (*value, self.older[index], self.oldest[index]) = (last + (last - before) * ahead, last, before);
        }
        let mut state = self.state;
        for _ in 0..SWEEPS {
            let mut change = 0.0_f64;
            for index in usize::from(held)..self.unknowns.len() {
                let before = self.values[index];
                state = self.solve_one(index).or(state);
                change = change.max((self.values[index] - before).abs());
            }
            self.scale = self.values.iter().fold(self.scale, |s, v| s.max(v.abs()));
            if self.unknowns.len() < 2 || change <= 10.0 * TOLERANCE * self.scale {
                break;
            }
        }
        state
    }

    /// Solves one implicit load with the others as they are.
    fn solve_one(&mut self, index: usize) -> Option<L::State> {
        let unknown = self.unknowns[index];
        let line = Line {
            value: self.values[index],
            motion: self.motion(index),
            gain: self.compliance()[index * self.unknowns.len() + index],
        };
        let tolerance = TOLERANCE * self.scale.max(line.value.abs());
        let guess = Guess { value: line.value, slope: unknown.slope, tolerance };
        let (mut state, mut rests) = (None, false);
        let (root, slope) = match (unknown.kind, &self.assembly.friction, self.state) {
            (Kind::Local(characteristic), ..) => rising_root(guess, |f| {
                let [y, v] = line.at(f);
                f - characteristic.load(y, v)
            }),
            (Kind::Normal, Some(contact), _) => {
                rising_root(guess, |f| f - contact.normal.deviation(line.at(f)[0], self.time))
            }
            (Kind::Friction, Some(contact), Some(old)) => {
                let normal = self.normal_now(&contact.normal);
                let mut force = |f: f64| {
                    let (new, force) = contact.law.step(old, &self.law_step(line.at(f), normal));
                    state = Some(new);
                    force
                };
                match self.branch(old, (&line, normal)) {
                    Branch::Rests(load) => {
                        rests = true;
                        force(load);
                        (load, unknown.slope)
                    }
                    branch => {
                        let value = branch.start(line.value);
                        rising_root(Guess { value, ..guess }, |f| f + force(f))
                    }
                }
            }
            // A friction or normal load exists only where there is a contact.
            _ => (0.0, 1.0),
        };
        if let (Some(grip), Kind::Friction) = (&mut self.grip, unknown.kind) {
            grip.rests = rests;
        }
        self.values[index] = root;
        self.unknowns[index].slope = slope.clamp(1.0, 1e9);
        state
    }

    pub(super) fn law_step(&self, [slip, velocity]: [f64; 2], normal: f64) -> Step<f64> {
        Step {
            slip: [self.moment.slip, slip],
            velocity: [self.moment.velocity, velocity],
            normal: [self.moment.normal, normal],
            dt: self.levels[self.level].dt,
        }
    }

    /// The normal force with the loads as they are.
    pub(super) fn normal_now(&self, normal: &Normal) -> f64 {
        let displacement = if normal.port.is_some() { self.motion(self.ports.len() - 1)[0] } else { 0.0 };
        normal.force(displacement, self.time)
    }
}
