//! Several contacts, clearances, subharmonic bases.

use crate::hb::*;
use crate::march::Structure;
use num_complex::Complex64;

const SETTINGS: Settings = Settings { order: 31, samples: 256, tolerance: 1e-11, iterations: 40 };

fn oscillator() -> Network {
    let structure = Structure::new(vec![1.0], vec![0.02], vec![vec![1.0]]).unwrap();
    let mut network = Network::new(structure, vec![Reading::motion(0)], vec![0]);
    network.loads.push(Load { port: 0, harmonic: 1, amplitude: Complex64::ONE });
    network
}

fn slider(share: f64) -> ElasticContact {
    ElasticContact {
        normal_stiffness: 0.0,
        preload: 0.6 * share,
        tangential_stiffness: 2.0 * share,
        friction_coefficient: 1.0,
    }
}

fn contact(force: usize, element: &dyn Element) -> Contact<'_> {
    Contact { slip: 0, normal: Normal::Constant(0.0), force, normal_force: None, element }
}

/// Three tenths and seven tenths of a slider at one place are the slider: on one force, or on two at the same port.
#[test]
fn parts_of_a_contact_are_the_contact() {
    let mut solver = Solver::new(SETTINGS).unwrap();
    let (whole, less, more) = (slider(1.0), slider(0.3), slider(0.7));
    let one = oscillator().lines(0.8, 31, 1.0).unwrap();
    let two = Network { forces: vec![0, 0], ..oscillator() }.lines(0.8, 31, 1.0).unwrap();
    let expected = solver.solve(&Problem { lines: &one, contacts: &[contact(0, &whole)] }, None).unwrap();
    assert_eq!(expected.status, Status::Converged);
    let sum = [contact(0, &less), contact(0, &more)];
    let together = solver.solve(&Problem { lines: &one, contacts: &sum }, None).unwrap();
    let apart = [contact(0, &less), contact(1, &more)];
    let apart = solver.solve(&Problem { lines: &two, contacts: &apart }, None).unwrap();
    for h in 0..=31 {
        // Ten times the tolerance of the forces, which are of order 1.
        assert!((together.forces[h] - expected.forces[h]).norm() < 1e-10);
        assert!((apart.forces[h] + apart.forces[32 + h] - expected.forces[h]).norm() < 1e-10);
        assert!((apart.forces[h] - expected.forces[h] * 0.3).norm() < 1e-10);
    }
}

/// At half the base frequency, with the load on line 2, a motion that repeats with the load is the same motion.
#[test]
fn subharmonic_base_contains_the_harmonic_motion() {
    let element = slider(1.0);
    let mut solver = Solver::new(SETTINGS).unwrap();
    let lines = oscillator().lines(0.8, 31, 1.0).unwrap();
    let harmonic = solver.solve(&Problem { lines: &lines, contacts: &[contact(0, &element)] }, None).unwrap();
    let mut network = oscillator();
    network.loads[0].harmonic = 2;
    let lines = network.lines(0.4, 63, 1.0).unwrap();
    let settings = Settings { order: 63, samples: 512, ..SETTINGS };
    let mut solver = Solver::new(settings).unwrap();
    let found = solver.solve(&Problem { lines: &lines, contacts: &[contact(0, &element)] }, None).unwrap();
    assert_eq!(found.status, Status::Converged);
    for h in 0..=31 {
        assert!((found.forces[2 * h] - harmonic.forces[h]).norm() < 1e-9);
        assert!(found.forces[2 * h + 1].norm() < 1e-9);
    }
}

/// A mass that touches a stop on one side for half its motion: `ω = 2/(1/ω₁ + 1/ω₂)` at every amplitude
/// (S. W. Shaw, P. J. Holmes, J. Sound Vib. 90 (1983) 129), without damping.
#[test]
fn bilinear_mode() {
    let structure = Structure::new(vec![1.0], vec![0.0], vec![vec![1.0]]).unwrap();
    let network = Network::new(structure, vec![Reading::motion(0)], vec![0]);
    let stop = Stop { stiffness: 3.0, damping: 0.0, clearance: 0.0, two_sided: false };
    let settings = Settings { samples: 2048, tolerance: 1e-9, ..SETTINGS };
    let modes = Modes { mode: 0, channel: 0, amplitudes: [0.1, 10.0], points: 5 };
    let points = Solver::new(settings).unwrap().follow_mode(&network, &[contact(0, &stop)], &modes).unwrap();
    assert_eq!(points.len(), 5);
    for point in points {
        // ω₁ = 1, ω₂ = √(1 + 3) = 2; lines above 31 of a force with kinks in its slope are of order 31⁻².
        assert!((point.omega - 4.0 / 3.0).abs() < 1e-4, "{}", point.omega);
        assert!(point.damping_ratio.abs() < 1e-6, "{}", point.damping_ratio);
    }
}
