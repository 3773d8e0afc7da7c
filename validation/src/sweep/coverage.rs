//! Coverage: how often the truth lies in the bands and intervals that the program states.
//!
//! The clean sets of the plan go through `reconstruct` and `identify`: the bands of friction force, slip and slip velocity
//! should hold the true history at 95 % of the samples, the intervals of the parameters the true value in 95 % of the rigs.
//!
//! The intervals allow for sensors that keep their calibration to 5·10⁻⁴, and for a rig that is known to as much, besides the noise. For
//! `identify` the rigs have such sensors and such a load cell under the support; perfect ones would find every interval too wide.

use super::Finished;
use super::apart::NotMade;
use super::made::{Made, make};
use super::plan::Planned;
use frettrace::Progress;
use frettrace::identify::{IdentifyOptions, identify};
use frettrace::reconstruct::{ReconstructOptions, reconstruct};
use frettrace::rig::parameter_key;
use frettrace_friction::Law;
use frettrace_identify::HALF_INTERVAL95;
use frettrace_measurement::{Measurement, Recording};
use rand::SeedableRng;
use rand_distr::{Distribution, StandardNormal};
use rand_pcg::Pcg64;
use serde::{Deserialize, Serialize};

/// What became of a clean set.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Covered {
    /// Name in the plan.
    pub name: String,
    /// For friction force, slip and slip velocity: median over the runs of the relative error.
    pub error: Vec<f64>,
    /// For the same three: share of the samples of all runs inside the 95 % band.
    pub inside: Vec<f64>,
    /// The identifiable parameters.
    pub parameters: Vec<CoveredParameter>,
    /// Why it failed.
    pub failure: Option<String>,
    /// Whether it could not be made: no rig settles, or not in time.
    #[serde(default)]
    pub unmade: bool,
}

/// An identified parameter beside the truth.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct CoveredParameter {
    /// Law and parameter.
    pub name: String,
    /// Relative error.
    pub error: f64,
    /// Error in standard deviations: the truth's distance from the estimate over the half interval on its side, times
    /// 1.96. An honest interval has a root mean square of 1 here; coverage alone does not tell narrow from wide.
    pub deviation: f64,
}

impl CoveredParameter {
    /// Whether the interval of 95 % holds the truth.
    #[must_use]
    pub fn is_inside(&self) -> bool {
        self.deviation.abs() <= HALF_INTERVAL95
    }
}

impl Finished for Covered {
    fn name(&self) -> &str {
        &self.name
    }
}

/// Relative standard deviation of the gains of the sensors, one draw a sensor for all runs, and of the declared preload, one draw for all.
const CALIBRATION: f64 = 5e-4;

impl Covered {
    /// A set without an answer; that is one too.
    #[must_use]
    pub fn failed(planned: &Planned, error: &anyhow::Error) -> Self {
        Self {
            name: planned.name.clone(),
            failure: Some(format!("{error:#}")),
            unmade: error.is::<NotMade>(),
            ..Self::default()
        }
    }
}

/// Makes a planned set, says so, and compares; a failure is an answer too.
#[must_use]
pub fn cover(planned: &Planned, is_made: impl FnOnce()) -> Covered {
    let made = match make(planned) {
        Ok(made) => made,
        Err(error) => return Covered { unmade: true, ..Covered::failed(planned, &error) },
    };
    is_made();
    let mut covered = Covered { name: planned.name.clone(), ..Covered::default() };
    let outcome = histories(&made, &mut covered).and_then(|()| parameters(&made, planned.seed, &mut covered));
    covered.failure = outcome.err().map(|error| format!("{error:#}"));
    covered
}

/// Root mean square of what is left of values when their mean is taken away.
fn spread(values: &[f64]) -> f64 {
    let mean = values.iter().sum::<f64>() / values.len() as f64;
    (values.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / values.len() as f64).sqrt()
}

fn histories(made: &Made, covered: &mut Covered) -> anyhow::Result<()> {
    let found =
        reconstruct(&made.simulation.measurement, &ReconstructOptions::default(), &Progress::silent())?;
    let runs = || found.inverse.runs.iter().zip(&made.simulation.truth.runs);
    for channel in 0..3 {
        let (mut errors, mut inside, mut count) = (Vec::new(), 0, 0);
        for (run, truth) in runs() {
            let (estimate, truth) = match channel {
                0 => (&run.friction_force, &truth.friction_force),
                1 => (&run.slip_displacement, &truth.slip_displacement),
                _ => (&run.slip_velocity, &truth.slip_velocity),
            };
            // Means cannot be seen by accelerometers.
            let difference: Vec<f64> = estimate.values.iter().zip(truth).map(|(a, b)| a - b).collect();
            let mean = difference.iter().sum::<f64>() / difference.len() as f64;
            // A rigid contact that holds all the time has no slip to miss by a share of it; the band is asked all the same.
            errors.extend(Some(spread(&difference) / spread(truth)).filter(|error| error.is_finite()));
            inside += difference
                .iter()
                .zip(&estimate.std)
                .filter(|(d, s)| (**d - mean).abs() <= HALF_INTERVAL95 * **s)
                .count();
            count += difference.len();
        }
        errors.sort_by(f64::total_cmp);
        covered.error.push(errors.get(errors.len() / 2).copied().unwrap_or(0.0));
        covered.inside.push(inside as f64 / count as f64);
    }
    Ok(())
}

/// What sensors of a laboratory's calibration would have recorded, and the preload as its load cell reads it.
#[must_use]
pub fn calibrated(mut measurement: Measurement, seed: u64) -> Measurement {
    // The rig was drawn from the seed itself.
    let mut random = Pcg64::seed_from_u64(!seed);
    let mut draw =
        |_| -> f64 { 1.0 + CALIBRATION * Distribution::<f64>::sample(&StandardNormal, &mut random) };
    let sensors = measurement.runs.first().map_or(0, |run| run.acceleration.len());
    let gains: Vec<f64> = (0..sensors).map(&mut draw).collect();
    let load = draw(sensors);
    for run in &mut measurement.runs {
        run.preload *= load;
        for (channel, gain) in run.acceleration.iter_mut().zip(&gains) {
            channel.iter_mut().for_each(|value| *value *= gain);
        }
    }
    measurement
}

fn parameters(made: &Made, seed: u64, covered: &mut Covered) -> anyhow::Result<()> {
    let measurement = calibrated(made.simulation.measurement.clone(), seed);
    let recording = Recording::Measurement(measurement);
    let found = identify(&recording, &IdentifyOptions::default(), &Progress::silent())?;
    for parameter in Law::from_name(&found.law)?.parameters() {
        let truth = made.rig.support.parameters.get(&parameter_key(parameter));
        let (Some(&truth), Some(estimate)) = (truth, found.parameters.get(parameter.name)) else { continue };
        if estimate.identifiable {
            let [low, high] = estimate.interval95;
            let away = truth - estimate.value;
            let half = if away < 0.0 { estimate.value - low } else { high - estimate.value };
            covered.parameters.push(CoveredParameter {
                name: format!("{} {}", found.law, parameter.name),
                error: away.abs() / truth.abs().max(f64::MIN_POSITIVE),
                deviation: HALF_INTERVAL95 * away / half,
            });
        }
    }
    Ok(())
}

/// The coverage in Markdown.
#[must_use]
pub fn markdown(sets: &[Covered]) -> String {
    let mut text = format!(
        "# Coverage\n\n{} rigs that were made, {} without an answer.\n\n| quantity | rigs | median relative error | share inside | deviation, rms [std] |\n|---|---|---|---|---|\n",
        sets.iter().filter(|set| !set.unmade).count(),
        sets.iter().filter(|set| set.failure.is_some() && !set.unmade).count()
    );
    for (channel, name) in ["friction force", "slip", "slip velocity"].into_iter().enumerate() {
        let rows: Vec<(f64, f64)> = sets
            .iter()
            .filter_map(|set| Some((*set.error.get(channel)?, *set.inside.get(channel)?)))
            .collect();
        let mean = rows.iter().map(|(_, inside)| inside).sum::<f64>() / rows.len().max(1) as f64;
        text += &row(name, rows.iter().map(|(error, _)| *error).collect(), mean, None);
    }
    let mut names: Vec<&str> =
        sets.iter().flat_map(|set| &set.parameters).map(|parameter| parameter.name.as_str()).collect();
    names.sort_unstable();
    names.dedup();
    for name in names.into_iter().map(Some).chain([None]) {
        let all = || {
            let all = sets.iter().flat_map(|set| &set.parameters);
            all.filter(|parameter| name.is_none_or(|name| parameter.name == name))
        };
        let share = |sum: f64| sum / all().count().max(1) as f64;
        text += &row(
            name.unwrap_or("all parameters"),
            all().map(|parameter| parameter.error).collect(),
            share(all().filter(|parameter| parameter.is_inside()).count() as f64),
            Some(share(all().map(|parameter| parameter.deviation.powi(2)).sum()).sqrt()),
        );
    }
    text
}

fn row(name: &str, mut errors: Vec<f64>, inside: f64, deviation: Option<f64>) -> String {
    errors.sort_by(f64::total_cmp);
    let median = errors.get(errors.len() / 2).copied().unwrap_or(f64::NAN);
    let deviation = deviation.map_or_else(|| "-".into(), |deviation| format!("{deviation:.2}"));
    format!(
        "| {name} | {} | {:.2} % | {:.1} % | {deviation} |\n",
        errors.len(),
        100.0 * median,
        100.0 * inside
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two rigs counted by hand.
    #[test]
    fn coverage_is_counted() {
        let one = Covered {
            error: vec![0.01, 0.02, 0.03],
            inside: vec![0.9, 1.0, 0.8],
            parameters: vec![CoveredParameter { name: "mu_k".into(), error: 0.01, deviation: 1.5 }],
            ..Covered::default()
        };
        let missed = CoveredParameter { name: "mu_k".into(), error: 0.02, deviation: -2.5 };
        let other = Covered { parameters: vec![missed], ..one.clone() };
        let text = markdown(&[one, other]);
        assert!(text.contains("| mu_k | 2 | 2.00 % | 50.0 % | 2.06 |"), "{text}");
        assert!(text.contains("| slip velocity | 2 | 3.00 % | 80.0 % | - |"), "{text}");
    }
}
