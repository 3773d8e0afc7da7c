//! What a person looks at: each run as measured, and as both models predict it.

use crate::search::Explained;
use crate::start::histories;
use crate::study::ExplainError;
use crate::{Case, Outcome};
use frettrace_forward::accelerations::{AccelerationModel, Prediction, RunLines};
use frettrace_fourier::Harmonics;
use num_complex::Complex64;

/// Samples of a period that is shown.
const SAMPLES: usize = 240;

/// One period of the contact; means are removed, since accelerometers cannot see them.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Loop {
    /// Slip (m).
    pub slip: Vec<f64>,
    /// Slip velocity (m/s).
    pub velocity: Vec<f64>,
    /// Friction force (N).
    pub force: Vec<f64>,
    /// Energy that friction takes out of the beam in this period, `∮ F v dt` (J).
    pub energy: f64,
}

/// One run: what was measured or recovered without a law, and what the two models predict.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Exhibit {
    /// Index of the run.
    pub run: usize,
    /// The contact recovered without a law.
    pub recovered: Loop,
    /// The contact as the declared model has it, and as the model with the effects.
    pub modelled: [Loop; 2],
    /// Times of the samples of one period (s).
    pub time: Vec<f64>,
    /// Accelerations over one period (m/s²), one vector a sensor: measured, declared model, model with the effects.
    pub acceleration: [Vec<Vec<f64>>; 3],
    /// Residual of each sensor before and after: `√(Σ_h |m_h − p_h|² / 2Hσ_h²)`, 1 for noise alone.
    pub residual: [Vec<f64>; 2],
    /// What the residual is looked at against, over one period.
    pub(crate) traces: Traces,
}

/// One period of what a residual may follow, on the times of an [`Exhibit`].
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Traces {
    /// Slip, slip velocity and normal force of the recovered contact, each over its largest value in the run.
    pub shares: [Vec<f64>; 3],
    /// Residual before and after at each time, quadratic mean over the sensors, in standard deviations of the noise.
    pub residual: [Vec<f64>; 2],
    /// The same for each sensor.
    pub sensors: [Vec<Vec<f64>>; 2],
    /// Mean square acceleration (m²/s⁴).
    pub mean_square: f64,
}

/// Exhibits of all runs that both models can answer; a run that is not periodic has none.
///
/// # Errors
/// [`ExplainError::Model`] where the rig cannot be built at all.
pub fn exhibits(case: &Case, outcome: &Outcome) -> Result<Vec<Exhibit>, ExplainError> {
    let lines = case.records.iter().map(|record| record.lines.clone()).collect();
    let model = AccelerationModel::new(case.rig.clone(), lines)?;
    let [training, held_out] = &outcome.runs;
    let mut runs: Vec<usize> = training.iter().chain(held_out).copied().collect();
    runs.sort_unstable();
    Ok(runs.into_iter().filter_map(|run| exhibit(case, &model, outcome, run)).collect())
}

fn exhibit(case: &Case, model: &AccelerationModel, outcome: &Outcome, run: usize) -> Option<Exhibit> {
    let recovered = histories(case, model, &outcome.model.fitted.setting, &[run]).ok()?.into_iter().next()?;
    let lines = &case.records[run].lines;
    let period = std::f64::consts::TAU / lines.omega;
    let (before, predicted_before) = predicted(model, &outcome.baseline, (run, period))?;
    let (after, predicted_after) = predicted(model, &outcome.model, (run, period))?;
    let sampled = |of: &Prediction| of.iter().map(|x| period_of(lines.omega, x)).collect::<Vec<_>>();
    let residual = |of: &Prediction| -> Vec<f64> {
        let sensors = lines.acceleration.iter().zip(of).zip(&lines.deviation);
        sensors.map(|((measured, predicted), deviation)| reduced(measured, predicted, deviation)).collect()
    };
    let sensors = [&predicted_before, &predicted_after].map(|of| in_time(lines, of));
    Some(Exhibit {
        run,
        recovered: shown([&recovered.slip, &recovered.velocity, &recovered.force], period),
        modelled: [before, after],
        time: (0..SAMPLES).map(|k| period * k as f64 / SAMPLES as f64).collect(),
        residual: [residual(&predicted_before), residual(&predicted_after)],
        traces: Traces {
            shares: [&recovered.slip, &recovered.velocity, &recovered.normal].map(|of| share(of)),
            residual: sensors.each_ref().map(|of| over_sensors(of)),
            sensors,
            mean_square: lines.acceleration.iter().flat_map(|of| &of[1..]).map(|x| 0.5 * x.norm_sqr()).sum(),
        },
        acceleration: [sampled(&lines.acceleration), sampled(&predicted_before), sampled(&predicted_after)],
    })
}

/// A motion at the times of an exhibit, its mean removed, over its largest value.
fn share(values: &[f64]) -> Vec<f64> {
    let mean = values.iter().sum::<f64>() / values.len().max(1) as f64;
    let largest = values.iter().map(|x| (x - mean).abs()).fold(f64::MIN_POSITIVE, f64::max);
    (0..SAMPLES)
        .filter_map(|k| values.get(k * values.len() / SAMPLES))
        .map(|x| (x - mean) / largest)
        .collect()
}

/// `|r_s(t)|/√(Σ_h σ_sh²)` of each sensor with `r(t) = Re Σ_h (m_h − p_h) e^{ihΩt}`: 1 in quadratic mean for noise alone.
fn in_time(lines: &RunLines, predicted: &Prediction) -> Vec<Vec<f64>> {
    let sensors = lines.acceleration.iter().zip(predicted).zip(&lines.deviation);
    let one = |((measured, predicted), deviation): ((&Vec<Complex64>, &Vec<Complex64>), &Vec<f64>)| {
        let known = |h: usize| deviation[h].is_finite() && deviation[h] > 0.0;
        let left = measured.iter().zip(predicted).enumerate();
        let left: Vec<Complex64> =
            left.map(|(h, (m, p))| if known(h) { m - p } else { Complex64::ZERO }).collect();
        let variance: f64 =
            (1..deviation.len()).filter(|h| known(*h)).map(|h| deviation[h] * deviation[h]).sum();
        let std = variance.max(f64::MIN_POSITIVE).sqrt();
        period_of(lines.omega, &left).into_iter().map(|r| r.abs() / std).collect()
    };
    sensors.map(one).collect()
}

/// Quadratic mean over the sensors at every time.
fn over_sensors(of: &[Vec<f64>]) -> Vec<f64> {
    let mean = |t: usize| of.iter().map(|sensor| sensor[t].powi(2)).sum::<f64>() / of.len().max(1) as f64;
    (0..SAMPLES).map(|t| mean(t).sqrt()).collect()
}

fn predicted(
    model: &AccelerationModel,
    found: &Explained,
    (run, period): (usize, f64),
) -> Option<(Loop, Prediction)> {
    let mut memory = found.fitted.memory.clone();
    let setting = &found.fitted.setting;
    let contact = model.contact(setting, run, &mut memory).ok()?;
    let prediction = model.predict(setting, &[run], &mut memory).ok()?.into_iter().next()?;
    Some((shown([&contact.slip, &contact.velocity, &contact.force], period), prediction))
}

/// About [`SAMPLES`] of the samples, without their means; the energy from all of them.
fn shown(columns: [&[f64]; 3], period: f64) -> Loop {
    let [_, velocity, force] = columns;
    let power: f64 = force.iter().zip(velocity).map(|(f, v)| f * v).sum();
    let energy = period * power / force.len().max(1) as f64;
    let [slip, velocity, force] = columns.map(|values| {
        let mean = values.iter().sum::<f64>() / values.len().max(1) as f64;
        let stride = (values.len() / SAMPLES).max(1);
        values.iter().step_by(stride).map(|value| value - mean).collect()
    });
    Loop { slip, velocity, force, energy }
}

/// One period of a signal given by its lines, without its mean.
fn period_of(omega: f64, lines: &[Complex64]) -> Vec<f64> {
    let mut lines = lines.to_vec();
    if let Some(mean) = lines.first_mut() {
        *mean = Complex64::ZERO;
    }
    let rate = SAMPLES as f64 * omega / std::f64::consts::TAU;
    Harmonics::exact(omega, lines).sample(rate, SAMPLES)
}

fn reduced(measured: &[Complex64], predicted: &[Complex64], deviation: &[f64]) -> f64 {
    let terms = measured.iter().zip(predicted).zip(deviation).skip(1);
    let known = terms.filter(|(_, deviation)| deviation.is_finite() && **deviation > 0.0);
    let (sum, count) = known.fold((0.0, 0), |(sum, count), ((m, p), deviation)| {
        (sum + (m - p).norm_sqr() / deviation.powi(2), count + 2)
    });
    (sum / f64::from(count.max(1))).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A difference of one deviation in the real and in the imaginary part of every line is a residual of 1.
    #[test]
    fn noise_alone_has_a_residual_of_one() {
        let measured = vec![Complex64::new(9.0, 0.0), Complex64::new(1.2, 0.2), Complex64::new(0.5, 0.5)];
        let predicted = vec![Complex64::ZERO, Complex64::new(1.0, 0.0), Complex64::ZERO];
        assert!((reduced(&measured, &predicted, &[1.0, 0.2, 0.5]) - 1.0).abs() < 1e-12);
    }

    /// Means go, the shape stays: a cosine of amplitude 2 about 5 spans −2 … 2.
    #[test]
    fn means_are_removed() {
        let wave: Vec<f64> =
            (0..960).map(|k| 5.0 + 2.0 * (std::f64::consts::TAU * f64::from(k) / 960.0).cos()).collect();
        let shown = shown([&wave, &wave, &wave], 2.0);
        assert_eq!(shown.slip.len(), SAMPLES);
        // Mean of (5 + 2 cos)² is 25 + 2, over a period of 2.
        assert!((shown.energy - 54.0).abs() < 1e-10);
        assert!((shown.force[0] - 2.0).abs() < 1e-12);
        let lines = [Complex64::new(5.0, 0.0), Complex64::new(2.0, 0.0)];
        assert!((period_of(10.0, &lines)[0] - 2.0).abs() < 1e-12);
    }
}
