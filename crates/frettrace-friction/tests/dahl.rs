//! Dahl against its closed forms.

use frettrace_friction::laws::{CattaneoMindlin, Dahl};
use frettrace_friction::{FrictionLaw, Step};

fn straight(slip: [f64; 2]) -> Step<f64> {
    Step { slip, velocity: [slip[1] - slip[0]; 2], normal: [1.0; 2], dt: 1.0 }
}

/// F/Fc from rest at ξ = 0.2, 0.5, 1, 1.5, 2, 3, 5, computed in high precision from
/// `1 − [1 + (i − 1) ξ]^{−1/(i − 1)}` and `1 − e^{−ξ}`.
#[test]
fn virgin_curves_of_five_exponents() {
    let distances = [0.2, 0.5, 1.0, 1.5, 2.0, 3.0, 5.0];
    let table = [
        (0.5, [0.19, 0.4375, 0.75, 0.9375, 1.0, 1.0, 1.0]),
        (1.0, [0.181269247, 0.393469340, 0.632120559, 0.776869840, 0.864664717, 0.950212932, 0.993262053]),
        (1.5, [0.173553719, 0.36, 0.555555556, 0.673469388, 0.75, 0.84, 0.918367347]),
        (2.0, [0.166666667, 0.333333333, 0.5, 0.6, 0.666666667, 0.75, 0.833333333]),
        (3.0, [0.154845745, 0.292893219, 0.422649731, 0.5, 0.552786405, 0.622035527, 0.698488655]),
    ];
    for (exponent, forces) in table {
        let law = Dahl { sigma0: 3e6, mu_k: 0.7, exponent };
        let scale = law.mu_k / law.sigma0;
        // In one stride and in steps of ξ = 0.1: the same, because the step is exact in the travel.
        let (mut state, mut slip) = (law.rest(), 0.0);
        for (xi, expected) in distances.into_iter().zip(forces) {
            let leap = law.step(law.rest(), &straight([0.0, xi * scale])).1 / law.mu_k;
            // The table has nine decimals.
            assert!((leap - expected).abs() < 6e-10, "{exponent} {xi}: {leap}");
            let mut force = 0.0;
            while slip < (xi - 1e-9) * scale {
                (state, force) = law.step(state, &straight([slip, slip + 0.1 * scale]));
                slip += 0.1 * scale;
            }
            assert!((force / law.mu_k - leap).abs() < 1e-12, "{exponent} {xi}: {force}");
        }
    }
}

#[test]
fn one_third_is_mindlin() {
    let mindlin = CattaneoMindlin { mu_k: 0.4, slip_distance: 2e-6 };
    let dahl = Dahl { sigma0: 1.5 * 0.4 / 2e-6, mu_k: 0.4, exponent: 1.0 / 3.0 };
    for slip in [1e-8, 5e-7, 1.7e-6, 1.999e-6, 3e-6] {
        let expected = mindlin.step(mindlin.rest(), &straight([0.0, slip])).1;
        let found = dahl.step(dahl.rest(), &straight([0.0, slip])).1;
        assert!((found - expected).abs() < 1e-13, "{slip}: {found} {expected}");
    }
}

/// Tip force over Fc and energy σ0 W/Fc² of the steady loop of amplitude `a = σ0 A/Fc`, `strides` strides each way: Gauss-Legendre
/// with three points in each, since the force is smooth between the tips.
fn steady_loop(law: &Dahl<f64>, a: f64, strides: usize) -> [f64; 2] {
    let amplitude = a * law.mu_k / law.sigma0;
    let mut state = law.rest();
    for _ in 0..400 {
        state = law.step(state, &straight([-amplitude, amplitude])).0;
        state = law.step(state, &straight([amplitude, -amplitude])).0;
    }
    let width = 2.0 * amplitude / strides as f64;
    let (mut energy, mut force) = (0.0, 0.0);
    for k in 0..strides {
        let start = -amplitude + width * k as f64;
        for (node, weight) in
            [(0.112701665379258, 5.0 / 18.0), (0.5, 8.0 / 18.0), (0.887298334620742, 5.0 / 18.0)]
        {
            energy += 2.0 * width * weight * law.step(state, &straight([start, start + node * width])).1;
        }
        (state, force) = law.step(state, &straight([start, start + width]));
    }
    [force / law.mu_k, energy * law.sigma0 / law.mu_k.powi(2)]
}

/// Tip force Fc tanh a and energy 4 (Fc²/σ0)(a − tanh a); W σ0/Fc² and its sensitivity d ln W/d ln σ0 to the digits of a table made
/// with 40 digits.
#[test]
fn steady_loop_of_exponent_one() {
    let table = [
        (0.1, 0.0013280215, 1.99),
        (0.5, 0.151531371, 1.82),
        (1.0, 0.953623376, 1.43),
        (2.0, 4.14388968, 0.794),
        (5.0, 16.0003632, 0.250),
        (10.0, 36.0, 0.111),
        (50.0, 196.0, 0.0204),
    ];
    for (a, tabled, sensitivity) in table {
        let law = Dahl { sigma0: 2e6, mu_k: 0.5, exponent: 1.0 };
        let [tip, energy] = steady_loop(&law, a, 4000);
        assert!((tip - a.tanh()).abs() < 1e-9, "tip at {a}: {tip}");
        let exact = 4.0 * (a - a.tanh());
        assert!((energy / exact - 1.0).abs() < 1e-9, "energy at {a}: {energy} for {exact}");
        assert!((energy / tabled - 1.0).abs() < 4e-8, "table at {a}: {energy}"); // 0.0013280215 has eight digits
        // W is the number over σ0, at an amplitude that stays: a grows with σ0.
        let shift = 1e-4;
        let [low, high] = [-shift, shift].map(|s| steady_loop(&law, a * (1.0 + s), 4000)[1].ln() - s);
        let slope = (high - low) / (2.0 * shift);
        // Three digits are given: half a unit of the last is up to 0.5 %.
        assert!((slope / sensitivity - 1.0).abs() < 5e-3, "slope at {a}: {slope}");
    }
}

/// Any exponent: with the tip force `t`, `∫ dp/(1 − p)^i` from −t to t is 2a, and the energy is twice `∫ p dp/(1 − p)^i`:
/// `a = [(1 + t)^{1−i} − (1 − t)^{1−i}]/(2(1 − i))`, `σ0 W/Fc² = 4a − 2[(1 + t)^{2−i} − (1 − t)^{2−i}]/(2 − i)`, a logarithm of
/// `(1 + t)/(1 − t)` where the power is 0.
#[test]
fn steady_loops_of_other_exponents() {
    let power = |n: f64, t: f64| {
        if n == 0.0 { ((1.0 + t) / (1.0 - t)).ln() } else { ((1.0 + t).powf(n) - (1.0 - t).powf(n)) / n }
    };
    for exponent in [0.5, 1.0, 1.5, 2.0, 3.0] {
        for tip in [0.1, 0.5, 0.8, 0.95] {
            let law = Dahl { sigma0: 2e6, mu_k: 0.5, exponent };
            let a = 0.5 * power(1.0 - exponent, tip);
            let energy = 4.0 * a - 2.0 * power(2.0 - exponent, tip);
            let found = steady_loop(&law, a, 16_000);
            assert!((found[0] - tip).abs() < 1e-9, "tip, {exponent} {tip}: {found:?}");
            assert!((found[1] / energy - 1.0).abs() < 1e-8, "energy, {exponent} {tip}: {found:?} {energy}");
        }
    }
}

/// After an inner loop the force is another: Dahl's law has no memory but its deflection. On the branch from z = 0, r = 1 − e^{−ξ}
/// and back r → −1 + (1 + r) e^{−ξ}: a loop of ξ = 1 down to 1/2 and up again ends at 1 − e^{−1/2}(2 − e^{−1/2}(2 − e^{−1})).
#[test]
fn an_inner_loop_does_not_close() {
    let law = Dahl { sigma0: 1.0, mu_k: 1.0, exponent: 1.0 };
    let mut state = law.rest();
    for pair in [[0.0, 1.0], [1.0, 0.5], [0.5, 1.0]] {
        state = law.step(state, &straight(pair)).0;
    }
    let half = (-0.5_f64).exp();
    let expected = 1.0 - half * (2.0 - half * (2.0 - (-1.0_f64).exp()));
    assert!((state[0] - expected).abs() < 1e-15, "{} {expected}", state[0]);
    assert!((state[0] - (1.0 - (-1.0_f64).exp())).abs() > 0.01);
}
