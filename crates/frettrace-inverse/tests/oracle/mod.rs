//! An independent rig: finite elements, marched in time under prescribed forces. Nothing of it knows lines or receptances.
#![allow(dead_code)] // each test file uses its part

use frettrace_beam::{Boundary, Dof, FiniteElements, ModalModel, ModalOptions, UniformBeam};
use frettrace_inverse::{ModeTrust, Rig, RunData, Sensor, Slip};
use rand::SeedableRng;
use rand_distr::Distribution;
use std::f64::consts::TAU;

pub const LENGTH: f64 = 0.7;
pub const LEVER: f64 = 3e-3;
pub const EXCITER: f64 = 0.28;
pub const SECOND: f64 = 0.41;
pub const RATE: f64 = 4096.0;
/// Half a wavelength of three thicknesses of 6 mm.
const BEAM_MODES: usize = 38;
const DAMPING: f64 = 0.02;
/// Marched steps a sample: forces are linear between them. Linear pieces have images of the force at multiples of 65 kHz, of the
/// share `(f/65 kHz)²`, and lose as much of it: 6e-7 of a line at 50 Hz, 6e-5 at 500 Hz.
const SUBSTEPS: usize = 16;
/// Modes whose phase turns by more than this in a step answer without inertia, or the images would hit their resonances.
const QUASI_STATIC: f64 = 1.0;

/// A force as a function of time.
pub type Force<'a> = &'a dyn Fn(f64) -> f64;

/// What the rig is loaded with.
pub struct Loads<'a> {
    pub exciter: Force<'a>,
    pub friction: Force<'a>,
    pub second: Force<'a>,
    pub normal_deviation: Force<'a>,
}

pub fn nothing(_: f64) -> f64 {
    0.0
}

/// What was recorded, and the truth.
pub struct Record {
    pub force: Vec<f64>,
    pub accelerations: Vec<Vec<f64>>,
    pub friction: Vec<f64>,
    pub slip: Vec<f64>,
    pub velocity: Vec<f64>,
    pub normal: Vec<f64>,
}

impl Record {
    pub fn run(&self, frequency: f64) -> RunData<'_> {
        RunData {
            id: "0001",
            sampling_rate: RATE,
            excitation_frequency: frequency,
            preload: 50.0,
            force: &self.force,
            accelerations: self.accelerations.iter().map(Vec::as_slice).collect(),
        }
    }

    pub fn add_noise(&mut self, std: f64, seed: u64) {
        let mut random = rand_pcg::Pcg64::seed_from_u64(seed);
        let normal = rand_distr::Normal::new(0.0, std).unwrap();
        for value in self.accelerations.iter_mut().flatten() {
            *value += normal.sample(&mut random);
        }
    }
}

pub struct Oracle {
    pub stiffness: f64,
    frequency: Vec<f64>,
    rows: Vec<Vec<f64>>,
    sensors: usize,
}

pub fn beam() -> UniformBeam {
    UniformBeam::rectangular(LENGTH, [0.03, 0.006], 2.05e11, 7850.0)
}

impl Oracle {
    /// 40 elements: the tenth frequency is right to 3e-4, the first five to 2e-5.
    pub fn new(stiffness: f64, sensors: &[f64]) -> Self {
        let mut elements = FiniteElements::clamped(&beam(), 40).unwrap();
        elements.add_spring(Dof::displacement(LENGTH), stiffness);
        let modes = elements.eigenmodes().unwrap();
        let mut points: Vec<(Dof, f64)> = sensors.iter().map(|x| (Dof::displacement(*x), 1.0)).collect();
        points.push((Dof::displacement(EXCITER), 1.0));
        points.push((Dof::rotation(LENGTH), LEVER));
        points.push((Dof::displacement(SECOND), 1.0));
        points.push((Dof::displacement(LENGTH), 1.0));
        let rows = points
            .iter()
            .map(|(dof, scale)| {
                let row = elements.row(*dof);
                (0..row.len())
                    .map(|n| scale * (0..row.len()).map(|i| row[i] * modes.modes[(i, n)]).sum::<f64>())
                    .collect()
            })
            .collect();
        Self { stiffness, frequency: modes.natural_frequency, rows, sensors: sensors.len() }
    }

    /// The rig as a laboratory would declare it: the first `measured` frequencies as they are, times `1 + off`.
    pub fn declared(&self, sensors: &[f64], noise: f64, measured: usize, off: f64) -> Rig {
        let natural_frequency: Vec<f64> = self.frequency[..measured]
            .iter()
            .enumerate()
            .map(|(n, w)| w * (1.0 + off * if n % 2 == 0 { 1.0 } else { -1.0 }))
            .collect();
        let options = ModalOptions {
            modes: 30,
            natural_frequency,
            damping_ratio: vec![DAMPING; measured.max(1)],
            ..ModalOptions::default()
        };
        let trust = ModeTrust { frequency: off.abs().max(1e-5), damping: 1e-3 };
        Rig {
            structure: ModalModel::new(&beam(), &Boundary::spring(self.stiffness), &options).unwrap(),
            trust: vec![trust; measured],
            beam_modes: BEAM_MODES,
            slip: Slip::Rotation { lever_arm: LEVER },
            normal_stiffness: self.stiffness,
            second_support: None,
            exciter: EXCITER,
            sensors: sensors
                .iter()
                .map(|x| Sensor { position: *x, noise_std: (noise > 0.0).then_some(noise) })
                .collect(),
        }
    }

    /// Marches from rest for `settling` seconds, then records `samples`.
    pub fn march(&self, loads: &Loads<'_>, settling: f64, samples: usize) -> Record {
        let step = 1.0 / (RATE * SUBSTEPS as f64);
        let start = (settling * RATE) as usize;
        let steppers: Vec<Stepper> = self.frequency.iter().map(|w| Stepper::new(*w, step)).collect();
        let mut state = vec![(0.0, 0.0); steppers.len()];
        let mut record = Record {
            force: Vec::new(),
            accelerations: vec![Vec::new(); self.sensors],
            friction: Vec::new(),
            slip: Vec::new(),
            velocity: Vec::new(),
            normal: Vec::new(),
        };
        let mut now = loads.at(0.0);
        for j in 0..(start + samples) * SUBSTEPS {
            if j % SUBSTEPS == 0 && j / SUBSTEPS >= start {
                self.record(now, &state, &mut record);
            }
            let next = loads.at((j + 1) as f64 * step);
            for (n, (stepper, at)) in steppers.iter().zip(&mut state).enumerate() {
                let (from, to) = (self.modal_load(now, n), self.modal_load(next, n));
                *at = if stepper.frequency * step > QUASI_STATIC {
                    stepper.follow((from, to))
                } else {
                    stepper.advance(*at, (from, to))
                };
            }
            now = next;
        }
        record
    }

    fn modal_load(&self, loads: [f64; 4], n: usize) -> f64 {
        let row = |i: usize| self.rows[self.sensors + i][n];
        row(0) * loads[0] - row(1) * loads[1] + row(2) * loads[2] + row(3) * loads[3]
    }

    fn record(&self, loads: [f64; 4], state: &[(f64, f64)], record: &mut Record) {
        let sum = |row: &[f64], x: &dyn Fn(usize) -> f64| -> f64 {
            row.iter().enumerate().map(|(n, r)| r * x(n)).sum()
        };
        let acceleration = |n: usize| {
            let (w, (q, v)) = (self.frequency[n], state[n]);
            if w > QUASI_STATIC * RATE * SUBSTEPS as f64 {
                return 0.0;
            }
            self.modal_load(loads, n) - 2.0 * DAMPING * w * v - w * w * q
        };
        let accelerations: Vec<f64> = (0..state.len()).map(acceleration).collect();
        for (s, channel) in record.accelerations.iter_mut().enumerate() {
            channel.push(sum(&self.rows[s], &|n| accelerations[n]));
        }
        record.force.push(loads[0]);
        record.friction.push(loads[1]);
        record.slip.push(sum(&self.rows[self.sensors + 1], &|n| state[n].0));
        record.velocity.push(sum(&self.rows[self.sensors + 1], &|n| state[n].1));
        let end = sum(&self.rows[self.sensors + 3], &|n| state[n].0);
        record.normal.push(-self.stiffness * end + loads[3]);
    }
}

impl Loads<'_> {
    fn at(&self, t: f64) -> [f64; 4] {
        [(self.exciter)(t), (self.friction)(t), (self.second)(t), (self.normal_deviation)(t)]
    }
}

/// Exact step of `q̈ + 2ζω q̇ + ω² q = f` under a force that is linear in time.
struct Stepper {
    frequency: f64,
    step: f64,
    damped: f64,
    decay: f64,
    sine: f64,
    cosine: f64,
}

impl Stepper {
    fn new(frequency: f64, step: f64) -> Self {
        let damped = frequency * (1.0 - DAMPING * DAMPING).sqrt();
        let (sine, cosine) = (damped * step).sin_cos();
        Self { frequency, step, damped, decay: (-DAMPING * frequency * step).exp(), sine, cosine }
    }

    /// Displacement and velocity without inertia.
    fn follow(&self, (from, to): (f64, f64)) -> (f64, f64) {
        let square = self.frequency * self.frequency;
        (to / square, (to - from) / self.step / square)
    }

    fn advance(&self, (q, v): (f64, f64), (from, to): (f64, f64)) -> (f64, f64) {
        let (w, slope) = (self.frequency, (to - from) / self.step);
        // Particular solution (f + s t)/ω² − 2ζ s/ω³, then the free decay of the rest.
        let particular = |f: f64| f / (w * w) - 2.0 * DAMPING * slope / w.powi(3);
        let velocity = slope / (w * w);
        let (a, b) = (q - particular(from), v - velocity);
        let c = (b + DAMPING * w * a) / self.damped;
        let free = self.decay * (a * self.cosine + c * self.sine);
        let swing = self.decay * self.damped * (c * self.cosine - a * self.sine);
        (particular(to) + free, velocity + swing - DAMPING * w * free)
    }
}

/// Relative root mean square of the difference, means removed.
pub fn error(found: &[f64], truth: &[f64]) -> f64 {
    let centred = |x: &[f64]| {
        let mean = x.iter().sum::<f64>() / x.len() as f64;
        x.iter().map(|v| v - mean).collect::<Vec<_>>()
    };
    let (a, b) = (centred(found), centred(truth));
    let power = |x: &mut dyn Iterator<Item = f64>| x.map(|v| v * v).sum::<f64>();
    (power(&mut a.iter().zip(&b).map(|(x, y)| x - y)) / power(&mut b.iter().copied())).sqrt()
}

/// A friction force with the harmonics of a saturating contact.
pub fn saturating(frequency: f64, t: f64) -> f64 {
    20.0 * (1.2 * (TAU * frequency * t - 0.4).cos()).tanh() + 1.5 * (2.0 * TAU * frequency * t).sin()
}
