//! Parameters by name: unit and allowed range.

use std::fmt;

/// The values a parameter may take.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Range {
    /// Lower end.
    pub low: f64,
    /// Whether the lower end itself is allowed.
    pub low_allowed: bool,
    /// Upper end.
    pub high: f64,
    /// Whether the upper end itself is allowed.
    pub high_allowed: bool,
}

impl Range {
    /// `0 < value < ∞`.
    pub const POSITIVE: Range =
        Range { low: 0.0, low_allowed: false, high: f64::INFINITY, high_allowed: false };
    /// `0 ≤ value < ∞`.
    pub const NOT_NEGATIVE: Range = Range { low_allowed: true, ..Range::POSITIVE };
    /// `0 < value ≤ ∞`.
    pub const POSITIVE_OR_INFINITE: Range = Range { high_allowed: true, ..Range::POSITIVE };
    /// Any finite number.
    pub const FINITE: Range = Range { low: f64::NEG_INFINITY, ..Range::POSITIVE };

    /// `low ≤ value < high`.
    pub const fn half_open(low: f64, high: f64) -> Range {
        Range { low, low_allowed: true, high, high_allowed: false }
    }

    /// `low < value < high`.
    pub const fn open(low: f64, high: f64) -> Range {
        Range { low, low_allowed: false, high, high_allowed: false }
    }

    /// Whether the value lies in the range; a NaN lies in none.
    pub fn contains(&self, value: f64) -> bool {
        (value > self.low || self.low_allowed && value == self.low)
            && (value < self.high || self.high_allowed && value == self.high)
    }
}

impl fmt::Display for Range {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match (self.low == f64::NEG_INFINITY, self.high == f64::INFINITY) {
            (true, true) => write!(formatter, "finite"),
            (false, true) => {
                let rest = if self.high_allowed { " (infinite allowed)" } else { " and finite" };
                write!(formatter, "{} {}{rest}", if self.low_allowed { "≥" } else { ">" }, self.low)
            }
            _ => {
                let (left, right) =
                    (if self.low_allowed { '[' } else { '(' }, if self.high_allowed { ']' } else { ')' });
                write!(formatter, "in {left}{}, {}{right}", self.low, self.high)
            }
        }
    }
}

/// One parameter of a law.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Parameter {
    /// Name in files and results.
    pub name: &'static str,
    /// Unit in files and results.
    pub unit: &'static str,
    /// Allowed values.
    pub range: Range,
    /// Value of an ordinary contact.
    pub example: f64,
}

impl Parameter {
    pub(crate) const fn new(name: &'static str, unit: &'static str, range: Range, example: f64) -> Self {
        Self { name, unit, range, example }
    }
}

/// Bristle stiffness per newton of normal force.
pub const SIGMA0: Parameter = Parameter::new("sigma0", "1/m", Range::POSITIVE, 5e5);
/// Presliding damping per newton of normal force.
pub const SIGMA1: Parameter = Parameter::new("sigma1", "s/m", Range::NOT_NEGATIVE, 50.0);
/// Velocity above which presliding damping dies.
pub const V_D: Parameter = Parameter::new("v_d", "m/s", Range::POSITIVE_OR_INFINITE, 1e-3);
/// Viscous damping.
pub const SIGMA2: Parameter = Parameter::new("sigma2", "N·s/m", Range::NOT_NEGATIVE, 0.5);
/// Friction coefficient at rest.
pub const MU_S: Parameter = Parameter::new("mu_s", "1", Range::POSITIVE, 0.6);
/// Friction coefficient of fast slip.
pub const MU_K: Parameter = Parameter::new("mu_k", "1", Range::POSITIVE, 0.4);
/// Stribeck velocity.
pub const V_S: Parameter = Parameter::new("v_s", "m/s", Range::POSITIVE, 1e-3);
/// Stribeck exponent.
pub const DELTA: Parameter = Parameter::new("delta", "1", Range::open(0.0, 20.0), 2.0);
/// Dahl's exponent.
pub const EXPONENT: Parameter = Parameter::new("exponent", "1", Range::half_open(0.0, 20.0), 1.0);
/// Elastic share of the steady deflection.
pub const BREAKAWAY: Parameter = Parameter::new("breakaway", "1", Range::half_open(0.0, 1.0), 0.5);
/// Tangential stiffness of the contact.
pub const STIFFNESS: Parameter = Parameter::new("tangential_stiffness", "N/m", Range::POSITIVE, 5e7);
/// Velocity over which a smooth law turns from one sign to the other.
pub const V_REF: Parameter = Parameter::new("v_ref", "m/s", Range::POSITIVE, 1e-4);
