//! The friction-velocity function as the solution of a linear equation: adaptive estimator and sliding-mode controller.

use crate::case::{Case, Outcome, Row};
use frettrace_friction::{FrictionLaw, Step, laws::Lugre};
use std::f64::consts::TAU;

/// The case.
pub const CASE: Case = Case { name: "compare_friction_velocity", run };

/// `F(v) = a + b e^{−cv} + d v` (N): level, rise at rest, decay (s/m), slope (N·s/m).
const LEVEL: f64 = 1.0;
const RISE: f64 = 0.5;
const DECAY: f64 = 30.0;
const SLOPE: f64 = 0.8;
/// Speeds of the estimation (m/s): mean and swing, without a change of sign.
const MEAN: f64 = 0.06;
const SWING: f64 = 0.055;
/// Speed that the slider is to hold (m/s): far down the falling branch.
const HELD: f64 = 0.01;

fn run() -> anyhow::Result<Outcome> {
    let [decay, slope, level] = estimate();
    let parameter = |name: &str, unit, truth: f64, found| Row {
        quantity: format!("{name} of the friction-velocity function, adaptive"),
        unit,
        source: "the simulated slider",
        expected: Some(truth),
        found,
        tolerance: 0.05 * truth,
        reason: "Euler steps of 1 ms",
    };
    let (stops_pid, _) = hold(pid);
    let (stops, error) = hold(sliding_mode);
    let count = |name: &str, expected, found: usize| Row {
        quantity: format!("stops of the slider in 7 s under {name}"),
        unit: "1",
        source: "Tsaprounis and Aspragathos: the controller avoids the stick-slip that PID shows",
        expected,
        found: found as f64,
        tolerance: 0.5,
        reason: "a count",
    };
    Ok(Outcome::Ran(vec![
        parameter("decay", "s/m", DECAY, decay),
        parameter("slope", "N·s/m", SLOPE, slope),
        parameter("level", "N", LEVEL, level),
        count("PID", None, stops_pid),
        Row {
            quantity: "PID sticks and slips".to_owned(),
            unit: "1",
            source: "Tsaprounis and Aspragathos",
            expected: Some(1.0),
            found: f64::from(u8::from(stops_pid > 1)),
            tolerance: 0.0,
            reason: "yes or no",
        },
        count("the sliding-mode controller", Some(0.0), stops),
        Row {
            quantity: "position error under the sliding-mode controller, RMS".to_owned(),
            unit: "m",
            source: "its boundary layer over its gain",
            expected: Some(0.0),
            found: error,
            tolerance: 2.5e-4,
            reason: "a layer of 5 mm/s over a slope of 20/s",
        },
    ]))
}

/// Friction at a speed (N).
fn friction(speed: f64) -> f64 {
    LEVEL + RISE * (-DECAY * speed).exp() + SLOPE * speed
}

/// Decay, slope and level from friction and speed while the speed swings for 200 s.
///
/// In time the function obeys `Ḟ = v̇ (−cF + cd v + ca + d)`, linear in `(c, cd, ca + d)`. A reference model with these
/// three as adjustable gains, `F̂˙ = v̇ p·φ + k e`, `ṗ = γ φ v̇ e`, `e = F − F̂`, has the Lyapunov function
/// `e² + |p − p*|²/γ`; φ is centred and scaled, since its parts are nearly parallel.
fn estimate() -> [f64; 3] {
    const STEP: f64 = 1e-3;
    const RATE: f64 = 2000.0;
    const FEEDBACK: f64 = 20.0;
    let (middle, reach) = (1.2, 0.2);
    let (mut gains, mut model) = ([0.0_f64; 3], friction(MEAN));
    for k in 0..200_000 {
        let angle = TAU * k as f64 * STEP;
        let (speed, change) = (MEAN + SWING * angle.sin(), TAU * SWING * angle.cos());
        let measured = friction(speed);
        let regressor = [(middle - measured) / reach, (speed - MEAN) / SWING, 1.0].map(|r| r * change);
        let error = measured - model;
        let slope: f64 = gains.iter().zip(&regressor).map(|(p, r)| p * r).sum();
        model += STEP * (slope + FEEDBACK * error);
        gains.iter_mut().zip(&regressor).for_each(|(p, r)| *p += STEP * RATE * r * error);
    }
    let decay = gains[0] / reach;
    let slope = gains[1] / SWING / decay;
    let constant = gains[0] * middle / reach - gains[1] * MEAN / SWING + gains[2];
    [decay, slope, (constant - slope) / decay]
}

/// What a controller sees: errors of position and speed, and the integral of the first.
type Errors = [f64; 3];

fn pid([position, speed, integral]: Errors) -> f64 {
    100.0 * position + 10.0 * speed + 200.0 * integral
}

/// `u = λė + F̂(v_d) + K sat(s/Φ)`, `s = ė + λe`, for a mass of 1 kg at constant wanted speed.
fn sliding_mode([position, speed, _]: Errors) -> f64 {
    let surface = speed + 20.0 * position;
    20.0 * speed + friction(HELD) + 0.8 * (surface / 5e-3).clamp(-1.0, 1.0)
}

/// Times the slider of 1 kg stops, and the RMS position error, from the third to the tenth second.
fn hold(controller: fn(Errors) -> f64) -> (usize, f64) {
    const STEP: f64 = 2e-4;
    let law = Lugre {
        sigma0: 1e4,
        sigma1: 60.0,
        v_d: 3e-3,
        sigma2: SLOPE,
        mu_s: LEVEL + RISE,
        mu_k: LEVEL,
        v_s: 1.0 / DECAY,
        delta: 1.0,
    };
    let (mut position, mut speed, mut integral, mut state) = (0.0, 0.0, 0.0, law.rest());
    let (mut stops, mut stopped, mut square, mut count) = (0, false, 0.0, 0.0_f64);
    for k in 0..50_000 {
        let time = k as f64 * STEP;
        let error = HELD * time - position;
        integral += error * STEP;
        let drive = controller([error, HELD - speed, integral]);
        let step = Step {
            slip: [position, position + speed * STEP],
            velocity: [speed; 2],
            normal: [1.0; 2],
            dt: STEP,
        };
        let (next, force) = law.step(state, &step);
        state = next;
        speed += STEP * (drive - force);
        position += STEP * speed;
        if time > 3.0 {
            square += error * error;
            count += 1.0;
            if speed.abs() < 0.1 * HELD && !stopped {
                stops += 1;
            }
            stopped = speed.abs() < if stopped { 0.5 } else { 0.1 } * HELD;
        }
    }
    (stops, (square / count.max(1.0)).sqrt())
}
