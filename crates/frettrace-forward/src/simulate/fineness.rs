//! The march of one run, its steps made as short as the accelerations need.

use std::f64::consts::TAU;

use frettrace_friction::FrictionLaw;

use super::record::{Job, SENSORS};
use super::rig::Steps;
use crate::march::{GRACE, March, SettleOptions, Settling, settle};

/// How finely a run was marched.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Marching {
    /// Steps a second (Hz), in the mean over the record, with those that were taken back.
    pub rate: f64,
    /// Change of the accelerations by the last tightening (m/s², root mean square of the worst sensor); `None` where the
    /// rate was given, infinite where the contact chatters and no tightening could be paid. About a fifth of it is left.
    pub change: Option<f64>,
    /// Change that was wanted (m/s²).
    pub tolerance: f64,
    /// Modes marched, besides those of the residual: fewer than the rig has where more make the contact chatter.
    pub modes: usize,
}

impl Marching {
    /// Whether the tolerance was met; where the rate was given nothing was asked.
    #[must_use]
    pub fn is_met(&self) -> bool {
        self.change.is_none_or(|change| change <= self.tolerance)
    }
}

/// Settling is first brought to this change a period on a coarse time base, …
const COARSE_TOLERANCE: f64 = 1e-5;
/// … of this many fine samples a step, …
const COARSENING: usize = 2;
/// … then to this one on the fine one, …
const FINE_TOLERANCE: f64 = 1e-8;
/// … or to this part of the share that makes a step be halved: where a contact sticks and slides, halvings that fall
/// differently from period to period change the motion by about a hundredth of that share.
const HALVING_TOLERANCE: f64 = 0.05;
/// Time constants of the slowest mode after which a run that still changes is recorded as it is.
const PATIENCE: f64 = 25.0;
/// Time constants in which its motion has lost more than half (seven times that, alone).
const HALF_LIFE: f64 = 2.0;
/// Accelerations that change by less than this share of the smallest sensor's signal are as good as the same where no
/// tolerance is given.
const RELATIVE: f64 = 1e-4;
/// Share of a load's impulse that makes a step be halved while the motion settles, …
const COARSE_SHARE: f64 = 4e-4;
/// … in the first record, …
const FIRST_SHARE: f64 = 1e-4;
/// … how much less in each further one, …
const TIGHTENING: f64 = 0.1;
/// … in the last one, …
const LAST_SHARE: f64 = 1e-7;
/// … and where the rate is given.
const GIVEN_SHARE: f64 = 1e-6;
/// A tightening that leaves more than this share of the change before does not lead to the tolerance: the run is chaotic,
/// or has more than one answer.
const HOPELESS: f64 = 0.8;
/// So does one of which not this share of the signal is as it was: two ways of a chaotic run, which shorter steps, ever
/// dearer where it chatters, part all the same.
const ANOTHER: f64 = 0.1;
/// A contact chatters where it takes more than this many steps for each whole one at the first record's share, and at smaller ones in
/// proportion to the third root, as loads that only bend do, …
const CHATTER: f64 = 3.0;
/// … beside so many a period: a dozen changes from stick to slip, each found by two dozen halvings, …
const CHANGES: f64 = 300.0;
/// Share of a load's impulse in the record of a contact that chatters whatever the modes.
const CHATTER_SHARE: f64 = 1e-2;

/// All channels on the fine time base.
pub(super) struct Fine {
    /// Displacements of the sensors against the base.
    pub(super) displacement: Vec<Vec<f64>>,
    /// Acceleration of the base.
    pub(super) base: Vec<f64>,
    /// Force, friction force, normal force, slip, slip velocity.
    pub(super) contact: [Vec<f64>; 5],
    pub(super) second: Option<Vec<f64>>,
}

impl Fine {
    fn new(sensors: usize, count: usize, second: bool) -> Self {
        let channel = || Vec::with_capacity(count);
        Self {
            displacement: (0..sensors).map(|_| channel()).collect(),
            base: channel(),
            contact: std::array::from_fn(|_| channel()),
            second: second.then(channel),
        }
    }
}

/// What a march notes.
struct Recorded {
    fine: Fine,
    /// Steps a second (Hz).
    rate: f64,
    /// Whether it is all there.
    whole: bool,
}

/// A marched run.
pub(super) struct Marched {
    pub(super) fine: Fine,
    pub(super) settling: Settling,
    pub(super) marching: Marching,
}

/// The time base of a march.
#[derive(Clone, Copy)]
struct Base {
    /// Phase of the excitation (rad).
    phase: f64,
    /// Steps in a fine sample.
    steps: usize,
    /// Share of a load's impulse that makes a step be halved.
    share: f64,
}

impl Job<'_> {
    /// Settles and records, with steps as short as they have to be; `None` where the contact chatters.
    pub(super) fn march<L: FrictionLaw<f64>>(
        &self,
        mut march: March<'_, L>,
        (phase, modes): (f64, usize),
    ) -> Option<Marched> {
        let options = self.settle_options(&march, COARSE_SHARE);
        let settling = self.approach(&mut march, (phase, COARSE_SHARE), options);
        match self.rig.sampling.steps {
            Steps::Given(steps) => {
                let base = Base { phase, steps, share: GIVEN_SHARE };
                let settling = self.settle_on(&mut march, &base, settling);
                let Recorded { fine, rate, .. } = self.record(march, &base, usize::MAX);
                let marching = Marching { rate, change: None, tolerance: f64::INFINITY, modes };
                Some(Marched { fine, settling, marching })
            }
            Steps::Within(tolerance) => self.tighten(march, (phase, tolerance, modes), settling),
        }
    }

    /// Marches a contact that chatters whatever is tried: one of the motions it may have.
    pub(super) fn chattering<L: FrictionLaw<f64>>(
        &self,
        mut march: March<'_, L>,
        (phase, modes): (f64, usize),
    ) -> Marched {
        let options = SettleOptions { most_steps: None, ..self.settle_options(&march, CHATTER_SHARE) };
        let settling = self.approach(&mut march, (phase, CHATTER_SHARE), options);
        let base = Base { phase, steps: 1, share: CHATTER_SHARE };
        let Recorded { fine, rate, .. } = self.record(march, &base, usize::MAX);
        let tolerance = match self.rig.sampling.steps {
            Steps::Within(tolerance) => tolerance,
            Steps::Given(_) => f64::INFINITY,
        };
        Marched { fine, settling, marching: Marching { rate, change: Some(f64::INFINITY), tolerance, modes } }
    }

    /// Records with ever shorter steps until the accelerations stay the same; `None` where the contact chatters.
    fn tighten<L: FrictionLaw<f64>>(
        &self,
        mut march: March<'_, L>,
        (phase, wanted, modes): (f64, f64, usize),
        mut settling: Settling,
    ) -> Option<Marched> {
        let mut base = Base { phase, steps: 1, share: FIRST_SHARE };
        let mut before: Option<Vec<Vec<f64>>> = None;
        let mut last = f64::INFINITY;
        loop {
            settling = self.settle_on(&mut march, &base, settling);
            if matches!(settling, Settling::NotPeriodic { chatters: true, .. }) {
                return None;
            }
            let Recorded { fine, rate, whole } =
                self.record(march.clone(), &base, self.most_steps(base.share));
            if !whole {
                return None;
            }
            let signals = self.perfect(&fine);
            if let Some(before) = &before {
                let change = signals.iter().zip(before).map(|(a, b)| distance(a, b)).fold(0.0, f64::max);
                let tolerance = if wanted > 0.0 { wanted } else { RELATIVE * smallest(&signals) };
                let hopeless = change > HOPELESS * last
                    || change > ANOTHER * smallest(&signals)
                    || base.share * TIGHTENING < LAST_SHARE;
                if change <= tolerance || hopeless {
                    let marching = Marching { rate, change: Some(change), tolerance, modes };
                    return Some(Marched { fine, settling, marching });
                }
                last = change;
            }
            before = Some(signals);
            base.share *= TIGHTENING;
        }
    }

    /// Steps of a period beyond which a contact chatters.
    fn most_steps(&self, share: f64) -> usize {
        let whole = TAU / self.run.omega * self.fine_rate();
        (CHATTER * (FIRST_SHARE / share).cbrt() * whole + CHANGES) as usize
    }

    fn settle_options<L: FrictionLaw<f64>>(&self, march: &March<'_, L>, share: f64) -> SettleOptions {
        let period = TAU / self.run.omega;
        let damping = self.rig.damping_ratio.iter().copied().fold(f64::INFINITY, f64::min).clamp(1e-4, 1.0);
        let time_constant = 1.0 / (damping * march.slowest_frequency() * period);
        let patience = (PATIENCE * time_constant).ceil().max(50.0) as usize;
        let half_life = (HALF_LIFE * time_constant).ceil().max(10.0) as usize;
        SettleOptions {
            maximum_periods: patience,
            half_life: Some(half_life),
            most_steps: Some(self.most_steps(share)),
            ..SettleOptions::new(period)
        }
    }

    /// From rest to nearly steady, in long steps that are halved where an impulse errs by this share.
    fn approach<L: FrictionLaw<f64>>(
        &self,
        march: &mut March<'_, L>,
        (phase, share): (f64, f64),
        options: SettleOptions,
    ) -> Settling {
        let fine = (options.period * self.fine_rate()) as usize;
        march.set_refinement(share);
        let options = SettleOptions {
            steps_per_period: (fine / COARSENING).max(64),
            tolerance: COARSE_TOLERANCE,
            ..options
        };
        let known = self.held(phase, options.period / options.steps_per_period as f64);
        settle(march, &options, known)
    }

    /// Input loads whose straight lines between the steps of `dt` (s) have the loads themselves as their fundamentals: a line
    /// loses `(sin x/x)²` of a sinusoid, `x = ωΔt/2`.
    fn held(&self, phase: f64, dt: f64) -> impl Fn(f64, &mut [f64]) {
        let factor = |ratio: f64| {
            let x = 0.5 * ratio * self.run.omega * dt;
            (x / x.sin()).powi(2)
        };
        let factors: Vec<f64> = self.frequency_ratios().into_iter().map(factor).collect();
        move |time, loads| {
            self.known(phase, time, loads);
            for (load, factor) in loads.iter_mut().zip(&factors) {
                *load *= factor;
            }
        }
    }

    /// Settles on in steps of the record; what is not periodic goes on from where it is.
    fn settle_on<L: FrictionLaw<f64>>(
        &self,
        march: &mut March<'_, L>,
        base: &Base,
        before: Settling,
    ) -> Settling {
        if matches!(before, Settling::NotPeriodic { .. }) {
            return before;
        }
        let options = self.settle_options(march, base.share);
        let fine = (options.period * self.fine_rate()).round().max(64.0) as usize;
        march.set_refinement(base.share);
        let tolerance = FINE_TOLERANCE.max(HALVING_TOLERANCE * base.share);
        let options = SettleOptions { steps_per_period: base.steps * fine, tolerance, ..options };
        let known = self.held(base.phase, options.period / options.steps_per_period as f64);
        let settled = settle(march, &options, &known);
        if let Settling::Periodic { multiple, periods, .. } = settled {
            // A subharmonic motion is met in the same one of its periods, whatever the steps: records are compared.
            let rest = periods.next_multiple_of(multiple) - periods;
            settle(march, &SettleOptions { maximum_periods: rest, tolerance: NEVER, ..options }, known);
        }
        settled
    }

    /// The fine channels; broken off where a period takes more than `most` steps.
    fn record<L: FrictionLaw<f64>>(&self, mut march: March<'_, L>, base: &Base, most: usize) -> Recorded {
        let count = self.rig.sampling.samples * self.rig.sampling.oversampling + 2 * self.margin();
        let mut fine = Fine::new(self.rig.sensors.len(), count, self.rig.second_support.is_some());
        let dt = 1.0 / (base.steps as f64 * self.fine_rate());
        march.set_refinement(base.share);
        march.set_step(dt);
        let (start, before) = (march.time(), march.step_count());
        let held = self.held(base.phase, dt);
        let mut loads = vec![0.0; march.input_count()];
        let mut whole = true;
        for k in 1..=count * base.steps {
            let time = start + k as f64 * dt;
            held(time, &mut loads);
            march.step(&loads);
            march.set_time(time);
            if k % base.steps == 0 {
                self.note(&march, base, &mut fine);
            }
            let periods = (time - start) * self.run.omega / TAU + GRACE as f64;
            if (march.step_count() - before) as f64 > most as f64 * periods {
                whole = false;
                break;
            }
        }
        let rate = (march.step_count() - before) as f64 / (count as f64 * self.fine_rate().recip());
        Recorded { fine, rate, whole }
    }

    /// Notes all channels as they are.
    fn note<L: FrictionLaw<f64>>(&self, march: &March<'_, L>, base: &Base, fine: &mut Fine) {
        let mut loads = vec![0.0; march.input_count()];
        fine.base.push(self.known(base.phase, march.time(), &mut loads));
        let moment = march.moment();
        let contact = [loads[0], moment.friction, moment.normal, moment.slip, moment.velocity];
        for (channel, value) in fine.contact.iter_mut().zip(contact) {
            channel.push(value);
        }
        for (index, channel) in fine.displacement.iter_mut().enumerate() {
            channel.push(march.displacement(SENSORS + index));
        }
        if let (Some(channel), Some(index)) = (&mut fine.second, self.second_support()) {
            channel.extend(march.local_loads().nth(index));
        }
    }
}

/// A change that is never met.
const NEVER: f64 = -1.0;

/// Root mean square of a difference.
fn distance(a: &[f64], b: &[f64]) -> f64 {
    root_mean_square(a.iter().zip(b).map(|(a, b)| a - b), a.len())
}

/// Root mean square of the smallest signal; a sensor that sees a millionth of what another does sees nothing.
fn smallest(signals: &[Vec<f64>]) -> f64 {
    let sizes: Vec<f64> =
        signals.iter().map(|signal| root_mean_square(signal.iter().copied(), signal.len())).collect();
    let largest = sizes.iter().copied().fold(0.0, f64::max);
    sizes.into_iter().filter(|size| *size > 1e-6 * largest).fold(largest, f64::min)
}

fn root_mean_square(values: impl Iterator<Item = f64>, count: usize) -> f64 {
    (values.map(|x| x * x).sum::<f64>() / count as f64).sqrt()
}
