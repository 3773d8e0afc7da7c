//! What can be wrong with a described beam.

/// A beam, boundary or model that cannot be computed.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum BeamError {
    /// A quantity outside its range.
    #[error("{quantity} is {found}, allowed: {allowed}")]
    OutOfRange {
        /// The quantity, with its unit.
        quantity: &'static str,
        /// The value given.
        found: f64,
        /// The allowed range.
        allowed: &'static str,
    },
    /// Neither end holds the beam.
    #[error(
        "the beam is a mechanism: clamp rotational stiffness {clamp} N·m/rad with support stiffness {support} N/m holds it nowhere"
    )]
    Mechanism {
        /// Rotational stiffness of the clamp (N·m/rad).
        clamp: f64,
        /// Stiffness of the support (N/m).
        support: f64,
    },
    /// Fewer or more roots of the frequency equation were bracketed than the beam has.
    #[error("natural frequency {mode} was not bracketed: βL = {found} lies outside [{low}, {high}]")]
    RootNotBracketed {
        /// Number of the mode, from 1.
        mode: usize,
        /// The root found in its place.
        found: f64,
        /// Smallest possible root.
        low: f64,
        /// Largest possible root.
        high: f64,
    },
    /// More measured modes than the model holds.
    #[error("{given} measured modes given, the model holds {held}")]
    TooManyMeasured {
        /// Measured modes.
        given: usize,
        /// Modes of the model.
        held: usize,
    },
    /// The mass matrix is not positive definite, or the eigenvalue iteration did not converge.
    #[error("no eigenvalues of the {size} × {size} finite-element matrices: {reason}")]
    Eigenvalues {
        /// Size of the matrices.
        size: usize,
        /// What failed.
        reason: &'static str,
    },
}

/// Refuses a value that is not finite and positive.
pub(crate) fn positive(quantity: &'static str, value: f64) -> Result<(), BeamError> {
    if value.is_finite() && value > 0.0 {
        Ok(())
    } else {
        Err(BeamError::OutOfRange { quantity, found: value, allowed: "finite and > 0" })
    }
}

/// Refuses a stiffness below zero or not a number; infinity means rigid.
pub(crate) fn stiffness(quantity: &'static str, value: f64) -> Result<(), BeamError> {
    if value >= 0.0 {
        Ok(())
    } else {
        Err(BeamError::OutOfRange { quantity, found: value, allowed: "≥ 0, infinite = rigid" })
    }
}
