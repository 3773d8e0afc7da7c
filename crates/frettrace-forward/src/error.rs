//! What keeps a forward problem from being tried.

/// Why a forward problem could not be tried.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ForwardError {
    /// The phase grid cannot carry the harmonics.
    #[error(transparent)]
    Grid(#[from] frettrace_fourier::GridError),
    /// The beam cannot be computed.
    #[error(transparent)]
    Beam(#[from] frettrace_beam::BeamError),
    /// A contact names a channel or force that the lines do not have.
    #[error("contact {contact} names {what} {index}, but there are {available}")]
    Index {
        /// Which contact, from 0.
        contact: usize,
        /// "channel" or "force".
        what: &'static str,
        /// The index named.
        index: usize,
        /// How many there are.
        available: usize,
    },
    /// Two sizes that must agree do not.
    #[error("{what}: {found} found, {expected} expected")]
    Size {
        /// What is sized.
        what: &'static str,
        /// The size expected.
        expected: usize,
        /// The size found.
        found: usize,
    },
    /// A law with more internal states than the solver carries.
    #[error("contact {contact} has {found} internal states, at most {limit} are carried")]
    States {
        /// Which contact, from 0.
        contact: usize,
        /// States of its law.
        found: usize,
        /// The largest number allowed.
        limit: usize,
    },
    /// A number that must be finite and positive.
    #[error("{what} must be finite and positive, found {found}")]
    NotPositive {
        /// What the number is, with its unit.
        what: &'static str,
        /// The number found.
        found: f64,
    },
}
