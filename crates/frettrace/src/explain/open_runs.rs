//! Runs without a period beside periodic ones: whether their balance is closed, too, and by what it would be.

use super::aperiodic::whole;
use super::identification;
use crate::reconstruct::FormChoice;
use crate::{StudyError, case};
use frettrace_explain::aperiodic::open_place;
use frettrace_explain::{BALANCE_CLOSED, Case, Outcome, SeenSupport, peak_from_rest};
use frettrace_inverse::{Form, RunReconstruction};
use frettrace_measurement::{MeasuredModes, Measurement, SecondSupport};
use rayon::prelude::*;
use std::ops::Range;

/// Places along the beam that are tried for a further force, and how often the distance about the best is halved.
const PLACES: usize = 16;
const CLOSER: usize = 5;

/// Asks runs without a period what no contact force makes of them, where nothing outside the contact is said to be missing: with the structure of
/// the fit, a force along the beam that rests closes their balance, or something without a name is missing.
pub(super) fn ask(
    measurement: &Measurement,
    (case, recovered): (&Case, &[RunReconstruction]),
    outcome: &mut Outcome,
) -> Result<(), StudyError> {
    let Some(last) = measurement.modes.as_ref().and_then(|modes| modes.frequency.last().copied()) else {
        // Of a structure that nobody measured no run says more than the fit to the others.
        return Ok(());
    };
    if measurement.second_support.is_some() || !outcome.leaves_the_balance(case) {
        return Ok(());
    }
    let suspects: Vec<usize> = (0..recovered.len()).filter(|&run| is_open(&recovered[run], last)).collect();
    if suspects.is_empty() {
        return Ok(());
    }
    let asked = Suspects::new(measurement, outcome, &suspects);
    let runs = asked.recovered(None)?;
    let worst = worst(&runs);
    if worst <= BALANCE_CLOSED {
        return Ok(());
    }
    let ids: Vec<&str> = asked.0.runs.iter().map(|run| run.id.as_str()).collect();
    let found = format!(
        "no contact force closes the balance of runs without a period ({}; χ² per degree of freedom {worst:.2}, with the fitted structure)",
        ids.join(", ")
    );
    if let Some(support) = asked.support()? {
        let [place, force] = [support.seen.position[0], support.seen.force[0]];
        let note = format!(
            "{found}: one more force, at {place:.4} m, does ({:.2}); it rests most of the time, and is {force:.3} N at most: a stop that the beam reaches in no other run",
            support.reduced
        );
        outcome.with_support(case, support.seen, note);
        return Ok(());
    }
    let whole: Vec<_> =
        suspects.iter().copied().zip(&runs).filter_map(|(k, run)| Some((k, whole(run)?))).collect();
    let (place, why) = open_place(case, &case::samples(measurement), &whole)?;
    outcome.left_open(place, format!("{found}: {why}"));
    Ok(())
}

/// Whether no contact force closes the balance of a run without a period: over the whole spectrum, for noise is stated as a whole and may have a
/// colour, and more up to the last measured mode (Hz) than beyond: a mode that was not measured leaves what it does about itself, and a tail below.
fn is_open(run: &RunReconstruction, last: f64) -> bool {
    let balance = &run.balance;
    let spacing = run.lines.sampling_rate / run.lines.samples as f64;
    let known = ((last / spacing) as usize).min(balance.chi_square.len());
    let reduced = |bins: Range<usize>| {
        let freedom: usize = balance.freedom[bins.clone()].iter().sum();
        balance.chi_square[bins].iter().sum::<f64>() / freedom.max(1) as f64
    };
    run.lines.form == Form::Aperiodic
        && balance.reduced() > BALANCE_CLOSED
        && reduced(0..known) > reduced(known..balance.chi_square.len())
}

/// χ² per degree of freedom of the worst of some runs.
fn worst(runs: &[RunReconstruction]) -> f64 {
    runs.iter().map(|run| run.balance.reduced()).fold(0.0, f64::max)
}

/// Runs whose balance is open, with the structure of the fit.
struct Suspects(Measurement);

/// A support that closes the balance: of the worst run, by χ² per degree of freedom.
struct Found {
    seen: SeenSupport,
    reduced: f64,
}

impl Suspects {
    fn new(measurement: &Measurement, outcome: &Outcome, runs: &[usize]) -> Self {
        let mut part = case::selected(measurement, runs);
        let fitted = identification(measurement, &measurement.support.law, &outcome.model).structure.modes;
        let known = fitted
            .iter()
            .take_while(|mode| mode.frequency.std.is_finite() && mode.damping_ratio.std.is_finite());
        let modes: Vec<_> = known.collect();
        if !modes.is_empty() {
            part.modes = Some(MeasuredModes {
                frequency: modes.iter().map(|mode| mode.frequency.value).collect(),
                frequency_std: modes.iter().map(|mode| mode.frequency.std).collect(),
                damping_ratio: modes.iter().map(|mode| mode.damping_ratio.value).collect(),
                damping_ratio_std: modes.iter().map(|mode| mode.damping_ratio.std).collect(),
            });
        }
        Self(part)
    }

    /// The runs over the whole spectrum, with a force of a second support at a place (m) along the beam, or without one.
    fn recovered(&self, support: Option<f64>) -> Result<Vec<RunReconstruction>, StudyError> {
        let mut measurement = self.0.clone();
        measurement.second_support = support.map(|position| SecondSupport { position });
        case::runs(&measurement, FormChoice::Aperiodic)
    }

    /// The second support that closes the balance of all runs and rests most of the time.
    fn support(&self) -> Result<Option<Found>, StudyError> {
        let length = self.0.beam.length;
        let at = |position: f64| {
            let runs = self.recovered(Some(position))?;
            let chi = runs.iter().flat_map(|run| &run.balance.chi_square).sum::<f64>();
            Ok::<_, StudyError>((position, chi))
        };
        let mut step = length / PLACES as f64;
        // Where a place leaves nothing to recover, it is none.
        let mut tried: Vec<(f64, f64)> =
            (1..PLACES).into_par_iter().filter_map(|k| at(step * k as f64).ok()).collect();
        if tried.is_empty() {
            return Ok(None);
        }
        for _ in 0..CLOSER {
            let (best, _) = least(&tried);
            step *= 0.5;
            tried.par_extend([best - step, best + step].into_par_iter().filter_map(|place| at(place).ok()));
        }
        let (position, _) = least(&tried);
        let runs = self.recovered(Some(position))?;
        let reduced = worst(&runs);
        if reduced > BALANCE_CLOSED {
            return Ok(None);
        }
        let forces = runs.iter().filter_map(|run| run.second_support_force.as_ref());
        let peaks: Option<Vec<[f64; 2]>> = forces
            .map(|force| {
                let std = force.std.iter().map(|std| std * std).sum::<f64>() / force.std.len().max(1) as f64;
                Some([peak_from_rest(&force.values)?, std.sqrt()])
            })
            .collect();
        let largest = peaks.and_then(|peaks| peaks.into_iter().max_by(|a, b| a[0].total_cmp(&b[0])));
        Ok(largest.map(|force| Found {
            seen: SeenSupport { position: [position, curvature(&tried, reduced.max(1.0))], force },
            reduced,
        }))
    }
}

fn least(tried: &[(f64, f64)]) -> (f64, f64) {
    tried.iter().copied().min_by(|a, b| a.1.total_cmp(&b.1)).unwrap_or((f64::NAN, f64::INFINITY))
}

/// Standard deviation of the place where `χ²(x)` is least, in units of a variance: of the parabola through it and the nearest on either side.
fn curvature(tried: &[(f64, f64)], variance: f64) -> f64 {
    let (x, chi) = least(tried);
    let nearest = |side: f64| {
        let there = tried.iter().filter(|(place, _)| (place - x) * side > 0.0);
        there.min_by(|a, b| (a.0 - x).abs().total_cmp(&(b.0 - x).abs())).copied()
    };
    let (Some(below), Some(above)) = (nearest(-1.0), nearest(1.0)) else { return f64::INFINITY };
    let slope = |(place, other): (f64, f64)| (other - chi) / (place - x);
    let half_curvature = (slope(above) - slope(below)) / (above.0 - below.0);
    if half_curvature > 0.0 { (variance / half_curvature).sqrt() } else { f64::INFINITY }
}

#[cfg(test)]
mod tests {
    use super::curvature;

    /// `χ² = 40 + (x − 0.3)²/σ²`.
    #[test]
    fn a_parabola_tells_its_width() {
        let at = |x: f64| (x, 40.0 + ((x - 0.3) / 0.02_f64).powi(2));
        let tried: Vec<(f64, f64)> = [0.1, 0.29, 0.32, 0.5].map(at).to_vec();
        assert!((curvature(&tried, 1.0) - 0.02).abs() < 1e-12);
        assert!((curvature(&tried, 4.0) - 0.04).abs() < 1e-12);
        assert_eq!(curvature(&tried[..1], 1.0), f64::INFINITY);
    }
}
