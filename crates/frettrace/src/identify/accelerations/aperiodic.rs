//! Runs that are not periodic: no waveform is predicted, the law is driven along the recovered motion instead.
//!
//! Residuals are recovered minus answered force in the bins of the record that the sensors know, over `σ_F·|1 + κR|`: an
//! error of the recovered force moves the recovered slip by the receptance `R` times as much, and that moves the answer by
//! the stiffness `κ = σ0 N`. What drift, taper and structure leave is common to the bins of a run: together they may tell its
//! force no better than to [`ACCURACY`].

use crate::StudyError;
use frettrace_explain::{Case, ExplainError, Series, Study, slip_receptance};
use frettrace_forward::accelerations::{Quantity, RunLines, Setting};
use frettrace_friction::effects::{Circumstance, Hook, ModifiedLaw};
use frettrace_identify::contact::{Closure, ContactHistory};
use frettrace_identify::{NoSolution, Parameter};
use num_complex::Complex64;

/// Relative accuracy of the force recovered of one run.
pub(super) const ACCURACY: f64 = 0.01;
/// Deviations that a bin must exceed to be compared.
const KNOWN: f64 = 3.0;
/// Samples of a record that the first steps of the identification see.
const HISTORY: usize = 1024;
/// Share of a parameter over which its effect is differenced.
const DIFFERENCE: f64 = 1e-4;

/// All runs that are not periodic but were recovered.
pub(super) struct Aperiodic {
    /// Their indices.
    pub(super) runs: Vec<usize>,
    records: Vec<Record>,
}

/// One of them.
struct Record {
    series: Series,
    circumstance: Circumstance,
    /// Recovered force with the velocity's share, which a rigid contact takes as long as it holds.
    trial: Vec<f64>,
    /// Bins compared, with their deviations (N).
    bins: Vec<(usize, f64)>,
    measured: Vec<Complex64>,
}

impl Aperiodic {
    /// Prepares the runs of a study whose contact has been recovered over the whole spectrum.
    ///
    /// # Errors
    /// [`StudyError`] where the structure cannot be built.
    pub(super) fn new(study: &Study<'_>, setting: &Setting) -> Result<Self, StudyError> {
        let (mut runs, mut records) = (Vec::new(), Vec::new());
        for (run, record) in study.case.records.iter().enumerate() {
            let Some(series) = record.series.as_ref().filter(|_| !record.periodic) else { continue };
            if let Some(prepared) = Record::new(study, setting, (&record.lines, series))? {
                runs.push(run);
                records.push(prepared);
            }
        }
        Ok(Self { runs, records })
    }

    /// Real residuals of each run.
    pub(super) fn sizes(&self) -> Vec<usize> {
        self.records.iter().map(|record| 2 * record.bins.len()).collect()
    }

    /// Residuals of all runs under a setting.
    pub(super) fn residual(&self, setting: &Setting, out: &mut [f64]) -> Result<(), NoSolution> {
        let mut rest = out;
        for record in &self.records {
            let (own, more) = rest.split_at_mut(2 * record.bins.len());
            record.residual((&setting.law, setting.holds_rigidly()), own);
            // Far from the contact's own values a march along a recovered motion may have no finite answer.
            if own.iter().any(|left| !left.is_finite()) {
                return Err(NoSolution);
            }
            rest = more;
        }
        Ok(())
    }

    /// Their derivatives by the parameters of the law, differenced.
    pub(super) fn derivative(
        &self,
        (setting, plain): (&Setting, &[f64]),
        (quantity, described): (Quantity, &Parameter),
    ) -> Result<Vec<f64>, NoSolution> {
        let mut moved = vec![0.0; plain.len()];
        let (Quantity::Law(_), Some(value)) = (quantity, setting.get(quantity)) else { return Ok(moved) };
        let distance = described.difference(value, DIFFERENCE);
        let mut beside = setting.clone();
        beside.set(quantity, value + distance);
        self.residual(&beside, &mut moved)?;
        moved.iter_mut().zip(plain).for_each(|(moved, plain)| *moved = (*moved - plain) / distance);
        Ok(moved)
    }
}

impl Record {
    /// `None` where no bin of the force is known.
    fn new(
        study: &Study<'_>,
        setting: &Setting,
        (lines, series): (&RunLines, &Series),
    ) -> Result<Option<Self>, ExplainError> {
        let measured = Series::amplitudes(&series.force);
        let deviation = |k: usize| series.deviation_of(k, series.force.len());
        // The taper ties neighbours together: every second bin is independent of the others.
        let known: Vec<usize> =
            (2..measured.len()).step_by(2).filter(|&k| measured[k].norm() > KNOWN * deviation(k)).collect();
        let Some(&highest) = known.last() else { return Ok(None) };
        let gain = slip_receptance(study.case, setting, (spacing(series), highest + 1))?;
        let spacing = spacing(series);
        let resistance = known.iter().map(|&k| -(gain[k].norm() * k as f64 * spacing).ln()).sum::<f64>();
        let resistance = (resistance / known.len() as f64).exp();
        let rigid = setting.holds_rigidly();
        let stiffness = setting.law.get(Hook::Sigma0).unwrap_or_default() * lines.preload;
        let slope = |k: usize| {
            let held = Complex64::new(0.0, resistance * k as f64 * spacing);
            (1.0 + gain[k] * if rigid { held } else { Complex64::from(stiffness) }).norm().max(1.0)
        };
        let mut bins: Vec<(usize, f64)> = known.iter().map(|&k| (k, deviation(k) * slope(k))).collect();
        share_accuracy(&measured, &mut bins);
        let trial = series.force.iter().zip(&series.velocity).map(|(f, v)| f + resistance * v).collect();
        let circumstance = lines.circumstance();
        Ok(Some(Self { series: series.clone(), circumstance, trial, bins, measured }))
    }

    fn residual(&self, (law, rigid): (&ModifiedLaw<f64>, bool), out: &mut [f64]) {
        let trial = rigid.then_some(&self.trial[..]);
        let answered = Series::amplitudes(&self.series.answer(law, &self.circumstance, trial));
        for (pair, (k, deviation)) in out.chunks_mut(2).zip(&self.bins) {
            let left = (self.measured[*k] - answered[*k]) / *deviation;
            pair.copy_from_slice(&[left.re, left.im]);
        }
    }
}

/// The last samples of the recovered runs as histories with a beginning and an end, the first tenth of which only settles the
/// law.
pub(super) fn histories(case: &Case) -> Vec<ContactHistory> {
    let runs = case.records.iter().enumerate().filter(|(_, record)| !record.periodic);
    runs.filter_map(|(run, record)| record.series.as_ref().map(|series| history(run, series))).collect()
}

fn history(run: usize, of: &Series) -> ContactHistory {
    let from = of.force.len().saturating_sub(HISTORY);
    let peak = of.force.iter().fold(0.0_f64, |m, f| f.abs().max(m));
    let noise: f64 = of.deviation.iter().filter(|d| d.is_finite()).map(|d| d * d).sum();
    let samples = of.force.len() - from;
    ContactHistory {
        label: format!("run {}", run + 1),
        time: (0..samples).map(|k| k as f64 * of.dt).collect(),
        slip: of.slip[from..].to_vec(),
        velocity: of.velocity[from..].to_vec(),
        acceleration: None,
        normal: of.normal[from..].to_vec(),
        force: of.force[from..].to_vec(),
        closure: Closure::Open,
        mean_is_seen: false,
        force_std: noise.sqrt().max(ACCURACY * peak).max(1e-12),
        draws: Vec::new(),
        first: Series::settling(samples),
    }
}

/// Widens the deviations of the bins until all of them together tell the size of the force no better than to [`ACCURACY`].
fn share_accuracy(measured: &[Complex64], bins: &mut [(usize, f64)]) {
    let told: f64 = bins.iter().map(|(k, deviation)| (measured[*k].norm() / deviation).powi(2)).sum();
    let inflation = (ACCURACY * told.sqrt()).max(1.0);
    bins.iter_mut().for_each(|(_, deviation)| *deviation *= inflation);
}

/// Angular frequency from one bin to the next (rad/s).
fn spacing(series: &Series) -> f64 {
    let kept = series.force.len() - Series::settling(series.force.len());
    std::f64::consts::TAU / (kept.max(1) as f64 * series.dt)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A record of a slip of two incommensurable tones with the force of a law along it.
    fn record(law: &ModifiedLaw<f64>) -> Record {
        let at = |k: usize| {
            let t = k as f64 / 2048.0;
            let (a, b) = (2.0 * std::f64::consts::PI * 20.0, 2.0 * std::f64::consts::PI * 13.7);
            let slip = 1e-4 * ((a * t).sin() + 0.6 * (b * t).cos());
            (slip, 1e-4 * (a * (a * t).cos() - 0.6 * b * (b * t).sin()))
        };
        let (slip, velocity) = (0..4096).map(at).unzip();
        let normal = vec![20.0; 4096];
        let series = Series { dt: 1.0 / 2048.0, slip, velocity, normal, ..Series::default() };
        let mut record = Record {
            series,
            circumstance: Circumstance::default(),
            trial: Vec::new(),
            bins: (2..400).step_by(2).map(|k| (k, 1e-6)).collect(),
            measured: Vec::new(),
        };
        record.measured = Series::amplitudes(&record.series.answer(law, &record.circumstance, None));
        share_accuracy(&record.measured, &mut record.bins);
        record
    }

    /// The law that made the force leaves nothing. One with its friction larger by the accuracy of a record is one standard
    /// deviation away where the contact slides throughout; sticking (here below a quarter of the time) lessens that.
    #[test]
    fn a_record_tells_its_force_to_its_accuracy_and_no_better() {
        let law: ModifiedLaw<f64> = ModifiedLaw::dahl(4e5, 0.3);
        let record = record(&law);
        let cost = |law: &ModifiedLaw<f64>| {
            let mut left = vec![0.0; 2 * record.bins.len()];
            record.residual((law, false), &mut left);
            left.iter().map(|r| r * r).sum::<f64>()
        };
        assert!(cost(&law) < 1e-18, "{}", cost(&law));
        let found = cost(&ModifiedLaw::dahl(4e5, 0.3 * (1.0 + ACCURACY)));
        assert!((0.75..1.05).contains(&found), "{found}");
    }
}
