use super::*;

/// Three damped modes, held at port 0, loaded at port 1.
fn structure() -> Structure {
    let rows = vec![vec![1.0, -0.8, 0.5], vec![0.3, 0.9, -0.4]];
    Structure::new(vec![1.0, 2.7, 6.1], vec![0.05, 0.01, 0.3], rows).unwrap()
}

/// A motion that leaves the held port where it is.
const START: [[f64; 3]; 2] = [[0.2, 0.1, 0.7], [0.4, 0.25, -0.4]];
const LOADS: [f64; 2] = [0.6, -1.1];

/// The equations of the module as they stand, by the classical Runge-Kutta rule in a thousand steps.
fn marched(duration: f64) -> [[f64; 3]; 2] {
    let structure = structure();
    let (shape, loaded) = (structure.row(0), structure.row(1));
    let (w, z) = (structure.natural_frequency(), structure.damping_ratio());
    let rates = |time: f64, [q, v]: [[f64; 3]; 2]| {
        let load = LOADS[0] + (LOADS[1] - LOADS[0]) * time / duration;
        let free = [0, 1, 2].map(|n| loaded[n] * load - 2.0 * z[n] * w[n] * v[n] - w[n] * w[n] * q[n]);
        let force = dot(shape, &free) / dot(shape, shape);
        [v, [0, 1, 2].map(|n| free[n] - shape[n] * force)]
    };
    let along = |y: [[f64; 3]; 2], k: [[f64; 3]; 2], h: f64| {
        [0, 1].map(|part| [0, 1, 2].map(|n| y[part][n] + h * k[part][n]))
    };
    let (mut y, h) = (START, duration / 1000.0);
    for step in 0..1000 {
        let t = f64::from(step) * h;
        let k1 = rates(t, y);
        let k2 = rates(t + h / 2.0, along(y, k1, h / 2.0));
        let k3 = rates(t + h / 2.0, along(y, k2, h / 2.0));
        let k4 = rates(t + h, along(y, k3, h));
        for (k, weight) in [(k1, 1.0), (k2, 2.0), (k3, 2.0), (k4, 1.0)] {
            y = along(y, k, weight * h / 6.0);
        }
    }
    y
}

fn advanced(step: &Held, start: [[f64; 3]; 2], loads: [f64; 2]) -> [[f64; 3]; 2] {
    let mut end = [[0.0; 3]; 2];
    let [q, v] = &mut end;
    step.advance([&start[0], &start[1]], [&loads[..1], &loads[1..]], [q, v]);
    end
}

fn largest_difference(a: [[f64; 3]; 2], b: [[f64; 3]; 2]) -> f64 {
    a.as_flattened().iter().zip(b.as_flattened()).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}

/// Long steps and short ones; Runge-Kutta's own error `(ωh)⁴·ωT/120` is 1e-9 of the fastest mode over four time units.
#[test]
fn a_held_step_is_exact_whatever_its_length() {
    assert!(dot(structure().row(0), &START[1]).abs() < 1e-15, "the port is at rest");
    for duration in [4.0, 0.3, 1e-3] {
        let ladder = Held::ladder(&structure(), (0, &[1]), (duration, 1));
        let [found, expected] = [advanced(&ladder[0], START, LOADS), marched(duration)];
        assert!(largest_difference(found, expected) < 2e-8, "{duration}: {found:?} {expected:?}");
        let moved = [found, START].map(|motion| dot(structure().row(0), &motion[0]));
        assert!((moved[0] - moved[1]).abs() < 1e-13 && dot(structure().row(0), &found[1]).abs() < 1e-13);
    }
}

/// Thousands of the shortest steps of a ladder are its longest: doubling keeps the digits.
#[test]
fn halved_steps_make_the_whole() {
    let ladder = Held::ladder(&structure(), (0, &[1]), (0.5, 13));
    let shares = 1 << 12;
    let load = |k: i32| LOADS[0] + (LOADS[1] - LOADS[0]) * f64::from(k) / f64::from(shares);
    let steps = (0..shares).fold(START, |y, k| advanced(&ladder[12], y, [load(k), load(k + 1)]));
    let difference = largest_difference(steps, advanced(&ladder[0], START, LOADS));
    assert!(difference < 1e-12, "{difference:e}");
}

/// A load at the end of the step, and one all through it, are columns of the step; the port that is held does not answer.
#[test]
fn loads_are_added_afterwards() {
    let step = Held::ladder(&structure(), (0, &[1]), (0.7, 1)).remove(0);
    for (constant, loads) in [(false, [0.0, 2.0]), (true, [2.0, 2.0])] {
        let expected = advanced(&step, START, loads);
        let mut found = advanced(&step, START, [0.0; 2]);
        let [q, v] = &mut found;
        step.add_load((0, constant), 2.0, [q, v]);
        assert!(largest_difference(found, expected) < 1e-15);
        let [to_q, to_v] = step.response(structure().row(0), (0, constant));
        assert!(to_q.abs() < 1e-15 && to_v.abs() < 1e-15, "{to_q} {to_v}");
    }
}

/// The holding force makes the port's acceleration nought, and its rate is the difference quotient of the force along the motion.
#[test]
fn the_holding_force_and_its_rate() {
    let structure = structure();
    let holding = Holding::new(&structure, 0);
    let h = 1e-5;
    let ladder = Held::ladder(&structure, (0, &[1]), (h, 1));
    let loads = [LOADS[0], LOADS[0] + (LOADS[1] - LOADS[0]) * h];
    let beside = loads.map(|load| structure.row(1).iter().map(|g| g * load).collect::<Vec<_>>());
    let motions = [START, advanced(&ladder[0], START, loads)];
    let force = [0, 1].map(|k| holding.force([&motions[k][0], &motions[k][1], &beside[k]]));
    let all: Vec<f64> = beside[0].iter().zip(structure.row(0)).map(|(p, g)| p - g * force[0]).collect();
    assert!(holding.force([&START[0], &START[1], &all]).abs() < 1e-14, "acceleration of the held port");
    let load_rate = dot(structure.row(0), structure.row(1)) * (LOADS[1] - LOADS[0]) / holding.mobility;
    let rate = holding.rate([&START[0], &START[1], &all]) + load_rate;
    // The quotient is off by half the second rate, some ω²F = 40 times 1e-5.
    assert!((rate - (force[1] - force[0]) / h).abs() < 1e-3, "{rate} {force:?}");
}

/// What is still to come after two periods of a motion under a steady periodic load is what the sum of all further changes is.
#[test]
fn the_steady_state_is_known_after_a_period() {
    let steps = 5;
    let step = Held::ladder(&structure(), (0, &[1]), (0.2, 1)).remove(0);
    let load = |k: usize| (std::f64::consts::TAU * k as f64 / steps as f64).sin();
    let period = |y: [[f64; 3]; 2]| (0..steps).fold(y, |y, k| advanced(&step, y, [load(k), load(k + 1)]));
    let once = period(START);
    let change = [0, 1].map(|part| [0, 1, 2].map(|n| once[part][n] - START[part][n]));
    let to_come = step.to_come(&structure(), 0, [&change[0], &change[1]], steps).unwrap();
    let steady = [0, 1].map(|part| [0, 1, 2].map(|n| once[part][n] + to_come[part][n]));
    assert!(largest_difference(steady, once) > 0.1, "the motion was far from steady");
    assert!(largest_difference(period(steady), steady) < 1e-12);
    let place = |y: [[f64; 3]; 2]| dot(structure().row(0), &y[0]);
    assert!((place(steady) - place(START)).abs() < 1e-13, "it is held where it was");
}

/// `1 − 4s(1 − s)` touches zero in the middle and `1 − 4.4 s(1 − s)` passes below; a straight line and what rises all the way do not.
#[test]
fn cubics_that_dip_are_told() {
    assert!(!dips([1.0, 1.0], [-3.9, 3.9]));
    assert!(dips([1.0, 1.0], [-4.4, 4.4]));
    assert!(!dips([1.0, 0.0], [-1.0, -1.0]));
    assert!(!dips([0.0, 1.0], [0.0, 3.0]));
    assert!(dips([0.0, 1.0], [-0.5, 1.0]) && dips([1.0, 0.0], [-1.0, 0.5]));
}
