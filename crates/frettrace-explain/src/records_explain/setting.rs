//! What is fitted, and how values become a law with what acts beside it.

use super::{MovingMass, RecordCase, RecordScales};
use frettrace_friction::Scalar;
use frettrace_friction::effects::{Hook, ModifiedLaw};
use frettrace_identify::contact::{Family, Guess};
use frettrace_identify::{Parameter, Prior, Transform};

/// What an unknown of a contact record sets.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RecordQuantity {
    /// A parameter of the law or of an effect inside it.
    Law(Hook),
    /// Half the play in series with the contact: the force rests at zero while it is crossed (m).
    Gap,
    /// Mass that moves with the contact (kg).
    Mass,
    /// Constant part of the force (N).
    Offset,
    /// Part of the force in proportion to the load (1).
    LoadOffset,
    /// Load of the contact beside the stated one, as of a seal that is squeezed in its groove (N).
    Squeeze,
    /// Time by which the force is recorded late against the motion (s).
    Delay,
}

/// An unknown with its value.
#[derive(Clone, Debug, PartialEq)]
pub struct RecordUnknown {
    /// What it sets.
    pub quantity: RecordQuantity,
    /// Name, unit, bounds.
    pub parameter: Parameter,
    /// Its value.
    pub value: f64,
}

/// A law with all unknowns.
#[derive(Clone, Debug)]
pub struct RecordSetting {
    /// The law; hooks that are unknown take their values from the unknowns.
    pub law: ModifiedLaw<f64>,
    /// What is fitted.
    pub unknowns: Vec<RecordUnknown>,
    /// Mass that is known (kg).
    pub known_mass: f64,
    /// Load the exponents of the normal force refer to (N).
    pub reference_load: f64,
    /// Position that position dependence counts from (m).
    pub middle: f64,
}

/// What acts beside the law.
#[derive(Clone, Copy, Debug)]
pub(super) struct Beside<T> {
    pub gap: Option<T>,
    pub mass: T,
    pub offset: T,
    pub load_offset: T,
    pub delay: Option<T>,
    pub squeeze: T,
}

impl RecordSetting {
    /// The declared law with values read off the loops, and the nuisances.
    pub(super) fn declared(case: &RecordCase, guess: &Guess, scales: &RecordScales) -> Self {
        let values = guess.parameters(case.law);
        let stiff = 50.0 * guess.mu / scales.slip;
        let sigma0 = if case.law.is_static() { stiff } else { guess.sigma0 };
        let mut setting = Self {
            law: ModifiedLaw::dahl(sigma0, guess.mu),
            unknowns: Vec::new(),
            known_mass: if let MovingMass::Known(mass) = case.mass { mass } else { 0.0 },
            reference_load: scales.normal,
            middle: scales.middle,
        };
        for (name, value) in case.law.parameter_names().iter().zip(values) {
            if let Some(unknown) = of_law(name, value, guess.mu) {
                setting.put(unknown);
            }
        }
        if case.mass == MovingMass::Wanted {
            let heavy = scales.force / scales.acceleration.max(f64::MIN_POSITIVE);
            setting.put(mass(heavy));
        }
        // Load cells drift: a tenth of the force is a generous offset, and twice that the most.
        let size = 0.1 * scales.force;
        setting.put(RecordUnknown {
            quantity: RecordQuantity::Offset,
            parameter: Parameter {
                transform: Transform::Linear { scale: size },
                bounds: (-2.0 * size, 2.0 * size),
                ..Parameter::declared("force_offset", "N", Prior { mean: 0.0, std: size })
            },
            value: 0.0,
        });
        setting
    }

    /// Sets an unknown: a new one, or another description of one that is there.
    pub(super) fn put(&mut self, unknown: RecordUnknown) {
        if let RecordQuantity::Law(hook) = unknown.quantity {
            self.law.set(hook, unknown.value);
        }
        match self.unknowns.iter_mut().find(|u| u.quantity == unknown.quantity) {
            Some(old) => *old = unknown,
            None => self.unknowns.push(unknown),
        }
    }

    /// The value of an unknown.
    #[must_use]
    pub fn get(&self, quantity: RecordQuantity) -> Option<f64> {
        self.unknowns.iter().find(|u| u.quantity == quantity).map(|u| u.value)
    }

    pub(super) fn values(&self) -> Vec<f64> {
        self.unknowns.iter().map(|u| u.value).collect()
    }

    pub(super) fn with_values(&self, values: &[f64]) -> Self {
        let mut setting = self.clone();
        for (unknown, value) in setting.unknowns.iter_mut().zip(values) {
            unknown.value = *value;
            if let RecordQuantity::Law(hook) = unknown.quantity {
                setting.law.set(hook, *value);
            }
        }
        setting
    }

    /// The law over a scalar, and what acts beside it.
    pub(super) fn over<T: Scalar>(&self, values: &[T]) -> (ModifiedLaw<T>, Beside<T>) {
        let mut law = self.law.lift(|_, value| T::from(value));
        let mut beside = Beside {
            gap: None,
            mass: T::from(self.known_mass),
            offset: T::from(0.0),
            load_offset: T::from(0.0),
            delay: None,
            squeeze: T::from(0.0),
        };
        for (unknown, value) in self.unknowns.iter().zip(values) {
            match unknown.quantity {
                RecordQuantity::Law(hook) => law.set(hook, *value),
                RecordQuantity::Gap => beside.gap = Some(*value),
                RecordQuantity::Mass => beside.mass = *value,
                RecordQuantity::Offset => beside.offset = *value,
                RecordQuantity::LoadOffset => beside.load_offset = *value,
                RecordQuantity::Squeeze => beside.squeeze = *value,
                RecordQuantity::Delay => beside.delay = Some(*value),
            }
        }
        (law, beside)
    }
}

/// A moving mass, from a thousandth of the one whose inertia would be the whole force to ten times that.
pub(super) fn mass(heavy: f64) -> RecordUnknown {
    RecordUnknown {
        quantity: RecordQuantity::Mass,
        parameter: Parameter {
            transform: Transform::Linear { scale: 0.1 * heavy },
            ..Parameter::positive("moving_mass", "kg", (0.0, 10.0 * heavy))
        },
        value: 0.05 * heavy,
    }
}

/// The unknown behind a parameter of a declared law.
fn of_law(name: &str, value: f64, mu: f64) -> Option<RecordUnknown> {
    let (hook, value, bounds, linear) = match name {
        "sigma0" => (Hook::Sigma0, value, (1e-3 * value, 1e3 * value), None),
        "mu_k" => (Hook::MuKinetic, value, (1e-2 * value, 1e2 * value), None),
        "exponent" => (Hook::Exponent, value, (0.02, 8.0), None),
        "sigma1" => (Hook::Sigma1, 0.1 * value, (0.0, 1e4 * value), Some(value)),
        "v_d" => (Hook::DampingVelocity, value, (1e-3 * value, 1e3 * value), None),
        "sigma2" => (Hook::Viscous, value, (0.0, 1e4 * value), Some(value)),
        "mu_s" => (Hook::StribeckRise, 0.15 * mu, (0.0, 10.0 * mu), Some(0.2 * mu)),
        "v_s" => (Hook::StribeckVelocity, value, (1e-2 * value, 1e2 * value), None),
        "delta" => (Hook::StribeckExponent, value, (0.25, 6.0), None),
        "breakaway" => (Hook::Breakaway, value, (0.0, 0.95), Some(0.2)),
        _ => return None,
    };
    let (name, unit) = hook.name_and_unit();
    let transform = linear.map_or(Transform::Log, |scale| Transform::Linear { scale });
    let parameter = Parameter { transform, ..Parameter::positive(name, unit, bounds) };
    Some(RecordUnknown { quantity: RecordQuantity::Law(hook), parameter, value })
}

/// Whether a law is one without memory, which is fitted as the limit of a stiff bristle.
#[must_use]
pub(super) fn has_stiffness(family: Family) -> bool {
    !family.is_static()
}
