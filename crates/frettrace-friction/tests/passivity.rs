//! LuGre's bounds of passivity: with the storage function `V = N σ0 z²/2` of the bristle, `V̇ ≤ F v` along every motion.
//!
//! With `r = σ0 z sgn(v)/μ(v)` the excess is `F v − V̇ = |v| (N μ r² + (N σ1(v)(1 − r) + σ2)|v|)` (K. J. Åström, C. Canudas de
//! Wit, IEEE Control Systems 28(6) (2008) 101). In the invariant set `r ≤ μ_s/μ(v)`. Constant σ1: it stays positive at every speed if
//! `σ2 > σ1 N (μ_s − μ_k)/μ_k`; below that a bristle bent at rest and then moved fast takes it below 0. Without σ2 it is a
//! square in `r` that has no root if `σ1(v)|v| < 4 μ_k`; `|v| exp(−(v/v_d)²)` is at most `v_d/√(2e)`.

use frettrace_friction::laws::Lugre;
use frettrace_friction::{FrictionLaw, Step};

const NORMAL: f64 = 20.0;

/// Numbers in [0, 1): the linear congruence of D. E. Knuth's MMIX.
struct Numbers(u64);

impl Numbers {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// A velocity (m/s): its size over seven decades, either sense.
    fn velocity(&mut self) -> f64 {
        let size = 10.0_f64.powf(-6.0 + 7.0 * self.next());
        if self.next() < 0.3 { -size } else { size }
    }
}

/// Least excess `F v − V̇` \[W\] at the samples, and least `∫ F v dt − ΔV` \[J\] from rest to a sample, along random motions:
/// phases of one acceleration each, some of one speed, in steps of a fiftieth of the bristle's length.
fn least_excess(law: Lugre<f64>) -> (f64, f64) {
    let (bristle, mut numbers) = (law.bristle(), Numbers(1));
    let [length, mut velocity] = [law.mu_k / law.sigma0, 1e-6];
    let (mut state, mut before, mut least, mut supplied) = (law.rest(), 0.0, (f64::INFINITY, 0.0_f64), 0.0);
    for _ in 0..3000 {
        let target = numbers.velocity();
        let [rise, rest] = [10.0_f64.powf(2.5 * numbers.next()) as usize, (300.0 * numbers.next()) as usize];
        let start = velocity;
        for k in 1..=rise + rest {
            let next = start + (target - start) * (k as f64 / rise as f64).min(1.0);
            let dt = 0.02 * length / f64::abs(velocity).max(next.abs());
            let step = Step {
                slip: [0.0, 0.5 * (velocity + next) * dt],
                velocity: [velocity, next],
                normal: [NORMAL; 2],
                dt,
            };
            let force;
            (state, force) = law.step(state, &step);
            let z = state[0];
            let rate = bristle.rate(z, next, bristle.steady(next));
            let excess = force * next - NORMAL * law.sigma0 * z * rate;
            supplied += 0.5 * (before + force * next) * dt;
            let stored = 0.5 * NORMAL * law.sigma0 * z * z;
            least = (least.0.min(excess), least.1.min(supplied - stored));
            (before, velocity) = (force * next, next);
        }
    }
    least
}

/// μ_s is above twice μ_k, so that the bristle can be bent to `r = 2`, where the bound of v_d is reached.
fn law() -> Lugre<f64> {
    Lugre {
        sigma0: 1e5,
        sigma1: 300.0,
        v_d: f64::INFINITY,
        sigma2: 0.0,
        mu_s: 1.0,
        mu_k: 0.4,
        v_s: 1e-3,
        delta: 2.0,
    }
}

/// The excess of an ordinary step, N μ |v| of some 1e-3 m/s, is 1e-2 W.
const ROUNDING: f64 = 1e-12;

#[test]
fn viscous_damping_keeps_constant_presliding_damping_passive() {
    let law = law();
    let bound = law.sigma1 * NORMAL * (law.mu_s - law.mu_k) / law.mu_k;
    let (excess, energy) = least_excess(Lugre { sigma2: bound, ..law });
    assert!(excess > -ROUNDING && energy > -1e-9, "{excess:e} W, {energy:e} J");
    let (excess, _) = least_excess(Lugre { sigma2: 0.9 * bound, ..law });
    // A tenth of σ2 v² at 10 m/s is 90 kW; what is met at random falls short of it.
    assert!(excess < -1e3, "{excess:e} W");
}

#[test]
fn presliding_damping_that_fades_is_passive_by_itself() {
    let law = law();
    let bound = 4.0 * (2.0 * std::f64::consts::E).sqrt() * law.mu_k / law.sigma1;
    let (excess, energy) = least_excess(Lugre { v_d: bound, ..law });
    assert!(excess > -ROUNDING && energy > -1e-9, "{excess:e} W, {energy:e} J");
    let (excess, _) = least_excess(Lugre { v_d: 1.1 * bound, ..law });
    assert!(excess < -1e-3, "{excess:e} W");
}
