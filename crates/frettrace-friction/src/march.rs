//! A law over a periodic slip, repeated until the loop closes.

use std::ops::ControlFlow;

use crate::{Error, FrictionLaw, Scalar, Step, Stretch};

/// One period of the motion of the contact in equally spaced samples; the sample after the last is the first.
#[derive(Clone, Copy, Debug)]
pub struct Period<'a, T> {
    /// Slip \[m\].
    pub slip: &'a [T],
    /// Slip velocity (m/s).
    pub velocity: &'a [T],
    /// Normal force \[N\], compression positive.
    pub normal: &'a [T],
    /// Time between samples \[s\].
    pub dt: f64,
}

/// When a loop counts as closed.
#[derive(Clone, Copy, Debug)]
pub struct Closing {
    /// Largest change of the state over a period, relative to its largest value in it.
    pub tolerance: f64,
    /// Number of periods after which to give up.
    pub periods: usize,
}

impl Default for Closing {
    /// 1e-12 (rounding of the states leaves about 1e-15) within 200 periods; most laws close in two or three.
    fn default() -> Self {
        Self { tolerance: 1e-12, periods: 200 }
    }
}

/// The outcome of [`close_loop`].
#[derive(Clone, Copy, Debug)]
pub struct Closed<S> {
    /// State at the last sample of the period (that is before the first).
    pub state: S,
    /// Periods marched.
    pub periods: usize,
    /// Change of the state over the last period, relative to its largest value.
    pub gap: f64,
    /// Whether the gap is within the tolerance; some laws drift and never close.
    pub closed: bool,
}

impl<T: Scalar> Period<'_, T> {
    /// The step that ends at sample `index`.
    #[inline(always)]
    pub fn step(&self, index: usize) -> Step<T> {
        let before = if index == 0 { self.slip.len() - 1 } else { index - 1 };
        Step {
            slip: [self.slip[before], self.slip[index]],
            velocity: [self.velocity[before], self.velocity[index]],
            normal: [self.normal[before], self.normal[index]],
            dt: self.dt,
        }
    }

    /// # Errors
    /// Where the three columns and the room for the force differ in length or are empty.
    fn check(&self, room: usize) -> Result<(), Error> {
        let lengths = [self.slip.len(), self.velocity.len(), self.normal.len(), room];
        if lengths[0] == 0 || lengths.iter().any(|length| *length != lengths[0]) {
            return Err(Error::Lengths { lengths });
        }
        Ok(())
    }

    /// One period from `state`: fills `force` \[N\], returns the state after it and the largest of each state.
    ///
    /// # Errors
    /// [`Error::Lengths`] where the columns differ in length.
    pub fn march<L: FrictionLaw<T>>(
        &self,
        law: &L,
        state: L::State,
        force: &mut [T],
    ) -> Result<L::State, Error> {
        self.check(force.len())?;
        Ok(self.sweep(law, state, force).0)
    }

    #[inline]
    fn sweep<L: FrictionLaw<T>>(&self, law: &L, state: L::State, force: &mut [T]) -> (L::State, L::State) {
        let mut peak = state;
        let mut note = |after: L::State| {
            for (high, value) in peak.as_mut().iter_mut().zip(after.as_ref()) {
                if value.re().abs() > high.re().abs() {
                    *high = *value;
                }
            }
        };
        let Self { slip, velocity, normal, dt } = *self;
        let ([.., u], [.., v], [.., n]) = (slip, velocity, normal) else {
            return (state, peak);
        };
        let (around, mut slots) = ([[*u, slip[0]], [*v, velocity[0]], [*n, normal[0]]], force.iter_mut());
        // One closure for the step into the period and for those along it: the law's step is there once, inlined.
        let mut record = |_, after, value| {
            if let Some(slot) = slots.next() {
                *slot = value;
            }
            note(after);
            ControlFlow::Continue(())
        };
        let [slip_around, velocity_around, normal_around] = &around;
        let into = Stretch { slip: slip_around, velocity: velocity_around, normal: normal_around, dt };
        let start = law.follow(state, &into, &mut record);
        let end = law.follow(start, &Stretch { slip, velocity, normal, dt }, &mut record);
        (end, peak)
    }
}

/// Repeats the period until the state returns to itself; `force` \[N\] is that of the last period.
///
/// # Errors
/// [`Error::Lengths`] where the columns differ in length.
pub fn close_loop<T: Scalar, L: FrictionLaw<T>>(
    law: &L,
    period: &Period<'_, T>,
    force: &mut [T],
    closing: Closing,
) -> Result<Closed<L::State>, Error> {
    period.check(force.len())?;
    let mut outcome = Closed { state: law.rest(), periods: 0, gap: f64::INFINITY, closed: false };
    while !outcome.closed && outcome.periods < closing.periods {
        let (after, peak) = period.sweep(law, outcome.state, force);
        outcome.gap = gap(outcome.state.as_ref(), after.as_ref(), peak.as_ref());
        outcome.state = after;
        outcome.periods += 1;
        outcome.closed = outcome.gap <= closing.tolerance;
    }
    Ok(outcome)
}

fn gap<T: Scalar>(before: &[T], after: &[T], peak: &[T]) -> f64 {
    let changes = before.iter().zip(after).zip(peak).map(|((old, new), high)| {
        let change = (new.re() - old.re()).abs();
        if change == 0.0 { 0.0 } else { change / high.re().abs() }
    });
    changes.fold(0.0, f64::max)
}
