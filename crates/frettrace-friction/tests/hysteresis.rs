//! Jenkins, Iwan, Mindlin and the elasto-plastic law against their closed forms.

use frettrace_friction::laws::{CattaneoMindlin, ElastoPlastic, Iwan, Jenkins, Lugre};
use frettrace_friction::{Bristle, FrictionLaw, Step};

fn straight(slip: [f64; 2], normal: f64) -> Step<f64> {
    Step { slip, velocity: [slip[1] - slip[0]; 2], normal: [normal; 2], dt: 1.0 }
}

/// Vertices computed by hand for kt = 2, Fs = 3 (also in tmd-lab/tmdsimpy's tests).
#[test]
fn jenkins_vertices() {
    let law: Jenkins<f64> = Jenkins { tangential_stiffness: 2.0, mu_k: 3.0 };
    let (slips, forces) =
        ([0.0, 5.0, 3.5, 2.0, -5.0, -3.5, -2.0, 0.0], [0.0, 3.0, 0.0, -3.0, -3.0, 0.0, 3.0, 3.0]);
    let mut state = law.rest();
    for k in 1..slips.len() {
        let (next, force) = law.step(state, &straight([slips[k - 1], slips[k]], 1.0));
        state = next;
        assert!((force - forces[k]).abs() < 1e-15, "{k}: {force}");
    }
}

/// Caughey's first harmonic for kt = 2, Fs = 3 under u = A cos θ.
#[test]
fn jenkins_describing_function() {
    let law: Jenkins<f64> = Jenkins { tangential_stiffness: 2.0, mu_k: 3.0 };
    let table = [
        (2.0, 3.217996, -0.954930),
        (3.0, 3.0, -1.909859),
        (5.0, 2.523158, -2.673803),
        (20.0, 1.362949, -3.533240),
    ];
    for (amplitude, cosine, sine) in table {
        let samples = 1 << 14;
        let at = |k: usize| {
            let phase = std::f64::consts::TAU * k as f64 / samples as f64;
            (amplitude * phase.cos(), -amplitude * phase.sin())
        };
        let dt = std::f64::consts::TAU / samples as f64;
        let (mut state, mut sums) = (law.rest(), [0.0; 2]);
        for k in 0..2 * samples {
            let ((u0, v0), (u1, v1)) = (at(k), at(k + 1));
            let (next, force) =
                law.step(state, &Step { slip: [u0, u1], velocity: [v0, v1], normal: [1.0; 2], dt });
            state = next;
            if k >= samples {
                let phase = std::f64::consts::TAU * (k + 1) as f64 / samples as f64;
                sums[0] += 2.0 / samples as f64 * force * phase.cos();
                sums[1] += 2.0 / samples as f64 * force * phase.sin();
            }
        }
        // Six decimals are given; the rectangle rule with kinks adds (2π/samples)².
        assert!((sums[0] - cosine).abs() < 1e-6 && (sums[1] - sine).abs() < 1e-6, "{amplitude}: {sums:?}");
        // The loop's area is π A times the part of the first harmonic out of phase: 4 Fs (A − Fs/kt).
        let area = -std::f64::consts::PI * amplitude * sums[1];
        assert!((area / (12.0 * (amplitude - 1.5)) - 1.0).abs() < 1e-6, "{amplitude}: {area}");
    }
}

/// Energy of a loop between ±amplitude, after a first loop: Gauss-Legendre with three points in each of `strides` strides each way.
fn loop_energy<L: FrictionLaw<f64>>(law: &L, amplitude: f64, strides: usize) -> f64 {
    let slip = |k: usize| {
        let place = k % (2 * strides);
        let along = if place <= strides { place } else { 2 * strides - place };
        // Strides shorten towards the tips, where the branches of microslip laws have their broken powers.
        -amplitude * (std::f64::consts::PI * along as f64 / strides as f64).cos()
    };
    let mut state = law.step(law.rest(), &straight([0.0, -amplitude], 1.0)).0;
    let mut energy = 0.0;
    for k in 0..4 * strides {
        let (start, end) = (slip(k), slip(k + 1));
        if k >= 2 * strides {
            for (node, weight) in
                [(0.112701665379258, 5.0 / 18.0), (0.5, 8.0 / 18.0), (0.887298334620742, 5.0 / 18.0)]
            {
                let inside = straight([start, start + node * (end - start)], 1.0);
                energy += weight * (end - start) * law.step(state, &inside).1;
            }
        }
        state = law.step(state, &straight([start, end], 1.0)).0;
    }
    energy
}

/// Segalman's law with kt = 2, Fs = 3, χ = −0.1, β = 0.1; digits from the closed forms in high precision. R and S are the strength of
/// the distribution and the stiffness that is left to break at φ_max.
#[test]
fn iwan_backbone_and_dissipation() {
    let (chi, beta) = (-0.1_f64, 0.1);
    let law: Iwan<f64> = Iwan { sigma0: 2.0, mu_k: 3.0, chi, beta };
    let full = law.full_slip();
    assert!((full - 2.876146789).abs() < 5e-10);
    let share = beta + (chi + 1.0) / (chi + 2.0);
    let strength = 3.0 * (chi + 1.0) / (full.powf(chi + 2.0) * share);
    assert!((strength - 0.6323388680).abs() < 5e-10, "{strength}");
    let shortly_before = 1e-7 * full;
    let left = (law.backbone(full) - law.backbone(full - shortly_before)) / shortly_before;
    // The curvature R φ_max^χ leaves a tenth of a millionth, rounding 3e-16/3e-7.
    assert!((left - 0.1818181818).abs() < 2e-7, "{left}");
    let table = [
        (0.05, 0.278330623, 0.00165738468),
        (0.1, 0.540580035, 0.0123711567),
        (0.25, 1.240476200, 0.176374718),
        (0.5, 2.138687984, 1.31650745),
        (0.75, 2.720870284, 4.26665936),
        (1.0, 3.0, 9.82675904),
    ];
    for (share, force, dissipated) in table {
        let amplitude = share * full;
        let found = law.step(law.rest(), &straight([0.0, amplitude], 1.0)).1;
        assert!((found - force).abs() < 6e-10, "{share}: {found}");
        let energy = loop_energy(&law, amplitude, 2000);
        let exact = 4.0 * strength * amplitude.powf(chi + 3.0) / ((chi + 2.0) * (chi + 3.0));
        assert!((energy / exact - 1.0).abs() < 1e-9, "{share}: {energy} {exact}");
        assert!((energy / dissipated - 1.0).abs() < 4e-9, "{share}: {energy}"); // nine digits
    }
    // Beyond φ_max everything slips.
    let energy = loop_energy(&law, 1.5 * full, 2000);
    let exact = 4.0 * strength * full.powf(chi + 3.0) / ((chi + 2.0) * (chi + 3.0)) + 4.0 * 3.0 * 0.5 * full;
    // The corner at φ_max lies inside a stride of π/2000: its square is left.
    assert!((energy / exact - 1.0).abs() < 3e-6, "{energy} {exact}");
}

/// Johnson's energy of partial slip, and (4/27) μN u_s τ³ where the slip is small.
#[test]
fn mindlin_energy() {
    let law: CattaneoMindlin<f64> = CattaneoMindlin { mu_k: 1.0, slip_distance: 1.0 };
    let table = [
        (0.1, 1.58771569e-4),
        (0.3, 5.01676562e-3),
        (0.5, 0.0281736902),
        (0.7, 0.0998843875),
        (0.9, 0.320990646),
        (1.0, 0.8),
    ];
    let exact = |tau: f64| {
        let p = 1.0 - tau;
        let third = p.powf(2.0 / 3.0);
        4.8 * (1.0 - p * third - 5.0 * tau / 6.0 * (1.0 + third))
    };
    for (tau, expected) in table {
        let amplitude = 1.0 - f64::powf(1.0 - tau, 2.0 / 3.0);
        let energy = loop_energy(&law, amplitude, 2000);
        assert!((energy / exact(tau) - 1.0).abs() < 1e-9, "{tau}: {energy} {}", exact(tau));
        assert!((energy / expected - 1.0).abs() < 4e-9, "{tau}: {energy}"); // nine digits
    }
    // The next term of the series is of the relative size τ.
    let energy = loop_energy(&law, 1.0 - f64::powf(1.0 - 1e-3, 2.0 / 3.0), 2000);
    assert!((energy / (4.0 / 27.0 * 1e-9) - 1.0).abs() < 1e-3, "{energy}");
}

/// Radius, load and limit displacement of the sphere in tmd-lab/microslip-rough-contact: our numbers for the formulas
/// N = (4/3) E* √R d^{3/2}, a = √(R d), u_s = 3 μ N/(16 G* a).
#[test]
fn mindlin_limit_of_a_steel_sphere() {
    let (modulus, poisson, radius, mu, depth) = (192.85e9, 0.29, 4.174432305996625e-3, 0.2, 1e-5_f64);
    let plane = modulus / (1.0 - poisson * poisson) / 2.0;
    let normal = 4.0 / 3.0 * plane * f64::sqrt(radius) * depth.powf(1.5);
    let shear = modulus / (2.0 * (1.0 + poisson)) / (2.0 * (2.0 - poisson));
    let slip_distance = 3.0 * mu * normal / (16.0 * shear * (radius * depth).sqrt());
    assert!((normal - 286.799927043).abs() < 1e-8 && (slip_distance - 2.408450704e-6).abs() < 1e-15);
    let law: CattaneoMindlin<f64> = CattaneoMindlin { mu_k: mu, slip_distance };
    let force = law.step(law.rest(), &straight([0.0, 1.9014e-7], normal)).1;
    // The displacement has five digits: 2.6e-5 of the force.
    assert!((force - 6.65675).abs() < 1.7e-4, "{force}");
}

/// Inner loops are wiped out: the force depends on the outer turning points alone.
#[test]
fn closed_inner_loops_are_forgotten() {
    let law: Iwan<f64> = Iwan { sigma0: 2.0, mu_k: 3.0, chi: -0.5, beta: 0.3 };
    let along = |slips: &[f64]| {
        let mut state = law.rest();
        let mut force = 0.0;
        for pair in slips.windows(2) {
            (state, force) = law.step(state, &straight([pair[0], pair[1]], 1.0));
        }
        force
    };
    let plain = along(&[0.0, 1.2, -0.7, 0.6]);
    let nested = along(&[0.0, 1.2, -0.7, 0.2, -0.3, 0.1, -0.1, 0.1, -0.3, 0.2, 0.6]);
    assert!((plain - nested).abs() < 1e-14, "{plain} {nested}");
}

/// Net displacement of a mass under an oscillating force with a bias, below the breakaway force, over 40 cycles.
fn drift(bristle: &Bristle<f64>) -> f64 {
    let (period, h) = (1.0, 1e-4);
    let slope = |t: f64, [_, v, z]: [f64; 3]| {
        let rate = bristle.rate(z, v, bristle.steady(v));
        let load = 0.2 * (1.0 - (-t / 2.0).exp()) + 0.08 * (std::f64::consts::TAU * t / period).sin();
        [v, load - bristle.force(z, rate, v, 1.0), rate]
    };
    let (mut state, mut marks) = ([0.0; 3], Vec::new());
    for count in 0..600_000 {
        let t = count as f64 * h;
        if count == 200_000 || count == 599_999 {
            marks.push(state[0]);
        }
        let k1 = slope(t, state);
        let middle: [f64; 3] = std::array::from_fn(|i| state[i] + h / 2.0 * k1[i]);
        let k2 = slope(t + h / 2.0, middle);
        state = std::array::from_fn(|i| state[i] + h * k2[i]);
    }
    marks[1] - marks[0]
}

/// σ0 = 1000, σ1 = 100, σ2 = 50, breakaway 0.3 of the steady deflection; the force stays below 0.3.
#[test]
fn elasto_plastic_does_not_drift_where_lugre_does() {
    let elastic = ElastoPlastic {
        sigma0: 1e3,
        sigma1: 100.0,
        sigma2: 50.0,
        mu_s: 1.0,
        mu_k: 1.0,
        v_s: 1e-2,
        delta: 2.0,
        breakaway: 0.3,
    };
    let creeping = Lugre {
        sigma0: 1e3,
        sigma1: 100.0,
        v_d: f64::INFINITY,
        sigma2: 50.0,
        mu_s: 1.0,
        mu_k: 1.0,
        v_s: 1e-2,
        delta: 2.0,
    };
    let (still, creep) = (drift(&elastic.bristle()), drift(&creeping.bristle()));
    // The bias is reached to 0.2 exp(−10) at the first mark: 9e-6/σ0 of elastic displacement is left.
    assert!(still.abs() < 2e-8, "{still}");
    assert!(creep > 1e-4, "{creep}");
}
