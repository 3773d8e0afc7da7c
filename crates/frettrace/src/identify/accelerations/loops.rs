//! Motion and force of the contact, recovered from the accelerations without a law, with draws of their errors.

use super::aperiodic;
use frettrace_explain::{Case, ExplainError, RunRecord, Study};
use frettrace_forward::accelerations::{AccelerationError, Balance, Quantity, Setting};
use frettrace_fourier::Grid;
use frettrace_identify::contact::{Closure, ContactFit, ContactHistory, ContactModel, Extras, NoiseDraw};
use num_complex::Complex64;
use rand::SeedableRng;
use rand_distr::{Distribution, StandardNormal};

/// Draws of noise and structure: enough for a standard deviation to a quarter.
const DRAWS: usize = 8;
/// Seed of the draws.
const SEED: u64 = 1;
/// Highest line (of the excitation) of a recovered period.
const LINES: usize = 60;
/// Periodic runs from which a fit can start.
const LEAST_PERIODIC: usize = 3;
/// Share of the peak force that a cut series of lines misses at best.
const CUT: f64 = 5e-3;

/// The recovered periods of some runs.
pub(super) struct Loops {
    runs: Vec<RunLoop>,
    /// One history a run, without the forces that the noise hides.
    pub(super) histories: Vec<ContactHistory>,
    /// Runs that are not periodic, where there are too few others.
    pub(super) open: Vec<ContactHistory>,
}

/// One recovered period as lines.
struct RunLoop {
    label: String,
    omega: f64,
    preload: f64,
    order: usize,
    grid: Grid,
    /// Contact force where it is known, else nothing.
    force: Vec<Complex64>,
    known: Vec<bool>,
    deviation: Vec<f64>,
    /// Slip without any contact force, and slip lost per unit force.
    free: Vec<Complex64>,
    gain: Vec<Complex64>,
    /// Change of the normal force.
    normal: Vec<Complex64>,
}

impl Loops {
    /// Recovers the training runs of a study at a setting.
    ///
    /// # Errors
    /// [`ExplainError`] where the structure cannot be built.
    pub(super) fn new(case: &Case, study: &Study<'_>, setting: &Setting) -> Result<Self, ExplainError> {
        let selected = &study.training;
        let found = study.model.balance(setting, selected)?;
        let mut runs = Vec::with_capacity(selected.len());
        for (run, balance) in selected.iter().zip(&found) {
            runs.push(RunLoop::new(case, (*run, &case.records[*run]), balance)?);
        }
        let mut generator = rand_pcg::Pcg64::seed_from_u64(SEED);
        let mut normal = || -> f64 { StandardNormal.sample(&mut generator) };
        let mut histories: Vec<ContactHistory> = runs.iter().map(|run| run.history(&run.force)).collect();
        for _ in 0..DRAWS {
            let moved = study.model.balance(&drawn(case, setting, &mut normal), selected)?;
            for (place, run) in runs.iter().enumerate() {
                let draw = run.draw((&found[place], &moved[place]), &mut normal);
                histories[place].draws.push(draw);
            }
        }
        // They are long and no period shortens the march along them: the fit starts without them where it can.
        let open = if runs.len() < LEAST_PERIODIC { aperiodic::histories(case) } else { Vec::new() };
        Ok(Self { runs, histories, open })
    }

    /// The histories with the lines that the noise hides filled by what a law fitted to the others answers.
    pub(super) fn filled(&self, fit: &ContactFit) -> Vec<ContactHistory> {
        let values = fit.law_values();
        let fill = |run: &RunLoop, history: &ContactHistory| {
            let model = ContactModel::new(fit.family, vec![history], &values, Extras::default());
            let miss = model.force_residual(0, &values);
            let answer: Vec<f64> = miss.iter().zip(&history.force).map(|(r, f)| r + f).collect();
            let mut lines = vec![Complex64::ZERO; run.order + 1];
            run.grid.project(&answer, &mut lines, &mut run.grid.scratch());
            for (h, line) in lines.iter_mut().enumerate() {
                if h == 0 || run.known[h] {
                    *line = run.force[h];
                }
            }
            ContactHistory { draws: history.draws.clone(), ..run.history(&lines) }
        };
        self.runs.iter().zip(&self.histories).map(|(run, history)| fill(run, history)).collect()
    }
}

/// A structure as it may be: every measured mode moved by a draw of its standard deviation.
fn drawn(case: &Case, setting: &Setting, normal: &mut impl FnMut() -> f64) -> Setting {
    let mut moved = setting.clone();
    for unknown in case.unknowns() {
        let structural = matches!(unknown.quantity, Quantity::ModeFrequency(_) | Quantity::ModeDamping(_));
        if let (true, Some(prior)) = (structural, unknown.parameter.prior) {
            let low = unknown.parameter.bounds.0;
            moved.set(unknown.quantity, (prior.mean + prior.std * normal()).max(low));
        }
    }
    moved
}

impl RunLoop {
    fn new(
        case: &Case,
        (index, record): (usize, &RunRecord),
        balance: &Balance,
    ) -> Result<Self, AccelerationError> {
        let lines = &record.lines;
        let order = lines.order().min(LINES * record.subharmonic);
        let grid = Grid::new(order, (4 * order).next_power_of_two().max(128))?;
        let known: Vec<bool> = (0..=order)
            .map(|h| h > 0 && balance.force[h].norm() > 3.0 * balance.force_deviation[h])
            .collect();
        let stiffness = case.rig.boundary.support_stiffness;
        let turns = case.rig.lever.is_some();
        let driven = |h: usize| lines.force[h] != Complex64::ZERO;
        let of = |value: &dyn Fn(usize) -> Complex64| -> Vec<Complex64> {
            (0..=order).map(|h| if h == 0 { Complex64::ZERO } else { value(h) }).collect()
        };
        Ok(Self {
            label: format!("run {}", index + 1),
            omega: lines.omega,
            preload: lines.preload,
            order,
            force: of(&|h| if known[h] { balance.force[h] } else { Complex64::ZERO }),
            deviation: balance.force_deviation[..=order].to_vec(),
            free: of(&|h| balance.slip[h] + balance.slip_gain[h] * balance.force[h]),
            gain: of(&|h| balance.slip_gain[h]),
            // What the noise of a hidden force moves the end by is no motion of it.
            normal: of(&|h| {
                if turns && (known[h] || driven(h)) { -balance.end[h] * stiffness } else { Complex64::ZERO }
            }),
            grid,
            known,
        })
    }

    fn sampled(&self, lines: &[Complex64]) -> Vec<f64> {
        let mut out = vec![0.0; self.grid.samples()];
        self.grid.evaluate(lines, &mut out, &mut self.grid.scratch());
        out
    }

    fn rates(&self, lines: &[Complex64]) -> Vec<Complex64> {
        lines.iter().enumerate().map(|(h, x)| x * Complex64::new(0.0, h as f64 * self.omega)).collect()
    }

    /// The period under given lines of the contact force.
    fn history(&self, force: &[Complex64]) -> ContactHistory {
        let slip: Vec<Complex64> =
            self.free.iter().zip(&self.gain).zip(force).map(|((u, g), f)| u - g * f).collect();
        let forces = self.sampled(force);
        let peak = forces.iter().fold(0.0_f64, |m, f| f.abs().max(m));
        let heard = self.deviation.iter().zip(&self.known).filter(|(_, known)| **known);
        let variance: f64 = heard.map(|(std, _)| std * std).sum();
        let period = std::f64::consts::TAU / self.omega;
        let samples = self.grid.samples();
        ContactHistory {
            label: self.label.clone(),
            time: (0..samples).map(|k| period * k as f64 / samples as f64).collect(),
            slip: self.sampled(&slip),
            velocity: self.sampled(&self.rates(&slip)),
            acceleration: None,
            normal: self.sampled(&self.normal).iter().map(|change| self.preload + change).collect(),
            closure: Closure::Periodic { period },
            mean_is_seen: false,
            force_std: variance.sqrt().max(CUT * peak).max(1e-12),
            force: forces,
            draws: Vec::new(),
            first: 0,
        }
    }

    /// What noise and a structure moved by its uncertainty make of force and slip, on the known lines.
    fn draw(&self, (found, moved): (&Balance, &Balance), normal: &mut impl FnMut() -> f64) -> NoiseDraw {
        let mut force = vec![Complex64::ZERO; self.order + 1];
        let mut slip = force.clone();
        for h in (1..=self.order).filter(|h| self.known[*h]) {
            let noise = Complex64::new(normal(), normal()) * self.deviation[h];
            force[h] = moved.force[h] - found.force[h] + noise;
            slip[h] = moved.slip[h] - found.slip[h] - self.gain[h] * noise;
        }
        let forces = self.sampled(&self.force);
        let cut = CUT * forces.iter().fold(0.0_f64, |m, f| f.abs().max(m));
        NoiseDraw {
            slip: self.sampled(&slip),
            velocity: self.sampled(&self.rates(&slip)),
            force: self.sampled(&force).iter().map(|f| f + cut * normal()).collect(),
        }
    }
}
