//! The friction contact over one period: force on the phase grid, and its linearisation through the hysteresis.

use frettrace_friction::effects::{Hook, ModifiedLaw, ModifiedState, Periodic, STATES};
use frettrace_friction::{Gradient, Step};

/// Motion of the contact on the phase grid, one value a sample.
#[derive(Clone, Debug, Default)]
pub(super) struct Motion {
    pub slip: Vec<f64>,
    pub velocity: Vec<f64>,
    pub normal: Vec<f64>,
    /// Force that a rigid contact takes as long as it holds; empty where the contact yields.
    pub trial: Vec<f64>,
    /// Slip (m) that a contact with a deflection of its own gains in the period beside that ([`ModifiedLaw::drift`]).
    pub drift: f64,
}

/// The law in the circumstances of a run.
#[derive(Clone, Copy, Debug)]
pub(super) struct Contact<'a> {
    pub law: &'a ModifiedLaw<f64>,
    /// Duration between two samples of the grid (s).
    pub dt: f64,
    pub preload: f64,
    pub progress: f64,
    pub worked: [f64; 2],
    /// Order of the line with which the preload is modulated.
    pub modulation: usize,
    /// Phase of that line at the first sample (rad).
    pub modulation_phase: f64,
    /// Deflection with which the period begins, where the contact has not settled.
    pub deflection: Option<f64>,
}

/// The motion of a step as directions of differentiation, after the states.
pub(super) const MOTIONS: usize = 7;
/// Law parameters differentiated at once.
pub(super) const PARAMETERS: usize = 14;
const WIDTH: usize = STATES + MOTIONS + PARAMETERS;
/// Directions where no parameter is asked for.
const BARE: usize = STATES + MOTIONS;

/// Derivatives of one step: of new states and force by old states, motion `(u₀, u₁, v₀, v₁, N₀, N₁)`, held force and parameters.
#[derive(Clone, Copy, Debug)]
pub(super) struct Local {
    pub state: [[f64; WIDTH]; STATES],
    pub force: [f64; WIDTH],
}

/// Derivatives of the states with which the settled period starts, where these are still what the contact came to from rest: one that
/// forgets nothing keeps them. By the motion at the first sample, and by the parameters, as in [`Local`]; 0 elsewhere.
pub(super) type Begun = [[f64; WIDTH]; STATES];

impl Local {
    pub const MOTION: usize = STATES;
    pub const TRIAL: usize = STATES + 6;
    pub const PARAMETER: usize = STATES + MOTIONS;
}

/// Slopes, the last of them zero where they were not asked for.
fn widened<const W: usize>(slopes: [f64; W]) -> [f64; WIDTH] {
    let mut wide = [0.0; WIDTH];
    wide[..W].copy_from_slice(&slopes);
    wide
}

impl Contact<'_> {
    /// The motion with what the law needs to know beside it.
    fn along<'a>(&self, motion: &'a Motion) -> Periodic<'a> {
        Periodic {
            slip: &motion.slip,
            velocity: &motion.velocity,
            normal: &motion.normal,
            trial: &motion.trial,
            dt: self.dt,
            preload: self.preload,
            progress: self.progress,
            worked: self.worked,
            modulation: self.modulation,
            modulation_phase: self.modulation_phase,
            deflection: self.deflection,
            drift: motion.drift,
        }
    }

    /// The slip that a contact with a deflection of its own gains in a period; 0 where it has none.
    pub fn drift(&self, motion: &Motion) -> f64 {
        self.law.drift(&self.along(motion))
    }

    /// The force over the settled period, and the state with which that starts.
    pub fn start(&self, motion: &Motion, force: &mut [f64]) -> ModifiedState<f64> {
        self.law.settle(&self.along(motion), force)
    }

    /// What the deflection would gain in a period of a motion that repeats.
    pub fn creep(&self, motion: &Motion) -> f64 {
        self.law.creep(&Periodic { drift: 0.0, ..self.along(motion) })
    }

    /// Local derivatives of every step of the settled period, and those of the state with which it starts.
    pub fn locals(
        &self,
        motion: &Motion,
        start: ModifiedState<f64>,
        hooks: &[Hook],
        locals: &mut Vec<Local>,
    ) -> Begun {
        if hooks.is_empty() {
            self.locals_in::<BARE>(motion, start, hooks, locals)
        } else {
            self.locals_in::<WIDTH>(motion, start, hooks, locals)
        }
    }

    /// The same in so many directions: states and motion, then the hooks.
    fn locals_in<const W: usize>(
        &self,
        motion: &Motion,
        start: ModifiedState<f64>,
        hooks: &[Hook],
        locals: &mut Vec<Local>,
    ) -> Begun {
        let along = self.along(motion);
        let position = |hook: Hook| hooks.iter().position(|h| *h == hook);
        let law = self.law.lift(|hook, value| match position(hook) {
            Some(p) if Local::PARAMETER + p < W => Gradient::variable(value, Local::PARAMETER + p),
            _ => Gradient::<W>::constant(value),
        });
        let first = |at: usize, of: &[f64]| Gradient::variable(of[0], Local::MOTION + at);
        let moved = (first(0, &motion.slip), first(2, &motion.velocity), first(4, &motion.normal));
        let kept = law.kept(moved, &along, start);
        let begun = kept.map(|state| state.map_or([0.0; WIDTH], |state| widened(state.slopes)));
        locals.clear();
        let mut values = start.0;
        for k in 0..motion.slip.len() {
            let state = ModifiedState(std::array::from_fn(|i| Gradient::variable(values[i], i)));
            let plain = along.step(k);
            let pair =
                |at: usize, of: [f64; 2]| [Gradient::variable(of[0], at), Gradient::variable(of[1], at + 1)];
            let step = Step {
                slip: pair(Local::MOTION, plain.slip),
                velocity: pair(Local::MOTION + 2, plain.velocity),
                normal: pair(Local::MOTION + 4, plain.normal),
                dt: self.dt,
            };
            let circumstance = along.circumstance(&law, k);
            let (next, force) = match motion.trial.get(along.next(k)) {
                Some(&trial) => {
                    let held = Gradient::variable(trial, Local::TRIAL);
                    law.advance_rigid(state, &step, (held, &circumstance))
                }
                None => law.advance(state, &step, &circumstance),
            };
            values = next.0.map(|s| s.re);
            locals.push(Local {
                state: std::array::from_fn(|i| widened(next.0[i].slopes)),
                force: widened(force.slopes),
            });
        }
        begun
    }
}
