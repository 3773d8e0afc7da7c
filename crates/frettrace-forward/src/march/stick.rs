//! Rigid friction in the march: a law that is set-valued at rest holds the contact, or lets it slide.
//!
//! Held, the structure is linear and its step exact ([`super::held`]); sliding, the force follows from the motion, one branch of the law for
//! either sense. A step that passes from one to the other inside is halved until it is one of the shortest: there the contact is let go
//! where the force that holds it is beyond the law's bounds, and held where the load that leaves no velocity is between them.

use frettrace_friction::FrictionLaw;

use super::engine::{March, Moment, dot};
use super::held::{Held, Holding, dips};
use super::implicit::{FRICTION, Line};
use super::refine::add;

/// A contact under a law that is set-valued at rest.
#[derive(Clone, Copy, Debug)]
pub(super) struct Grip {
    /// Whether it is held.
    pub(super) held: bool,
    /// Whether it came to rest in the step just tried.
    pub(super) rests: bool,
    /// Lowest and highest friction force (N) that hold it at the last sample.
    bounds: [f64; 2],
}

/// Held steps of one length.
#[derive(Clone, Debug)]
pub(super) struct HeldLevel {
    step: Held,
    /// Motion at the march's ports per unit of each implicit load; none of the friction force's.
    compliance: Vec<[f64; 2]>,
}

/// Where an implicit friction force lies.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Branch {
    /// The law's force follows from the motion.
    Follows,
    /// With this load the contact ends at rest.
    Rests(f64),
    /// It slides: the load is beyond the one that would bring it to rest, `from` it …
    Slides {
        from: f64,
        /// … about here.
        about: f64,
    },
}

impl Branch {
    /// A first trial on the branch, of the value expected.
    pub(super) fn start(self, expected: f64) -> f64 {
        match self {
            Self::Slides { from, about } if (expected - from) * (about - from) <= 0.0 => about,
            _ => expected,
        }
    }
}

impl<L: FrictionLaw<f64>> March<'_, L> {
    /// Whether the contact is held.
    pub(super) fn is_held(&self) -> bool {
        self.grip.is_some_and(|grip| grip.held)
    }

    /// The grip of a contact that begins to be held; none where the law's force follows from the motion.
    pub(super) fn grip(&self) -> Option<Grip> {
        let bounds = self.bounds(self.state?, self.moment.slip, self.moment.normal)?;
        Some(Grip { held: true, rests: false, bounds })
    }

    /// Lowest and highest friction force (N) with which a contact stays at rest at a slip under a normal force at the end of a step.
    fn bounds(&self, old: L::State, slip: f64, normal: f64) -> Option<[f64; 2]> {
        let contact = self.assembly.friction.as_ref()?;
        contact.law.at_rest(old, &self.law_step([slip, 0.0], normal))
    }

    /// The branch of the law on which the friction force of the present step lies.
    pub(super) fn branch(&self, old: L::State, (line, normal): (&Line, f64)) -> Branch {
        let resting = line.resting();
        let bounds = self.grip.and_then(|_| self.bounds(old, line.at(resting)[0], normal));
        match bounds {
            None => Branch::Follows,
            Some([low, high]) if (low..=high).contains(&-resting) => Branch::Rests(resting),
            Some([low, high]) => {
                Branch::Slides { from: resting, about: if -resting > high { -high } else { -low } }
            }
        }
    }

    /// The matrix of compliances of the step in use, one row a port.
    pub(super) fn compliance(&self) -> &[[f64; 2]] {
        let level = &self.levels[self.level];
        match &level.held {
            Some(held) if self.is_held() => &held.compliance,
            _ => &level.compliance,
        }
    }

    /// Held steps beside those of the structure, where the law can hold.
    pub(super) fn add_held_levels(&mut self) {
        let (Some(contact), true) = (&self.assembly.friction, self.grip.is_some()) else { return };
        let structure = &self.assembly.structure;
        self.holding = Some(Holding::new(structure, contact.slip_port));
        let inputs = self.assembly.inputs.len();
        let others = self.unknowns.iter().skip(1).map(|unknown| unknown.port);
        let loads: Vec<usize> = self.assembly.inputs.iter().copied().chain(others).collect();
        let whole = (self.levels[0].dt, self.levels.len());
        let steps = Held::ladder(structure, (contact.slip_port, &loads), whole);
        for (level, step) in self.levels.iter_mut().zip(steps) {
            let constant = level.constant;
            let row = |&port: &usize| {
                let gain = |load| step.response(structure.row(port), (load, constant));
                std::iter::once([0.0; 2]).chain((inputs..loads.len()).map(gain)).collect::<Vec<_>>()
            };
            let compliance = self.ports.iter().flat_map(row).collect();
            level.held = Some(HeldLevel { step, compliance });
        }
    }

    /// One step; returns whether the contact was held, or slid one way, all through it.
    pub(super) fn try_step(&mut self, end: f64, known: &[f64]) -> bool {
        self.time += self.levels[self.level].dt;
        self.count += 1;
        if self.is_held() { self.try_held(end, known) } else { self.try_free(end, known) }
    }

    fn try_free(&mut self, end: f64, known: &[f64]) -> bool {
        self.free_count += 1;
        let before = self.grip.map(|_| [self.moment.velocity, self.slip_acceleration()]);
        self.propagate(end, known);
        self.read_free();
        let state = self.solve();
        self.span = self.levels[self.level].dt;
        self.correct();
        if let Some(contact) = &self.assembly.friction {
            self.moment = self.observe(contact);
            self.state = state;
        }
        before.is_none_or(|before| self.slid(before))
    }

    /// Whether the contact slid one way all through the step that began with this velocity and acceleration.
    fn slid(&self, [velocity, acceleration]: [f64; 2]) -> bool {
        let dt = self.levels[self.level].dt;
        let velocity = [velocity, self.moment.velocity];
        let sense = 1.0_f64.copysign(velocity[0] + velocity[1]);
        let forward = velocity.map(|v| v * sense);
        let slopes = [acceleration, self.slip_acceleration()].map(|a| a * sense * dt);
        let rests = self.grip.is_some_and(|grip| grip.rests);
        !rests && forward.iter().all(|&v| v >= 0.0) && !dips(forward, slopes)
    }

    fn slip_acceleration(&self) -> f64 {
        let motion = [&self.displacement, &self.velocity, &self.load].map(Vec::as_slice);
        self.holding.as_ref().map_or(0.0, |holding| holding.mobility * holding.force(motion))
    }

    fn try_held(&mut self, end: f64, known: &[f64]) -> bool {
        self.propagate_held(end, known);
        self.read_free();
        self.solve();
        self.span = self.levels[self.level].dt;
        self.correct_held();
        if let (Some(contact), Some(old)) = (&self.assembly.friction, self.state) {
            let normal = self.normal_now(&contact.normal);
            self.state = Some(contact.law.step(old, &self.law_step([self.moment.slip, 0.0], normal)).0);
            self.moment = Moment { velocity: 0.0, ..self.observe(contact) };
        }
        self.kept()
    }

    /// Advances all modes under the known loads, the contact held.
    fn propagate_held(&mut self, end: f64, known: &[f64]) {
        let level = &self.levels[self.level];
        let Some(held) = &level.held else { return };
        let start = end - level.dt / self.levels[0].dt;
        let others = self.values.len() - 1;
        for (loads, share) in self.beside.iter_mut().zip([start, end]) {
            loads.clear();
            loads.extend(self.known.iter().zip(known).map(|(old, new)| old + (new - old) * share));
        }
        let [old, new] = &mut self.beside;
        old.extend(self.values[1..].iter().map(|&value| if level.constant { 0.0 } else { value }));
        new.resize(new.len() + others, 0.0);
        let [displacement, velocity, load] = &mut self.next;
        held.step.advance([&self.displacement, &self.velocity], [old, new], [displacement, velocity]);
        load.fill(0.0);
        for (&port, value) in self.assembly.inputs.iter().zip(new.iter()) {
            add(load, self.assembly.structure.row(port), *value);
        }
    }

    /// Takes the implicit loads into the motion, and the force that holds the contact into its loads.
    fn correct_held(&mut self) {
        let level = &self.levels[self.level];
        let (Some(held), Some(holding)) = (&level.held, &self.holding) else { return };
        let structure = &self.assembly.structure;
        let [displacement, velocity, load] = &mut self.next;
        let inputs = self.assembly.inputs.len();
        for (index, unknown) in self.unknowns.iter().enumerate().skip(1) {
            let value = self.values[index];
            add(load, structure.row(unknown.port), value);
            held.step.add_load((inputs + index - 1, level.constant), value, [displacement, velocity]);
        }
        let force = holding.force([displacement, velocity, load]);
        self.values[FRICTION] = -force;
        add(load, structure.row(self.unknowns[FRICTION].port), -force);
        self.swap_motion();
    }

    /// Whether the force that held the contact was between the law's bounds all through the step just made.
    fn kept(&mut self) -> bool {
        let Some(Grip { bounds: before, .. }) = self.grip else { return true };
        self.grip = self.grip();
        let Some(Grip { bounds: now, .. }) = self.grip else { return true };
        let force = [self.older[FRICTION], self.values[FRICTION]].map(|load| -load);
        let slopes = self.holding_slopes();
        let margin = |side: usize, sense: f64| {
            let bound = [before[side], now[side]];
            let margin = [0, 1].map(|k| (bound[k] - force[k]) * sense);
            let slopes = slopes.map(|slope| (bound[1] - bound[0] - slope) * sense);
            margin[1] >= 0.0 && !dips(margin, slopes)
        };
        margin(0, -1.0) && margin(1, 1.0)
    }

    /// What the force that holds the contact would change in the step just made at its rates at the beginning and at the end (N).
    fn holding_slopes(&self) -> [f64; 2] {
        let Some(holding) = &self.holding else { return [0.0; 2] };
        let row = self.assembly.structure.row(self.unknowns[FRICTION].port);
        let dt = self.levels[self.level].dt;
        // The loads of the motion have the holding one in them, which is minus the force.
        let beside = |load: &[f64], value: f64| dot(row, load) / holding.mobility - value;
        let [q, v, p] = &self.next;
        let change = beside(&self.load, self.values[FRICTION]) - beside(p, self.older[FRICTION]);
        let motions = [[q, v, p], [&self.displacement, &self.velocity, &self.load]];
        motions.map(|motion| holding.rate(motion.map(Vec::as_slice)) * dt + change)
    }

    /// Steps made with the contact sliding; where the law cannot hold it, all of them.
    pub(super) fn free_step_count(&self) -> usize {
        self.free_count
    }

    /// Where the contact was held all through a period of equal steps, goes to the steady state that the motion tends to with it held: linear,
    /// it is known from the change of modal displacements and velocities over that period. Returns whether it did.
    pub(super) fn settle_held(&mut self, change: [&[f64]; 2], steps: usize) -> bool {
        let (Some(held), Some(holding)) = (&self.levels[0].held, &self.holding) else { return false };
        let port = self.unknowns[FRICTION].port;
        if !self.is_held() || self.unknowns.len() > 1 {
            return false;
        }
        let structure = &self.assembly.structure;
        let Some(rest) = held.step.to_come(structure, port, change, steps) else { return false };
        for (motion, rest) in [&mut self.displacement, &mut self.velocity].into_iter().zip(rest) {
            add(motion, &rest, 1.0);
        }
        let row = structure.row(port);
        add(&mut self.load, row, -self.values[FRICTION]);
        let force = holding.force([&self.displacement, &self.velocity, &self.load].map(Vec::as_slice));
        add(&mut self.load, row, -force);
        for values in [&mut self.values, &mut self.older, &mut self.oldest] {
            values[FRICTION] = -force;
        }
        self.read_present();
        true
    }

    /// The contact as the motion has it.
    fn read_present(&mut self) {
        let Some(contact) = &self.assembly.friction else { return };
        let slip = self.displacement(contact.slip_port);
        let under = contact.normal.port.map_or(0.0, |port| self.displacement(port));
        let normal = contact.normal.force(under, self.time);
        self.moment = Moment { slip, normal, friction: -self.values[FRICTION], ..self.moment };
        self.grip = self.grip();
    }

    /// Lets go or holds, after one of the shortest steps, of which it is known whether the contact was held or slid all through it.
    pub(super) fn change_grip(&mut self, all_through: bool) {
        let Some(mut grip) = self.grip else { return };
        if all_through {
            return;
        }
        if grip.held {
            grip.held = false;
            self.grip = Some(grip);
        } else if grip.rests {
            self.moment.velocity = 0.0;
            self.grip = self.grip();
        }
        // What follows does not go on from what was before.
        self.older[FRICTION] = self.values[FRICTION];
        self.oldest[FRICTION] = self.values[FRICTION];
    }
}
