//! What do a balanced run, its tangents and a whole response curve cost? See README.md beside this file.

#![allow(clippy::print_stdout, reason = "the counts of a sweep belong to its time")]

#[path = "../tests/peers/problems.rs"]
#[allow(dead_code, missing_docs, clippy::unwrap_used, reason = "shared with the tests")]
mod problems;

use frettrace_beam::{Boundary, Dof, ModalModel, ModalOptions, UniformBeam};
use frettrace_forward::accelerations::{AccelerationModel, Rig, RunLines, Setting};
use frettrace_forward::hb::{
    Accuracy, Contact, Family, Friction, FrictionBeam, Lines, Load, Network, Normal, Problem, Reading,
    Response, ResponseOptions, Settings, Solver, Sweep, SweepStatus, response,
};
use frettrace_forward::march::{Port, Structure};
use frettrace_friction::effects::ModifiedLaw;
use frettrace_friction::{Bristle, Scalar, laws::Dahl};
use num_complex::Complex64;
use problems::Peer;
use std::f64::consts::TAU;

fn main() {
    for (name, peer, range) in [("P2", problems::p2(), RANGES[0]), ("P3", problems::p3(), RANGES[1])] {
        if let Some((points, evaluations, linearisations)) = follow(&peer, range) {
            println!("{name}: {points} points, {evaluations} evaluations, {linearisations} Jacobians");
        }
    }
    for range in [WHOLE, HUNDRED] {
        if let Some(found) = response_of_levels(range) {
            let points: Vec<usize> = found.levels.iter().map(|level| level.points.len()).collect();
            let finished = found.levels.iter().all(|level| level.status == SweepStatus::Finished);
            println!("response over {range:?} Hz: points {points:?}, all finished: {finished}");
        }
    }
    divan::main();
}

/// Sweeps of the peers (rad/s).
const RANGES: [[f64; 2]; 2] = [[420.0, 260.0], [760.0, 380.0]];

fn follow(peer: &Peer, range: [f64; 2]) -> Option<(usize, usize, usize)> {
    let settings = Settings { order: peer.order, samples: peer.samples, tolerance: 1e-9, iterations: 40 };
    let sweep = Sweep { range, ..Sweep::default() };
    let curve = Solver::new(settings).ok()?.follow(&peer.network, &[peer.contact()], &sweep).ok()?;
    Some((curve.points.len(), curve.evaluations, curve.linearisations))
}

#[divan::bench]
fn p2_sweep(bencher: divan::Bencher) {
    let peer = problems::p2();
    bencher.bench_local(|| follow(&peer, RANGES[0]));
}

#[divan::bench]
fn p3_sweep(bencher: divan::Bencher) {
    let peer = problems::p3();
    bencher.bench_local(|| follow(&peer, RANGES[1]));
}

struct Bristles([f64; 2]);

impl Family for Bristles {
    type Law<T: Scalar> = Friction<Bristle<T>>;

    fn parameters(&self) -> &[f64] {
        &self.0
    }

    fn law<T: Scalar>(&self, parameters: &[T]) -> Self::Law<T> {
        let law = Dahl { sigma0: parameters[0], mu_k: parameters[1], exponent: T::one() };
        Friction(law.bristle())
    }
}

const LAW: Bristles = Bristles([2.0, 0.5]);

fn run(order: usize) -> Option<(Lines, Settings)> {
    let structure = Structure::new(vec![1.0, 6.0, 15.0], vec![0.02; 3], vec![vec![1.0; 3]]).ok()?;
    let mut network = Network::new(structure, vec![Reading::motion(0)], vec![0]);
    network.loads.push(Load { port: 0, harmonic: 1, amplitude: Complex64::ONE });
    let samples = (8 * order).next_power_of_two();
    Some((network.lines(0.7, order, 1.0).ok()?, Settings { order, samples, ..Settings::default() }))
}

/// Ranges of the excitation (Hz): the whole resonance, and one that takes about a hundred points a level.
const WHOLE: [f64; 2] = [76.0, 114.0];
const HUNDRED: [f64; 2] = [94.0, 112.0];

/// Eight levels over a resonance of a beam on its friction support, as the program's `response` asks for them: 40 modes,
/// a truncation of 1e-3, stability of every point, backbone; all cores.
fn response_of_levels(range: [f64; 2]) -> Option<Response> {
    let (length, spring) = (0.52, 4e6);
    let beam = UniformBeam::rectangular(length, [0.03, 0.007], 2.05e11, 7840.0);
    let model = |modes: usize| {
        let options = ModalOptions { modes, damping_ratio: vec![0.005], ..ModalOptions::default() };
        ModalModel::new(&beam, &Boundary::spring(spring), &options).ok()
    };
    let displacement = |x| Port { dof: Dof::displacement(x), factor: 1.0 };
    let rig = FrictionBeam {
        model: model(40)?,
        coarse: model(6)?,
        exciter: displacement(0.212),
        slip: Port { dof: Dof::rotation(length), factor: 0.0035 },
        normal: Some((displacement(length), spring)),
        preload: 65.0,
        friction: &SUPPORT,
        masses: Vec::new(),
        attached: Vec::new(),
        sensors: [0.1, 0.2, 0.3, 0.4, 0.5].map(displacement).to_vec(),
    };
    let options = ResponseOptions {
        levels: (0..8).map(|level| 0.2 * 1.7_f64.powi(level)).collect(),
        range: range.map(|frequency| TAU * frequency),
        accuracy: Accuracy { truncation: 1e-3, orders: [7, 63], samples_a_line: 16, ..Accuracy::default() },
        settings: Settings { tolerance: 1e-7, ..Settings::default() },
        resolution: [1e-2, 0.03],
        stability: true,
        backbone: 25,
    };
    response(&rig, &options).ok()
}

const SUPPORT: Bristles = Bristles([4.2e5, 0.24]);

#[divan::bench(sample_count = 10)]
fn whole_response_over_eight_levels(bencher: divan::Bencher) {
    bencher.bench_local(|| response_of_levels(WHOLE));
}

#[divan::bench(sample_count = 10)]
fn hundred_points_over_eight_levels(bencher: divan::Bencher) {
    bencher.bench_local(|| response_of_levels(HUNDRED));
}

fn contact() -> Contact<'static> {
    Contact { slip: 0, normal: Normal::Constant(1.0), force: 0, normal_force: None, element: &LAW }
}

/// One run with Dahl friction from nothing; samples are eight a line.
#[divan::bench(args = [15, 31, 60])]
fn cold_run(bencher: divan::Bencher, order: usize) {
    let Some((lines, settings)) = run(order) else { return };
    let Ok(mut solver) = Solver::new(settings) else { return };
    let contacts = [contact()];
    let problem = Problem { lines: &lines, contacts: &contacts };
    bencher.bench_local(|| solver.solve(&problem, None));
}

/// Tangents by the two parameters of the law and ten of the structure.
#[divan::bench(args = [15, 31, 60])]
fn twelve_tangents(bencher: divan::Bencher, order: usize) {
    let Some((lines, settings)) = run(order) else { return };
    let Ok(mut solver) = Solver::new(settings) else { return };
    let contacts = [contact()];
    let problem = Problem { lines: &lines, contacts: &contacts };
    let Ok(solution) = solver.solve(&problem, None) else { return };
    let changes = vec![lines.clone(); 10];
    bencher.bench_local(|| solver.tangents(&problem, &solution, &changes));
}

/// The beam of `tests/rigid_friction` at its force of 6 N: friction that is set-valued at rest, a run of stick and slip.
fn rigid(order: usize) -> Option<(AccelerationModel, Setting)> {
    let (beam, boundary) =
        (UniformBeam::rectangular(0.5, [0.03, 0.007], 2.0e11, 7850.0), Boundary::spring(5e6));
    let options = ModalOptions { modes: 40, ..ModalOptions::default() };
    let frequency = ModalModel::new(&beam, &boundary, &options).ok()?.natural_frequency().to_vec();
    let (sensors, lever) = (vec![0.33], Some(0.0035));
    let rig = Rig { beam, boundary, exciter: 0.2, sensors, lever, known_support: None, modes: 40 };
    let mut force = vec![Complex64::ZERO; 41];
    force[1] = 6.0.into();
    let run = RunLines {
        omega: TAU * 105.0,
        preload: 60.0,
        progress: 0.0,
        worked: [0.0; 2],
        acceleration: vec![vec![Complex64::ZERO; force.len()]],
        deviation: vec![vec![6e-6; force.len()]],
        force,
        base_phase: 0.0,
        known_force: Vec::new(),
        contact_order: order,
        samples: 16 * (order + 1),
    };
    let law = ModifiedLaw::dahl(1e6, 0.25);
    let damping = vec![0.01; frequency.len()];
    let setting = Setting { rigid: true, ..Setting::new(frequency, damping, law, 1) };
    Some((AccelerationModel::new(rig, vec![run]).ok()?, setting))
}

/// One run of a rigid contact from nothing; from 600 unknowns (order 300) on by products.
#[divan::bench(args = [200, 400, 800], sample_count = 10)]
fn rigid_run(bencher: divan::Bencher, order: usize) {
    let Some((model, setting)) = rigid(order) else { return };
    bencher.bench_local(|| model.predict(&setting, &[0], &mut model.memory()));
}
