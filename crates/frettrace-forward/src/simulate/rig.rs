//! The rig as it truly is, whatever its file declares.

use frettrace_beam::{Boundary, UniformBeam};
use frettrace_friction::FrictionModel;
use frettrace_friction::effects::ModifiedLaw;

use super::chain::Chain;
use super::foreign::ForeignLaw;
use crate::march::{Characteristic, Modulation};

/// A rig with every effect in place; angles in rad, frequencies in rad/s, everything else SI.
#[derive(Clone, Debug)]
pub struct SimulatedRig {
    /// The beam.
    pub beam: UniformBeam,
    /// Its ends; the support spring is the normal contact's.
    pub boundary: Boundary,
    /// Modes marched, besides those of the residual.
    pub modes: usize,
    /// True natural frequencies of the first modes (rad/s); may be empty.
    pub natural_frequency: Vec<f64>,
    /// True damping ratios of the first modes; the last one holds for the rest.
    pub damping_ratio: Vec<f64>,
    /// Kind of slip.
    pub slip: Slip,
    /// What the normal contact does beside its linear spring.
    pub normal: NormalContact,
    /// The true friction law.
    pub law: SimulatedLaw,
    /// Position of the exciter (m).
    pub exciter: f64,
    /// The accelerometers.
    pub sensors: Vec<SimulatedSensor>,
    /// What else is fixed to the beam, at positions (m).
    pub attached: Vec<(f64, Attached)>,
    /// Index in `attached` of the load that the record reports as the second support's.
    pub second_support: Option<usize>,
    /// Motion of the base.
    pub base: Option<BaseMotion>,
    /// Lever of the moment that the exciter brings in beside its force (m).
    pub exciter_lever: f64,
    /// A force that nobody measures.
    pub second_force: Option<SecondForce>,
    /// Sampling.
    pub sampling: Sampling,
    /// Seed of all noise and phases.
    pub seed: u64,
}

/// How the contact face slips.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Slip {
    /// `u = lever_arm · θ(L)`, `N = preload − k w(L)`.
    Rotation {
        /// Lever arm (m).
        lever_arm: f64,
    },
    /// `u = w(L)`, `N = preload`.
    Transverse,
}

/// The normal contact beside its linear spring.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct NormalContact {
    /// Cubic stiffness (N/m³).
    pub cubic: f64,
    /// Sharpness of an exponential stiffening; 0 is none.
    pub sharpness: f64,
    /// Power of a contact between round bodies; up to 1 is none.
    pub power: f64,
    /// Whether it can open.
    pub lifts_off: bool,
}

/// A law of the catalogue, or one with effects in it.
#[derive(Clone, Copy, Debug)]
#[expect(clippy::large_enum_variant, reason = "one value a rig: boxing would only hide the law")]
pub enum SimulatedLaw {
    /// From the catalogue.
    Declared(FrictionModel),
    /// With effects.
    Modified(ModifiedLaw<f64>),
    /// With effects in other functional forms.
    Foreign(ForeignLaw),
}

/// An accelerometer at its true position.
#[derive(Clone, Debug, PartialEq)]
pub struct SimulatedSensor {
    /// True position (m).
    pub position: f64,
    /// Its measuring chain.
    pub chain: Chain,
    /// What it hears of another sensor.
    pub cross_talk: Option<CrossTalk>,
}

/// A share of another sensor's signal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CrossTalk {
    /// Number of the other sensor, from 0.
    pub from: usize,
    /// Share of its acceleration.
    pub share: f64,
}

/// `F(t) = amplitude · cos(ratio·Ωt + phase)` at a place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SecondForce {
    /// Position (m).
    pub position: f64,
    /// Amplitude (N).
    pub amplitude: f64,
    /// Frequency over the excitation's.
    pub frequency_ratio: f64,
    /// Phase where the excitation's sine begins (rad).
    pub phase: f64,
}

/// Something fixed to the beam.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Attached {
    /// A point mass (kg).
    Mass(f64),
    /// A load against the transverse motion.
    Load(Characteristic),
}

/// `a(t) = acceleration · cos(ratio·Ωt + phase)` of clamp and support alike.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BaseMotion {
    /// Amplitude (m/s²).
    pub acceleration: f64,
    /// Frequency over the excitation's.
    pub frequency_ratio: f64,
    /// Phase where the excitation's sine begins (rad).
    pub phase: f64,
}

/// The time base.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sampling {
    /// Sampling rate (Hz).
    pub rate: f64,
    /// Samples a run.
    pub samples: usize,
    /// Fine samples of the march a sample, before the anti-alias filter.
    pub oversampling: usize,
    /// Steps of the march.
    pub steps: Steps,
}

/// Steps of the march, before those that are halved where friction or a stop acts suddenly.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Steps {
    /// This many in a fine sample.
    Given(usize),
    /// One in a fine sample, halved ever further until no acceleration changes by more than this (m/s², root mean square);
    /// 0 takes a ten-thousandth of the smallest sensor's signal.
    Within(f64),
}

/// A beat of the excitation: `F(t) = A (1 + share · sin(ratio·ψ)) sin ψ` with `ψ = Ωt`. With a ratio that is no fraction of small numbers nothing
/// repeats, although force and motion are steady.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Beat {
    /// Share of the amplitude `A`.
    pub share: f64,
    /// Frequency of the beat over the excitation's.
    pub frequency_ratio: f64,
}

/// One run: a sinusoidal force, or one that beats.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SimulatedRun {
    /// Amplitude of the force (N).
    pub force_amplitude: f64,
    /// Beat of the force.
    pub beat: Option<Beat>,
    /// Angular frequency (rad/s).
    pub omega: f64,
    /// Preload (N).
    pub preload: f64,
    /// Modulation of the preload; its phase is that where the excitation's sine begins.
    pub modulation: Option<Modulation>,
    /// Factor on all natural frequencies in this run.
    pub frequency_factor: f64,
    /// Place of the run between the first (0) and the last (1).
    pub progress: f64,
}
