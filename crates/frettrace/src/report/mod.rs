//! The report of an explanation: one HTML file for a person who decides; works offline, on paper, and in the dark.

pub mod chart;
mod figures;
pub mod levels;
mod page;
pub mod responses;
pub mod signals;
pub mod words;

pub use figures::{Figure, figures};
pub use page::html;

/// Text as it may stand in HTML or SVG.
#[must_use]
pub fn escape(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}
