//! The zero-phase anti-alias filter between the march and the record.

/// Half the length of the filter, in samples of the record.
pub(super) const REACH: usize = 32;
/// Half-power frequency over the sampling rate: flat to 0.40, nothing left at 0.50, as laboratory analysers have it.
const CORNER: f64 = 0.45;
/// Kaiser's shape parameter for 100 dB: 0.1102 (100 − 8.7).
const KAISER: f64 = 10.06;

/// A symmetric low-pass over `REACH` samples to either side, centred `shift` fine samples before the sample it stands for.
pub(super) struct LowPass {
    weights: Vec<f64>,
    first: isize,
}

impl LowPass {
    /// The filter for a fine time base of `oversampling` steps a sample and a delay of `shift` steps, whole or not.
    pub(super) fn new(oversampling: usize, shift: f64) -> Self {
        let reach = (REACH * oversampling) as f64;
        let first = (-shift - reach).ceil() as isize;
        let last = (-shift + reach).floor() as isize;
        let corner = CORNER / oversampling as f64;
        let weights: Vec<f64> = (first..=last)
            .map(|offset| {
                let place = offset as f64 + shift;
                let share = place / reach;
                let window = bessel(KAISER * (1.0 - share * share).max(0.0).sqrt()) / bessel(KAISER);
                2.0 * corner * sinc(2.0 * corner * place) * window
            })
            .collect();
        // Unit gain at rest whatever the fraction of the shift.
        let sum: f64 = weights.iter().sum();
        Self { weights: weights.into_iter().map(|w| w / sum).collect(), first }
    }

    /// The filtered signal at the fine sample `at`.
    pub(super) fn at(&self, fine: &[f64], at: usize) -> f64 {
        let start = at.saturating_add_signed(self.first);
        self.weights.iter().zip(&fine[start..]).map(|(w, x)| w * x).sum()
    }
}

fn sinc(x: f64) -> f64 {
    let argument = std::f64::consts::PI * x;
    if argument.abs() < 1e-8 { 1.0 } else { argument.sin() / argument }
}

/// Modified Bessel function `I₀` by its series.
fn bessel(x: f64) -> f64 {
    let quarter = x * x / 4.0;
    let (mut term, mut sum) = (1.0, 1.0);
    for k in 1..60 {
        term *= quarter / f64::from(k * k);
        sum += term;
    }
    sum
}
