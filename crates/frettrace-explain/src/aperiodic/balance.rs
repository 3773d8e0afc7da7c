//! Where the balance of runs without a period is open, before any law is asked.
//!
//! What no contact force explains is told apart by what it follows:
//!
//! | it | place |
//! |---|---|
//! | vanishes with the accelerations' own frequency in the force's place: a response has the frequency of what excites it | measurement |
//! | has the same size whatever the beam does, and the sensors share it | excitation |
//! | has the same size whatever the beam does, each sensor its own | measurement |
//! | grows with the motion | where one more free value a line of the excitation closes the balance best |

use super::motion::WholeRun;
use crate::effects::EffectPlace;
use crate::records::{RunRecord, RunSamples};
use crate::verdict::{BALANCE_CLOSED, BALANCE_CLOSED_RUN};
use crate::{Case, ExplainError, Study};
use frettrace_forward::accelerations::{AccelerationModel, RunLines, Setting};
use frettrace_fourier::{Lines, refine};
use frettrace_friction::effects::ModifiedLaw;
use nalgebra::DMatrix;
use num_complex::Complex64;
use std::f64::consts::TAU;

/// Where a balance is open, and why.
#[derive(Clone, Debug)]
pub(super) struct Open {
    pub place: EffectPlace,
    /// χ² per degree of freedom of all runs, and of the worst.
    pub reduced: (f64, f64),
    /// What shows the place.
    pub why: String,
}

impl Open {
    /// What a reader must know.
    pub fn note(&self) -> String {
        let (all, worst) = self.reduced;
        format!(
            "no contact force closes the balance without a law (χ² per degree of freedom {all:.2}, {worst:.2} in the worst run): {}",
            self.why
        )
    }
}

/// Runs it takes to tell a trend with the level.
const TREND_RUNS: usize = 3;
/// Range of the power of the motion (a factor of two in amplitude) over which one shows.
const TREND_RANGE: f64 = 4.0;
/// Exponent of what is left in the power of the motion below which it keeps its own size: half way between that (0) and what grows with
/// the motion (1).
const OWN_SIZE: f64 = 0.5;
/// Standard errors from which two frequencies differ.
const OTHER_CLOCK: f64 = 5.0;
/// Bands, equally wide in frequency, in which shared noise is looked for.
const BANDS: usize = 16;
/// Factor over the largest eigenvalue that sensors of independent noise may show from which they share a motion.
const SHARED: f64 = 2.0;

/// χ² per degree of freedom of the balance of all runs, and the worst of one.
pub(super) fn reduced(runs: &[&WholeRun]) -> (f64, f64) {
    let (sum, freedom) =
        runs.iter().fold((0.0, 0.0), |(sum, freedom), run| (sum + run.balance[0], freedom + run.balance[1]));
    (sum / f64::max(freedom, 1.0), runs.iter().map(|run| run.reduced()).fold(0.0, f64::max))
}

/// Whether the balance of all runs closes without a law.
pub(super) fn closed(runs: &[&WholeRun]) -> bool {
    let (all, worst) = reduced(runs);
    all <= BALANCE_CLOSED && worst <= BALANCE_CLOSED_RUN
}

/// Where an open balance is open.
///
/// # Errors
/// [`ExplainError::Model`] where the rig cannot be modelled.
pub(super) fn open(
    case: &Case,
    samples: &[RunSamples<'_>],
    runs: &[(usize, &WholeRun)],
) -> Result<Open, ExplainError> {
    let whole: Vec<&WholeRun> = runs.iter().map(|run| run.1).collect();
    let reduced = reduced(&whole);
    let open = |place, why: &str| Open { place, reduced, why: why.to_owned() };
    if let Some(late) = clocks(case, samples) {
        return Ok(open(
            EffectPlace::Measurement,
            &format!(
                "the accelerations' frequency is {late:+.0} ppm off the force's in every run, and with their own frequency the runs are periodic: the channels have different clocks; record them with one"
            ),
        ));
    }
    if keeps_its_size(case, runs) {
        return Ok(if is_shared(&whole) {
            open(
                EffectPlace::Excitation,
                "what is left has the same size at all levels, and the sensors share it: something beside the exciter moves the beam",
            )
        } else {
            open(
                EffectPlace::Measurement,
                "what is left has the same size at all levels, each sensor its own: more noise than is stated",
            )
        });
    }
    let study = study(case)?;
    let (place, _) = study.open_place(&declared(case));
    Ok(open(place, "what is left grows with the motion"))
}

pub(super) fn declared(case: &Case) -> Setting {
    case.setting(ModifiedLaw::dahl(1.0, 1.0))
}

/// All runs by what the lines of the excitation hold of them: at these the balance is linear whatever lies between.
fn study(case: &Case) -> Result<Study<'_>, ExplainError> {
    balanced(case, case.records.iter().map(|record| record.lines.clone()).collect())
}

/// A study of the balance of all runs on some lines.
pub(super) fn balanced(case: &Case, lines: Vec<RunLines>) -> Result<Study<'_>, ExplainError> {
    Ok(Study {
        case,
        training: (0..lines.len()).collect(),
        model: AccelerationModel::new(case.rig.clone(), lines)?,
        held_out: Vec::new(),
        scales: crate::Scales { length: case.rig.beam.length, ..Default::default() },
        series: Vec::new(),
        support: None,
        fine: None,
    })
}

/// Parts in a million by which the clock of the accelerations is ahead of the force's, where it is in every run and runs are periodic by
/// their own clock.
fn clocks(case: &Case, samples: &[RunSamples<'_>]) -> Option<f64> {
    let apart: Vec<(f64, f64)> = samples.iter().map(frequencies_apart).collect::<Option<_>>()?;
    let weight: f64 = apart.iter().map(|(_, std)| std.powi(-2)).sum();
    let mean = apart.iter().map(|(apart, std)| apart / (std * std)).sum::<f64>() / weight;
    // What beside the excitation disturbs a frequency differs from run to run.
    let scatter = apart.iter().map(|(apart, std)| ((apart - mean) / std).powi(2)).sum::<f64>();
    let inflation = (scatter / (apart.len() as f64 - 1.0).max(1.0)).max(1.0);
    let told = mean.abs() > OTHER_CLOCK * (inflation / weight).sqrt();
    let same = apart.iter().all(|(apart, _)| apart * mean > 0.0);
    if !told || !same || apart.len() < TREND_RUNS {
        return None;
    }
    let noise: Vec<f64> = case.records.first()?.noise.clone();
    let by_own = samples.iter().filter(|run| on_own_clock(run, mean, &noise)).count();
    (2 * by_own > samples.len()).then_some(1e6 * mean)
}

/// Relative difference of the frequencies of accelerations and force, and its standard deviation.
pub(super) fn frequencies_apart(run: &RunSamples<'_>) -> Option<(f64, f64)> {
    let lines = |order| Lines {
        base: TAU * run.excitation_frequency,
        order,
        samples: run.force.len(),
        sampling_rate: run.sampling_rate,
        drift: 0,
    };
    let force = refine(lines(3), &[run.force]).ok()?;
    let channels: Vec<&[f64]> = run.acceleration.iter().map(Vec::as_slice).collect();
    let moved = refine(Lines { base: force.base, ..lines(3) }, &channels).ok()?;
    let std = force.std.hypot(moved.std) / force.base;
    std.is_finite().then_some((moved.base / force.base - 1.0, std))
}

/// Whether a run is periodic where its force has the frequency of its accelerations.
fn on_own_clock(run: &RunSamples<'_>, ahead: f64, noise: &[f64]) -> bool {
    let force = stretched(run.force, ahead);
    let stretched = RunSamples {
        force: &force,
        excitation_frequency: run.excitation_frequency * (1.0 + ahead),
        acceleration: run.acceleration,
        ..*run
    };
    RunRecord::new(&stretched, Some(noise), 0.5).is_ok_and(|record| record.periodic)
}

/// A signal as a clock reads it that is so far ahead: cubic interpolation at `(1 + ahead) j`, the last samples held.
pub(super) fn stretched(x: &[f64], ahead: f64) -> Vec<f64> {
    let last = x.len().saturating_sub(1);
    let at = |k: isize| x[k.clamp(0, last as isize) as usize];
    (0..x.len())
        .map(|j| {
            let place = (1.0 + ahead) * j as f64;
            let (k, s) = (place.floor() as isize, place.fract());
            let [a, b, c, d] = [at(k - 1), at(k), at(k + 1), at(k + 2)];
            b + 0.5 * s * (c - a + s * (2.0 * a - 5.0 * b + 4.0 * c - d + s * (3.0 * (b - c) + d - a)))
        })
        .collect()
}

/// Whether what is left does not grow with the motion: the slope of its logarithm over that of the motion's power.
fn keeps_its_size(case: &Case, runs: &[(usize, &WholeRun)]) -> bool {
    let points: Vec<[f64; 2]> = runs
        .iter()
        .map(|(index, run)| [case.records[*index].power.iter().sum::<f64>(), run.reduced() - 1.0])
        .filter(|[power, excess]| *power > 0.0 && *excess > 0.0)
        .map(|point| point.map(f64::ln))
        .collect();
    if points.len() < TREND_RUNS || points.len() < runs.len() {
        return false;
    }
    let count = points.len() as f64;
    let mean: [f64; 2] = std::array::from_fn(|i| points.iter().map(|p| p[i]).sum::<f64>() / count);
    let spread: f64 = points.iter().map(|p| (p[0] - mean[0]).powi(2)).sum();
    let along: f64 = points.iter().map(|p| (p[0] - mean[0]) * (p[1] - mean[1])).sum();
    let ends = points.iter().map(|p| p[0]);
    let range = ends.clone().fold(f64::NEG_INFINITY, f64::max) - ends.fold(f64::INFINITY, f64::min);
    range > TREND_RANGE.ln() && along < OWN_SIZE * spread
}

/// Whether the sensors share what is left: in some band the largest eigenvalue of their correlation matrix exceeds what independent noise of
/// `n` complex values at `S` sensors may show, `(1 + √(S/n))²` (Marchenko and Pastur 1967).
pub(super) fn is_shared(runs: &[&WholeRun]) -> bool {
    let bands = runs.iter().flat_map(|run| run.left.chunks(run.left.len().div_ceil(BANDS).max(1)));
    bands.into_iter().any(|band| {
        let sensors = band.first().map_or(0, Vec::len);
        if band.len() < 2 * sensors || sensors < 2 {
            return false;
        }
        let product = |a: usize, b: usize| band.iter().map(|bin| bin[a] * bin[b].conj()).sum::<Complex64>();
        let size: Vec<f64> = (0..sensors).map(|s| product(s, s).re.max(f64::MIN_POSITIVE).sqrt()).collect();
        let matrix = DMatrix::from_fn(sensors, sensors, |a, b| product(a, b) / (size[a] * size[b]));
        let largest = matrix.symmetric_eigenvalues().max();
        largest > SHARED * (1.0 + (sensors as f64 / band.len() as f64).sqrt()).powi(2)
    })
}
