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

/// Tip force Fc tanh a and energy 4 (Fc²/σ0)(a − tanh a); the table's W σ0/Fc² to its digits.
#[test]
fn steady_loop_of_exponent_one() {
    let table = [
        (0.1, 0.0013280215),
        (0.5, 0.151531371),
        (1.0, 0.953623376),
        (2.0, 4.14388968),
        (5.0, 16.0003632),
        (10.0, 36.0),
    ];
    for (a, tabled) in table {
        let law = Dahl { sigma0: 2e6, mu_k: 0.5, exponent: 1.0 };
        let amplitude = a * law.mu_k / law.sigma0;
        let mut state = law.rest();
        for _ in 0..400 {
            state = law.step(state, &straight([-amplitude, amplitude])).0;
            state = law.step(state, &straight([amplitude, -amplitude])).0;
        }
        // Gauss-Legendre with three points in each of 4000 strides: the loop's force is smooth between the tips.
        let strides = 4000;
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
        assert!((force - law.mu_k * a.tanh()).abs() < 1e-9 * law.mu_k, "tip at {a}: {force}");
        let scaled = energy * law.sigma0 / law.mu_k.powi(2);
        assert!((scaled - 4.0 * (a - a.tanh())).abs() < 1e-9 * scaled.max(1.0), "energy at {a}: {scaled}");
        assert!((scaled / tabled - 1.0).abs() < 5e-9, "table at {a}: {scaled}");
    }
}
