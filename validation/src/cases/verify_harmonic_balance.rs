//! Harmonic balance against the time march and closed forms: a stop, two periods, a friction support, Den Hartog, modes.

use crate::case::{Case, Outcome, Row};
use frettrace_beam::{Boundary, Dof, ModalModel, ModalOptions, UniformBeam};
use frettrace_forward::hb::{
    Contact, ElasticContact, Element, Family, Friction, Load, Modes, Network, Normal, Problem, Reading,
    Settings, Solver, Status, Stop,
};
use frettrace_forward::march::{
    Assembly, Characteristic, FrictionContact, LocalLoad, March, Normal as MarchNormal, Port, SettleOptions,
    Settling, Structure, settle,
};
use frettrace_friction::{Bristle, FrictionLaw, Scalar, laws::Dahl};
use num_complex::Complex64;
use std::f64::consts::{PI, TAU};

/// The case.
pub const CASE: Case = Case { name: "verify_harmonic_balance", run };

const STEPS: usize = 1024;
/// Error of a load's impulse in a step that makes it be halved.
const SHARE: f64 = 1e-7;
const MARCH: &str = "time march of the same structure";

fn run() -> anyhow::Result<Outcome> {
    let mut rows = vec![stop(4e-7)?, stop(0.0)?, two_periods()?];
    rows.extend([friction_support(0.6)?, friction_support(6.0)?]);
    for (ratio, share, amplitude) in DEN_HARTOG {
        rows.push(den_hartog(ratio, share, amplitude)?);
    }
    rows.extend(dry_mode()?);
    rows.extend(jenkins_mode()?);
    Ok(Outcome::Ran(rows))
}

fn on(element: &dyn Element) -> Contact<'_> {
    Contact { slip: 0, normal: Normal::Constant(0.0), force: 0, normal_force: None, element }
}

/// One mass, `m = k = 1`, with the damping ratio.
fn oscillator(ratio: f64) -> anyhow::Result<Structure> {
    Ok(Structure::new(vec![1.0], vec![ratio], vec![vec![1.0]])?)
}

/// Root mean square of lines, mean left out.
fn rms(lines: &[Complex64]) -> f64 {
    (lines[1..].iter().map(|x| x.norm_sqr() / 2.0).sum::<f64>()).sqrt()
}

/// Root mean square of a port over the settled motion under `force · cos ωt`, mean left out; NaN where it does not settle.
fn marched<L: FrictionLaw<f64>>(assembly: &Assembly<L>, [force, omega]: [f64; 2], port: usize) -> f64 {
    let options =
        SettleOptions { steps_per_period: STEPS, tolerance: 1e-8, ..SettleOptions::new(TAU / omega) };
    let dt = options.period / STEPS as f64;
    // A straight line between the steps loses (sin x/x)² of the excitation, x = ωΔt/2.
    let half = PI / STEPS as f64;
    let held = force * (half / half.sin()).powi(2);
    let known = |time: f64, out: &mut [f64]| out[0] = held * (omega * time).cos();
    let mut march = March::new(assembly, dt);
    march.set_refinement(SHARE);
    let Settling::Periodic { multiple, .. } = settle(&mut march, &options, known) else { return f64::NAN };
    let (start, mut values) = (march.time(), [0.0]);
    let samples: Vec<f64> = (1..=multiple * STEPS)
        .map(|k| {
            known(start + k as f64 * dt, &mut values);
            march.step(&values);
            march.displacement(port)
        })
        .collect();
    let mean = samples.iter().sum::<f64>() / samples.len() as f64;
    (samples.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / samples.len() as f64).sqrt()
}

fn against_march(quantity: String, found: f64, expected: f64) -> Row {
    let (source, reason) = (MARCH, "hold of the march in its steps, lines cut off, kinks between samples");
    Row { quantity, unit: "m", source, expected: Some(expected), found, tolerance: 3e-6 * expected, reason }
}

/// The march of a structure with a stop at port 0.
fn stopped(structure: &Structure, stop: Stop, load: [f64; 2], [input, port]: [usize; 2]) -> f64 {
    let characteristic = Characteristic::Stop { stiffness: stop.stiffness, gap: stop.clearance };
    let assembly: Assembly<Dahl<f64>> = Assembly {
        structure: structure.clone(),
        inputs: vec![input],
        friction: None,
        loads: vec![LocalLoad { port: 0, characteristic }],
    };
    marched(&assembly, load, port)
}

/// A cantilever that hits a stop near its middle.
fn stop(clearance: f64) -> anyhow::Result<Row> {
    let beam = UniformBeam::rectangular(0.7, [0.03, 0.03], 185e9, 7830.0);
    let options = ModalOptions { modes: 8, damping_ratio: vec![0.01], ..ModalOptions::default() };
    let model = ModalModel::new(&beam, &Boundary::cantilever(), &options)?;
    let displacement = |x| Port { dof: Dof::displacement(x), factor: 1.0 };
    let structure = Structure::from_beam(&model, &[displacement(0.3), displacement(0.7)])?;
    let mut network = Network::new(structure.clone(), vec![Reading::motion(0), Reading::motion(1)], vec![0]);
    network.loads.push(Load { port: 1, harmonic: 1, amplitude: Complex64::new(0.2, 0.0) });
    let stop = Stop { stiffness: 1e6, damping: 0.0, clearance, two_sided: false };
    let (omega, order) = (270.0, 95);
    let lines = network.lines(omega, order, 1.0)?;
    let mut solver = Solver::new(Settings { order, samples: 8192, tolerance: 1e-10, iterations: 60 })?;
    let found = solver.solve(&Problem { lines: &lines, contacts: &[on(&stop)] }, None)?;
    let converged = if found.status == Status::Converged { 1.0 } else { f64::NAN };
    let tip = converged * rms(&lines.motion(1, &found.forces));
    let expected = stopped(&structure, stop, [0.2, omega], [1, 1]);
    Ok(against_march(format!("tip of a beam with a stop {clearance:e} m away"), tip, expected))
}

/// A mass that rests on a stop, driven near twice its frequency: the motion repeats with every second period of the load.
fn two_periods() -> anyhow::Result<Row> {
    let (omega, structure) = (3.0, oscillator(0.03)?);
    let stop = Stop { stiffness: 9.0, damping: 0.0, clearance: 0.0, two_sided: false };
    let mut network = Network::new(structure.clone(), vec![Reading::motion(0)], vec![0]);
    network.loads.push(Load { port: 0, harmonic: 2, amplitude: Complex64::ONE });
    let lines = network.lines(omega / 2.0, 127, 1.0)?;
    let mut solver = Solver::new(Settings { order: 127, samples: 16384, tolerance: 1e-11, iterations: 60 })?;
    let mut found = f64::NAN;
    // Half-waves of an amplitude of 2, at any phase until one leads to a motion with its line 1.
    for turn in 0..12 {
        let start = [(18.0 / PI).into(), Complex64::from_polar(9.0, TAU * f64::from(turn) / 12.0)];
        let solution = solver.solve(&Problem { lines: &lines, contacts: &[on(&stop)] }, Some(&start))?;
        if solution.status == Status::Converged && solution.forces[1].norm() > 0.1 {
            found = rms(&lines.motion(0, &solution.forces));
            break;
        }
    }
    let expected = stopped(&structure, stop, [1.0, omega], [0, 0]);
    Ok(against_march("mass on a stop, motion of two periods".to_owned(), found, expected))
}

struct Bristles(Dahl<f64>);

impl Family for Bristles {
    type Law<T: Scalar> = Friction<Bristle<T>>;

    fn parameters(&self) -> &[f64] {
        &[]
    }

    fn law<T: Scalar>(&self, _: &[T]) -> Self::Law<T> {
        Friction(self.0.bristle().lift())
    }
}

/// A beam on its friction support: slip by rotation, a normal force that follows the motion, Dahl's law.
fn friction_support(force: f64) -> anyhow::Result<Row> {
    let (length, spring, preload, omega) = (0.52, 4e6, 65.0, TAU * 93.7);
    let beam = UniformBeam::rectangular(length, [0.03, 0.007], 2.05e11, 7840.0);
    let options = ModalOptions { modes: 30, damping_ratio: vec![0.005], ..ModalOptions::default() };
    let model = ModalModel::new(&beam, &Boundary::spring(spring), &options)?;
    let displacement = |x| Port { dof: Dof::displacement(x), factor: 1.0 };
    let slip = Port { dof: Dof::rotation(length), factor: 0.0035 };
    let ports = [displacement(0.212), slip, displacement(length), displacement(0.337)];
    let structure = Structure::from_beam(&model, &ports)?;
    let law = Dahl { sigma0: 4.2e5, mu_k: 0.24, exponent: 1.0 };
    let normal = Reading { port: 2, scale: -spring, offset: preload };
    let mut network =
        Network::new(structure.clone(), vec![Reading::motion(1), normal, Reading::motion(3)], vec![1]);
    network.loads.push(Load { port: 0, harmonic: 1, amplitude: force.into() });
    let lines = network.lines(omega, 127, 1.0)?;
    let element = Bristles(law);
    let contact = Contact { normal: Normal::Channel(1), ..on(&element) };
    let mut solver = Solver::new(Settings { order: 127, samples: 4096, tolerance: 1e-10, iterations: 40 })?;
    let found = solver.solve(&Problem { lines: &lines, contacts: &[contact] }, None)?;
    let normal = MarchNormal { port: Some(2), stiffness: spring, ..MarchNormal::constant(preload) };
    let assembly = Assembly {
        structure,
        inputs: vec![0],
        friction: Some(FrictionContact { law, slip_port: 1, normal }),
        loads: Vec::new(),
    };
    let expected = marched(&assembly, [force, omega], 3);
    let found = rms(&lines.motion(2, &found.forces));
    Ok(against_march(format!("beam on its friction support at {force} N"), found, expected))
}

/// Frequency ratio, friction over load, amplitude over P/k at a damping ratio of 0.1: Den Hartog's solution.
const DEN_HARTOG: [(f64, f64, f64); 4] =
    [(0.6, 0.3, 1.393_261_34), (0.9, 0.5, 1.808_622_93), (1.0, 0.3, 3.087_857_48), (2.0, 0.3, 0.278_701_17)];

/// Friction that is dry but for a spring `stiffness` times the oscillator's.
fn dry(limit: f64, stiffness: f64) -> ElasticContact {
    ElasticContact {
        normal_stiffness: 0.0,
        preload: limit,
        tangential_stiffness: stiffness,
        friction_coefficient: 1.0,
    }
}

fn den_hartog(ratio: f64, share: f64, amplitude: f64) -> anyhow::Result<Row> {
    let mut network = Network::new(oscillator(0.1)?, vec![Reading::motion(0)], vec![0]);
    network.loads.push(Load { port: 0, harmonic: 1, amplitude: Complex64::ONE });
    let (order, samples) = (127, 16384);
    let lines = network.lines(ratio, order, 1.0)?;
    let element = dry(share, 1e6);
    let mut solver = Solver::new(Settings { order, samples, tolerance: 1e-9, iterations: 60 })?;
    let solution = solver.solve(&Problem { lines: &lines, contacts: &[on(&element)] }, None)?;
    let motion = lines.motion(0, &solution.forces);
    let at = |k: usize| -> f64 {
        let turn = |h: usize| Complex64::from_polar(1.0, TAU * (h * k) as f64 / samples as f64);
        motion.iter().enumerate().map(|(h, x)| (x * turn(h)).re).sum()
    };
    let converged = solution.status == Status::Converged;
    let found = if converged { (0..samples).map(at).fold(0.0, f64::max) } else { f64::NAN };
    Ok(Row {
        quantity: format!("dry friction {share} P at frequency ratio {ratio}: amplitude over P/k"),
        unit: "1",
        source: "Den Hartog 1931, damped, 8 digits by an event-driven march",
        expected: Some(amplitude),
        found,
        tolerance: 2e-3 * amplitude,
        reason: "friction turns a sample of 16384 late and within its spring's bend, 2e-3 of the phase",
    })
}

/// The mode of a mass with dry friction: the exact motion between two reversals.
fn dry_mode() -> anyhow::Result<[Row; 2]> {
    let (limit, ratio) = (0.25, 0.01);
    let network = Network::new(oscillator(ratio)?, vec![Reading::motion(0)], vec![0]);
    let element = dry(limit, 1e7);
    let settings = Settings { order: 63, samples: 16384, tolerance: 1e-9, iterations: 40 };
    let modes = Modes { mode: 0, channel: 0, amplitudes: [20.0, 2.0], points: 8 };
    let points = Solver::new(settings)?.follow_mode(&network, &[on(&element)], &modes)?;
    let last = points.last().map_or([f64::NAN; 3], |p| [p.amplitude, p.omega, p.damping_ratio]);
    let damper = damper_of_line_one(last[0], limit);
    let omega = (1.0 - damper * damper / 4.0).sqrt();
    let damping = (2.0 * ratio - damper) / (2.0 * omega);
    let row = |name: &str, unit, expected: f64, found, tolerance: f64| Row {
        quantity: format!("mode with dry friction 0.25 at amplitude 2: {name}"),
        unit,
        source: "exact motion between two reversals (Den Hartog 1931)",
        expected: Some(expected),
        found,
        tolerance: tolerance * expected,
        reason: "friction turns a sample of 16384 late: 6e-4 of the phase, times its share of the force",
    };
    Ok([row("frequency", "rad/s", omega, last[1], 2e-4), row("damping ratio", "1", damping, last[2], 1e-3)])
}

/// `c = 2ζω − ε` with `e^{−cπ/2ω} = (A + F)/(A − F)`, `ω² = 1 − c²/4`, at the `A` whose motion has a line 1 of this size.
fn damper_of_line_one(first: f64, limit: f64) -> f64 {
    let damper = |amplitude: f64| {
        let slope = ((amplitude + limit) / (amplitude - limit)).ln() / PI;
        -2.0 * slope / (1.0 + slope * slope).sqrt()
    };
    let line_one = |amplitude: f64| {
        let c = damper(amplitude);
        let omega = (1.0 - c * c / 4.0).sqrt();
        let count = 2000;
        let sum: Complex64 = (0..count)
            .map(|k| {
                let phase = PI * (f64::from(k) + 0.5) / f64::from(count);
                let free =
                    (-c * phase / (2.0 * omega)).exp() * (phase.cos() + c / (2.0 * omega) * phase.sin());
                Complex64::from_polar(limit + (amplitude - limit) * free, -phase)
            })
            .sum();
        (sum * 2.0 / f64::from(count)).norm()
    };
    let (mut low, mut high) = (0.9 * first, 1.5 * first);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if line_one(middle) < first { low = middle } else { high = middle }
    }
    damper(low)
}

/// The mode of a mass with a Jenkins element, one line: its describing function (Caughey 1960), at thrice the amplitude of slip.
fn jenkins_mode() -> anyhow::Result<[Row; 2]> {
    let (stiffness, limit, ratio, amplitude): (f64, f64, f64, f64) = (0.5, 0.5, 0.01, 3.0);
    let network = Network::new(oscillator(ratio)?, vec![Reading::motion(0)], vec![0]);
    let element = dry(limit, stiffness);
    let settings = Settings { order: 1, samples: 4096, tolerance: 1e-10, iterations: 30 };
    let modes = Modes { mode: 0, channel: 0, amplitudes: [0.5, amplitude], points: 8 };
    let points = Solver::new(settings)?.follow_mode(&network, &[on(&element)], &modes)?;
    let last = points.last().map_or([f64::NAN; 2], |p| [p.omega, p.damping_ratio]);
    let angle = (1.0 - 2.0 * limit / (stiffness * amplitude)).acos();
    let unit = stiffness * amplitude / PI;
    let [real, imaginary] = [unit * (angle - (2.0 * angle).sin() / 2.0), unit * angle.sin().powi(2)];
    let omega = (1.0 + real / amplitude).sqrt();
    let damping = (2.0 * ratio + imaginary / (amplitude * omega)) / (2.0 * omega);
    let row = |name: &str, unit, expected: f64, found, tolerance: f64| Row {
        quantity: format!("mode with a Jenkins element at amplitude 3: {name}"),
        unit,
        source: "describing function of the bilinear loop (Caughey 1960)",
        expected: Some(expected),
        found,
        tolerance: tolerance * expected,
        reason: "kinks between 4096 samples",
    };
    Ok([row("frequency", "rad/s", omega, last[0], 1e-5), row("damping ratio", "1", damping, last[1], 1e-4)])
}
