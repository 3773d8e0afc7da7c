use std::f64::consts::TAU;

use frettrace_beam::{Boundary, Dof, ModalModel, ModalOptions, Receptance, UniformBeam};
use frettrace_friction::effects::{Circumstance, ModifiedLaw, ModifiedState};
use frettrace_friction::laws::Coulomb;
use frettrace_friction::{FrictionLaw, Step};

use super::*;

/// Rigid Coulomb friction, set-valued at rest: the solver finds the jump.
#[derive(Clone, Copy, Debug)]
struct Rigid {
    level: f64,
}

impl FrictionLaw<f64> for Rigid {
    type State = [f64; 1];

    fn rest(&self) -> [f64; 1] {
        [0.0]
    }

    fn step(&self, state: [f64; 1], step: &Step<f64>) -> ([f64; 1], f64) {
        (state, self.level * step.velocity[1].signum())
    }
}

/// Dahl's law in the oracle of the effects' crate.
#[derive(Clone, Copy)]
struct Dahl(ModifiedLaw<f64>);

impl FrictionLaw<f64> for Dahl {
    type State = ModifiedState<f64>;

    fn rest(&self) -> ModifiedState<f64> {
        self.0.rest_at(0.0)
    }

    fn step(&self, state: ModifiedState<f64>, step: &Step<f64>) -> (ModifiedState<f64>, f64) {
        self.0.advance(state, step, &Circumstance::default())
    }
}

/// One oscillator of unit mass and stiffness: port 0.
fn oscillator<L>(damping: f64, law: L) -> Assembly<L> {
    Assembly {
        structure: Structure::new(vec![1.0], vec![damping], vec![vec![1.0]]).unwrap(),
        inputs: vec![0],
        friction: Some(FrictionContact { law, slip_port: 0, normal: Normal::constant(1.0) }),
        loads: Vec::new(),
    }
}

/// Largest displacement over the steady period, between samples by the cubic through displacements and velocities.
fn amplitude<L: FrictionLaw<f64>>(assembly: &Assembly<L>, ratio: f64, (share, tolerance): (f64, f64)) -> f64 {
    const STEPS: usize = 4096;
    let period = TAU / ratio;
    let options = SettleOptions { steps_per_period: STEPS, tolerance, ..SettleOptions::new(period) };
    let mut march = March::new(assembly, 1.0);
    march.set_refinement(share);
    // A straight line between the steps loses (sin x/x)² of the excitation, x = ωΔt/2.
    let x = TAU / 2.0 / STEPS as f64;
    let force = |time: f64, loads: &mut [f64]| loads[0] = (x / x.sin()).powi(2) * (ratio * time).cos();
    let settled = settle(&mut march, &options, force);
    assert!(matches!(settled, Settling::Periodic { multiple: 1, .. }), "{ratio}: {settled:?}");
    let (start, dt) = (march.time(), period / STEPS as f64);
    let (mut loads, mut largest) = ([0.0], 0.0_f64);
    for k in 1..=STEPS {
        let before = march.moment();
        force(start + k as f64 * dt, &mut loads);
        march.step(&loads);
        let after = march.moment();
        largest = largest.max(after.slip);
        if before.velocity > 0.0 && after.velocity < 0.0 {
            let (slip, velocity) = ([before.slip, after.slip], [before.velocity, after.velocity]);
            let step = Step { slip, velocity, normal: [1.0; 2], dt };
            largest = largest.max(step.at(before.velocity / (before.velocity - after.velocity)).0);
        }
    }
    largest
}

/// Den Hartog's amplitudes with damping, and stick-slip rows without it found by an event search, both from independent
/// computations to eight decimals. (Undamped motion without stops is neutrally stable: a march keeps any beat it starts with.)
const DEN_HARTOG: [(f64, f64, f64, f64); 23] = [
    (0.1, 0.6, 0.1, 1.493_703_00),
    (0.1, 0.6, 0.3, 1.393_261_34),
    (0.1, 0.9, 0.1, 3.472_695_86),
    (0.1, 0.9, 0.3, 2.697_647_30),
    (0.1, 0.9, 0.5, 1.808_622_93),
    (0.1, 1.0, 0.1, 4.362_820_53),
    (0.1, 1.0, 0.3, 3.087_857_48),
    (0.1, 1.0, 0.5, 1.812_088_58),
    (0.1, 1.2, 0.1, 1.858_270_59),
    (0.1, 1.2, 0.3, 1.489_682_86),
    (0.1, 1.2, 0.5, 0.966_934_45),
    (0.1, 2.0, 0.1, 0.321_108_52),
    (0.1, 2.0, 0.3, 0.278_701_17),
    (0.1, 2.0, 0.5, 0.192_232_42),
    (0.0, 0.25, 0.2, 0.993_224_79),
    (0.0, 0.25, 0.5, 0.691_464_06),
    (0.0, 0.4, 0.3, 1.127_623_77),
    (0.0, 0.4, 0.5, 1.079_074_07),
    (0.0, 0.4, 0.7, 0.949_567_36),
    (0.0, 0.6, 0.7, 1.351_930_93),
    (0.0, 0.8, 0.9, 0.068_345_38),
    (0.0, 1.2, 0.8, 0.114_364_52),
    (0.0, 2.0, 0.7, 0.070_099_69),
];

/// A contact that is held is exact to the digits of the table: half a unit of the last one, and 3e-8 of a jump inside a step.
#[test]
fn den_hartog_held() {
    for (damping, ratio, level, expected) in DEN_HARTOG {
        let found = amplitude(&oscillator(damping, Coulomb { mu_k: level }), ratio, (1e-9, 1e-10));
        let allowed = 5e-9 + 3e-8 * expected;
        assert!((found - expected).abs() < allowed, "ζ {damping} r {ratio} β {level}: {found} {expected}");
    }
}

/// The oracle of holding: a force that only jumps, found by halving brackets, anywhere inside the shortest step.
#[test]
fn den_hartog_jumping() {
    for (damping, ratio, level, expected) in DEN_HARTOG.into_iter().skip(1).step_by(3) {
        let found = amplitude(&oscillator(damping, Rigid { level }), ratio, (2e-4, 1e-5));
        assert!((found / expected - 1.0).abs() < 3e-4, "ζ {damping} r {ratio} β {level}: {found} {expected}");
    }
}

/// With a linear load the march is the receptance: static residual and damping included.
#[test]
fn the_beam_without_friction_answers_with_its_receptance() {
    let beam = UniformBeam { length: 1.0, bending_stiffness: 1.0, mass_per_length: 1.0 };
    let options = ModalOptions { modes: 40, damping_ratio: vec![0.02], ..ModalOptions::default() };
    let model = ModalModel::new(&beam, &Boundary::spring(500.0), &options).unwrap();
    let ports =
        [Port { dof: Dof::displacement(0.4), factor: 1.0 }, Port { dof: Dof::rotation(1.0), factor: 0.01 }];
    let assembly: Assembly<Rigid> = Assembly {
        structure: Structure::from_beam(&model, &ports).unwrap(),
        inputs: vec![0],
        friction: None,
        loads: vec![LocalLoad { port: 1, characteristic: Characteristic::Dashpot(30.0) }],
    };
    let omega = 13.0;
    let mut march = March::new(&assembly, 1.0);
    let settle_options = SettleOptions { steps_per_period: 8192, ..SettleOptions::new(TAU / omega) };
    let settled = settle(&mut march, &settle_options, |time, loads| loads[0] = (omega * time).cos());
    assert!(matches!(settled, Settling::Periodic { .. }), "{settled:?}");
    let dashpot = frettrace_beam::Attachment {
        dof: ports[1].dof,
        element: frettrace_beam::Element::Dashpot(30.0 * ports[1].factor.powi(2)),
    };
    let modified = frettrace_beam::Modified { base: model, attachments: vec![dashpot] };
    // At a multiple of the period the cosine response is the real part.
    for port in 0..2 {
        let expected = modified.receptance(ports[port].dof, ports[0].dof, omega).re * ports[port].factor;
        let found = march.displacement(port);
        // (ΩΔt)²/12 = 5e-8 amplified near the resonance; the residual modes' inertia (13/2e4)².
        assert!((found / expected - 1.0).abs() < 3e-6, "{port}: {found} {expected}");
    }
}

/// Energy put in by the force is what friction and damping take out, for a beam with a bristle contact.
#[test]
fn energy_over_a_settled_period_balances() {
    let beam = UniformBeam::rectangular(0.5, [0.03, 0.007], 2.0e11, 7850.0);
    let model = ModalModel::new(
        &beam,
        &Boundary::spring(5e6),
        &ModalOptions { modes: 72, damping_ratio: vec![0.005], ..ModalOptions::default() },
    )
    .unwrap();
    let arm = 0.0035;
    let ports = [
        Port { dof: Dof::displacement(0.2), factor: 1.0 },
        Port { dof: Dof::rotation(0.5), factor: arm },
        Port { dof: Dof::displacement(0.5), factor: 1.0 },
    ];
    let normal = Normal { port: Some(2), stiffness: 5e6, lifts_off: true, ..Normal::constant(60.0) };
    let assembly = Assembly {
        structure: Structure::from_beam(&model, &ports).unwrap(),
        inputs: vec![0],
        friction: Some(FrictionContact { law: Dahl(ModifiedLaw::dahl(4e5, 0.25)), slip_port: 1, normal }),
        loads: Vec::new(),
    };
    let omega = TAU * 105.0;
    let mut march = March::new(&assembly, 1.0);
    let options = SettleOptions { steps_per_period: 1024, ..SettleOptions::new(TAU / omega) };
    let force = |time: f64| 3.0 * (omega * time).sin();
    let settled = settle(&mut march, &options, |time, loads| loads[0] = force(time));
    assert!(matches!(settled, Settling::Periodic { multiple: 1, .. }), "{settled:?}");
    let (mut supplied, mut rubbed, mut damped) = (0.0, 0.0, 0.0);
    let dt = options.period / 1024.0;
    for _ in 0..1024 {
        let before = (march.moment(), march.displacement(0), march.modal_state().map(<[f64]>::to_vec));
        let old = force(march.time());
        march.step(&[force(march.time() + dt)]);
        let after = march.moment();
        supplied += 0.5 * (old + force(march.time())) * (march.displacement(0) - before.1);
        rubbed += 0.5 * (before.0.friction + after.friction) * (after.slip - before.0.slip);
        let rates = march.modal_state()[1].iter().zip(&before.2[1]).enumerate();
        damped += rates
            .map(|(n, (new, old))| {
                let s = &assembly.structure;
                2.0 * s.damping_ratio()[n] * s.natural_frequency()[n] * 0.5 * (new * new + old * old) * dt
            })
            .sum::<f64>();
    }
    assert!(rubbed > 0.05 * supplied, "friction takes part: {rubbed} of {supplied}");
    // Trapezoids of 1024 samples: (2π/1024)²/12·… of the harmonics of the force, 1e-5 to 1e-4.
    assert!((supplied - rubbed - damped).abs() < 2e-4 * supplied, "{supplied} {rubbed} {damped}");
}

/// A stop that is always pressed is a spring, one out of reach is nothing; a spring by load equals one in the boundary.
#[test]
fn local_loads() {
    let response = |loads: Vec<LocalLoad>, frequency: f64| {
        let assembly: Assembly<Rigid> = Assembly {
            structure: Structure::new(vec![frequency], vec![0.05], vec![vec![1.0]]).unwrap(),
            inputs: vec![0],
            friction: None,
            loads,
        };
        let mut march = March::new(&assembly, 1.0);
        settle(&mut march, &SettleOptions::new(TAU / 1.3), |time, loads| loads[0] = (1.3 * time).cos());
        march.displacement(0)
    };
    let load = |characteristic| vec![LocalLoad { port: 0, characteristic }];
    let plain = response(Vec::new(), 1.0);
    let far = response(load(Characteristic::Stop { stiffness: 5.0, gap: 100.0 }), 1.0);
    assert!((plain - far).abs() < 1e-12);
    // ω² = 3 by a spring of 2; the damping ratio 0.05 becomes 0.05/√3, checked with the closed form.
    let sprung = response(load(Characteristic::Spring(2.0)), 1.0);
    let denominator = num_complex::Complex64::new(3.0 - 1.69, 2.0 * 0.05 * 1.3);
    let expected = denominator.inv().re;
    // (ΩΔt)²/12 of the hold at 2048 steps, 8e-7, on both the excitation and the spring's force.
    assert!((sprung / expected - 1.0).abs() < 1e-5, "{sprung} {expected}");
    let opposed = response(load(Characteristic::CubicSpring(0.1)), 1.0);
    assert!(
        opposed.abs() > plain.abs(),
        "a hardening spring brings the resonance nearer to 1.3: {opposed} {plain}"
    );
}

/// A mass added to the modes equals the mass added to the receptance.
#[test]
fn an_added_mass() {
    let beam = UniformBeam { length: 1.0, bending_stiffness: 1.0, mass_per_length: 1.0 };
    let options = ModalOptions { modes: 60, ..ModalOptions::default() };
    let model = ModalModel::new(&beam, &Boundary::cantilever(), &options).unwrap();
    let place = Dof::displacement(0.7);
    let mut structure = Structure::from_beam(&model, &[Port { dof: place, factor: 1.0 }]).unwrap();
    structure.add_mass(0, 0.3).unwrap();
    let attachment = frettrace_beam::Attachment { dof: place, element: frettrace_beam::Element::Mass(0.3) };
    let modified = frettrace_beam::Modified { base: model, attachments: vec![attachment] };
    for omega in [1.0, 9.0, 31.0] {
        let sum: f64 = (0..structure.mode_count())
            .map(|n| structure.row(0)[n].powi(2) / (structure.natural_frequency()[n].powi(2) - omega * omega))
            .sum();
        let expected = modified.receptance(place, place, omega).re;
        // The residual mode's inertia: (ω/ω_r)², ω_r = 5e4.
        assert!((sum / expected - 1.0).abs() < 1e-6, "{omega}: {sum} {expected}");
    }
}

/// A base that accelerates steadily loads the beam by its own weight: tip deflection ρA a L⁴/(8EI).
#[test]
fn a_steady_acceleration_of_the_base_is_a_uniform_load() {
    let beam = UniformBeam { length: 1.0, bending_stiffness: 1.0, mass_per_length: 1.0 };
    let model = ModalModel::new(&beam, &Boundary::cantilever(), &ModalOptions::default()).unwrap();
    let mut structure =
        Structure::from_beam(&model, &[Port { dof: Dof::displacement(1.0), factor: 1.0 }]).unwrap();
    let base = structure.add_base(&model);
    let tip: f64 = (0..structure.mode_count())
        .map(|n| structure.row(0)[n] * structure.row(base)[n] / structure.natural_frequency()[n].powi(2))
        .sum();
    assert!((tip + 0.125).abs() < 1e-9, "{tip}");
}

/// Two periods of the excitation in one of the motion: a stop struck every other period.
#[test]
fn a_subharmonic_is_recognised() {
    // The response to cos 2.2t of an oscillator that rests on a stop answers at half the excitation frequency.
    let assembly: Assembly<Rigid> = Assembly {
        structure: Structure::new(vec![0.35], vec![0.05], vec![vec![1.0]]).unwrap(),
        inputs: vec![0],
        friction: None,
        loads: vec![LocalLoad {
            port: 0,
            characteristic: Characteristic::Stop { stiffness: 30.0, gap: 0.0 },
        }],
    };
    let mut march = March::new(&assembly, 1.0);
    let mut multiples = Vec::new();
    for omega in [0.9, 1.1, 1.3, 1.4, 1.5] {
        let settled = settle(&mut march, &SettleOptions::new(TAU / omega), |time, loads| {
            loads[0] = (omega * time).cos()
        });
        if let Settling::Periodic { multiple, .. } = settled {
            multiples.push(multiple);
        }
    }
    // Half-sine flights of a bilinear oscillator repeat after whole numbers of periods; at least one is not the first.
    assert!(multiples.iter().any(|&m| m > 1), "{multiples:?}");
}
