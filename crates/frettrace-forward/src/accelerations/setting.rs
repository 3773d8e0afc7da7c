//! What the model is made of: the declared rig and the values of everything that may be fitted.

use super::phase::FrequencyRatio;
use super::ports::{COEFFICIENTS, PortLaw};
use super::run::RunLines;
use frettrace_beam::{BeamError, Boundary, ModalModel, ModalOptions, UniformBeam};
use frettrace_friction::effects::{Hook, ModifiedLaw};
use num_complex::Complex64;
use std::sync::Arc;

/// The declared rig.
#[derive(Clone, Debug, PartialEq)]
pub struct Rig {
    /// The beam.
    pub beam: UniformBeam,
    /// Its ends with the friction removed; the support spring is finite.
    pub boundary: Boundary,
    /// Position of the exciter (m).
    pub exciter: f64,
    /// Positions of the sensors (m).
    pub sensors: Vec<f64>,
    /// Lever arm (m) where the contact turns with the end; `None` where it slides with it.
    pub lever: Option<f64>,
    /// Position of a second support whose force is known from elsewhere (m).
    pub known_support: Option<f64>,
    /// Modes summed; the rest acts through its static flexibility.
    pub modes: usize,
}

impl Rig {
    /// The beam on the given ends, without measured values.
    pub(super) fn declared(&self, boundary: &Boundary) -> Result<ModalModel, BeamError> {
        ModalModel::new(&self.beam, boundary, &ModalOptions { modes: self.modes, ..ModalOptions::default() })
    }
}

/// Where a port acts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PortPlace {
    /// Transverse displacement at a position (m).
    At(f64),
    /// Rotation at a position (m): the port's force is a moment (N·m).
    Turn(f64),
    /// The support itself: the transverse displacement of the end, with the contact's normal force.
    Support,
    /// A modal coordinate.
    Mode(usize),
}

/// A memoryless force on the structure.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Port {
    /// Where it acts.
    pub place: PortPlace,
    /// Its law.
    pub law: PortLaw,
    /// Coefficients of the law.
    pub coefficients: [f64; COEFFICIENTS],
}

/// How a sensor distorts what it measures.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SensorSetting {
    /// Gain.
    pub gain: f64,
    /// Delay (s).
    pub delay: f64,
    /// Distance from the declared position (m).
    pub shift: f64,
    /// Time by which a low pass is late at low frequencies (s): its time constant, that of all its stages together.
    pub lag: f64,
    /// Equal stages of first order that it has.
    pub stages: f64,
    /// Offset (m/s²).
    pub offset: f64,
}

impl Default for SensorSetting {
    fn default() -> Self {
        Self { gain: 1.0, delay: 0.0, shift: 0.0, lag: 0.0, stages: 1.0, offset: 0.0 }
    }
}

impl SensorSetting {
    /// `g e^{−iωd}/(1 + iωτ/n)ⁿ` at an angular frequency (rad/s): what the channel makes of a line.
    pub(super) fn response(&self, omega: f64) -> Complex64 {
        let late = Complex64::from_polar(self.gain, -omega * self.delay);
        let stage = self.stage(omega);
        late / if self.stages == 1.0 { stage } else { stage.powf(self.stages) }
    }

    /// `1 + iωτ/n`, by which one stage of the low pass divides.
    pub(super) fn stage(&self, omega: f64) -> Complex64 {
        Complex64::new(1.0, omega * self.lag / self.stages)
    }
}

/// A value of the model that may be fitted.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Quantity {
    /// Natural frequency of a measured mode (rad/s).
    ModeFrequency(usize),
    /// Damping ratio of a measured mode.
    ModeDamping(usize),
    /// Relative change of all natural frequencies, those that nobody measured among them.
    FrequencyScale,
    /// Relative change of all damping ratios.
    DampingScale,
    /// Hook of the friction law.
    Law(Hook),
    /// Coefficient of a port.
    Port(usize, usize),
    /// Position of a port (m).
    PortPosition(usize),
    /// Mass added to the beam (kg).
    AddedMass,
    /// Its position (m).
    MassPosition,
    /// Rotational compliance of the clamp over that of the beam, `EI/(k_c L)`.
    ClampCompliance,
    /// Relative change of all natural frequencies from the first run to the last.
    Drift,
    /// Rate `k` at which a drift settles, see [`Setting::drift_course`].
    DriftRate,
    /// Slowing `m` of that.
    DriftSlowing,
    /// Local compliance of the contact beside that of the modes (m/N).
    ContactCompliance,
    /// Motion of the base per excitation force at the same line, real part (m/N).
    BaseReal,
    /// The same, imaginary part.
    BaseImaginary,
    /// Gain of a sensor.
    Gain(usize),
    /// Delay of a sensor (s).
    Delay(usize),
    /// Time constant of a sensor's low pass (s).
    Lag(usize),
    /// Distance of a sensor from its declared position (m).
    Shift(usize),
    /// Distance of all sensors from their declared positions (m).
    CommonShift,
    /// Offset of a sensor (m/s²).
    Offset(usize),
}

impl Quantity {
    /// Whether it is a place along the beam where something acts.
    #[must_use]
    pub fn is_place(self) -> bool {
        matches!(self, Self::PortPosition(_) | Self::MassPosition)
    }
}

/// All values of the model.
#[derive(Clone, Debug, PartialEq)]
pub struct Setting {
    /// Natural frequencies of the measured modes (rad/s).
    pub frequency: Vec<f64>,
    /// Their damping ratios.
    pub damping: Vec<f64>,
    /// Relative change of all natural frequencies and of all damping ratios, those that nobody measured among them.
    pub frequency_scale: f64,
    /// See `frequency_scale`.
    pub damping_scale: f64,
    /// The friction law.
    pub law: ModifiedLaw<f64>,
    /// Whether the bristle is rigid where the law has no presliding range of its own: friction is then set-valued at rest,
    /// and the law's stiffness is not used.
    pub rigid: bool,
    /// Frequency with which the preload is modulated.
    pub modulation: FrequencyRatio,
    /// Memoryless forces on the structure.
    pub ports: Vec<Port>,
    /// Displacement (m) in every run of the port of the given index that the mean of the friction makes: friction that is not overcome keeps
    /// one of its history's, which no accelerometer sees and no law of the period knows, and a stop feels where that holds the beam. Empty
    /// where the law's own mean is believed.
    pub rests: (usize, Vec<f64>),
    /// Deflection of the contact (in units of the friction coefficient) with which the period of each run begins, where that has not settled: a
    /// bristle that is elastic up to its breakaway keeps what it came to, or creeps from it for thousands of periods. No value, or none at
    /// all, where it has settled.
    pub deflections: Vec<Option<f64>>,
    /// Added mass (kg) and its position (m).
    pub mass: Option<[f64; 2]>,
    /// Rotational compliance of the clamp, `EI/(k_c L)`.
    pub clamp_compliance: f64,
    /// Relative change of all natural frequencies from the first run to the last.
    pub drift: f64,
    /// Rate `k ≥ 0` and slowing `m ≥ 0` of its course: by `p` of the runs `G(p)/G(1)` of it has come, `G(p) = 1 − (1 + m k p)^(−1/m)`.
    /// Steady for `k = 0`; with `m` it goes from an exponential (`m → 0`, warming) over a rational course (`m = 1`) to a logarithmic
    /// one (`m ≫ 1`, bolts that relax).
    pub drift_course: [f64; 2],
    /// Local compliance of the contact beside that of the modes (m/N).
    pub contact_compliance: f64,
    /// Motion of the base, real and imaginary part: per excitation force (m/N), or an acceleration (m/s²) on one line.
    pub base: Option<[f64; 2]>,
    /// The line on which the clamp has an acceleration of its own, in phase with the excitation; `None` where its motion follows
    /// the excitation on every line.
    pub base_line: Option<FrequencyRatio>,
    /// Lines of the motion of the base in every run (m), known from elsewhere; `base` is then a factor on them.
    pub base_motion: Option<Arc<Vec<Vec<Complex64>>>>,
    /// Sensors.
    pub sensors: Vec<SensorSetting>,
    /// Distance of all sensors from their declared positions (m), beside their own.
    pub shift: f64,
}

/// Share of a drift that has come by `progress` between the first run (0) and the last (1), see [`Setting::drift_course`].
pub(super) fn course([rate, slowing]: [f64; 2], progress: f64) -> f64 {
    let slowing = slowing.max(LEAST_SLOWING);
    let come = |p: f64| -(-(slowing * rate * p).ln_1p() / slowing).exp_m1();
    if rate.abs() < STEADY { progress } else { come(progress) / come(1.0) }
}

/// Rate below which a drift is steady: its course is off a straight line by `k(1 + m)/8` at half time.
const STEADY: f64 = 1e-9;
/// Slowing below which a course is the exponential one to rounding.
const LEAST_SLOWING: f64 = 1e-6;

impl Setting {
    /// Nothing but the modes (natural frequencies in rad/s, damping ratios) and a friction law that yields, read by sound sensors.
    #[must_use]
    pub fn new(frequency: Vec<f64>, damping: Vec<f64>, law: ModifiedLaw<f64>, sensors: usize) -> Self {
        Self {
            frequency,
            damping,
            frequency_scale: 0.0,
            damping_scale: 0.0,
            law,
            rigid: false,
            modulation: FrequencyRatio::ONE,
            ports: Vec::new(),
            rests: (0, Vec::new()),
            deflections: Vec::new(),
            mass: None,
            clamp_compliance: 0.0,
            drift: 0.0,
            drift_course: [0.0; 2],
            shift: 0.0,
            contact_compliance: 0.0,
            base: None,
            base_line: None,
            base_motion: None,
            sensors: vec![SensorSetting::default(); sensors],
        }
    }

    /// Whether friction is set-valued at rest.
    #[must_use]
    pub fn holds_rigidly(&self) -> bool {
        self.rigid && !self.law.yields()
    }

    /// Motion of the base on a line of a run for a unit value of `base`.
    pub(super) fn clamp_unit(&self, lines: &RunLines, (run, line): (usize, usize)) -> Complex64 {
        match &self.base_motion {
            Some(known) => known.get(run).and_then(|l| l.get(line)).copied().unwrap_or_default(),
            None => lines.clamp_unit(self.base_line, line),
        }
    }

    /// The value of a quantity; `None` where the model does not hold it.
    #[must_use]
    pub fn get(&self, quantity: Quantity) -> Option<f64> {
        let sensor = |k: usize| self.sensors.get(k);
        match quantity {
            Quantity::ModeFrequency(n) => self.frequency.get(n).copied(),
            Quantity::ModeDamping(n) => self.damping.get(n).copied(),
            Quantity::FrequencyScale => Some(self.frequency_scale),
            Quantity::DampingScale => Some(self.damping_scale),
            Quantity::Law(hook) => self.law.get(hook),
            Quantity::Port(p, k) => self.ports.get(p).and_then(|port| port.coefficients.get(k).copied()),
            Quantity::PortPosition(p) => self.ports.get(p).and_then(|port| match port.place {
                PortPlace::At(position) => Some(position),
                _ => None,
            }),
            Quantity::AddedMass => self.mass.map(|m| m[0]),
            Quantity::MassPosition => self.mass.map(|m| m[1]),
            Quantity::ClampCompliance => Some(self.clamp_compliance),
            Quantity::CommonShift => Some(self.shift),
            Quantity::Drift => Some(self.drift),
            Quantity::DriftRate => Some(self.drift_course[0]),
            Quantity::DriftSlowing => Some(self.drift_course[1]),
            Quantity::ContactCompliance => Some(self.contact_compliance),
            Quantity::BaseReal => self.base.map(|b| b[0]),
            Quantity::BaseImaginary => self.base.map(|b| b[1]),
            Quantity::Gain(k) => sensor(k).map(|s| s.gain),
            Quantity::Delay(k) => sensor(k).map(|s| s.delay),
            Quantity::Lag(k) => sensor(k).map(|s| s.lag),
            Quantity::Shift(k) => sensor(k).map(|s| s.shift),
            Quantity::Offset(k) => sensor(k).map(|s| s.offset),
        }
    }

    /// Takes back what gives a quantity its meaning: a hook of the law, the added mass, a fault of a sensor, … `false`, and nothing done,
    /// for what every model has (modes, the contact's compliance) and for ports that others stand behind.
    pub fn clear(&mut self, quantity: Quantity) -> bool {
        let sensor = |sensors: &mut Vec<SensorSetting>, k: usize, clear: fn(&mut SensorSetting)| {
            sensors.get_mut(k).into_iter().for_each(clear);
        };
        match quantity {
            Quantity::ModeFrequency(_) | Quantity::ModeDamping(_) | Quantity::ContactCompliance => {
                return false;
            }
            Quantity::FrequencyScale => self.frequency_scale = 0.0,
            Quantity::DampingScale => self.damping_scale = 0.0,
            Quantity::Law(hook) => self.law.clear(hook),
            Quantity::Port(p, _) | Quantity::PortPosition(p) if p + 1 < self.ports.len() => return false,
            Quantity::Port(p, _) | Quantity::PortPosition(p) => {
                self.ports.truncate(p);
                if self.rests.0 >= p {
                    self.rests.1.clear();
                }
            }
            Quantity::AddedMass | Quantity::MassPosition => self.mass = None,
            Quantity::ClampCompliance => self.clamp_compliance = 0.0,
            Quantity::CommonShift => self.shift = 0.0,
            Quantity::Drift => self.drift = 0.0,
            Quantity::DriftRate => self.drift_course[0] = 0.0,
            Quantity::DriftSlowing => self.drift_course[1] = 0.0,
            Quantity::BaseReal | Quantity::BaseImaginary => {
                (self.base, self.base_line, self.base_motion) = (None, None, None);
            }
            Quantity::Gain(k) => sensor(&mut self.sensors, k, |s| s.gain = 1.0),
            Quantity::Delay(k) => sensor(&mut self.sensors, k, |s| s.delay = 0.0),
            Quantity::Lag(k) => sensor(&mut self.sensors, k, |s| (s.lag, s.stages) = (0.0, 1.0)),
            Quantity::Shift(k) => sensor(&mut self.sensors, k, |s| s.shift = 0.0),
            Quantity::Offset(k) => sensor(&mut self.sensors, k, |s| s.offset = 0.0),
        }
        true
    }

    /// Sets a quantity; one the model does not hold is left alone.
    pub fn set(&mut self, quantity: Quantity, value: f64) {
        let place = match quantity {
            Quantity::Law(hook) => {
                self.law.set(hook, value);
                None
            }
            Quantity::ModeFrequency(n) => self.frequency.get_mut(n),
            Quantity::ModeDamping(n) => self.damping.get_mut(n),
            Quantity::FrequencyScale => Some(&mut self.frequency_scale),
            Quantity::DampingScale => Some(&mut self.damping_scale),
            Quantity::Port(p, k) => self.ports.get_mut(p).and_then(|port| port.coefficients.get_mut(k)),
            Quantity::PortPosition(p) => self.ports.get_mut(p).and_then(|port| match &mut port.place {
                PortPlace::At(position) => Some(position),
                _ => None,
            }),
            Quantity::AddedMass => self.mass.as_mut().map(|m| &mut m[0]),
            Quantity::MassPosition => self.mass.as_mut().map(|m| &mut m[1]),
            Quantity::ClampCompliance => Some(&mut self.clamp_compliance),
            Quantity::CommonShift => Some(&mut self.shift),
            Quantity::Drift => Some(&mut self.drift),
            Quantity::DriftRate => Some(&mut self.drift_course[0]),
            Quantity::DriftSlowing => Some(&mut self.drift_course[1]),
            Quantity::ContactCompliance => Some(&mut self.contact_compliance),
            Quantity::BaseReal => self.base.as_mut().map(|b| &mut b[0]),
            Quantity::BaseImaginary => self.base.as_mut().map(|b| &mut b[1]),
            Quantity::Gain(k) => self.sensors.get_mut(k).map(|s| &mut s.gain),
            Quantity::Delay(k) => self.sensors.get_mut(k).map(|s| &mut s.delay),
            Quantity::Lag(k) => self.sensors.get_mut(k).map(|s| &mut s.lag),
            Quantity::Shift(k) => self.sensors.get_mut(k).map(|s| &mut s.shift),
            Quantity::Offset(k) => self.sensors.get_mut(k).map(|s| &mut s.offset),
        };
        if let Some(place) = place {
            *place = value;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Half-way values: steady 1/2; exponential of rate 4, (1 − e⁻²)/(1 − e⁻⁴) = 0.880797; rational of rate 3,
    /// (1.5/2.5)/(3/4) = 0.8; logarithmic of m k = 8, which m = 10⁴ meets to 10⁻⁴: ln 5/ln 9 = 0.732487. All end at 1.
    #[test]
    fn drifts_settle_as_they_should() {
        let cases = [
            ([0.0, 1.0], 0.5, 1e-12),
            ([4.0, 0.0], 0.880_797, 1e-6),
            ([3.0, 1.0], 0.8, 1e-12),
            ([8e-4, 1e4], 0.732_487, 1e-4),
        ];
        for (shape, half, accuracy) in cases {
            let found = course(shape, 0.5);
            assert!((found - half).abs() < accuracy, "{shape:?}: {found}");
            assert!(course(shape, 0.0).abs() < 1e-15 && (course(shape, 1.0) - 1.0).abs() < 1e-12);
        }
    }
}
