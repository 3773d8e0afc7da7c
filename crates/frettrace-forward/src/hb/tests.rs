//! Tests of the solver on small discrete systems whose answers are known or can be differenced.

mod curves;
mod laws;
mod oscillator;
mod several;
mod wedge;

use super::*;
use crate::ForwardError;
use laws::{Dahl, Jenkins};
use num_complex::Complex64;
use oscillator::Oscillator;

fn solve(lines: &Lines, element: &dyn Element, settings: Settings) -> (Solver, Solution) {
    let contacts = [Contact { slip: 0, normal: Normal::Channel(1), force: 0, normal_force: None, element }];
    let mut solver = Solver::new(settings).unwrap();
    let solution = solver.solve(&Problem { lines, contacts: &contacts }, None).unwrap();
    (solver, solution)
}

const SETTINGS: Settings = Settings { order: 15, samples: 128, tolerance: 1e-11, iterations: 30 };

/// A stuck Jenkins element is a spring: the response is that of the oscillator with `k + kt`, statics included.
#[test]
fn stuck_contact_is_a_spring() {
    let rig = Oscillator { static_load: 0.4, ..Oscillator::default() };
    let jenkins = Jenkins { parameters: [2.0, 50.0] };
    let lines = rig.lines(SETTINGS.order);
    let (_, solution) = solve(&lines, &jenkins, SETTINGS);
    assert_eq!(solution.status, Status::Converged);
    let mut slip = vec![Complex64::ZERO; SETTINGS.order + 1];
    lines.respond(0, &solution.forces, &mut slip);
    for (h, x) in slip.iter().enumerate().take(2) {
        let stuck = rig.load(h) / (rig.dynamic_stiffness(h) + 2.0);
        // Rounding of 128 samples.
        assert!((x - stuck).norm() < 1e-12, "{h}: {x} {stuck}");
    }
}

/// The Jacobian of the balance and the tangents against central differences, with sliding, fading and slowly fading
/// memory, and a normal force that follows the friction force.
#[test]
fn tangents_are_differences() {
    let settings = Settings { tolerance: 1e-12, ..SETTINGS };
    let rig = Oscillator::default();
    for element in [
        &Jenkins { parameters: [2.0, 0.5] } as &dyn Element,
        &Dahl { parameters: [2.0, 0.5] },
        &Dahl { parameters: [2.0, 40.0] },
    ] {
        let lines = rig.lines(settings.order);
        let contacts =
            [Contact { slip: 0, normal: Normal::Channel(1), force: 0, normal_force: None, element }];
        let problem = Problem { lines: &lines, contacts: &contacts };
        let (mut solver, solution) = solve(&lines, element, settings);
        assert_eq!(solution.status, Status::Converged);
        let stiffer = |k: f64| Oscillator { stiffness: k, ..rig }.lines(settings.order);
        // Any step serves for the structure's own derivative: it is a smooth rational function.
        let change = difference(&stiffer(rig.stiffness + 1e-5), &stiffer(rig.stiffness - 1e-5), 2e-5);
        let tangents = solver.tangents(&problem, &solution, &[change]).unwrap();
        let step = 1e-5;
        let solved = |k: f64| solve(&stiffer(k), element, settings).1.forces;
        let (up, down) = (solved(rig.stiffness + step), solved(rig.stiffness - step));
        compare(&tangents.structure[0], &up, &down, step);
    }
}

/// Tangents by the law's parameters against central differences.
#[test]
fn law_tangents_are_differences() {
    let settings = Settings { tolerance: 1e-12, ..SETTINGS };
    let lines = Oscillator::default().lines(settings.order);
    for base in [[2.0, 0.5], [2.0, 40.0]] {
        let dahl = |parameters| Dahl { parameters };
        let (mut solver, solution) = solve(&lines, &dahl(base), settings);
        let element = dahl(base);
        let contacts = [Contact {
            slip: 0,
            normal: Normal::Channel(1),
            force: 0,
            normal_force: None,
            element: &element,
        }];
        let problem = Problem { lines: &lines, contacts: &contacts };
        let tangents = solver.tangents(&problem, &solution, &[]).unwrap();
        for p in 0..2 {
            let step = 1e-3 * base[p];
            let moved = |sign: f64| {
                let mut parameters = base;
                parameters[p] += sign * step;
                solve(&lines, &dahl(parameters), settings).1.forces
            };
            compare(&tangents.law[p], &moved(1.0), &moved(-1.0), step);
        }
    }
}

fn difference(up: &Lines, down: &Lines, width: f64) -> Lines {
    let mut change = Lines::zeros(up.omega(), up.order(), [up.channels(), up.forces()]);
    for c in 0..up.channels() {
        let pairs = up.free(c).iter().zip(down.free(c));
        change.free_mut(c).iter_mut().zip(pairs).for_each(|(x, (a, b))| *x = (a - b) / width);
        let pairs = up.receptance(c, 0).iter().zip(down.receptance(c, 0));
        change.receptance_mut(c, 0).iter_mut().zip(pairs).for_each(|(x, (a, b))| *x = (a - b) / width);
    }
    change
}

fn compare(tangent: &[Complex64], up: &[Complex64], down: &[Complex64], step: f64) {
    let norm = |x: &[Complex64]| x.iter().map(Complex64::norm_sqr).sum::<f64>().sqrt();
    let differenced: Vec<_> = up.iter().zip(down).map(|(a, b)| (a - b) / (2.0 * step)).collect();
    let error: Vec<_> = tangent.iter().zip(&differenced).map(|(a, b)| a - b).collect();
    let relative = norm(&error) / norm(&differenced);
    // Corrections of 1e-12 differenced over 1e-5 of a stiffness; the square of 1e-3 of a parameter.
    assert!(relative < 1e-5, "{relative}");
    assert!(norm(tangent) > 0.0);
}

#[test]
fn bad_index_is_refused() {
    let lines = Oscillator::default().lines(3);
    let element = Jenkins { parameters: [2.0, 0.5] };
    let contacts =
        [Contact { slip: 7, normal: Normal::Channel(1), force: 0, normal_force: None, element: &element }];
    let mut solver = Solver::new(Settings { order: 3, samples: 16, ..SETTINGS }).unwrap();
    let refused = solver.solve(&Problem { lines: &lines, contacts: &contacts }, None);
    let expected = ForwardError::Index { contact: 0, what: "channel", index: 7, available: 2 };
    assert_eq!(refused.err(), Some(expected));
}
