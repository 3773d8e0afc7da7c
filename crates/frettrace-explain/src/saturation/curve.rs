//! The curve of a saturation and its fit to what a sensor read.

use super::Reading;
use crate::deviation::deviations;
use frettrace_forward::accelerations::Balance;
use frettrace_fourier::{Grid, GridError};
use frettrace_identify::{FitSettings, Model, NoSolution, Parameter, Transform, fit};
use nalgebra::DMatrix;
use num_complex::Complex64;

/// What a channel reads of an acceleration: straight, then bent.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Saturation {
    /// Acceleration `a` up to which it is straight (m/s²).
    pub straight: f64,
    /// Acceleration `c` beyond `a` about which it bends (m/s²); for `m = 1` it reads no more than `a + c`.
    pub reach: f64,
    /// Sharpness `n` of the bend.
    pub sharpness: f64,
    /// Flatness `m` beyond it: the slope goes as `b^(−m)`.
    pub flatness: f64,
}

/// Range of sharpness: an exponential has 1, beyond 60 a limit is hard.
const SHARPNESS: (f64, f64) = (0.8, 60.0);
/// Range of flatness.
const FLATNESS: (f64, f64) = (0.2, 5.0);
/// Shares of the largest reading up to which the curve is straight, and sharpness, from which fits start.
const STARTS: [(f64, f64); 4] = [(0.0, 2.0), (0.0, 8.0), (0.5, 2.0), (0.5, 8.0)];

impl Saturation {
    /// What is read of `x`.
    #[must_use]
    pub fn reads(&self, x: f64) -> f64 {
        let beyond = x.abs() - self.straight;
        if beyond <= 0.0 { x } else { x.signum() * (self.straight + beyond * self.bend(beyond)[0]) }
    }

    /// `(1 + u)^(−m/n)`, `u/(1 + u)` and `ln(1 + u)` for `u = (b/c)ⁿ`.
    fn bend(&self, beyond: f64) -> [f64; 3] {
        let u = (beyond / self.reach).powf(self.sharpness);
        let grown = u.ln_1p();
        [(-self.flatness / self.sharpness * grown).exp(), u / (1.0 + u), grown]
    }

    /// Derivatives of the reading by straight part, reach, sharpness and flatness.
    fn slopes(&self, x: f64) -> [f64; 4] {
        let Self { straight, reach, sharpness: n, flatness: m } = *self;
        let beyond = x.abs() - straight;
        if beyond <= 0.0 {
            return [0.0; 4];
        }
        let [share, bent, grown] = self.bend(beyond);
        let y = beyond * share;
        let sharper = y * m * (grown / n - bent * (beyond / reach).ln()) / n;
        [1.0 - share * (1.0 - m * bent), y * m * bent / reach, sharper, -y * grown / n]
            .map(|d| x.signum() * d)
    }

    /// Lines of what is read of predicted lines.
    #[must_use]
    pub fn lines(&self, predicted: &[Complex64]) -> Vec<Complex64> {
        Wave::of(predicted).map_or_else(|_| predicted.to_vec(), |wave| wave.lines(|x| self.reads(x)))
    }
}

/// Samples of one period, on a grid that carries the harmonics a bend makes.
struct Wave {
    grid: Grid,
    samples: Vec<f64>,
}

impl Wave {
    fn of(lines: &[Complex64]) -> Result<Self, GridError> {
        let order = lines.len().saturating_sub(1);
        let grid = Grid::new(order, (8 * order).next_power_of_two().max(256))?;
        let mut samples = vec![0.0; grid.samples()];
        grid.evaluate(lines, &mut samples, &mut grid.scratch());
        Ok(Self { grid, samples })
    }

    /// Lines of a function of the wave.
    fn lines(&self, of: impl Fn(f64) -> f64) -> Vec<Complex64> {
        let samples: Vec<f64> = self.samples.iter().map(|x| of(*x)).collect();
        let mut out = vec![Complex64::ZERO; self.grid.order() + 1];
        self.grid.project(&samples, &mut out, &mut self.grid.scratch());
        out
    }
}

/// A sensor in one run: what it read, whitened line by line from the first on or sample by sample, and what the others say it should have.
pub(super) struct Heard {
    read: Vec<f64>,
    /// Largest reading (m/s²).
    largest: f64,
    told: Told,
}

/// What a sensor should have read, and the deviation of the difference.
enum Told {
    /// The wave of a period, compared on its lines.
    Lines { wave: Wave, deviation: Vec<f64> },
    /// Samples of a run without a period.
    Samples { samples: Vec<f64>, deviation: f64 },
}

impl Heard {
    /// From a balance with the sensor's signal free.
    pub(super) fn of(read: &[Complex64], balance: &Balance) -> Option<Self> {
        let (free, deviation) = (balance.beside.first()?, balance.beside_deviation.first()?);
        let without_mean = |h: usize, value: Complex64| if h == 0 { Complex64::ZERO } else { value };
        let lines = read.iter().zip(free).enumerate();
        let lines: Vec<Complex64> = lines.map(|(h, (read, free))| without_mean(h, read - free)).collect();
        Some(Self::on_lines(read, Wave::of(&lines).ok()?, deviation.clone()))
    }

    fn on_lines(read: &[Complex64], wave: Wave, deviation: Vec<f64>) -> Self {
        let largest = Wave::of(read).map_or(0.0, |wave| peak(&wave.samples));
        Self { read: whitened(read, &deviation), largest, told: Told::Lines { wave, deviation } }
    }

    /// From the samples of a run without a period.
    pub(super) fn sampled(reading: Reading) -> Self {
        let Reading { read, told: samples, deviation } = reading;
        let largest = peak(&read);
        let read = read.into_iter().map(|y| y / deviation).collect();
        Self { read, largest, told: Told::Samples { samples, deviation } }
    }

    /// A function of what should have been read, whitened as the readings are.
    fn told(&self, of: impl Fn(f64) -> f64) -> Vec<f64> {
        match &self.told {
            Told::Lines { wave, deviation } => whitened(&wave.lines(of), deviation),
            Told::Samples { samples, deviation } => samples.iter().map(|x| of(*x) / deviation).collect(),
        }
    }
}

fn peak(samples: &[f64]) -> f64 {
    samples.iter().fold(0.0, |peak: f64, x| peak.max(x.abs()))
}

fn whitened(lines: &[Complex64], deviation: &[f64]) -> Vec<f64> {
    let scaled = lines.iter().zip(deviation).skip(1).map(|(line, deviation)| line / deviation);
    scaled.flat_map(|line| [line.re, line.im]).collect()
}

/// A sensor in all fitted runs, as a function of the values of a [`Saturation`].
pub(super) struct Curve {
    runs: Vec<Heard>,
    /// Largest reading (m/s²).
    largest: f64,
    parameters: Vec<Parameter>,
}

/// The best curve of a sensor.
pub(super) struct Best {
    pub saturation: Saturation,
    pub chi: f64,
    /// Bound on the standard deviation of its limit `a + c` (m/s²): both parts go against each other.
    pub limit_deviation: f64,
}

impl Curve {
    /// `None` where nothing was read.
    pub(super) fn new(runs: Vec<Heard>) -> Option<Self> {
        let largest = runs.iter().map(|run| run.largest).fold(0.0, f64::max);
        if largest <= 0.0 {
            return None;
        }
        let parameters = vec![
            Parameter {
                transform: Transform::Linear { scale: 0.1 * largest },
                ..Parameter::positive("straight", "m/s^2", (0.0, largest))
            },
            Parameter::positive("reach", "m/s^2", (1e-3 * largest, 30.0 * largest)),
            Parameter::positive("sharpness", "1", SHARPNESS),
            Parameter::positive("flatness", "1", FLATNESS),
        ];
        Some(Self { runs, largest, parameters })
    }

    /// χ² of the best constant gain.
    pub(super) fn of_a_gain(&self) -> f64 {
        let (mut cross, mut power, mut read) = (0.0, 0.0, 0.0);
        for run in &self.runs {
            for (x, y) in run.told(|x| x).into_iter().zip(&run.read) {
                cross += x * y;
                power += x * x;
                read += y * y;
            }
        }
        read - cross * cross / f64::max(power, f64::MIN_POSITIVE)
    }

    pub(super) fn best(&self) -> Option<Best> {
        let fitted = STARTS.iter().filter_map(|&(straight, sharpness)| {
            let flat = FitSettings { free: vec![true, true, true, false], ..FitSettings::default() };
            let start = [straight, 1.2 - straight].map(|share| share * self.largest);
            let begun = fit(self, &[start[0], start[1], sharpness, 1.0], &flat).ok()?;
            fit(self, &begun.values, &FitSettings::default()).ok()
        });
        let found = fitted.min_by(|a, b| a.data_cost.total_cmp(&b.data_cost))?;
        let deviation = deviations(self, &found, &());
        let limit_deviation = deviation[0].hypot(deviation[1]);
        Some(Best { saturation: curve(&found.values), chi: found.data_cost, limit_deviation })
    }
}

fn curve(values: &[f64]) -> Saturation {
    Saturation { straight: values[0], reach: values[1], sharpness: values[2], flatness: values[3] }
}

impl Model for Curve {
    type Memory = ();

    fn parameters(&self) -> &[Parameter] {
        &self.parameters
    }

    fn residual_count(&self) -> usize {
        self.runs.iter().map(|run| run.read.len()).sum()
    }

    fn memory(&self) {}

    fn residual(&self, values: &[f64], _memory: &mut (), residual: &mut [f64]) -> Result<(), NoSolution> {
        let curve = curve(values);
        let mut out = residual.iter_mut();
        for run in &self.runs {
            let pairs = run.read.iter().zip(run.told(|x| curve.reads(x)));
            out.by_ref().zip(pairs).for_each(|(out, (read, predicted))| *out = read - predicted);
        }
        if residual.iter().all(|r| r.is_finite()) { Ok(()) } else { Err(NoSolution) }
    }

    fn linearise(
        &self,
        values: &[f64],
        _free: &[bool],
        memory: &mut (),
        (residual, jacobian): (&mut [f64], &mut DMatrix<f64>),
    ) -> Result<(), NoSolution> {
        self.residual(values, memory, residual)?;
        let curve = curve(values);
        for k in 0..values.len() {
            let mut row = 0;
            for run in &self.runs {
                for value in run.told(|x| curve.slopes(x)[k]) {
                    jacobian[(row, k)] = -value;
                    row += 1;
                }
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::{Curve, Heard, Saturation, Wave, curve};
    use num_complex::Complex64;

    const BENT: Saturation = Saturation { straight: 0.3, reach: 0.8, sharpness: 2.3, flatness: 0.9 };

    #[test]
    fn slopes_are_differences() {
        let values = [BENT.straight, BENT.reach, BENT.sharpness, BENT.flatness];
        for x in [-1.7, -0.2, 0.0, 0.4, 0.9, 3.0] {
            for (k, slope) in BENT.slopes(x).into_iter().enumerate() {
                let moved = |step: f64| {
                    let mut values = values;
                    values[k] += step;
                    curve(&values).reads(x)
                };
                // Central differences: h² times a third derivative of order one.
                let difference = (moved(1e-5) - moved(-1e-5)) / 2e-5;
                assert!((slope - difference).abs() < 1e-8, "{k} at {x}: {slope} {difference}");
            }
        }
    }

    /// Noise of the tests over RMS.
    const NOISE: f64 = 1e-5;

    /// A tone of the first and third line, read through `of`, against the best curve: RMS over RMS.
    fn left(amplitude: f64, of: impl Fn(f64) -> f64) -> f64 {
        let mut lines = vec![Complex64::ZERO; 40];
        (lines[1], lines[3]) = (Complex64::from(amplitude), Complex64::new(0.0, 0.2 * amplitude));
        let wave = Wave::of(&lines).unwrap();
        let read = wave.lines(of);
        let power: f64 = read.iter().map(Complex64::norm_sqr).sum();
        let deviation = vec![NOISE * power.sqrt(); read.len()];
        let heard = Heard::on_lines(&read, wave, deviation);
        let chi = Curve::new(vec![heard]).unwrap().best().unwrap().chi;
        NOISE * chi.sqrt()
    }

    /// The module's figures: other laboratories' formulas are carried, a gain that grows is not.
    #[test]
    fn other_formulas_are_carried() {
        let arc = |x: f64| (std::f64::consts::FRAC_PI_2 * x).atan() / std::f64::consts::FRAC_PI_2;
        for (name, of) in [("tanh", f64::tanh as fn(f64) -> f64), ("arc tangent", arc)] {
            assert!(left(1.0, of) < 1.1e-4, "{name}: {}", left(1.0, of));
            assert!(left(1.7, of) < 1e-3, "{name}: {}", left(1.7, of));
        }
        let knee = |x: f64| {
            if x.abs() < 0.7 { x } else { x.signum() * (0.7 + 0.3 * ((x.abs() - 0.7) / 0.3).tanh()) }
        };
        assert!(left(1.2, knee) < 1e-3, "knee: {}", left(1.2, knee));
        assert!(left(1.0, |x| x + 0.05 * x.powi(3)) > 5e-3);
    }
}
