//! A sensor that saturates softly: what it reads against what the others say it should.
//!
//! A hard limit shows in the samples of the channel itself ([`crate::channels`]); a soft one does not. With the signal of one
//! sensor free on every line, the balance of the others says what accelerates it: `x`, the measured line less the free value.
//! A reading that is a function of `x` alone, straight up to `a` and bent beyond it,
//!
//! `y(x) = sgn(x) (a + b (1 + (b/c)ⁿ)^(−m/n))` with `b = |x| − a > 0`, `y(x) = x` with `|x| ≤ a`,
//!
//! is fitted to the lines of all fitted runs. It is the hard limit `a + c` for `n → ∞, m = 1`; with `a = 0` tanh, arc tangent, error
//! function and exponential lie within 1.1e-4 of it where the motion comes up to 1.2 of their limit, within 1e-3 at twice that. A
//! gain is no saturation: it must leave far more. The sensor is then left out as one with a hard limit is, and predictions are bent
//! by the curve before they are compared with it.

use crate::study::deviations;
use crate::{Case, ChannelFault, Clipped, ExplainError, Split, Study};
use frettrace_forward::accelerations::{AccelerationModel, Balance, Beside, Setting};
use frettrace_fourier::Grid;
use frettrace_friction::effects::ModifiedLaw;
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

/// χ² per degree of freedom of the balance from which a sensor may be in doubt: with the thousand degrees of freedom of a set, two
/// standard deviations.
const OPEN: f64 = 1.1;
/// … and up to which the balance is closed with the sensor's signal free.
const CLOSED: f64 = 1.6;
/// Share of the χ² of a gain that the curve may leave on a structure as declared, …
const WORTH: f64 = 0.3;
/// … and of its excess over the noise on the calibrated one.
const LEFT: f64 = 0.05;
/// χ² by which the curve must explain a sensor better than a gain: more than any effect needs against another, for four values.
const CLAIM: f64 = 40.0;
/// Sensors that must be there for one to be left out: those left recover the contact and are checked by each other.
const LEAST: usize = 4;
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
        mapped(predicted, |x| self.reads(x)).unwrap_or_else(|| predicted.to_vec())
    }
}

/// Lines of a function of a wave, on a grid that carries the harmonics a bend makes.
fn mapped(lines: &[Complex64], of: impl Fn(f64) -> f64) -> Option<Vec<Complex64>> {
    let order = lines.len().saturating_sub(1);
    let grid = Grid::new(order, (8 * order).next_power_of_two().max(256)).ok()?;
    let mut scratch = grid.scratch();
    let mut wave = vec![0.0; grid.samples()];
    grid.evaluate(lines, &mut wave, &mut scratch);
    wave.iter_mut().for_each(|x| *x = of(*x));
    let mut out = vec![Complex64::ZERO; order + 1];
    grid.project(&wave, &mut out, &mut scratch);
    Some(out)
}

/// A sensor in one run: what it read, what the others say it should have, and the deviation of the difference.
struct Heard {
    read: Vec<Complex64>,
    true_lines: Vec<Complex64>,
    deviation: Vec<f64>,
}

impl Heard {
    fn of(read: &[Complex64], balance: &Balance) -> Option<Self> {
        let (free, deviation) = (balance.beside.first()?, balance.beside_deviation.first()?);
        let without_mean = |h: usize, value: Complex64| if h == 0 { Complex64::ZERO } else { value };
        let lines = read.iter().zip(free).enumerate();
        Some(Self {
            true_lines: lines.map(|(h, (read, free))| without_mean(h, read - free)).collect(),
            read: read.to_vec(),
            deviation: deviation.clone(),
        })
    }

    /// Whitened line by line from the first on.
    fn whitened<'a>(&'a self, lines: &'a [Complex64]) -> impl Iterator<Item = f64> + 'a {
        let scaled = lines.iter().zip(&self.deviation).skip(1).map(|(line, deviation)| line / deviation);
        scaled.flat_map(|line| [line.re, line.im])
    }
}

/// A sensor in all fitted runs, as a function of the values of a [`Saturation`].
struct Curve {
    runs: Vec<Heard>,
    /// Largest reading (m/s²).
    largest: f64,
    parameters: Vec<Parameter>,
}

impl Curve {
    fn new(runs: Vec<Heard>) -> Option<Self> {
        let largest = runs
            .iter()
            .filter_map(|run| {
                let mut peak: f64 = 0.0;
                let grid = Grid::new(run.read.len() - 1, (8 * run.read.len()).next_power_of_two()).ok()?;
                let mut wave = vec![0.0; grid.samples()];
                grid.evaluate(&run.read, &mut wave, &mut grid.scratch());
                wave.iter().for_each(|x| peak = peak.max(x.abs()));
                Some(peak)
            })
            .fold(0.0, f64::max);
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
    fn of_a_gain(&self) -> f64 {
        let (mut cross, mut power, mut read) = (0.0, 0.0, 0.0);
        for run in &self.runs {
            for (x, y) in run.whitened(&run.true_lines).zip(run.whitened(&run.read)) {
                cross += x * y;
                power += x * x;
                read += y * y;
            }
        }
        read - cross * cross / f64::max(power, f64::MIN_POSITIVE)
    }

    /// The best curve, its χ², and the deviation of its limit.
    fn best(&self) -> Option<(Saturation, f64, f64)> {
        let fitted = STARTS.iter().filter_map(|&(straight, sharpness)| {
            let flat = FitSettings { free: vec![true, true, true, false], ..FitSettings::default() };
            let start = [straight, 1.2 - straight].map(|share| share * self.largest);
            let begun = fit(self, &[start[0], start[1], sharpness, 1.0], &flat).ok()?;
            fit(self, &begun.values, &FitSettings::default()).ok()
        });
        let found = fitted.min_by(|a, b| a.data_cost.total_cmp(&b.data_cost))?;
        let deviation = deviations(self, &found, &());
        Some((curve(&found.values), found.data_cost, deviation[0].hypot(deviation[1])))
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
        self.runs.iter().map(|run| 2 * run.read.len().saturating_sub(1)).sum()
    }

    fn memory(&self) {}

    fn residual(&self, values: &[f64], _memory: &mut (), residual: &mut [f64]) -> Result<(), NoSolution> {
        let curve = curve(values);
        let mut out = residual.iter_mut();
        for run in &self.runs {
            let reads = mapped(&run.true_lines, |x| curve.reads(x)).ok_or(NoSolution)?;
            let pairs = run.whitened(&run.read).zip(run.whitened(&reads));
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
                let slope = mapped(&run.true_lines, |x| curve.slopes(x)[k]).ok_or(NoSolution)?;
                for value in run.whitened(&slope) {
                    jacobian[(row, k)] = -value;
                    row += 1;
                }
            }
        }
        Ok(())
    }
}

/// A sensor that saturates.
struct Found {
    sensor: usize,
    saturation: Saturation,
    fault: ChannelFault,
}

impl Case {
    /// Leaves a sensor out that saturates softly, and names the fault: its lines carry no weight, and predictions are bent before
    /// they are compared with it.
    ///
    /// # Errors
    /// [`ExplainError::Model`] where the rig cannot be modelled.
    pub fn leave_out_saturated(&mut self) -> Result<(), ExplainError> {
        let Some(Found { sensor, saturation, fault }) = self.saturated()? else { return Ok(()) };
        for record in &mut self.records {
            let mut clipped = record.clipped.clone();
            match &mut clipped[sensor] {
                Some(Clipped::Hard { bend, .. }) => *bend = Some(saturation),
                soft => *soft = Some(Clipped::Soft(saturation)),
            }
            record.silence(&clipped);
        }
        match self.faults.iter_mut().find(|known| known.id == fault.id && known.sensor == sensor) {
            Some(known) => known.evidence += fault.evidence,
            None => self.faults.push(fault),
        }
        Ok(())
    }

    fn saturated(&self) -> Result<Option<Found>, ExplainError> {
        let sensors = self.rig.sensors.len();
        if sensors < LEAST || !self.records.iter().any(|record| record.periodic) {
            return Ok(None);
        }
        if self.declared_balance()? <= OPEN {
            return Ok(None);
        }
        let (study, setting) = Study::new(self, Split::First)?;
        if study.balance_base(&setting, &[]).reduced <= OPEN {
            return Ok(None);
        }
        let chi = |sensor: &usize| study.chi_beside(&setting, Beside::Sensor(*sensor));
        // One that is flat in some runs may be bent in others.
        let flat = |sensor: &usize| self.records.iter().any(|record| record.clipped[*sensor].is_some());
        let any = (0..sensors).any(|sensor| flat(&sensor));
        let doubted = (0..sensors)
            .filter(|sensor| !any || flat(sensor))
            .map(|sensor| (chi(&sensor), sensor))
            .min_by(|a, b| a.0.total_cmp(&b.0));
        Ok(doubted.and_then(|(_, sensor)| study.saturated(&setting, sensor)))
    }

    /// χ² per degree of freedom of the balance of all periodic runs with what is declared.
    fn declared_balance(&self) -> Result<f64, ExplainError> {
        let lines = self.records.iter().map(|record| record.lines.clone()).collect();
        let model = AccelerationModel::new(self.rig.clone(), lines)?;
        let runs: Vec<usize> = (0..self.records.len()).filter(|&k| self.records[k].periodic).collect();
        Ok(reduced(&model.balance(&self.setting(ModifiedLaw::dahl(1.0, 1.0)), &runs)?))
    }
}

/// χ² per degree of freedom.
fn reduced(balances: &[Balance]) -> f64 {
    let sum = balances.iter().map(Balance::chi_squared).fold((0.0, 0), |a, b| (a.0 + b.0, a.1 + b.1));
    sum.0 / sum.1.max(1) as f64
}

impl Study<'_> {
    /// The saturation of a sensor, where that is what keeps the balance open.
    fn saturated(&self, setting: &Setting, sensor: usize) -> Option<Found> {
        let (curve, _) = self.heard(setting, sensor)?;
        curve.best().filter(|(_, chi, _)| *chi < WORTH * curve.of_a_gain())?;
        // The structure was calibrated with the sensor in it.
        let setting = self.calibrated_beside(setting, Beside::Sensor(sensor));
        let (curve, _) = self.heard(&setting, sensor).filter(|(_, reduced)| *reduced < CLOSED)?;
        let (gain, count) = (curve.of_a_gain(), curve.residual_count() as f64);
        let (saturation, chi, deviation) = curve.best()?;
        let claimed = gain - chi > CLAIM && chi - CLOSED * count < LEFT * (gain - count);
        claimed.then(|| Found {
            sensor,
            saturation,
            fault: ChannelFault {
                id: "measurement.clipping",
                sensor,
                parameters: vec![(
                    "limit".into(),
                    "m/s^2".into(),
                    saturation.straight + saturation.reach,
                    deviation,
                )],
                evidence: gain - chi,
            },
        })
    }

    /// A sensor against what the others say it should read, and χ² per degree of freedom of their balance.
    fn heard(&self, setting: &Setting, sensor: usize) -> Option<(Curve, f64)> {
        let balances = self.model.balance_beside(setting, &self.training, Beside::Sensor(sensor)).ok()?;
        let runs = self.training.iter().zip(&balances);
        let runs = runs.filter(|(run, _)| self.case.records[**run].clipped[sensor].is_none());
        let heard =
            runs.map(|(&run, balance)| Heard::of(&self.model.runs[run].acceleration[sensor], balance));
        Some((Curve::new(heard.collect::<Option<Vec<_>>>()?)?, reduced(&balances)))
    }
}

#[cfg(test)]
mod tests {
    use super::{Curve, Heard, Saturation, mapped};
    use num_complex::Complex64;

    const BENT: Saturation = Saturation { straight: 0.3, reach: 0.8, sharpness: 2.3, flatness: 0.9 };

    #[test]
    fn slopes_are_differences() {
        let at = |values: [f64; 4]| Saturation {
            straight: values[0],
            reach: values[1],
            sharpness: values[2],
            flatness: values[3],
        };
        let values = [BENT.straight, BENT.reach, BENT.sharpness, BENT.flatness];
        for x in [-1.7, -0.2, 0.0, 0.4, 0.9, 3.0] {
            for (k, slope) in BENT.slopes(x).into_iter().enumerate() {
                let moved = |step: f64| {
                    let mut values = values;
                    values[k] += step;
                    at(values).reads(x)
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
        let read = mapped(&lines, of).unwrap();
        let power: f64 = read.iter().map(Complex64::norm_sqr).sum();
        let heard = Heard { deviation: vec![NOISE * power.sqrt(); read.len()], true_lines: lines, read };
        let (_, chi, _) = Curve::new(vec![heard]).unwrap().best().unwrap();
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
