//! A rig to its frequency responses over levels, by harmonic balance.

use std::f64::consts::TAU;

use frettrace_beam::{Dof, ModalModel, ModalOptions};
use frettrace_forward::hb::{
    self, Accuracy, Element, FrictionBeam, LocalElement, ResponseOptions as Wanted, Settings, SweepStatus,
};
use frettrace_forward::march::Port;
use frettrace_forward::simulate::{Attached, SimulatedLaw, SimulatedRig, Slip};
use frettrace_friction::FrictionModel;
use frettrace_measurement as file;
use serde::Serialize;

use crate::rig::Rig;
use crate::{Progress, StudyError, simulate};

/// What `response` computes.
#[derive(Clone, Debug, PartialEq)]
pub struct ResponseOptions {
    /// Excitation frequencies at the ends of the sweep (Hz); by default 20 % below and above the rig's runs.
    pub range_hz: Option<[f64; 2]>,
    /// Motion that the harmonics cut off may cause, relative to the slip: each point has the lowest order that keeps it.
    pub truncation: f64,
    /// Harmonic order of every point; by default it follows from the truncation.
    pub order: Option<usize>,
    /// Whether stability is computed.
    pub stability: bool,
}

impl Default for ResponseOptions {
    fn default() -> Self {
        Self { range_hz: None, truncation: 1e-3, order: None, stability: true }
    }
}

/// Frequency responses of a rig.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct FrequencyResponse {
    /// Positions of the sensors (m).
    pub sensor_position_m: Vec<f64>,
    /// One response for each amplitude of the force.
    pub levels: Vec<Level>,
    /// Resonance without excitation and loss, over slip.
    pub backbone: Vec<Backbone>,
}

impl FrequencyResponse {
    /// The responses as they stand in their file.
    #[must_use]
    pub fn file(&self, title: &str) -> file::ResponseFile {
        file::ResponseFile {
            title: title.to_owned(),
            sensor_position: self.sensor_position_m.clone(),
            levels: self.levels.iter().map(|level| level.file(self.sensor_position_m.len())).collect(),
            backbone: file::ResponseBackbone {
                slip: self.backbone.iter().map(|point| point.slip_m).collect(),
                frequency: self.backbone.iter().map(|point| point.frequency_hz).collect(),
                damping_ratio: self.backbone.iter().map(|point| point.damping_ratio).collect(),
            },
        }
    }
}

/// The response at one amplitude of the force.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Level {
    /// Amplitude of the force (N).
    pub force_amplitude_n: f64,
    /// `finished`, `returned`, `jumped`, `stalled`, `no-start` or `point-limit`.
    pub status: &'static str,
    /// Largest motion that the harmonics cut off would cause along the curve, relative to the slip.
    pub truncation: f64,
    /// Points along the curve.
    pub points: Vec<Point>,
}

impl Level {
    fn file(&self, sensors: usize) -> file::ResponseLevel {
        let column = |value: &dyn Fn(&Point) -> f64| self.points.iter().map(value).collect::<Vec<f64>>();
        file::ResponseLevel {
            force_amplitude: self.force_amplitude_n,
            status: self.status.to_owned(),
            truncation: self.truncation,
            frequency: column(&|point| point.frequency_hz),
            acceleration: (0..sensors).map(|s| column(&|point| point.acceleration_m_per_s2[s])).collect(),
            slip: column(&|point| point.slip_m),
            friction_force: column(&|point| point.friction_force_n),
            order: column(&|point| point.order as f64),
            stable: self.points.iter().map(|point| point.stable).collect(),
        }
    }
}

/// A point of a response.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Point {
    /// Excitation frequency (Hz).
    pub frequency_hz: f64,
    /// Root mean square of the acceleration of each sensor (m/s²).
    pub acceleration_m_per_s2: Vec<f64>,
    /// Amplitude of the slip on the excitation's line (m).
    pub slip_m: f64,
    /// Amplitude of the friction force on the excitation's line (N).
    pub friction_force_n: f64,
    /// Harmonic order of the point.
    pub order: usize,
    /// Whether small disturbances die out.
    pub stable: Option<bool>,
}

/// A point of the backbone.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Backbone {
    /// Frequency (Hz).
    pub frequency_hz: f64,
    /// Damping ratio of the mode, friction included.
    pub damping_ratio: f64,
    /// Amplitude of the slip on line 1 (m).
    pub slip_m: f64,
}

/// Modes of the balance; more change nothing but the highest lines, since the residual flexibility is kept.
const MODES: usize = 40;
/// Modes for stability.
const COARSE_MODES: usize = 6;
/// Orders between which a response is free to choose.
const ORDERS: [usize; 2] = [7, 63];
/// Samples a period for each line.
const SAMPLES_A_LINE: usize = 16;
/// The same for a law that turns within a small slip or velocity: some samples must fall inside it, or the friction turns by
/// whole samples, and the curve through such a balance has folds of its own.
const SAMPLES_A_LINE_OF_TURNS: usize = 32;
/// A contact without presliding is given a bristle this much stiffer than the beam at its slip.
const RIGID: f64 = 300.0;
/// Points of the backbone.
const BACKBONE: usize = 25;

/// Responses of a rig at all amplitudes of the force in its runs; the preload is that of the first run.
///
/// # Errors
/// [`StudyError`] where the beam cannot be computed, or an effect does not fit the law or a periodic response.
pub fn response(
    rig: &Rig,
    options: &ResponseOptions,
    progress: &Progress,
) -> Result<FrequencyResponse, StudyError> {
    let simulated = simulate::simulated_rig(rig)?;
    refuse(rig, &simulated)?;
    let locals: Vec<(Port, LocalElement)> = simulated.attached.iter().filter_map(local).collect();
    let model = model(&simulated, MODES)?;
    let preload = rig.runs.first().map_or(0.0, |run| run.preload_n);
    let slip = slip(&simulated);
    let compliance =
        frettrace_beam::Receptance::receptance(&model, slip.dof, slip.dof, 0.0).re * slip.factor.powi(2);
    let friction = laws::law(&simulated.law, RIGID / (compliance * preload));
    let beam = FrictionBeam {
        coarse: self::model(&simulated, COARSE_MODES)?,
        model,
        exciter: displacement(simulated.exciter),
        slip,
        normal: match simulated.slip {
            Slip::Rotation { .. } => {
                Some((displacement(simulated.beam.length), simulated.boundary.support_stiffness))
            }
            Slip::Transverse => None,
        },
        preload,
        friction: friction.as_ref(),
        masses: simulated.attached.iter().filter_map(mass).collect(),
        attached: locals.iter().map(|(port, element)| (*port, element as &dyn Element)).collect(),
        sensors: simulated.sensors.iter().map(|sensor| displacement(sensor.position)).collect(),
    };
    let wanted = wanted(rig, &simulated.law, options);
    progress.start(1, "following the responses");
    let found = hb::response(&beam, &wanted)?;
    progress.step();
    progress.finish();
    Ok(described(&simulated, found))
}

fn wanted(rig: &Rig, law: &SimulatedLaw, options: &ResponseOptions) -> Wanted {
    let mut levels: Vec<f64> =
        rig.runs.iter().flat_map(|run| run.force_amplitude_n.iter().copied()).collect();
    levels.sort_by(f64::total_cmp);
    levels.dedup();
    let frequencies = || rig.runs.iter().map(|run| run.frequency_hz);
    let [low, high] = options.range_hz.unwrap_or([
        0.8 * frequencies().fold(f64::INFINITY, f64::min),
        1.2 * frequencies().fold(0.0, f64::max),
    ]);
    let samples_a_line = if laws::turns(law) { SAMPLES_A_LINE_OF_TURNS } else { SAMPLES_A_LINE };
    Wanted {
        levels,
        range: [TAU * low, TAU * high],
        accuracy: Accuracy {
            truncation: options.truncation,
            orders: options.order.map_or(ORDERS, |order| [order; 2]),
            samples_a_line,
            ..Accuracy::default()
        },
        settings: Settings { tolerance: 1e-7, ..Settings::default() },
        resolution: [1e-2, 0.03],
        stability: options.stability,
        backbone: BACKBONE,
    }
}

/// What a periodic response at the excitation's frequency, with the linear support spring, does not carry: effects, and the
/// force balance, which has no force for a motion apart from the time step it is marched with.
fn refuse(rig: &Rig, simulated: &SimulatedRig) -> Result<(), StudyError> {
    if let SimulatedLaw::Declared(FrictionModel::Fbfm(_)) = &simulated.law {
        return Err(StudyError::RigValue {
            path: std::path::PathBuf::new(),
            place: "support.law".to_owned(),
            found: "fbfm".to_owned(),
            allowed: "every other law: a balance of forces is a rule from time step to time step, which simulate marches"
                .to_owned(),
        });
    }
    let normal = simulated.normal;
    let normal = normal.lifts_off || normal.cubic != 0.0 || normal.sharpness != 0.0 || normal.power > 1.0;
    let foreign = matches!(simulated.law, SimulatedLaw::Foreign(_));
    let carried = |id: &str| {
        let place = id.trim_start_matches("unlisted:");
        !(place.starts_with("excitation") || id == "structure.frequency-drift")
            && !(normal && (id == "contact.lift-off" || id == "contact.normal-stiffening"))
            && !(foreign && (place.starts_with("friction") || place.starts_with("contact")))
    };
    match rig.effects.iter().position(|effect| !carried(effect.id())) {
        None => Ok(()),
        Some(index) => Err(StudyError::RigValue {
            path: std::path::PathBuf::new(),
            place: format!("effect {}", index + 1),
            found: rig.effects[index].id().to_owned(),
            allowed:
                "effects of friction (in their usual formulas), structure and measurement: response follows one \
                 period of the force"
                    .to_owned(),
        }),
    }
}

fn model(simulated: &SimulatedRig, modes: usize) -> Result<ModalModel, StudyError> {
    let given = |values: &[f64]| values[..values.len().min(modes)].to_vec();
    let options = ModalOptions {
        modes,
        natural_frequency: given(&simulated.natural_frequency),
        damping_ratio: given(&simulated.damping_ratio),
        ..ModalOptions::default()
    };
    Ok(ModalModel::new(&simulated.beam, &simulated.boundary, &options)?)
}

fn displacement(position: f64) -> Port {
    Port { dof: Dof::displacement(position), factor: 1.0 }
}

fn slip(simulated: &SimulatedRig) -> Port {
    let end = simulated.beam.length;
    match simulated.slip {
        Slip::Rotation { lever_arm } => Port { dof: Dof::rotation(end), factor: lever_arm },
        Slip::Transverse => displacement(end),
    }
}

fn local((position, attached): &(f64, Attached)) -> Option<(Port, LocalElement)> {
    match attached {
        Attached::Load(characteristic) => Some((displacement(*position), LocalElement(*characteristic))),
        Attached::Mass(_) => None,
    }
}

fn mass((position, attached): &(f64, Attached)) -> Option<(Port, f64)> {
    match attached {
        Attached::Mass(mass) => Some((displacement(*position), *mass)),
        Attached::Load(_) => None,
    }
}

fn described(simulated: &SimulatedRig, found: hb::Response) -> FrequencyResponse {
    let point = |p: hb::ResponsePoint| Point {
        frequency_hz: p.omega / TAU,
        acceleration_m_per_s2: p.acceleration,
        slip_m: p.slip,
        friction_force_n: p.friction,
        order: p.order,
        stable: p.stable,
    };
    let level = |l: hb::LevelResponse| Level {
        force_amplitude_n: l.force_amplitude,
        status: status(l.status),
        truncation: l.truncation,
        points: l.points.into_iter().map(point).collect(),
    };
    let backbone = |b: hb::BackbonePoint| Backbone {
        frequency_hz: b.omega / TAU,
        damping_ratio: b.damping_ratio,
        slip_m: b.slip,
    };
    FrequencyResponse {
        sensor_position_m: simulated.sensors.iter().map(|sensor| sensor.position).collect(),
        levels: found.levels.into_iter().map(level).collect(),
        backbone: found.backbone.into_iter().map(backbone).collect(),
    }
}

/// Status of a curve that ends where the force of its law jumps.
pub const JUMPED: &str = "jumped";

fn status(status: SweepStatus) -> &'static str {
    match status {
        SweepStatus::Finished => "finished",
        SweepStatus::Returned => "returned",
        SweepStatus::Jumped => JUMPED,
        SweepStatus::NoStart => "no-start",
        SweepStatus::PointLimit => "point-limit",
        _ => "stalled",
    }
}

mod laws;
#[cfg(test)]
mod tests;
