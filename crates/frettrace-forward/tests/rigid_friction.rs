//! Rigid friction on a beam, set-valued at rest: the march that holds what sticks and halves steps against one of eight times the steps that
//! does neither, and against the harmonic balance with the friction force held as long as the contact sticks.

#![allow(clippy::unwrap_used, reason = "a test")]

use std::f64::consts::TAU;

use frettrace_beam::{Boundary, Dof, ModalModel, ModalOptions, UniformBeam};
use frettrace_forward::accelerations::{AccelerationModel, Rig, RunLines, Setting};
use frettrace_forward::march::{
    Assembly, FrictionContact, March, Normal, Port, SettleOptions, Settling, Structure, settle,
};
use frettrace_friction::effects::ModifiedLaw;
use frettrace_friction::laws::Coulomb;
use frettrace_friction::{FrictionLaw, Step};
use num_complex::Complex64;

const OMEGA: f64 = TAU * 105.0;
const ARM: f64 = 0.0035;
const SPRING: f64 = 5e6;
const PRELOAD: f64 = 60.0;
const MU: f64 = 0.25;
const DAMPING: f64 = 0.01;
/// Modes of the balance, which has the static flexibility of all others as it is, …
const MODES: usize = 40;
/// … and of a march in which modes far above the last one, damped, stand for it.
const MANY: usize = 160;
const EXCITER: f64 = 0.2;
const SENSOR: f64 = 0.33;
/// Lines compared, up to 4.3 kHz.
const LINES: usize = 40;

fn beam() -> UniformBeam {
    UniformBeam::rectangular(0.5, [0.03, 0.007], 2.0e11, 7850.0)
}

fn model(modes: usize) -> ModalModel {
    let options = ModalOptions { modes, damping_ratio: vec![DAMPING], ..ModalOptions::default() };
    ModalModel::new(&beam(), &Boundary::spring(SPRING), &options).unwrap()
}

/// Coulomb friction that only jumps: the march looks for the jump by halving brackets and knows nothing of holding.
#[derive(Clone, Copy)]
struct Jumping(Coulomb<f64>);

impl FrictionLaw<f64> for Jumping {
    type State = [f64; 0];

    fn rest(&self) -> [f64; 0] {
        []
    }

    fn step(&self, state: [f64; 0], step: &Step<f64>) -> ([f64; 0], f64) {
        self.0.step(state, step)
    }
}

fn assembly<L>(law: L, modes: usize) -> Assembly<L> {
    let displacement = |x| Port { dof: Dof::displacement(x), factor: 1.0 };
    let slip = Port { dof: Dof::rotation(0.5), factor: ARM };
    let ports = [displacement(EXCITER), slip, displacement(0.5), displacement(SENSOR)];
    let normal = Normal { port: Some(2), stiffness: SPRING, ..Normal::constant(PRELOAD) };
    Assembly {
        structure: Structure::from_beam(&model(modes), &ports).unwrap(),
        inputs: vec![0],
        friction: Some(FrictionContact { law, slip_port: 1, normal }),
        loads: Vec::new(),
    }
}

/// Lines of the sensor's acceleration over the settled period, and the steps that this period took.
fn marched<L: FrictionLaw<f64>>(
    (law, modes): (L, usize),
    force: f64,
    (steps, share): (usize, f64),
) -> (Vec<Complex64>, usize) {
    let assembly = assembly(law, modes);
    let mut march = March::new(&assembly, 1.0);
    march.set_refinement(share);
    let period = TAU / OMEGA;
    let options = SettleOptions { steps_per_period: steps, tolerance: 1e-9, ..SettleOptions::new(period) };
    // A straight line between the steps loses (sin x/x)² of the excitation, x = ωΔt/2.
    let x = TAU / 2.0 / steps as f64;
    let known = |time: f64, loads: &mut [f64]| {
        loads[0] = force * (x / x.sin()).powi(2) * (OMEGA * time).cos();
    };
    let settled = settle(&mut march, &options, known);
    assert!(matches!(settled, Settling::Periodic { multiple: 1, .. }), "{force}: {settled:?}");
    let (start, before) = (march.time(), march.step_count());
    let (mut loads, mut lines) = ([0.0], vec![Complex64::ZERO; LINES + 1]);
    for k in 1..=steps {
        let time = start + k as f64 * period / steps as f64;
        known(time, &mut loads);
        march.step(&loads);
        march.set_time(time);
        for (h, line) in lines.iter_mut().enumerate() {
            let scale = -2.0 / steps as f64 * (h as f64 * OMEGA).powi(2);
            *line += Complex64::cis(-TAU * (h * k) as f64 / steps as f64) * march.displacement(3) * scale;
        }
    }
    (lines, march.step_count() - before)
}

/// The same lines by harmonic balance.
fn balanced(force: f64, order: usize) -> Vec<Complex64> {
    let rig = Rig {
        beam: beam(),
        boundary: Boundary::spring(SPRING),
        exciter: EXCITER,
        sensors: vec![SENSOR],
        lever: Some(ARM),
        known_support: None,
        modes: MODES,
    };
    let mut force_lines = vec![Complex64::ZERO; LINES + 1];
    force_lines[1] = force.into();
    let lines = RunLines {
        omega: OMEGA,
        preload: PRELOAD,
        progress: 0.0,
        worked: [0.0; 2],
        force: force_lines,
        acceleration: vec![vec![Complex64::ZERO; LINES + 1]],
        deviation: vec![vec![1e-6 * force; LINES + 1]],
        base_phase: 0.0,
        known_force: Vec::new(),
        contact_order: order,
        samples: 16 * (order + 1),
    };
    // Its stiffness is not used: the contact is rigid.
    let law = ModifiedLaw::dahl(1e6, MU);
    let frequency = model(MODES).natural_frequency().to_vec();
    let setting = Setting { rigid: true, ..Setting::new(frequency, vec![DAMPING; MODES], law, 1) };
    let model = AccelerationModel::new(rig, vec![lines]).unwrap();
    model.predict(&setting, &[0], &mut model.memory()).unwrap().swap_remove(0).swap_remove(0)
}

/// Root mean square of the difference of the lines over that of the second.
fn apart(a: &[Complex64], b: &[Complex64]) -> f64 {
    let square = |lines: &mut dyn Iterator<Item = Complex64>| lines.map(|x| x.norm_sqr()).sum::<f64>();
    let difference = square(&mut a.iter().zip(b).skip(1).map(|(a, b)| a - b));
    (difference / square(&mut b.iter().skip(1).copied())).sqrt()
}

/// Stick and slip (6 N) and mostly slip (60 N).
const FORCES: [f64; 2] = [6.0, 60.0];

/// The slow and obvious march, whose every jump is looked for in steps of one length, against the one that holds what sticks.
#[test]
fn halved_steps_are_worth_eight_times_the_steps() {
    let law = Coulomb { mu_k: MU };
    for force in FORCES {
        let (oracle, _) = marched((Jumping(law), MODES), force, (8 * 512, 1.0));
        let (plain, _) = marched((Jumping(law), MODES), force, (512, 1.0));
        let (halved, count) = marched((law, MODES), force, (512, 1e-6));
        // Unhalved, 4096 steps put a jump up to half of one, 8e-4 of the phase, beside its place: 3e-6 to 8e-6 here.
        let [far, near] = [apart(&plain, &oracle), apart(&halved, &oracle)];
        assert!(near < 2e-5 && far > 5e-4, "{force}: {near:e}, without halving {far:e}");
        assert!((513..8 * 512).contains(&count), "{force}: {count} steps");
    }
}

/// Lines of the balance without an end of its order: the limit `a` of `a + b/H²` through orders from 360 to 720, each weighted with its `H⁴`.
fn balanced_without_end(force: f64) -> Vec<Complex64> {
    let orders = [360, 414, 475, 546, 627, 720];
    let all = orders.map(|order| balanced(force, order));
    let weights = orders.map(|order| (order as f64).powi(4));
    let abscissae = orders.map(|order| (order as f64).powi(-2));
    let mean = |values: &dyn Fn(usize) -> Complex64| {
        (0..orders.len()).map(|k| values(k) * weights[k]).sum::<Complex64>() / weights.iter().sum::<f64>()
    };
    let centre = mean(&|k| abscissae[k].into()).re;
    let spread = mean(&|k| (abscissae[k] - centre).powi(2).into());
    (0..=LINES)
        .map(|h| {
            let slope = mean(&|k| all[k][h] * (abscissae[k] - centre)) / spread;
            mean(&|k| all[k][h]) - slope * centre
        })
        .collect()
}

/// Two causes kept march and balance 1e-4 apart where friction without a presliding range holds and slips. The flexibility of the modes
/// that a march leaves out rides on damped ones, whose loss falls with the third power of the number of modes: 1.2e-4 with 40 (at
/// order 511), 1.5e-5 with 80, 1.3e-5 with 160, of which nearly all is the other cause: a force that jumps has lines that fall with 1/h, and
/// the balance that cuts them off errs by about 4/H² (6 N) and 3/H² (60 N) at orders from 63 to 722: 1.2e-3, 1.8e-4, 6e-5, 1.3e-5, 7e-6 and 8e-4,
/// 1.7e-4, 4e-5, 9e-6, 6e-6 at 63, 127, 255, 511, 722, whether with 8, 16 or 32 samples a line. With both taken away 1e-6 to 4e-6 are left;
/// against steps eight times finer the march moves by 6e-8, and for one degree of freedom it is Den Hartog's exact motion to eight digits.
#[test]
fn the_march_is_the_rigid_balance() {
    for force in FORCES {
        let (lines, _) = marched((Coulomb { mu_k: MU }, MANY), force, (1024, 1e-7));
        let difference = apart(&balanced_without_end(force), &lines);
        assert!(difference < 6e-6, "{force}: {difference:e}");
    }
}
