//! A law along a recovered period: its settled force, and the derivatives of that by values of the law.

use super::Recovered;
use frettrace_forward::accelerations::FrequencyRatio;
use frettrace_friction::effects::{Hook, ModifiedLaw, ModifiedState, Monodromy, Periodic, Reached, STATES};
use frettrace_friction::{Gradient, Step};
use nalgebra::DMatrixViewMut;
use num_complex::Complex64;

/// Directions differentiated at once: a cache line of slopes.
pub(crate) const LANES: usize = 8;

impl Recovered {
    fn along(&self, modulation: FrequencyRatio) -> Periodic<'_> {
        let modulation = modulation.line(self.driven).unwrap_or(0);
        Periodic {
            slip: &self.slip,
            velocity: &self.velocity,
            normal: &self.normal,
            trial: &self.trial,
            dt: self.dt,
            preload: self.preload,
            progress: self.progress,
            worked: self.worked,
            modulation,
            modulation_phase: modulation as f64 * self.base_phase,
            deflection: None,
            drift: 0.0,
        }
    }

    /// State at the start of the settled period, and the force over it.
    pub(super) fn settled(
        &self,
        law: &ModifiedLaw<f64>,
        modulation: FrequencyRatio,
    ) -> (ModifiedState<f64>, Vec<f64>) {
        let mut force = vec![0.0; self.slip.len()];
        let state = law.settle(&self.along(modulation), &mut force);
        (state, force)
    }

    /// Derivatives of the force over the settled period that begins in `state`, by what varies in the law in its first
    /// directions; the last ones, [`ModifiedLaw::states`] of them, are free.
    ///
    /// With the period's map `s ↦ P(s, p)` the settled state moves by `(I − ∂P/∂s)⁻¹ ∂P/∂p`: one period with the initial state in
    /// the free directions gives all of it.
    pub(super) fn slopes(
        &self,
        law: &ModifiedLaw<Gradient<LANES>>,
        modulation: FrequencyRatio,
        state: ModifiedState<f64>,
    ) -> Vec<Gradient<LANES>> {
        let along = self.along(modulation);
        let rigid = along.is_rigid(law);
        let used = law.states();
        let free = LANES - used;
        let mut reached = Reached::default();
        let first = [&self.slip, &self.velocity, &self.normal].map(|series| Gradient::constant(series[0]));
        let began =
            law.kept(first.into(), &along, state).map(|state| state.map_or([0.0; LANES], |s| s.slopes));
        let mut state = ModifiedState(std::array::from_fn(|i| {
            if i < used { Gradient::variable(state.0[i], free + i) } else { Gradient::constant(state.0[i]) }
        }));
        let mut force = vec![Gradient::constant(0.0); self.slip.len()];
        for k in 0..self.slip.len() {
            let (step, next) = (along.step(k), along.next(k));
            let ends = |pair: [f64; 2]| pair.map(Gradient::constant);
            let step = Step {
                slip: ends(step.slip),
                velocity: ends(step.velocity),
                normal: ends(step.normal),
                dt: step.dt,
            };
            let circumstance = along.circumstance(law, k);
            (state, force[next]) = if rigid {
                law.advance_rigid(state, &step, (Gradient::constant(self.trial[next]), &circumstance))
            } else {
                law.advance_on(state, &step, (&circumstance, &mut reached))
            };
        }
        let period = Monodromy::new(used, |i, j| state.0[i].slopes[free + j]);
        let moved: [[f64; STATES]; LANES] = std::array::from_fn(|lane| {
            let reached = std::array::from_fn(|i| if i < used { state.0[i].slopes[lane] } else { 0.0 });
            period.settle(reached, began.map(|state| state[lane]))
        });
        for force in &mut force {
            let own = force.slopes;
            let by_state = &own[free..];
            let through = |lane: usize| by_state.iter().zip(moved[lane]).map(|(a, b)| a * b).sum::<f64>();
            force.slopes =
                std::array::from_fn(|lane| if lane < free { own[lane] + through(lane) } else { 0.0 });
        }
        force
    }
}

/// Writes the derivatives of minus the whitened force by the hooks of a law, each with its column: `answer` is the force of the law
/// with derivatives in the first `lanes` directions, `whitened` turns its samples, linearly, into what is compared.
pub(crate) fn columns(
    (law, hooks): (&ModifiedLaw<f64>, &[(usize, Hook)]),
    (mut out, lanes): (DMatrixViewMut<'_, f64>, usize),
    mut answer: impl FnMut(&ModifiedLaw<Gradient<LANES>>) -> Vec<Gradient<LANES>>,
    whitened: impl Fn(&[f64]) -> Vec<Complex64>,
) {
    for block in hooks.chunks(lanes) {
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
