//! The whole inverse: runs in, contact forces out.

mod check;
mod series;
mod whole;

pub use series::Channel;
use series::{Series, Times};

use crate::analysis::{Form, RunLines, analyse};
use crate::calibration::{CalibratedStructure, Equations, calibrate, covariance};
use crate::contact::{BalanceResidual, ContactHarmonics, RunBalance, Setting};
use crate::doubt;
use crate::dynamics::{Dynamics, FixedReceptances, Load};
use crate::findings::{self, Finding};
use crate::{InverseError, Options, Rig, RunData, Slip};
use rayon::prelude::*;
use std::sync::OnceLock;
use whole::Beside;

/// Excess of the balance residual over its expectation from which a further unknown is considered.
const CONSPICUOUS: f64 = 3.0;
/// Share of that excess that may remain with the further unknown for it to be the answer.
const LEFT: f64 = 0.05;
/// Reduced chi-square of a run over its whole spectrum from which the structure is calibrated on such runs, …
const OPEN: f64 = 1.44;
/// … and the share of the excess that this may leave: what leaves more was bent to something else.
const BENT: f64 = 0.3;

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
    // What asks for no line of any run is done beside the runs.
    let (lines, (dynamics, mut findings)) = rayon::join(
        || runs.par_iter().map(|run| analyse(run, &rig.sensors, options.form)).collect::<Result<_, _>>(),
        || (Dynamics::new(rig), findings::of_channels(rig, runs)),
    );
    let lines: Vec<RunLines> = lines?;
    let declared = CalibratedStructure::declared(rig.structure.clone(), &rig.trust);
    let fixed: Vec<FixedReceptances> = lines
        .par_iter()
        .map(|run| dynamics.fixed(&rig.structure, declared.modes, (run.force.base, run.force.order())))
        .collect();
    let mut equations: Vec<Equations<'_>> =
        lines.par_iter().zip(&fixed).map(|run| Equations::new(run, wanted(rig))).collect();
    let calibrated = |from: &CalibratedStructure, equations: &[Equations<'_>]| {
        fitted((&declared, from), &dynamics, equations, options)
    };
    let mut structure = calibrated(&declared, &equations);
    if free_normal_reaction(rig, &setting(rig, &structure, &dynamics), &mut equations) {
        structure = calibrated(&structure, &equations);
    }
    if doubt::add(&setting(rig, &structure, &dynamics), &mut equations) {
        structure = calibrated(&structure, &equations);
    }
    structure.covariance = covariance_of((&declared, &structure), &dynamics, &equations, options);
    let with = |structure| Setting { splines: options.splines, ..setting(rig, structure, &dynamics) };
    let solve = |setting: &Setting<'_>| -> Vec<Solved> {
        let runs = equations.par_iter().zip(runs);
        runs.map(|(equations, run)| Solved::of(rig, setting, run, equations)).collect()
    };
    let setting = with(&structure);
    let (mut solved, told): (Vec<Solved>, _) = rayon::join(
        || solve(&setting),
        || {
            let run = &equations[loudest(&lines)?];
            findings::of_balance(&setting, &run.with_loads(run.loads.clone()))
        },
    );
    findings.extend(told.filter(|finding| !finding.follows(&findings)));
    let whole: Vec<_> =
        runs.iter().zip(&equations).filter(|(_, run)| run.lines.form == Form::Aperiodic).collect();
    let may_move = options.calibrate && structure.modes > 0 && rig.sensors.len() > wanted(rig).len();
    if may_move && is_open(&solved, &equations) {
        // What periodic runs have told of the structure is known of it.
        if let Some(calibrated) = whole::calibrated(rig, &structure, &dynamics, &whole) {
            let again = solve(&with(&calibrated));
            if is_closed_by(&solved, &again) {
                (solved, structure) = (again, calibrated);
            }
        }
    }
    drop(whole);
    drop(equations);
    let finished = lines
        .into_par_iter()
        .zip(runs)
        .zip(solved)
        .map(|((lines, run), solved)| finish(rig, run, lines, solved))
        .collect();
    Ok(Reconstruction { structure, runs: finished, findings })
}

/// A solved run.
struct Solved {
    balance: RunBalance,
    /// What is beside the lines.
    beside: Beside,
    loads: Vec<Load>,
}

impl Solved {
    fn of(rig: &Rig, setting: &Setting<'_>, run: &RunData<'_>, equations: &Equations<'_>) -> Self {
        if equations.lines.form == Form::Aperiodic {
            let (balance, loads) = whole::solve(rig, setting, run, equations);
            return Self { balance, beside: Beside::Nothing, loads };
        }
        let beside = whole::beside_lines(setting, equations);
        Self { balance: setting.balance(equations), beside, loads: equations.loads.clone() }
    }
}

/// χ² per degree of freedom of the balance of all runs.
fn reduced(solved: &[Solved]) -> f64 {
    let residual = |run: &Solved| {
        (run.balance.residual.chi_square.iter().sum(), run.balance.residual.freedom.iter().sum())
    };
    let add = |sum: (f64, usize), run: (f64, usize)| (sum.0 + run.0, sum.1 + run.1);
    let (chi, freedom) = solved.iter().map(residual).fold((0.0, 0), add);
    chi / freedom.max(1) as f64
}

/// Whether the balance of a run without a period leaves more than noise that is stated a fifth too small.
fn is_open(solved: &[Solved], equations: &[Equations<'_>]) -> bool {
    let mut whole = solved.iter().zip(equations).filter(|(_, run)| run.lines.form == Form::Aperiodic);
    whole.any(|(run, _)| run.balance.residual.reduced() > OPEN)
}

/// Whether the same runs with another structure leave little of what some leave beside the noise.
fn is_closed_by(open: &[Solved], closed: &[Solved]) -> bool {
    let [open, closed] = [open, closed].map(reduced);
    closed - 1.0 < BENT * (open - 1.0)
}

/// The periodic run with the strongest accelerations.
fn loudest(lines: &[RunLines]) -> Option<usize> {
    let level = |run: usize| lines[run].accelerations.iter().map(|a| a.rms().powi(2)).sum::<f64>();
    (0..lines.len())
        .filter(|run| lines[*run].form != Form::Aperiodic)
        .max_by(|a, b| level(*a).total_cmp(&level(*b)))
}

fn setting<'a>(rig: &Rig, structure: &'a CalibratedStructure, dynamics: &'a Dynamics) -> Setting<'a> {
    Setting {
        structure,
        dynamics,
        normal_stiffness: rig.normal_stiffness,
        splines: false,
        roots: OnceLock::new(),
    }
}

/// The contact forces that are wanted of every run.
fn wanted(rig: &Rig) -> Vec<Load> {
    [Load::Friction].into_iter().chain(rig.second_support.map(|_| Load::SecondSupport)).collect()
}

/// The structure calibrated on the periodic runs that leave degrees of freedom, beginning from one that is near.
fn fitted(
    (declared, from): (&CalibratedStructure, &CalibratedStructure),
    dynamics: &Dynamics,
    equations: &[Equations<'_>],
    options: &Options,
) -> CalibratedStructure {
    let usable = usable(dynamics, equations, options);
    if usable.is_empty() { declared.clone() } else { calibrate((declared, from), dynamics, &usable) }
}

/// Covariance of the parameters of a structure that was calibrated so.
fn covariance_of(
    (declared, structure): (&CalibratedStructure, &CalibratedStructure),
    dynamics: &Dynamics,
    equations: &[Equations<'_>],
    options: &Options,
) -> Vec<f64> {
    let usable = usable(dynamics, equations, options);
    if usable.is_empty() {
        declared.covariance.clone()
    } else {
        covariance((declared, structure), dynamics, &usable)
    }
}

/// The runs that the structure is calibrated on.
fn usable<'a, 'b>(
    dynamics: &Dynamics,
    equations: &'b [Equations<'a>],
    options: &Options,
) -> Vec<&'b Equations<'a>> {
    let tells = |run: &&Equations<'_>| {
        options.calibrate && run.lines.form != Form::Aperiodic && dynamics.sensors() > run.loads.len()
    };
    equations.iter().filter(tells).collect()
}

/// Frees the normal reaction of the runs whose balance residual asks for it; whether any does.
///
/// It asks for it when the residual is conspicuous and a force at the end takes nearly all of it away.
fn free_normal_reaction(rig: &Rig, setting: &Setting<'_>, runs: &mut [Equations<'_>]) -> bool {
    let freed = |run: &Equations<'_>| -> Option<Vec<Load>> {
        let bound = setting.residual(run).reduced();
        let more = with_normal_reaction(rig, &run.loads).filter(|_| asks(bound))?;
        answered(bound, setting.residual(&run.with_loads(more.clone())).reduced()).then_some(more)
    };
    let found: Vec<Option<Vec<Load>>> = runs
        .par_iter()
        .map(|run| if run.lines.form == Form::Aperiodic { None } else { freed(run) })
        .collect();
    for (run, loads) in runs.iter_mut().zip(&found) {
        run.loads = loads.clone().unwrap_or_else(|| run.loads.clone());
    }
    found.iter().any(Option::is_some)
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

fn finish(rig: &Rig, run: &RunData<'_>, mut lines: RunLines, solved: Solved) -> RunReconstruction {
    let Solved { balance: RunBalance { contact, residual, regularised }, beside, loads } = solved;
    let frequency_std = if lines.form == Form::Aperiodic { 0.0 } else { lines.frequency.std };
    let times = Times::new(&lines, frequency_std, &contact.friction);
    let mut series = Series::of(&contact, &times);
    if let Beside::Contact(beside) = &beside {
        let times = Times::new(&lines, 0.0, &beside.contact.friction);
        series = series.with(&Series::of(&beside.contact, &times));
    }
    // Its tables are larger than what they made.
    lines.sampler = None;
    // What is between the lines and no force makes is noise, whatever was declared.
    let noise = if let Beside::Foreign(_) = beside { &lines.residual_std } else { &lines.noise_std };
    let (acceleration_error, noise_floor) = series::errors(run, &series.acceleration_fit, noise);
    RunReconstruction {
        time: times.into_samples(),
        friction_force: series.friction,
        normal_force: series.normal.plus(run.preload),
        slip_displacement: series.slip,
        slip_velocity: series.slip_velocity,
        second_support_force: series.second_support,
        acceleration_fit: series.acceleration_fit,
        acceleration_error,
        noise_floor,
        balance: residual,
        normal_deviates: loads.contains(&Load::NormalDeviation),
        regularised_lines: regularised,
        unobservable: unobservable(rig, lines.form),
        notes: notes(&lines, &beside),
        contact: Some(contact),
        lines,
    }
}

/// What a reader must know about a run.
fn notes(lines: &RunLines, beside: &Beside) -> Vec<String> {
    let share = 100.0 * lines.aperiodic_share;
    let aperiodic = (lines.form == Form::Aperiodic).then(|| {
        format!(
            "not taken as periodic: {share:.2} % of the power lies outside all lines; balanced over the whole spectrum, drift slower than the record weighed against a random walk"
        )
    });
    let beside = match beside {
        Beside::Nothing => None,
        Beside::Contact(_) => Some(format!(
            "{share:.1e} % of the power lies between the lines and is made in the contact: balanced over the whole spectrum and added to the samples, not to the lines"
        )),
        Beside::Foreign(foreign) => Some(foreign.to_string()),
    };
    aperiodic.into_iter().chain(beside).collect()
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
