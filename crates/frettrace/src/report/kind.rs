//! Figures and their kinds.

use super::chart::Picture;

/// Kind of a figure: what it is looked at for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Waveforms, measured and rebuilt.
    Signals,
    /// Spectra with the floor of the noise.
    Spectra,
    /// Force against slip and slip velocity.
    Loops,
    /// Shapes, frequencies and damping of modes.
    Modes,
    /// What is left, against one quantity and over two.
    Residuals,
    /// Evidence of all candidates, and errors before and after.
    Evidence,
    /// Parameters with their intervals.
    Parameters,
    /// Frequency responses.
    Responses,
}

impl Kind {
    /// All of them.
    pub const ALL: [Self; 8] = [
        Self::Signals,
        Self::Spectra,
        Self::Loops,
        Self::Modes,
        Self::Residuals,
        Self::Evidence,
        Self::Parameters,
        Self::Responses,
    ];

    /// The word for it on the command line.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Signals => "signals",
            Self::Spectra => "spectra",
            Self::Loops => "loops",
            Self::Modes => "modes",
            Self::Residuals => "residuals",
            Self::Evidence => "evidence",
            Self::Parameters => "parameters",
            Self::Responses => "responses",
        }
    }

    /// Head of its section in a report.
    #[must_use]
    pub fn heading(self) -> &'static str {
        match self {
            Self::Signals => "Signals and residuals",
            Self::Spectra => "Spectra",
            Self::Loops => "Friction loops",
            Self::Modes => "Modes",
            Self::Residuals => "Shape of the residual",
            Self::Evidence => "Evidence of all candidates",
            Self::Parameters => "Parameters",
            Self::Responses => "Responses",
        }
    }
}

/// One figure.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Figure {
    /// Name for a file, without ending: `loop-0003`.
    pub name: String,
    /// Its kind.
    pub kind: Kind,
    /// The picture, as one SVG element.
    pub svg: String,
    /// The picture as a PNG file, where it was asked for.
    pub png: Option<Vec<u8>>,
}

impl Figure {
    pub(super) fn new(name: impl Into<String>, kind: Kind, picture: Picture) -> Self {
        Self { name: name.into(), kind, svg: picture.svg, png: picture.png }
    }
}

/// A run in a title: its name, its label, and whether it was held out.
pub(super) fn title(what: &str, run: &str, label: &str, held_out: bool) -> String {
    let label = if label.is_empty() { String::new() } else { format!(", {label}") };
    format!("{what}, run {run}{label}{}", if held_out { " (held out)" } else { "" })
}
