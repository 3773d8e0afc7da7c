//! Free decays of the modes, as they appear in the spectrum of a finite record.

use frettrace_beam::ModalModel;
use frettrace_fourier::spectrum;
use num_complex::Complex64;

/// Spectra of `Re(e^{λ_n t})` and `Re(i e^{λ_n t})` for every mode within the band; as accelerations, of unit size.
pub(super) struct Transients {
    /// Spectrum of each decay as acceleration, one vector a decay, from bin 1.
    acceleration: Vec<Vec<Complex64>>,
    /// Spectrum of each decay as velocity.
    velocity: Vec<Vec<Complex64>>,
    /// Spectrum of each decay as displacement.
    displacement: Vec<Vec<Complex64>>,
}

impl Transients {
    pub(super) fn new(model: &ModalModel, rate: f64, samples: usize, order: usize) -> Self {
        let highest = std::f64::consts::PI * rate;
        let modes = model.natural_frequency().iter().take_while(|w| **w < highest).count();
        let decays: Vec<(Complex64, Complex64)> = (0..2 * modes)
            .map(|m| {
                let (frequency, ratio) = (model.natural_frequency()[m / 2], model.damping_ratio()[m / 2]);
                let pole = frequency * Complex64::new(-ratio, (1.0 - ratio * ratio).max(0.0).sqrt());
                (pole, if m % 2 == 0 { Complex64::ONE } else { Complex64::I })
            })
            .collect();
        let bins = |pole: Complex64, start: Complex64| -> Vec<Complex64> {
            let turn = (pole / rate).exp();
            let mut now = start;
            let mut series = Vec::with_capacity(samples);
            for _ in 0..samples {
                series.push(now.re);
                now *= turn;
            }
            spectrum(&series)[1..=order].iter().map(|z| z * (2.0 / samples as f64)).collect()
        };
        Self {
            acceleration: decays.iter().map(|(pole, start)| bins(*pole, *start)).collect(),
            velocity: decays.iter().map(|(pole, start)| bins(*pole, start / pole)).collect(),
            displacement: decays.iter().map(|(pole, start)| bins(*pole, start / (pole * pole))).collect(),
        }
    }

    /// Number of real unknowns: two a mode.
    pub(super) fn count(&self) -> usize {
        self.acceleration.len()
    }

    /// Mode of an unknown.
    pub(super) fn mode(&self, unknown: usize) -> usize {
        unknown / 2
    }

    pub(super) fn acceleration(&self, unknown: usize, bin: usize) -> Complex64 {
        self.acceleration[unknown][bin]
    }

    pub(super) fn velocity(&self, unknown: usize, bin: usize) -> Complex64 {
        self.velocity[unknown][bin]
    }

    pub(super) fn displacement(&self, unknown: usize, bin: usize) -> Complex64 {
        self.displacement[unknown][bin]
    }
}
