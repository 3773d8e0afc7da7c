//! A parameter with what is known of it.

use crate::Parameter;

/// Whether the data tell a parameter.
#[derive(Clone, Debug, PartialEq)]
pub enum Identifiability {
    /// They do.
    Identifiable,
    /// They do not: why, and which experiment would.
    NotIdentifiable {
        /// Whether they bound it at all: its sum or product with another may be known though it is not.
        bounded: bool,
        /// Why.
        reason: String,
        /// The experiment that would tell.
        experiment: String,
    },
    /// It was not free.
    Fixed,
}

/// A parameter with its uncertainty.
#[derive(Clone, Debug, PartialEq)]
pub struct IdentifiedParameter {
    /// Name.
    pub name: String,
    /// Unit.
    pub unit: String,
    /// Value.
    pub value: f64,
    /// Standard deviation; `None` where the parameter is not identified.
    pub std: Option<f64>,
    /// Interval of 95 % confidence; `None` where the parameter is not identified.
    pub interval95: Option<(f64, f64)>,
    /// Whether the data tell it.
    pub identifiability: Identifiability,
}

impl IdentifiedParameter {
    /// Whether the data tell it.
    #[must_use]
    pub fn is_identifiable(&self) -> bool {
        self.identifiability == Identifiability::Identifiable
    }

    /// Whether the data tell it, or would tell it together with another.
    #[must_use]
    pub fn is_bounded(&self) -> bool {
        matches!(
            self.identifiability,
            Identifiability::Identifiable | Identifiability::NotIdentifiable { bounded: true, .. }
        )
    }

    /// Widens interval and standard deviation about the value.
    pub(crate) fn stretch(&mut self, ratio: f64, described: &Parameter) {
        if !ratio.is_finite() {
            return;
        }
        let transform = described.transform;
        let centre = transform.coordinate(self.value);
        let moved = |end: f64| transform.value(centre + ratio * (transform.coordinate(end) - centre));
        self.std = self.std.map(|std| ratio * std);
        self.interval95 = self.interval95.map(|(low, high)| (moved(low), moved(high)));
    }

    /// Takes the interval back as too wide.
    pub(crate) fn loosen(&mut self, (low, high): (f64, f64), experiment: &str) {
        let unit = if self.unit == "1" { String::new() } else { format!(" {}", self.unit) };
        self.std = None;
        self.interval95 = None;
        self.identifiability = Identifiability::NotIdentifiable {
            bounded: true,
            reason: format!("its 95 % interval, {low:.3e} to {high:.3e}{unit}, is too wide to call it known"),
            experiment: experiment.to_owned(),
        };
    }
}
