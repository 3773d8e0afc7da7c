//! The noise of sensors that state none: what none of the others shares.
//!
//! Between the lines of a run lies noise, each sensor's own and of any colour, and what the beam does beside them, which all sensors
//! see through the same few shapes. Of the spectra `X` of what is left of `S` sensors over the `K` bins of a band,
//! ```text
//! G = X Xᴴ/K = A Aᴴ + Ψ        Ψ = diag(ψ_s)
//! ```
//! has `M` motions `A` and the noise `Ψ`: factor analysis (Lawley and Maxwell, Factor Analysis as a Statistical Method, 1971). Motions are
//! the eigenvalues of `Ψ^(−½) G Ψ^(−½)` above `(1 + √(S/K))²`, the largest one of noise alone (Marchenko and Pastur), `λ − 1` of each.

use frettrace_fourier::spectrum;
use nalgebra::{DMatrix, SymmetricEigen};
use num_complex::Complex64;

/// Bins of a band.
const BAND: usize = 64;
/// Fewest sensors that can tell one motion from their noise …
const SENSORS: usize = 3;
/// … and fewest bins for each of them.
const BINS: usize = 4;
/// Share by which an eigenvalue of a finite band may exceed the limit by chance.
const CHANCE: f64 = 1.15;
/// Most steps to the powers of the noise, and the relative change of them at which there are no more.
const STEPS: usize = 200;
const SETTLED: f64 = 1e-3;

/// Standard deviation of what each channel does not share with the others; `None` where they are too few, too short or not independent.
pub(crate) fn unshared(channels: &[&[f64]]) -> Option<Vec<f64>> {
    let sensors = channels.len();
    let spectra: Vec<Vec<Complex64>> = channels.iter().map(|x| spectrum(x)).collect();
    let bins = spectra.first()?.len();
    if sensors < SENSORS || bins < BAND.max(BINS * sensors) {
        return None;
    }
    let mut kept = vec![[0.0; 2]; sensors];
    // The first bins hold offsets and drifts.
    for first in (2..bins).step_by(BAND).filter(|first| first + BAND <= bins) {
        let x = DMatrix::from_fn(sensors, BAND, |s, k| spectra[s][first + k]);
        let shared = &x * x.adjoint();
        for ((s, kept), noise) in kept.iter_mut().enumerate().zip(powers(&shared)?) {
            kept[0] += noise;
            kept[1] += shared[(s, s)].re;
        }
    }
    let std = |([own, all], x): ([f64; 2], &&[f64])| {
        let power = x.iter().map(|v| v * v).sum::<f64>() / x.len() as f64;
        (power * (own / all).min(1.0)).sqrt()
    };
    let found: Vec<f64> = kept.into_iter().zip(channels).map(std).collect();
    found.iter().all(|std| std.is_finite()).then_some(found)
}

/// Powers of the noise, `ψ`, in the cross spectra of a band.
fn powers(shared: &DMatrix<Complex64>) -> Option<Vec<f64>> {
    let sensors = shared.nrows();
    let limit = CHANCE * (1.0 + (sensors as f64 / BAND as f64).sqrt()).powi(2);
    // More motions than this are no less than the noise of the sensors: `(S − M)² > S + M`.
    let most = (2 * sensors + 1) as f64 - ((8 * sensors + 1) as f64).sqrt();
    let most = (0.5 * most).floor() as usize;
    let inverse = shared.clone().try_inverse()?;
    let mut noise: Vec<f64> = (0..sensors).map(|s| inverse[(s, s)].re.recip()).collect();
    for _ in 0..STEPS {
        let scale: Vec<f64> = noise.iter().map(|power| power.sqrt().recip()).collect();
        let white = DMatrix::from_fn(sensors, sensors, |i, j| shared[(i, j)] * (scale[i] * scale[j]));
        let SymmetricEigen { eigenvalues, eigenvectors } = white.clone().symmetric_eigen();
        let mut order: Vec<usize> = (0..sensors).collect();
        order.sort_by(|a, b| eigenvalues[*b].total_cmp(&eigenvalues[*a]));
        let motions: Vec<usize> = order.into_iter().take(most).filter(|k| eigenvalues[*k] > limit).collect();
        let mut change = 0.0_f64;
        for (s, power) in noise.iter_mut().enumerate() {
            let moved = |k: &usize| (eigenvalues[*k] - 1.0) * eigenvectors[(s, *k)].norm_sqr();
            let left = white[(s, s)].re - motions.iter().map(moved).sum::<f64>();
            change = change.max((left - 1.0).abs());
            *power *= left.max(LEAST);
        }
        if change < SETTLED {
            break;
        }
    }
    noise.iter().all(|power| power.is_finite()).then_some(noise)
}

/// Least share of a power that a step leaves.
const LEAST: f64 = 0.1;

#[cfg(test)]
mod tests {
    use super::*;
    use rand::SeedableRng;
    use rand_distr::{Distribution, StandardNormal};

    /// Noise of another size in every sensor, white or the sum of what went before (its power falls by the square of the frequency), alone and
    /// beside two motions that all sensors see, ten times as large: what is not shared is the noise. 4096 samples are 31 bands of 64 bins, so
    /// that a deviation scatters by a hundredth; red noise has most of its power in a few of them, and a motion takes two of five sensors.
    #[test]
    fn noise_is_what_sensors_do_not_share() {
        let mut random = rand_pcg::Pcg64::seed_from_u64(5);
        let mut white = |_| -> f64 { StandardNormal.sample(&mut random) };
        let samples = 4096;
        for red in [false, true] {
            for motion in [0.0, 10.0] {
                let [first, second]: [Vec<f64>; 2] = [0, 1].map(|_| (0..samples).map(&mut white).collect());
                let noise: Vec<Vec<f64>> = (0..5)
                    .map(|s| {
                        let mut held = 0.0;
                        let mut next = |k: usize| {
                            held = if red { 0.9 * held } else { 0.0 } + white(k);
                            (1.0 + 0.2 * f64::from(s)) * held
                        };
                        (0..samples).map(&mut next).collect()
                    })
                    .collect();
                let seen = |s: usize| {
                    let shape = 0.4 * s as f64;
                    let at = |k: usize| motion * (shape.cos() * first[k] + shape.sin() * second[k]);
                    noise[s].iter().enumerate().map(|(k, n)| n + at(k)).collect::<Vec<f64>>()
                };
                let channels: Vec<Vec<f64>> = (0..5).map(seen).collect();
                let found = unshared(&channels.iter().map(Vec::as_slice).collect::<Vec<_>>()).unwrap();
                for (found, noise) in found.iter().zip(&noise) {
                    let std = (noise.iter().map(|n| n * n).sum::<f64>() / samples as f64).sqrt();
                    let tolerance = if red || motion > 0.0 { 0.15 } else { 0.04 };
                    assert!((found / std - 1.0).abs() < tolerance, "{red} {motion}: {found} {std}");
                }
            }
        }
    }

    /// Two channels alike have nothing of their own, and two sensors are too few.
    #[test]
    fn channels_alike_tell_nothing() {
        let x: Vec<f64> = (0..1024).map(|k| f64::from(k * k % 37)).collect();
        let y: Vec<f64> = (0..1024).map(|k| f64::from(k * k % 41)).collect();
        assert_eq!(unshared(&[&x, &x, &y]), None);
        assert_eq!(unshared(&[&x, &y]), None);
    }
}
