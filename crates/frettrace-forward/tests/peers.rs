//! The answers of other harmonic-balance codes, at equal order and sampling.

#![allow(clippy::unwrap_used, reason = "a helper of tests that fails is a test that fails")]

#[path = "peers/problems.rs"]
mod problems;

use frettrace_forward::hb::{Problem, Settings, Solver, Status, Sweep, SweepStatus};
use num_complex::Complex64;
use problems::{Peer, rms, table};

/// Lines of a channel at each frequency, every answer started from the one before.
fn answers(peer: &Peer, channels: [usize; 2], omegas: impl Iterator<Item = f64>) -> Vec<[Vec<Complex64>; 2]> {
    let settings = Settings { order: peer.order, samples: peer.samples, tolerance: 1e-11, iterations: 40 };
    let mut solver = Solver::new(settings).unwrap();
    let contacts = [peer.contact()];
    let mut start = None;
    let solve = |omega| {
        let lines = peer.network.lines(omega, peer.order, 1.0).unwrap();
        let solution =
            solver.solve(&Problem { lines: &lines, contacts: &contacts }, start.as_deref()).unwrap();
        assert_eq!(solution.status, Status::Converged, "at {omega} rad/s: {}", solution.correction);
        let motion = channels.map(|channel| {
            let mut motion = vec![Complex64::ZERO; peer.order + 1];
            lines.respond(channel, &solution.forces, &mut motion);
            motion
        });
        start = Some(solution.forces);
        motion
    };
    omegas.map(solve).collect()
}

/// Relative differences of the tip's root mean square from a table.
fn compare(peer: &Peer, csv: &str, tolerance: f64) {
    let rows = table(csv);
    let found = answers(peer, [1, 1], rows.iter().map(|row| row[0]));
    for (row, [tip, _]) in rows.iter().zip(&found) {
        let error = rms(tip, true) / row[1] - 1.0;
        assert!(error.abs() < tolerance, "at {} rad/s: {error:e}", row[0]);
    }
}

#[test]
fn p1_agrees() {
    compare(&problems::p1(), include_str!("peers/p1.csv"), 1e-8);
}

#[test]
fn p2_agrees() {
    compare(&problems::p2(), include_str!("peers/p2.csv"), 1e-8);
}

#[test]
fn p3_agrees() {
    compare(&problems::p3(), include_str!("peers/p3.csv"), 1e-8);
}

#[test]
fn p2_agrees_along_the_curve() {
    compare(&problems::p2(), include_str!("peers/p2_trace.csv"), 1e-8);
}

/// The peer's continuation accepts a point when MINPACK's hybrid step is below 1e-6·(number of unknowns), relative, and
/// its trace is as far from its own solution: a dozen points by more than 1e-8, the worst, beside the turning point near 459 rad/s,
/// by 1.4e-7. The last column is the peer's own balance, at the same frequencies, put through its own Newton steps until
/// they fall below 2e-9 of the motion; steep stretches stand at 1e-10 there. The trace itself is held to the peer's step.
#[test]
fn p3_agrees_along_the_curve() {
    let peer = problems::p3();
    let rows = table(include_str!("peers/p3_trace.csv"));
    let found = answers(&peer, [1, 1], rows.iter().map(|row| row[0]));
    for (row, [tip, _]) in rows.iter().zip(&found) {
        let [trace, converged] = [row[1], row[2]].map(|expected| rms(tip, true) / expected - 1.0);
        assert!(
            converged.abs() < 1e-8 && trace.abs() < 2e-7,
            "at {} rad/s: {converged:e}, {trace:e}",
            row[0]
        );
    }
}

#[test]
fn p4_agrees() {
    let rows = table(include_str!("peers/p4.csv"));
    let found = answers(&problems::p4(), [0, 1], rows.iter().map(|row| row[0]));
    for (row, [x, n]) in rows.iter().zip(&found) {
        for (value, expected) in [(rms(x, false), row[1]), (rms(n, false), row[2])] {
            assert!((value / expected - 1.0).abs() < 1e-8, "at {} rad/s: {value} {expected}", row[0]);
        }
        // The mean of x is that of a slider started at 0.
        assert!((x[0].re - row[3]).abs() < 1e-7 * row[1] && (n[0].re - row[4]).abs() < 1e-9);
    }
}

/// The followed curve goes through the peers' points: the largest response along it is theirs.
#[test]
fn curves_have_the_peers_peaks() {
    // Peaks of the order-7 curves on a grid of 0.005 rad/s, from a third code (comparison of NLvib, tmdsimpy and pyHarm).
    for (peer, range, peak) in
        [(problems::p2(), [420.0, 260.0], 5.472_718_60e-6), (problems::p3(), [760.0, 380.0], 4.186_627_20e-5)]
    {
        let settings = Settings { order: peer.order, samples: peer.samples, tolerance: 1e-9, iterations: 40 };
        let mut solver = Solver::new(settings).unwrap();
        let sweep = Sweep { range, ..Sweep::default() };
        let curve = solver.follow(&peer.network, &[peer.contact()], &sweep).unwrap();
        assert_eq!(curve.status, SweepStatus::Finished);
        let tip = |point: &frettrace_forward::hb::Point| {
            let lines = peer.network.lines(point.omega, peer.order, 1.0).unwrap();
            let mut motion = vec![Complex64::ZERO; peer.order + 1];
            lines.respond(1, &point.forces, &mut motion);
            rms(&motion, true)
        };
        let largest = curve.points.iter().map(tip).fold(0.0, f64::max);
        // Points nearest the peak lie a little beside it.
        assert!(largest <= peak * (1.0 + 1e-6) && largest > 0.99 * peak, "{largest} {peak}");
    }
}
