//! Effects by their ids, each with its own keys.

use serde::{Deserialize, Serialize};

/// What a rig does beside what its file declares. Positions in m from the clamp, sensors from 0.
#[derive(Clone, Debug, Deserialize, Serialize, PartialEq)]
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
    /// The same effects in other formulas: what another laboratory would write.
    #[serde(rename = "friction.stribeck/rational")]
    RationalStribeck { mu_s: f64, v_s_m_per_s: f64, delta: f64 },
    #[serde(rename = "friction.viscous/power")]
    PowerViscous { force_at_1_m_per_s_n: f64, power: f64 },
    #[serde(rename = "friction.lag/saturating")]
    SaturatingLag { time_s: f64, mu_s: f64, v_s_m_per_s: f64, delta: f64 },
    #[serde(rename = "friction.film/rational")]
    RationalFilm { loss: f64, rise_time_s: f64, fall_time_s: f64, velocity_m_per_s: f64 },
    #[serde(rename = "friction.ageing/saturating")]
    SaturatingAgeing { gain: f64, distance_m: f64, time_s: f64 },
    #[serde(rename = "friction.asymmetry/smooth")]
    SmoothAsymmetry { share: f64, velocity_m_per_s: f64 },
    #[serde(rename = "friction.breakaway/straight")]
    StraightBreakaway { breakaway: f64 },
    #[serde(rename = "friction.exponent/power")]
    PowerBristle { power: f64 },
    #[serde(rename = "friction.presliding-damping/rational")]
    RationalDamping { sigma1_s_per_m: f64, v_d_m_per_s: f64 },
    #[serde(rename = "friction.position/saturating")]
    SaturatingPosition { share: f64, distance_m: f64 },
    #[serde(rename = "friction.position-periodic/triangle")]
    TrianglePosition { share: f64, wavelength_m: f64 },
    #[serde(rename = "friction.normal-dependence/straight")]
    StraightNormalDependence { slope: f64, reference_n: f64 },
    #[serde(rename = "friction.wear/settling")]
    SettlingWear { relative_change: f64 },
    #[serde(rename = "contact.normal-stiffening/exponential")]
    ExponentialStiffening { sharpness: f64 },
    #[serde(rename = "contact.tangential-stiffness/series")]
    SeriesSpring { series_stiffness_n_per_m: f64 },
    #[serde(rename = "contact.tangential-stiffness/parallel")]
    ParallelSpring { stiffness_n_per_m: f64 },
    #[serde(rename = "contact.backlash/gradual")]
    GradualBacklash { half_play_m: f64 },
    #[serde(rename = "structure.cubic-stiffness/yielding")]
    YieldingCubic { position_m: f64, stiffness_n_per_m3: f64, scale_m: f64 },
    #[serde(rename = "structure.quadratic-damping/power")]
    PowerDamping { position_m: f64, force_at_1_m_per_s_n: f64, power: f64 },
    #[serde(rename = "structure.second-support/round")]
    RoundSupport { position_m: f64, stiffness_n_per_m_3_2: f64, gap_m: f64 },
    #[serde(rename = "structure.second-support/rubbing")]
    RubbingSupport { position_m: f64, level_n: f64, velocity_m_per_s: f64 },
    #[serde(rename = "structure.frequency-drift/settling")]
    SettlingDrift { relative_change: f64 },
    #[serde(rename = "excitation.preload-modulation/square")]
    SquareModulation { share: f64, frequency_ratio: f64, phase_rad: f64 },
    #[serde(rename = "measurement.delay/low-pass")]
    LowPass { sensor: usize, time_s: f64 },
    #[serde(rename = "measurement.hum/third-harmonic")]
    ThirdHarmonicHum { sensor: usize, amplitude_m_per_s2: f64, frequency_hz: f64, third_share: f64 },
    #[serde(rename = "measurement.clipping/soft")]
    SoftClipping { sensor: usize, limit_m_per_s2: f64 },
    #[serde(rename = "measurement.dropout/hold")]
    HeldDropout { sensor: usize, start_share: f64, length_share: f64 },
    #[serde(rename = "measurement.offset/drift")]
    OffsetDrift { sensor: usize, offset_m_per_s2: f64 },
    /// And in third ones.
    #[serde(rename = "friction.stribeck/straight")]
    StraightStribeck { mu_s: f64, v_s_m_per_s: f64 },
    #[serde(rename = "friction.viscous/eyring")]
    EyringViscous { force_n: f64, velocity_m_per_s: f64 },
    #[serde(rename = "friction.ageing/power")]
    PowerAgeing { gain: f64, distance_m: f64, time_s: f64, power: f64 },
    #[serde(rename = "friction.presliding-damping/exponential")]
    ExponentialDamping { sigma1_s_per_m: f64, v_d_m_per_s: f64 },
    #[serde(rename = "friction.position/parabola")]
    ParabolicPosition { share: f64, distance_m: f64 },
    #[serde(rename = "friction.position-periodic/square")]
    SquarePosition { share: f64, wavelength_m: f64 },
    #[serde(rename = "friction.normal-dependence/adhesion")]
    Adhesion { share: f64, reference_n: f64 },
    #[serde(rename = "friction.wear/root")]
    RootWear { relative_change: f64 },
    #[serde(rename = "contact.normal-stiffening/round")]
    RoundContact { power: f64 },
    #[serde(rename = "structure.cubic-stiffness/hyperbolic")]
    HyperbolicCubic { position_m: f64, stiffness_n_per_m3: f64, scale_m: f64 },
    #[serde(rename = "structure.second-support/smooth")]
    SmoothSupport { position_m: f64, stiffness_n_per_m: f64, gap_m: f64, smoothness_m: f64 },
    #[serde(rename = "excitation.preload-modulation/skewed")]
    SkewedModulation { share: f64, frequency_ratio: f64, phase_rad: f64 },
    #[serde(rename = "measurement.delay/two-low-passes")]
    TwoLowPasses { sensor: usize, time_s: f64 },
    #[serde(rename = "measurement.clipping/one-sided")]
    OneSidedClipping { sensor: usize, limit_m_per_s2: f64 },
    #[serde(rename = "measurement.offset/settling")]
    SettlingOffset { sensor: usize, offset_m_per_s2: f64 },
    /// Effects that have no name in results: the answer must be that something is unexplained, and where.
    #[serde(rename = "unlisted:contact/speed-square")]
    SpeedSquare { coefficient_n_s2_per_m2: f64 },
    #[serde(rename = "unlisted:contact/normal-memory")]
    NormalMemory { time_s: f64 },
    #[serde(rename = "unlisted:structure/even-stiffness")]
    EvenStiffness { position_m: f64, stiffness_n_per_m2: f64 },
    #[serde(rename = "unlisted:excitation/moment")]
    ExciterMoment { lever_m: f64 },
    #[serde(rename = "unlisted:excitation/second-force")]
    SecondForce { position_m: f64, amplitude_n: f64, frequency_ratio: f64, phase_rad: f64 },
    #[serde(rename = "unlisted:measurement/quadratic-gain")]
    QuadraticGain { sensor: usize, coefficient_s2_per_m: f64 },
    #[serde(rename = "unlisted:measurement/high-pass")]
    HighPass { sensor: usize, corner_hz: f64 },
    #[serde(rename = "unlisted:measurement/cross-talk")]
    CrossTalk { sensor: usize, from: usize, share: f64 },
}

impl Effect {
    /// Its id in results; `unlisted:` and the place where it has none.
    #[must_use]
    pub fn id(&self) -> &'static str {
        match self {
            Self::Stribeck { .. } | Self::RationalStribeck { .. } | Self::StraightStribeck { .. } => {
                "friction.stribeck"
            }
            Self::Viscous { .. } | Self::PowerViscous { .. } | Self::EyringViscous { .. } => {
                "friction.viscous"
            }
            Self::Lag { .. } | Self::SaturatingLag { .. } => "friction.lag",
            Self::Film { .. } | Self::RationalFilm { .. } => "friction.film",
            Self::Ageing { .. } | Self::SaturatingAgeing { .. } | Self::PowerAgeing { .. } => {
                "friction.ageing"
            }
            Self::Asymmetry { .. } | Self::SmoothAsymmetry { .. } => "friction.asymmetry",
            Self::Breakaway { .. } | Self::StraightBreakaway { .. } => "friction.breakaway",
            Self::Exponent { .. } | Self::PowerBristle { .. } => "friction.exponent",
            Self::PreslidingDamping { .. }
            | Self::RationalDamping { .. }
            | Self::ExponentialDamping { .. } => "friction.presliding-damping",
            Self::Position { .. } | Self::SaturatingPosition { .. } | Self::ParabolicPosition { .. } => {
                "friction.position"
            }
            Self::PositionPeriodic { .. } | Self::TrianglePosition { .. } | Self::SquarePosition { .. } => {
                "friction.position-periodic"
            }
            Self::NormalDependence { .. } | Self::StraightNormalDependence { .. } | Self::Adhesion { .. } => {
                "friction.normal-dependence"
            }
            Self::Wear { .. } | Self::SettlingWear { .. } | Self::RootWear { .. } => "friction.wear",
            Self::LiftOff => "contact.lift-off",
            Self::NormalStiffening { .. }
            | Self::ExponentialStiffening { .. }
            | Self::RoundContact { .. } => "contact.normal-stiffening",
            Self::TangentialStiffness { .. } | Self::SeriesSpring { .. } | Self::ParallelSpring { .. } => {
                "contact.tangential-stiffness"
            }
            Self::Backlash { .. } | Self::GradualBacklash { .. } => "contact.backlash",
            Self::CubicStiffness { .. } | Self::YieldingCubic { .. } | Self::HyperbolicCubic { .. } => {
                "structure.cubic-stiffness"
            }
            Self::QuadraticDamping { .. } | Self::PowerDamping { .. } => "structure.quadratic-damping",
            Self::ClampCompliance { .. } => "structure.clamp-compliance",
            Self::AddedMass { .. } => "structure.added-mass",
            Self::SecondSupport { .. }
            | Self::RoundSupport { .. }
            | Self::RubbingSupport { .. }
            | Self::SmoothSupport { .. } => "structure.second-support",
            Self::ModalFrequency { .. } => "structure.modal-frequency",
            Self::ModalDamping { .. } => "structure.modal-damping",
            Self::FrequencyDrift { .. } | Self::SettlingDrift { .. } => "structure.frequency-drift",
            Self::PreloadModulation { .. }
            | Self::SquareModulation { .. }
            | Self::SkewedModulation { .. } => "excitation.preload-modulation",
            Self::BaseMotion { .. } => "excitation.base-motion",
            Self::Gain { .. } => "measurement.gain",
            Self::Delay { .. } | Self::LowPass { .. } | Self::TwoLowPasses { .. } => "measurement.delay",
            Self::Hum { .. } | Self::ThirdHarmonicHum { .. } => "measurement.hum",
            Self::Clipping { .. } | Self::SoftClipping { .. } | Self::OneSidedClipping { .. } => {
                "measurement.clipping"
            }
            Self::SensorPosition { .. } => "measurement.position",
            Self::Dropout { .. } | Self::HeldDropout { .. } => "measurement.dropout",
            Self::Offset { .. } | Self::OffsetDrift { .. } | Self::SettlingOffset { .. } => {
                "measurement.offset"
            }
            Self::SpeedSquare { .. } | Self::NormalMemory { .. } => "unlisted:contact",
            Self::EvenStiffness { .. } => "unlisted:structure",
            Self::ExciterMoment { .. } | Self::SecondForce { .. } => "unlisted:excitation",
            Self::QuadraticGain { .. } | Self::HighPass { .. } | Self::CrossTalk { .. } => {
                "unlisted:measurement"
            }
        }
    }

    /// Where it acts (m), where it has a place on the beam.
    #[must_use]
    pub fn position(&self) -> Option<f64> {
        match *self {
            Self::CubicStiffness { position_m, .. }
            | Self::QuadraticDamping { position_m, .. }
            | Self::AddedMass { position_m, .. }
            | Self::SecondSupport { position_m, .. }
            | Self::YieldingCubic { position_m, .. }
            | Self::PowerDamping { position_m, .. }
            | Self::RoundSupport { position_m, .. }
            | Self::RubbingSupport { position_m, .. }
            | Self::HyperbolicCubic { position_m, .. }
            | Self::SmoothSupport { position_m, .. }
            | Self::EvenStiffness { position_m, .. }
            | Self::SecondForce { position_m, .. } => Some(position_m),
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
            | Self::Offset { sensor, .. }
            | Self::LowPass { sensor, .. }
            | Self::ThirdHarmonicHum { sensor, .. }
            | Self::SoftClipping { sensor, .. }
            | Self::HeldDropout { sensor, .. }
            | Self::OffsetDrift { sensor, .. }
            | Self::TwoLowPasses { sensor, .. }
            | Self::OneSidedClipping { sensor, .. }
            | Self::SettlingOffset { sensor, .. }
            | Self::QuadraticGain { sensor, .. }
            | Self::HighPass { sensor, .. }
            | Self::CrossTalk { sensor, .. } => Some(sensor),
            _ => None,
        }
    }
}
