use super::Family;
use crate::Identified;

/// What one step of the identification did.
#[derive(Clone, Debug, PartialEq)]
pub struct StepReport {
    /// What it does.
    pub name: String,
    /// Parameters it freed.
    pub parameters: Vec<String>,
    /// Relative RMS of the force over the runs it used.
    pub error: f64,
}

/// A law fitted to motion and force of the contact.
#[derive(Clone, Debug, PartialEq)]
pub struct ContactFit {
    /// The law.
    pub family: Family,
    /// Its parameters (law, then moving mass, then offset where asked for).
    pub identified: Identified,
    /// The steps.
    pub steps: Vec<StepReport>,
    /// Relative RMS of the force over all runs it was fitted to.
    pub error: f64,
    /// Share of the starts that led to the best minimum.
    pub agreement: f64,
    /// The law's values in other minima, best first: what to try where the best one fails elsewhere.
    pub others: Vec<Vec<f64>>,
}

impl ContactFit {
    /// Values of the law's parameters, without mass and offset.
    #[must_use]
    pub fn law_values(&self) -> Vec<f64> {
        self.identified.values()[..self.family.parameter_names().len()].to_vec()
    }
}
