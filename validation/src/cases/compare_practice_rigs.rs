//! The rigs of the practice sets, marched and balanced: both against each other, and against what another code recorded.

use crate::case::{Case, Outcome, Row};
use crate::practice::{ABSENT, folder};
use anyhow::Context;
use frettrace_beam::{Boundary, Dof, ModalModel, ModalOptions, UniformBeam};
use frettrace_forward::hb::{
    Accuracy, AdaptiveSolver, Contact, Declared, Load, Network, Normal, Problem, Reading, Settings, Status,
};
use frettrace_forward::march::{
    Assembly, FrictionContact, March, Normal as MarchNormal, Port, SettleOptions, Settling, Structure, settle,
};
use frettrace_fourier::{Harmonics, Lines, Projector, refine};
use frettrace_friction::{FrictionModel, Law};
use frettrace_measurement::{Measurement, Run, SlipKind, read_measurement};
use num_complex::Complex64;
use std::f64::consts::{PI, TAU};
use std::path::Path;

/// The case.
pub const CASE: Case = Case { name: "compare_practice_rigs", run };

/// Sets whose law is the declared one but for a lag in the last.
const SETS: [&str; 4] = ["p01-clean-dahl", "p02-clean-hybrid", "p03-clean-transverse", "p12-lag"];
/// The one with the lag, which its truth does not state: its rig is compared with itself only.
const LAGS: &str = "p12-lag";
/// Modes summed, the residual flexibility beside them.
const MODES: usize = 30;
/// Steps of the march over a period.
const STEPS: usize = 8192;
/// Lines that are compared.
const LINES: usize = 15;

fn run() -> anyhow::Result<Outcome> {
    let Some(folder) = folder() else { return Ok(Outcome::Skipped(ABSENT.into())) };
    let mut rows = Vec::new();
    for name in SETS {
        let set = Set::read(&folder, name)?;
        let count = set.measurement.runs.len();
        let runs = [count / 2 - 1, count - 1].map(|run| set.compared(run));
        let [apart, off] = worst(runs.into_iter().collect::<anyhow::Result<Vec<_>>>()?);
        rows.push(Row {
            quantity: format!("{name}: march against balance, sensors' motion"),
            unit: "1",
            source: "two solutions of one set of equations",
            expected: Some(0.0),
            found: apart,
            tolerance: 1e-6,
            reason: "hold of the march in its steps, lines cut off",
        });
        if name != LAGS {
            rows.push(Row {
                quantity: format!("{name}: balance against the record, accelerations"),
                unit: "1",
                source: "a finite-element march of another laboratory, with noise",
                expected: Some(0.0),
                found: off,
                tolerance: 1e-2,
                reason: "0.6 % damping: a frequency that is 1e-5 off moves a slope of the resonance by 2e-3; noise",
            });
        }
    }
    Ok(Outcome::Ran(rows))
}

/// The larger ones; an undefined one is not lost.
fn worst(runs: Vec<[f64; 2]>) -> [f64; 2] {
    let largest =
        |k: usize| runs.iter().fold(0.0, |most: f64, run| if run[k] <= most { most } else { run[k] });
    [largest(0), largest(1)]
}

/// A set with what only its maker knows.
struct Set {
    measurement: Measurement,
    law: FrictionModel,
    natural_frequency: Vec<f64>,
    damping_ratio: Vec<f64>,
}

impl Set {
    fn read(folder: &Path, name: &str) -> anyhow::Result<Self> {
        let path = folder.join(format!("{name}.truth.json"));
        let text = std::fs::read_to_string(&path).with_context(|| path.display().to_string())?;
        let truth: serde_json::Value = serde_json::from_str(&text)?;
        let law = Law::from_name(truth["law"].as_str().context("law")?)?;
        let values: Option<Vec<f64>> = law
            .parameters()
            .iter()
            .map(|parameter| truth["friction"][key(parameter.name)].as_f64())
            .collect();
        let list =
            |name: &str| -> anyhow::Result<Vec<f64>> { Ok(serde_json::from_value(truth[name].clone())?) };
        Ok(Self {
            measurement: read_measurement(folder.join(format!("{name}.h5")))?,
            law: law.with_values(&values.context("parameters of the law")?)?,
            natural_frequency: list("modal_frequency_hz")?.into_iter().map(|f| TAU * f).collect(),
            damping_ratio: list("damping_ratio")?,
        })
    }
}

/// Lines of one run: its force, and its accelerations.
struct Recorded {
    omega: f64,
    force: Complex64,
    acceleration: Vec<Harmonics>,
}

fn recorded(run: &Run) -> anyhow::Result<Recorded> {
    let samples = run.force.len();
    let lines = Lines {
        base: TAU * run.excitation_frequency,
        order: 1,
        samples,
        sampling_rate: run.sampling_rate,
        drift: 0,
    };
    let omega = refine(lines, &[&run.force])?.base;
    let force = Projector::new(Lines { base: omega, ..lines })?.project(&run.force)?.harmonics;
    let projector = Projector::new(Lines { base: omega, order: LINES, ..lines })?;
    let acceleration = run.acceleration.iter().map(|channel| Ok(projector.project(channel)?.harmonics));
    Ok(Recorded {
        omega,
        force: force.coefficients[1],
        acceleration: acceleration.collect::<anyhow::Result<_>>()?,
    })
}

/// The rig as march and balance share it: ports of exciter, slip, end and sensors.
struct Shared {
    structure: Structure,
    spring: f64,
    preload: f64,
}

/// Where things are among the ports.
const EXCITER: usize = 0;
const SLIP: usize = 1;
const END: usize = 2;
const SENSORS: usize = 3;

impl Set {
    fn shared(&self, preload: f64) -> anyhow::Result<Shared> {
        let Measurement { beam, support, exciter, sensors, .. } = &self.measurement;
        let uniform = UniformBeam::rectangular(
            beam.length,
            [beam.width, beam.thickness],
            beam.youngs_modulus,
            beam.density,
        );
        let displacement = |x: f64| Port { dof: Dof::displacement(x), factor: 1.0 };
        let (slip, spring) = match support.slip {
            SlipKind::Rotation => {
                let turning = Port { dof: Dof::rotation(beam.length), factor: support.lever_arm };
                (turning, support.normal_stiffness)
            }
            SlipKind::Transverse => (displacement(beam.length), 0.0),
        };
        let boundary = if spring > 0.0 { Boundary::spring(spring) } else { Boundary::cantilever() };
        let options = ModalOptions {
            modes: MODES,
            natural_frequency: self.natural_frequency.clone(),
            damping_ratio: self.damping_ratio.clone(),
            ..ModalOptions::default()
        };
        let model = ModalModel::new(&uniform, &boundary, &options)?;
        let ports: Vec<Port> = [displacement(exciter.position), slip, displacement(beam.length)]
            .into_iter()
            .chain(sensors.position.iter().map(|&x| displacement(x)))
            .collect();
        Ok(Shared { structure: Structure::from_beam(&model, &ports)?, spring, preload })
    }

    /// How far march and balance are apart, relative to the motion of the sensors, and the balance from the record, relative to that.
    fn compared(&self, index: usize) -> anyhow::Result<[f64; 2]> {
        let run = &self.measurement.runs[index];
        let recorded = recorded(run)?;
        let shared = self.shared(run.preload)?;
        let sensors = self.measurement.sensors.position.len();
        let balanced = self.balanced(&shared, &recorded, sensors)?;
        let marched = self.marched(&shared, &recorded, sensors);
        let [mut apart, mut off] = [[0.0; 2]; 2];
        for (s, measured) in recorded.acceleration.iter().enumerate() {
            for h in 1..=LINES {
                let heard = measured.coefficients[h];
                let square = (h as f64 * recorded.omega).powi(2);
                let [found, other] = [balanced[s][h], marched[s][h]];
                apart = [apart[0] + (found - other).norm_sqr(), apart[1] + found.norm_sqr()];
                off = [off[0] + (heard + found * square).norm_sqr(), off[1] + heard.norm_sqr()];
            }
        }
        Ok([apart, off].map(|[difference, size]: [f64; 2]| (difference / size).sqrt()))
    }

    /// Lines of the sensors' displacements by converged balance; NaN where there is none.
    fn balanced(
        &self,
        shared: &Shared,
        recorded: &Recorded,
        sensors: usize,
    ) -> anyhow::Result<Vec<Vec<Complex64>>> {
        let pressed = Reading { port: END, scale: -shared.spring, offset: shared.preload };
        let seen = (SENSORS..SENSORS + sensors).map(Reading::motion);
        let channels = [Reading::motion(SLIP), pressed].into_iter().chain(seen).collect();
        let mut network = Network::new(shared.structure.clone(), channels, vec![SLIP]);
        network.loads.push(Load { port: EXCITER, harmonic: 1, amplitude: recorded.force });
        let element = Declared(self.law);
        let contact =
            Contact { slip: 0, normal: Normal::Channel(1), force: 0, normal_force: None, element: &element };
        let lines = network.lines(recorded.omega, 511, 1.0)?;
        let accuracy = Accuracy {
            truncation: 1e-8,
            sampling: 1e-7,
            orders: [31, 255],
            samples: 8192,
            ..Accuracy::default()
        };
        let settings = Settings { tolerance: 1e-10, ..Settings::default() };
        let problem = Problem { lines: &lines, contacts: &[contact] };
        let found = AdaptiveSolver::new(accuracy, settings).solve(&problem, None)?.solution;
        let converged = if found.status == Status::Converged { 1.0 } else { f64::NAN };
        let motion = |s: usize| lines.motion(2 + s, &found.forces).iter().map(|x| x * converged).collect();
        Ok((0..sensors).map(motion).collect())
    }

    /// The same lines over the settled period of the march; NaN where it does not settle.
    fn marched(&self, shared: &Shared, recorded: &Recorded, sensors: usize) -> Vec<Vec<Complex64>> {
        let Shared { structure, spring, preload } = shared;
        let normal = MarchNormal { port: Some(END), stiffness: *spring, ..MarchNormal::constant(*preload) };
        let friction = Some(FrictionContact { law: self.law, slip_port: SLIP, normal });
        let assembly =
            Assembly { structure: structure.clone(), inputs: vec![EXCITER], friction, loads: Vec::new() };
        let period = TAU / recorded.omega;
        let options =
            SettleOptions { steps_per_period: STEPS, tolerance: 1e-8, ..SettleOptions::new(period) };
        // A straight line between the steps loses (sin x/x)² of the excitation, x = ωΔt/2.
        let half = PI / STEPS as f64;
        let held = recorded.force * (half / half.sin()).powi(2);
        let known = |time: f64, out: &mut [f64]| out[0] = (held * Complex64::cis(recorded.omega * time)).re;
        let mut march = March::new(&assembly, period / STEPS as f64);
        let settled = settle(&mut march, &options, known);
        let periodic = matches!(settled, Settling::Periodic { multiple: 1, .. });
        let mut lines = vec![vec![Complex64::ZERO; LINES + 1]; sensors];
        let (start, mut values) = (march.time(), [0.0]);
        for k in 1..=STEPS {
            let angle = TAU * k as f64 / STEPS as f64;
            known(start + angle / recorded.omega, &mut values);
            march.step(&values);
            for (s, lines) in lines.iter_mut().enumerate() {
                let scale = if periodic { 2.0 / STEPS as f64 } else { f64::NAN };
                let sample = march.displacement(SENSORS + s) * scale;
                for (h, line) in lines.iter_mut().enumerate() {
                    *line += Complex64::cis(-angle * h as f64) * sample;
                }
            }
        }
        lines
    }
}

/// Name of a parameter in the sets' own files.
fn key(parameter: &str) -> &str {
    match parameter {
        "sigma0" => "sig0",
        "sigma1" => "sig1",
        "sigma2" => "sig2",
        "mu_s" => "mus",
        "mu_k" => "muk",
        "v_s" => "vs",
        "v_d" => "vd",
        "delta" => "dst",
        "exponent" => "iexp",
        "breakaway" => "zba",
        other => other,
    }
}
