//! A law along a motion that repeats: its settled state and force.
//!
//! Along a given motion nothing but the deflection depends on the deflection. So the state settles part by part – the slip that
//! play engages, the memory, the deflection, the lagged force – and the friction coefficient, which costs most, is computed
//! once for every place instead of once in every period. A part that is the fixed point of `x = P(x)`, one period, is found
//! by the secant; where `P(x) = a + kx` (a bristle of linear saturation along a given motion) it is
//! `x = a/(1 − k)`.

use super::hooks::Hook;
use super::leg::{Flow, Leg};
use super::modified::{Circumstance, End, ModifiedLaw, ModifiedState, sense};
use super::monodromy::{FORGETS, STATES};
use crate::law::{Scalar, Step};

/// Periods after which a state counts as settled, …
const PERIODS: usize = 12;
/// … relative change over a period below which it is, …
const SETTLED: f64 = 1e-9;
/// … beside a state (in units of the friction coefficient, or of the memory) that is none.
const NONE: f64 = 1e-12;
/// Relative difference below which a state has met what it was a period before, and stays with it: along a given motion differences only shrink.
const MET: f64 = 1e-11;
/// Slip that a contact with a deflection of its own gains in a period at most, over what the bristle would lose in it by its stiffness.
const FARTHEST: f64 = 30.0;

/// Motion of a contact over one period, one value a sample; the series are equally long and not empty.
#[derive(Clone, Copy, Debug)]
pub struct Periodic<'a> {
    /// Slip (m).
    pub slip: &'a [f64],
    /// Slip velocity (m/s).
    pub velocity: &'a [f64],
    /// Normal force (N).
    pub normal: &'a [f64],
    /// Force that a rigid contact takes as long as it holds (N); empty where the contact yields.
    pub trial: &'a [f64],
    /// Duration between two samples (s).
    pub dt: f64,
    /// Preload (N).
    pub preload: f64,
    /// Place of the run between the first (0) and the last (1).
    pub progress: f64,
    /// The same in the work that friction had done when it began and when it ended.
    pub worked: [f64; 2],
    /// Line of the base frequency with which the preload is modulated, where the law has that; 0 where this run has no such line.
    pub modulation: usize,
    /// Phase of that line at the first sample (rad).
    pub modulation_phase: f64,
    /// Deflection (in units of the friction coefficient) with which the period begins, where the contact has not settled: one that creeps by
    /// little in a period moves as if it had, for long. `None` where it has.
    pub deflection: Option<f64>,
    /// Slip (m) that such a contact gains in the period beside the motion that repeats ([`ModifiedLaw::drift`]): what the bristle would lose, the
    /// structure that holds it follows with.
    pub drift: f64,
}

impl Periodic<'_> {
    /// The sample after the `k`-th: the first after the last.
    #[must_use]
    pub fn next(&self, k: usize) -> usize {
        if k + 1 < self.slip.len() { k + 1 } else { 0 }
    }

    /// The step from the `k`-th sample to the next.
    #[must_use]
    pub fn step(&self, k: usize) -> Step<f64> {
        let ends = |series: &[f64]| [series[k], series[self.next(k)]];
        let [mut slip, mut velocity] = [self.slip, self.velocity].map(ends);
        if self.drift != 0.0 {
            let gained = self.drift / self.slip.len() as f64;
            slip[0] += gained * k as f64;
            slip[1] += gained * (k + 1) as f64;
            velocity.iter_mut().for_each(|v| *v += gained / self.dt);
        }
        Step { slip, velocity, normal: ends(self.normal), dt: self.dt }
    }

    /// What a law needs to know of that step beside its motion.
    #[must_use]
    pub fn circumstance<T: Scalar>(&self, law: &ModifiedLaw<T>, k: usize) -> Circumstance {
        let modulated = law.on(Hook::ModulationCosine);
        let phase = if modulated { [self.phase(k), self.phase(self.next(k))] } else { [[1.0, 0.0]; 2] };
        Circumstance { preload: self.preload, progress: self.progress, worked: self.worked, phase }
    }

    fn phase(&self, k: usize) -> [f64; 2] {
        if self.modulation == 0 {
            return [0.0; 2];
        }
        let samples = self.slip.len();
        let turns = (self.modulation * k % samples) as f64 / samples as f64;
        let angle = std::f64::consts::TAU * turns + self.modulation_phase;
        [angle.cos(), angle.sin()]
    }

    /// Whether a law is set-valued at rest along this motion.
    #[must_use]
    pub fn is_rigid<T: Scalar>(&self, law: &ModifiedLaw<T>) -> bool {
        !self.trial.is_empty() && !law.yields()
    }
}

impl<T: Scalar> ModifiedLaw<T> {
    /// The state at the first sample of a motion, slip, velocity and normal force of it as given, come to from rest along the virgin curve.
    fn begun(&self, (slip, velocity, normal): (T, T, T), along: &Periodic<'_>) -> ModifiedState<T> {
        let virgin =
            Step { slip: [T::from(0.0), slip], velocity: [velocity; 2], normal: [normal; 2], dt: along.dt };
        let last = along.slip.len() - 1;
        let mut begun = self.advance(self.rest_at(T::from(0.0)), &virgin, &along.circumstance(self, last)).0;
        if let Some(deflection) = along.deflection {
            begun.0[0] = T::from(deflection);
        }
        begun
    }

    /// The state that the contact came to from rest, or that it is given, where the period still starts with it: one that forgets nothing
    /// keeps it. `None` for each state that the period has changed.
    #[must_use]
    pub fn kept(
        &self,
        moved: (T, T, T),
        along: &Periodic<'_>,
        start: ModifiedState<f64>,
    ) -> [Option<T>; STATES] {
        if along.is_rigid(self) {
            return [None; STATES];
        }
        let begun = self.begun(moved, along).0;
        std::array::from_fn(|i| {
            let value = begun[i].re();
            ((start.0[i] - value).abs() <= SETTLED * value.abs()).then_some(begun[i])
        })
    }
}

/// A settled bristle: deflection after every step, and the friction coefficient there.
struct Rubbed {
    start: f64,
    deflection: Vec<f64>,
    friction: Vec<f64>,
}

impl Rubbed {
    /// Deflection with which the period ends.
    fn end(&self) -> f64 {
        self.deflection.last().copied().unwrap_or(self.start)
    }
}

/// A contact that is not set-valued at rest, along a period: its monotone stretches, the last one of every step, the states with which the period begins,
/// the lagged force being that of rest, and the bristle.
struct Yielded {
    legs: Vec<Leg<f64>>,
    of_step: Vec<usize>,
    memory: f64,
    engaged: f64,
    lagged: f64,
    rubbed: Rubbed,
}

impl ModifiedLaw<f64> {
    /// Writes the settled force (N) at every sample of a motion; the state with which its period begins. A contact that never
    /// forgets is as it comes from rest along its virgin curve, and one that has not settled begins with its own deflection.
    pub fn settle(&self, along: &Periodic<'_>, force: &mut [f64]) -> ModifiedState<f64> {
        if along.is_rigid(self) {
            return self.settle_rigid(along, force);
        }
        self.settle_yielding(along, force)
    }

    /// What the deflection gains in a period that begins with one of its own ([`Periodic::deflection`]); nothing where it has settled.
    #[must_use]
    pub fn creep(&self, along: &Periodic<'_>) -> f64 {
        if along.deflection.is_none() || along.is_rigid(self) {
            return 0.0;
        }
        // What the force is does not tell what the deflection does.
        let rubbed = self.yielded(along).rubbed;
        rubbed.end() - rubbed.start
    }

    /// Slip (m) that a contact with a deflection of its own ([`Periodic::deflection`]) gains in a period, in which the deflection comes back to what it
    /// was: a soft structure follows its mean force, so that a bristle that would lose a part of it in every period loses
    /// `1 + R₀Pσ₀` times less. 0 where the contact has settled, where it loses nothing, where it forgets within the period, and where play takes the slip up.
    ///
    /// `z(T; δ) = z₀` is solved by the secant, begun with the bristle's own stiffness, `δ = (z₀ − z(T; 0))/σ₀`.
    #[must_use]
    pub fn drift(&self, along: &Periodic<'_>) -> f64 {
        let plain = Periodic { drift: 0.0, ..*along };
        let sigma0 = self.get(Hook::Sigma0).unwrap_or_default();
        let lost = -self.creep(&plain);
        if lost.abs() <= NONE || sigma0 <= 0.0 || self.on(Hook::Backlash) {
            return 0.0;
        }
        let left = |drift: f64| self.creep(&Periodic { drift, ..plain });
        let (mut before, mut drift) = ([0.0, -lost], lost / sigma0);
        for _ in 0..PERIODS {
            let now = left(drift);
            let next = drift - now * (drift - before[0]) / (now - before[1]);
            if now.abs() <= SETTLED * lost.abs() {
                return drift;
            }
            // Where it slides all the way no slip brings it back: it has settled.
            if !next.is_finite() || next.abs() > FARTHEST * (lost / sigma0).abs() {
                return 0.0;
            }
            (before, drift) = ([drift, now], next);
        }
        drift
    }

    /// A contact that is not set-valued at rest, but for its force.
    fn yielded(&self, along: &Periodic<'_>) -> Yielded {
        let begun = self.begun((along.slip[0], along.velocity[0], along.normal[0]), along);
        let [b, memory, engaged, lagged] = begun.0;
        let (mut legs, of_step, engaged) = self.legs(along, engaged);
        let memory = if self.remembers() {
            let mut repeated = Repeated::new(legs.len());
            close(memory, |memory| repeated.lead(memory, |k, memory| legs[k].recall(self, memory)))
        } else {
            memory
        };
        let rubbed = self.rub(along, (&legs, &of_step), b);
        Yielded { legs, of_step, memory, engaged, lagged, rubbed }
    }

    /// The same with its force.
    fn settle_yielding(&self, along: &Periodic<'_>, force: &mut [f64]) -> ModifiedState<f64> {
        let Yielded { legs, of_step, memory, engaged, lagged, rubbed } = self.yielded(along);
        let circumstance = along.circumstance(self, 0);
        for (k, &last) in of_step.iter().enumerate() {
            let (next, leg) = (along.next(k), &legs[last]);
            let Step { slip: [_, slip], velocity: [_, velocity], .. } = along.step(k);
            let normal = self.pressed(along, next);
            let end = End { memory: leg.ends[2].memory, ..self.place(slip, (velocity, normal)) };
            let known = self.joins() && leg.sign == sense(velocity);
            let friction = || {
                if known { rubbed.friction[k] } else { self.friction(&end, sense(velocity), &circumstance) }
            };
            force[next] = self.force(rubbed.deflection[k], &end, velocity, friction);
        }
        let lagged = if self.on(Hook::ForceLag) { self.settle_lag(along, force, lagged) } else { lagged };
        ModifiedState([rubbed.start, memory, engaged, lagged])
    }

    /// Normal force at a sample, with the modulation of the preload.
    fn pressed(&self, along: &Periodic<'_>, k: usize) -> f64 {
        if !self.on(Hook::ModulationCosine) {
            return along.normal[k];
        }
        self.modulated(along.normal[k], along.phase(k), along.preload)
    }

    /// The monotone stretches of the period, the last one of every step, and the engaged slip at its start.
    fn legs(&self, along: &Periodic<'_>, mut engaged: f64) -> (Vec<Leg<f64>>, Vec<usize>, f64) {
        let samples = along.slip.len();
        if self.on(Hook::Backlash) {
            // One period of a given slip leads its play where every later one does, unless it closes gradually.
            let period = |x: f64| (0..samples).fold(x, |x, k| self.catch(x, &along.step(k)).0);
            engaged = if self.on(Hook::BacklashPower) { close(engaged, period) } else { period(engaged) };
        }
        let begun = engaged;
        let mut legs: Vec<Leg<f64>> = Vec::with_capacity(samples + 16);
        let mut of_step = Vec::with_capacity(samples);
        let mut from = self.pressed(along, 0);
        for k in 0..samples {
            let to = self.pressed(along, along.next(k));
            let (motion, caught) = self.motion(engaged, &along.step(k), [from, to]);
            (engaged, from) = (caught, to);
            let (first, second) = motion.cut();
            for part in std::iter::once(first).chain(second) {
                let before = legs.last().filter(|leg| self.joins() && leg.sign == part.sign());
                let start = before.map(|leg| leg.ends[2]);
                legs.push(Leg::new(self, part, start));
            }
            of_step.push(legs.len() - 1);
        }
        (legs, of_step, begun)
    }

    /// Settles the deflection, from `b`.
    fn rub(&self, along: &Periodic<'_>, (legs, of_step): (&[Leg<f64>], &[usize]), b: f64) -> Rubbed {
        let circumstance = along.circumstance(self, 0);
        let mut friction = Vec::with_capacity(legs.len());
        let mut flows: Vec<Flow<f64>> = Vec::with_capacity(legs.len());
        let mut before: Option<(f64, f64)> = None;
        for leg in legs {
            let known = before.filter(|(sign, _)| self.joins() && *sign == leg.sign);
            let along = leg.friction(self, &circumstance, known.map(|(_, mu)| mu));
            before = Some((leg.sign, along[2]));
            friction.push(along[2]);
            flows.push(leg.flow(self, along));
        }
        let mut repeated = Repeated::new(of_step.len());
        let mut period = |start: f64, over: &dyn Fn(usize, f64) -> f64| {
            let from = |k: usize| k.checked_sub(1).map_or(0, |before| of_step[before] + 1);
            repeated.lead(start, |k, b| (from(k)..=of_step[k]).fold(b, |b, leg| over(leg, b)))
        };
        let start = if along.deflection.is_some() {
            period(b, &|leg, b| flows[leg].over(self, b));
            b
        } else if self.is_linear() {
            let map = |flow: &Flow<f64>| {
                let added = flow.over(self, 0.0);
                [added, flow.over(self, 1.0) - added]
            };
            let maps: Vec<[f64; 2]> = flows.iter().map(map).collect();
            let after = |[added, kept]: [f64; 2], [a, k]: &[f64; 2]| [a + k * added, k * kept];
            let [added, kept] = maps.iter().fold([0.0, 1.0], after);
            let start = if 1.0 - kept > FORGETS { added / (1.0 - kept) } else { b };
            period(start, &|leg, b| maps[leg][0] + maps[leg][1] * b)
        } else {
            close(b, |b| period(b, &|leg, b| flows[leg].over(self, b)))
        };
        Rubbed {
            start,
            deflection: repeated.reached,
            friction: of_step.iter().map(|&leg| friction[leg]).collect(),
        }
    }

    /// Replaces a settled force by the one that lags behind it; its value at the start of the period.
    fn settle_lag(&self, along: &Periodic<'_>, force: &mut [f64], lagged: f64) -> f64 {
        let mut late = vec![0.0; force.len()];
        let start = close(lagged, |lagged| {
            (0..force.len()).fold(lagged, |lagged, k| {
                let next = along.next(k);
                late[next] = self.lag(lagged, [force[k], force[next]], along.dt);
                late[next]
            })
        });
        force.copy_from_slice(&late);
        start
    }

    /// A rigid contact: but for its memory it has no state.
    fn settle_rigid(&self, along: &Periodic<'_>, force: &mut [f64]) -> ModifiedState<f64> {
        let circumstance = along.circumstance(self, 0);
        let mut places: Vec<End<f64>> = (0..along.slip.len())
            .map(|k| {
                let velocity = along.velocity[k];
                let place = self.place(along.slip[k], (velocity, self.pressed(along, k)));
                self.followed(place, sense(velocity))
            })
            .collect();
        let mut memory = self.rest_at(0.0).0[1];
        if self.remembers() {
            let mut repeated = Repeated::new(along.slip.len());
            memory = close(memory, |memory| {
                repeated.lead(memory, |k, memory| {
                    let next = along.next(k);
                    places[next].memory = self.remember(memory, &places[k], &places[next], along.dt);
                    places[next].memory
                })
            });
        }
        let mut b = 0.0;
        for (k, place) in places.iter().enumerate() {
            let held = self.hold(place, (along.velocity[k], along.trial[k]), &circumstance);
            if k == 0 {
                b = held.0;
            }
            force[k] = held.1;
        }
        ModifiedState([b, memory, along.slip[0], 0.0])
    }
}

/// A state after each part of a period that is gone through again and again.
struct Repeated {
    reached: Vec<f64>,
}

impl Repeated {
    fn new(parts: usize) -> Self {
        Self { reached: vec![f64::NAN; parts] }
    }

    /// Leads a state through the period, or until it meets what it was there the time before; the state after the last part.
    fn lead(&mut self, mut state: f64, mut over: impl FnMut(usize, f64) -> f64) -> f64 {
        for k in 0..self.reached.len() {
            state = over(k, state);
            let before = std::mem::replace(&mut self.reached[k], state);
            if (state - before).abs() <= MET * (NONE + state.abs()) {
                break;
            }
        }
        self.reached.last().copied().unwrap_or(state)
    }
}

/// The fixed point of a period, from a start.
fn close(mut state: f64, mut period: impl FnMut(f64) -> f64) -> f64 {
    let mut before: Option<[f64; 2]> = None;
    for left in (0..PERIODS).rev() {
        let old = state;
        state = period(old);
        let change = state - old;
        if change.abs() <= SETTLED * (NONE + state.abs()) {
            break;
        }
        // Slow memory closes geometrically, by the share that the last two periods show: the secant's zero of the change, not in the last period.
        let share = before.map(|[start, last]| 1.0 + (change - last) / (old - start));
        if let Some(share) = share.filter(|share| left > 0 && share.is_finite() && share.abs() < 0.999) {
            state += change * share / (1.0 - share);
        }
        before = Some([old, change]);
    }
    state
}
