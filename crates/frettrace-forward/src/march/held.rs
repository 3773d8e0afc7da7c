//! The structure while its contact is held.
//!
//! Specified: modes, the shapes `γ` of the held port, all other loads `p`, linear over the step. Unknown: the motion and the force `F` that
//! holds. Equations:
//!
//! ```text
//! q̈ = p − D q̇ − K q − γF,  γᵀq̇ = 0   ⇒   F = γᵀ(p − D q̇ − K q)/γᵀγ,   q̈ = (I − γγᵀ/γᵀγ)(p − D q̇ − K q)
//! ```
//!
//! That is linear: whatever it takes to hold the contact, the step of `(Ωq, q̇)` and of the loads beside it is one exponential of the
//! matrix of this system, exact for any length. Nothing is iterated, no force has to be a line between samples, and what rings while
//! the contact sticks costs no steps. Halved steps come from the shortest by doubling, `X ← 2X + X²` of `X = e^{Ah} − 1`, which keeps the
//! digits of the short ones.

use nalgebra::{DMatrix, DVector};
use pulp::{Arch, Simd, WithSimd};

use super::engine::dot;
use super::structure::Structure;

/// The step of a held structure: a linear map from modal displacements, velocities and the loads at its beginning and end.
#[derive(Clone, Debug)]
pub(super) struct Held {
    /// Columns, each with all displacements and then all velocities at the end: those of displacements and velocities, of the loads
    /// at the beginning, of the loads at the end.
    columns: DMatrix<f64>,
    modes: usize,
}

/// Norm of `A h` below which the series takes few terms, …
const SMALL: f64 = 0.25;
/// … this many: the next one is 0.25¹²/12! < 1e-16.
const TERMS: usize = 11;

impl Held {
    /// Held steps of `dt` (s) and its halvings, `count` in all, with loads at the ports `loads`.
    pub(super) fn ladder(
        structure: &Structure,
        (held, loads): (usize, &[usize]),
        (dt, count): (f64, usize),
    ) -> Vec<Self> {
        let system = system(structure, held, loads, dt);
        let norm = system.abs().column_sum().max();
        let spare = (norm / SMALL).log2().ceil().max(0.0) as usize;
        let deepest = spare.max(count.saturating_sub(1));
        let mut less_one = series(&(system * 0.5_f64.powi(deepest as i32)));
        let mut ladder = Vec::new();
        for level in (0..=deepest).rev() {
            if level < count {
                ladder.push(Self::new(structure, &less_one, 0.5_f64.powi(level as i32)));
            }
            less_one = &less_one * 2.0 + &less_one * &less_one;
        }
        ladder.reverse();
        ladder
    }

    /// From `e^{Ah} − 1` of the scaled system; `share` of the whole step is `h`.
    fn new(structure: &Structure, less_one: &DMatrix<f64>, share: f64) -> Self {
        let frequency = structure.natural_frequency();
        let modes = frequency.len();
        let loads = (less_one.ncols() - 2 * modes) / 2;
        let scale = |index: usize| frequency.get(index).copied().unwrap_or(1.0);
        let columns = DMatrix::from_fn(2 * modes, 2 * (modes + loads), |row, column| {
            if column < 2 * modes {
                let one = f64::from(u8::from(row == column));
                return (less_one[(row, column)] + one) * scale(column) / scale(row);
            }
            let load = column - 2 * modes;
            // The load grows by its rate, per whole step, times the share: from the value at the end this much is taken back.
            let of_rate = |load: usize| less_one[(row, 2 * modes + loads + load)] / share;
            let entry = if load < loads {
                less_one[(row, 2 * modes + load)] - of_rate(load)
            } else {
                of_rate(load - loads)
            };
            entry / scale(row)
        });
        Self { columns, modes }
    }

    /// Displacements and velocities at the end of the step, of those at its beginning and the loads (N) at both.
    pub(super) fn advance(
        &self,
        start: [&[f64]; 2],
        loads: [&[f64]; 2],
        [displacement, velocity]: [&mut [f64]; 2],
    ) {
        displacement.fill(0.0);
        velocity.fill(0.0);
        let values: [&[f64]; 4] = [start[0], start[1], loads[0], loads[1]];
        Arch::new().dispatch(Advance { step: self, values, displacement, velocity });
    }

    /// Adds what a load at the end of the step does; a `constant` one acts all through the step.
    pub(super) fn add_load(&self, (load, constant): (usize, bool), value: f64, end: [&mut [f64]; 2]) {
        let [displacement, velocity] = end;
        let last = self.loads() + load;
        for load in constant.then_some(load).into_iter().chain([last]) {
            let [to_q, to_v] = self.column(2 * self.modes + load);
            add_times(displacement, to_q, value);
            add_times(velocity, to_v, value);
        }
    }

    fn loads(&self) -> usize {
        (self.columns.ncols() - 2 * self.modes) / 2
    }

    /// What a value does to displacements and velocities.
    #[inline(always)]
    fn column(&self, column: usize) -> [&[f64]; 2] {
        let length = 2 * self.modes;
        let (displacement, velocity) =
            self.columns.as_slice()[column * length..(column + 1) * length].split_at(self.modes);
        [displacement, velocity]
    }

    /// Displacement and velocity at the end of the step, of a port with these shapes, per unit of a load as of [`Self::add_load`].
    pub(super) fn response(&self, shapes: &[f64], load: (usize, bool)) -> [f64; 2] {
        let mut end = [vec![0.0; self.modes], vec![0.0; self.modes]];
        let [displacement, velocity] = &mut end;
        self.add_load(load, 1.0, [displacement, velocity]);
        end.map(|motion| dot(shapes, &motion))
    }
}

impl Held {
    /// What is still to come of a motion that settles, held all the time: of displacements and velocities, from their change over the
    /// last of equal periods of so many steps.
    ///
    /// With the map `E` of a period, `y* − y = (1 − E)⁻¹ E Δ`. The place where the port is held, and its rest, do not settle: `E` leaves
    /// them, and two dyads keep them as they are.
    pub(super) fn to_come(
        &self,
        structure: &Structure,
        port: usize,
        change: [&[f64]; 2],
        steps: usize,
    ) -> Option<[Vec<f64>; 2]> {
        let (modes, frequency, shape) = (self.modes, structure.natural_frequency(), structure.row(port));
        let scale = |index: usize| frequency.get(index).copied().unwrap_or(1.0);
        let step = DMatrix::from_fn(2 * modes, 2 * modes, |row, column| {
            self.columns[(row, column)] * scale(row) / scale(column)
        });
        let period = step.pow(u32::try_from(steps).ok()?);
        let change = DVector::from_fn(2 * modes, |row, _| change[row / modes][row % modes] * scale(row));
        let mut system = DMatrix::identity(2 * modes, 2 * modes) - &period;
        let place = DVector::from_fn(2 * modes, |row, _| shape.get(row).map_or(0.0, |g| g / frequency[row]));
        let motion = DVector::from_fn(2 * modes, |row, _| if row < modes { 0.0 } else { shape[row - modes] });
        for kept in [place, motion].map(|kept| kept.normalize()) {
            system.ger(1.0, &kept, &kept, 1.0);
        }
        let found = system.lu().solve(&(period * change))?;
        let part = |first: usize| (0..modes).map(|n| found[first + n] / scale(first + n)).collect();
        Some([part(0), part(modes)])
    }
}

/// A step, in the code of each instruction set.
struct Advance<'a> {
    step: &'a Held,
    values: [&'a [f64]; 4],
    displacement: &'a mut [f64],
    velocity: &'a mut [f64],
}

impl WithSimd for Advance<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let Self { step, values, displacement, velocity } = self;
        let mut first = 0;
        for values in values {
            // Four columns a time: what is added to is loaded and stored once for them.
            let mut fours = values.chunks_exact(4);
            for (four, &[a, b, c, d]) in fours.by_ref().flat_map(<&[f64; 4]>::try_from).enumerate() {
                let columns = [0, 1, 2, 3].map(|k| step.column(first + 4 * four + k));
                for (part, target) in [&mut *displacement, &mut *velocity].into_iter().enumerate() {
                    let [p, q, r, s] = columns.map(|column| column[part]);
                    for ((((entry, p), q), r), s) in target.iter_mut().zip(p).zip(q).zip(r).zip(s) {
                        *entry += (a * p + b * q) + (c * r + d * s);
                    }
                }
            }
            let rest = fours.remainder();
            let column = first + values.len() - rest.len();
            for (k, &value) in rest.iter().enumerate() {
                let [to_q, to_v] = step.column(column + k);
                add_times(displacement, to_q, value);
                add_times(velocity, to_v, value);
            }
            first += values.len();
        }
    }
}

#[inline(always)]
fn add_times(target: &mut [f64], values: &[f64], factor: f64) {
    for (entry, value) in target.iter_mut().zip(values) {
        *entry += value * factor;
    }
}

/// The matrix of the whole step, `A Δt`: energy coordinates, loads, and their rates per step.
fn system(structure: &Structure, held: usize, loads: &[usize], dt: f64) -> DMatrix<f64> {
    let (frequency, ratio) = (structure.natural_frequency(), structure.damping_ratio());
    let (modes, shape) = (frequency.len(), structure.row(held));
    let square = dot(shape, shape);
    let size = 2 * (modes + loads.len());
    let mut system = DMatrix::zeros(size, size);
    for n in 0..modes {
        system[(n, modes + n)] = dt * frequency[n];
    }
    // What acts on the modes, less its part along the held shape.
    let mut projected = |column: usize, force: &dyn Fn(usize) -> f64| {
        let along: f64 = (0..modes).map(|n| shape[n] * force(n)).sum::<f64>() / square;
        for n in 0..modes {
            system[(modes + n, column)] = dt * (force(n) - shape[n] * along);
        }
    };
    for k in 0..modes {
        let only = |value: f64| move |n: usize| if n == k { value } else { 0.0 };
        projected(k, &only(-frequency[k]));
        projected(modes + k, &only(-2.0 * ratio[k] * frequency[k]));
    }
    for (index, &port) in loads.iter().enumerate() {
        projected(2 * modes + index, &|n| structure.row(port)[n]);
    }
    for index in 0..loads.len() {
        system[(2 * modes + index, 2 * modes + loads.len() + index)] = 1.0;
    }
    system
}

/// `e^A − 1` by its series.
fn series(matrix: &DMatrix<f64>) -> DMatrix<f64> {
    let mut term = matrix.clone();
    let mut sum = matrix.clone();
    for k in 2..=TERMS {
        term = &term * matrix / k as f64;
        sum += &term;
    }
    sum
}

/// A linear form of modal displacements, velocities and loads.
type Form = [Vec<f64>; 3];

/// Modal displacements, velocities and loads.
pub(super) type Motion<'a> = [&'a [f64]; 3];

/// What holds a port.
#[derive(Clone, Debug)]
pub(super) struct Holding {
    /// `γᵀγ`: acceleration (m/s²) that a newton on the port makes there at once.
    pub(super) mobility: f64,
    force: Form,
    rate: Form,
}

impl Holding {
    pub(super) fn new(structure: &Structure, port: usize) -> Self {
        let shape = structure.row(port);
        let mobility = dot(shape, shape);
        let form = |of: &dyn Fn([f64; 2]) -> f64| -> Vec<f64> {
            let modes = structure.natural_frequency().iter().zip(structure.damping_ratio());
            let terms = modes.map(|(w, ratio)| of([w * w, 2.0 * ratio * w]));
            terms.zip(shape).map(|(term, g)| term * g / mobility).collect()
        };
        Self {
            mobility,
            force: [form(&|[k, _]| -k), form(&|[_, d]| -d), form(&|_| 1.0)],
            rate: [form(&|[k, d]| d * k), form(&|[k, d]| d * d - k), form(&|[_, d]| -d)],
        }
    }

    /// Force (N) that holds the port, of the motion with all other loads; with all loads, the acceleration of the port over
    /// [`Self::mobility`].
    pub(super) fn force(&self, motion: Motion<'_>) -> f64 {
        value(&self.force, motion)
    }

    /// Rate of that force (N/s) with the port held, of the motion with all loads, as far as the loads themselves do not change:
    /// `γᵀ(−D q̈ − K q̇)/γᵀγ`.
    pub(super) fn rate(&self, motion: Motion<'_>) -> f64 {
        value(&self.rate, motion)
    }
}

fn value(form: &Form, motion: Motion<'_>) -> f64 {
    form.iter().zip(motion).map(|(row, values)| dot(row, values)).sum()
}

/// Whether the cubic through two values, neither below zero, with these slopes (per step) is clearly below zero between them.
pub(super) fn dips([start, end]: [f64; 2], [leaving, arriving]: [f64; 2]) -> bool {
    let rise = end - start;
    let [bend, lean] = [leaving + arriving - 2.0 * rise, 3.0 * rise - 2.0 * leaving - arriving];
    let at = |s: f64| start + s * (leaving + s * (lean + s * bend));
    // Roots of 3·bend s² + 2·lean s + leaving, the form that does not cancel first.
    let discriminant = lean * lean - 3.0 * bend * leaving;
    if discriminant < 0.0 {
        return false;
    }
    let pivot = -(lean + discriminant.sqrt().copysign(lean));
    let rounding = 1e-9 * (start.abs() + end.abs());
    [pivot / (3.0 * bend), leaving / pivot].into_iter().any(|s| s > 0.0 && s < 1.0 && at(s) < -rounding)
}

#[cfg(test)]
mod tests;
