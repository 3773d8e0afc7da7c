//! Halved steps where the implicit loads are not straight lines.
//!
//! A load that jumps or bends inside a step is held as a straight line over it, with an error of its impulse of about
//! `Δt/12 · |p₁ − p̂₁|`, where `p̂₁` continues the line of the step before. Where that exceeds a share of the largest load's
//! impulse over a whole step, the step is taken back and its halves are marched, each judged alike. Loads known in time are
//! linear over the whole step, so that halving changes nothing but the implicit ones.
//!
//! In the shortest steps the implicit loads are constants instead of lines. A contact that begins to stick in mid-step needs
//! the mean force of that step; a line from the old force to a new one that has this mean overshoots, and the constraint of
//! no slip then carries the overshoot with alternating sign from step to step. A constant has nothing to carry.

use frettrace_friction::FrictionLaw;

use super::engine::{March, Moment, dot};
use super::implicit::Unknown;
use super::propagator::Propagator;
use super::stick::{Grip, HeldLevel};
use super::structure::Structure;

/// Error of a load's impulse in a step, relative to the largest load's over a whole step, that makes the step be halved.
pub(super) const SHARE: f64 = 2e-4;
/// Most halvings of a step.
const DEEPEST: usize = 24;

/// Steps halved equally often.
#[derive(Clone, Debug)]
pub(super) struct Level {
    pub(super) dt: f64,
    propagator: Propagator,
    /// Displacement and velocity of the modes per unit of an implicit modal load at the end of the step.
    gain: [Vec<f64>; 2],
    /// Whether the implicit loads are constant over the step.
    pub(super) constant: bool,
    /// The same step with the contact held, where its law can.
    pub(super) held: Option<HeldLevel>,
    /// Motion at the march's ports per unit of each implicit load: displacement and velocity.
    pub(super) compliance: Vec<[f64; 2]>,
}

impl Level {
    fn new(structure: &Structure, dt: f64, constant: bool) -> Self {
        let propagator = Propagator::new(structure.natural_frequency(), structure.damping_ratio(), dt);
        let gain = [0, 1].map(|row| {
            let ends = propagator.from_old_load[row].iter().zip(&propagator.from_new_load[row]);
            ends.map(|(old, new)| if constant { old + new } else { *new }).collect()
        });
        Self { dt, propagator, gain, constant, held: None, compliance: Vec::new() }
    }

    /// Displacement and velocity of `output` at the end of a step per unit of an implicit load at `input`.
    pub(super) fn response(&self, structure: &Structure, output: usize, input: usize) -> [f64; 2] {
        let shapes = structure.row(output).iter().zip(structure.row(input));
        let gains = self.gain[0].iter().zip(&self.gain[1]);
        shapes.zip(gains).fold([0.0; 2], |sum, ((a, b), (q, v))| [sum[0] + a * b * q, sum[1] + a * b * v])
    }
}

/// The whole step and its halvings, the last of them so short that a jump in it is within the share.
pub(super) fn levels(
    structure: &Structure,
    [dt, share]: [f64; 2],
    (ports, unknowns): (&[usize], &[Unknown]),
) -> Vec<Level> {
    // A reversal is a jump by twice the load: `(h/Δt) · 2/12` is the share.
    let halvings = if unknowns.is_empty() { 0.0 } else { (1.0 / (6.0 * share)).log2().ceil() };
    let halvings = (halvings.max(0.0) as usize).min(DEEPEST);
    (0..=halvings)
        .map(|level| {
            let constant = level > 0 && level == halvings;
            let mut one = Level::new(structure, dt * 0.5_f64.powi(level as i32), constant);
            let pairs = ports.iter().flat_map(|&port| unknowns.iter().map(move |u| (port, u.port)));
            one.compliance = pairs.map(|(output, input)| one.response(structure, output, input)).collect();
            one
        })
        .collect()
}

/// What a step that is taken back leaves as it was, besides the motion.
#[derive(Clone, Copy)]
struct Before<S> {
    grip: Option<Grip>,
    state: Option<S>,
    moment: Moment,
    time: f64,
    span: f64,
    scale: f64,
}

impl<L: FrictionLaw<f64>> March<'_, L> {
    /// From where the march is to the share `end` of the whole step, by a step halved `level` times or by its halves.
    pub(super) fn advance(&mut self, level: usize, end: f64, known: &[f64]) {
        let before = Before {
            grip: self.grip,
            state: self.state,
            moment: self.moment,
            time: self.time,
            span: self.span,
            scale: self.scale,
        };
        self.level = level;
        let all_through = self.try_step(end, known);
        if level + 1 == self.levels.len() {
            return self.change_grip(all_through);
        }
        if all_through && self.defect(before.span) <= self.share * self.scale {
            return;
        }
        self.take_back(&before);
        let half = 0.5_f64.powi(level as i32 + 1);
        self.advance(level + 1, end - half, known);
        self.advance(level + 1, end, known);
    }

    /// Error of the impulse of the worst implicit load, over the duration of a whole step (N).
    fn defect(&self, span: f64) -> f64 {
        let dt = self.levels[self.level].dt;
        // A held contact's force is exact.
        let loads = self.values.iter().zip(&self.older).zip(&self.oldest).skip(usize::from(self.is_held()));
        let largest = loads
            .map(|((new, old), older)| (new - old - (old - older) * (dt / span)).abs())
            .fold(0.0, f64::max);
        largest * dt / (12.0 * self.levels[0].dt)
    }

    fn take_back(&mut self, before: &Before<L::State>) {
        self.swap_motion();
        self.values.copy_from_slice(&self.older);
        self.older.copy_from_slice(&self.oldest);
        Before {
            grip: self.grip,
            state: self.state,
            moment: self.moment,
            time: self.time,
            span: self.span,
            scale: self.scale,
        } = *before;
    }

    /// Advances all modes under the known loads, which are at the share `end` of their way to `known`.
    pub(super) fn propagate(&mut self, end: f64, known: &[f64]) {
        let structure = &self.assembly.structure;
        let level = &self.levels[self.level];
        let [displacement, velocity, load] = &mut self.next;
        load.fill(0.0);
        let inputs = self.assembly.inputs.iter().zip(&self.known).zip(known);
        for ((&port, old), new) in inputs {
            add(load, structure.row(port), old + (new - old) * end);
        }
        if level.constant {
            for (unknown, value) in self.unknowns.iter().zip(&self.values) {
                add(&mut self.load, structure.row(unknown.port), -value);
            }
        }
        let p = &level.propagator;
        for (row, target) in [displacement, velocity].into_iter().enumerate() {
            let old = self.displacement.iter().zip(&self.velocity).zip(&self.load).zip(load.iter());
            let coefficients = p.from_displacement[row]
                .iter()
                .zip(&p.from_velocity[row])
                .zip(p.from_old_load[row].iter().zip(&p.from_new_load[row]));
            for ((entry, (((q, v), p0), p1)), ((a, b), (c, d))) in
                target.iter_mut().zip(old).zip(coefficients)
            {
                *entry = a * q + b * v + c * p0 + d * p1;
            }
        }
    }

    /// Motion of the ports without the implicit loads.
    pub(super) fn read_free(&mut self) {
        let [displacement, velocity, _] = &self.next;
        for (free, &port) in self.free.iter_mut().zip(&self.ports) {
            let row = self.assembly.structure.row(port);
            *free = [dot(row, displacement), dot(row, velocity)];
        }
    }

    /// Takes the implicit loads into the motion.
    pub(super) fn correct(&mut self) {
        let structure = &self.assembly.structure;
        let [displacement, velocity, load] = &mut self.next;
        let gains = &self.levels[self.level].gain;
        for (unknown, &value) in self.unknowns.iter().zip(&self.values) {
            let entries = displacement.iter_mut().zip(velocity.iter_mut()).zip(load.iter_mut());
            let shapes = structure.row(unknown.port).iter().zip(gains[0].iter().zip(&gains[1]));
            for (((q, v), p), (shape, (to_q, to_v))) in entries.zip(shapes) {
                let share = shape * value;
                *p += share;
                *q += to_q * share;
                *v += to_v * share;
            }
        }
        self.swap_motion();
    }

    /// The motion at the end of the step becomes the present one, and back.
    pub(super) fn swap_motion(&mut self) {
        let [displacement, velocity, load] = &mut self.next;
        std::mem::swap(displacement, &mut self.displacement);
        std::mem::swap(velocity, &mut self.velocity);
        std::mem::swap(load, &mut self.load);
    }
}

pub(super) fn add(load: &mut [f64], shape: &[f64], value: f64) {
    for (entry, shape) in load.iter_mut().zip(shape) {
        *entry += shape * value;
    }
}
