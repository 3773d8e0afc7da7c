//! Oracle: the state equation integrated by Runge-Kutta in very many small steps.

use num_dual::DualSVec64;

use super::{Bristle, Saturation, Steady};
use crate::{FrictionLaw, Step};

const OMEGA: f64 = 6.0;

fn slip(t: f64) -> (f64, f64) {
    let (a, b) = (1.1e-4, 0.35e-4);
    let u = a * (OMEGA * t).sin() + b * (3.0 * OMEGA * t + 0.4).cos();
    let v = a * OMEGA * (OMEGA * t).cos() - 3.0 * b * OMEGA * (3.0 * OMEGA * t + 0.4).sin();
    (u, v)
}

fn bristle(saturation: Saturation, steady: Steady) -> Bristle<f64> {
    Bristle {
        sigma0: 4.0e4,
        sigma1: 30.0,
        v_d: 2e-3,
        sigma2: 0.4,
        mu_s: 0.9,
        mu_k: 0.6,
        v_s: 7e-4,
        delta: 2.0,
        exponent: 0.7,
        breakaway: 0.4,
        saturation,
        steady,
    }
}

// The end of the break-away zone (α has a jump in its second derivative there, and a sample may lie anywhere to it)
// costs `Breakaway` an order in some steps; its errors are the size of the others'.
/// z after `duration` by classical Runge-Kutta with `steps` steps.
fn oracle(law: &Bristle<f64>, duration: f64, steps: usize) -> f64 {
    let h = duration / steps as f64;
    let rate = |t: f64, z: f64| {
        let v = slip(t).1;
        law.rate(z, v, law.steady(v))
    };
    (0..steps).fold(0.0, |z, k| {
        let t = k as f64 * h;
        let k1 = rate(t, z);
        let k2 = rate(t + h / 2.0, z + h / 2.0 * k1);
        let k3 = rate(t + h / 2.0, z + h / 2.0 * k2);
        let k4 = rate(t + h, z + h * k3);
        z + h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4)
    })
}

fn step_at(t: f64, dt: f64) -> Step<f64> {
    let ((u0, v0), (u1, v1)) = (slip(t), slip(t + dt));
    Step { slip: [u0, u1], velocity: [v0, v1], normal: [1.0, 1.0], dt }
}

fn marched(law: &Bristle<f64>, duration: f64, steps: usize) -> f64 {
    let dt = duration / steps as f64;
    (0..steps).fold([0.0], |z, k| law.step(z, &step_at(k as f64 * dt, dt)).0)[0]
}

#[test]
fn the_step_converges_to_the_state_equation() {
    let duration = 1.3;
    for (saturation, steady, order, bound) in [
        (Saturation::Linear, Steady::Constant, 3.8, 1e-10),
        (Saturation::Linear, Steady::Stribeck, 3.8, 1e-8),
        (Saturation::Power, Steady::Constant, 3.8, 1e-10),
        (Saturation::Power, Steady::Stribeck, 1.9, 5e-5),
        (Saturation::Breakaway, Steady::Constant, 2.0, 1e-8),
        (Saturation::Breakaway, Steady::Stribeck, 2.0, 1e-7),
    ] {
        let law = bristle(saturation, steady);
        let exact = oracle(&law, duration, 400_000);
        let error = |steps| (marched(&law, duration, steps) - exact).abs() * law.sigma0;
        let (coarse, fine) = (error(150), error(600));
        // σ0 z is of the size of μ = 0.6 … 0.9; the oracle itself is good to 1e-13.
        assert!(fine < bound, "{saturation:?} {steady:?}: {fine:.2e}");
        let measured = (coarse / fine.max(1e-14)).log(4.0);
        assert!(measured > order || coarse < 2e-8, "{saturation:?} {steady:?}: order {measured:.2}");
    }
}

#[test]
fn derivatives_are_those_of_central_differences() {
    for (saturation, steady) in [
        (Saturation::Linear, Steady::Constant),
        (Saturation::Linear, Steady::Stribeck),
        (Saturation::Power, Steady::Constant),
        (Saturation::Power, Steady::Stribeck),
        (Saturation::Breakaway, Steady::Constant),
        (Saturation::Breakaway, Steady::Stribeck),
    ] {
        for (z, t, dt) in [(0.3e-5, 0.0, 0.02), (-0.5e-5, 0.0, 0.2), (1.4e-5, 0.02, 0.05), (1e-5, 0.1, 0.1)] {
            check_derivatives(&bristle(saturation, steady), z, &step_at(t, dt));
        }
    }
}

/// State, motion and parameters as one vector.
fn evaluate<T: crate::Scalar>(law: &Bristle<f64>, x: [T; 17], dt: f64) -> [T; 2] {
    let law = Bristle {
        sigma0: x[7],
        sigma1: x[8],
        v_d: x[9],
        sigma2: x[10],
        mu_s: x[11],
        mu_k: x[12],
        v_s: x[13],
        delta: x[14],
        exponent: x[15],
        breakaway: x[16],
        saturation: law.saturation,
        steady: law.steady,
    };
    let step = Step { slip: [x[1], x[2]], velocity: [x[3], x[4]], normal: [x[5], x[6]], dt };
    let ([z], force) = law.step([x[0]], &step);
    [z, force]
}

fn check_derivatives(law: &Bristle<f64>, z: f64, step: &Step<f64>) {
    let x = [
        z,
        step.slip[0],
        step.slip[1],
        step.velocity[0],
        step.velocity[1],
        step.normal[0],
        step.normal[1],
        law.sigma0,
        law.sigma1,
        law.v_d,
        law.sigma2,
        law.mu_s,
        law.mu_k,
        law.v_s,
        law.delta,
        law.exponent,
        law.breakaway,
    ];
    let duals: [DualSVec64<17>; 17] = std::array::from_fn(|k| DualSVec64::from_re(x[k]).derivative(k));
    let dual = evaluate(law, duals, step.dt);
    let scale = [1e-5, 1e-4, 1e-4, 1e-3, 1e-3, 1.0, 1.0, 4e4, 30.0, 2e-3, 0.4, 0.9, 0.6, 7e-4, 2.0, 0.7, 0.4];
    for k in 0..17 {
        let h = 1e-5 * scale[k];
        let shifted = |sign: f64| {
            let mut y = x;
            y[k] += sign * h;
            evaluate(law, y, step.dt)
        };
        let (plus, minus) = (shifted(1.0), shifted(-1.0));
        for (row, size) in [(0, 1e-5), (1, 1.0)] {
            let numeric = (plus[row] - minus[row]) / (2.0 * h) * scale[k] / size;
            let exact = dual[row].eps.0.map_or(0.0, |slopes| slopes[k]) * scale[k] / size;
            // h² of a central difference times a third derivative up to 1e4 leaves 1e-7. In the
            // partial-slip zone the Runge-Kutta stride is fixed in the derivative and moves in the difference, and kinks of α lie inside strides of 0.15
            // relaxation lengths: 9e-4 at the coarsest step here, falling with the square of the stride.
            let bound = if law.saturation == Saturation::Breakaway { 1e-3 } else { 1e-6 };
            let within = (numeric - exact).abs() < bound * (1.0 + exact.abs());
            assert!(within, "{:?} {:?} row {row} k {k}: {numeric} {exact}", law.saturation, law.steady);
        }
    }
}

#[test]
fn stiff_steps_reach_the_steady_deflection() {
    for saturation in [Saturation::Linear, Saturation::Power, Saturation::Breakaway] {
        let law = bristle(saturation, Steady::Stribeck);
        // σ0 Δu / μ of 6e4: the bristle has long forgotten where it came from; the lag that is left is μ'/σ0.
        let step = Step { slip: [0.0, 1.0], velocity: [1e-4, 3e-4], normal: [1.0; 2], dt: 5e3 };
        let z = law.step([-1e-5], &step).0[0];
        let lag = law.sigma0 * z / law.steady(3e-4) - 1.0;
        assert!(lag.abs() < 3e-4, "{saturation:?} {lag}");
    }
}

#[test]
fn a_velocity_that_is_zero_but_for_rounding_does_no_harm() {
    let law = bristle(Saturation::Breakaway, Steady::Stribeck);
    for velocity in [[1e-3, -1e-20], [1e-20, -1e-3], [0.0, 1e-3], [-1e-3, 0.0], [0.0, 0.0], [-1e-3, 1e-300]] {
        let slip = [1e-5, 1e-5 + 0.5e-2 * (velocity[0] + velocity[1])];
        let step = Step { slip, velocity, normal: [1.0; 2], dt: 1e-2 };
        let ([z], force) = law.step([3e-6], &step);
        let near = z - (3e-6 + slip[1] - slip[0]);
        // An elastic step, or one that has just entered the partial-slip zone.
        assert!(force.is_finite() && near.abs() < 3e-6, "{velocity:?}: {z} {force}");
    }
}

/// A step of a simulated rig that reverses by 4e-7 of its duration before its end, 16 pm/s on the way back: that way is no
/// difference of two slips of 0.16 mm.
#[test]
fn a_reversal_just_before_a_sample_does_no_harm() {
    let law = Bristle {
        sigma0: 5112.168543054344,
        sigma1: 2.202121022910131,
        v_d: 0.027263187019410783,
        sigma2: 0.0,
        mu_s: 0.32150453455582917,
        mu_k: 0.20794397542201054,
        v_s: 0.01914431748970178,
        breakaway: 0.5059469425722378,
        ..bristle(Saturation::Breakaway, Steady::Stribeck)
    };
    let (start, z) = (-0.00015894276372912855, -0.000053647318024578985);
    for (end, back) in [
        (-0.00015894212791334945, -1.5889940286033033e-11),
        (-0.00015894212791334948, -1.589163900771031e-11),
        (-0.00015894212791484912, -1.3878878572439552e-10),
    ] {
        let step = Step {
            slip: [start, end],
            velocity: [4.201736226520057e-5, back],
            normal: [43.40417700033981; 2],
            dt: 0.000030529160913419815,
        };
        for sign in [1.0, -1.0] {
            let turned =
                Step { slip: step.slip.map(|s| sign * s), velocity: step.velocity.map(|v| sign * v), ..step };
            let ([after], force) = law.step([sign * z], &turned);
            let moved = sign * (after - sign * z) / (end - start);
            // The bristle is loaded against the motion, so that all of the slip deflects it.
            assert!(force.is_finite() && (moved - 1.0).abs() < 1e-6, "{end} {sign}: {moved}");
        }
    }
}
