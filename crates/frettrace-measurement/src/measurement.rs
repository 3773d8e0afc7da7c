//! What the two kinds of file hold, as plain data (SI units).

/// Whether data were measured or simulated.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Source {
    /// From a laboratory.
    Measured,
    /// From a forward model.
    Simulated,
}

/// The declared beam.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Beam {
    /// Length \[m\].
    pub length: f64,
    /// Width \[m\].
    pub width: f64,
    /// Thickness, in the direction of vibration \[m\].
    pub thickness: f64,
    /// Young's modulus \[Pa\].
    pub youngs_modulus: f64,
    /// Density (kg/m³).
    pub density: f64,
    /// Area of the section \[m²\], where it is not `width · thickness` (tubes).
    pub area: Option<f64>,
    /// Second moment of area \[m⁴\], where it is not `width · thickness³/12` (tubes).
    pub second_moment: Option<f64>,
}

/// Modes measured with the friction removed.
#[derive(Clone, Debug, PartialEq)]
pub struct MeasuredModes {
    /// Natural frequencies \[Hz\].
    pub frequency: Vec<f64>,
    /// Their standard deviations \[Hz\]; empty where not given.
    pub frequency_std: Vec<f64>,
    /// Damping ratios.
    pub damping_ratio: Vec<f64>,
    /// Their standard deviations; empty where not given.
    pub damping_ratio_std: Vec<f64>,
}

/// How the contact face slips.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SlipKind {
    /// `u = lever_arm · θ(L, t)`.
    Rotation,
    /// `u = w(L, t)`.
    Transverse,
}

/// The friction support.
#[derive(Clone, Debug, PartialEq)]
pub struct Support {
    /// Position \[m\].
    pub position: f64,
    /// Kind of slip.
    pub slip: SlipKind,
    /// Lever arm \[m\]; 0 where the slip is transverse.
    pub lever_arm: f64,
    /// Stiffness of the support spring (N/m); infinite for a pinned end.
    pub normal_stiffness: f64,
    /// The declared friction law.
    pub law: String,
}

/// A further contact whose transverse force is unknown and wanted.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SecondSupport {
    /// Position \[m\].
    pub position: f64,
}

/// The exciter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Exciter {
    /// Position \[m\].
    pub position: f64,
}

/// The accelerometers.
#[derive(Clone, Debug, PartialEq)]
pub struct Sensors {
    /// Positions \[m\].
    pub position: Vec<f64>,
    /// Standard deviations of their noise (m/s²), where given.
    pub noise_std: Option<Vec<f64>>,
    /// Names, where given.
    pub name: Option<Vec<String>>,
}

/// One run.
#[derive(Clone, Debug, PartialEq)]
pub struct Run {
    /// Name of the run's group in the file (`0001`).
    pub id: String,
    /// Label.
    pub label: String,
    /// Sampling rate \[Hz\].
    pub sampling_rate: f64,
    /// Nominal excitation frequency \[Hz\].
    pub excitation_frequency: f64,
    /// Preload \[N\].
    pub preload: f64,
    /// Whether the contact was lubricated, where stated.
    pub lubricated: Option<bool>,
    /// Temperature \[K\], where stated.
    pub temperature: Option<f64>,
    /// Accelerations (m/s²), one vector of `n` samples a sensor.
    pub acceleration: Vec<Vec<f64>>,
    /// Excitation force \[N\], `n` samples.
    pub force: Vec<f64>,
}

/// A measurement file.
#[derive(Clone, Debug, PartialEq)]
pub struct Measurement {
    /// Title.
    pub title: String,
    /// Source.
    pub source: Source,
    /// Beam.
    pub beam: Beam,
    /// Measured modes, where given.
    pub modes: Option<MeasuredModes>,
    /// Friction support.
    pub support: Support,
    /// Declared second support, where there is one.
    pub second_support: Option<SecondSupport>,
    /// Exciter.
    pub exciter: Exciter,
    /// Sensors.
    pub sensors: Sensors,
    /// Runs, in the order of their names.
    pub runs: Vec<Run>,
}

/// Unit of the slip of a contact record.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SlipUnit {
    /// Metres.
    Metre,
    /// Radians.
    Radian,
}

/// One run of a contact record.
#[derive(Clone, Debug, PartialEq)]
pub struct ContactRun {
    /// Name of the run's group in the file.
    pub id: String,
    /// Label.
    pub label: String,
    /// Preload \[N\], where given.
    pub preload: Option<f64>,
    /// Time of each sample \[s\] (made from the sampling rate where the file gives one).
    pub time: Vec<f64>,
    /// Sampling rate \[Hz\], where sampling is uniform.
    pub sampling_rate: Option<f64>,
    /// Measured force \[N\].
    pub force: Vec<f64>,
    /// Slip \[m or rad\].
    pub slip_displacement: Vec<f64>,
    /// Slip velocity, where given.
    pub slip_velocity: Option<Vec<f64>>,
    /// Slip acceleration, where given.
    pub slip_acceleration: Option<Vec<f64>>,
    /// Normal force \[N\], where given.
    pub normal_force: Option<Vec<f64>>,
    /// Standard deviation of the noise of the force \[N\], where given.
    pub force_noise_std: Option<f64>,
}

/// A contact record: motion and force measured in the contact itself.
#[derive(Clone, Debug, PartialEq)]
pub struct ContactRecord {
    /// Title.
    pub title: String,
    /// Source.
    pub source: Source,
    /// The declared friction law.
    pub law: String,
    /// Unit of the slip.
    pub slip_unit: SlipUnit,
    /// Moving mass \[kg\]: `Some(NaN)` = unknown and wanted, `None` = no mass moves.
    pub moving_mass: Option<f64>,
    /// Runs.
    pub runs: Vec<ContactRun>,
}
