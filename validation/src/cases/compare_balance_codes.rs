//! Four problems that other harmonic-balance codes have answered, at their order and sampling.

use crate::case::{Case, Outcome, Row};
use frettrace_forward::hb::{Problem, Settings, Solver, Status};
use num_complex::Complex64;
use problems::{Peer, rms, table};

#[path = "../../../crates/frettrace-forward/tests/peers/problems.rs"]
#[allow(
    dead_code,
    missing_docs,
    unreachable_pub,
    clippy::unwrap_used,
    reason = "shared with the tests of the crate"
)]
mod problems;

/// The case.
pub const CASE: Case = Case { name: "compare_balance_codes", run };

const P1: &str = include_str!("../../../crates/frettrace-forward/tests/peers/p1.csv");
const P2: &str = include_str!("../../../crates/frettrace-forward/tests/peers/p2_trace.csv");
const P3: &str = include_str!("../../../crates/frettrace-forward/tests/peers/p3_trace.csv");
const P4: &str = include_str!("../../../crates/frettrace-forward/tests/peers/p4.csv");

fn run() -> anyhow::Result<Outcome> {
    // Column of the peer's root mean square, channel, and whether the mean counts.
    let rows = [
        ("P1, tanh friction, tip", problems::p1(), P1, (1, 1, true)),
        ("P2, Jenkins element, tip", problems::p2(), P2, (1, 1, true)),
        ("P3, stiff Jenkins element, tip", problems::p3(), P3, (2, 1, true)),
        ("P4, lift-off and friction, tangential", problems::p4(), P4, (1, 0, false)),
        ("P4, lift-off and friction, normal", problems::p4(), P4, (2, 1, false)),
    ];
    let rows = rows.into_iter().map(|(name, peer, csv, at)| row(name, &peer, (csv, at)));
    Ok(Outcome::Ran(rows.collect::<anyhow::Result<_>>()?))
}

fn row(
    name: &str,
    peer: &Peer,
    (csv, (column, channel, mean)): (&str, (usize, usize, bool)),
) -> anyhow::Result<Row> {
    let points = table(csv);
    let omegas = points.iter().map(|point| point[0]);
    let found = answers(peer, channel, omegas)?;
    let differences =
        points.iter().zip(&found).map(|(point, lines)| (rms(lines, mean) / point[column] - 1.0).abs());
    Ok(Row {
        quantity: format!("{name}: largest difference over {} frequencies", points.len()),
        unit: "1",
        source: "tmdsimpy 17d5fc3; NLvib and pyHarm agree with it",
        expected: Some(0.0),
        // NaN must not be lost in a maximum.
        found: differences.fold(0.0, |most: f64, d| if d <= most { most } else { d }),
        tolerance: 1e-8,
        reason: "the same equations: what is left are the peer's own Newton steps",
    })
}

/// Lines of a channel at each frequency, every answer started from the one before; NaN where there is none.
fn answers(
    peer: &Peer,
    channel: usize,
    omegas: impl Iterator<Item = f64>,
) -> anyhow::Result<Vec<Vec<Complex64>>> {
    let settings = Settings { order: peer.order, samples: peer.samples, tolerance: 1e-11, iterations: 40 };
    let mut solver = Solver::new(settings)?;
    let contacts = [peer.contact()];
    let mut start: Option<Vec<Complex64>> = None;
    omegas
        .map(|omega| {
            let lines = peer.network.lines(omega, peer.order, 1.0)?;
            let solution = solver.solve(&Problem { lines: &lines, contacts: &contacts }, start.as_deref())?;
            let mut motion = vec![Complex64::ZERO; peer.order + 1];
            lines.respond(channel, &solution.forces, &mut motion);
            if solution.status != Status::Converged {
                motion.fill(f64::NAN.into());
            }
            start = Some(solution.forces);
            Ok(motion)
        })
        .collect()
}
