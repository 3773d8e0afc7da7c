//! Finite elements of the rig with static and with dynamic friction, after the 2019 study of the frictional beam.
//!
//! An "experiment" (hybrid law, 60 elements) is predicted by models of 24 elements whose friction is fitted to the
//! experiment's own contact force: a static law gets the size of the friction force right and the beam wrong, the laws with
//! a presliding spring get both right.

#![allow(clippy::unwrap_used, reason = "a test")]

use std::f64::consts::TAU;

use frettrace_beam::{Dof, FiniteElements, UniformBeam};
use frettrace_forward::march::{
    Assembly, FrictionContact, March, Moment, Normal, SettleOptions, Settling, Structure, settle,
};
use frettrace_friction::FrictionLaw;
use frettrace_friction::laws::{Coulomb, Dahl, Hybrid, Lugre, Stribeck};

const LENGTH: f64 = 0.5;
const ARM: f64 = 0.0037;
const SUPPORT: f64 = 5e6;
const SAMPLES: usize = 512;
/// Steps a sample.
const REFINEMENT: usize = 4;
const OMEGA: f64 = TAU * 109.0;

/// Exciter, slip, end, sensor.
fn structure(elements: usize) -> Structure {
    let beam = UniformBeam::rectangular(LENGTH, [0.03, 0.0075], 2.0e11, 7850.0);
    let mut mesh = FiniteElements::clamped(&beam, elements).unwrap();
    mesh.add_spring(Dof::displacement(LENGTH), SUPPORT);
    let modes = mesh.eigenmodes().unwrap();
    let row = |dof: Dof, factor: f64| -> Vec<f64> {
        let row = mesh.row(dof);
        let sum = |n: usize| row.iter().enumerate().map(|(i, r)| factor * r * modes.modes[(i, n)]).sum();
        (0..row.len()).map(sum).collect()
    };
    let rows = vec![
        row(Dof::displacement(0.21), 1.0),
        row(Dof::rotation(LENGTH), ARM),
        row(Dof::displacement(LENGTH), 1.0),
        row(Dof::displacement(0.31), 1.0),
    ];
    let damping = vec![0.005; modes.natural_frequency.len()];
    Structure::new(modes.natural_frequency, damping, rows).unwrap()
}

/// Contact and sensor displacement over the settled period.
fn respond<L: FrictionLaw<f64>>(law: L, elements: usize, amplitude: f64) -> Vec<(Moment, f64)> {
    let normal = Normal { port: Some(2), stiffness: SUPPORT, ..Normal::constant(70.0) };
    let assembly = Assembly {
        structure: structure(elements),
        inputs: vec![0],
        friction: Some(FrictionContact { law, slip_port: 1, normal }),
        loads: Vec::new(),
    };
    let steps = SAMPLES * REFINEMENT;
    let options =
        SettleOptions { steps_per_period: steps, tolerance: 1e-7, ..SettleOptions::new(TAU / OMEGA) };
    let mut march = March::new(&assembly, 1.0);
    let force = |time: f64| amplitude * (OMEGA * time).cos();
    let settled = settle(&mut march, &options, |time, loads| loads[0] = force(time));
    assert!(matches!(settled, Settling::Periodic { multiple: 1, .. }), "{settled:?}");
    let dt = options.period / steps as f64;
    let mut record = Vec::new();
    for step in 1..=steps {
        march.step(&[force(march.time() + dt)]);
        if step % REFINEMENT == 0 {
            record.push((march.moment(), march.displacement(3)));
        }
    }
    record
}

/// Relative root mean square of the difference.
fn error(found: &[(Moment, f64)], truth: &[(Moment, f64)], read: impl Fn(&(Moment, f64)) -> f64) -> f64 {
    let square = |values: &mut dyn Iterator<Item = f64>| values.map(|x| x * x).sum::<f64>().sqrt();
    let difference = square(&mut found.iter().zip(truth).map(|(a, b)| read(a) - read(b)));
    difference / square(&mut truth.iter().map(&read))
}

fn root_mean_square(record: &[(Moment, f64)]) -> f64 {
    (record.iter().map(|(m, _)| m.friction.powi(2)).sum::<f64>() / record.len() as f64).sqrt()
}

/// Friction over normal force against `sgn v` and `sgn v · e^{−|v|/v_s}`: coefficients and remaining square.
fn static_fit(record: &[(Moment, f64)], v_s: f64) -> ([f64; 2], f64) {
    let (mut a, mut b) = ([0.0_f64; 3], [0.0_f64; 2]);
    let columns = |m: &Moment| (m.velocity.signum(), m.velocity.signum() * (-m.velocity.abs() / v_s).exp());
    for (m, _) in record {
        let ((c, d), y) = (columns(m), m.friction / m.normal);
        a = [a[0] + c * c, a[1] + c * d, a[2] + d * d];
        b = [b[0] + c * y, b[1] + d * y];
    }
    let determinant = a[0] * a[2] - a[1] * a[1];
    let x = [(b[0] * a[2] - b[1] * a[1]) / determinant, (a[0] * b[1] - a[1] * b[0]) / determinant];
    let rest = |m: &Moment| {
        let (c, d) = columns(m);
        (m.friction / m.normal - x[0] * c - x[1] * d).powi(2)
    };
    (x, record.iter().map(|(m, _)| rest(m)).sum())
}

/// Errors of the beam (Coulomb, Stribeck, Dahl, hybrid) and sizes of their friction force at an amplitude of the force (N).
fn predicted(force: f64) -> [[f64; 4]; 2] {
    let lugre = Lugre {
        sigma0: 5e5,
        sigma1: 0.0,
        v_d: 1e-3,
        sigma2: 0.0,
        mu_s: 0.25,
        mu_k: 0.25,
        v_s: 1e-3,
        delta: 2.0,
    };
    let hybrid = Hybrid { lugre, breakaway: 0.3 };
    let truth = respond(hybrid, 60, force);
    let products = |(m, _): &(Moment, f64)| m.velocity.signum() * m.friction / m.normal;
    let mu_k = truth.iter().map(products).sum::<f64>() / truth.len() as f64;
    let widths = (0..24).map(|k| 1e-5 * 1.4_f64.powi(k));
    let ([level, rise], v_s, _) = widths
        .map(|v_s| {
            let (fit, rest) = static_fit(&truth, v_s);
            (fit, v_s, rest)
        })
        .min_by(|a, b| a.2.total_cmp(&b.2))
        .unwrap();
    let mu_s = (level + rise).max(1e-3);
    let stribeck = Stribeck { mu_s, mu_k: level, v_s, delta: 1.0, sigma2: 0.0 };
    let found = [
        respond(Coulomb { mu_k }, 24, force),
        respond(stribeck, 24, force),
        respond(Dahl { sigma0: 5e5, mu_k: 0.25, exponent: 1.0 }, 24, force),
        respond(hybrid, 24, force),
    ];
    let beam = found.each_ref().map(|record| error(record, &truth, |(_, w)| *w));
    let size = found.each_ref().map(|record| root_mean_square(record) / root_mean_square(&truth));
    [beam, size]
}

/// Slips of 7 and of 48 elastic deflections. Found: Coulomb 25 % and 2.6 %, Stribeck 28 % and 2.1 %, Dahl 3 % and less.
/// Fitted to force over velocity, Stribeck's curve rises, since a presliding contact gives way first; it is nearer to the beam than
/// Coulomb's, as the study found, only where sliding prevails: where presliding matters no function of the velocity helps.
#[test]
fn static_friction_gets_the_force_right_and_the_beam_wrong() {
    for (force, sliding) in [(1.1, false), (8.0, true)] {
        let [beam, size] = predicted(force);
        // The right order of the friction force, whatever the law.
        assert!(size.iter().all(|s| (0.5..2.0).contains(s)), "{size:?}");
        let [coulomb, stribeck, dahl, hybrid] = beam;
        assert_eq!(stribeck < coulomb, sliding, "{beam:?}");
        assert!(coulomb.min(stribeck) > if sliding { 0.01 } else { 0.1 }, "{beam:?}");
        assert!(dahl < 0.5 * coulomb.min(stribeck), "{beam:?}");
        // Two meshes and two steps: frequencies differ by (β/24)⁴/1440-like 1e-5, amplified by 1/(2ζ).
        assert!(hybrid < 1e-3, "{beam:?}");
    }
}
