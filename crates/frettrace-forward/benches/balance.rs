//! What do a balanced run, its tangents and a whole response curve cost? See README.md beside this file.

#![allow(clippy::print_stdout, reason = "the counts of a sweep belong to its time")]

#[path = "../tests/peers/problems.rs"]
#[allow(dead_code, missing_docs, clippy::unwrap_used, reason = "shared with the tests")]
mod problems;

use frettrace_forward::hb::{
    Contact, Family, Friction, Lines, Load, Network, Normal, Problem, Reading, Settings, Solver, Sweep,
};
use frettrace_forward::march::Structure;
use frettrace_friction::{Bristle, Scalar, laws::Dahl};
use num_complex::Complex64;
use problems::Peer;

fn main() {
    for (name, peer, range) in [("P2", problems::p2(), RANGES[0]), ("P3", problems::p3(), RANGES[1])] {
        if let Some((points, evaluations, linearisations)) = follow(&peer, range) {
            println!("{name}: {points} points, {evaluations} evaluations, {linearisations} Jacobians");
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
