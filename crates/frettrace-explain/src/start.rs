//! Where the fit starts: motion and force of the contact without a law, and the declared law on them.

use crate::Case;
use crate::case::Scales;
use crate::split::by_level;
use frettrace_forward::accelerations::{AccelerationError, AccelerationModel, Balance, Setting};
use frettrace_fourier::{Grid, GridError};
use frettrace_friction::effects::{Hook, ModifiedLaw};
use frettrace_identify::contact::{Closure, ContactHistory, ContactModel, Extras, Family, Guess};
use frettrace_identify::{FitSettings, fit};
use num_complex::Complex64;

/// Samples of a recovered period.
const SAMPLES: usize = 256;
/// Highest line of a recovered history: above it the forces of one period are noise in practice.
const LINES: usize = 60;

/// Recovered histories of the selected runs.
pub fn histories(
    case: &Case,
    model: &AccelerationModel,
    setting: &Setting,
    selected: &[usize],
) -> Result<Vec<ContactHistory>, AccelerationError> {
    let balances = model.balance(setting, selected)?;
    selected.iter().zip(&balances).map(|(&run, balance)| Ok(history(case, run, balance)?)).collect()
}

/// One recovered period.
fn history(case: &Case, run: usize, balance: &Balance) -> Result<ContactHistory, GridError> {
    let lines = &case.records[run].lines;
    let order = lines.order().min(LINES * case.records[run].subharmonic);
    let samples = (4 * order).next_power_of_two().max(SAMPLES);
    let grid = Grid::new(order, samples)?;
    let mut scratch = grid.scratch();
    let known = |h: usize| balance.force[h].norm() > 3.0 * balance.force_deviation[h];
    let mut sampled = |of: &dyn Fn(usize) -> Complex64| {
        let lines: Vec<Complex64> =
            (0..=order).map(|h| if h == 0 { Complex64::ZERO } else { of(h) }).collect();
        let mut out = vec![0.0; samples];
        grid.evaluate(&lines, &mut out, &mut scratch);
        out
    };
    let force = sampled(&|h| if known(h) { balance.force[h] } else { Complex64::ZERO });
    let slip = sampled(&|h| balance.slip[h]);
    let velocity = sampled(&|h| balance.slip[h] * Complex64::new(0.0, h as f64 * lines.omega));
    let stiffness = case.rig.boundary.support_stiffness;
    let normal = if case.rig.lever.is_some() {
        let end = sampled(&|h| balance.end[h]);
        end.iter().map(|w| lines.preload - stiffness * w).collect()
    } else {
        vec![lines.preload; samples]
    };
    let period = std::f64::consts::TAU / lines.omega;
    let variance: f64 = (1..=order).filter(|h| known(*h)).map(|h| balance.force_deviation[h].powi(2)).sum();
    Ok(ContactHistory {
        label: format!("run {}", run + 1),
        time: (0..samples).map(|k| period * k as f64 / samples as f64).collect(),
        slip,
        velocity,
        acceleration: None,
        normal,
        closure: Closure::Periodic { period },
        mean_is_seen: false,
        // Every level counts by its own size, not by its noise: the start must be fair to all.
        force_std: variance.sqrt().max(0.02 * peak(&force)).max(1e-12),
        force,
        draws: Vec::new(),
        first: 0,
    })
}

/// The declared law fitted to the recovered histories.
pub(crate) fn law(family: Family, histories: &[ContactHistory]) -> ModifiedLaw<f64> {
    let all: Vec<&ContactHistory> = histories.iter().collect();
    let guess = Guess::of(&all);
    let mut law = if family == Family::Dahl {
        ModifiedLaw::dahl(guess.sigma0, guess.mu)
    } else {
        let values = guess.parameters(family);
        let model = ContactModel::new(family, all, &values, Extras::default());
        let settings = FitSettings { max_iterations: 40, relative_tolerance: 1e-3, ..FitSettings::default() };
        family.law(&fit(&model, &values, &settings).map_or(values, |found| found.values))
    };
    if family.is_static() {
        let level = level(histories);
        let total =
            law.get(Hook::MuKinetic).unwrap_or_default() + law.get(Hook::StribeckRise).unwrap_or_default();
        // Runs that stick have no slip but noise, and a fit to that may have any friction coefficient.
        if !(0.5 * level..=1.5 * level).contains(&total) {
            law.set(Hook::MuKinetic, level);
        }
        // A stiffness is needed only where the law is marched along a recovered slip, which has noise where it sticks: a
        // fiftieth of the smallest slip of the runs that slide.
        let slides = |h: &&ContactHistory| peak(&h.force) > 0.8 * level * h.mean_normal();
        let reach =
            histories.iter().filter(slides).map(ContactHistory::amplitude).fold(f64::INFINITY, f64::min);
        let widest = histories.iter().map(ContactHistory::amplitude).fold(0.0, f64::max);
        let reach = if reach.is_finite() { reach.max(0.02 * widest) } else { widest };
        law.set(Hook::Sigma0, 50.0 * level / reach.max(1e-12));
    }
    // Starts in the open interior of what the fit admits.
    for (hook, least) in [(Hook::StribeckRise, 1e-3 * guess.mu), (Hook::StribeckVelocity, 1e-3 * guess.speed)]
    {
        if let Some(value) = law.get(hook) {
            law.set(hook, value.max(least));
        }
    }
    law
}

/// Sizes of the motion.
pub(crate) fn scales(case: &Case, histories: &[ContactHistory]) -> Scales {
    let largest = |of: &dyn Fn(&ContactHistory) -> f64| histories.iter().map(of).fold(0.0, f64::max);
    let first = case.records.first();
    let period = first.map_or(1.0, |r| std::f64::consts::TAU / r.lines.omega / r.subharmonic as f64);
    Scales {
        slip: largest(&ContactHistory::amplitude).max(1e-12),
        velocity: largest(&ContactHistory::top_speed).max(1e-12),
        period,
        preload: mean_preload(case),
        length: case.rig.beam.length,
        mass: case.rig.beam.mass_per_length * case.rig.beam.length,
        subharmonic: case.records.iter().filter(|r| r.periodic).map(|r| r.subharmonic).max().unwrap_or(1),
    }
}

/// Place of every run, at its beginning and its end, between the middles of the first and the last in the work that friction had done,
/// from the recovered forces; that of the number of the run where friction does none. What was done before a run is the rig's history, an
/// input as the excitation is; what a run that is held out does itself is told by those next to it in level.
pub(crate) fn worked(
    case: &Case,
    model: &AccelerationModel,
    setting: &Setting,
    held_out: &[usize],
) -> Result<Vec<[f64; 2]>, AccelerationError> {
    let all: Vec<usize> = (0..case.records.len()).collect();
    let balances = model.balance(setting, &all)?;
    let power = |k: usize| {
        let record = &case.records[k];
        match (&record.series, record.periodic) {
            (_, true) => Some(dissipated(&balances[k], record.lines.omega)),
            (Some(series), false) => Some(series.dissipated()),
            (None, false) => None,
        }
    };
    let known: Vec<Option<f64>> = all.iter().map(|&k| power(k)).collect();
    let ranked = by_level(case, &all);
    let work = told_by_next(&ranked, &known);
    let seen: Vec<Option<f64>> = all.iter().map(|k| known[*k].filter(|_| !held_out.contains(k))).collect();
    let own = told_by_next(&ranked, &seen);
    let duration = |k: usize| case.records[k].samples as f64 / case.records[k].sampling_rate;
    let mut done = 0.0;
    let ends: Vec<[f64; 2]> = all
        .iter()
        .map(|&k| {
            let before = done;
            done += work[k].max(0.0) * duration(k);
            [before, before + own[k].max(0.0) * duration(k)]
        })
        .collect();
    let middle = |run: Option<&[f64; 2]>| run.map_or(0.0, |[before, after]| 0.5 * (before + after));
    let [first, last] = [middle(ends.first()), middle(ends.last())];
    let place = |k: usize| match last - first {
        whole if whole > 0.0 && whole.is_finite() => ends[k].map(|end| (end - first) / whole),
        _ => [case.records[k].lines.progress; 2],
    };
    Ok(all.iter().map(|&k| place(k)).collect())
}

/// Power (W) that the contact takes, `½ Σ Re(F_h v_h*)`.
fn dissipated(balance: &Balance, omega: f64) -> f64 {
    let lines = balance.force.iter().zip(&balance.slip).enumerate();
    lines
        .map(|(h, (force, slip))| 0.5 * (force * (slip * Complex64::new(0.0, h as f64 * omega)).conj()).re)
        .sum()
}

/// Values of all runs, ranked by level; one that is not known lies between those next to it on a logarithmic scale.
fn told_by_next(ranked: &[usize], known: &[Option<f64>]) -> Vec<f64> {
    let mut all = vec![0.0; known.len()];
    for (place, &run) in ranked.iter().enumerate() {
        let below = ranked[..place].iter().rev().find_map(|&k| known[k]);
        let above = ranked[place..].iter().find_map(|&k| known[k]);
        all[run] = match (known[run], below, above) {
            (Some(own), ..) => own,
            (None, Some(below), Some(above)) => (below.max(0.0) * above.max(0.0)).sqrt(),
            (None, below, above) => below.or(above).unwrap_or_default(),
        };
    }
    all
}

/// Level of `|F|/N` where the widest loop slides: the mean over the samples of at least half its top speed.
fn level(histories: &[ContactHistory]) -> f64 {
    let Some(widest) = histories.iter().max_by(|a, b| a.amplitude().total_cmp(&b.amplitude())) else {
        return 1.0;
    };
    let fast = 0.5 * widest.top_speed();
    let least = 0.1 * widest.mean_normal();
    let (mut sum, mut count) = (0.0, 0.0);
    for ((force, v), normal) in widest.force.iter().zip(&widest.velocity).zip(&widest.normal) {
        if v.abs() >= fast && *normal > least {
            sum += force.abs() / normal;
            count += 1.0;
        }
    }
    (sum / f64::max(count, 1.0)).max(1e-6)
}

fn mean_preload(case: &Case) -> f64 {
    let sum: f64 = case.records.iter().map(|r| r.lines.preload).sum();
    if case.records.is_empty() { 1.0 } else { sum / case.records.len() as f64 }
}

fn peak(values: &[f64]) -> f64 {
    values.iter().fold(0.0, |m, v| v.abs().max(m))
}
