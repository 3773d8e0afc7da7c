//! What can be wrong with a law asked for.

use crate::Range;

/// A law or its parameters could not be made.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// No law has this name.
    #[error("no friction law is called '{name}'; known: {known}")]
    UnknownLaw {
        /// The name asked for.
        name: String,
        /// All names, separated by commas.
        known: String,
    },
    /// The law has no parameter of this name.
    #[error("law '{law}' has no parameter '{parameter}'; it has {known}")]
    UnknownParameter {
        /// Name of the law.
        law: &'static str,
        /// Name of the parameter asked for.
        parameter: String,
        /// All names, separated by commas.
        known: String,
    },
    /// A parameter of the law was not given.
    #[error("law '{law}' needs a value of '{parameter}' in {unit}, allowed {range}")]
    MissingParameter {
        /// Name of the law.
        law: &'static str,
        /// Name of the parameter.
        parameter: &'static str,
        /// Its unit.
        unit: &'static str,
        /// Its range.
        range: Range,
    },
    /// A parameter lies outside its range, or is not a number.
    #[error("law '{law}': {parameter} = {value} {unit} is not allowed, it must be {range}")]
    OutOfRange {
        /// Name of the law.
        law: &'static str,
        /// Name of the parameter.
        parameter: &'static str,
        /// The value given.
        value: f64,
        /// Its unit.
        unit: &'static str,
        /// Its range.
        range: Range,
    },
    /// Not as many values as the law has parameters.
    #[error("law '{law}' has {expected} parameters, {found} values were given")]
    Count {
        /// Name of the law.
        law: &'static str,
        /// Number of parameters.
        expected: usize,
        /// Number of values.
        found: usize,
    },
    /// Slip, velocity, normal force and force of a period differ in length, or are empty.
    #[error("a period needs slip, velocity, normal force and room for the force of one length: {lengths:?}")]
    Lengths {
        /// The lengths found.
        lengths: [usize; 4],
    },
}
