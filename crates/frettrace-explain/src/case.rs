//! What is declared: the rig, its runs, and how well its values are known.

use crate::support::set_means;
use crate::{ChannelFault, ExplainError, RunRecord, Split, Study, Unknown};
use frettrace_beam::{ModalModel, ModalOptions};
use frettrace_forward::accelerations::{
    AccelerationModel, Beside, COEFFICIENTS, Port, PortLaw, PortPlace, Quantity, Rig, Setting,
};
use frettrace_friction::effects::{Hook, ModifiedLaw};
use frettrace_identify::contact::Family;
use frettrace_identify::{Parameter, Prior, Transform};
use nalgebra::DMatrix;
use num_complex::Complex64;

/// Measured modes with their standard deviations.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct DeclaredModes {
    /// Natural frequencies (rad/s).
    pub frequency: Vec<f64>,
    /// Their standard deviations (rad/s).
    pub frequency_std: Vec<f64>,
    /// Damping ratios.
    pub damping: Vec<f64>,
    /// Their standard deviations.
    pub damping_std: Vec<f64>,
    /// How many of them were measured; the rest was added by [`Case::open_higher_modes`].
    pub measured: usize,
}

/// Everything an explanation starts from.
#[derive(Clone, Debug)]
pub struct Case {
    /// The rig.
    pub rig: Rig,
    /// The runs, reduced to lines.
    pub records: Vec<RunRecord>,
    /// Measured modes.
    pub modes: DeclaredModes,
    /// The declared law.
    pub law: Family,
    /// Faults of channels, mended in the runs.
    pub faults: Vec<ChannelFault>,
    /// Frequency (Hz) of a tone that the beam itself moves with and no declared force makes; it is taken out of the runs.
    pub shaken: Option<f64>,
    /// Ids of effects that are left out of the search.
    pub without: Vec<String>,
    /// Indices of runs that are neither fitted nor held out.
    pub aside: Vec<usize>,
}

/// Sizes of the motion in the contact, from which starting values and ranges are scaled.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Scales {
    /// Largest slip (m).
    pub slip: f64,
    /// Largest slip velocity (m/s).
    pub velocity: f64,
    /// Period of the excitation (s).
    pub period: f64,
    /// Mean preload of the runs (N).
    pub preload: f64,
    /// Length of the beam (m).
    pub length: f64,
    /// Mass of the beam (kg).
    pub mass: f64,
    /// Smallest part of the excitation's frequency that a periodic run moves at: weaker ones may not show it beside their noise.
    pub subharmonic: usize,
}

/// A positive unknown of the law, fitted in its logarithm.
#[must_use]
pub fn positive(hook: Hook, low: f64, high: f64) -> Unknown {
    let (name, unit) = hook.name_and_unit();
    Unknown { quantity: Quantity::Law(hook), parameter: Parameter::positive(name, unit, (low, high)) }
}

/// An unknown that may have either sign, with a typical size.
#[must_use]
pub fn signed(quantity: Quantity, (name, unit): (&str, &str), scale: f64, bounds: (f64, f64)) -> Unknown {
    Unknown {
        quantity,
        parameter: Parameter {
            name: name.to_owned(),
            unit: unit.to_owned(),
            transform: Transform::Linear { scale },
            bounds,
            prior: None,
            experiment: String::new(),
        },
    }
}

/// Smallest relative standard deviations that a declared frequency and damping ratio may claim: a clamp is never
/// tightened twice alike, and a free decay gives damping to some tenth of a per cent at best.
const LEAST_STD: [f64; 2] = [2e-6, 5e-4];
/// Relative standard deviation of a natural frequency that was not measured.
const UNMEASURED: f64 = 1e-3;

/// Bounds a declared value by five standard deviations: beyond them the declaration itself is wrong, and that is an
/// effect with a name, not a calibration.
fn within(mut parameter: Parameter) -> Parameter {
    if let Some(prior) = parameter.prior {
        parameter.bounds = (prior.mean - 5.0 * prior.std, prior.mean + 5.0 * prior.std);
    }
    parameter
}

/// Fewest sensors whose amplitudes tell a motion from hum: it has three unknown shares.
const LEAST_TOLD: usize = 5;
/// Share of the power of a tone that a motion leaves beside its three shares, …
const UNSHAPED: f64 = 1e-2;
/// … and the factor by which one amplitude for all sensors must leave more.
const UNLIKE: f64 = 10.0;

/// Frequency (Hz), amplitude (m/s²) and phase (rad) of hum.
fn hum(fault: &ChannelFault) -> Option<[f64; 3]> {
    let value = |name: &str| fault.parameters.iter().find(|(own, ..)| own == name).map(|found| found.2);
    if fault.id != "measurement.hum" {
        return None;
    }
    Some([value("frequency")?, value("amplitude")?, value("phase")?])
}

/// Whether amplitudes at places along the beam are those of a motion.
fn is_motion(heard: &[(f64, Complex64)], length: f64) -> bool {
    if heard.len() < LEAST_TOLD {
        return false;
    }
    let parts = DMatrix::from_fn(heard.len(), 2, |row, column| {
        let amplitude = heard[row].1;
        if column == 0 { amplitude.re } else { amplitude.im }
    });
    let left_by = |powers: &[i32]| {
        let shapes = DMatrix::from_fn(heard.len(), powers.len(), |row, column| {
            (heard[row].0 / length).powi(powers[column])
        });
        let fitted = shapes.clone().svd(true, true).solve(&parts, 1e-9);
        fitted.map_or(f64::INFINITY, |shares| (&parts - shapes * shares).norm_squared())
    };
    let moved = left_by(&[2, 3, 4]).max(1e-6 * parts.norm_squared());
    moved < UNSHAPED * parts.norm_squared() && left_by(&[0]) > UNLIKE * moved
}

/// Relative standard deviation of the natural frequencies that nobody measured: the declared beam's own are exact by
/// declaration, a clamp and a support move them by some tenths of a per cent.
const HIGHER_FREQUENCY: f64 = 1e-3;
/// Relative standard deviation of damping ratios that nobody measured, from the last measured one.
const HIGHER_DAMPING: f64 = 0.4;
/// Damping ratio where none was measured, and its relative standard deviation: bolted metal beams have 0.1 to 1 %.
const UNKNOWN_DAMPING: (f64, f64) = (5e-3, 0.6);
/// Most modes that have values of their own.
const MOST_MODES: usize = 14;

impl Case {
    /// Whether the effect may be looked for.
    pub(crate) fn allows(&self, id: &str) -> bool {
        self.without.iter().all(|left_out| left_out != id)
    }

    /// The declared model at declared values, with a friction law to start from.
    #[must_use]
    pub fn setting(&self, law: ModifiedLaw<f64>) -> Setting {
        let DeclaredModes { frequency, damping, .. } = self.modes.clone();
        let setting = Setting::new(frequency, damping, law, self.rig.sensors.len());
        Setting { rigid: self.law.is_static(), ..setting }
    }

    /// Opens the modes of the declared beam beyond the measured ones up to the highest line: nobody measured them, and
    /// harmonics of the contact force reach them.
    ///
    /// Their frequencies are the declared beam's within `HIGHER_FREQUENCY`, their damping ratios the last measured one's
    /// within `HIGHER_DAMPING`; where nothing was measured, a metal beam's with joints, `UNKNOWN_DAMPING`.
    ///
    /// # Errors
    /// [`ExplainError::Model`] where the declared beam is out of range.
    pub fn open_higher_modes(&mut self) -> Result<(), ExplainError> {
        self.modes.measured = self.modes.frequency.len();
        let highest = self.records.iter().map(|r| r.lines.order() as f64 * r.lines.omega).fold(0.0, f64::max);
        let options = ModalOptions { modes: MOST_MODES, ..ModalOptions::default() };
        let beam = ModalModel::new(&self.rig.beam, &self.rig.boundary, &options)
            .map_err(frettrace_forward::accelerations::AccelerationError::from)?;
        let (damping, share) = match self.modes.damping.last() {
            Some(&last) => (last, HIGHER_DAMPING),
            None => UNKNOWN_DAMPING,
        };
        let known = self.modes.measured.max(self.modes.damping.len());
        for &frequency in beam.natural_frequency().iter().skip(known).take_while(|f| **f < highest) {
            self.modes.frequency.push(frequency);
            self.modes.frequency_std.resize(self.modes.frequency.len() - 1, 1e-3 * frequency);
            self.modes.frequency_std.push(HIGHER_FREQUENCY * frequency);
            self.modes.damping.push(damping);
            self.modes.damping_std.resize(self.modes.damping.len() - 1, 0.1 * damping);
            self.modes.damping_std.push(share * damping);
        }
        Ok(())
    }

    /// Tells hum that every sensor hears from a motion of the beam: with `x` the distance from the clamp, motion follows `x²`, `x³` and `x⁴`
    /// to a tenth, and hum in all channels either follows nothing or is the same in all.
    pub fn tell_motion_from_hum(&mut self) {
        let mut frequencies: Vec<f64> =
            self.faults.iter().filter_map(hum).map(|[frequency, ..]| frequency).collect();
        frequencies.dedup();
        for frequency in frequencies {
            let of_it = |fault: &ChannelFault| hum(fault).filter(|[own, ..]| *own == frequency);
            let heard = self.faults.iter().filter_map(|fault| Some((fault.sensor, of_it(fault)?)));
            let heard: Vec<(f64, Complex64)> = heard
                .filter_map(|(sensor, [_, amplitude, phase])| {
                    Some((*self.rig.sensors.get(sensor)?, Complex64::from_polar(amplitude, phase)))
                })
                .collect();
            if 2 * heard.len() > self.rig.sensors.len() && is_motion(&heard, self.rig.beam.length) {
                self.faults.retain(|fault| of_it(fault).is_none());
                self.shaken = Some(frequency);
            }
        }
    }

    /// Takes a declared second support into the rig: its force is recovered from the accelerations, without a law, and is an
    /// input of every prediction. Where the structure is known loosely it is calibrated first, with the forces of contact and support free:
    /// a structure that is off makes a force that is off, and every law would be blamed for it.
    ///
    /// # Errors
    /// [`ExplainError::Model`] where the rig cannot be modelled.
    pub fn know_support(&mut self, position: f64) -> Result<(), ExplainError> {
        let mut setting = self.setting(ModifiedLaw::dahl(1.0, 1.0));
        let place = PortPlace::At(position);
        setting.ports.push(Port { place, law: PortLaw::Polynomial, coefficients: [0.0; COEFFICIENTS] });
        if self.loosely_known()
            && let Ok((study, _)) = Study::new(self, Split::First)
        {
            setting = study.calibrated_beside(&setting, Beside::Ports);
        }
        let lines = self.records.iter().map(|r| r.lines.clone()).collect();
        let model = AccelerationModel::new(self.rig.clone(), lines)?;
        let runs: Vec<usize> = (0..self.records.len()).collect();
        for (record, found) in
            self.records.iter_mut().zip(model.balance_beside(&setting, &runs, Beside::Ports)?)
        {
            record.lines.known_force = found.beside.into_iter().next().unwrap_or_default();
        }
        set_means(self.records.iter_mut().map(|record| &mut record.lines));
        self.rig.known_support = Some(position);
        Ok(())
    }

    /// What the declared model leaves open: the structure within its standard deviations, and the law.
    #[must_use]
    pub fn unknowns(&self) -> Vec<Unknown> {
        let mut unknowns = self.structure_unknowns();
        unknowns.extend(self.law_unknowns());
        unknowns
    }

    fn structure_unknowns(&self) -> Vec<Unknown> {
        let modes = &self.modes;
        let mut unknowns = Vec::new();
        let std = |given: &[f64], n: usize, value: f64, least: f64, otherwise: f64| {
            given.get(n).map_or(otherwise * value, |s| s.max(least * value))
        };
        for (n, (&frequency, &damping)) in modes.frequency.iter().zip(&modes.damping).enumerate() {
            let width = std(&modes.frequency_std, n, frequency, LEAST_STD[0], UNMEASURED);
            let prior = Prior { mean: frequency, std: width };
            let parameter = within(Parameter::declared(&format!("frequency_{}", n + 1), "rad/s", prior));
            unknowns.push(Unknown { quantity: Quantity::ModeFrequency(n), parameter });
            let width = std(&modes.damping_std, n, damping, LEAST_STD[1], 0.1);
            let prior = Prior { mean: damping, std: width };
            let mut parameter = within(Parameter::declared(&format!("damping_{}", n + 1), "1", prior));
            parameter.bounds.0 = parameter.bounds.0.max(1e-2 * damping);
            unknowns.push(Unknown { quantity: Quantity::ModeDamping(n), parameter });
        }
        unknowns.push(Unknown {
            quantity: Quantity::ContactCompliance,
            parameter: within(Parameter::declared(
                "contact_compliance",
                "m/N",
                Prior { mean: 0.0, std: self.local_compliance() },
            )),
        });
        unknowns
    }

    /// Static compliance that modes beyond the twentieth lend to the contact: how far a local compliance is unknown.
    fn local_compliance(&self) -> f64 {
        let options = ModalOptions { modes: 20, ..ModalOptions::default() };
        let Ok(model) = ModalModel::new(&self.rig.beam, &self.rig.boundary, &options) else { return 1e-12 };
        let end = self.rig.beam.length;
        let (dof, lever) = match self.rig.lever {
            Some(lever) => (frettrace_beam::Dof::rotation(end), lever),
            None => (frettrace_beam::Dof::displacement(end), 1.0),
        };
        model.residual(dof, dof).abs() * lever * lever
    }

    /// The same with no natural frequency known better than to a thousandth, as where none was measured.
    pub(crate) fn loosened(&self) -> Self {
        let mut case = self.clone();
        let DeclaredModes { frequency, frequency_std, .. } = &mut case.modes;
        frequency_std
            .iter_mut()
            .zip(frequency)
            .for_each(|(std, frequency)| *std = std.max(UNMEASURED * *frequency));
        case
    }

    /// Whether a natural frequency is known to no better than 5e-5: then a tenth of a resonance's width, and a law fitted on
    /// the declared values may be far off through no fault of its own.
    pub(crate) fn loosely_known(&self) -> bool {
        let modes = &self.modes;
        let loose = |n: usize| modes.frequency_std.get(n).is_none_or(|s| *s > 5e-5 * modes.frequency[n]);
        modes.measured == 0 || (0..modes.measured.min(modes.frequency.len())).any(loose)
    }

    fn law_unknowns(&self) -> Vec<Unknown> {
        let mut unknowns = vec![positive(Hook::Sigma0, 1.0, 1e12), positive(Hook::MuKinetic, 1e-4, 20.0)];
        if matches!(self.law, Family::Stribeck | Family::LuGre | Family::Hybrid) {
            unknowns.push(positive(Hook::StribeckRise, 1e-5, 20.0));
            unknowns.push(positive(Hook::StribeckVelocity, 1e-7, 100.0));
            unknowns.push(positive(Hook::StribeckExponent, 0.3, 6.0));
            unknowns.push(signed(
                Quantity::Law(Hook::Viscous),
                ("sigma2", "N·s/m"),
                1.0,
                (0.0, f64::INFINITY),
            ));
        }
        if matches!(self.law, Family::LuGre | Family::Hybrid) {
            unknowns.push(signed(Quantity::Law(Hook::Sigma1), ("sigma1", "s/m"), 1.0, (0.0, f64::INFINITY)));
            unknowns.push(positive(Hook::DampingVelocity, 1e-7, 100.0));
        }
        if self.law == Family::Hybrid {
            unknowns.push(signed(Quantity::Law(Hook::Breakaway), ("breakaway", "1"), 0.1, (0.0, 0.95)));
        }
        unknowns
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A cantilever's first mode, `cosh βx − cos βx − 0.7341 (sinh βx − sin βx)` with `βL = 1.8751` (Blevins 1979), with every third amplitude a
    /// hundredth off, is a motion; the same amplitude in all sensors, and any amplitudes, are none.
    #[test]
    fn hum_is_told_from_motion() {
        let at = |share: f64| (1 + (share * 30.0) as usize % 3) as f64;
        let first = |share: f64| {
            let b = 1.8751 * share;
            b.cosh() - b.cos() - 0.7341 * (b.sinh() - b.sin())
        };
        let places: Vec<f64> = (2..=9).map(|k| 0.1 * f64::from(k)).collect();
        let heard = |of: &dyn Fn(f64) -> Complex64| -> Vec<(f64, Complex64)> {
            places.iter().map(|&x| (x, of(x))).collect()
        };
        let moved = heard(&|x| Complex64::from_polar(first(x) * if at(x) == 1.0 { 1.01 } else { 1.0 }, 0.7));
        assert!(is_motion(&moved, 1.0));
        assert!(!is_motion(&heard(&|_| Complex64::new(0.3, 0.1)), 1.0));
        let random = heard(&|x| Complex64::from_polar(0.7 + 0.3 * (37.0 * x).sin(), 50.0 * x));
        assert!(!is_motion(&random, 1.0));
        assert!(!is_motion(&moved[..4], 1.0));
    }
}
