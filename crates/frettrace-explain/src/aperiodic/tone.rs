//! A tone beside the excitation that all runs share and no contact force makes.
//!
//! The balance is linear, so that the tone's own line is balanced by itself, with one more free value a run: a motion of the base, a sensor, a
//! force anywhere on the beam. Where a motion of the base closes it and nothing else does, that motion is told in every run, and with it
//! what clamp and support bring to sensors, slip and normal force: it is taken out of the accelerations and put to the motion of the contact.

use super::balance::{balanced, declared};
use super::motion::WholeRun;
use crate::effects::EffectPlace;
use crate::verdict::BALANCE_CLOSED;
use crate::{Case, ExplainError};
use frettrace_forward::accelerations::{AccelerationModel, Balance, Beside, RunLines, Setting};
use frettrace_fourier::{Lines, Projector, refine};
use num_complex::Complex64;
use std::f64::consts::TAU;
use std::sync::Arc;

/// Factor over the median bin from which a bin holds a tone: the mean of `S R` powers of white noise, with five sensors and four runs the fewest,
/// exceeds three times its median in one of 10¹⁰ bins.
const STANDS_OUT: f64 = 3.0;
/// Share of what is left without a motion of the base that it must take.
const TAKEN: f64 = 0.5;

/// A motion of clamp and support alike that all runs have beside the excitation.
#[derive(Clone, Debug)]
pub struct BaseTone {
    /// Its frequency (rad/s).
    pub omega: f64,
    /// χ² per degree of freedom of the tone's own line, without and with it.
    pub reduced: [f64; 2],
    /// What it makes in each run.
    pub runs: Vec<ToneMotion>,
}

/// What a motion of the base makes in a run: complex amplitudes, `x(t) = Re x e^{iωt}`.
#[derive(Clone, Debug, Default)]
pub struct ToneMotion {
    /// Acceleration of the base (m/s²).
    pub base: Complex64,
    /// Acceleration of each sensor (m/s²).
    pub acceleration: Vec<Complex64>,
    /// Slip (m).
    pub slip: Complex64,
    /// Displacement of the end against the support (m).
    pub end: Complex64,
}

/// The motion of the base that all runs share beside the excitation, where the balance of its own line asks for one.
///
/// # Errors
/// [`ExplainError::Model`] where the rig cannot be modelled.
pub fn base_tone(case: &Case, whole: &[Option<WholeRun>]) -> Result<Option<BaseTone>, ExplainError> {
    let sensors = case.rig.sensors.len();
    let Some(omega) = loudest(whole).and_then(|omega| shared(case, omega)) else { return Ok(None) };
    let lines: Option<Vec<RunLines>> = (0..case.records.len()).map(|run| at_tone(case, run, omega)).collect();
    let Some(lines) = lines.filter(|_| sensors > 2 && case.allows("excitation.base-motion")) else {
        return Ok(None);
    };
    let study = balanced(case, lines.clone())?;
    let setting = declared(case);
    let plain = Balance::chi_squared_of(&study.model.balance(&setting, &study.training)?);
    let balances = study.model.balance_beside(&setting, &study.training, Beside::Base)?;
    let moved = Balance::chi_squared_of(&balances);
    let reduced = [plain, moved].map(|(chi, freedom)| chi / freedom.max(1) as f64);
    let (place, _) = study.open_place(&setting);
    if !asks(reduced) || place != EffectPlace::Excitation {
        return Ok(None);
    }
    Ok(Some(BaseTone { omega, reduced, runs: motions(case, (&setting, lines), &balances)? }))
}

/// Whether a balance asks for a motion of the base: χ² per degree of freedom without and with it. One that is closed asks for nothing.
fn asks([without, with]: [f64; 2]) -> bool {
    without > BALANCE_CLOSED && with <= BALANCE_CLOSED && with < TAKEN * without
}

/// Frequency (rad/s) of the bin that stands out of what no contact force makes in all runs together; `None` where none does or the runs differ in
/// length.
fn loudest(whole: &[Option<WholeRun>]) -> Option<f64> {
    let runs: Vec<&WholeRun> = whole.iter().flatten().collect();
    let first = runs.first()?;
    let samples = first.found.force.len();
    if runs.iter().any(|run| run.found.force.len() != samples || run.dt != first.dt) {
        return None;
    }
    let bins = runs.iter().map(|run| run.left.len()).min()?;
    let power = |k: usize| runs.iter().flat_map(|run| &run.left[k]).map(Complex64::norm_sqr).sum::<f64>();
    let powers: Vec<f64> = (0..bins).map(power).collect();
    let loudest = (0..bins).max_by(|a, b| powers[*a].total_cmp(&powers[*b]))?;
    let mut sorted = powers.clone();
    sorted.sort_by(f64::total_cmp);
    let stands_out = powers[loudest] > STANDS_OUT * sorted[bins / 2];
    stands_out.then(|| TAU * (loudest + 1) as f64 / (samples as f64 * first.dt))
}

fn lines(case: &Case, run: usize, omega: f64) -> Lines {
    let record = &case.records[run];
    Lines { base: omega, order: 1, samples: record.samples, sampling_rate: record.sampling_rate, drift: 0 }
}

/// The frequency near a bin's in which the runs agree.
fn shared(case: &Case, omega: f64) -> Option<f64> {
    let one = |run: usize| {
        let channels: Vec<&[f64]> = case.records[run].residual.iter().map(Vec::as_slice).collect();
        refine(lines(case, run, omega), &channels).ok().filter(|found| found.std.is_finite())
    };
    let found: Vec<_> = (0..case.records.len()).map(one).collect::<Option<_>>()?;
    let weight: f64 = found.iter().map(|one| one.std.powi(-2)).sum();
    Some(found.iter().map(|one| one.base / (one.std * one.std)).sum::<f64>() / weight)
}

/// The tone's own line of a run, in what the lines of the excitation leave.
fn at_tone(case: &Case, run: usize, omega: f64) -> Option<RunLines> {
    let record = &case.records[run];
    let projector = Projector::new(lines(case, run, omega)).ok()?;
    let (mut acceleration, mut deviation) = (Vec::new(), Vec::new());
    for (channel, noise) in record.residual.iter().zip(&record.noise) {
        let found = projector.project(channel).ok()?.harmonics;
        let least = noise * (2.0 / record.samples as f64).sqrt();
        acceleration.push(vec![Complex64::ZERO, *found.coefficients.get(1)?]);
        deviation.push(vec![1.0, (0.5 * found.variance.get(1)?).sqrt().max(least)]);
    }
    Some(RunLines {
        omega,
        force: vec![Complex64::ZERO; 2],
        acceleration,
        deviation,
        known_force: Vec::new(),
        contact_order: 1,
        samples: 16,
        ..record.lines.clone()
    })
}

/// What the base makes of sensors, slip and end: the balance of the motion that is the base's alone.
fn motions(
    case: &Case,
    (setting, mut lines): (&Setting, Vec<RunLines>),
    balances: &[Balance],
) -> Result<Vec<ToneMotion>, ExplainError> {
    let mut found: Vec<ToneMotion> = Vec::new();
    for (lines, balance) in lines.iter_mut().zip(balances) {
        for (s, acceleration) in lines.acceleration.iter_mut().enumerate() {
            acceleration[1] -=
                balance.left[s][1] * lines.deviation[s][1] + balance.gain[s][1] * balance.force[1];
        }
        let base = balance.beside.first().map_or(Complex64::ZERO, |lines| lines[1]);
        let acceleration = lines.acceleration.iter().map(|lines| lines[1]).collect();
        found.push(ToneMotion { base: -base * lines.omega.powi(2), acceleration, ..ToneMotion::default() });
    }
    let known = balances.iter().map(|b| b.beside.first().cloned().unwrap_or_default()).collect();
    let moving = Setting {
        base: Some([1.0, 0.0]),
        base_line: None,
        base_motion: Some(Arc::new(known)),
        ..setting.clone()
    };
    let runs: Vec<usize> = (0..lines.len()).collect();
    let model = AccelerationModel::new(case.rig.clone(), lines)?;
    for (motion, balance) in found.iter_mut().zip(model.balance(&moving, &runs)?) {
        (motion.slip, motion.end) = (balance.slip[1], balance.end[1]);
    }
    Ok(found)
}

#[cfg(test)]
mod tests {
    use super::{BALANCE_CLOSED, TAKEN, asks};

    /// A motion of the base is asked for where the balance is open without it and closed with it. One that is closed without it asks for none, whatever share of its
    /// χ² that takes: the noise about a line of a quasi-periodic motion is that motion, beside which both are small. Nor does one that no motion of the base closes.
    #[test]
    fn a_balance_that_is_closed_asks_for_no_motion_of_the_base() {
        let [closed, open] = [0.9 * BALANCE_CLOSED, 1.1 * BALANCE_CLOSED / TAKEN];
        assert!(asks([open, closed]));
        assert!(!asks([closed, 0.5 * TAKEN * closed]));
        assert!(!asks([open, 1.1 * BALANCE_CLOSED]));
    }
}
