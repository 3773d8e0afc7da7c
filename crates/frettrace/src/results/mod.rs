//! What the commands find, as their JSON files hold it (SI units).
//!
//! Infinite and undefined numbers are `null` in JSON and read back as NaN: an interval without an end is `null`.

mod explanation;
mod identification;
mod number;

pub use explanation::{
    Amplitudes, BeforeAfter, Candidate, ChannelSpectrum, ContactCurve, ContactLoop, Control, Effect,
    Exhibits, Explanation, Place, Question, ResidualMap, ResidualShape, Verdict, Waveform,
};
pub use identification::{
    Dependence, ErrorSummary, Estimate, GroupEstimate, HeldOut, Identification, ModeEstimate,
    NoiseFloorSource, Provenance, Step, Structure,
};
