//! LuGre along a stretch of samples: what depends on the motion alone is computed side by side, block by block.
//!
//! With linear saturation a step is affine in the deflection, `z' = a z + b`, and so is the force, `F = c z' + d`; `a … d` depend
//! on slip, velocity and normal force of the step only. They are found for a block of steps in loops without branch, which
//! the compiler makes into vector instructions; one product and one sum a sample are left to be done in order. The
//! formulas are those of [`super::plain`]; steps with a reversal, or whose velocities contradict the path, are left to it.

use std::ops::ControlFlow;

use pulp::{Arch, Simd, WithSimd};

use super::flow::{LONG, MIDDLE, Memory};
use super::{Bristle, Saturation, Steady};
use crate::decay::{decay, power};
use crate::{FrictionLaw, Scalar, Stretch};

/// Steps of a block: its rows stay in the nearest cache.
const BLOCK: usize = 64;

/// Steps that are always computed together: the widest vectors there are. What lies beyond the last step is not used.
const LANES: usize = 8;

type Row = [f64; BLOCK];
type Samples = [f64; BLOCK + 1];

/// Parameters in plain numbers, with what is needed of them.
#[derive(Clone, Copy)]
struct Plain {
    sigma0: f64,
    sigma1: f64,
    sigma2: f64,
    mu_k: f64,
    excess: f64,
    slowness: f64,
    fading: f64,
    delta: f64,
}

/// One block of steps. The motion is copied into it, so that all rows are known not to overlap.
struct Block {
    slip: Samples,
    velocity: Samples,
    normal: Samples,
    /// μ and 1/μ at the samples.
    mu: Samples,
    inverses: Samples,
    /// Slip velocity and μ at half time.
    middle: Row,
    mu_middle: Row,
    /// Length X of the step, and up to half time.
    whole: Row,
    half: Row,
    /// What an exponential memory makes of the powers 1, s, s².
    moments: [Row; 3],
    /// Presliding damping at the end.
    damping: Row,
    /// `z' = keep z + target`; `keep` is no number where the step is not affine.
    keep: Row,
    target: Row,
    /// `F = slope z' + offset`.
    slope: Row,
    offset: Row,
}

/// As [`FrictionLaw::follow`].
#[inline]
pub(super) fn follow<T: Scalar>(
    law: &Bristle<T>,
    state: [T; 1],
    stretch: &Stretch<'_, T>,
    mut record: impl FnMut(usize, [T; 1], T) -> ControlFlow<()>,
) -> [T; 1] {
    let mut state = state;
    let steps = stretch.steps();
    let Some(plain) = Plain::of(law) else {
        for index in 0..steps {
            let (new, force) = law.step(state, &stretch.step(index));
            state = new;
            if record(index, state, force).is_break() {
                break;
            }
        }
        return state;
    };
    let (arch, mut block) = (Arch::new(), Block::new());
    for first in (0..steps).step_by(BLOCK) {
        let part = stretch.part(first, BLOCK.min(steps - first));
        block.read(&part);
        arch.dispatch(Fill { block: &mut block, law: plain, steps: part.steps(), dt: part.dt });
        let motion = block.keep.iter().zip(&block.target);
        let answer = block.slope.iter().zip(&block.offset);
        for (index, ((keep, target), (slope, offset))) in motion.zip(answer).take(part.steps()).enumerate() {
            let z = state[0].re() * keep + target;
            let mut force = T::from(slope * z + offset);
            if z.is_nan() {
                (state, force) = law.step(state, &part.step(index));
            } else {
                state = [T::from(z)];
            }
            if record(first + index, state, force).is_break() {
                return state;
            }
        }
    }
    state
}

impl Plain {
    /// `None` for what is not affine, or needs derivatives.
    fn of<T: Scalar>(law: &Bristle<T>) -> Option<Self> {
        let affine = law.saturation == Saturation::Linear && law.steady == Steady::Stribeck;
        let [mu_s, mu_k] = [law.mu_s.re(), law.mu_k.re()];
        (T::NDERIV == 0 && affine && mu_s > 0.0 && mu_k > 0.0).then(|| Self {
            sigma0: law.sigma0.re(),
            sigma1: law.sigma1.re(),
            sigma2: law.sigma2.re(),
            mu_k,
            excess: mu_s - mu_k,
            slowness: law.v_s.re().recip(),
            fading: law.v_d.re().recip(),
            delta: law.delta.re(),
        })
    }
}

/// [`Block::fill`], inlined into the code of each instruction set, of which the processor's own is taken: the same operations
/// in the same order, hence the same numbers, in wider vectors.
struct Fill<'a> {
    block: &'a mut Block,
    law: Plain,
    steps: usize,
    dt: f64,
}

impl WithSimd for Fill<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let lanes = self.steps.next_multiple_of(LANES).min(BLOCK);
        self.block.fill(self.law, lanes, self.dt);
    }
}

impl Block {
    fn new() -> Self {
        let (samples, row) = ([0.0; BLOCK + 1], [0.0; BLOCK]);
        Self {
            slip: samples,
            velocity: samples,
            normal: samples,
            mu: samples,
            inverses: samples,
            middle: row,
            mu_middle: row,
            whole: row,
            half: row,
            moments: [row; 3],
            damping: row,
            keep: row,
            target: row,
            slope: row,
            offset: row,
        }
    }

    fn read<T: Scalar>(&mut self, part: &Stretch<'_, T>) {
        let rows = [
            (&mut self.slip, part.slip),
            (&mut self.velocity, part.velocity),
            (&mut self.normal, part.normal),
        ];
        for (row, samples) in rows {
            row.iter_mut().zip(samples).for_each(|(to, from)| *to = from.re());
        }
    }

    #[inline(always)]
    fn fill(&mut self, law: Plain, lanes: usize, dt: f64) {
        if law.delta == 2.0 {
            self.steady(law, lanes, dt, |ratio| ratio * ratio);
        } else if law.delta == 1.0 {
            self.steady(law, lanes, dt, |ratio| ratio);
        } else {
            self.steady(law, lanes, dt, |ratio| power(ratio, law.delta));
        }
        let long = self.lengths(law, lanes, dt);
        self.remember(lanes, long);
        self.damp(law, lanes);
        self.close(law, lanes);
    }

    /// μ at the samples and at half time.
    #[inline(always)]
    fn steady(&mut self, law: Plain, lanes: usize, dt: f64, power: impl Fn(f64) -> f64) {
        let at = |v: f64| law.mu_k + law.excess * decay(power(v.abs() * law.slowness));
        let (slip, velocity) = (&self.slip[..=lanes], &self.velocity[..=lanes]);
        let (mu, inverses) = (&mut self.mu[..=lanes], &mut self.inverses[..=lanes]);
        for ((mu, inverse), v) in mu.iter_mut().zip(inverses).zip(velocity) {
            *mu = at(*v);
            *inverse = mu.recip();
        }
        let factor = 1.5 / dt;
        let (middle, mu) = (&mut self.middle[..lanes], &mut self.mu_middle[..lanes]);
        for k in 0..lanes {
            middle[k] = (slip[k + 1] - slip[k]) * factor - (velocity[k] + velocity[k + 1]) * 0.25;
            mu[k] = at(middle[k]);
        }
    }

    /// Length of each step, and up to half time; whether one is long.
    #[inline(always)]
    fn lengths(&mut self, law: Plain, lanes: usize, dt: f64) -> bool {
        let (slip, velocity) = (&self.slip[..=lanes], &self.velocity[..=lanes]);
        let inverses = &self.inverses[..=lanes];
        let (speed, mu) = (&self.middle[..lanes], &self.mu_middle[..lanes]);
        let (whole, half) = (&mut self.whole[..lanes], &mut self.half[..lanes]);
        // A whole number: the largest of many would have to be found one after the other.
        let mut long = 0_u64;
        for k in 0..lanes {
            let (travel, [v0, v2]) = (slip[k + 1] - slip[k], [velocity[k], velocity[k + 1]]);
            let pace = law.sigma0.copysign(sense(travel, v0, v2)) * dt;
            let start = v0 * pace * inverses[k];
            let middle = speed[k] * pace * mu[k].recip();
            let end = v2 * pace * inverses[k + 1];
            whole[k] = (start + middle * 4.0 + end) * (1.0 / 6.0);
            half[k] = (start * 5.0 + middle * 8.0 - end) * (1.0 / 24.0);
            long |= u64::from(whole[k] > LONG);
        }
        long > 0
    }

    /// Both ways side by side where a step is long: a branch would keep the loop from vectors.
    #[inline(always)]
    fn remember(&mut self, lanes: usize, long: bool) {
        let [zeroth, first, second] = &mut self.moments;
        let rows = zeroth.iter_mut().zip(first).zip(second).zip(&self.whole).take(lanes);
        if long {
            for (((m0, m1), m2), &x) in rows {
                let (near, far) = (Memory::short(x).moments, Memory::long(x).moments);
                let pick = |index: usize| if x > LONG { far[index] } else { near[index] };
                (*m0, *m1, *m2) = (pick(0), pick(1), pick(2));
            }
        } else {
            for (((m0, m1), m2), &x) in rows {
                [*m0, *m1, *m2] = Memory::short(x).moments;
            }
        }
    }

    /// Presliding damping at the ends of the steps.
    #[inline(always)]
    fn damp(&mut self, law: Plain, lanes: usize) {
        if law.sigma1 == 0.0 || law.fading == 0.0 {
            self.damping.fill(law.sigma1);
            return;
        }
        for (damping, v) in self.damping[..lanes].iter_mut().zip(&self.velocity[1..=lanes]) {
            let ratio = v * law.fading;
            *damping = law.sigma1 * decay(ratio * ratio);
        }
    }

    /// The affine maps of deflection and force.
    #[inline(always)]
    fn close(&mut self, law: Plain, lanes: usize) {
        let (slip, velocity) = (&self.slip[..=lanes], &self.velocity[..=lanes]);
        let (normal, compliance) = (&self.normal[..=lanes], law.sigma0.recip());
        let (mu, inverses) = (&self.mu[..=lanes], &self.inverses[..=lanes]);
        let (mu_middle, damping) = (&self.mu_middle[..lanes], &self.damping[..lanes]);
        let (whole, half) = (&self.whole[..lanes], &self.half[..lanes]);
        let [zeroth, first, second] = &self.moments;
        let (zeroth, first, second) = (&zeroth[..lanes], &first[..lanes], &second[..lanes]);
        let (keep, target) = (&mut self.keep[..lanes], &mut self.target[..lanes]);
        let (slope, offset) = (&mut self.slope[..lanes], &mut self.offset[..lanes]);
        for k in 0..lanes {
            let (travel, [v0, v2]) = (slip[k + 1] - slip[k], [velocity[k], velocity[k + 1]]);
            let (whole, half) = (whole[k], half[k]);
            let (lean, rise) = (mu[k + 1] - mu[k], mu_middle[k] - mu[k]);
            // The parabola's bend, `(rise − κ lean)/(κ (κ − 1))` with κ = half/whole, in one division.
            let bend = (rise * whole - lean * half) * whole / (half * (half - whole));
            let loading = mu[k] * zeroth[k] + lean * first[k] + bend * (second[k] - first[k]);
            let inside = (half >= MIDDLE.0 * whole) & (half <= MIDDLE.1 * whole);
            let affine = (whole > 0.0) & inside & (v0 * v2 >= 0.0);
            keep[k] = if affine { 1.0 - zeroth[k] } else { f64::NAN };
            target[k] = loading * compliance.copysign(sense(travel, v0, v2));
            let pressed = if normal[k + 1] > 0.0 { normal[k + 1] } else { 0.0 };
            let relaxing = 1.0 - damping[k] * v2.abs() * inverses[k + 1];
            slope[k] = pressed * (law.sigma0 * relaxing);
            offset[k] = pressed * damping[k] * v2 + law.sigma2 * v2;
        }
    }
}

/// What has the sign of the slip.
#[inline(always)]
fn sense(travel: f64, v0: f64, v2: f64) -> f64 {
    if travel == 0.0 { v0 + v2 } else { travel }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 300 samples (four blocks and a part) of a slip of two lines, held for a while, with lift-off.
    fn motion() -> [Vec<f64>; 3] {
        let held = |k: usize| if (180..210).contains(&k) { 180 } else { k };
        let slip = |k: usize| {
            let t = 0.05 * held(k) as f64;
            1e-5 * (t.sin() + 0.3 * (3.0 * t).cos())
        };
        let velocity = |k: usize| {
            let t = 0.05 * held(k) as f64;
            if held(k) == k { 1e-3 * (t.cos() - 0.9 * (3.0 * t).sin()) } else { 0.0 }
        };
        let normal = |k: usize| 2.0 + 3.0 * (0.11 * k as f64).sin();
        [(0..300).map(slip).collect(), (0..300).map(velocity).collect(), (0..300).map(normal).collect()]
    }

    fn law(sigma0: f64, damping: [f64; 2], delta: f64) -> Bristle<f64> {
        let [sigma1, v_d] = damping;
        let (saturation, steady) = (Saturation::Linear, Steady::Stribeck);
        let plain = Bristle::plain(sigma0, 0.4);
        Bristle { sigma1, v_d, sigma2: 0.3, mu_s: 0.7, v_s: 4e-4, delta, saturation, steady, ..plain }
    }

    /// The same numbers as single steps, but for rounding: some hundred steps of few operations, the general exponent's power
    /// to some units in the last place. Short and long steps (σ0 |Δu|/μ from 0.02 to 200), reversals, rest and lift-off.
    #[test]
    fn a_stretch_is_its_steps() {
        let [slip, velocity, normal] = motion();
        let stretch = Stretch { slip: &slip, velocity: &velocity, normal: &normal, dt: 5e-4 };
        for sigma0 in [1e4, 3e5, 1e8] {
            for damping in [[0.0, 1e-3], [20.0, 8e-4], [20.0, f64::INFINITY]] {
                for delta in [0.6, 1.0, 1.7, 2.0] {
                    let law = law(sigma0, damping, delta);
                    let (mut state, mut count) = ([0.0], 0);
                    law.follow([0.0], &stretch, |index, after, force| {
                        let expected;
                        (state, expected) = law.step(state, &stretch.step(index));
                        let error = (after[0] - state[0]).abs() * sigma0;
                        assert!(error < 1e-13, "{sigma0} {delta} {index}: z is {error:e} off");
                        let error = (force - expected).abs();
                        assert!(error < 1e-12, "{sigma0} {delta} {index}: the force is {error:e} N off");
                        count += 1;
                        ControlFlow::Continue(())
                    });
                    assert_eq!(count, 299);
                }
            }
        }
    }

    /// The processor's widest vectors and those that every processor has give the same bits: no product is fused with a sum.
    #[test]
    fn every_instruction_set_gives_the_same_numbers() {
        let [slip, velocity, normal] = motion();
        let stretch = Stretch { slip: &slip, velocity: &velocity, normal: &normal, dt: 5e-4 };
        for (sigma0, delta) in [(1e4, 1.0), (3e5, 1.7), (1e8, 2.0)] {
            let plain = Plain::of(&law(sigma0, [20.0, 8e-4], delta)).unwrap();
            let [mut here, mut there] = [Block::new(), Block::new()];
            for (first, steps) in [(0, BLOCK), (170, BLOCK), (256, 43)] {
                let part = stretch.part(first, steps);
                let dt = part.dt;
                here.read(&part);
                there.read(&part);
                here.fill(plain, steps.next_multiple_of(LANES), dt);
                Arch::new().dispatch(Fill { block: &mut there, law: plain, steps, dt });
                let rows = |block: &Block| [block.keep, block.target, block.slope, block.offset];
                for (one, other) in rows(&here).iter().zip(&rows(&there)) {
                    let same = |(a, b): (&f64, &f64)| a.to_bits() == b.to_bits() || a.is_nan() && b.is_nan();
                    assert!(one.iter().zip(other).take(steps).all(same));
                }
            }
        }
    }

    #[test]
    fn a_stretch_breaks_off_where_it_is_told() {
        let [slip, velocity, normal] = motion();
        let stretch = Stretch { slip: &slip, velocity: &velocity, normal: &normal, dt: 5e-4 };
        let law = law(1e5, [20.0, 1e-3], 2.0);
        let mut last = (0, [0.0]);
        let end = law.follow([0.0], &stretch, |index, after, _| {
            last = (index, after);
            if index == 70 { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        });
        assert_eq!(last, (70, end));
        let nothing = Stretch { slip: &[], velocity: &[], normal: &[], dt: 1.0 };
        assert_eq!(law.follow([3e-7], &nothing, |_, _, _| ControlFlow::Continue(())), [3e-7]);
    }
}
