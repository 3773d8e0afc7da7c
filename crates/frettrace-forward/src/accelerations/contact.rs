//! The friction contact over one period: force on the phase grid, and its linearisation through the hysteresis.

use frettrace_friction::effects::{Circumstance, Hook, ModifiedLaw, ModifiedState};
use frettrace_friction::{Gradient, Step};

/// Motion of the contact on the phase grid, one value a sample.
#[derive(Clone, Debug, Default)]
pub(super) struct Motion {
    pub slip: Vec<f64>,
    pub velocity: Vec<f64>,
    pub normal: Vec<f64>,
    /// Force that a rigid contact takes as long as it holds; empty where the contact yields.
    pub trial: Vec<f64>,
}

/// The law in the circumstances of a run.
#[derive(Clone, Copy, Debug)]
pub(super) struct Contact<'a> {
    pub law: &'a ModifiedLaw<f64>,
    /// Duration between two samples of the grid (s).
    pub dt: f64,
    pub preload: f64,
    pub progress: f64,
    /// Order of the line with which the preload is modulated.
    pub modulation: usize,
}

/// States that a law may use, and the motion of a step, as directions of differentiation.
pub(super) const STATES: usize = 4;
pub(super) const MOTIONS: usize = 7;
/// Law parameters differentiated at once.
pub(super) const PARAMETERS: usize = 14;
const WIDTH: usize = STATES + MOTIONS + PARAMETERS;
type Dual = Gradient<WIDTH>;

/// Derivatives of one step: of new states and force by old states, motion `(u₀, u₁, v₀, v₁, N₀, N₁)`, held force and parameters.
#[derive(Clone, Copy, Debug)]
pub(super) struct Local {
    pub state: [[f64; WIDTH]; STATES],
    pub force: [f64; WIDTH],
}

impl Local {
    pub const MOTION: usize = STATES;
    pub const TRIAL: usize = STATES + 6;
    pub const PARAMETER: usize = STATES + MOTIONS;
}

fn seed(value: f64, direction: usize) -> Dual {
    Dual::variable(value, direction)
}

impl Contact<'_> {
    fn circumstance(&self, from: usize, samples: usize) -> Circumstance {
        let phase = |k: usize| {
            let (sine, cosine) =
                (std::f64::consts::TAU * (self.modulation * k % samples) as f64 / samples as f64).sin_cos();
            [cosine, sine]
        };
        let modulated = self.law.get(Hook::ModulationCosine).is_some();
        Circumstance {
            preload: self.preload,
            progress: self.progress,
            phase: if modulated { [phase(from), phase(from + 1)] } else { [[1.0, 0.0]; 2] },
        }
    }

    fn step(&self, motion: &Motion, k: usize) -> Step<f64> {
        let next = (k + 1) % motion.slip.len();
        Step {
            slip: [motion.slip[k], motion.slip[next]],
            velocity: [motion.velocity[k], motion.velocity[next]],
            normal: [motion.normal[k], motion.normal[next]],
            dt: self.dt,
        }
    }

    /// The state with which the period starts: from rest along the virgin curve, then periods until it closes.
    pub fn start(&self, motion: &Motion, force: &mut [f64]) -> ModifiedState<f64> {
        let samples = motion.slip.len();
        let virgin = Step {
            slip: [0.0, motion.slip[0]],
            velocity: [motion.velocity[0]; 2],
            normal: [motion.normal[0]; 2],
            dt: self.dt,
        };
        let circumstance = self.circumstance(samples - 1, samples);
        let advance = |state, step: &Step<f64>, k: usize| match motion.trial.get((k + 1) % samples) {
            Some(&trial) => self.law.advance_rigid(state, step, (trial, &self.circumstance(k, samples))),
            None => self.law.advance(state, step, &self.circumstance(k, samples)),
        };
        let mut state = self.law.rest_at(0.0);
        if motion.trial.is_empty() {
            (state, _) = self.law.advance(state, &virgin, &circumstance);
        }
        let mut before: Option<[f64; STATES]> = None;
        for _ in 0..12 {
            let old = state.0;
            for k in 0..samples {
                let (next, f) = advance(state, &self.step(motion, k), k);
                state = next;
                force[(k + 1) % samples] = f;
            }
            let change: [f64; STATES] = std::array::from_fn(|i| state.0[i] - old[i]);
            if change.iter().zip(&state.0).all(|(c, s)| c.abs() <= 1e-9 * (1e-12 + s.abs())) {
                break;
            }
            // Slow memory closes geometrically: Aitken's extrapolation.
            if let Some(last) = before {
                for i in 0..STATES {
                    let ratio = change[i] / last[i];
                    if ratio.is_finite() && ratio.abs() < 0.999 {
                        state.0[i] += change[i] * ratio / (1.0 - ratio);
                    }
                }
                before = None;
            } else {
                before = Some(change);
            }
        }
        state
    }

    /// Local derivatives of every step of the settled period.
    pub fn locals(
        &self,
        motion: &Motion,
        start: ModifiedState<f64>,
        hooks: &[Hook],
        locals: &mut Vec<Local>,
    ) {
        let samples = motion.slip.len();
        let position = |hook: Hook| hooks.iter().position(|h| *h == hook);
        let law = self.law.lift(|hook, value| match position(hook) {
            Some(p) if p < PARAMETERS => seed(value, Local::PARAMETER + p),
            _ => Dual::constant(value),
        });
        locals.clear();
        let mut values = start.0;
        for k in 0..samples {
            let state = ModifiedState(std::array::from_fn(|i| seed(values[i], i)));
            let plain = self.step(motion, k);
            let pair = |at: usize, of: [f64; 2]| [seed(of[0], at), seed(of[1], at + 1)];
            let step = Step {
                slip: pair(Local::MOTION, plain.slip),
                velocity: pair(Local::MOTION + 2, plain.velocity),
                normal: pair(Local::MOTION + 4, plain.normal),
                dt: self.dt,
            };
            let circumstance = self.circumstance(k, samples);
            let (next, force) = match motion.trial.get((k + 1) % samples) {
                Some(&trial) => law.advance_rigid(state, &step, (seed(trial, Local::TRIAL), &circumstance)),
                None => law.advance(state, &step, &circumstance),
            };
            values = next.0.map(|s| s.re);
            locals.push(Local { state: std::array::from_fn(|i| next.0[i].slopes), force: force.slopes });
        }
    }
}
