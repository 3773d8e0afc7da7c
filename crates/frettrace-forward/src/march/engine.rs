//! The march itself.

use frettrace_friction::FrictionLaw;

use super::assembly::{Assembly, FrictionContact};
use super::implicit::{Kind, Unknown, ports, unknowns};
use super::propagator::Propagator;
use super::structure::Structure;

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
    pub(super) dt: f64,
    pub(super) time: f64,
    propagator: Propagator,
    displacement: Vec<f64>,
    velocity: Vec<f64>,
    load: Vec<f64>,
    pub(super) unknowns: Vec<Unknown>,
    /// Ports read at every step: those of the unknown loads and of the contact.
    pub(super) ports: Vec<usize>,
    /// Motion at `ports` per unit of each unknown load at the new sample: displacement and velocity.
    pub(super) compliance: Vec<[f64; 2]>,
    pub(super) free: Vec<[f64; 2]>,
    pub(super) values: Vec<f64>,
    pub(super) older: Vec<f64>,
    pub(super) scale: f64,
    pub(super) state: Option<L::State>,
    pub(super) moment: Moment,
    /// What the propagation of a step writes before the implicit loads are known.
    next: [Vec<f64>; 3],
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
            dt,
            time: 0.0,
            propagator: Propagator::default(),
            displacement: zero.clone(),
            velocity: zero.clone(),
            load: zero.clone(),
            free: vec![[0.0; 2]; ports.len()],
            values: vec![0.0; unknowns.len()],
            older: vec![0.0; unknowns.len()],
            scale: 0.0,
            state: assembly.friction.as_ref().map(|f| f.law.rest()),
            moment: Moment::default(),
            next: [zero.clone(), zero.clone(), zero],
            compliance: Vec::new(),
            unknowns,
            ports,
        };
        if let Some(contact) = &assembly.friction {
            march.moment.normal = contact.normal.force(0.0, 0.0);
        }
        march.set_step(dt);
        march
    }

    /// Goes on with another step (s).
    pub fn set_step(&mut self, dt: f64) {
        let structure = &self.assembly.structure;
        self.dt = dt;
        self.propagator = Propagator::new(structure.natural_frequency(), structure.damping_ratio(), dt);
        self.compliance = self
            .ports
            .iter()
            .flat_map(|&output| self.unknowns.iter().map(move |unknown| (output, unknown.port)))
            .map(|(output, input)| step_response(structure, &self.propagator, output, input))
            .collect();
        for (index, unknown) in self.unknowns.iter_mut().enumerate() {
            unknown.slope = 1.0;
            self.older[index] = self.values[index];
        }
    }

    /// Displacement of a port per unit load at the same port at the end of one step (m/N).
    #[must_use]
    pub fn step_compliance(&self, port: usize) -> f64 {
        step_response(&self.assembly.structure, &self.propagator, port, port)[0]
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

    /// One step; `known` holds the input loads (N) at the new sample.
    pub fn step(&mut self, known: &[f64]) {
        self.time += self.dt;
        self.propagate(known);
        self.read_free();
        let state = self.solve();
        self.correct();
        if let Some(contact) = &self.assembly.friction {
            self.moment = self.observe(contact);
            self.state = state;
        }
    }

    /// Advances all modes under the known loads.
    fn propagate(&mut self, known: &[f64]) {
        let [displacement, velocity, load] = &mut self.next;
        load.fill(0.0);
        for (&port, &value) in self.assembly.inputs.iter().zip(known) {
            for (entry, shape) in load.iter_mut().zip(self.assembly.structure.row(port)) {
                *entry += shape * value;
            }
        }
        let p = &self.propagator;
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
    fn read_free(&mut self) {
        let [displacement, velocity, _] = &self.next;
        for (free, &port) in self.free.iter_mut().zip(&self.ports) {
            let row = self.assembly.structure.row(port);
            *free = [dot(row, displacement), dot(row, velocity)];
        }
    }

    /// Displacement and velocity of the port number `place` with the present loads.
    pub(super) fn motion(&self, place: usize) -> [f64; 2] {
        let width = self.unknowns.len();
        let gains = &self.compliance[place * width..(place + 1) * width];
        let mut motion = self.free[place];
        for (gain, value) in gains.iter().zip(&self.values) {
            motion[0] += gain[0] * value;
            motion[1] += gain[1] * value;
        }
        motion
    }

    /// Takes the implicit loads into the motion.
    fn correct(&mut self) {
        let structure = &self.assembly.structure;
        let [displacement, velocity, load] = &mut self.next;
        let gains = &self.propagator.from_new_load;
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
        std::mem::swap(displacement, &mut self.displacement);
        std::mem::swap(velocity, &mut self.velocity);
        std::mem::swap(load, &mut self.load);
    }

    /// The contact with the loads just solved.
    fn observe(&self, contact: &FrictionContact<L>) -> Moment {
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

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(x, y)| x * y).sum()
}

/// Displacement and velocity of `output` at the end of a step per unit load at `input` at its end.
fn step_response(structure: &Structure, propagator: &Propagator, output: usize, input: usize) -> [f64; 2] {
    let shapes = structure.row(output).iter().zip(structure.row(input));
    let gains = propagator.from_new_load[0].iter().zip(&propagator.from_new_load[1]);
    shapes.zip(gains).fold([0.0; 2], |sum, ((a, b), (q, v))| [sum[0] + a * b * q, sum[1] + a * b * v])
}
