//! The whole inverse: runs in, contact forces out.

mod check;
mod series;
mod whole;

pub use series::Channel;
use series::Times;

use crate::analysis::{Form, RunLines, analyse};
use crate::calibration::{CalibratedStructure, Equations, calibrate};
use crate::contact::{BalanceResidual, ContactHarmonics, RunBalance, Setting};
use crate::doubt;
use crate::dynamics::{Dynamics, Load};
use crate::findings::{self, Finding};
use crate::{InverseError, Options, Rig, RunData, Slip};
use rayon::prelude::*;

/// Excess of the balance residual over its expectation from which a further unknown is considered.
const CONSPICUOUS: f64 = 3.0;
/// Share of that excess that may remain with the further unknown for it to be the answer.
const LEFT: f64 = 0.05;

/// All that was recovered.
#[derive(Clone, Debug)]
pub struct Reconstruction {
    /// The calibrated structure.
    pub structure: CalibratedStructure,
    /// The runs, in the order given.
    pub runs: Vec<RunReconstruction>,
    /// What is wrong with the channels.
    pub findings: Vec<Finding>,
}

/// What was recovered of one run. Time series have one value a sample.
#[derive(Clone, Debug)]
pub struct RunReconstruction {
    /// What was measured, as lines.
    pub lines: RunLines,
    /// What was recovered, as lines; `None` for an aperiodic run.
    pub contact: Option<ContactHarmonics>,
    /// Time of each sample (s).
    pub time: Vec<f64>,
    /// Friction force, its mean left out (N).
    pub friction_force: Channel,
    /// Normal force, with the declared preload (N).
    pub normal_force: Channel,
    /// Slip, its mean left out (m).
    pub slip_displacement: Channel,
    /// Slip velocity (m/s).
    pub slip_velocity: Channel,
    /// Force of the second support on the beam, its mean left out (N).
    pub second_support_force: Option<Channel>,
    /// Accelerations that the structure makes of all forces (m/s²).
    pub acceleration_fit: Vec<Channel>,
    /// Relative root mean square of measured less fitted acceleration over all sensors.
    pub acceleration_error: f64,
    /// The same of a perfect fit.
    pub noise_floor: f64,
    /// What no contact force can explain.
    pub balance: BalanceResidual,
    /// Whether the normal reaction was an unknown of its own.
    pub normal_deviates: bool,
    /// Lines on which the prior outweighs the data.
    pub regularised_lines: Vec<usize>,
    /// What accelerations cannot show.
    pub unobservable: Vec<&'static str>,
    /// What a reader must know about this run.
    pub notes: Vec<String>,
}

/// Reconstructs the contact of all runs.
///
/// # Errors
/// [`InverseError`] when the rig or a run cannot be used; a run that is not periodic is no error.
pub fn reconstruct(
    rig: &Rig,
    runs: &[RunData<'_>],
    options: &Options,
) -> Result<Reconstruction, InverseError> {
    check::rig(rig)?;
    check::runs(rig, runs)?;
    let lines: Vec<RunLines> =
        runs.par_iter().map(|run| analyse(run, &rig.sensors, options.form)).collect::<Result<_, _>>()?;
    let dynamics = Dynamics::new(rig);
    let declared = CalibratedStructure::declared(rig.structure.clone(), &rig.trust);
    let mut wanted = vec![Load::Friction];
    wanted.extend(rig.second_support.map(|_| Load::SecondSupport));
    let mut loads = vec![wanted; runs.len()];
    let calibrated = |equations: &[Equations<'_>]| fitted(&declared, &dynamics, equations, options);
    let mut structure = calibrated(&equations(&lines, &loads));
    if free_normal_reaction(rig, &setting(rig, &structure, &dynamics), &lines, &mut loads) {
        structure = calibrated(&equations(&lines, &loads));
    }
    let mut equations = equations(&lines, &loads);
    if doubt::add(&setting(rig, &structure, &dynamics), &mut equations) {
        structure = calibrated(&equations);
    }
    let setting = Setting { splines: options.splines, ..setting(rig, &structure, &dynamics) };
    let mut findings = findings::of_channels(rig, runs);
    let told = loudest(&lines)
        .and_then(|run| findings::of_balance(&setting, &Equations::new(&lines[run], loads[run].clone())));
    findings.extend(told.filter(|finding| !finding.follows(&findings)));
    let solved: Vec<(RunBalance, Vec<Load>)> = equations
        .par_iter()
        .zip(runs)
        .map(|(equations, run)| match equations.lines.form {
            Form::Aperiodic => whole::solve(rig, &setting, run, equations),
            _ => (setting.balance(equations), equations.loads.clone()),
        })
        .collect();
    drop(equations);
    let finished = lines
        .into_par_iter()
        .zip(runs)
        .zip(solved)
        .map(|((lines, run), (balance, loads))| {
            finish(rig, run, (lines, balance), loads.contains(&Load::NormalDeviation))
        })
        .collect();
    Ok(Reconstruction { structure, runs: finished, findings })
}

/// The periodic run with the strongest accelerations.
fn loudest(lines: &[RunLines]) -> Option<usize> {
    let level = |run: usize| lines[run].accelerations.iter().map(|a| a.rms().powi(2)).sum::<f64>();
    (0..lines.len())
        .filter(|run| lines[*run].form != Form::Aperiodic)
        .max_by(|a, b| level(*a).total_cmp(&level(*b)))
}

fn setting<'a>(rig: &Rig, structure: &'a CalibratedStructure, dynamics: &'a Dynamics) -> Setting<'a> {
    Setting { structure, dynamics, normal_stiffness: rig.normal_stiffness, splines: false }
}

/// Equations of all runs.
fn equations<'a>(lines: &'a [RunLines], loads: &[Vec<Load>]) -> Vec<Equations<'a>> {
    lines.iter().zip(loads).map(|(lines, loads)| Equations::new(lines, loads.clone())).collect()
}

/// The structure calibrated on the periodic runs that leave degrees of freedom.
fn fitted(
    declared: &CalibratedStructure,
    dynamics: &Dynamics,
    equations: &[Equations<'_>],
    options: &Options,
) -> CalibratedStructure {
    let usable: Vec<&Equations<'_>> = equations
        .iter()
        .filter(|run| run.lines.form != Form::Aperiodic && dynamics.sensors() > run.loads.len())
        .collect();
    if options.calibrate && !usable.is_empty() {
        calibrate(declared, dynamics, &usable)
    } else {
        declared.clone()
    }
}

/// Frees the normal reaction of the runs whose balance residual asks for it; whether any does.
///
/// It asks for it when the residual is conspicuous and a force at the end takes nearly all of it away.
fn free_normal_reaction(
    rig: &Rig,
    setting: &Setting<'_>,
    lines: &[RunLines],
    loads: &mut [Vec<Load>],
) -> bool {
    let mut any = false;
    for (lines, loads) in lines.iter().zip(loads).filter(|(lines, _)| lines.form != Form::Aperiodic) {
        let residual = |loads: &[Load]| setting.residual(&Equations::new(lines, loads.to_vec())).reduced();
        if !asks(residual(loads)) {
            continue;
        }
        let Some(more) = with_normal_reaction(rig, loads) else { continue };
        if answered(residual(loads), residual(&more)) {
            *loads = more;
            any = true;
        }
    }
    any
}

/// Whether a reduced chi-square is conspicuous.
fn asks(reduced: f64) -> bool {
    reduced - 1.0 >= CONSPICUOUS
}

/// Whether the normal reaction takes nearly all of the excess of a reduced chi-square away.
fn answered(bound: f64, free: f64) -> bool {
    free - 1.0 < LEFT * (bound - 1.0)
}

/// The loads with the deviation of the normal reaction, where the rig has one and enough sensors tell it.
fn with_normal_reaction(rig: &Rig, loads: &[Load]) -> Option<Vec<Load>> {
    let possible = rig.slip != Slip::Transverse
        && rig.normal_stiffness > 0.0
        && rig.sensors.len() >= loads.len() + 2
        && !loads.contains(&Load::NormalDeviation);
    possible.then(|| loads.iter().copied().chain([Load::NormalDeviation]).collect())
}

fn finish(
    rig: &Rig,
    run: &RunData<'_>,
    (lines, balance): (RunLines, RunBalance),
    deviates: bool,
) -> RunReconstruction {
    let RunBalance { contact, residual, regularised } = balance;
    let frequency_std = if lines.form == Form::Aperiodic { 0.0 } else { lines.frequency.std };
    let times = Times { rate: lines.sampling_rate, samples: lines.samples, frequency_std };
    let series = |harmonics, shared: &[_]| Channel::from_harmonics(harmonics, shared, &times);
    let acceleration_fit: Vec<Channel> = contact.acceleration_fit.iter().map(|a| series(a, &[])).collect();
    let (acceleration_error, noise_floor) = series::errors(run, &acceleration_fit, &lines.noise_std);
    let mut notes = Vec::new();
    if lines.form == Form::Aperiodic {
        notes.push(format!(
            "not taken as periodic: {:.2} % of the power lies outside all lines; balanced over the whole spectrum, drift slower than the record left out",
            100.0 * lines.aperiodic_share
        ));
    }
    RunReconstruction {
        time: (0..lines.samples).map(|j| j as f64 / lines.sampling_rate).collect(),
        friction_force: series(&contact.friction, &contact.shared.friction),
        normal_force: series(&contact.normal, &contact.shared.normal).plus(run.preload),
        slip_displacement: series(&contact.slip, &contact.shared.slip),
        slip_velocity: series(&contact.slip_velocity, &contact.shared.slip_velocity(contact.slip.base)),
        second_support_force: contact
            .second_support
            .as_ref()
            .map(|second| series(second, &contact.shared.second_support)),
        acceleration_fit,
        acceleration_error,
        noise_floor,
        balance: residual,
        normal_deviates: deviates,
        regularised_lines: regularised,
        unobservable: unobservable(rig, lines.form),
        notes,
        contact: Some(contact),
        lines,
    }
}

fn unobservable(rig: &Rig, form: Form) -> Vec<&'static str> {
    let mut names = vec!["mean of friction_force", "mean of slip_displacement", "preload"];
    if form == Form::Aperiodic {
        names.push("drift slower than the record");
    }
    if rig.second_support.is_some() {
        names.push("mean of second_support_force");
    }
    names
}
