//! Effects by their ids, each with its own keys.

use serde::Deserialize;

/// What a rig does beside what its file declares. Positions in m from the clamp, sensors from 0.
#[derive(Clone, Debug, Deserialize, PartialEq)]
#[serde(tag = "id", deny_unknown_fields)]
#[expect(missing_docs, reason = "the id is the name and every key carries its unit")]
pub enum Effect {
    #[serde(rename = "friction.stribeck")]
    Stribeck { mu_s: f64, v_s_m_per_s: f64, delta: f64 },
    #[serde(rename = "friction.viscous")]
    Viscous { sigma2_n_s_per_m: f64 },
    #[serde(rename = "friction.lag")]
    Lag { time_s: f64, mu_s: f64, v_s_m_per_s: f64, delta: f64 },
    #[serde(rename = "friction.film")]
    Film { loss: f64, rise_time_s: f64, fall_time_s: f64, velocity_m_per_s: f64 },
    #[serde(rename = "friction.ageing")]
    Ageing { gain: f64, distance_m: f64, time_s: f64 },
    #[serde(rename = "friction.asymmetry")]
    Asymmetry { share: f64 },
    #[serde(rename = "friction.breakaway")]
    Breakaway { breakaway: f64 },
    #[serde(rename = "friction.exponent")]
    Exponent { exponent: f64 },
    #[serde(rename = "friction.presliding-damping")]
    PreslidingDamping { sigma1_s_per_m: f64, v_d_m_per_s: f64 },
    #[serde(rename = "friction.position")]
    Position { slope_per_m: f64 },
    #[serde(rename = "friction.position-periodic")]
    PositionPeriodic { share: f64, wavelength_m: f64 },
    #[serde(rename = "friction.normal-dependence")]
    NormalDependence { exponent: f64 },
    #[serde(rename = "friction.wear")]
    Wear { relative_change: f64 },
    #[serde(rename = "contact.lift-off")]
    LiftOff,
    #[serde(rename = "contact.normal-stiffening")]
    NormalStiffening { cubic_n_per_m3: f64 },
    #[serde(rename = "contact.tangential-stiffness")]
    TangentialStiffness { series_stiffness_n_per_m: f64 },
    #[serde(rename = "contact.backlash")]
    Backlash { half_play_m: f64 },
    #[serde(rename = "structure.cubic-stiffness")]
    CubicStiffness { position_m: f64, stiffness_n_per_m3: f64 },
    #[serde(rename = "structure.quadratic-damping")]
    QuadraticDamping { position_m: f64, damping_n_s2_per_m2: f64 },
    #[serde(rename = "structure.clamp-compliance")]
    ClampCompliance { rotational_stiffness_n_m_per_rad: f64 },
    #[serde(rename = "structure.added-mass")]
    AddedMass { position_m: f64, mass_kg: f64 },
    #[serde(rename = "structure.second-support")]
    SecondSupport {
        position_m: f64,
        stiffness_n_per_m: f64,
        #[serde(default)]
        gap_m: f64,
    },
    #[serde(rename = "structure.modal-frequency")]
    ModalFrequency { mode: usize, relative_change: f64 },
    #[serde(rename = "structure.modal-damping")]
    ModalDamping { mode: usize, relative_change: f64 },
    #[serde(rename = "structure.frequency-drift")]
    FrequencyDrift { relative_change: f64 },
    #[serde(rename = "excitation.preload-modulation")]
    PreloadModulation { share: f64, frequency_ratio: f64, phase_rad: f64 },
    #[serde(rename = "excitation.base-motion")]
    BaseMotion { acceleration_m_per_s2: f64, frequency_ratio: f64, phase_rad: f64 },
    #[serde(rename = "measurement.gain")]
    Gain { sensor: usize, factor: f64 },
    #[serde(rename = "measurement.delay")]
    Delay { sensor: usize, delay_s: f64 },
    #[serde(rename = "measurement.hum")]
    Hum { sensor: usize, amplitude_m_per_s2: f64, frequency_hz: f64 },
    #[serde(rename = "measurement.clipping")]
    Clipping { sensor: usize, limit_m_per_s2: f64 },
    #[serde(rename = "measurement.position")]
    SensorPosition { sensor: usize, shift_m: f64 },
    #[serde(rename = "measurement.dropout")]
    Dropout { sensor: usize, start_share: f64, length_share: f64 },
    #[serde(rename = "measurement.offset")]
    Offset { sensor: usize, offset_m_per_s2: f64 },
}

impl Effect {
    /// Its id in results.
    #[must_use]
    pub fn id(&self) -> &'static str {
        match self {
            Self::Stribeck { .. } => "friction.stribeck",
            Self::Viscous { .. } => "friction.viscous",
            Self::Lag { .. } => "friction.lag",
            Self::Film { .. } => "friction.film",
            Self::Ageing { .. } => "friction.ageing",
            Self::Asymmetry { .. } => "friction.asymmetry",
            Self::Breakaway { .. } => "friction.breakaway",
            Self::Exponent { .. } => "friction.exponent",
            Self::PreslidingDamping { .. } => "friction.presliding-damping",
            Self::Position { .. } => "friction.position",
            Self::PositionPeriodic { .. } => "friction.position-periodic",
            Self::NormalDependence { .. } => "friction.normal-dependence",
            Self::Wear { .. } => "friction.wear",
            Self::LiftOff => "contact.lift-off",
            Self::NormalStiffening { .. } => "contact.normal-stiffening",
            Self::TangentialStiffness { .. } => "contact.tangential-stiffness",
            Self::Backlash { .. } => "contact.backlash",
            Self::CubicStiffness { .. } => "structure.cubic-stiffness",
            Self::QuadraticDamping { .. } => "structure.quadratic-damping",
            Self::ClampCompliance { .. } => "structure.clamp-compliance",
            Self::AddedMass { .. } => "structure.added-mass",
            Self::SecondSupport { .. } => "structure.second-support",
            Self::ModalFrequency { .. } => "structure.modal-frequency",
            Self::ModalDamping { .. } => "structure.modal-damping",
            Self::FrequencyDrift { .. } => "structure.frequency-drift",
            Self::PreloadModulation { .. } => "excitation.preload-modulation",
            Self::BaseMotion { .. } => "excitation.base-motion",
            Self::Gain { .. } => "measurement.gain",
            Self::Delay { .. } => "measurement.delay",
            Self::Hum { .. } => "measurement.hum",
            Self::Clipping { .. } => "measurement.clipping",
            Self::SensorPosition { .. } => "measurement.position",
            Self::Dropout { .. } => "measurement.dropout",
            Self::Offset { .. } => "measurement.offset",
        }
    }

    /// Where it acts (m), where it has a place on the beam.
    #[must_use]
    pub fn position(&self) -> Option<f64> {
        match *self {
            Self::CubicStiffness { position_m, .. }
            | Self::QuadraticDamping { position_m, .. }
            | Self::AddedMass { position_m, .. }
            | Self::SecondSupport { position_m, .. } => Some(position_m),
            _ => None,
        }
    }

    /// The sensor it acts on, where it acts on one.
    #[must_use]
    pub fn sensor(&self) -> Option<usize> {
        match *self {
            Self::Gain { sensor, .. }
            | Self::Delay { sensor, .. }
            | Self::Hum { sensor, .. }
            | Self::Clipping { sensor, .. }
            | Self::SensorPosition { sensor, .. }
            | Self::Dropout { sensor, .. }
            | Self::Offset { sensor, .. } => Some(sensor),
            _ => None,
        }
    }
}
