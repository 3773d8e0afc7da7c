//! A law along a recovered period: its settled force, and the derivatives of that by values of the law.

use super::Recovered;
use frettrace_friction::effects::{Circumstance, Hook, ModifiedLaw, ModifiedState};
use frettrace_friction::{Gradient, Scalar, Step};
use nalgebra::DMatrixViewMut;
use num_complex::Complex64;

/// Directions differentiated at once: a cache line of slopes.
pub(crate) const LANES: usize = 8;
/// Periods after which a state counts as settled.
const PERIODS: usize = 6;
/// Relative change over a period below which the state is settled …
const SETTLED: f64 = 1e-7;
/// … with a deflection (in units of the friction coefficient) that is none, …
const NONE: f64 = 1e-9;
/// … and the relative change below which its derivatives are: they guide a step, they do not judge it.
const SLOPES_SETTLED: f64 = 1e-4;

impl Recovered {
    /// Force of the law over the settled period.
    pub fn answer(&self, law: &ModifiedLaw<f64>, modulation: usize) -> Vec<f64> {
        self.settled(law, modulation).1
    }

    /// State at the start of the settled period, and the force over it.
    pub(super) fn settled(
        &self,
        law: &ModifiedLaw<f64>,
        modulation: usize,
    ) -> (ModifiedState<f64>, Vec<f64>) {
        let virgin = Step {
            slip: [0.0, self.slip[0]],
            velocity: [self.velocity[0]; 2],
            normal: [self.normal[0]; 2],
            dt: self.dt,
        };
        let modulation = modulated(law, modulation);
        let mut force = vec![0.0; self.slip.len()];
        let (mut state, _) = law.advance(law.rest_at(0.0), &virgin, &self.circumstance(0, modulation));
        for _ in 0..PERIODS {
            let before = state;
            state = self.period(law, modulation, before, &mut force);
            let closed = |(now, then): (&f64, &f64)| (now - then).abs() <= SETTLED * (NONE + then.abs());
            if state.0.iter().zip(&before.0).all(closed) {
                break;
            }
        }
        (state, force)
    }

    /// Force over the settled period that begins in `state`, with its derivatives by what varies in the law.
    pub(super) fn slopes(
        &self,
        law: &ModifiedLaw<Gradient<LANES>>,
        modulation: usize,
        state: ModifiedState<f64>,
    ) -> Vec<Gradient<LANES>> {
        let modulation = modulated(law, modulation);
        let mut state = ModifiedState(state.0.map(Gradient::constant));
        let mut force = vec![Gradient::constant(0.0); self.slip.len()];
        for _ in 0..PERIODS {
            let before = state;
            state = self.period(law, modulation, before, &mut force);
            let closed = |(now, then): (&Gradient<LANES>, &Gradient<LANES>)| {
                now.slopes.iter().zip(then.slopes).all(|(a, b)| (a - b).abs() <= SLOPES_SETTLED * a.abs())
            };
            if state.0.iter().zip(&before.0).all(closed) {
                break;
            }
        }
        force
    }

    /// One period from a state; the state after it.
    fn period<T: Scalar>(
        &self,
        law: &ModifiedLaw<T>,
        modulation: Option<usize>,
        mut state: ModifiedState<T>,
        force: &mut [T],
    ) -> ModifiedState<T> {
        let rigid = !self.trial.is_empty() && !law.yields();
        let samples = self.slip.len();
        for k in 0..samples {
            let next = if k + 1 == samples { 0 } else { k + 1 };
            let ends = |series: &[f64]| [T::from(series[k]), T::from(series[next])];
            let step = Step {
                slip: ends(&self.slip),
                velocity: ends(&self.velocity),
                normal: ends(&self.normal),
                dt: self.dt,
            };
            let circumstance = self.circumstance(k, modulation);
            (state, force[next]) = if rigid {
                law.advance_rigid(state, &step, (T::from(self.trial[next]), &circumstance))
            } else {
                law.advance(state, &step, &circumstance)
            };
        }
        state
    }

    fn circumstance(&self, k: usize, modulation: Option<usize>) -> Circumstance {
        let samples = self.slip.len();
        let phase = |k: usize, order: usize| {
            let angle = std::f64::consts::TAU * ((order * k) % samples) as f64 / samples as f64;
            [angle.cos(), angle.sin()]
        };
        Circumstance {
            preload: self.preload,
            progress: self.progress,
            phase: modulation.map_or([[1.0, 0.0]; 2], |m| [phase(k, m), phase(k + 1, m)]),
        }
    }
}

/// The line that modulates the preload, where the law has one.
fn modulated<T: Scalar>(law: &ModifiedLaw<T>, modulation: usize) -> Option<usize> {
    law.get(Hook::ModulationCosine).map(|_| modulation)
}

/// Writes the derivatives of minus the whitened force by the hooks of a law, each with its column: `answer` is the force of the law,
/// `whitened` turns its samples, linearly, into what is compared.
pub(crate) fn columns(
    (law, hooks): (&ModifiedLaw<f64>, &[(usize, Hook)]),
    mut out: DMatrixViewMut<'_, f64>,
    answer: impl Fn(&ModifiedLaw<Gradient<LANES>>) -> Vec<Gradient<LANES>>,
    whitened: impl Fn(&[f64]) -> Vec<Complex64>,
) {
    for block in hooks.chunks(LANES) {
        let seeded = law.lift(|hook, value| match block.iter().position(|(_, free)| *free == hook) {
            Some(lane) => Gradient::variable(value, lane),
            None => Gradient::constant(value),
        });
        let force = answer(&seeded);
        for (lane, (column, _)) in block.iter().enumerate() {
            let slopes: Vec<f64> = force.iter().map(|f| f.slopes[lane]).collect();
            for (row, slope) in whitened(&slopes).iter().enumerate() {
                out[(2 * row, *column)] = -slope.re;
                out[(2 * row + 1, *column)] = -slope.im;
            }
        }
    }
}
