//! The problems P1-P4 that other harmonic-balance codes have answered, and their answers.
//!
//! P1: the cantilever with a tanh element of NLvib's example 08 (M. Krack, J. Gross, *Harmonic Balance for Nonlinear
//! Vibration Problems*, 2019). P2, P3: cantilevers with a Jenkins element. P4: two degrees of freedom under a normal and
//! tangential contact. The CSV files beside this one hold what tmdsimpy (commit 17d5fc3) answers: `omega_rad_s` and the
//! root mean square of the tip's displacement, at order 7 (P1: 128, P2 and P3: 1024 samples a period) and at order 8 with 128
//! samples (P4); `march_*` is a time march. NLvib and pyHarm agree with it to 1e-10. P3's
//! trace has a second answer, the same code's Newton steps carried on at each frequency.

use frettrace_beam::{Dof, FiniteElements, UniformBeam};
use frettrace_forward::hb::{
    Contact, ContactLaw, ElasticContact, Family, Load, Network, Normal, Reading, Support,
};
use frettrace_forward::march::Structure;
use frettrace_friction::{Scalar, Step};
use num_complex::Complex64;

/// A problem: its structure, channel 0 the contact, the last channels the outputs.
pub struct Peer {
    pub network: Network,
    pub element: Box<dyn frettrace_forward::hb::Element>,
    pub normal: Normal,
    pub normal_force: Option<usize>,
    pub order: usize,
    pub samples: usize,
}

impl Peer {
    pub fn contact(&self) -> Contact<'_> {
        Contact {
            slip: 0,
            normal: self.normal,
            force: 0,
            normal_force: self.normal_force,
            element: self.element.as_ref(),
        }
    }
}

/// Rows of numbers under a header.
pub fn table(csv: &str) -> Vec<Vec<f64>> {
    csv.lines().skip(1).map(|line| line.split(',').map(|x| x.parse().unwrap()).collect()).collect()
}

/// Root mean square of lines, the mean left out where `mean` is false.
pub fn rms(lines: &[Complex64], mean: bool) -> f64 {
    let alternating: f64 = lines[1..].iter().map(|x| x.norm_sqr() / 2.0).sum();
    (alternating + if mean { lines[0].re.powi(2) } else { 0.0 }).sqrt()
}

/// Modes of a clamped beam; ports: contact node, tip.
struct Cantilever {
    frequency: Vec<f64>,
    rows: Vec<Vec<f64>>,
}

impl Cantilever {
    fn new(beam: &UniformBeam, elements: usize, node: usize, spring: f64) -> Self {
        let mut model = FiniteElements::clamped(beam, elements).unwrap();
        let at = Dof::displacement(beam.length * (node - 1) as f64 / elements as f64);
        model.add_spring(at, spring);
        let modes = model.eigenmodes().unwrap();
        let row = |dof: Dof| -> Vec<f64> {
            let row = model.row(dof);
            (0..row.len())
                .map(|n| row.iter().enumerate().map(|(i, r)| r * modes.modes[(i, n)]).sum())
                .collect()
        };
        let rows = vec![row(at), row(Dof::displacement(beam.length))];
        Self { frequency: modes.natural_frequency, rows }
    }

    fn network(self, ratio: impl Fn(f64) -> f64, force: f64) -> Network {
        let damping = self.frequency.iter().map(|&w| ratio(w)).collect();
        let structure = Structure::new(self.frequency, damping, self.rows).unwrap();
        let mut network = Network::new(structure, vec![Reading::motion(0), Reading::motion(1)], vec![0]);
        network.loads.push(Load { port: 1, harmonic: 1, amplitude: Complex64::new(force, 0.0) });
        network
    }

    /// First natural frequency with the contact node held: the first zero of its receptance.
    fn held(&self) -> f64 {
        let receptance = |w: f64| -> f64 {
            self.frequency.iter().zip(&self.rows[0]).map(|(n, r)| r * r / (n * n - w * w)).sum()
        };
        let (mut low, mut high) = (self.frequency[0] * (1.0 + 1e-12), self.frequency[1] * (1.0 - 1e-12));
        for _ in 0..200 {
            let middle = 0.5 * (low + high);
            if receptance(middle) < 0.0 { low = middle } else { high = middle }
        }
        0.5 * (low + high)
    }
}

/// `f = μN tanh(v/ε)`, memoryless.
#[derive(Clone, Copy)]
pub struct Tanh {
    limit: f64,
    width: f64,
}

impl Family for Tanh {
    type Law<T: Scalar> = Self;

    fn parameters(&self) -> &[f64] {
        &[]
    }

    fn law<T: Scalar>(&self, _: &[T]) -> Self {
        *self
    }
}

impl<T: Scalar> ContactLaw<T> for Tanh {
    type State = [T; 0];

    const FORCES: usize = 1;

    fn rest(&self) -> [T; 0] {
        []
    }

    fn step(&self, state: [T; 0], step: &Step<T>) -> ([T; 0], [T; 2]) {
        (state, [(step.velocity[1] / self.width).tanh() * self.limit, T::zero()])
    }
}

pub fn p1() -> Peer {
    let beam = UniformBeam::rectangular(2.0, [0.3, 0.1], 185e9, 7830.0);
    let cantilever = Cantilever::new(&beam, 8, 4, 0.0);
    let held = cantilever.held();
    let network = cantilever.network(|w| 0.01 * w / held, 0.2);
    let element = Box::new(Tanh { limit: 1.5, width: 6e-7 });
    Peer { network, element, normal: Normal::Constant(0.0), normal_force: None, order: 7, samples: 128 }
}

/// Node of the contact, tangential stiffness, slip limit, damping ratios of the first two stuck modes.
struct Stuck(usize, f64, f64, [f64; 2]);

/// `D = αM + β(K + k_t wwᵀ)` with `α`, `β` from the stuck modes; `β k_t` is a dashpot at the contact.
fn jenkins(beam: &UniformBeam, elements: usize, contact: Stuck, force: f64) -> Peer {
    let Stuck(node, stiffness, limit, [z1, z2]) = contact;
    let stuck = Cantilever::new(beam, elements, node, stiffness).frequency;
    let (w1, w2) = (stuck[0], stuck[1]);
    let beta = 2.0 * (z2 * w2 - z1 * w1) / (w2 * w2 - w1 * w1);
    let alpha = 2.0 * z1 * w1 - beta * w1 * w1;
    let cantilever = Cantilever::new(beam, elements, node, 0.0);
    let mut network = cantilever.network(|w| 0.5 * (alpha / w + beta * w), force);
    network.supports.push(Support { port: 0, stiffness: 0.0, damping: beta * stiffness });
    let element = Box::new(ElasticContact {
        normal_stiffness: 0.0,
        preload: limit,
        tangential_stiffness: stiffness,
        friction_coefficient: 1.0,
    });
    Peer { network, element, normal: Normal::Constant(0.0), normal_force: None, order: 7, samples: 1024 }
}

pub fn p2() -> Peer {
    let beam = UniformBeam::rectangular(0.7, [0.03, 0.03], 185e9, 7830.0);
    jenkins(&beam, 7, Stuck(4, 1.3e6, 1.0, [0.008, 0.002]), 0.2)
}

pub fn p3() -> Peer {
    let beam = UniformBeam::rectangular(0.710, [0.06, 0.05], 210e9 * 0.6725, 7850.0);
    jenkins(&beam, 14, Stuck(6, 1e8, 106.0, [0.002, 0.002]), 20.0)
}

/// Ports: tangential, normal.
pub fn p4() -> Peer {
    let frequency = vec![12.0_f64.sqrt(), 21.0_f64.sqrt()];
    let damping = vec![0.05, 0.1 * 10.0 / frequency[1]];
    let structure = Structure::new(frequency, damping, vec![vec![1.0, 0.0], vec![0.0, 1.0]]).unwrap();
    let mut network = Network::new(structure, vec![Reading::motion(0), Reading::motion(1)], vec![0, 1]);
    for (port, harmonic, amplitude) in [(1, 0, 100.0), (0, 1, 100.0), (1, 1, 10.0)] {
        network.loads.push(Load { port, harmonic, amplitude: Complex64::new(amplitude, 0.0) });
    }
    let element = Box::new(ElasticContact {
        normal_stiffness: 21.0,
        preload: 0.0,
        tangential_stiffness: 5.0,
        friction_coefficient: 0.85,
    });
    Peer { network, element, normal: Normal::Channel(1), normal_force: Some(1), order: 8, samples: 128 }
}
