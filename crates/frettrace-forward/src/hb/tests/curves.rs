//! Curves with turning points, against a closed form.

use crate::hb::*;
use crate::march::Structure;
use frettrace_friction::{Scalar, Step};
use num_complex::Complex64;

/// `f = c x³`, no memory.
#[derive(Clone, Copy)]
struct Cubic(f64);

impl Family for Cubic {
    type Law<T: Scalar> = Self;

    fn parameters(&self) -> &[f64] {
        &[]
    }

    fn law<T: Scalar>(&self, _: &[T]) -> Self {
        *self
    }
}

impl<T: Scalar> ContactLaw<T> for Cubic {
    type State = [T; 0];

    const FORCES: usize = 1;

    fn rest(&self) -> [T; 0] {
        []
    }

    fn step(&self, state: [T; 0], step: &Step<T>) -> ([T; 0], [T; 2]) {
        let x = step.slip[1];
        (state, [x * x * x * self.0, T::zero()])
    }
}

/// Duffing at order 1: `[(1 − ω² + ¾A²)² + (2ζω)²] A² = P²` holds exactly on the whole curve, which turns twice.
#[test]
fn duffing_turns_twice() {
    let structure = Structure::new(vec![1.0], vec![0.02], vec![vec![1.0]]).unwrap();
    let mut network = Network::new(structure, vec![Reading::motion(0)], vec![0]);
    network.loads.push(Load { port: 0, harmonic: 1, amplitude: Complex64::new(0.1, 0.0) });
    let cubic = Cubic(1.0);
    let contacts =
        [Contact { slip: 0, normal: Normal::Constant(0.0), force: 0, normal_force: None, element: &cubic }];
    let settings = Settings { order: 1, samples: 16, tolerance: 1e-11, iterations: 30 };
    let mut solver = Solver::new(settings).unwrap();
    let sweep = Sweep { range: [0.5, 2.5], ..Sweep::default() };
    let curve = solver.follow(&network, &contacts, &sweep).unwrap();
    assert_eq!(curve.status, SweepStatus::Finished);
    assert_eq!(curve.points.iter().filter(|p| p.turned).count(), 2);
    let mut largest = 0.0_f64;
    for point in &curve.points {
        let lines = network.lines(point.omega, 1, 1.0).unwrap();
        let mut x = [Complex64::ZERO; 2];
        lines.respond(0, &point.forces, &mut x);
        let (a, w) = (x[1].norm(), point.omega);
        largest = largest.max(a);
        let balance = ((1.0 - w * w + 0.75 * a * a).powi(2) + (0.04 * w).powi(2)) * a * a;
        assert!((balance / 0.01 - 1.0).abs() < 1e-8, "{w} {a}");
    }
    // At the peak A = P/(2ζω) with ω² = 1 + ¾A²: A = 1.594 (root of ¾A⁴ + A² − 6.25); points lie up to 5 % of the range apart.
    let peak = ((-1.0 + (1.0 + 3.0 * 6.25_f64).sqrt()) / 1.5).sqrt();
    assert!((largest / peak - 1.0).abs() < 0.02, "{largest} {peak}");
    println!(
        "{} points, {} evaluations, {} linearisations",
        curve.points.len(),
        curve.evaluations,
        curve.linearisations
    );
}
