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

mod curve;

use crate::channels::LEAST_LEFT;
use crate::verdict::{BALANCE_CALIBRATED, BALANCE_CLOSED};
use crate::{Case, ChannelFault, Clipped, ExplainError, Split, Study};
use curve::{Best, Curve, Heard};
use frettrace_forward::accelerations::{AccelerationModel, Balance, Beside, Setting};
use frettrace_friction::effects::ModifiedLaw;
use frettrace_identify::Model;

pub use curve::Saturation;

/// Share of the χ² of a gain that the curve may leave on a structure as declared, …
const WORTH: f64 = 0.3;
/// … and of its excess over the noise on the calibrated one.
const LEFT: f64 = 0.05;
/// χ² by which the curve must explain a sensor better than a gain: more than any effect needs against another, for four values.
const CLAIM: f64 = 40.0;

impl Case {
    /// Leaves a sensor out that saturates softly, and names the fault: its lines carry no weight, and predictions are bent before
    /// they are compared with it.
    ///
    /// # Errors
    /// [`ExplainError::Model`] where the rig cannot be modelled.
    pub fn leave_out_saturated(&mut self) -> Result<(), ExplainError> {
        if let Some(found) = self.saturated()? {
            self.leave_out(found);
        }
        Ok(())
    }

    /// The same of a sensor with which the balance of runs without a period is open, and without which it is closed. Whether its readings in them
    /// are a curve of what the others tell.
    pub fn leave_out_bent(&mut self, sensor: usize, readings: Vec<Reading>) -> bool {
        let heard = readings.into_iter().map(Heard::sampled).collect();
        let found = Curve::new(heard).and_then(|curve| claimed(&curve, sensor));
        found.map(|found| self.leave_out(found)).is_some()
    }

    fn leave_out(&mut self, (saturation, fault): (Saturation, ChannelFault)) {
        let sensor = fault.sensor;
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
    }

    fn saturated(&self) -> Result<Option<(Saturation, ChannelFault)>, ExplainError> {
        let sensors = self.rig.sensors.len();
        if sensors <= LEAST_LEFT || !self.records.iter().any(|record| record.periodic) {
            return Ok(None);
        }
        if self.declared_balance()? <= BALANCE_CALIBRATED {
            return Ok(None);
        }
        let (study, setting) = Study::new(self, Split::First)?;
        if study.balance_base(&setting, &[]).reduced <= BALANCE_CALIBRATED {
            return Ok(None);
        }
        // One that is flat in some runs may be bent in others.
        let flat = |sensor: &usize| self.records.iter().any(|record| record.clipped[*sensor].is_some());
        let any = (0..sensors).any(|sensor| flat(&sensor));
        let doubted = (0..sensors)
            .filter(|sensor| !any || flat(sensor))
            .map(|sensor| (study.chi_beside(&setting, Beside::Sensor(sensor)), sensor))
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

/// A sensor in a run without a period: its samples, those that the others tell of it (m/s²), and the deviation of the difference.
#[derive(Clone, Debug)]
pub struct Reading {
    /// What it read, without the mean.
    pub read: Vec<f64>,
    /// What it should have read.
    pub told: Vec<f64>,
    /// Standard deviation of a sample of the difference.
    pub deviation: f64,
}

/// The best curve of a sensor, where that explains what it read and no gain does.
fn claimed(curve: &Curve, sensor: usize) -> Option<(Saturation, ChannelFault)> {
    let (gain, count) = (curve.of_a_gain(), curve.residual_count() as f64);
    let Best { saturation, chi, limit_deviation } = curve.best()?;
    let claimed = gain - chi > CLAIM && chi - BALANCE_CLOSED * count < LEFT * (gain - count);
    let limit = saturation.straight + saturation.reach;
    let fault = ChannelFault {
        id: "measurement.clipping",
        sensor,
        parameters: vec![("limit".into(), "m/s^2".into(), limit, limit_deviation)],
        evidence: gain - chi,
    };
    claimed.then_some((saturation, fault))
}

/// χ² per degree of freedom.
fn reduced(balances: &[Balance]) -> f64 {
    let (chi, freedom) = Balance::chi_squared_of(balances);
    chi / freedom.max(1) as f64
}

impl Study<'_> {
    /// The saturation of a sensor, where that is what keeps the balance open.
    fn saturated(&self, setting: &Setting, sensor: usize) -> Option<(Saturation, ChannelFault)> {
        let (curve, _) = self.heard(setting, sensor)?;
        curve.best().filter(|best| best.chi < WORTH * curve.of_a_gain())?;
        // The structure was calibrated with the sensor in it.
        let setting = self.calibrated_beside(setting, Beside::Sensor(sensor));
        let (curve, _) = self.heard(&setting, sensor).filter(|(_, reduced)| *reduced < BALANCE_CLOSED)?;
        claimed(&curve, sensor)
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
    use super::{Curve, Heard, Reading, claimed};
    use rand::SeedableRng;
    use rand_distr::{Distribution, Normal};

    /// Two tones without a common period, up to twice the limit 0.9, and what a sensor makes of them, with noise of 1e-3.
    fn heard(reads: impl Fn(f64) -> f64) -> Curve {
        let mut generator = rand_pcg::Pcg64::seed_from_u64(3);
        let noise = Normal::new(0.0, 1e-3).unwrap();
        let told: Vec<f64> = (0..2000)
            .map(f64::from)
            .map(|k| 1.1 * (0.21 * k).sin() + 0.7 * (0.21 * 2.0_f64.sqrt() * k).sin())
            .collect();
        let read = told.iter().map(|x| reads(*x) + noise.sample(&mut generator)).collect();
        Curve::new(vec![Heard::sampled(Reading { read, told, deviation: 1e-3 })]).unwrap()
    }

    #[test]
    fn a_bent_reading_without_a_period_is_a_saturation() {
        let (curve, fault) = claimed(&heard(|x| 0.9 * (x / 0.9).tanh()), 4).unwrap();
        assert_eq!((fault.id, fault.sensor), ("measurement.clipping", 4));
        for x in [0.2, 0.9, 1.5] {
            // The family comes within 1e-3 of tanh at twice the limit.
            assert!((curve.reads(x) - 0.9 * (x / 0.9).tanh()).abs() < 3e-3, "{x}");
        }
    }

    #[test]
    fn a_gain_or_another_signal_is_no_saturation() {
        assert!(claimed(&heard(|x| 0.9 * x), 0).is_none());
        assert!(claimed(&heard(|x| x + 0.2 * x * x), 0).is_none());
    }
}
