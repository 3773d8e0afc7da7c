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
}

/// Between its turning points the Duffing curve is unstable, outside stable. The damped free vibration of the same
/// oscillator has the multipliers `e^{(−ζ ± i√(1−ζ²)) T}`.
#[test]
fn floquet_of_duffing_and_of_free_vibration() {
    let (network, _) = duffing();
    let settings = Settings { order: 7, samples: 128, tolerance: 1e-10, iterations: 30 };
    let mut solver = Solver::new(settings).unwrap();
    let cubic = Cubic(1.0);
    let contacts = [on_slip(&cubic)];
    let sweep = Sweep { range: [0.8, 2.5], ..Sweep::default() };
    let curve = solver.follow(&network, &contacts, &sweep).unwrap();
    let mut middle = false;
    let (mut wrong, mut unstable) = (0, 0);
    for point in &curve.points {
        middle ^= point.turned;
        let stable = solver.floquet(&network, &contacts, (point.omega, 1.0), &point.forces).unwrap().stable();
        wrong += usize::from(stable == middle);
        unstable += usize::from(!stable);
    }
    // A point beside a turning point may count for the other side.
    assert!(wrong <= 2 && unstable > 5, "{wrong} {unstable}");
    let none = Cubic(0.0);
    let zeros = vec![Complex64::ZERO; 8];
    let omega = 0.7;
    let floquet = solver.floquet(&network, &[on_slip(&none)], (omega, 1.0), &zeros).unwrap();
    let expected = (-0.02 * std::f64::consts::TAU / omega).exp();
    // Exact but for rounding: no force acts.
    assert!((floquet.multipliers[0].norm() - expected).abs() < 1e-12);
}

/// A Jenkins element on one mass at order 1: frequency and damping are those of its describing function (the first
/// harmonic of the bilinear loop: T. K. Caughey, J. Appl. Mech. 27 (1960) 640), at every amplitude.
#[test]
fn nonlinear_mode_of_a_jenkins_oscillator() {
    let (stiffness, limit, ratio): (f64, f64, f64) = (0.5, 0.5, 0.01);
    let structure = Structure::new(vec![1.0], vec![ratio], vec![vec![1.0]]).unwrap();
    let network = Network::new(structure, vec![Reading::motion(0)], vec![0]);
    let jenkins = ElasticContact {
        normal_stiffness: 0.0,
        preload: limit,
        tangential_stiffness: stiffness,
        friction_coefficient: 1.0,
    };
    let samples = 4096;
    let mut solver = Solver::new(Settings { order: 1, samples, tolerance: 1e-10, iterations: 30 }).unwrap();
    let modes = Modes { mode: 0, channel: 0, amplitudes: [0.5, 50.0], points: 25 };
    let points = solver.follow_mode(&network, &[on_slip(&jenkins)], &modes).unwrap();
    assert_eq!(points.len(), 25);
    for point in &points {
        let a = point.amplitude;
        let [real, imaginary] = if a * stiffness > limit {
            let angle = (1.0 - 2.0 * limit / (stiffness * a)).acos();
            let unit = stiffness * a / std::f64::consts::PI;
            [unit * (angle - (2.0 * angle).sin() / 2.0), unit * angle.sin().powi(2)]
        } else {
            [stiffness * a, 0.0]
        };
        let omega = (1.0 + real / a).sqrt();
        let damping = (2.0 * ratio + imaginary / (a * omega)) / (2.0 * omega);
        // Kinks between 4096 samples: (2π/4096)² of the loop.
        assert!((point.omega / omega - 1.0).abs() < 1e-5, "{a}: {} {omega}", point.omega);
        assert!((point.damping_ratio / damping - 1.0).abs() < 1e-4, "{a}: {} {damping}", point.damping_ratio);
    }
}

fn duffing() -> (Network, f64) {
    let structure = Structure::new(vec![1.0], vec![0.02], vec![vec![1.0]]).unwrap();
    let mut network = Network::new(structure, vec![Reading::motion(0)], vec![0]);
    network.loads.push(Load { port: 0, harmonic: 1, amplitude: Complex64::new(0.1, 0.0) });
    (network, 0.1)
}

fn on_slip(element: &dyn Element) -> Contact<'_> {
    Contact { slip: 0, normal: Normal::Constant(0.0), force: 0, normal_force: None, element }
}
