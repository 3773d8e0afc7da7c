//! A case and its rows.

/// One quantity of a case.
#[derive(Clone, Debug, PartialEq)]
pub struct Row {
    /// What is compared.
    pub quantity: String,
    /// Its unit.
    pub unit: &'static str,
    /// Where the expected value comes from.
    pub source: &'static str,
    /// Expected value; `None` for a quantity that is reported, with nothing known before to compare it with.
    pub expected: Option<f64>,
    /// Found value.
    pub found: f64,
    /// Largest difference allowed; for a reported quantity what change would matter.
    pub tolerance: f64,
    /// Why that much.
    pub reason: &'static str,
}

impl Row {
    /// Whether the difference is allowed; an undefined number never is.
    #[must_use]
    pub fn passes(&self) -> bool {
        match self.expected {
            Some(expected) => (self.found - expected).abs() <= self.tolerance,
            None => self.found.is_finite(),
        }
    }
}

/// What came of a case.
#[derive(Clone, Debug, PartialEq)]
pub enum Outcome {
    /// It ran.
    Ran(Vec<Row>),
    /// It could not run here, and why.
    Skipped(String),
}

/// A question with a known answer.
#[derive(Clone, Copy, Debug)]
pub struct Case {
    /// Name of its folder in `cases/`: `verify_…`, `compare_…` or `validate_…`.
    pub name: &'static str,
    /// Answers it.
    pub run: fn() -> anyhow::Result<Outcome>,
}

/// What is said of an error on data that nothing was fitted to, in the words of `explain`.
#[must_use]
pub fn verdict(error: f64, allowed: f64) -> &'static str {
    if error <= allowed { "explained" } else { "open" }
}
