//! What the ends of a record add to its spectrum: free decays of the modes, and the jump of the continued forces.

use frettrace_beam::ModalModel;
use frettrace_fourier::spectrum;
use num_complex::Complex64;

/// Spectra of one decay, from bin 1: of `Re(s e^{λt})` as an acceleration, and of the velocity and displacement it belongs to.
#[derive(Clone)]
pub(super) struct Decay {
    pub(super) acceleration: Vec<Complex64>,
    pub(super) velocity: Vec<Complex64>,
    pub(super) displacement: Vec<Complex64>,
}

/// Free decays of every mode within the band, `s = 1` and `s = i`, of unit acceleration at the start.
pub(super) struct Decays {
    pub(super) all: Vec<Decay>,
}

impl Decays {
    pub(super) fn new(model: &ModalModel, record: &Record) -> Self {
        let starts = [Complex64::ONE, Complex64::I];
        let decays = (0..record.modes).flat_map(|n| starts.map(|start| (pole(model, n), start)));
        let all = decays
            .map(|(pole, start)| {
                let bins = |power: i32| record.bins(pole, |_| start * pole.powi(-power));
                Decay { acceleration: bins(0), velocity: bins(1), displacement: bins(2) }
            })
            .collect();
        Self { all }
    }

    /// Derivatives of the decay `Re(s e^{λt})` of a mode with respect to its `ln ω_n` (`kind` 0) or `ln ζ_n` (1).
    ///
    /// With `λ = ω(−ζ + i√(1 − ζ²))` these are `∂λ = λ` and `−ωζ(1 + iζ/√(1 − ζ²))`, and
    /// `∂(λ^{−p} e^{λt}) = ∂λ (t − p/λ) λ^{−p} e^{λt}`.
    pub(super) fn derivative(
        model: &ModalModel,
        record: &Record,
        (mode, start): (usize, Complex64),
        kind: usize,
    ) -> Decay {
        let (pole, ratio) = (pole(model, mode), model.damping_ratio()[mode]);
        let turned = model.natural_frequency()[mode] * ratio;
        let change = match kind {
            0 => pole,
            _ => -turned * Complex64::new(1.0, ratio / (1.0 - ratio * ratio).max(f64::MIN_POSITIVE).sqrt()),
        };
        let bins = |power: i32| {
            let scaled = start * change * pole.powi(-power);
            record.bins(pole, |t| scaled * (t - f64::from(power) / pole))
        };
        Decay { acceleration: bins(0), velocity: bins(1), displacement: bins(2) }
    }
}

fn pole(model: &ModalModel, mode: usize) -> Complex64 {
    let (frequency, ratio) = (model.natural_frequency()[mode], model.damping_ratio()[mode]);
    frequency * Complex64::new(-ratio, (1.0 - ratio * ratio).max(0.0).sqrt())
}

/// Length of a record, and the modes within its band.
#[derive(Clone, Copy)]
pub(super) struct Record {
    pub(super) rate: f64,
    pub(super) samples: usize,
    /// Bins `1..=order`.
    pub(super) order: usize,
    pub(super) modes: usize,
}

impl Record {
    pub(super) fn new(model: &ModalModel, rate: f64, samples: usize) -> Self {
        let highest = std::f64::consts::PI * rate;
        let modes = model.natural_frequency().iter().take_while(|w| **w < highest).count();
        Self { rate, samples, order: (samples - 1) / 2, modes }
    }

    /// Spectrum of `Re(a(t) e^{λt})`.
    fn bins(&self, pole: Complex64, amplitude: impl Fn(f64) -> Complex64) -> Vec<Complex64> {
        let turn = (pole / self.rate).exp();
        let mut now = Complex64::ONE;
        let series: Vec<f64> = (0..self.samples)
            .map(|j| {
                let here = amplitude(j as f64 / self.rate) * now;
                now *= turn;
                here.re
            })
            .collect();
        self.amplitudes(&series)
    }

    /// Amplitudes of a series in the bins `1..=order`.
    pub(super) fn amplitudes(&self, series: &[f64]) -> Vec<Complex64> {
        let scale = 2.0 / self.samples as f64;
        spectrum(series)[1..=self.order].iter().map(|z| z * scale).collect()
    }
}

/// Polynomials that jump at the end of a record, bins from 1: the ramp `t/T − ½` in its value by one, the parabola
/// `½T(t²/T² − t/T + 1/6)`, whose derivative is the ramp, in its slope (s).
pub(super) fn ramps(record: &Record) -> [Vec<Complex64>; JUMPS] {
    let length = record.samples as f64 / record.rate;
    let series = |value: &dyn Fn(f64) -> f64| -> Vec<Complex64> {
        let samples: Vec<f64> =
            (0..record.samples).map(|j| value(j as f64 / record.samples as f64)).collect();
        record.amplitudes(&samples)
    };
    [series(&|t| t - 0.5), series(&|t| 0.5 * length * (t * t - t + 1.0 / 6.0))]
}

/// What jumps: value and slope.
pub(super) const JUMPS: usize = 2;

/// The jumps of a continued force: `f = h + Σ_q J_q (r_q − r̃_q)`, with the polynomials `r_q` of [`ramps`] and what is left of them
/// below a corner, `r̃_k = r_k ω_c²/(ω_k² + ω_c²)`.
#[derive(Clone, Copy)]
pub(super) struct Jump {
    /// Squared corner, in bins.
    corner: f64,
    /// Prior variances of the `J_q` (N², N²/s²).
    pub(super) variances: [f64; JUMPS],
}

impl Jump {
    /// The jumps of a force whose bins have the powers `P_k`: value and slope have at either end the variances `½ ΣP` and `½ Σω²P`,
    /// which makes twice that, and the corner is the mean frequency, `ω_c² = Σ ω²P/ΣP`.
    pub(super) fn new(powers: &[f64], base: f64) -> Self {
        let total = powers.iter().sum::<f64>().max(f64::MIN_POSITIVE);
        let bent: f64 = powers.iter().enumerate().map(|(k, p)| (k as f64 + 1.0).powi(2) * p).sum();
        let slope = (bent * base * base).max(f64::MIN_POSITIVE);
        Self { corner: bent / total, variances: [total, slope] }
    }

    /// No jump.
    pub(super) fn none() -> Self {
        Self { corner: 0.0, variances: [0.0; JUMPS] }
    }

    /// Share of the polynomials that lies below the corner in bin `k` (from 0).
    pub(super) fn below(&self, k: usize) -> f64 {
        self.corner / ((k as f64 + 1.0).powi(2) + self.corner)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use frettrace_beam::{Boundary, ModalOptions, UniformBeam};

    fn model() -> ModalModel {
        let beam = UniformBeam::rectangular(0.7, [0.03, 0.006], 2.05e11, 7850.0);
        let options = ModalOptions { modes: 4, damping_ratio: vec![0.02], ..ModalOptions::default() };
        ModalModel::new(&beam, &Boundary::spring(1e6), &options).unwrap()
    }

    /// The parabola's derivative is the ramp: its bins times `iω`, but for the jump that the samples round off at the record's end.
    #[test]
    fn the_parabola_bends_into_the_ramp() {
        let record = Record { rate: 512.0, samples: 512, order: 255, modes: 0 };
        let [ramp, parabola] = ramps(&record);
        let base = std::f64::consts::TAU;
        for k in 0..10 {
            let turned = parabola[k] * Complex64::new(0.0, base * (k as f64 + 1.0));
            // The ramp's samples hold half of the jump too much: 1/n of a bin.
            assert!((turned - ramp[k]).norm() < 1.5 / 512.0, "{k}: {turned} {}", ramp[k]);
        }
    }

    /// Derivatives of decays are those of central differences: of relative size `(ω T δ)²/6` with `ωT` below 400 and `δ` of
    /// 1e-6, and rounding over `δ`.
    #[test]
    fn derivatives_of_decays_are_differences() {
        let (plain, step) = (model(), 1e-6);
        let record = Record::new(&plain, 1024.0, 200);
        for (unknown, kind) in [(0, 0), (1, 1), (3, 0), (2, 1)] {
            let moved = |sign: f64| {
                let mut model = plain.clone();
                let mode = unknown / 2;
                let mut values = [model.natural_frequency()[mode], model.damping_ratio()[mode]];
                values[kind] *= (sign * step).exp();
                model.set_mode(mode, values[0], values[1]);
                Decays::new(&model, &record).all[unknown].clone()
            };
            let (above, below) = (moved(1.0), moved(-1.0));
            let start = [Complex64::ONE, Complex64::I][unknown % 2];
            let found = Decays::derivative(&plain, &record, (unknown / 2, start), kind);
            let largest = found.displacement.iter().map(|z| z.norm()).fold(0.0, f64::max);
            for k in 0..record.order {
                let difference = (above.displacement[k] - below.displacement[k]) / (2.0 * step);
                assert!((found.displacement[k] - difference).norm() < 1e-6 * largest, "{unknown} {kind} {k}");
            }
        }
    }
}
