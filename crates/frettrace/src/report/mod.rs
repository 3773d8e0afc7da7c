//! The report of an explanation: one HTML file for a person who decides; works offline, on paper, and in the dark.

pub mod chart;
mod figures;
mod identified;
mod kind;
pub mod levels;
mod numbers;
mod page;
pub mod recovered;
mod residuals;
pub mod responses;
mod shapes;
pub mod signals;
pub(crate) mod spectra;
pub mod words;

pub use figures::figures;
pub use identified::identification;
pub use kind::{Figure, Kind};
pub use page::html;

/// Text as it may stand in HTML or SVG.
#[must_use]
pub fn escape(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}
