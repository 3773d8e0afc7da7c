//! Harmonics of sampled signals.
//!
//! # Convention
//! A periodic signal of base angular frequency `Ω` is `x(t) = Re Σ_{h=0..H} x̂_h e^{ihΩt}`; `x̂_0` is real.
//! The amplitude of line `h ≥ 1` is `|x̂_h|`, its mean square `|x̂_h|²/2`.
//!
//! # Normalization
//! [`Grid::project`] and [`Grid::evaluate`] are inverse to each other for `N > 2H` samples a period.
//!
//! # Order
//! Line `h` of a harmonic form is the frequency `hΩ`; of a subharmonic form of order `ν` it is `hΩ/ν`: the base
//! frequency carries `ν`, nothing else does.
//!
//! | type | role |
//! |---|---|
//! | [`Harmonics`] | a periodic signal, with the variance of each line |
//! | [`Projector`] | whole records to harmonics, by least squares: no integer number of periods is needed |
//! | [`OpenLines`] | some lines of a record that is read in a part of its samples only |
//! | [`refine`] | the base frequency from the record itself |
//! | [`Sampler`] | samples of many harmonics of one base frequency |
//! | [`Grid`] | samples of one period to harmonics and back |
//! | [`sum`], [`dot`], [`variance`] | sums over long records |

mod frequency;
mod grid;
mod harmonics;
mod noise;
mod open_lines;
mod phasors;
mod plans;
mod projection;
mod sampler;
mod sums;

pub use frequency::{Frequency, refine};
pub use grid::{Grid, GridError, GridScratch};
pub use harmonics::Harmonics;
pub use noise::{spectrum, tapered_spectrum};
pub use open_lines::OpenLines;
pub use projection::{Lines, Projected, ProjectionError, Projector};
pub use sampler::Sampler;
pub use sums::{dot, sum, variance};
