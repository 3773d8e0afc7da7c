/// Why a fit could not be tried.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum IdentifyError {
    /// The start has another length than the model's parameter list.
    #[error("the model has {expected} parameters, the start has {found}")]
    StartLength {
        /// Parameters of the model.
        expected: usize,
        /// Values given.
        found: usize,
    },
    /// A start value is not finite or, for a logarithmic parameter, not positive.
    #[error("start value {value} of parameter {name} is not admissible")]
    StartValue {
        /// Name of the parameter.
        name: String,
        /// The value given.
        value: f64,
    },
    /// The model has no solution at any start.
    #[error("the model has no solution at any of the {starts} starts")]
    NoStart {
        /// Starts tried.
        starts: usize,
    },
    /// Nothing to fit: no free parameter or no residual.
    #[error("nothing to fit: {parameters} free parameters, {residuals} residuals")]
    Empty {
        /// Free parameters.
        parameters: usize,
        /// Residuals.
        residuals: usize,
    },
}
