//! Plans of Fourier transforms: tables of phasors, made once for each length.

use realfft::{ComplexToReal, RealFftPlanner, RealToComplex};
use std::sync::{Arc, LazyLock, Mutex, MutexGuard, PoisonError};

static PLANNER: LazyLock<Mutex<RealFftPlanner<f64>>> = LazyLock::new(|| Mutex::new(RealFftPlanner::new()));

fn planner() -> MutexGuard<'static, RealFftPlanner<f64>> {
    // A planner only ever gains plans that are whole.
    PLANNER.lock().unwrap_or_else(PoisonError::into_inner)
}

/// From so many samples to their bins.
pub(crate) fn forward(samples: usize) -> Arc<dyn RealToComplex<f64>> {
    planner().plan_fft_forward(samples)
}

/// From bins to so many samples.
pub(crate) fn inverse(samples: usize) -> Arc<dyn ComplexToReal<f64>> {
    planner().plan_fft_inverse(samples)
}
