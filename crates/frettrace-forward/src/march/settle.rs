//! Marching to the steady state.

use frettrace_friction::FrictionLaw;

use super::engine::March;

/// How long and how exactly to settle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SettleOptions {
    /// Period of the excitation (s).
    pub period: f64,
    /// Steps over one period.
    pub steps_per_period: usize,
    /// Periods before giving up.
    pub maximum_periods: usize,
    /// Steps a period, those that are halved included, beyond which the contact chatters and is given up: on the mean from the start, at
    /// which ten periods more are granted. `None`: as many as the most periods have without halvings may be made in all.
    pub most_steps: Option<usize>,
    /// Change of the modal state over the period, relative to its size, that counts as steady.
    pub tolerance: f64,
    /// Largest number of excitation periods after which the motion may repeat.
    pub largest_multiple: usize,
    /// Periods in which whatever decays loses more than half; a march whose change does not fall by half in two such spans is
    /// given up before the most periods. `None`: never.
    pub half_life: Option<usize>,
}

impl SettleOptions {
    /// Defaults for a period (s): 2048 steps, 3000 periods, 1e-9, up to six periods, never given up before.
    #[must_use]
    pub fn new(period: f64) -> Self {
        Self {
            period,
            steps_per_period: 2048,
            maximum_periods: 3000,
            most_steps: None,
            tolerance: 1e-9,
            largest_multiple: 6,
            half_life: None,
        }
    }
}

/// What became of a march.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Settling {
    /// The motion repeats.
    Periodic {
        /// Its period in periods of the excitation: 1 harmonic, more subharmonic.
        multiple: usize,
        /// Relative change over it.
        change: f64,
        /// Excitation periods marched.
        periods: usize,
    },
    /// It does not, within the periods allowed.
    NotPeriodic {
        /// Smallest relative change seen over the last periods.
        change: f64,
        /// Excitation periods marched.
        periods: usize,
        /// Whether so many steps were halved that it was given up: the contact chatters.
        chatters: bool,
    },
}

/// Marches until the motion repeats after one or a few periods; `known` fills the input loads at a time (s).
pub fn settle<L: FrictionLaw<f64>>(
    march: &mut March<'_, L>,
    options: &SettleOptions,
    known: impl Fn(f64, &mut [f64]),
) -> Settling {
    march.set_step(options.period / options.steps_per_period as f64);
    let mut loads = vec![0.0; march.input_count()];
    let mut history: Vec<Vec<f64>> = Vec::new();
    let mut change = f64::INFINITY;
    let mut decline = Decline::default();
    let mut jumped = false;
    let most_steps = |periods: usize| match options.most_steps {
        Some(most) => most * (periods + GRACE),
        None => options.maximum_periods * options.steps_per_period,
    };
    let steps_before = march.step_count();
    for periods in 0..=options.maximum_periods {
        let now = march.energy_coordinates();
        let size = now.iter().map(|v| v * v).sum::<f64>().sqrt();
        let distance = |before: &Vec<f64>| {
            now.iter().zip(before).map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt() / size
        };
        let changes: Vec<f64> = history.iter().rev().map(distance).collect();
        change = changes.iter().copied().fold(f64::INFINITY, f64::min);
        if let Some(multiple) = repeats(&changes, options.tolerance) {
            return Settling::Periodic { multiple, change, periods };
        }
        let ended = options.half_life.is_some_and(|span| decline.has_ended(span, change));
        let chatters = march.step_count() - steps_before > most_steps(periods);
        if ended || chatters {
            return Settling::NotPeriodic { change, periods, chatters };
        }
        if history.len() == options.largest_multiple {
            history.remove(0);
        }
        history.push(now);
        if periods == options.maximum_periods {
            break;
        }
        let [displacement, velocity] = march.modal_state().map(<[f64]>::to_vec);
        let (start, slid) = (march.time(), march.free_step_count());
        for step in 1..=options.steps_per_period {
            let time = start + options.period * step as f64 / options.steps_per_period as f64;
            known(time, &mut loads);
            march.step(&loads);
            march.set_time(time);
        }
        if !jumped && march.free_step_count() == slid {
            let before = [displacement, velocity];
            let change: [Vec<f64>; 2] = std::array::from_fn(|k| {
                march.modal_state()[k].iter().zip(&before[k]).map(|(now, before)| now - before).collect()
            });
            jumped = march.settle_held(change.each_ref().map(Vec::as_slice), options.steps_per_period);
        }
    }
    Settling::NotPeriodic { change, periods: options.maximum_periods, chatters: false }
}

/// Periods that a march from rest may take more steps in than later.
pub(crate) const GRACE: usize = 10;
/// Spans without a fall by half after which a motion does not decay any more.
const IDLE_SPANS: usize = 2;

/// The smallest change of every span.
struct Decline {
    periods: usize,
    least: f64,
    before: f64,
    idle: usize,
}

impl Default for Decline {
    fn default() -> Self {
        Self { periods: 0, least: f64::INFINITY, before: f64::INFINITY, idle: 0 }
    }
}

impl Decline {
    /// Whether the change, that of one more period, has stopped falling.
    fn has_ended(&mut self, span: usize, change: f64) -> bool {
        self.periods += 1;
        self.least = self.least.min(change);
        if self.periods.is_multiple_of(span.max(1)) {
            self.idle = if self.least > 0.5 * self.before { self.idle + 1 } else { 0 };
            self.before = self.least;
            self.least = f64::INFINITY;
        }
        self.idle >= IDLE_SPANS
    }
}

/// A decaying oscillation of half the excitation's frequency repeats after two periods before it repeats after one: a
/// longer period counts only where the shorter ones are clearly not on their way. Under a damping ratio ζ the changes over one
/// period and over two are in the ratio of `1 : 2πζ`, which no structure brings to a thousand.
const CLEARLY_APART: f64 = 1e3;

/// The number of periods after which the motion repeats, from the changes over one, two, … periods.
///
/// A march that halves its steps may repeat after two periods to the last digit and after one to a few digits less, because
/// halvings alternate: that is a motion of one period on the steps that there are.
fn repeats(changes: &[f64], tolerance: f64) -> Option<usize> {
    let near = |c: &f64| *c <= CLEARLY_APART * tolerance;
    let back = changes.iter().position(|&change| change <= tolerance)?;
    if !changes[..back].iter().any(near) {
        return Some(back + 1);
    }
    // What stays as it is over some number of periods, and over fewer does not decay: either is far from the others, or from the
    // tolerance, of which a decay would have missed no more than a thousandth over one period then.
    let stays = |(k, change): (usize, &f64)| {
        let apart = CLEARLY_APART * change;
        apart <= tolerance || (*change <= tolerance && changes[..k].iter().all(|&c| c > apart))
    };
    let shortest = changes.iter().position(near)?;
    changes.iter().enumerate().skip(back).any(stays).then_some(shortest + 1)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A decay by e in ten periods is never given up, what stays is after three spans: one to begin with and two without a fall.
    #[test]
    fn what_does_not_decay_is_given_up() {
        let ends = |change: &dyn Fn(usize) -> f64| {
            let mut decline = Decline::default();
            (1..=400).find(|&period| decline.has_ended(10, change(period)))
        };
        assert_eq!(ends(&|period| (-0.1 * period as f64).exp()), None);
        assert_eq!(ends(&|_| 1e-6), Some(30));
        // Onto a floor of 1e-6: 7.1e-6 at 120, 3.3e-6 at 130, 1.8e-6 at 140; the span that ends at 130 is the last to fall by half.
        let onto = |period: usize| 1e-6 + (-0.1 * period as f64).exp();
        assert_eq!(ends(&onto), Some(150));
    }

    /// Changes over one, two and three periods at a tolerance of 1e-8, each case by hand.
    #[test]
    fn periods_are_told_from_decay_and_from_steps() {
        let repeats = |changes: &[f64]| repeats(changes, 1e-8);
        assert_eq!(repeats(&[1e-9, 1e-9, 1e-9]), Some(1));
        assert_eq!(repeats(&[1e-7, 1e-7, 1e-7]), None);
        // Half the frequency, and half the frequency on its way out at ζ = 0.3 %.
        assert_eq!(repeats(&[0.3, 1e-9, 0.3]), Some(2));
        assert_eq!(repeats(&[2e-7, 4e-9, 2e-7]), None);
        // Halvings that alternate.
        assert_eq!(repeats(&[2e-7, 3e-12, 2e-7]), Some(1));
        assert_eq!(repeats(&[0.3, 2e-7, 0.3, 3e-12]), Some(2));
        assert_eq!(repeats(&[2e-7, 5e-9, 2e-7, 5e-9, 2e-7, 4e-13]), Some(1));
        assert_eq!(repeats(&[2e-7, 2e-7, 3e-10, 2e-7, 2e-7, 4e-13]), Some(1));
    }
}
