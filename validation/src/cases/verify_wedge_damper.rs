//! The wedge damper's two coupled faces against the closed form of opposed neighbours, and under a blade.

use crate::case::{Case, Outcome, Row};
use frettrace_forward::hb::{
    Contact, ContactLaw, Interface, Load, Network, Normal, Problem, Reading, Settings, Solver, Status,
    WedgeDamper,
};
use frettrace_forward::march::Structure;
use frettrace_friction::Step;
use num_complex::Complex64;
use std::f64::consts::TAU;

/// The case.
pub const CASE: Case = Case { name: "verify_wedge_damper", run };

const DAMPER: WedgeDamper = WedgeDamper {
    angle: 0.8,
    centrifugal_force: 2.0,
    normal_stiffness: 1.5,
    tangential_stiffness: 1.0,
    friction_coefficient: 0.3,
    neighbour: -1.0,
};
const SAMPLES: usize = 4096;
/// Force on the blade.
const FORCE: f64 = 0.4;

fn run() -> anyhow::Result<Outcome> {
    let mut rows = Vec::new();
    for amplitude in [1.0, 3.0, 10.0] {
        rows.extend(cycle(amplitude));
    }
    for omega in [0.9, 1.1, 1.3] {
        rows.push(blade(omega)?);
    }
    Ok(Outcome::Ran(rows))
}

/// The faces marched through cycles of `u = A cos τ`: first harmonic of the force, and where sticking ends.
fn cycle(amplitude: f64) -> [Row; 3] {
    let slip = |k: usize| amplitude * (TAU * k as f64 / SAMPLES as f64).cos();
    let mut state: [f64; 4] = ContactLaw::<f64>::rest(&DAMPER);
    let (mut before, mut first, mut stuck) = (0.0, Complex64::ZERO, None);
    for k in 0..3 * SAMPLES {
        let step = Step { slip: [before, slip(k)], velocity: [0.0; 2], normal: [0.0; 2], dt: 1.0 };
        // The third cycle is the same as all that follow.
        if let Some(k) = k.checked_sub(2 * SAMPLES).filter(|&k| k > 0) {
            let slides = DAMPER.interfaces(state, step.slip) != [Interface::Stick; 2];
            stuck = stuck.or(slides.then_some(k));
        }
        let (new, [force, _]) = DAMPER.step(state, &step);
        (state, before) = (new, slip(k));
        if k >= 2 * SAMPLES {
            first += Complex64::from_polar(2.0 / SAMPLES as f64, -TAU * k as f64 / SAMPLES as f64) * force;
        }
    }
    let closed = DAMPER.opposed();
    let [stiffness, loss] = closed.equivalent(amplitude);
    let travel = (closed.limits[1] - closed.limits[0]) / closed.stiffness;
    let row = |quantity: &str, unit, expected, found, tolerance| Row {
        quantity: format!("cycle of amplitude {amplitude}: {quantity}"),
        unit,
        source: "bilinear loop of opposed neighbours, in closed form",
        expected: Some(expected),
        found,
        tolerance,
        reason: "kinks between 4096 samples",
    };
    let turn = TAU / SAMPLES as f64;
    let end = stuck.map_or(f64::NAN, |k| k as f64 * turn);
    [
        row("equivalent stiffness", "N/m", stiffness, first.re / amplitude, 5e-6 * closed.stiffness),
        row("equivalent loss", "N/m", loss, first.im / amplitude, 5e-6 * closed.stiffness),
        row("phase at which sticking ends", "rad", (1.0 - travel / amplitude).acos(), end, turn),
    ]
}

/// A blade of one mode: its amplitude by harmonic balance of order 1 over that with the closed form's stiffness and loss.
fn blade(omega: f64) -> anyhow::Result<Row> {
    let structure = Structure::new(vec![1.0], vec![0.005], vec![vec![1.0]])?;
    let mut network = Network::new(structure, vec![Reading::motion(0)], vec![0]);
    network.loads.push(Load { port: 0, harmonic: 1, amplitude: FORCE.into() });
    let contact =
        Contact { slip: 0, normal: Normal::Constant(0.0), force: 0, normal_force: None, element: &DAMPER };
    let settings = Settings { order: 1, samples: SAMPLES, tolerance: 1e-10, iterations: 60 };
    let lines = network.lines(omega, 1, 1.0)?;
    let solution = Solver::new(settings)?.solve(&Problem { lines: &lines, contacts: &[contact] }, None)?;
    let converged = if solution.status == Status::Converged { 1.0 } else { f64::NAN };
    let amplitude = converged * lines.motion(0, &solution.forces)[1].norm();
    let [stiffness, loss] = DAMPER.opposed().equivalent(amplitude);
    let dynamic = Complex64::new(1.0 - omega * omega + stiffness, 0.01 * omega + loss);
    Ok(Row {
        quantity: format!("blade at frequency ratio {omega}: amplitude"),
        unit: "m",
        source: "one mode with the closed form's stiffness and loss at that amplitude",
        expected: Some(FORCE / dynamic.norm()),
        found: amplitude,
        tolerance: 1e-4 * amplitude,
        reason: "kinks between 4096 samples",
    })
}
