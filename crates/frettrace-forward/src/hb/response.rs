//! Frequency responses of a beam on a frictional support over levels of excitation, with stability and backbone.

use super::adaptive::{Accuracy, AdaptiveSolver};
use super::contact::{Contact, Normal};
use super::continuation::{Point, Sweep, SweepStatus};
use super::element::Element;
use super::modes::Modes;
use super::network::{Load, Network, Reading};
use super::solver::Settings;
use crate::ForwardError;
use crate::march::{Port, Structure};
use frettrace_beam::ModalModel;
use num_complex::Complex64;
use rayon::prelude::*;

/// A beam on a frictional support.
#[derive(Clone)]
pub struct FrictionBeam<'a> {
    /// The beam with all modes that are wanted; its residual flexibility is kept.
    pub model: ModalModel,
    /// The same beam with a few modes only, for stability, where every mode costs; its residual completes it.
    pub coarse: ModalModel,
    /// Where the exciter acts.
    pub exciter: Port,
    /// The slip.
    pub slip: Port,
    /// Displacement `w` at the support and stiffness `k_n` (N/m): `N = preload − k_n w`; `None`: `N = preload`.
    pub normal: Option<(Port, f64)>,
    /// Preload (N).
    pub preload: f64,
    /// The friction law.
    pub friction: &'a dyn Element,
    /// Point masses (kg).
    pub masses: Vec<(Port, f64)>,
    /// Local elements without friction: stops, nonlinear springs and dampers.
    pub attached: Vec<(Port, &'a dyn Element)>,
    /// The accelerometers.
    pub sensors: Vec<Port>,
}

/// What is computed.
#[derive(Clone, Debug, PartialEq)]
pub struct ResponseOptions {
    /// Amplitudes of the exciting force (N).
    pub levels: Vec<f64>,
    /// Excitation frequencies at the ends of the sweep (rad/s).
    pub range: [f64; 2],
    /// Order and sampling: each point has the lowest order that reaches [`Accuracy::truncation`], see
    /// [`AdaptiveSolver::follow`]; equal lowest and highest orders fix it.
    pub accuracy: Accuracy,
    /// Tolerance and iterations of the balance; order and samples are those of `accuracy`.
    pub settings: Settings,
    /// Error of the predictor aimed at, and longest step: see [`Sweep`].
    pub resolution: [f64; 2],
    /// Whether stability is computed for every point.
    pub stability: bool,
    /// Points of the backbone, 0 for none.
    pub backbone: usize,
}

/// A point of a response.
#[derive(Clone, Debug, PartialEq)]
pub struct ResponsePoint {
    /// Excitation frequency (rad/s).
    pub omega: f64,
    /// Root mean square of the acceleration of each sensor (m/s²).
    pub acceleration: Vec<f64>,
    /// Amplitude of line 1 of the slip (m).
    pub slip: f64,
    /// Amplitude of line 1 of the friction force (N).
    pub friction: f64,
    /// Harmonic order of the point.
    pub order: usize,
    /// Motion that the harmonics cut off would cause, relative to the slip: [`super::Solution::truncation`].
    pub truncation: f64,
    /// Whether the motion is stable, where that was asked.
    pub stable: Option<bool>,
}

/// The response at one level.
#[derive(Clone, Debug, PartialEq)]
pub struct LevelResponse {
    /// Amplitude of the exciting force (N).
    pub force_amplitude: f64,
    /// The points along the curve.
    pub points: Vec<ResponsePoint>,
    /// How the curve ended.
    pub status: SweepStatus,
    /// Largest [`ResponsePoint::truncation`] along the curve; NaN without points.
    pub truncation: f64,
    /// Marches through the contact's period.
    pub evaluations: usize,
}

/// A point of the backbone: the resonance without excitation and loss.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BackbonePoint {
    /// Frequency of the nonlinear mode (rad/s).
    pub omega: f64,
    /// Its damping ratio.
    pub damping_ratio: f64,
    /// Amplitude of line 1 of the slip (m).
    pub slip: f64,
}

/// Responses over levels.
#[derive(Clone, Debug, PartialEq)]
pub struct Response {
    /// One response a level, in the order asked.
    pub levels: Vec<LevelResponse>,
    /// The backbone over the slips of all levels; it ends early where the mode is lost.
    pub backbone: Vec<BackbonePoint>,
}

const EXCITER: usize = 0;
const SLIP: usize = 1;

impl FrictionBeam<'_> {
    fn ports(&self) -> Vec<Port> {
        let ports = [self.exciter, self.slip].into_iter().chain(self.normal.map(|(port, _)| port));
        let masses = self.masses.iter().map(|(port, _)| *port);
        ports.chain(self.attached.iter().map(|(port, _)| *port)).chain(masses).collect()
    }

    fn first_attached(&self) -> usize {
        2 + usize::from(self.normal.is_some())
    }

    /// Channels: slip, normal force where it varies, attached elements; forces: friction, attached elements.
    fn network(&self, structure: Structure) -> Network {
        let first = self.first_attached();
        let attached = first..first + self.attached.len();
        let mut channels = vec![Reading::motion(SLIP)];
        if let Some((_, stiffness)) = self.normal {
            channels.push(Reading { port: 2, scale: -stiffness, offset: self.preload });
        }
        channels.extend(attached.clone().map(Reading::motion));
        let forces = std::iter::once(SLIP).chain(attached).collect();
        let mut network = Network::new(structure, channels, forces);
        network.loads.push(Load { port: EXCITER, harmonic: 1, amplitude: Complex64::ONE });
        network
    }

    /// The structure with the contact's ports and then the sensors'.
    fn structure(&self, model: &ModalModel, sensors: bool) -> Result<Structure, ForwardError> {
        let mut ports = self.ports();
        let first_mass = self.first_attached() + self.attached.len();
        if sensors {
            ports.extend(&self.sensors);
        }
        let mut structure = Structure::from_beam(model, &ports)?;
        for (index, &(_, mass)) in self.masses.iter().enumerate() {
            structure.add_mass(first_mass + index, mass)?;
        }
        Ok(structure)
    }

    fn contacts(&self) -> Vec<Contact<'_>> {
        let normal = if self.normal.is_some() { Normal::Channel(1) } else { Normal::Constant(self.preload) };
        let friction = Contact { slip: 0, normal, force: 0, normal_force: None, element: self.friction };
        let first = self.first_attached() - 1;
        let attached = self.attached.iter().enumerate().map(|(index, (_, element))| Contact {
            slip: first + index,
            normal: Normal::Constant(0.0),
            force: 1 + index,
            normal_force: None,
            element: *element,
        });
        std::iter::once(friction).chain(attached).collect()
    }
}

/// The three views of the structure: for the balance, for the sensors, for stability.
struct Views {
    balance: Network,
    sensors: Network,
    stability: Network,
}

/// Responses over levels, in parallel.
///
/// # Errors
/// A problem that is not one: see [`ForwardError`]. A curve that ends early says so in its status.
pub fn response(beam: &FrictionBeam, options: &ResponseOptions) -> Result<Response, ForwardError> {
    let all = beam.structure(&beam.model, true)?;
    let count = beam.ports().len();
    // The balance sees the same modes, residual included, without the sensors' rows.
    let rows = (0..count).map(|port| all.row(port).to_vec()).collect();
    let few = Structure::new(all.natural_frequency().to_vec(), all.damping_ratio().to_vec(), rows)?;
    let mut sensors = beam.network(all);
    sensors.channels = (count..count + beam.sensors.len()).map(Reading::motion).collect();
    let views = Views {
        balance: beam.network(few),
        sensors,
        stability: beam.network(beam.structure(&beam.coarse, false)?),
    };
    let contacts = beam.contacts();
    let levels: Vec<LevelResponse> = options
        .levels
        .par_iter()
        .map(|&level| one_level(&views, &contacts, options, level))
        .collect::<Result<_, _>>()?;
    let backbone = backbone(&views.balance, &contacts, options, &levels)?;
    Ok(Response { levels, backbone })
}

fn one_level(
    views: &Views,
    contacts: &[Contact],
    options: &ResponseOptions,
    level: f64,
) -> Result<LevelResponse, ForwardError> {
    let mut solver = AdaptiveSolver::new(options.accuracy, options.settings);
    let [resolution, longest] = options.resolution;
    let sweep = Sweep { range: options.range, level, resolution, longest, ..Sweep::default() };
    let curve = solver.follow(&views.balance, contacts, &sweep)?;
    let mut points = Vec::with_capacity(curve.points.len());
    for point in &curve.points {
        let mut found = describe(views, level, point)?;
        if options.stability {
            let at = (point.omega, level);
            let solver = solver.at_order(found.order)?;
            found.stable = Some(solver.floquet(&views.stability, contacts, at, &point.forces)?.stable());
        }
        points.push(found);
    }
    Ok(LevelResponse {
        force_amplitude: level,
        status: curve.status,
        truncation: points.iter().map(|point| point.truncation).fold(f64::NAN, f64::max),
        points,
        evaluations: curve.evaluations,
    })
}

fn describe(views: &Views, level: f64, point: &Point) -> Result<ResponsePoint, ForwardError> {
    let order = point.forces.len() / views.balance.forces.len() - 1;
    let lines = views.sensors.lines(point.omega, order, level)?;
    let rms = |channel: usize| -> f64 {
        let motion = lines.motion(channel, &point.forces);
        let squares = motion.iter().enumerate();
        squares.map(|(h, x)| 0.5 * x.norm_sqr() * (h as f64 * point.omega).powi(4)).sum::<f64>().sqrt()
    };
    let slip = views.balance.lines(point.omega, 1, level)?.motion(0, &first_lines(&point.forces, order));
    Ok(ResponsePoint {
        omega: point.omega,
        acceleration: (0..lines.channels()).map(rms).collect(),
        slip: slip[1].norm(),
        friction: point.forces[1].norm(),
        order,
        truncation: point.truncation.unwrap_or(f64::NAN),
        stable: None,
    })
}

/// Lines 0 and 1 of every force.
fn first_lines(forces: &[Complex64], order: usize) -> Vec<Complex64> {
    forces.chunks_exact(order + 1).flat_map(|row| [row[0], row[1]]).collect()
}

/// The mode whose frequency with the contact sliding is nearest below the largest response, from small to large slip.
fn backbone(
    network: &Network,
    contacts: &[Contact],
    options: &ResponseOptions,
    levels: &[LevelResponse],
) -> Result<Vec<BackbonePoint>, ForwardError> {
    let all = || levels.iter().flat_map(|level| &level.points);
    let Some(peak) = all().max_by(|a, b| a.slip.total_cmp(&b.slip)) else { return Ok(Vec::new()) };
    if options.backbone == 0 {
        return Ok(Vec::new());
    }
    // A level without a start has no peak.
    let followed = levels.iter().filter(|level| !level.points.is_empty());
    let peaks = followed.map(|level| level.points.iter().map(|p| p.slip).fold(0.0, f64::max));
    let smallest = 0.5 * peaks.fold(f64::INFINITY, f64::min);
    let frequency = network.structure.natural_frequency();
    let mode = frequency.iter().rposition(|&w| w <= 1.02 * peak.omega).unwrap_or(0);
    let modes = Modes { mode, channel: 0, amplitudes: [smallest, 1.5 * peak.slip], points: options.backbone };
    // The order at the largest response is enough for the mode there.
    let mut solver = AdaptiveSolver::new(options.accuracy, options.settings);
    let points = solver.at_order(peak.order)?.follow_mode(network, contacts, &modes)?;
    let point = |p: &super::ModePoint| BackbonePoint {
        omega: p.omega,
        damping_ratio: p.damping_ratio,
        slip: p.amplitude,
    };
    Ok(points.iter().map(point).collect())
}
