//! A random rig of finite elements, marched in time under prescribed forces. Nothing of it knows lines, receptances or laws.

use frettrace_beam::{BeamError, Boundary, Dof, FiniteElements, ModalModel, ModalOptions, UniformBeam};
use frettrace_inverse::{ModeTrust, Rig, RunData, Sensor, Slip};
use rand::{RngExt, SeedableRng};
use rand_distr::StandardNormal;
use rand_pcg::Pcg64;
use std::f64::consts::TAU;

const RATE: f64 = 4096.0;
const SAMPLES: usize = 2048;
/// Marched steps a sample. Forces are linear between them: they lose `(ωΔt)²/12` of a line, 6e-5 at 500 Hz.
const SUBSTEPS: usize = 16;
/// Modes whose phase turns by more than this in a step answer without inertia.
const QUASI_STATIC: f64 = 1.0;
const ELEMENTS: usize = 40;
const DECLARED_MODES: usize = 6;
const FREQUENCY_STD: f64 = 1e-4;
const DAMPING_STD: f64 = 5e-3;
const SUPPORT_STIFFNESS: f64 = 5e6;
const YOUNGS_MODULUS: f64 = 2.05e11;
const DENSITY: f64 = 7850.0;

/// What a rig is drawn with.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Draw {
    pub sensors: usize,
    /// Whether all sensors sit within a fifth of the beam, anywhere.
    pub badly_placed: bool,
    /// Noise over the root mean square of the accelerations.
    pub noise: f64,
}

/// Whether the friction force has a period.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Motion {
    /// That of the excitation.
    Periodic,
    /// None: a broad spectrum beside the lines of the excitation, down to motions slower than the record.
    Wandering,
}

/// What was recorded, and the truth.
pub struct Record {
    pub rig: Rig,
    pub frequency: f64,
    force: Vec<f64>,
    accelerations: Vec<Vec<f64>>,
    pub friction: Vec<f64>,
    pub slip: Vec<f64>,
    pub velocity: Vec<f64>,
}

impl Record {
    pub fn run(&self) -> RunData<'_> {
        RunData {
            id: "0001",
            sampling_rate: RATE,
            excitation_frequency: self.frequency,
            preload: 50.0,
            force: &self.force,
            accelerations: self.accelerations.iter().map(Vec::as_slice).collect(),
        }
    }
}

/// The rig of a seed, what it is drawn with, and its record.
///
/// # Errors
/// [`BeamError`] where the beam cannot be computed.
pub fn record(seed: u64, motion: Motion) -> Result<(Draw, Record), BeamError> {
    let mut random = Pcg64::seed_from_u64(seed);
    let draw = Draw {
        sensors: random.random_range(3..=8),
        badly_placed: seed.is_multiple_of(3),
        noise: 10.0_f64.powf(random.random_range(-3.0..-1.3)),
    };
    let marched = Marched::new(&draw, &mut random)?;
    let wander = match motion {
        Motion::Periodic => Vec::new(),
        // Numbers of its own: the rig is that of the periodic record.
        Motion::Wandering => wander(&mut Pcg64::seed_from_u64(!seed)),
    };
    let mut record = marched.march(wander, &mut random)?;
    let power: f64 = record.accelerations.iter().flatten().map(|a| a * a).sum();
    let noise = draw.noise * (power / (draw.sensors * SAMPLES) as f64).sqrt();
    for value in record.accelerations.iter_mut().flatten() {
        *value += noise * random.sample::<f64, _>(StandardNormal);
    }
    // Every other laboratory knows its noise.
    if seed.is_multiple_of(2) {
        record.rig.sensors.iter_mut().for_each(|sensor| sensor.noise_std = Some(noise));
    }
    Ok((draw, record))
}

struct Marched {
    beam: UniformBeam,
    thickness: f64,
    lever: f64,
    sensors: Vec<f64>,
    exciter: f64,
    damping: f64,
    frequency: Vec<f64>,
    /// Shapes at the sensors, the exciter and the slip.
    rows: Vec<Vec<f64>>,
}

impl Marched {
    fn new(draw: &Draw, random: &mut Pcg64) -> Result<Self, BeamError> {
        let (length, thickness) = (random.random_range(0.5..0.8), random.random_range(0.005..0.008));
        let beam = UniformBeam::rectangular(length, [0.03, thickness], YOUNGS_MODULUS, DENSITY);
        let (first, span) =
            if draw.badly_placed { (random.random_range(0.1..0.75), 0.2) } else { (0.12, 0.82) };
        let sensors = (0..draw.sensors)
            .map(|s| {
                let place = (s as f64 + random.random_range(0.2..0.8)) / draw.sensors as f64;
                length * (first + span * place)
            })
            .collect::<Vec<f64>>();
        let exciter = length * 0.4;
        let lever = 0.5 * thickness;
        let mut elements = FiniteElements::clamped(&beam, ELEMENTS)?;
        elements.add_spring(Dof::displacement(length), SUPPORT_STIFFNESS);
        let modes = elements.eigenmodes()?;
        let mut points: Vec<(Dof, f64)> = sensors.iter().map(|x| (Dof::displacement(*x), 1.0)).collect();
        points.extend([(Dof::displacement(exciter), 1.0), (Dof::rotation(length), lever)]);
        let rows = points
            .iter()
            .map(|(dof, scale)| {
                let row = elements.row(*dof);
                let shape = |n: usize| (0..row.len()).map(|i| row[i] * modes.modes[(i, n)]).sum::<f64>();
                (0..row.len()).map(|n| scale * shape(n)).collect()
            })
            .collect();
        let damping = random.random_range(0.01..0.03);
        Ok(Self {
            beam,
            thickness,
            lever,
            sensors,
            exciter,
            damping,
            frequency: modes.natural_frequency,
            rows,
        })
    }

    /// The rig as a laboratory would declare it: modes with errors of the stated size, no word of the noise.
    fn declared(&self, random: &mut Pcg64) -> Result<Rig, BeamError> {
        let mut off = |std: f64| 1.0 + std * random.sample::<f64, _>(StandardNormal);
        let natural_frequency: Vec<f64> =
            self.frequency[..DECLARED_MODES].iter().map(|w| w * off(FREQUENCY_STD)).collect();
        let damping_ratio = (0..DECLARED_MODES).map(|_| self.damping * off(DAMPING_STD)).collect();
        let options = ModalOptions { modes: 30, natural_frequency, damping_ratio, ..ModalOptions::default() };
        Ok(Rig {
            structure: ModalModel::new(&self.beam, &Boundary::spring(SUPPORT_STIFFNESS), &options)?,
            trust: vec![ModeTrust { frequency: FREQUENCY_STD, damping: DAMPING_STD }; DECLARED_MODES],
            beam_modes: self.beam_modes(),
            slip: Slip::Rotation { lever_arm: self.lever },
            normal_stiffness: SUPPORT_STIFFNESS,
            second_support: None,
            exciter: self.exciter,
            sensors: self.sensors.iter().map(|&position| Sensor { position, noise_std: None }).collect(),
        })
    }

    fn beam_modes(&self) -> usize {
        (self.beam.length / (3.0 * self.thickness)) as usize
    }

    /// What the contact yields beyond beam theory (m/N): normal about none, as widely as half of what the theory has there.
    fn extra_compliance(&self, random: &mut Pcg64) -> Result<f64, BeamError> {
        let options = ModalOptions { modes: self.beam_modes(), ..ModalOptions::default() };
        let model = ModalModel::new(&self.beam, &Boundary::spring(SUPPORT_STIFFNESS), &options)?;
        let end = Dof::rotation(self.beam.length);
        let drawn: f64 = random.sample(StandardNormal);
        Ok(0.5 * drawn * self.lever * self.lever * model.residual(end, end))
    }

    fn march(&self, wander: Vec<Wave>, random: &mut Pcg64) -> Result<Record, BeamError> {
        let frequency = self.frequency[0] / TAU * random.random_range(0.95..1.35);
        let size = 20.0 * random.random_range(0.5..2.0);
        let forces = Forces { frequency, size, wander };
        let compliance = self.extra_compliance(random)?;
        let mut record = Record {
            rig: self.declared(random)?,
            frequency,
            force: Vec::with_capacity(SAMPLES),
            accelerations: vec![Vec::with_capacity(SAMPLES); self.sensors.len()],
            friction: Vec::with_capacity(SAMPLES),
            slip: Vec::with_capacity(SAMPLES),
            velocity: Vec::with_capacity(SAMPLES),
        };
        let step = 1.0 / (RATE * SUBSTEPS as f64);
        let dynamic = self.frequency.iter().take_while(|w| **w * step < QUASI_STATIC).count();
        let steppers: Vec<Stepper> =
            self.frequency[..dynamic].iter().map(|w| Stepper::new(*w, self.damping, step)).collect();
        let mut state = vec![(0.0, 0.0); dynamic];
        // A transient of 6e-6 is left.
        let settling = (12.0 / (self.damping * self.frequency[0]) * RATE).ceil() as usize;
        let mut now = forces.at(0.0);
        for j in 0..(settling + SAMPLES) * SUBSTEPS {
            let t = j as f64 * step;
            if j % SUBSTEPS == 0 && j / SUBSTEPS >= settling {
                self.write(&forces, t, &state, compliance, &mut record);
            }
            let next = forces.at(t + step);
            for (n, (stepper, at)) in steppers.iter().zip(&mut state).enumerate() {
                *at = stepper.advance(*at, (self.load(now, n), self.load(next, n)));
            }
            now = next;
        }
        Ok(record)
    }

    /// Generalised force of a mode.
    fn load(&self, [exciter, friction]: [f64; 2], mode: usize) -> f64 {
        let last = self.rows.len() - 1;
        self.rows[last - 1][mode] * exciter - self.rows[last][mode] * friction
    }

    fn write(&self, forces: &Forces, t: f64, state: &[(f64, f64)], compliance: f64, record: &mut Record) {
        let (now, slope, bend) = (forces.at(t), forces.slope(t), forces.bend(t));
        let slip = &self.rows[self.rows.len() - 1];
        let (mut u, mut v) = (-compliance * now[1], -compliance * slope[1]);
        let mut a = vec![0.0; self.sensors.len()];
        for (n, w) in self.frequency.iter().enumerate() {
            let square = w * w;
            let (q, rate) = state
                .get(n)
                .copied()
                .unwrap_or_else(|| (self.load(now, n) / square, self.load(slope, n) / square));
            u += slip[n] * q;
            v += slip[n] * rate;
            // Modes without inertia follow the force, accelerations too: what they add is small, and all that tells some structures.
            let acceleration = if n < state.len() {
                self.load(now, n) - 2.0 * self.damping * w * rate - square * q
            } else {
                self.load(bend, n) / square
            };
            a.iter_mut().zip(&self.rows).for_each(|(a, row)| *a += row[n] * acceleration);
        }
        record.accelerations.iter_mut().zip(a).for_each(|(channel, a)| channel.push(a));
        record.force.push(now[0]);
        record.friction.push(now[1]);
        record.slip.push(u);
        record.velocity.push(v);
    }
}

/// A share of the friction force besides the periodic one: amplitude, frequency over that of the excitation, phase.
type Wave = (f64, f64, f64);

/// Waves of a force without period.
const WAVES: usize = 40;

/// A force without period: waves evenly spread over the logarithm of the frequency, from slower than the record to four times
/// the excitation, whose amplitudes fall or rise with it as drawn; 1 to 30 % of the periodic force.
fn wander(random: &mut Pcg64) -> Vec<Wave> {
    let slope = random.random_range(-0.5..0.5);
    let share = 10.0_f64.powf(random.random_range(-2.0..-0.5));
    let waves: Vec<Wave> = (0..WAVES)
        .map(|_| {
            let place = 10.0_f64.powf(random.random_range(-2.0..0.6));
            (place.powf(slope) * random.random_range(0.5..1.5), place, random.random_range(0.0..TAU))
        })
        .collect();
    let total = waves.iter().map(|(a, _, _)| a * a).sum::<f64>().sqrt();
    waves.into_iter().map(|(a, place, phase)| (share * a / total, place, phase)).collect()
}

/// Excitation, and a friction force with the harmonics of a saturating contact.
struct Forces {
    frequency: f64,
    size: f64,
    wander: Vec<Wave>,
}

impl Forces {
    fn at(&self, t: f64) -> [f64; 2] {
        let phase = TAU * self.frequency * t;
        let friction = (1.2 * (phase - 0.4).cos()).tanh() + 0.075 * (2.0 * phase).sin();
        let more: f64 = self.wander.iter().map(|(a, place, at)| a * (place * phase + at).cos()).sum();
        [0.7 * phase.cos(), self.size * (friction + more)]
    }

    fn slope(&self, t: f64) -> [f64; 2] {
        let (turn, phase) = (TAU * self.frequency, TAU * self.frequency * t);
        let saturated = (1.2 * (phase - 0.4).cos()).tanh();
        let friction =
            -1.2 * (phase - 0.4).sin() * (1.0 - saturated * saturated) + 0.15 * (2.0 * phase).cos();
        let more: f64 =
            self.wander.iter().map(|(a, place, at)| -a * place * (place * phase + at).sin()).sum();
        [-0.7 * turn * phase.sin(), self.size * turn * (friction + more)]
    }

    fn bend(&self, t: f64) -> [f64; 2] {
        let (turn, phase) = (TAU * self.frequency, TAU * self.frequency * t);
        let saturated = (1.2 * (phase - 0.4).cos()).tanh();
        let (inner, outer) = (-1.2 * (phase - 0.4).sin(), 1.0 - saturated * saturated);
        let friction = outer * (-1.2 * (phase - 0.4).cos() - 2.0 * saturated * inner * inner)
            - 0.3 * (2.0 * phase).sin();
        let more: f64 =
            self.wander.iter().map(|(a, place, at)| -a * place * place * (place * phase + at).cos()).sum();
        [-0.7 * turn * turn * phase.cos(), self.size * turn * turn * (friction + more)]
    }
}

/// Exact step of `q̈ + 2ζω q̇ + ω² q = f` under a force that is linear in time.
struct Stepper {
    frequency: f64,
    damping: f64,
    step: f64,
    damped: f64,
    decay: f64,
    sine: f64,
    cosine: f64,
}

impl Stepper {
    fn new(frequency: f64, damping: f64, step: f64) -> Self {
        let damped = frequency * (1.0 - damping * damping).sqrt();
        let (sine, cosine) = (damped * step).sin_cos();
        Self { frequency, damping, step, damped, decay: (-damping * frequency * step).exp(), sine, cosine }
    }

    fn advance(&self, (q, v): (f64, f64), (from, to): (f64, f64)) -> (f64, f64) {
        let (w, z, slope) = (self.frequency, self.damping, (to - from) / self.step);
        // Particular solution (f + s t)/ω² − 2ζ s/ω³, then the free decay of the rest.
        let particular = |f: f64| f / (w * w) - 2.0 * z * slope / w.powi(3);
        let velocity = slope / (w * w);
        let (a, b) = (q - particular(from), v - velocity);
        let c = (b + z * w * a) / self.damped;
        let free = self.decay * (a * self.cosine + c * self.sine);
        let swing = self.decay * self.damped * (c * self.cosine - a * self.sine);
        (particular(to) + free, velocity + swing - z * w * free)
    }
}
