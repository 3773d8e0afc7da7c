//! Runs without a period beside periodic ones: whether their balance is closed, too, and by what it would be.

use super::aperiodic::whole;
use super::identification;
use crate::reconstruct::{FormChoice, ReconstructOptions, reconstruct};
use crate::{Progress, StudyError, case};
use frettrace_explain::aperiodic::open_place;
use frettrace_explain::{BALANCE_CLOSED, Case, Outcome, SeenSupport, peak_from_rest};
use frettrace_inverse::{Form, RunReconstruction};
use frettrace_measurement::{MeasuredModes, Measurement, SecondSupport};
use rayon::prelude::*;

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
    let open = |run: &RunReconstruction| Balance::of(run, last).is_open();
    let suspects: Vec<usize> = (0..recovered.len()).filter(|&run| open(&recovered[run])).collect();
    if suspects.is_empty() {
        return Ok(());
    }
    let asked = Suspects::new(measurement, outcome, &suspects, last);
    let runs = asked.recovered(None)?;
    let [_, worst] = asked.judged(&runs);
    if worst <= BALANCE_CLOSED {
        return Ok(());
    }
    let ids: Vec<&str> = asked.measurement.runs.iter().map(|run| run.id.as_str()).collect();
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

/// χ² of what no force makes of a run without a period, with its degrees of freedom: up to the last measured mode, and beyond.
#[derive(Clone, Copy, Default)]
struct Balance {
    known: [f64; 2],
    beyond: [f64; 2],
}

impl Balance {
    fn of(run: &RunReconstruction, last: f64) -> Self {
        let mut balance = Self::default();
        if run.lines.form != Form::Aperiodic || run.contact.is_none() {
            return balance;
        }
        let spacing = run.lines.sampling_rate / run.lines.samples as f64;
        let bins = run.balance.chi_square.iter().zip(&run.balance.freedom);
        for (k, (chi, freedom)) in bins.enumerate() {
            let known = (k + 1) as f64 * spacing <= last;
            let part = if known { &mut balance.known } else { &mut balance.beyond };
            part[0] += chi;
            part[1] += *freedom as f64;
        }
        balance
    }

    fn chi(&self) -> f64 {
        self.known[0] + self.beyond[0]
    }

    /// χ² per degree of freedom over the whole spectrum: noise is stated as a whole, and may have a colour.
    fn reduced(&self) -> f64 {
        self.chi() / f64::max(self.known[1] + self.beyond[1], 1.0)
    }

    /// A mode that was not measured leaves what it does about itself, and a tail of it below.
    fn is_open(&self) -> bool {
        let [known, beyond] = [self.known, self.beyond].map(|[chi, freedom]| chi / freedom.max(1.0));
        self.reduced() > BALANCE_CLOSED && known > beyond
    }
}

/// Runs whose balance is open, with the structure of the fit.
struct Suspects {
    measurement: Measurement,
    last: f64,
}

/// A support that closes the balance: of the worst run, by χ² per degree of freedom.
struct Found {
    seen: SeenSupport,
    reduced: f64,
}

impl Suspects {
    fn new(measurement: &Measurement, outcome: &Outcome, runs: &[usize], last: f64) -> Self {
        let mut part = measurement.clone();
        part.runs = runs.iter().map(|&run| measurement.runs[run].clone()).collect();
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
        Self { measurement: part, last }
    }

    /// The runs over the whole spectrum, with a force of a second support at a place (m) along the beam, or without one.
    fn recovered(&self, support: Option<f64>) -> Result<Vec<RunReconstruction>, StudyError> {
        let mut measurement = self.measurement.clone();
        measurement.second_support = support.map(|position| SecondSupport { position });
        let options = ReconstructOptions { form: FormChoice::Aperiodic, ..ReconstructOptions::default() };
        Ok(reconstruct(&measurement, &options, &Progress::silent())?.inverse.runs)
    }

    /// χ² of the balance of all runs, and that per degree of freedom of the worst.
    fn judged(&self, runs: &[RunReconstruction]) -> [f64; 2] {
        let each = runs.iter().map(|run| Balance::of(run, self.last));
        each.fold([0.0, 0.0], |[sum, worst], one| [sum + one.chi(), worst.max(one.reduced())])
    }

    /// The second support that closes the balance of all runs and rests most of the time.
    fn support(&self) -> Result<Option<Found>, StudyError> {
        let length = self.measurement.beam.length;
        let at = |position: f64| {
            let runs = self.recovered(Some(position))?;
            let [chi, _] = self.judged(&runs);
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
        let [_, reduced] = self.judged(&runs);
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
