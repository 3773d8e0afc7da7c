//! What every law must satisfy. The tests walk the catalogue, so a new law is tested the day it is listed.

use std::f64::consts::TAU;

use num_dual::DualSVec64;

use crate::{Closing, FrictionLaw, FrictionModel, Law, Period, Scalar, Step, Visitor, close_loop};

mod listing;
mod normal_force;

const NORMAL: f64 = 100.0;
/// Period of the test motion (s), long enough for the Stribeck curve of the example values to be passed.
const PERIOD: f64 = 0.05;

/// Slip and slip velocity at a fraction of the period: two harmonics, three amplitudes of the example laws' z_ss.
fn motion(fraction: f64) -> (f64, f64) {
    let (phase, omega) = (TAU * fraction, TAU / PERIOD);
    let slip = 3e-6 * (phase.sin() + 0.45 * (3.0 * phase + 0.7).cos());
    let velocity = 3e-6 * omega * (phase.cos() - 1.35 * (3.0 * phase + 0.7).sin());
    (slip, velocity)
}

/// One period in samples: slip, velocity, normal force.
struct Samples {
    slip: Vec<f64>,
    velocity: Vec<f64>,
    normal: Vec<f64>,
    dt: f64,
}

impl Samples {
    fn new(count: usize) -> Self {
        let points: Vec<(f64, f64)> = (0..count).map(|k| motion(k as f64 / count as f64)).collect();
        Self {
            slip: points.iter().map(|p| p.0).collect(),
            velocity: points.iter().map(|p| p.1).collect(),
            normal: vec![NORMAL; count],
            dt: PERIOD / count as f64,
        }
    }

    /// The same path, `pace` times as slow, `scale` times as far.
    fn changed(mut self, pace: f64, scale: f64) -> Self {
        self.slip.iter_mut().for_each(|u| *u *= scale);
        self.velocity.iter_mut().for_each(|v| *v *= scale / pace);
        self.dt *= pace;
        self
    }

    fn period(&self) -> Period<'_, f64> {
        Period { slip: &self.slip, velocity: &self.velocity, normal: &self.normal, dt: self.dt }
    }

    /// Forces of the closed loop.
    fn loop_force(&self, law: Law) -> Vec<f64> {
        let mut force = vec![0.0; self.slip.len()];
        let closing = Closing { tolerance: 1e-10, periods: 400 };
        let closed = model(law).visit(Loop(self.period(), &mut force, closing));
        assert!(closed, "{}: the loop does not close", law.name());
        force
    }
}

struct Loop<'a>(Period<'a, f64>, &'a mut [f64], Closing);

impl Visitor<f64> for Loop<'_> {
    type Output = bool;
    fn visit<L: FrictionLaw<f64>>(self, law: &L) -> bool {
        close_loop(law, &self.0, self.1, self.2).unwrap().closed
    }
}

/// Steps from rest; the forces after each.
struct Path<'a, T>(&'a [Step<T>]);

impl<T: Scalar> Visitor<T> for Path<'_, T> {
    type Output = Vec<T>;
    fn visit<L: FrictionLaw<T>>(self, law: &L) -> Vec<T> {
        let mut state = law.rest();
        let mut advance = |step| {
            let force;
            (state, force) = law.step(state, step);
            force
        };
        self.0.iter().map(&mut advance).collect()
    }
}

fn model(law: Law) -> FrictionModel {
    law.with_values(&law.example()).unwrap()
}

/// A straight path from one slip to another within `duration`.
fn straight(slip: [f64; 2], duration: f64) -> Step<f64> {
    let velocity = (slip[1] - slip[0]) / duration;
    Step { slip, velocity: [velocity; 2], normal: [NORMAL; 2], dt: duration }
}

fn largest_coefficient(law: Law) -> f64 {
    let named = model(law).named();
    let limits: f64 = (1..=4).filter_map(|k| named.get(&format!("limit_{k}"))).sum();
    let named = ["mu_s", "mu_k"].iter().filter_map(|name| named.get(*name));
    named.fold(limits, |high, value| high.max(*value))
}

#[test]
fn closed_cycles_dissipate() {
    for law in Law::ALL.iter().filter(|law| law.claims().passive) {
        for (pace, scale) in [(1.0, 1.0), (0.1, 1.0), (30.0, 0.2), (3.0, 10.0)] {
            let samples = Samples::new(512).changed(pace, scale);
            let force = samples.loop_force(*law);
            let energy: f64 = force.iter().zip(&samples.velocity).map(|(f, v)| f * v * samples.dt).sum();
            let scale: f64 =
                force.iter().zip(&samples.velocity).map(|(f, v)| (f * v).abs() * samples.dt).sum();
            // A purely elastic loop leaves the error of the rectangle rule.
            assert!(energy > -1e-6 * scale, "{}: {energy} of {scale}", law.name());
        }
    }
}

#[test]
fn opposite_slip_opposite_force() {
    for law in Law::ALL {
        let samples = Samples::new(200);
        let force = samples.loop_force(*law);
        let mirrored = samples.changed(1.0, -1.0).loop_force(*law);
        for (k, (plus, minus)) in force.iter().zip(&mirrored).enumerate() {
            assert!((plus + minus).abs() < 1e-9 * NORMAL, "{} sample {k}: {plus} {minus}", law.name());
        }
    }
}

/// A slip of odd harmonics turns into itself after half a period, and so does the force: it has no even harmonics.
#[test]
fn odd_slip_has_no_even_harmonics_in_its_force() {
    for law in Law::ALL {
        let force = Samples::new(200).loop_force(*law);
        for (k, (before, after)) in force.iter().zip(&force[100..]).enumerate() {
            // Loops are closed to 1e-10 of their largest state, some of them slowly.
            assert!((before + after).abs() < 1e-7 * NORMAL, "{} sample {k}: {before} {after}", law.name());
        }
    }
}

#[test]
fn rate_independent_laws_do_not_know_time() {
    for law in Law::ALL {
        let force = Samples::new(200).loop_force(*law);
        let slow = Samples::new(200).changed(7.3, 1.0).loop_force(*law);
        let change = force.iter().zip(&slow).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        if law.claims().rate_independent {
            assert!(change < 1e-10 * NORMAL, "{}: {change}", law.name());
        } else {
            assert!(change > 1e-3, "{} depends on the rate but does not show it: {change}", law.name());
        }
    }
}

#[test]
fn masing_laws_magnify_the_virgin_curve_twice() {
    for law in Law::ALL.iter().filter(|law| law.claims().masing) {
        for tip in [3e-7, 1e-6, 4e-6] {
            let virgin = |u: f64| model(*law).visit(Path(&[straight([0.0, u], 1e-3)]))[0];
            let mut steps = vec![straight([0.0, tip], 1e-3), straight([tip, -tip], 1e-3)];
            let points = 40;
            let slip = |k: usize| -tip + 2.0 * tip * k as f64 / points as f64;
            steps.extend((0..points).map(|k| straight([slip(k), slip(k + 1)], 1e-3)));
            let force = model(*law).visit(Path(&steps));
            for k in 1..=points {
                let expected = -virgin(tip) + 2.0 * virgin(tip * k as f64 / points as f64);
                let found = force[k + 1];
                assert!((found - expected).abs() < 1e-9 * NORMAL, "{} {k}: {found} {expected}", law.name());
            }
        }
    }
}

#[test]
fn bounded_laws_stay_below_the_largest_coefficient() {
    for law in Law::ALL.iter().filter(|law| law.claims().bounded) {
        let bound = NORMAL * largest_coefficient(*law) * (1.0 + 1e-12);
        for scale in [0.1, 1.0, 30.0] {
            for force in Samples::new(300).changed(1.0, scale).loop_force(*law) {
                assert!(force.abs() <= bound, "{}: {force} above {bound}", law.name());
            }
        }
    }
}

/// The motion along which steps are refined; a force that jumps by a rule from sample to sample needs one that is fast for the mass
/// in it.
fn refined(law: Law, count: usize) -> Samples {
    let samples = Samples::new(count);
    if law.claims().jumps { samples.changed(1e-3, 1e-3) } else { samples }
}

/// Root mean square of the distance from forces of finer steps, in units of the normal force; of forces that jump, which are
/// right but for the steps beside their jumps, the mean.
fn step_error(law: Law, coarse: &[f64], fine: &[f64]) -> f64 {
    let (stride, power) = (fine.len() / coarse.len(), if law.claims().jumps { 1 } else { 2 });
    let apart = coarse.iter().zip(fine.iter().step_by(stride)).map(|(c, f)| (c - f).abs() / NORMAL);
    let mean = apart.map(|error| error.powi(power)).sum::<f64>() / coarse.len() as f64;
    mean.powf(1.0 / f64::from(power))
}

/// A law that holds a contact says between which forces it does: those of slip that has just begun, either way. The force of any other law
/// goes through zero without a jump in a contact that has not slipped yet.
#[test]
fn a_law_that_jumps_at_rest_says_between_which_forces_it_holds() {
    struct AboutRest;
    impl Visitor<f64> for AboutRest {
        type Output = (Option<[f64; 2]>, [f64; 2]);
        fn visit<L: FrictionLaw<f64>>(self, law: &L) -> Self::Output {
            let force =
                [-1.0, 1.0].map(|sense| law.step(law.rest(), &straight([0.0, sense * 1e-18], 1e-3)).1);
            (law.at_rest(law.rest(), &straight([0.0; 2], 1e-3)), force)
        }
    }
    let mut holding = Vec::new();
    for law in Law::ALL {
        let (bounds, [below, above]) = model(*law).visit(AboutRest);
        holding.extend(bounds.map(|_| law.name()));
        let [low, high] = bounds.unwrap_or_default();
        assert!(bounds.is_none() || (low < 0.0 && high > 0.0), "{}", law.name());
        // Slip of 1e-15 m/s against the velocities and stiffnesses of the examples.
        let apart = (low - below).abs().max((high - above).abs());
        assert!(apart < 1e-6 * NORMAL, "{}: {below} {above} about {bounds:?}", law.name());
    }
    assert_eq!(holding, ["coulomb", "stribeck", "film-stribeck"]);
}

#[test]
fn refining_the_step_converges() {
    for law in Law::ALL {
        let force = |count: usize| refined(*law, count).loop_force(*law);
        let fine = force(1 << 14);
        let [coarse, middle] = [128, 512].map(|count| step_error(*law, &force(count), &fine));
        let order = if law.claims().jumps { 0.85 } else { 1.7 };
        // Below 2e-7 of N: the Runge-Kutta strides across the kinks of Bouc-Wen and of the break-away zone.
        let falls = middle < coarse / 4.0_f64.powf(order) || middle < 2e-7;
        assert!(falls, "{}: {coarse:.2e} {middle:.2e}", law.name());
    }
}

#[test]
fn stiff_steps_are_stable_and_right() {
    for law in Law::ALL {
        // A metre in one step: σ0 Δu/μ of a million. The slow reference has forgotten everything but the last
        // millimetre, too.
        let steps: Vec<Step<f64>> =
            (0..4000).map(|k| straight([k as f64 * 2.5e-4, (k + 1) as f64 * 2.5e-4], 2.5e-2)).collect();
        let reference = *model(*law).visit(Path(&steps)).last().unwrap();
        let leap = model(*law).visit(Path(&[straight([0.0, 1.0], 100.0)]))[0];
        assert!((leap - reference).abs() < 1e-6 * NORMAL, "{}: {leap} {reference}", law.name());
        let back = model(*law).visit(Path(&[straight([0.0, 1.0], 100.0), straight([1.0, 0.0], 100.0)]))[1];
        assert!((back + reference).abs() < 1e-6 * NORMAL, "{}: back {back} {reference}", law.name());
    }
}

const DIRECTIONS: usize = 20;

/// The force after a march in which one step's motion, or a parameter, is moved by `shift` in direction `k`.
fn shifted(law: Law, k: usize, shift: f64) -> f64 {
    let mut values = law.example();
    let mut steps = derivative_steps();
    match k {
        0..6 => move_step(&mut steps[3], k, shift),
        _ => values[k - 6] += shift * values[k - 6],
    }
    *law.with_values(&values).unwrap().visit(Path(&steps)).last().unwrap()
}

fn derivative_steps() -> Vec<Step<f64>> {
    let count = 40;
    let at = |k: usize| motion(k as f64 / count as f64);
    let step = |k: usize| {
        let ((u0, v0), (u1, v1)) = (at(k), at(k + 1));
        Step { slip: [u0, u1], velocity: [v0, v1], normal: [90.0, 110.0], dt: PERIOD / count as f64 }
    };
    (0..16).map(step).collect()
}

/// Sizes of slip, velocity and normal force.
const SIZES: [f64; 6] = [1e-6, 1e-6, 1e-3, 1e-3, 100.0, 100.0];

fn move_step(step: &mut Step<f64>, k: usize, shift: f64) {
    let group = [&mut step.slip, &mut step.velocity, &mut step.normal];
    group.into_iter().nth(k / 2).unwrap()[k % 2] += shift * SIZES[k];
}

fn dual_gradient(law: Law) -> [f64; DIRECTIONS] {
    type Dual = DualSVec64<DIRECTIONS>;
    let values = law.example();
    let duals: Vec<Dual> = values
        .iter()
        .enumerate()
        .map(|(k, value)| Dual::from_re(*value) + (Dual::from_re(0.0).derivative(k + 6) * *value))
        .collect();
    let plain = derivative_steps();
    let lifted = |pair: [f64; 2]| pair.map(Dual::from_re);
    let mut steps: Vec<Step<Dual>> = plain
        .iter()
        .map(|s| Step {
            slip: lifted(s.slip),
            velocity: lifted(s.velocity),
            normal: lifted(s.normal),
            dt: s.dt,
        })
        .collect();
    let seed = |pair: [Dual; 2], first: usize| {
        [0, 1].map(|i| pair[i] + Dual::from_re(0.0).derivative(first + i) * SIZES[first + i])
    };
    let moved = &mut steps[3];
    (moved.slip, moved.velocity, moved.normal) =
        (seed(moved.slip, 0), seed(moved.velocity, 2), seed(moved.normal, 4));
    let force = *law.with_values(&duals).unwrap().visit(Path(&steps)).last().unwrap();
    std::array::from_fn(|k| force.eps.0.map_or(0.0, |slopes| slopes[k]))
}

#[test]
fn dual_derivatives_are_those_of_differences() {
    for law in Law::ALL {
        let exact = dual_gradient(*law);
        for (k, exact) in exact.iter().enumerate().take(6 + law.parameters().len()) {
            let h = 1e-6;
            let (minus, here, plus) = (shifted(*law, k, -h), shifted(*law, k, 0.0), shifted(*law, k, h));
            let numeric = (plus - minus) / (2.0 * h);
            // Relative to the scale of the force; the Runge-Kutta strides of the laws with a zone move in the
            // difference and rest in the derivative, which leaves 1e-4 of it.
            let bound = 3e-4 * (NORMAL * 0.5 + exact.abs());
            let kink = ((plus - here) - (here - minus)).abs() / h > bound;
            assert!(!kink, "{} direction {k}: the point lies on a kink, choose another", law.name());
            assert!((numeric - exact).abs() < bound, "{} direction {k}: {numeric} {exact}", law.name());
        }
    }
}

#[test]
fn bad_parameters_are_refused_by_name() {
    for law in Law::ALL {
        assert_eq!(Law::from_name(law.name()).unwrap(), *law);
        assert_eq!(law.check(&law.example()), Ok(()));
        let named = model(*law).named();
        assert_eq!(law.with_named(&named).unwrap().values(), law.example());
        for parameter in law.parameters() {
            for bad in [f64::NAN, -1e3, f64::NEG_INFINITY] {
                let mut wrong = named.clone();
                wrong.insert(parameter.name.to_owned(), bad);
                let message = law.with_named(&wrong).unwrap_err().to_string();
                assert!(message.contains(parameter.name) && message.contains(law.name()), "{message}");
                assert!(message.contains(&parameter.range.to_string()), "{message}");
            }
            let mut missing = named.clone();
            missing.remove(parameter.name);
            assert!(law.with_named(&missing).unwrap_err().to_string().contains(parameter.name));
        }
        let mut extra = named.clone();
        extra.insert("colour".to_owned(), 1.0);
        assert!(law.with_named(&extra).unwrap_err().to_string().contains("colour"));
    }
    let mut hybrid = model(Law::Hybrid).named();
    hybrid.insert("breakaway".to_owned(), 1.0);
    let message = Law::Hybrid.with_named(&hybrid).unwrap_err().to_string();
    assert_eq!(message, "law 'hybrid': breakaway = 1 1 is not allowed, it must be in [0, 1)");
}
