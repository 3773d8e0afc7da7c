//! Every law under a normal force that varies in time, lift-off included.

use super::*;

/// The law's example without what a lifted contact keeps: viscous drag.
fn dry(law: Law) -> FrictionModel {
    let mut values = law.example();
    if let Ok(position) = law.position("sigma2") {
        values[position] = 0.0;
    }
    law.with_values(&values).unwrap()
}

#[test]
fn a_lifted_contact_has_no_dry_friction() {
    for law in Law::ALL {
        let model = dry(*law);
        let mut steps: Vec<Step<f64>> =
            (0..50).map(|k| straight([k as f64 * 1e-7, (k + 1) as f64 * 1e-7], 1e-4)).collect();
        let normal = |k: usize| 100.0 - 8.0 * k as f64;
        steps.iter_mut().enumerate().for_each(|(k, step)| step.normal = [normal(k), normal(k + 1)]);
        let force = model.visit(Path(&steps));
        for (k, force) in force.iter().enumerate() {
            let lifted = normal(k + 1) <= 0.0;
            assert!(force.is_finite() && (!lifted || *force == 0.0), "{} {k}: {force}", law.name());
        }
        assert!(force[5] > 0.0, "{}: pressed, it must resist", law.name());
    }
}

/// Two lift-offs in a period, each for about a quarter of it, out of step with the slip.
fn normal(fraction: f64) -> f64 {
    NORMAL * (0.3 + (2.0 * TAU * fraction + 0.4).cos())
}

/// Normal and friction force of the closed loop.
fn varying(law: Law, count: usize) -> (Vec<f64>, Vec<f64>) {
    let mut samples = refined(law, count);
    samples.normal = (0..count).map(|k| normal(k as f64 / count as f64)).collect();
    let mut force = vec![0.0; count];
    let closing = Closing { tolerance: 1e-10, periods: 400 };
    let closed = dry(law).visit(Loop(samples.period(), &mut force, closing));
    assert!(closed, "{}: the loop does not close", law.name());
    (samples.normal, force)
}

/// Nothing while the contact is open, and no more than the friction coefficient allows of the force of the moment while it is closed
/// (laws with presliding damping or inertia may exceed it); after each landing it resists again.
#[test]
fn the_force_follows_the_normal_force_of_the_moment() {
    for law in Law::ALL {
        let (normal, force) = varying(*law, 512);
        for (k, (n, f)) in normal.iter().zip(&force).enumerate() {
            assert!(f.is_finite() && (*n > 0.0 || *f == 0.0), "{} sample {k}: {f} N under {n} N", law.name());
            let bound = largest_coefficient(*law) * n.max(0.0) * (1.0 + 1e-12);
            assert!(!law.claims().bounded || f.abs() <= bound, "{} sample {k}: {f} > {bound}", law.name());
        }
        for half in [&force[..256], &force[256..]] {
            let largest = half.iter().fold(0.0_f64, |high, f| high.max(f.abs()));
            assert!(largest > 0.05 * NORMAL, "{}: {largest} N at most", law.name());
        }
    }
}

/// With the step the error falls at least in proportion: landing and lift-off lie between samples.
#[test]
fn refining_the_step_converges_under_a_varying_normal_force() {
    for law in Law::ALL {
        let (_, fine) = varying(*law, 1 << 14);
        let [coarse, middle] = [128, 1024].map(|count| step_error(*law, &varying(*law, count).1, &fine));
        // Below 2e-7 of N: the Runge-Kutta strides across the kinks of Bouc-Wen and of the break-away zone.
        let least = if law.claims().jumps { 6.0 } else { 8.0 };
        assert!(middle < coarse / least || middle < 2e-7, "{}: {coarse:.2e} {middle:.2e}", law.name());
    }
}
