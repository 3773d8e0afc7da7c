//! The wedge damper against its closed form, against a march of a wedge with mass, and under a blade.

use crate::hb::*;
use crate::march::Structure;
use frettrace_friction::Step;
use num_complex::Complex64;
use std::f64::consts::TAU;

const DAMPER: WedgeDamper = WedgeDamper {
    angle: 0.8,
    centrifugal_force: 2.0,
    normal_stiffness: 1.5,
    tangential_stiffness: 1.0,
    friction_coefficient: 0.3,
    neighbour: -1.0,
};

/// Forces over the second of two periods of `u = A cos τ`, and the states of the faces.
fn marched(damper: &WedgeDamper, amplitude: f64, samples: usize) -> (Vec<f64>, Vec<[Interface; 2]>) {
    let slip = |k: usize| amplitude * (TAU * k as f64 / samples as f64).cos();
    let mut state: [f64; 4] = ContactLaw::<f64>::rest(damper);
    let mut last = 0.0;
    let mut found = (Vec::new(), Vec::new());
    for k in 0..3 * samples {
        let step = Step { slip: [last, slip(k)], velocity: [0.0; 2], normal: [0.0; 2], dt: 1.0 };
        if k >= 2 * samples {
            found.1.push(damper.interfaces(state, step.slip));
        }
        let (new, [force, _]) = damper.step(state, &step);
        (state, last) = (new, slip(k));
        if k >= 2 * samples {
            found.0.push(force);
        }
    }
    found
}

fn first_harmonic(forces: &[f64]) -> Complex64 {
    let n = forces.len() as f64;
    let turn = |k: usize| Complex64::from_polar(2.0 / n, -TAU * k as f64 / n);
    forces.iter().enumerate().map(|(k, f)| turn(k) * f).sum()
}

/// Out of phase the damper is the bilinear loop of the analytic criteria: limits to rounding, stick ends at the limits,
/// slip at the reversals; equivalent stiffness and damping are those of the loop.
#[test]
fn opposed_platforms_follow_the_closed_form() {
    let closed = DAMPER.opposed();
    for amplitude in [0.3, 1.0, 3.0, 10.0] {
        let samples = 4096;
        let (forces, states) = marched(&DAMPER, amplitude, samples);
        let [low, high] = [
            forces.iter().copied().fold(f64::MAX, f64::min),
            forces.iter().copied().fold(f64::MIN, f64::max),
        ];
        let [k, h] = closed.equivalent(amplitude);
        let found = first_harmonic(&forces) / amplitude;
        // Kinks between 4096 samples: (2π/4096)² = 2e-6 of the loop.
        assert!(
            (found - Complex64::new(k, h)).norm() < 5e-6 * closed.stiffness,
            "{amplitude}: {found} {k} {h}"
        );
        if 2.0 * amplitude * closed.stiffness > closed.limits[1] - closed.limits[0] {
            assert!((low - closed.limits[0]).abs() < 1e-12 && (high - closed.limits[1]).abs() < 1e-12);
            // From the reversal at u = A it sticks until the force has fallen from limit to limit.
            let travel = (closed.limits[1] - closed.limits[0]) / closed.stiffness;
            let end = (1.0 - travel / amplitude).acos() / TAU * samples as f64;
            let slipping = |k: usize| states[k] != [Interface::Stick; 2];
            let first = (1..samples).find(|&k| slipping(k)).unwrap();
            assert_eq!(first, end.ceil() as usize, "{amplitude}");
        }
    }
}

/// Damping of the wedge with mass: six tenths of critical for the contact's stiffness.
const DASHPOT: f64 = 6e-3;

/// The same wedge with a little mass and damping, marched explicitly: semi-implicit Euler, sliders clipped step by step.
fn heavy_wedge(damper: &WedgeDamper, amplitude: f64, samples: usize) -> Vec<f64> {
    let (mass, fine) = (1e-5, 256);
    let dt = TAU / (samples * fine) as f64;
    let (sin, cos) = damper.angle.sin_cos();
    let faces = [[[-cos, sin], [sin, cos]], [[cos, sin], [-sin, cos]]];
    let static_normal = damper.static_normal_force();
    let (mut place, mut velocity, mut springs, mut before) = ([0.0; 2], [0.0; 2], [0.0_f64; 2], [0.0_f64; 2]);
    let mut forces = Vec::new();
    for k in 0..3 * samples * fine {
        let u = amplitude * (k as f64 * dt).cos();
        let mut load = [0.0, damper.centrifugal_force];
        let mut on_first = 0.0;
        for (i, [normal, tangent]) in faces.into_iter().enumerate() {
            let platform = if i == 0 { u } else { damper.neighbour * u };
            let relative = [place[0] - platform, place[1]];
            let along = |v: [f64; 2]| relative[0] * v[0] + relative[1] * v[1];
            let pressed = (static_normal + damper.normal_stiffness * along(normal)).max(0.0);
            let limit = damper.friction_coefficient * pressed;
            let trial = springs[i] + damper.tangential_stiffness * (along(tangent) - before[i]);
            (springs[i], before[i]) = (trial.clamp(-limit, limit), along(tangent));
            for c in 0..2 {
                load[c] -= pressed * normal[c] + springs[i] * tangent[c];
            }
            if i == 0 {
                on_first = pressed * normal[0] + springs[0] * tangent[0];
            }
        }
        for c in 0..2 {
            velocity[c] += dt * (load[c] - DASHPOT * velocity[c]) / mass;
            place[c] += dt * velocity[c];
        }
        if k % fine == 0 && k >= 2 * samples * fine {
            forces.push(-on_first - static_normal * damper.angle.cos());
        }
    }
    forces
}

/// Both faces coupled, one platform still or following: the states found by inequalities give what a march of the wedge gives.
#[test]
fn states_follow_a_march_of_the_wedge() {
    for (neighbour, amplitude) in [(-1.0, 2.0), (0.0, 3.0), (0.5, 8.0)] {
        let damper = WedgeDamper { neighbour, ..DAMPER };
        let samples = 256;
        let (quasi_static, states) = marched(&damper, amplitude, samples);
        let heavy = heavy_wedge(&damper, amplitude, samples);
        let worst = quasi_static.iter().zip(&heavy).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        // The wedge moves at most as fast as the platform, 1 rad/s times A; both faces carry what its dashpot takes.
        assert!(worst < 2.0 * DASHPOT * amplitude, "{neighbour}: {worst}");
        assert!(states.iter().any(|s| s != &[Interface::Stick; 2]));
    }
}

/// Under a blade of one mode at order 1 the balance holds with the loop's equivalent stiffness and damping.
#[test]
fn blade_with_wedge_damper() {
    let structure = Structure::new(vec![1.0], vec![0.005], vec![vec![1.0]]).unwrap();
    let mut network = Network::new(structure, vec![Reading::motion(0)], vec![0]);
    network.loads.push(Load { port: 0, harmonic: 1, amplitude: Complex64::new(0.4, 0.0) });
    let contact =
        Contact { slip: 0, normal: Normal::Constant(0.0), force: 0, normal_force: None, element: &DAMPER };
    let settings = Settings { order: 1, samples: 4096, tolerance: 1e-10, iterations: 60 };
    let mut solver = Solver::new(settings).unwrap();
    for omega in [0.9, 1.1, 1.3, 1.6] {
        let lines = network.lines(omega, 1, 1.0).unwrap();
        let contacts = [contact];
        let solution = solver.solve(&Problem { lines: &lines, contacts: &contacts }, None).unwrap();
        assert_eq!(solution.status, Status::Converged, "{omega}");
        let amplitude = lines.motion(0, &solution.forces)[1].norm();
        let [k, h] = DAMPER.opposed().equivalent(amplitude);
        let stiffness = Complex64::new(1.0 - omega * omega + k, 0.01 * omega + h);
        assert!((amplitude * stiffness.norm() / 0.4 - 1.0).abs() < 1e-4, "{omega}: {amplitude}");
    }
}
