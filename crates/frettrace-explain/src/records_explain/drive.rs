//! A law with hooks driven along a history, with play in series and what acts beside it.

use super::RecordRun;
use super::setting::{Beside, RecordSetting};
use crate::contact_fit::LANES;
use frettrace_friction::effects::{Circumstance, Hook, ModifiedLaw, ModifiedState};
use frettrace_friction::{Gradient, Scalar, Step};

/// Errors of the motion that are added to it.
#[derive(Clone, Copy)]
pub(super) struct Shift<'a> {
    pub slip: &'a [f64],
    pub velocity: &'a [f64],
}

/// Forces along a run (N).
pub(super) fn forces(
    setting: &RecordSetting,
    values: &[f64],
    run: &RecordRun,
    shift: Option<Shift<'_>>,
) -> Vec<f64> {
    drive(setting, values, run, shift)
}

/// Forces with their derivatives by the unknowns of one block of lanes.
pub(super) fn tangents(
    setting: &RecordSetting,
    values: &[f64],
    run: &RecordRun,
    block: usize,
) -> Vec<Gradient<LANES>> {
    let duals: Vec<Gradient<LANES>> = values
        .iter()
        .enumerate()
        .map(|(j, value)| Gradient::variable(*value, j.wrapping_sub(LANES * block)))
        .collect();
    drive(setting, &duals, run, None)
}

/// First sample that counts: the opening state is forgotten after a way of half the range of the slip.
pub(super) fn first_counted(slip: &[f64]) -> usize {
    let (low, high) =
        slip.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), x| (a.min(*x), b.max(*x)));
    let mut way = 0.0;
    for (k, pair) in slip.windows(2).enumerate() {
        way += (pair[1] - pair[0]).abs();
        if way >= 0.5 * (high - low) {
            return k + 1;
        }
    }
    1
}

fn drive<T: Scalar>(
    setting: &RecordSetting,
    values: &[T],
    run: &RecordRun,
    shift: Option<Shift<'_>>,
) -> Vec<T> {
    let history = &run.history;
    let (law, beside) = setting.over(values);
    let slip = |k: usize| T::from(history.slip[k] - setting.middle + shift.map_or(0.0, |s| s.slip[k]));
    let velocity = |k: usize| T::from(history.velocity[k] + shift.map_or(0.0, |s| s.velocity[k]));
    let mut state = opening(setting, run, &law);
    let sense = if history.velocity.first().is_some_and(|v| *v < 0.0) { -1.0 } else { 1.0 };
    let mut play = beside.gap.map(|half| half * sense);
    let samples = history.len();
    let mut out = Vec::with_capacity(samples);
    out.push(T::from(history.force.first().copied().unwrap_or(0.0)));
    for k in 1..samples {
        let place = k as f64 / samples as f64;
        let circumstance = Circumstance {
            preload: setting.reference_load,
            progress: run.progress[0] + place * (run.progress[1] - run.progress[0]),
            ..Circumstance::default()
        };
        let step = Step {
            slip: [slip(k - 1), slip(k)],
            velocity: [velocity(k - 1), velocity(k)],
            normal: [beside.squeeze + history.normal[k - 1], beside.squeeze + history.normal[k]],
            dt: history.time[k] - history.time[k - 1],
        };
        let force;
        (state, force) = match (play, beside.gap) {
            (Some(crossed), Some(half)) => {
                let (state, force, crossed) =
                    through_play((&law, half), (state, crossed), &step, &circumstance);
                play = Some(crossed);
                (state, force)
            }
            _ => law.advance(state, &step, &circumstance),
        };
        out.push(force);
    }
    add_beside(&mut out, run, &beside);
    out
}

/// The state of the first sample: its force over the normal force, within what the law can hold.
fn opening<T: Scalar>(setting: &RecordSetting, run: &RecordRun, law: &ModifiedLaw<T>) -> ModifiedState<T> {
    let history = &run.history;
    let at = |x: &[f64]| x.first().copied().unwrap_or(0.0);
    let value = |hook: Hook| law.get(hook).map_or(0.0, |v| v.re());
    let most = value(Hook::MuKinetic) + value(Hook::StribeckRise);
    let normal = at(&history.normal).max(f64::MIN_POSITIVE);
    let ratio = (at(&history.force) - value(Hook::Viscous) * at(&history.velocity)) / normal;
    let mut state = law.rest_at(T::from(at(&history.slip) - setting.middle));
    state.0[0] = T::from(ratio.clamp(-0.999 * most, 0.999 * most));
    state
}

/// One step of a contact in series with play: while the force has one sign the play rests at one side; where the force
/// comes to zero the play is crossed before the contact moves on.
fn through_play<T: Scalar>(
    (law, half): (&ModifiedLaw<T>, T),
    (state, crossed): (ModifiedState<T>, T),
    step: &Step<T>,
    circumstance: &Circumstance,
) -> (ModifiedState<T>, T, T) {
    let travel = step.slip[1] - step.slip[0];
    let sense = if travel.re() < 0.0 { -1.0 } else { 1.0 };
    let engaged = Step { slip: [step.slip[0] - crossed, step.slip[1] - crossed], ..*step };
    let (moved, force) = law.advance(state, &engaged, circumstance);
    let (before, after) = (state.0[0], moved.0[0]);
    let room = half * sense - crossed;
    let pushes = after.re() * sense > 0.0;
    if !pushes || before.re() * sense > 0.0 || room.re() * sense <= 0.0 {
        return (moved, force, crossed);
    }
    let left = travel * (-unloaded((law, state), &engaged, (before, after), circumstance) + 1.0);
    let mut free = moved;
    free.0[0] = T::from(0.0);
    let viscous = law.get(Hook::Viscous).unwrap_or_else(|| T::from(0.0)) * step.velocity[1];
    let still = T::from(0.0);
    if (left - room).re() * sense <= 0.0 {
        let place = engaged.slip[1] - left;
        let rest = Step { slip: [place, place], velocity: [still, still], ..*step };
        let (free, force) = law.advance(free, &rest, circumstance);
        return (free, force + viscous, crossed + left);
    }
    let onward = left - room;
    let speed = onward / step.dt;
    let end = step.slip[1] - half * sense;
    let rest = Step { slip: [end - onward, end], velocity: [speed, speed], ..*step };
    let (state, force) = law.advance(free, &rest, circumstance);
    let faster = law.get(Hook::Viscous).map_or(still, |c| c * (step.velocity[1] - speed));
    (state, force + faster, half * sense)
}

/// Share of a step at which the force is zero: the secant, twice corrected.
fn unloaded<T: Scalar>(
    (law, state): (&ModifiedLaw<T>, ModifiedState<T>),
    step: &Step<T>,
    (before, after): (T, T),
    circumstance: &Circumstance,
) -> T {
    let travel = step.slip[1] - step.slip[0];
    let mut share = before / (before - after);
    let mut known = (T::from(0.0), before);
    for _ in 0..2 {
        if share.re() <= 1e-9 || share.re() >= 1.0 {
            break;
        }
        let part = Step {
            slip: [step.slip[0], step.slip[0] + travel * share],
            velocity: [step.velocity[0], step.velocity[0] + (step.velocity[1] - step.velocity[0]) * share],
            normal: step.normal,
            dt: step.dt * share.re(),
        };
        let reached = law.advance(state, &part, circumstance).0.0[0];
        let slope = (reached - known.1) / (share - known.0);
        if slope.re() == 0.0 || reached.re() == 0.0 {
            break;
        }
        let next = share - reached / slope;
        known = (share, reached);
        if !(next.re() > 0.0 && next.re() < 1.0) {
            break;
        }
        share = next;
    }
    share
}

/// Inertia, offsets, and the delay of the force channel (first order).
fn add_beside<T: Scalar>(out: &mut [T], run: &RecordRun, beside: &Beside<T>) {
    let history = &run.history;
    for (k, force) in out.iter_mut().enumerate() {
        let acceleration = history.acceleration.as_ref().map_or(0.0, |a| a[k]);
        *force += beside.mass * acceleration + beside.offset + beside.load_offset * history.normal[k];
    }
    let Some(delay) = beside.delay else { return };
    let plain = out.to_vec();
    for k in 1..plain.len().saturating_sub(1) {
        let rate = (plain[k + 1] - plain[k - 1]) / (history.time[k + 1] - history.time[k - 1]);
        out[k] = plain[k] - delay * rate;
    }
}
