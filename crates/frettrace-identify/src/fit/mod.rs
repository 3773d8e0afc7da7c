//! Levenberg-Marquardt with bounds and priors, from one start or from many.

mod many;
mod state;
mod step;
#[cfg(test)]
mod tests;

pub use many::{ManyFits, fit_from_many, starts};
pub(crate) use state::stacked;

use crate::{IdentifyError, Model};
use state::State;
use step::Linearised;

/// How a fit works.
#[derive(Clone, Debug, PartialEq)]
pub struct FitSettings {
    /// Which parameters are free; empty means all.
    pub free: Vec<bool>,
    /// Most steps.
    pub max_iterations: usize,
    /// Converged when a step promises less than this share of χ².
    pub relative_tolerance: f64,
    /// Converged when a step promises less than this of χ² itself: 1e-4 shifts no estimate by more than 0.01 std.
    pub absolute_tolerance: f64,
    /// Whether a step that delivered what it promised spares the next linearisation: the Jacobian is brought up to date by what
    /// the step has shown (Broyden 1965, rank one). For models whose derivatives cost one evaluation a parameter. A fit still
    /// ends on a Jacobian of its own place.
    pub secant: bool,
}

impl Default for FitSettings {
    fn default() -> Self {
        Self {
            free: Vec::new(),
            max_iterations: 60,
            relative_tolerance: 1e-10,
            absolute_tolerance: 1e-4,
            secant: false,
        }
    }
}

impl FitSettings {
    /// The mask of free parameters for a model with `count` parameters.
    #[must_use]
    pub fn mask(&self, count: usize) -> Vec<bool> {
        (0..count).map(|j| self.free.get(j).copied().unwrap_or(self.free.is_empty())).collect()
    }

    /// What a step from some χ² must promise, or the fit has converged.
    fn enough(&self, cost: f64) -> f64 {
        self.absolute_tolerance.max(self.relative_tolerance * cost)
    }
}

/// Outcome of a minimisation.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Status {
    /// No step promises anything more.
    Converged,
    /// Steps promise more, none delivers: a kink or a model that does not converge.
    Stalled,
    /// The number of iterations is spent.
    IterationLimit,
}

/// Values that minimise χ² (data and priors), not yet judged: see [`crate::identify`].
#[derive(Clone, Debug, PartialEq)]
pub struct Fit {
    /// Physical values of all parameters.
    pub values: Vec<f64>,
    /// χ² of the data and the priors.
    pub cost: f64,
    /// χ² of the data alone.
    pub data_cost: f64,
    /// Steps taken.
    pub iterations: usize,
    /// Outcome.
    pub status: Status,
    /// Which parameters were free.
    pub free: Vec<bool>,
    /// Which lie on a bound.
    pub at_bound: Vec<bool>,
}

/// Minimises the χ² of `model` and its priors from `start` (physical values).
///
/// Each step solves `min ‖J δ + r‖² + λ‖D δ‖²` by QR in the coordinates of the parameters' transforms, with parameters
/// on a bound held while the gradient presses them against it; λ follows the gain ratio (Nielsen's rule). A step
/// where the model has no solution is refused like one that does not reduce χ². Where a few steps in a row deliver next
/// to nothing of what they promise, and next to nothing of what a fit ends by, it has stalled: a kink, or the accuracy
/// of the model itself.
///
/// # Errors
/// [`IdentifyError`] where the start does not suit the model or the model has no solution there.
pub fn fit<M: Model>(model: &M, start: &[f64], settings: &FitSettings) -> Result<Fit, IdentifyError> {
    fit_with_memory(model, start, settings, &mut model.memory())
}

/// As [`fit`], with memory (warm starts) that is handed back.
///
/// # Errors
/// As [`fit`].
pub fn fit_with_memory<M: Model>(
    model: &M,
    start: &[f64],
    settings: &FitSettings,
    memory: &mut M::Memory,
) -> Result<Fit, IdentifyError> {
    let free = settings.mask(model.parameters().len());
    let mut state = State::new(model, start, free, memory)?;
    let mut iterations = 0;
    let mut damping = Damping { factor: 1e-3, growth: 2.0 };
    let mut fresh = true;
    let mut crawled = 0;
    let status = loop {
        if iterations >= settings.max_iterations {
            break Status::IterationLimit;
        }
        let linearised = if fresh { state.linearise() } else { state.updated() };
        let Some(linearised) = linearised else { break Status::Stalled };
        let attempts = if fresh { ATTEMPTS } else { 1 };
        let before = damping;
        let cost = state.cost;
        match improve(&mut state, &linearised, (&mut damping, settings, attempts)) {
            Step::Taken { gain } => {
                iterations += 1;
                let crawls = fresh && gain < CRAWL && cost - state.cost < CRAWL * settings.enough(cost);
                crawled = if crawls { crawled + 1 } else { 0 };
                if crawled == CRAWLED {
                    break Status::Stalled;
                }
                fresh = !settings.secant || !(DELIVERED..=1.0 / DELIVERED).contains(&gain);
            }
            // Only a Jacobian of this place may end the fit.
            Step::Over(_) if !fresh => (fresh, damping) = (true, before),
            Step::Over(status) => {
                iterations += 1;
                break status;
            }
        }
    };
    let fit = state.finish(iterations, status);
    state.hand_back(memory);
    Ok(fit)
}

/// Steps tried on one linearisation: 60 doublings and more of λ, no shorter step is different from none.
const ATTEMPTS: usize = 25;
/// Share of what a step promises, and of what a fit ends by, below which it crawls, and such steps in a row that end a fit.
const CRAWL: f64 = 0.1;
const CRAWLED: usize = 3;
/// A step whose gain is this share of what was promised, or more, keeps the Jacobian that promised it.
const DELIVERED: f64 = 0.5;

/// Marquardt's factor and Nielsen's growth of it.
#[derive(Clone, Copy)]
struct Damping {
    factor: f64,
    growth: f64,
}

/// What became of a linearisation.
enum Step {
    /// A step was taken, with its gain over what was promised.
    Taken { gain: f64 },
    /// None is worth taking.
    Over(Status),
}

/// Tries steps of growing damping until one is taken or the fit is over.
fn improve<M: Model>(
    state: &mut State<'_, M>,
    linearised: &Linearised,
    (damping, settings, attempts): (&mut Damping, &FitSettings, usize),
) -> Step {
    for _ in 0..attempts {
        let (step, promised) = linearised.step(damping.factor);
        let enough = settings.enough(state.cost);
        // A step cut short by heavy damping promises little: only an almost undamped one may end the fit.
        if promised <= enough && (damping.factor <= 1.0 || promised <= 1e-3 * enough) {
            return Step::Over(if damping.factor <= 1e3 { Status::Converged } else { Status::Stalled });
        }
        let before = state.cost;
        if let Some(gain) = state.attempt(&step).map(|after| (before - after) / promised)
            && gain > 1e-4
        {
            state.accept();
            damping.factor = (damping.factor * (1.0 - (2.0 * gain - 1.0).powi(3)).max(1.0 / 10.0)).max(1e-12);
            damping.growth = 2.0;
            return Step::Taken { gain };
        }
        damping.factor *= damping.growth;
        damping.growth *= 2.0;
    }
    Step::Over(Status::Stalled)
}
