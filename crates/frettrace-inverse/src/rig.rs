//! What the inverse is told: the rig and its runs. No file and no friction law is seen here.

use frettrace_beam::ModalModel;

/// How the contact face slips.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Slip {
    /// `u = lever_arm · θ(L, t)`.
    Rotation {
        /// Lever arm (m).
        lever_arm: f64,
    },
    /// `u = w(L, t)`.
    Transverse,
}

/// What is declared about one mode: the values stand in the structure, here is how far they are trusted.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ModeTrust {
    /// Relative standard deviation of the natural frequency.
    pub frequency: f64,
    /// Relative standard deviation of the damping ratio.
    pub damping: f64,
}

/// An accelerometer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sensor {
    /// Position (m).
    pub position: f64,
    /// Standard deviation of its noise (m/s²), where declared.
    pub noise_std: Option<f64>,
}

/// The rig as it is declared.
#[derive(Clone, Debug)]
pub struct Rig {
    /// The beam on its linear support, with the measured modes in place.
    pub structure: ModalModel,
    /// Trust in the first modes; those beyond keep their values.
    pub trust: Vec<ModeTrust>,
    /// How many modes the beam theory holds for: those whose half wavelength is at least some thicknesses. The flexibility of
    /// the others, which matters in the contact alone and which no accelerometer sees, is trusted little.
    pub beam_modes: usize,
    /// How the contact at the end slips.
    pub slip: Slip,
    /// Stiffness of the linear normal support (N/m); 0 where there is none.
    pub normal_stiffness: f64,
    /// Position of a declared second support (m).
    pub second_support: Option<f64>,
    /// Position of the exciter (m).
    pub exciter: f64,
    /// The accelerometers.
    pub sensors: Vec<Sensor>,
}

/// One run. All channels have the same number of samples.
#[derive(Clone, Debug)]
pub struct RunData<'a> {
    /// Name.
    pub id: &'a str,
    /// Sampling rate (Hz).
    pub sampling_rate: f64,
    /// Nominal excitation frequency (Hz).
    pub excitation_frequency: f64,
    /// Preload (N).
    pub preload: f64,
    /// Excitation force (N).
    pub force: &'a [f64],
    /// Accelerations (m/s²), one slice a sensor.
    pub accelerations: Vec<&'a [f64]>,
}

/// Which form the answer takes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum FormChoice {
    /// By evidence.
    #[default]
    Auto,
    /// Lines at multiples of the excitation frequency.
    Harmonic,
    /// Lines at multiples of a fraction of the excitation frequency; the order by evidence, at least two.
    Subharmonic,
    /// No lines but the exciter's: the whole spectrum is balanced, bin by bin.
    Aperiodic,
}

/// Options of a reconstruction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Options {
    /// Form.
    pub form: FormChoice,
    /// Whether the structure is calibrated on the balance residual.
    pub calibrate: bool,
    /// Whether the friction force of periodic runs is a periodic smoothing spline through its lines.
    pub splines: bool,
}

impl Default for Options {
    fn default() -> Self {
        Self { form: FormChoice::Auto, calibrate: true, splines: false }
    }
}
