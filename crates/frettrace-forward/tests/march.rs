//! The time march on the problems that harmonic-balance codes have answered.
//!
//! Expected values are another laboratory's time march and converged harmonic balance (order 99) of the same problems: the
//! root mean square of the tip's displacement (m). They differ between themselves by up to 3e-6.

#![allow(clippy::unwrap_used, reason = "a test")]

#[path = "peers/problems.rs"]
#[expect(dead_code, reason = "the peers' test uses the rest")]
mod problems;

use std::f64::consts::TAU;

use frettrace_forward::march::{
    Assembly, Characteristic, FrictionContact, LocalLoad, March, Normal, SettleOptions, Settling, settle,
};
use frettrace_friction::FrictionLaw;
use frettrace_friction::laws::Jenkins;
use problems::{Peer, table};

const STEPS: usize = 4096;

/// Root mean squares without the mean of the ports' displacements over the settled period.
fn tips<L: FrictionLaw<f64>>(
    assembly: &Assembly<L>,
    omega: f64,
    force: impl Fn(f64, &mut [f64]),
) -> [f64; 2] {
    let options =
        SettleOptions { steps_per_period: STEPS, maximum_periods: 6000, ..SettleOptions::new(TAU / omega) };
    let mut march = March::new(assembly, 1.0);
    let settled = settle(&mut march, &options, &force);
    assert!(matches!(settled, Settling::Periodic { multiple: 1, .. }), "{omega}: {settled:?}");
    let mut loads = vec![0.0; march.input_count()];
    let (mut sums, mut squares) = ([0.0; 2], [0.0; 2]);
    for _ in 0..STEPS {
        force(march.time() + options.period / STEPS as f64, &mut loads);
        march.step(&loads);
        for port in 0..2 {
            let y = march.displacement(port);
            sums[port] += y / STEPS as f64;
            squares[port] += y * y / STEPS as f64;
        }
    }
    [0, 1].map(|port| (squares[port] - sums[port] * sums[port]).sqrt())
}

/// The tip under the harmonic force of a peer's problem.
fn tip<L: FrictionLaw<f64>>(peer: &Peer, law: Option<L>, loads: Vec<LocalLoad>, omega: f64) -> f64 {
    let normal = Normal::constant(1.0);
    let assembly = Assembly {
        structure: peer.network.structure.clone(),
        inputs: vec![1],
        friction: law.map(|law| FrictionContact { law, slip_port: 0, normal }),
        loads,
    };
    let amplitude = peer.network.loads[0].amplitude.re;
    tips(&assembly, omega, |time, loads| loads[0] = amplitude * (omega * time).cos())[1]
}

fn compare(expected: &[(f64, f64)], found: impl Fn(f64) -> f64) {
    for &(omega, value) in expected {
        let relative = found(omega) / value - 1.0;
        // The references' own scatter; kinks of the force inside one of 4096 steps are of order (2π/4096)².
        assert!(relative.abs() < 5e-6, "{omega}: {relative:e}");
    }
}

#[test]
fn p1_smooth_coulomb() {
    let peer = problems::p1();
    let load =
        LocalLoad { port: 0, characteristic: Characteristic::SmoothCoulomb { level: 1.5, velocity: 6e-7 } };
    let expected = [(260.0, 5.445_687_214_5e-8), (195.0, 6.710_455_58e-8), (140.0, 4.368_446_47e-8)];
    compare(&expected[1..], |omega| tip::<Jenkins<f64>>(&peer, None, vec![load], omega));
    // Order 7 at 260 rad/s is 0.063 % off: the march tells.
    let truncated = tip::<Jenkins<f64>>(&peer, None, vec![load], expected[0].0) / expected[0].1 - 1.0;
    assert!((truncated + 6.3e-4).abs() < 1e-5, "{truncated:e}");
}

fn jenkins(peer: &Peer, stiffness: f64, limit: f64, omega: f64) -> f64 {
    let law = Jenkins { tangential_stiffness: stiffness, mu_k: limit };
    let damping = peer.network.supports[0].damping;
    let dashpot = LocalLoad { port: 0, characteristic: Characteristic::Dashpot(damping) };
    tip(peer, Some(law), vec![dashpot], omega)
}

#[test]
fn p2_jenkins() {
    let peer = problems::p2();
    let expected = [(380.0, 4.455_327_15e-6), (343.0, 5.480_175_8e-6), (330.0, 3.553_964_5e-6)];
    compare(&expected, |omega| jenkins(&peer, 1.3e6, 1.0, omega));
}

#[test]
fn p3_stiff_jenkins() {
    let peer = problems::p3();
    let expected = [(660.0, 2.049_967_2e-5), (488.0, 4.147_532_8e-5), (470.0, 2.454_958_9e-5)];
    compare(&expected, |omega| jenkins(&peer, 1e8, 106.0, omega));
}

#[test]
fn p4_contact_with_lift_off() {
    let structure = problems::p4().network.structure;
    let normal = Normal { port: Some(1), stiffness: -21.0, ..Normal::constant(0.0) };
    let law = Jenkins { tangential_stiffness: 5.0, mu_k: 0.85 };
    // The spring 21 n of the contact pushes where n > 0: a stop without gap on top of the structure's own spring.
    let stop = LocalLoad { port: 1, characteristic: Characteristic::Stop { stiffness: 21.0, gap: 0.0 } };
    let assembly = Assembly {
        structure,
        inputs: vec![0, 1],
        friction: Some(FrictionContact { law, slip_port: 0, normal }),
        loads: vec![stop],
    };
    for row in table(include_str!("peers/p4.csv")).iter().take(4) {
        let omega = row[0];
        let found = tips(&assembly, omega, |time, loads| {
            let cosine = (omega * time).cos();
            (loads[0], loads[1]) = (100.0 * cosine, 100.0 + 10.0 * cosine);
        });
        // The reference march has six digits (its own step); columns 6 and 7.
        for (value, expected) in found.iter().zip(&row[6..8]) {
            assert!((value / expected - 1.0).abs() < 2e-5, "{omega}: {value} {expected}");
        }
    }
}
