//! Why a reconstruction could not be tried.

use frettrace_fourier::ProjectionError;

/// Why a reconstruction could not be tried.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum InverseError {
    /// Fewer sensors than unknown contact forces.
    #[error("{sensors} sensors cannot determine {unknowns} unknown contact forces")]
    TooFewSensors {
        /// Sensors given.
        sensors: usize,
        /// Contact forces wanted.
        unknowns: usize,
    },
    /// A position lies off the beam.
    #[error("{what} at {position} m is not on the beam of length {length} m")]
    OffTheBeam {
        /// Whose position.
        what: String,
        /// The position (m).
        position: f64,
        /// Length of the beam (m).
        length: f64,
    },
    /// A run has another number of channels than the rig has sensors, or channels of different length.
    #[error("run {run}: {found} {what}, {expected} expected")]
    Shape {
        /// Name of the run.
        run: String,
        /// What was counted.
        what: &'static str,
        /// Number found.
        found: usize,
        /// Number expected.
        expected: usize,
    },
    /// A sample is no number.
    #[error("run {run}: {channel} has no finite value at sample {sample}")]
    NotFinite {
        /// Name of the run.
        run: String,
        /// Name of the channel.
        channel: String,
        /// Index of the sample from 0.
        sample: usize,
    },
    /// A number of a run is out of range.
    #[error("run {run}: {what} {value} is out of range")]
    OutOfRange {
        /// Name of the run.
        run: String,
        /// The quantity.
        what: &'static str,
        /// Its value.
        value: f64,
    },
    /// The excitation force is zero throughout.
    #[error("run {run}: the excitation force is zero throughout; connect the force channel")]
    NoForce {
        /// Name of the run.
        run: String,
    },
    /// The record cannot be projected on lines.
    #[error("run {run}: {source}")]
    Projection {
        /// Name of the run.
        run: String,
        /// The reason.
        source: ProjectionError,
    },
    /// No run was given.
    #[error("there is no run to reconstruct")]
    NoRuns,
}
