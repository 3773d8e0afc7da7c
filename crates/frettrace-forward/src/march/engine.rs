//! The march itself.

use frettrace_friction::FrictionLaw;

use super::assembly::{Assembly, FrictionContact};
use super::held::Holding;
use super::implicit::{Kind, Unknown, ports, unknowns};
use super::refine::{Level, SHARE, levels};
use super::stick::Grip;

/// What is known of the contact at one sample.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Moment {
    /// Time (s).
    pub time: f64,
    /// Slip (m).
    pub slip: f64,
    /// Slip velocity (m/s).
    pub velocity: f64,
    /// Normal force (N).
    pub normal: f64,
    /// Friction force (N).
    pub friction: f64,
}

/// A march in progress.
#[derive(Clone, Debug)]
pub struct March<'a, L: FrictionLaw<f64>> {
    pub(super) assembly: &'a Assembly<L>,
    pub(super) time: f64,
    /// The step and its halvings, and the one in use.
    pub(super) levels: Vec<Level>,
    pub(super) level: usize,
    pub(super) share: f64,
    pub(super) displacement: Vec<f64>,
    pub(super) velocity: Vec<f64>,
    pub(super) load: Vec<f64>,
    /// Loads known in time, at the last sample.
    pub(super) known: Vec<f64>,
    pub(super) unknowns: Vec<Unknown>,
    /// Ports read at every step: those of the unknown loads and of the contact.
    pub(super) ports: Vec<usize>,
    pub(super) free: Vec<[f64; 2]>,
    /// Unknown loads at the last sample and the two before it.
    pub(super) values: Vec<f64>,
    pub(super) older: Vec<f64>,
    pub(super) oldest: Vec<f64>,
    /// Time between the last sample and the one before it (s).
    pub(super) span: f64,
    pub(super) scale: f64,
    /// Steps marched, those taken back included.
    pub(super) count: usize,
    /// Those of them in which the contact was not held.
    pub(super) free_count: usize,
    pub(super) state: Option<L::State>,
    pub(super) moment: Moment,
    /// Where the law is set-valued at rest, whether the contact is held.
    pub(super) grip: Option<Grip>,
    pub(super) holding: Option<Holding>,
    /// Loads beside the held one at both ends of the step.
    pub(super) beside: [Vec<f64>; 2],
    /// What the propagation of a step writes before the implicit loads are known.
    pub(super) next: [Vec<f64>; 3],
}

impl<'a, L: FrictionLaw<f64>> March<'a, L> {
    /// A march from rest with step `dt` (s).
    #[must_use]
    pub fn new(assembly: &'a Assembly<L>, dt: f64) -> Self {
        let modes = assembly.structure.mode_count();
        let zero = vec![0.0; modes];
        let unknowns = unknowns(assembly);
        let ports = ports(assembly, &unknowns);
        let mut march = Self {
            assembly,
            time: 0.0,
            levels: Vec::new(),
            level: 0,
            share: SHARE,
            displacement: zero.clone(),
            velocity: zero.clone(),
            load: zero.clone(),
            known: vec![0.0; assembly.inputs.len()],
            free: vec![[0.0; 2]; ports.len()],
            values: vec![0.0; unknowns.len()],
            older: vec![0.0; unknowns.len()],
            oldest: vec![0.0; unknowns.len()],
            span: dt,
            scale: 0.0,
            count: 0,
            free_count: 0,
            state: assembly.friction.as_ref().map(|f| f.law.rest()),
            moment: Moment::default(),
            grip: None,
            holding: None,
            beside: [Vec::new(), Vec::new()],
            next: [zero.clone(), zero.clone(), zero],
            unknowns,
            ports,
        };
        if let Some(contact) = &assembly.friction {
            march.moment.normal = contact.normal.force(0.0, 0.0);
        }

        march.set_step(dt);
        // Bounds of a contact at rest are those of a step at rest, whatever its length.
        march.grip = march.grip();
        march.add_held_levels();
        march
    }

    /// Goes on with another step (s).
    pub fn set_step(&mut self, dt: f64) {
        let structure = &self.assembly.structure;
        self.levels = levels(structure, [dt, self.share], (&self.ports, &self.unknowns));
        self.add_held_levels();
        self.level = 0;
        self.span = dt;
        for unknown in &mut self.unknowns {
            unknown.slope = 1.0;
        }
        self.older.copy_from_slice(&self.values);
    }

    /// Halves steps in which the error of an implicit load's impulse exceeds `share` of the largest load's over the whole
    /// step: 2e-4 if nothing is said, 1 never halves.
    pub fn set_refinement(&mut self, share: f64) {
        self.share = share;
        self.set_step(self.levels[0].dt);
    }

    /// Displacement of a port per unit load at the same port at the end of one step (m/N).
    #[must_use]
    pub fn step_compliance(&self, port: usize) -> f64 {
        self.levels[0].response(&self.assembly.structure, port, port)[0]
    }

    /// Time (s).
    #[must_use]
    pub fn time(&self) -> f64 {
        self.time
    }

    /// Sets the clock without moving anything (s).
    pub fn set_time(&mut self, time: f64) {
        self.time = time;
    }

    /// Steps marched so far, with those that were taken back and halved.
    #[must_use]
    pub fn step_count(&self) -> usize {
        self.count
    }

    /// The contact at the last sample.
    #[must_use]
    pub fn moment(&self) -> Moment {
        self.moment
    }

    /// Last values of the local loads (N), in the order of the assembly.
    pub fn local_loads(&self) -> impl Iterator<Item = f64> + '_ {
        let local = |u: &Unknown| matches!(u.kind, Kind::Local(_));
        self.unknowns.iter().zip(&self.values).filter(move |(u, _)| local(u)).map(|(_, &value)| value)
    }

    /// Modal displacements and velocities.
    #[must_use]
    pub fn modal_state(&self) -> [&[f64]; 2] {
        [&self.displacement, &self.velocity]
    }

    /// `ω_n q_n` and `q̇_n` of all modes: the sum of their squares is twice the energy.
    #[must_use]
    pub fn energy_coordinates(&self) -> Vec<f64> {
        let frequency = self.assembly.structure.natural_frequency();
        let displacement = self.displacement.iter().zip(frequency).map(|(q, w)| q * w);
        displacement.chain(self.velocity.iter().copied()).collect()
    }

    /// The lowest natural frequency (rad/s).
    #[must_use]
    pub fn slowest_frequency(&self) -> f64 {
        self.assembly.structure.natural_frequency().iter().copied().fold(f64::INFINITY, f64::min)
    }

    /// Number of loads known in time.
    #[must_use]
    pub fn input_count(&self) -> usize {
        self.assembly.inputs.len()
    }

    /// Displacement of a port (m).
    #[must_use]
    pub fn displacement(&self, port: usize) -> f64 {
        dot(self.assembly.structure.row(port), &self.displacement)
    }

    /// Acceleration of a port (m/s²).
    #[must_use]
    pub fn acceleration(&self, port: usize) -> f64 {
        let structure = &self.assembly.structure;
        let row = structure.row(port);
        let (frequency, ratio) = (structure.natural_frequency(), structure.damping_ratio());
        (0..row.len())
            .map(|n| {
                let w = frequency[n];
                row[n] * (self.load[n] - w * (2.0 * ratio[n] * self.velocity[n] + w * self.displacement[n]))
            })
            .sum()
    }

    /// One step; `known` holds the input loads (N) at the new sample. They are linear over the step.
    pub fn step(&mut self, known: &[f64]) {
        self.advance(0, 1.0, known);
        self.known.copy_from_slice(known);
    }

    /// Displacement and velocity of the port number `place` with the present loads.
    pub(super) fn motion(&self, place: usize) -> [f64; 2] {
        let width = self.unknowns.len();
        let gains = &self.compliance()[place * width..(place + 1) * width];
        let mut motion = self.free[place];
        for (gain, value) in gains.iter().zip(&self.values) {
            motion[0] += gain[0] * value;
            motion[1] += gain[1] * value;
        }
        motion
    }

    /// The contact with the loads just solved.
    pub(super) fn observe(&self, contact: &FrictionContact<L>) -> Moment {
        let [slip, velocity] = self.motion(0);
        Moment {
            time: self.time,
            slip,
            velocity,
            normal: self.normal_now(&contact.normal),
            friction: -self.values[0],
        }
    }
}

/// Scalar product in four sums, which processors form side by side.
pub(super) fn dot(a: &[f64], b: &[f64]) -> f64 {
    let (fours, others) = (a.chunks_exact(4), b.chunks_exact(4));
    let rest: f64 = fours.remainder().iter().zip(others.remainder()).map(|(x, y)| x * y).sum();
    let sums = fours.zip(others).fold([0.0; 4], |sums, (x, y)| [0, 1, 2, 3].map(|k| sums[k] + x[k] * y[k]));
    (sums[0] + sums[1]) + (sums[2] + sums[3]) + rest
}
