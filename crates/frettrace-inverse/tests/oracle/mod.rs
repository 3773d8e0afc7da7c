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
const DAMPING: f64 = 0.02;
/// Marched steps a sample: forces are linear between them.
const SUBSTEPS: usize = 4;

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
        let modes = self.frequency.len();
        let (mut q, mut v) = (vec![0.0; modes], vec![0.0; modes]);
        let mut record = Record {
            force: Vec::new(),
            accelerations: vec![Vec::new(); self.sensors],
            friction: Vec::new(),
            slip: Vec::new(),
            velocity: Vec::new(),
            normal: Vec::new(),
        };
        for j in 0..(start + samples) * SUBSTEPS {
            let t = j as f64 * step;
            if j % SUBSTEPS == 0 && j / SUBSTEPS >= start {
                self.record(loads, t, (&q, &v), &mut record);
            }
            for n in 0..modes {
                let (from, to) = (self.modal_load(loads, t, n), self.modal_load(loads, t + step, n));
                (q[n], v[n]) = advance((q[n], v[n]), (from, to), self.frequency[n], step);
            }
        }
        record
    }

    fn modal_load(&self, loads: &Loads<'_>, t: f64, n: usize) -> f64 {
        let row = |i: usize| self.rows[self.sensors + i][n];
        row(0) * (loads.exciter)(t) - row(1) * (loads.friction)(t)
            + row(2) * (loads.second)(t)
            + row(3) * (loads.normal_deviation)(t)
    }

    fn record(&self, loads: &Loads<'_>, t: f64, (q, v): (&[f64], &[f64]), record: &mut Record) {
        let sum = |row: &[f64], x: &dyn Fn(usize) -> f64| -> f64 {
            row.iter().enumerate().map(|(n, r)| r * x(n)).sum()
        };
        let acceleration = |n: usize| {
            let w = self.frequency[n];
            self.modal_load(loads, t, n) - 2.0 * DAMPING * w * v[n] - w * w * q[n]
        };
        let accelerations: Vec<f64> = (0..q.len()).map(acceleration).collect();
        for (s, channel) in record.accelerations.iter_mut().enumerate() {
            channel.push(sum(&self.rows[s], &|n| accelerations[n]));
        }
        record.force.push((loads.exciter)(t));
        record.friction.push((loads.friction)(t));
        record.slip.push(sum(&self.rows[self.sensors + 1], &|n| q[n]));
        record.velocity.push(sum(&self.rows[self.sensors + 1], &|n| v[n]));
        let end = sum(&self.rows[self.sensors + 3], &|n| q[n]);
        record.normal.push(-self.stiffness * end + (loads.normal_deviation)(t));
    }
}

/// Exact step of `q̈ + 2ζω q̇ + ω² q = f` under a force that is linear in time.
fn advance((q, v): (f64, f64), (from, to): (f64, f64), w: f64, step: f64) -> (f64, f64) {
    let slope = (to - from) / step;
    // Particular solution (f + s t)/ω² − 2ζ s/ω³, then the free decay of the rest.
    let particular = |f: f64| (f / (w * w) - 2.0 * DAMPING * slope / w.powi(3), slope / (w * w));
    let (p0, dp0) = particular(from);
    let (p1, dp1) = particular(to);
    let (a, b) = (q - p0, v - dp0);
    let damped = w * (1.0 - DAMPING * DAMPING).sqrt();
    let decay = (-DAMPING * w * step).exp();
    let (sine, cosine) = (damped * step).sin_cos();
    let c = (b + DAMPING * w * a) / damped;
    let free = decay * (a * cosine + c * sine);
    let free_velocity = -DAMPING * w * free + decay * damped * (c * cosine - a * sine);
    (p1 + free, dp1 + free_velocity)
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
    20.0 * (2.5 * (TAU * frequency * t - 0.4).cos()).tanh() + 1.5 * (2.0 * TAU * frequency * t).sin()
}
