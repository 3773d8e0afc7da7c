//! The base frequency, from the record itself.

use crate::sums::{dot, times_distance};
use crate::{Lines, ProjectionError, Projector};
use num_complex::Complex64;

/// A frequency found in a record.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Frequency {
    /// Base angular frequency (rad/s).
    pub base: f64,
    /// Its standard deviation (rad/s).
    pub std: f64,
}

/// Steps of Gauss-Newton: convergence is quadratic, three reach rounding from a nominal value within half a line width.
const MOST_STEPS: usize = 12;

/// Refines a base frequency by least squares over the lines of all channels together.
///
/// Minimises `Σ_c ‖x_c − B(Ω)a_c‖²/σ_c²`; each channel's noise `σ_c` comes from its own residual. One step is
/// `δΩ = Σ_c ⟨r_c, d_c⟩/σ_c² / Σ_c ‖d_c‖²/σ_c²` with `d_c = ∂(B a_c)/∂Ω` about the middle of the record, where the slope
/// and the amplitudes decouple but for terms of relative order one over the number of periods; the standard deviation is
/// the Cramér-Rao bound `(Σ‖d_c‖²/σ_c²)^{−1/2}`.
///
/// # Errors
/// Those of [`Projector::new`] and [`Projector::project`].
pub fn refine(lines: Lines, channels: &[&[f64]]) -> Result<Frequency, ProjectionError> {
    let mut here = lines;
    let mut found = Frequency { base: lines.base, std: f64::INFINITY };
    // A step may not leave the main lobe of the line's window.
    let lobe = std::f64::consts::PI * lines.sampling_rate / lines.samples as f64;
    for _ in 0..MOST_STEPS {
        let (slope, curvature) = step(here, channels)?;
        if curvature <= 0.0 {
            return Ok(found);
        }
        let change = (slope / curvature).clamp(-lobe, lobe);
        here.base += change;
        found = Frequency { base: here.base, std: curvature.sqrt().recip() };
        if change.abs() < 1e-3 * found.std || change.abs() < 1e-14 * here.base {
            break;
        }
    }
    Ok(found)
}

fn step(lines: Lines, channels: &[&[f64]]) -> Result<(f64, f64), ProjectionError> {
    let projector = Projector::new(lines)?;
    let (mut slope, mut curvature) = (0.0, 0.0);
    for fit in projector.fits(channels)? {
        let variance = fit.variance();
        if variance <= f64::MIN_POSITIVE {
            continue;
        }
        let coefficients = fit.coefficients.iter().enumerate();
        let turned: Vec<Complex64> = coefficients.map(|(h, x)| x * Complex64::new(0.0, h as f64)).collect();
        let mut moved = projector.synthesise(&turned);
        times_distance(&mut moved);
        slope += dot(&moved, &fit.residual) / (lines.sampling_rate * variance);
        curvature += dot(&moved, &moved) / (lines.sampling_rate.powi(2) * variance);
    }
    Ok((slope, curvature))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Harmonics;
    use rand::SeedableRng;
    use rand_distr::Distribution;

    fn lines() -> Lines {
        Lines { base: 301.0, order: 3, samples: 2048, sampling_rate: 2048.0, drift: 0 }
    }

    /// Without noise the frequency is found to rounding, from a nominal value half a lobe away.
    #[test]
    fn exact_record_gives_the_exact_frequency() {
        let x = Harmonics::exact(303.1, vec![Complex64::ZERO, Complex64::new(1.0, 0.3), Complex64::ZERO]);
        let samples = x.sample(2048.0, 2048);
        let found = refine(lines(), &[&samples]).unwrap();
        assert!((found.base - 303.1).abs() < 1e-9, "{}", found.base);
    }

    /// Scatter over 150 noisy records against the stated bound: the spread of a standard deviation from 150 values is
    /// 6 %, so 20 % is more than three of it.
    #[test]
    fn scatter_reaches_the_cramer_rao_bound() {
        let x = Harmonics::exact(301.3, vec![Complex64::ZERO, Complex64::ONE, Complex64::new(0.0, 0.2)]);
        let clean = x.sample(2048.0, 2048);
        let mut random = rand_pcg::Pcg64::seed_from_u64(11);
        let noise = rand_distr::Normal::new(0.0, 0.2).unwrap();
        let (mut squares, mut stated) = (0.0, 0.0);
        for _ in 0..150 {
            let noisy: Vec<f64> = clean.iter().map(|v| v + noise.sample(&mut random)).collect();
            let found = refine(lines(), &[&noisy]).unwrap();
            squares += (found.base - 301.3).powi(2) / 150.0;
            stated += found.std.powi(2) / 150.0;
        }
        assert!(((squares / stated).sqrt() - 1.0).abs() < 0.2, "{}", (squares / stated).sqrt());
    }
}
