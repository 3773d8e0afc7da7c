use crate::Parameter;
use nalgebra::DMatrix;

/// The model has no solution at these values (a solver did not converge, a bound of validity is left).
///
/// The fit answers with a shorter step.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct NoSolution;

/// Anything with parameters, a residual and its Jacobian.
///
/// The residual is whitened: divided by its standard deviation (or multiplied by the inverse Cholesky factor of its
/// covariance), so that `Σ r²` is a χ² for the true values. Complex residuals are two real ones.
pub trait Model: Sync {
    /// Working memory and warm starts, one per thread; a step that is refused restores a clone made before it.
    type Memory: Clone + Send + Sync;

    /// The parameters, in the order of every vector and column.
    fn parameters(&self) -> &[Parameter];

    /// Number of residuals.
    fn residual_count(&self) -> usize;

    /// Fresh memory.
    fn memory(&self) -> Self::Memory;

    /// Whitened residual at physical parameter values.
    ///
    /// # Errors
    /// [`NoSolution`] where the model cannot be evaluated.
    fn residual(
        &self,
        values: &[f64],
        memory: &mut Self::Memory,
        residual: &mut [f64],
    ) -> Result<(), NoSolution>;

    /// Residual and Jacobian `∂r_i/∂p_j` (rows: residuals, columns: parameters) by physical values.
    ///
    /// Columns of parameters that are not `free` may be left as they are.
    ///
    /// # Errors
    /// [`NoSolution`] where the model cannot be evaluated.
    fn linearise(
        &self,
        values: &[f64],
        free: &[bool],
        memory: &mut Self::Memory,
        target: (&mut [f64], &mut DMatrix<f64>),
    ) -> Result<(), NoSolution>;
}
