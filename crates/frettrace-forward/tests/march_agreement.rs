//! Harmonic balance of high order against the time march, which shares nothing with it but modes and law.

#![allow(clippy::unwrap_used, reason = "a helper of tests that fails is a test that fails")]

#[path = "peers/problems.rs"]
#[allow(dead_code)]
mod problems;

use frettrace_beam::{Boundary, Dof, ModalModel, ModalOptions, UniformBeam};
use frettrace_forward::hb::{
    Accuracy, AdaptiveSolver, Contact, Declared, Element, Family, Friction, Lines, Load, Network, Normal,
    Problem, Reading, Settings, Status, Stop,
};
use frettrace_forward::march::{
    Assembly, Characteristic, FrictionContact, LocalLoad, March, Normal as MarchNormal, Port, SettleOptions,
    Settling, Structure, settle,
};
use frettrace_friction::laws::{Dahl, Jenkins};
use frettrace_friction::{Bristle, FrictionLaw, FrictionModel, Law, Scalar};
use num_complex::Complex64;
use problems::rms;

/// The Jenkins element of the catalogue, its reversals found between samples.
struct Slider {
    stiffness: f64,
    limit: f64,
}

impl Family for Slider {
    type Law<T: Scalar> = Friction<Jenkins<T>>;

    fn parameters(&self) -> &[f64] {
        &[]
    }

    fn law<T: Scalar>(&self, _: &[T]) -> Self::Law<T> {
        Friction(Jenkins { tangential_stiffness: self.stiffness.into(), mu_k: self.limit.into() })
    }
}

/// Root mean square of a channel by harmonic balance of an order that truncates nothing above 1e-8 if it can.
fn balance(network: &Network, contact: Contact, omega: f64, channel: usize) -> f64 {
    let (lines, forces) = balanced(network, &[contact], omega);
    rms(&lines.motion(channel, &forces), false)
}

/// Lines of a network and the forces of its contacts, one contact after the other.
fn balanced(network: &Network, contacts: &[Contact], omega: f64) -> (Lines, Vec<Complex64>) {
    let accuracy = Accuracy {
        truncation: 1e-8,
        sampling: 1e-7,
        orders: [31, 255],
        samples: 8192,
        ..Accuracy::default()
    };
    let settings = Settings { tolerance: 1e-10, ..Settings::default() };
    let lines = network.lines(omega, 511, 1.0).unwrap();
    let problem = Problem { lines: &lines, contacts };
    let adapted = AdaptiveSolver::new(accuracy, settings).solve(&problem, None).unwrap();
    assert_eq!(adapted.solution.status, Status::Converged);
    (lines, adapted.solution.forces)
}

/// Root mean square of a port over the settled period, mean left out.
fn marched<L: FrictionLaw<f64>>(
    assembly: &Assembly<L>,
    loads: &[(f64, f64)],
    omega: f64,
    port: usize,
) -> f64 {
    let options = SettleOptions {
        steps_per_period: 8192,
        tolerance: 1e-8,
        ..SettleOptions::new(std::f64::consts::TAU / omega)
    };
    let known = |time: f64, out: &mut [f64]| {
        for (slot, (steady, amplitude)) in out.iter_mut().zip(loads) {
            *slot = steady + amplitude * (omega * time).cos();
        }
    };
    let mut march = March::new(assembly, options.period / options.steps_per_period as f64);
    let settled = settle(&mut march, &options, known);
    assert!(matches!(settled, Settling::Periodic { multiple: 1, .. }), "{settled:?}");
    let (start, dt) = (march.time(), options.period / options.steps_per_period as f64);
    let mut values = vec![0.0; loads.len()];
    let samples: Vec<f64> = (1..=options.steps_per_period)
        .map(|k| {
            known(start + k as f64 * dt, &mut values);
            march.step(&values);
            march.displacement(port)
        })
        .collect();
    let mean = samples.iter().sum::<f64>() / samples.len() as f64;
    (samples.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / samples.len() as f64).sqrt()
}

fn agree(name: &str, one: f64, other: f64) {
    // The march's hold errs by (ωΔt)²/12 = 5e-8 on line 1 and by as much more on the small lines above.
    assert!((one / other - 1.0).abs() < 1e-6, "{name}: {one:e} {other:e} {:e}", one / other - 1.0);
}

#[test]
fn jenkins_beams() {
    for (name, peer, [stiffness, limit, force], omegas) in [
        ("P2", problems::p2(), [1.3e6, 1.0, 0.2], [343.0, 330.0]),
        ("P3", problems::p3(), [1e8, 106.0, 20.0], [488.0, 600.0]),
    ] {
        let element = Slider { stiffness, limit };
        for omega in omegas {
            let normal = Normal::Constant(1.0);
            let contact = Contact { slip: 0, normal, force: 0, normal_force: None, element: &element };
            let found = balance(&peer.network, contact, omega, 1);
            let dashpot = Characteristic::Dashpot(peer.network.supports[0].damping);
            let law = Jenkins { tangential_stiffness: stiffness, mu_k: limit };
            let assembly = Assembly {
                structure: peer.network.structure.clone(),
                inputs: vec![1],
                friction: Some(FrictionContact { law, slip_port: 0, normal: MarchNormal::constant(1.0) }),
                loads: vec![LocalLoad { port: 0, characteristic: dashpot }],
            };
            agree(name, found, marched(&assembly, &[(0.0, force)], omega, 1));
        }
    }
}

/// P1, whose friction has no memory: tanh of the velocity.
#[test]
fn smooth_coulomb_beam() {
    let peer = problems::p1();
    let friction = Characteristic::SmoothCoulomb { level: 1.5, velocity: 6e-7 };
    for omega in [195.0, 230.0] {
        let found = balance(&peer.network, peer.contact(), omega, 1);
        let assembly: Assembly<Jenkins<f64>> = Assembly {
            structure: peer.network.structure.clone(),
            inputs: vec![1],
            friction: None,
            loads: vec![LocalLoad { port: 0, characteristic: friction }],
        };
        agree("P1", found, marched(&assembly, &[(0.0, 0.2)], omega, 1));
    }
}

struct Bristles(Dahl<f64>);

impl Family for Bristles {
    type Law<T: Scalar> = Friction<Bristle<T>>;

    fn parameters(&self) -> &[f64] {
        &[]
    }

    fn law<T: Scalar>(&self, _: &[T]) -> Self::Law<T> {
        let Dahl { sigma0, mu_k, exponent } = self.0;
        Friction(Dahl { sigma0: sigma0.into(), mu_k: mu_k.into(), exponent: exponent.into() }.bristle())
    }
}

/// A beam on its friction support as laboratories build it: residual flexibility, a normal force that varies with the motion,
/// Dahl's law; mostly presliding (0.6 N) and mostly sliding (6 N).
#[test]
fn beam_on_its_friction_support() {
    let (length, spring, preload) = (0.52, 4e6, 65.0);
    let beam = UniformBeam::rectangular(length, [0.03, 0.007], 2.05e11, 7840.0);
    let options = ModalOptions { modes: 30, damping_ratio: vec![0.005], ..ModalOptions::default() };
    let model = ModalModel::new(&beam, &Boundary::spring(spring), &options).unwrap();
    let displacement = |x| Port { dof: Dof::displacement(x), factor: 1.0 };
    let slip = Port { dof: Dof::rotation(length), factor: 0.0035 };
    let ports = [displacement(0.212), slip, displacement(length), displacement(0.337)];
    let structure = Structure::from_beam(&model, &ports).unwrap();
    let law = Dahl { sigma0: 4.2e5, mu_k: 0.24, exponent: 1.0 };
    let channels =
        vec![Reading::motion(1), Reading { port: 2, scale: -spring, offset: preload }, Reading::motion(3)];
    let element = Bristles(law);
    let contact =
        Contact { slip: 0, normal: Normal::Channel(1), force: 0, normal_force: None, element: &element };
    for force in [0.6, 6.0] {
        let omega = std::f64::consts::TAU * 93.7;
        let mut network = Network::new(structure.clone(), channels.clone(), vec![1]);
        network.loads.push(Load { port: 0, harmonic: 1, amplitude: force.into() });
        let found = balance(&network, contact, omega, 2);
        let normal = MarchNormal { port: Some(2), stiffness: spring, ..MarchNormal::constant(preload) };
        let assembly = Assembly {
            structure: structure.clone(),
            inputs: vec![0],
            friction: Some(FrictionContact { law, slip_port: 1, normal }),
            loads: Vec::new(),
        };
        agree("beam", found, marched(&assembly, &[(0.0, force)], omega, 3));
    }
}

/// Rigs declared as the practice sets are, with rounded dimensions of our own: a steel beam whose face turns over its support
/// (slip by rotation, the normal force follows the motion) or whose end slides sideways (a free end, constant normal force), five
/// or six damping ratios about 0.6 %, driven at 1.005 times its first frequency or between the first two.
#[test]
fn rigs_declared_as_in_practice() {
    let lugre = [5.0e5, 15.0, 3.0e-3, 0.0, 0.41, 0.28, 2.4e-3, 2.0];
    let hybrid = [&lugre[..], &[0.35]].concat();
    let dahl = [3.2e4, 0.276, 1.0];
    let sideways =
        Rig { length: 0.544, section: [0.0245, 0.0055], support: None, preload: 7.45, hertz: 64.9 };
    let turning =
        Rig { length: 0.498, section: [0.0317, 0.0075], support: Some(5.3e6), preload: 75.0, hertz: 107.8 };
    for (name, rig, law, values, forces) in [
        ("hybrid", turning, Law::Hybrid, &hybrid[..], [1.0, 6.0]),
        ("lugre", turning, Law::Lugre, &lugre[..], [1.0, 6.0]),
        ("sideways", sideways, Law::Dahl, &dahl[..], [0.4, 2.0]),
    ] {
        let law: FrictionModel = law.with_values(values).unwrap();
        for force in forces {
            let [found, expected] = rig.both(law, force);
            agree(&format!("{name} {force} N"), found, expected);
        }
    }
}

/// A beam with its contact at the end; with a support spring (N/m) the slip is that of its face, else the end's own.
#[derive(Clone, Copy)]
struct Rig {
    length: f64,
    section: [f64; 2],
    support: Option<f64>,
    preload: f64,
    hertz: f64,
}

impl Rig {
    /// Root mean square at two thirds of the length, by balance and by march.
    fn both(&self, law: FrictionModel, force: f64) -> [f64; 2] {
        let beam = UniformBeam::rectangular(self.length, self.section, 2.0e11, 7850.0);
        let damping_ratio = vec![0.0069, 0.0066, 0.0065, 0.0069, 0.0054, 0.0066];
        let options = ModalOptions { modes: 30, damping_ratio, ..ModalOptions::default() };
        let boundary = self.support.map_or_else(Boundary::cantilever, Boundary::spring);
        let model = ModalModel::new(&beam, &boundary, &options).unwrap();
        let displacement = |x| Port { dof: Dof::displacement(x), factor: 1.0 };
        let slip = match self.support {
            Some(_) => Port { dof: Dof::rotation(self.length), factor: 0.5 * self.section[1] },
            None => displacement(self.length),
        };
        let [exciter, end] = [displacement(0.466 * self.length), displacement(self.length)];
        let ports = [exciter, slip, end, displacement(self.length * 2.0 / 3.0)];
        let structure = Structure::from_beam(&model, &ports).unwrap();
        let spring = self.support.unwrap_or(0.0);
        let pressed = Reading { port: 2, scale: -spring, offset: self.preload };
        let channels = vec![Reading::motion(1), pressed, Reading::motion(3)];
        let mut network = Network::new(structure.clone(), channels, vec![1]);
        network.loads.push(Load { port: 0, harmonic: 1, amplitude: force.into() });
        let element = Declared(law);
        let contact =
            Contact { slip: 0, normal: Normal::Channel(1), force: 0, normal_force: None, element: &element };
        let omega = std::f64::consts::TAU * self.hertz;
        let found = balance(&network, contact, omega, 2);
        let normal = MarchNormal { port: Some(2), stiffness: spring, ..MarchNormal::constant(self.preload) };
        let friction = Some(FrictionContact { law, slip_port: 1, normal });
        let assembly = Assembly { structure, inputs: vec![0], friction, loads: Vec::new() };
        [found, marched(&assembly, &[(0.0, force)], omega, 3)]
    }
}

/// Two contacts of two kinds: the end of a cantilever rubs by Dahl's law, its middle hits a stop on either side of a clearance. The
/// march has the stop as two, one against the motion turned round.
#[test]
fn friction_and_a_stop_on_either_side() {
    let length = 0.5;
    let beam = UniformBeam::rectangular(length, [0.03, 0.006], 2.0e11, 7850.0);
    let options = ModalOptions { modes: 12, damping_ratio: vec![0.02], ..ModalOptions::default() };
    let model = ModalModel::new(&beam, &Boundary::cantilever(), &options).unwrap();
    let port = |share: f64, factor| Port { dof: Dof::displacement(share * length), factor };
    let ports = [port(0.4, 1.0), port(1.0, 1.0), port(0.5, 1.0), port(0.5, -1.0), port(0.7, 1.0)];
    let structure = Structure::from_beam(&model, &ports).unwrap();
    let (preload, force, omega) = (0.5, 2.0, std::f64::consts::TAU * 22.0);
    let law = Dahl { sigma0: 2e4, mu_k: 0.3, exponent: 1.0 };
    let stop = Stop { stiffness: 1e4, damping: 0.0, clearance: 5e-5, two_sided: true };

    let channels = vec![Reading::motion(1), Reading::motion(2), Reading::motion(4)];
    let mut network = Network::new(structure.clone(), channels, vec![1, 2]);
    network.loads.push(Load { port: 0, harmonic: 1, amplitude: force.into() });
    let rubbing = Bristles(law);
    let normal = Normal::Constant(preload);
    let contacts = [
        Contact { slip: 0, normal, force: 0, normal_force: None, element: &rubbing },
        Contact { slip: 1, normal: Normal::Constant(0.0), force: 1, normal_force: None, element: &stop },
    ];
    let (lines, forces) = balanced(&network, &contacts, omega);
    let (friction, blow) = forces.split_at(forces.len() / 2);
    assert!(friction[1].norm() > 0.1 * preload * law.mu_k, "the end does not rub: {}", friction[1]);
    assert!(
        blow[3].norm() > 0.05 * blow[1].norm(),
        "the stop is not left and touched: {} {}",
        blow[1],
        blow[3]
    );

    let blow = |port| LocalLoad {
        port,
        characteristic: Characteristic::Stop { stiffness: stop.stiffness, gap: stop.clearance },
    };
    let assembly = Assembly {
        structure,
        inputs: vec![0],
        friction: Some(FrictionContact { law, slip_port: 1, normal: MarchNormal::constant(preload) }),
        loads: vec![blow(2), blow(3)],
    };
    let found = rms(&lines.motion(2, &forces), false);
    agree("two contacts", found, marched(&assembly, &[(0.0, force)], omega, 4));
}

/// The march keeps the linear spring of the normal contact in the structure, and reads `w = −n`.
#[test]
fn normal_and_tangential() {
    let peer = problems::p4();
    for omega in [2.0, 3.6] {
        let found = balance(&peer.network, peer.contact(), omega, 0);
        let frequency = vec![12.0_f64.sqrt(), 42.0_f64.sqrt()];
        let damping = vec![0.05, 1.0 / frequency[1]];
        let rows = vec![vec![1.0, 0.0], vec![0.0, 1.0], vec![0.0, -1.0]];
        let normal =
            MarchNormal { port: Some(2), stiffness: 21.0, lifts_off: true, ..MarchNormal::constant(0.0) };
        let law = Jenkins { tangential_stiffness: 5.0, mu_k: 0.85 };
        let assembly = Assembly {
            structure: Structure::new(frequency, damping, rows).unwrap(),
            inputs: vec![0, 1],
            friction: Some(FrictionContact { law, slip_port: 0, normal }),
            loads: Vec::new(),
        };
        agree("P4", found, marched(&assembly, &[(0.0, 100.0), (100.0, 10.0)], omega, 0));
    }
}

/// A solver that must have another order is not the same solver: what is reported is what was used.
#[test]
fn order_rises_with_the_accuracy_asked() {
    let peer = problems::p3();
    let element: &dyn Element = peer.element.as_ref();
    let contact = Contact { element, ..peer.contact() };
    let lines = peer.network.lines(480.0, 255, 1.0).unwrap();
    let contacts = [contact];
    let problem = Problem { lines: &lines, contacts: &contacts };
    let solve = |truncation| {
        let accuracy = Accuracy { truncation, sampling: 1e-2, orders: [7, 127], ..Accuracy::default() };
        AdaptiveSolver::new(accuracy, Settings::default()).solve(&problem, None).unwrap()
    };
    let (coarse, fine) = (solve(3e-2), solve(1e-5));
    let tip =
        |adapted: &frettrace_forward::hb::Adapted| rms(&lines.motion(1, &adapted.solution.forces), false);
    assert!(coarse.settings.order < fine.settings.order);
    assert!(fine.solution.truncation <= 1e-5 && coarse.solution.truncation > fine.solution.truncation);
    // Time march of the third code at 480 rad/s: 3.96171994e-5 m; order 7 is 2.7 % away.
    assert!((tip(&fine) / 3.961_719_94e-5 - 1.0).abs() < 1e-4, "{:e}", tip(&fine));
}
