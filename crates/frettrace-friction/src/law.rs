//! What every law is: one step from sample to sample.

use std::ops::ControlFlow;

use num_dual::DualNum;

use crate::lift::sign;

/// A real number or a dual number of first order (`f64`, `Dual64`, `DualSVec64<K>`).
///
/// The laws carry first derivatives only: with a dual number of higher order the values and first derivatives are
/// right, the higher ones are not.
pub trait Scalar: DualNum<Primitive = f64> + Copy + Send + Sync {}
impl<T: DualNum<Primitive = f64> + Copy + Send + Sync> Scalar for T {}

/// A reversal closer to an end of the step, as a fraction of it, is one at the sample itself: a velocity there that is 0
/// but for rounding must not leave a stroke without duration.
const REVERSAL: f64 = 1e-9;

/// The motion of the contact over one step; index 0 is the old sample, 1 the new one.
///
/// Between the samples the slip is the cubic through both slips and both slip velocities (Hermite), the normal force
/// is a straight line.
#[derive(Clone, Copy, Debug)]
pub struct Step<T> {
    /// Slip `u` \[m\].
    pub slip: [T; 2],
    /// Slip velocity `v` (m/s).
    pub velocity: [T; 2],
    /// Normal force `N` \[N\], compression positive; a law uses `max(N, 0)`.
    pub normal: [T; 2],
    /// Duration \[s\].
    pub dt: f64,
}

/// A stretch of a step in which the slip keeps its direction.
#[derive(Clone, Copy, Debug)]
pub struct Stroke<T> {
    /// Slip over the stretch \[m\], with its sign.
    pub travel: T,
    /// +1 or −1: the sense of the slip.
    pub direction: f64,
    /// Slip velocity (m/s) at the start, the middle and the end in time.
    pub velocity: [T; 3],
    /// Where start, middle and end lie in the step, as fractions of its duration.
    pub fraction: [T; 3],
    /// Duration \[s\].
    pub duration: T,
}

impl<T: Scalar> Step<T> {
    /// Slip \[m\] and slip velocity (m/s) of the Hermite cubic at a fraction of the step's duration.
    pub fn at(&self, fraction: T) -> (T, T) {
        let [v0, v1] = self.velocity;
        let [bend, lean, start] = self.velocity_parabola();
        let slip =
            self.slip[0] + fraction * self.dt * (start + fraction * (lean / 2.0 + fraction * bend / 3.0));
        let velocity = if fraction.re() == 1.0 { v1 } else { v0 + fraction * (lean + fraction * bend) };
        (slip, velocity)
    }

    /// `[a, b, c]` of the slip velocity `a s² + b s + c` at the fraction `s`.
    #[inline(always)]
    fn velocity_parabola(&self) -> [T; 3] {
        let [v0, v1] = self.velocity;
        let mean = (self.slip[1] - self.slip[0]) / self.dt;
        [(v0 + v1 - mean * 2.0) * 3.0, mean * 6.0 - v0 * 4.0 - v1 * 2.0, v0]
    }

    /// The strokes of the step: one, or two where the velocity changes sign (the second is `None` otherwise).
    #[inline(always)]
    pub fn strokes(&self) -> (Stroke<T>, Option<Stroke<T>>) {
        let [v0, v1] = self.velocity;
        if v0.re() * v1.re() < 0.0 { self.strokes_about_reversal() } else { (self.single_stroke(), None) }
    }

    #[inline(always)]
    fn single_stroke(&self) -> Stroke<T> {
        let [v0, v1] = self.velocity;
        let travel = self.slip[1] - self.slip[0];
        let direction = match sign(travel.re()) {
            0.0 if v0.re() + v1.re() < 0.0 => -1.0,
            0.0 => 1.0,
            sense => sense,
        };
        let middle = travel * (1.5 / self.dt) - (v0 + v1) * 0.25;
        Stroke {
            travel,
            direction,
            velocity: [v0, middle, v1],
            fraction: [T::from(0.0), T::from(0.5), T::from(1.0)],
            duration: T::from(self.dt),
        }
    }

    /// The reversal lies at the root of the velocity's parabola in (0, 1), which is unique because its ends differ in
    /// sign; the form with the root in the denominator stays exact when the parabola is a straight line.
    fn strokes_about_reversal(&self) -> (Stroke<T>, Option<Stroke<T>>) {
        let [v0, v1] = self.velocity;
        let sense = sign(v0.re());
        let [bend, lean, start] = self.velocity_parabola();
        let root = (lean * lean - bend * start * 4.0).sqrt();
        let reversal = start * 2.0 / (root * sense - lean);
        if !(reversal.re() > REVERSAL && reversal.re() < 1.0 - REVERSAL) {
            return (self.single_stroke(), None);
        }
        let zero = T::from(0.0);
        let travel = self.at(reversal).0 - self.slip[0];
        let rest = self.slip[1] - self.slip[0] - travel;
        let (before, after) = (reversal * self.dt, (-reversal + 1.0) * self.dt);
        let first = Stroke {
            travel,
            direction: sense,
            velocity: [v0, travel * 1.5 / before - v0 * 0.25, zero],
            fraction: [zero, reversal * 0.5, reversal],
            duration: before,
        };
        let second = Stroke {
            travel: rest,
            direction: -sense,
            velocity: [zero, rest * 1.5 / after - v1 * 0.25, v1],
            fraction: [reversal, (reversal + 1.0) * 0.5, T::from(1.0)],
            duration: after,
        };
        (first, Some(second))
    }
}

/// The motion of the contact in consecutive samples: one step fewer than there are samples.
#[derive(Clone, Copy, Debug)]
pub struct Stretch<'a, T> {
    /// Slip `u` \[m\].
    pub slip: &'a [T],
    /// Slip velocity `v` (m/s).
    pub velocity: &'a [T],
    /// Normal force `N` \[N\], compression positive.
    pub normal: &'a [T],
    /// Time between samples \[s\].
    pub dt: f64,
}

impl<'a, T: Scalar> Stretch<'a, T> {
    /// Number of steps: what the shortest column allows.
    #[must_use]
    pub fn steps(&self) -> usize {
        self.slip.len().min(self.velocity.len()).min(self.normal.len()).saturating_sub(1)
    }

    /// Step `index`, from sample `index` to the next; `index` below [`Self::steps`].
    #[inline(always)]
    #[must_use]
    pub fn step(&self, index: usize) -> Step<T> {
        Step {
            slip: [self.slip[index], self.slip[index + 1]],
            velocity: [self.velocity[index], self.velocity[index + 1]],
            normal: [self.normal[index], self.normal[index + 1]],
            dt: self.dt,
        }
    }

    /// `count` of the steps from step `first` on.
    pub(crate) fn part(&self, first: usize, count: usize) -> Self {
        let samples = first..first + count + 1;
        Self {
            slip: &self.slip[samples.clone()],
            velocity: &self.velocity[samples.clone()],
            normal: &self.normal[samples],
            dt: self.dt,
        }
    }
}

/// A scalar friction law with its parameters over the scalar `T`.
pub trait FrictionLaw<T: Scalar>: Copy {
    /// Internal state (deflections of bristles, film thickness …), a small array.
    type State: Copy + AsRef<[T]> + AsMut<[T]>;

    /// The state of an unloaded contact.
    fn rest(&self) -> Self::State;

    /// From the old sample to the new one: the new state and the friction force `F_t` \[N\] at the new sample
    /// (positive: it resists positive slip).
    fn step(&self, state: Self::State, step: &Step<T>) -> (Self::State, T);

    /// Lowest and highest force \[N\] with which a contact that is at rest at the end of the step stays there; `None` for a law
    /// whose force follows from the step. `state` is that at the old sample, as in [`Self::step`].
    ///
    /// What a structure needs to be held decides the force of a law that is set-valued at rest, as long as it lies between them.
    fn at_rest(&self, _state: Self::State, _step: &Step<T>) -> Option<[T; 2]> {
        None
    }

    /// Step after step along a stretch: the state after it. `record` sees the index of each step, the state after it and
    /// the force \[N\], and breaks off with the state it has seen. Laws whose steps share work do it here once.
    #[inline]
    fn follow(
        &self,
        mut state: Self::State,
        stretch: &Stretch<'_, T>,
        mut record: impl FnMut(usize, Self::State, T) -> ControlFlow<()>,
    ) -> Self::State {
        for index in 0..stretch.steps() {
            let (new, force) = self.step(state, &stretch.step(index));
            state = new;
            if record(index, state, force).is_break() {
                break;
            }
        }
        state
    }
}
