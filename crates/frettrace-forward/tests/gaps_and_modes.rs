//! Stops behind a clearance, motions that repeat with every second period of the load, and nonlinear modes: against the time
//! march and against closed forms.

#[path = "peers/problems.rs"]
#[allow(dead_code, missing_docs, clippy::unwrap_used)]
mod problems;

use frettrace_forward::hb::{
    Accuracy, AdaptiveSolver, Contact, Element, Family, Friction, Lines, Load, Modes, Network, Normal,
    Problem, Reading, Settings, Solver, Status, Stop,
};
use frettrace_forward::march::{
    Assembly, Characteristic, LocalLoad, March, SettleOptions, Settling, Structure, settle,
};
use frettrace_friction::laws::{Dahl, Jenkins};
use frettrace_friction::{Bristle, Scalar};
use num_complex::Complex64;
use problems::rms;
use std::f64::consts::{PI, TAU};

const STEPS: usize = 16384;

fn on(element: &dyn Element) -> Contact<'_> {
    Contact { slip: 0, normal: Normal::Constant(0.0), force: 0, normal_force: None, element }
}

/// Root mean square of a port, mean left out, over the settled motion, and its multiple of the load's period, 0 where it
/// does not settle.
fn marched(
    structure: &Structure,
    stop: Stop,
    [load, port]: [usize; 2],
    [force, omega]: [f64; 2],
) -> (f64, usize) {
    let characteristic = Characteristic::Stop { stiffness: stop.stiffness, gap: stop.clearance };
    let assembly: Assembly<Jenkins<f64>> = Assembly {
        structure: structure.clone(),
        inputs: vec![load],
        friction: None,
        loads: vec![LocalLoad { port: 0, characteristic }],
    };
    let options =
        SettleOptions { steps_per_period: STEPS, tolerance: 1e-8, ..SettleOptions::new(TAU / omega) };
    let known = |time: f64, out: &mut [f64]| out[0] = force * (omega * time).cos();
    let mut march = March::new(&assembly, options.period / STEPS as f64);
    let settled = settle(&mut march, &options, known);
    let multiple = if let Settling::Periodic { multiple, .. } = settled { multiple } else { 0 };
    let (start, dt) = (march.time(), options.period / STEPS as f64);
    let mut values = [0.0];
    let samples: Vec<f64> = (1..=multiple * STEPS)
        .map(|k| {
            known(start + k as f64 * dt, &mut values);
            march.step(&values);
            march.displacement(port)
        })
        .collect();
    let mean = samples.iter().sum::<f64>() / samples.len() as f64;
    let square = samples.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / samples.len() as f64;
    (square.sqrt(), multiple)
}

// The march's hold errs by (ωΔt)²/12 = 1.2e-8 on line 1, and by as much more on the lines above and near a resonance.
fn agree(name: &str, one: f64, other: f64) {
    assert!((one / other - 1.0).abs() < 1e-6, "{name}: {one:e} {other:e} {:e}", one / other - 1.0);
}

/// The cantilever of P2 whose node hits a stop: from a distance, at rest on it, and pressed against it.
#[test]
fn a_one_sided_stop() {
    let mut network = problems::p2().network;
    network.supports.clear();
    let reach = 4e-7;
    for (clearance, omega) in [(reach, 270.0), (0.0, 230.0), (-reach, 230.0)] {
        let stop = Stop { stiffness: 1e6, damping: 0.0, clearance, two_sided: false };
        // A pressed stop pushes at rest: the march starts there at once, the balance has it in line 0.
        let accuracy = Accuracy {
            truncation: 1e-8,
            sampling: 1e-7,
            orders: [31, 255],
            samples: 8192,
            ..Accuracy::default()
        };
        let settings = Settings { tolerance: 1e-10, ..Settings::default() };
        let lines = network.lines(omega, 511, 1.0).unwrap();
        let contacts = [on(&stop)];
        let problem = Problem { lines: &lines, contacts: &contacts };
        let found = AdaptiveSolver::new(accuracy, settings).solve(&problem, None).unwrap();
        assert_eq!(found.solution.status, Status::Converged, "{clearance:e} {omega} {found:?}");
        let tip = rms(&lines.motion(1, &found.solution.forces), false);
        let forces = &found.solution.forces;
        assert!(forces[2].norm() > 1e-3 * forces[1].norm(), "the stop is not left and touched");
        let (expected, multiple) = marched(&network.structure, stop, [1, 1], [0.2, omega]);
        assert_eq!(multiple, 1);
        agree(&format!("stop at {clearance:e} m, {omega} rad/s"), tip, expected);
    }
}

/// A mass that rests on a stop, driven near twice its frequency `2/(1 + 1/√10) = 1.52`, answers with every second period.
#[test]
fn a_motion_of_two_periods() {
    let (omega, stiffness) = (3.0, 9.0);
    let structure = Structure::new(vec![1.0], vec![0.03], vec![vec![1.0]]).unwrap();
    let mut network = Network::new(structure.clone(), vec![Reading::motion(0)], vec![0]);
    let stop = Stop { stiffness, damping: 0.0, clearance: 0.0, two_sided: false };
    // The kink lies between two of 16384 samples.
    let settings = Settings { order: 127, samples: 16384, tolerance: 1e-11, iterations: 60 };
    let mut solver = Solver::new(settings).unwrap();

    // One period of the load: a motion there is, which small disturbances leave.
    network.loads = vec![Load { port: 0, harmonic: 1, amplitude: Complex64::ONE }];
    let lines = network.lines(omega, 127, 1.0).unwrap();
    let single = solver.solve(&Problem { lines: &lines, contacts: &[on(&stop)] }, None).unwrap();
    assert_eq!(single.status, Status::Converged);
    let floquet = solver.floquet(&network, &[on(&stop)], (omega, 1.0), &single.forces).unwrap();
    assert!(!floquet.stable());

    // Two periods: half-waves of an amplitude of 2 to start from, at any phase until one leads to another motion.
    network.loads[0].harmonic = 2;
    let lines = network.lines(omega / 2.0, 255, 1.0).unwrap();
    let double =
        (0..12).find_map(|turn| half_waves(&mut solver, &lines, &stop, TAU * f64::from(turn) / 12.0));
    let forces = double.unwrap();
    let motion = lines.motion(0, &forces);
    assert!(motion[1].norm() > 10.0 * motion[2].norm(), "{} {}", motion[1], motion[2]);
    let (expected, multiple) = marched(&structure, stop, [0, 0], [1.0, omega]);
    assert_eq!(multiple, 2);
    agree("two periods", rms(&motion, false), expected);
    let floquet = solver.floquet(&network, &[on(&stop)], (omega / 2.0, 1.0), &forces).unwrap();
    assert!(floquet.stable());
}

/// Contact forces of a motion in which line 1 is not nothing.
fn half_waves(solver: &mut Solver, lines: &Lines, stop: &Stop, phase: f64) -> Option<Vec<Complex64>> {
    let amplitude = 2.0 * stop.stiffness;
    let start = [(amplitude / PI).into(), Complex64::from_polar(amplitude / 2.0, phase)];
    let found = solver.solve(&Problem { lines, contacts: &[on(stop)] }, Some(&start)).ok()?;
    let other = found.status == Status::Converged && found.forces[1].norm() > 0.1;
    other.then_some(found.forces)
}

/// The Dahl element, for which Liouville's formula is closed.
struct Rubbing {
    sigma0: f64,
    mu_k: f64,
}

impl Family for Rubbing {
    type Law<T: Scalar> = Friction<Bristle<T>>;

    fn parameters(&self) -> &[f64] {
        &[]
    }

    fn law<T: Scalar>(&self, _: &[T]) -> Self::Law<T> {
        let dahl = Dahl { sigma0: self.sigma0.into(), mu_k: self.mu_k.into(), exponent: T::one() };
        Friction(dahl.bristle())
    }
}

/// A mass on a spring under Dahl's friction has the states `x, ẋ, z` with `ẍ = −x − 2ζẋ − σ₀z + p(t)` and `ż = ẋ − |ẋ| z/Z`,
/// `Z = μ/σ₀`. By Liouville's formula the product of its multipliers is `exp ∮ tr J dt = exp(−2ζT − s/Z)` with the path `s` of a
/// period, whatever the motion (P. Hartman, Ordinary Differential Equations, 1964, IV.1).
#[test]
fn multipliers_under_friction_have_the_product_of_liouville() {
    let (ratio, omega) = (0.02, 0.9);
    let rubbing = Rubbing { sigma0: 0.5, mu_k: 0.3 };
    let structure = Structure::new(vec![1.0], vec![ratio], vec![vec![1.0]]).unwrap();
    let mut network = Network::new(structure, vec![Reading::motion(0)], vec![0]);
    let contact = Contact { normal: Normal::Constant(1.0), ..on(&rubbing) };
    let settings = Settings { order: 63, samples: 16384, tolerance: 1e-11, iterations: 60 };
    let mut solver = Solver::new(settings).unwrap();
    for force in [0.2, 0.4] {
        network.loads = vec![Load { port: 0, harmonic: 1, amplitude: Complex64::from(force) }];
        let lines = network.lines(omega, 63, 1.0).unwrap();
        let found = solver.solve(&Problem { lines: &lines, contacts: &[contact] }, None).unwrap();
        assert_eq!(found.status, Status::Converged);
        let floquet = solver.floquet(&network, &[contact], (omega, 1.0), &found.forces).unwrap();
        // Two reversals a period: the path is twice the distance between them.
        let motion = lines.motion(0, &found.forces);
        let at = |k: usize| -> f64 {
            let angle = TAU * k as f64 / 4096.0;
            motion.iter().enumerate().map(|(h, x)| (x * Complex64::cis(h as f64 * angle)).re).sum()
        };
        let (low, high) = (0..4096).map(at).fold((f64::MAX, f64::MIN), |(l, h), x| (l.min(x), h.max(x)));
        let path = 2.0 * (high - low);
        let expected = (-2.0 * ratio * TAU / omega - path * rubbing.sigma0 / rubbing.mu_k).exp();
        // The held force at the end of a step follows from the three states: its multipliers are none.
        let product: Complex64 = floquet.multipliers.iter().take(3).product();
        assert!(floquet.stable() && path > rubbing.mu_k / rubbing.sigma0, "{path} {floquet:?}");
        assert!(
            (product.re / expected - 1.0).abs() < 1e-5 && product.im.abs() < 1e-9,
            "{product} {expected}"
        );
        assert!(floquet.multipliers.iter().skip(3).all(|m| m.norm() < 1e-9), "{floquet:?}");
    }
}

/// Friction between two reversals is a constant force (J. P. den Hartog, Trans. ASME 53 (1931) 107). With the
/// damper `c = 2ζω − ε` that keeps the motion periodic, `x = F + (A − F) e^{−ct/2}(cos ω_d t + (c/2ω_d) sin ω_d t)` from `A` to `−A`:
/// the mode has `ω = ω_d = √(1 − c²/4)` and `e^{−cπ/2ω} = (A + F)/(A − F)`.
#[test]
fn a_mode_with_dry_friction() {
    let (limit, ratio) = (0.25, 0.01);
    let structure = Structure::new(vec![1.0], vec![ratio], vec![vec![1.0]]).unwrap();
    let network = Network::new(structure, vec![Reading::motion(0)], vec![0]);
    // Dry but for a spring: it turns while the phase moves by 2√(F/kA) after a reversal, less than a sample.
    let dry = frettrace_forward::hb::ElasticContact {
        normal_stiffness: 0.0,
        preload: limit,
        tangential_stiffness: 1e7,
        friction_coefficient: 1.0,
    };
    // Friction turns a sample late, and while the spring bends: 2π/16384 + 2√(F/kA) = 6e-4 of the phase, times its share
    // 4F/πA = 0.16 of the force of the oscillator's spring.
    let settings = Settings { order: 63, samples: 16384, tolerance: 1e-9, iterations: 40 };
    let modes = Modes { mode: 0, channel: 0, amplitudes: [20.0, 2.0], points: 10 };
    let points = Solver::new(settings).unwrap().follow_mode(&network, &[on(&dry)], &modes).unwrap();
    assert_eq!(points.len(), 10);
    for point in points {
        let (amplitude, damper) = den_hartog(point.amplitude, limit);
        let omega = (1.0 - damper * damper / 4.0).sqrt();
        // ζ_mode = ε/(2ω) with ε = 2ζ − c.
        let damping = (2.0 * ratio - damper) / (2.0 * omega);
        assert!((point.omega / omega - 1.0).abs() < 2e-4, "{amplitude}: {} {omega}", point.omega);
        assert!((point.damping_ratio / damping - 1.0).abs() < 1e-3, "{}: {damping}", point.damping_ratio);
    }
}

/// Amplitude `A` and damper `c` of the motion whose line 1 has the size `first`, by bisection of `A`.
fn den_hartog(first: f64, limit: f64) -> (f64, f64) {
    let (mut low, mut high) = (0.9 * first, 1.5 * first);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if line_one(middle, limit) < first { low = middle } else { high = middle }
    }
    (low, damper(low, limit))
}

/// `c` of `c/(2ω) = −ln((A + F)/(A − F))/π`, `ω² = 1 − c²/4`.
fn damper(amplitude: f64, limit: f64) -> f64 {
    let slope = ((amplitude + limit) / (amplitude - limit)).ln() / PI;
    -2.0 * slope / (1.0 + slope * slope).sqrt()
}

/// Size of line 1 of the motion from `A` to `−A` and back: midpoints of 2000 intervals, 1e-7.
fn line_one(amplitude: f64, limit: f64) -> f64 {
    let c = damper(amplitude, limit);
    let omega = (1.0 - c * c / 4.0).sqrt();
    let count = 2000;
    let sum: Complex64 = (0..count)
        .map(|k| {
            let phase = PI * (f64::from(k) + 0.5) / f64::from(count);
            let (sine, cosine) = phase.sin_cos();
            let free = (-c * phase / (2.0 * omega)).exp() * (cosine + c / (2.0 * omega) * sine);
            Complex64::from_polar(limit + (amplitude - limit) * free, -phase)
        })
        .sum();
    (sum * 2.0 / f64::from(count)).norm()
}
