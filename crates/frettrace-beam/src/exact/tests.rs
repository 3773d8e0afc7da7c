use super::*;

const UNIT: UniformBeam = UniformBeam { length: 1.0, bending_stiffness: 1.0, mass_per_length: 1.0 };

/// `θ/M` of the pinned end in closed form, `(cosh λ cos λ − 1)/(λ (cos λ sinh λ − sin λ cosh λ))`.
fn pinned_end(wavenumber: f64) -> f64 {
    let (sine, cosine) = wavenumber.sin_cos();
    let (sinh, cosh) = (wavenumber.sinh(), wavenumber.cosh());
    (cosh * cosine - 1.0) / (wavenumber * (cosine * sinh - sine * cosh))
}

#[test]
fn unit_beam_values_at_the_pinned_end() {
    let exact = ExactBeam::new(&UNIT, &Boundary::pinned(), 0.0).unwrap();
    let first = 3.926_602_312_047_919_f64;
    let end = Dof::rotation(1.0);
    // The closed form below at 40 digits.
    let table = [
        (0.3, 0.263_958_933_259_126_06),
        (0.98, 3.580_924_790_001_432_7),
        (1.5, 0.015_280_721_089_070_949),
        (4.9, 0.060_576_422_757_050_76),
    ];
    for (ratio, value) in table {
        let omega = ratio * first * first;
        let found = exact.receptance(end, end, omega);
        // Near the pole (0.98) and near the zero (1.5) rounding of ω is amplified some fifty times.
        assert!((found.re / value - 1.0).abs() < 1e-13, "{ratio}: {} {value}", found.re);
        let oracle = pinned_end(omega.sqrt());
        // The hyperbolic form loses digits of its own.
        assert!((found.re / oracle - 1.0).abs() < 1e-12, "{ratio}: {} {oracle}", found.re);
        assert!(found.im.abs() < 1e-13 * found.re.abs());
    }
}

#[test]
fn cantilever_tip_to_a_force() {
    let exact = ExactBeam::new(&UNIT, &Boundary::cantilever(), 0.0).unwrap();
    let tip = Dof::displacement(1.0);
    for wavenumber in [0.7, 1.5, 3.0, 8.0, 20.0] {
        let (sine, cosine) = f64::sin_cos(wavenumber);
        let (sinh, cosh) = (f64::sinh(wavenumber), f64::cosh(wavenumber));
        // Classical: w/F = (sinh cos − cosh sin)·(−1)/(λ³ (1 + cosh cos)).
        let oracle = (cosh * sine - sinh * cosine) / (wavenumber.powi(3) * (1.0 + cosh * cosine));
        let found = exact.receptance(tip, tip, wavenumber * wavenumber).re;
        assert!((found / oracle - 1.0).abs() < 1e-11, "{wavenumber}: {found} {oracle}");
    }
}

#[test]
fn reciprocal_damped_and_continuous_to_the_static_limit() {
    let boundary = Boundary {
        clamp_rotational_stiffness: 30.0,
        support_stiffness: 400.0,
        support_rotational_stiffness: 2.0,
    };
    let exact = ExactBeam::new(&UNIT, &boundary, 0.01).unwrap();
    let undamped = ExactBeam::new(&UNIT, &boundary, 0.0).unwrap();
    let dofs = [Dof::displacement(0.3), Dof::displacement(1.0), Dof::rotation(0.3), Dof::rotation(1.0)];
    for output in dofs {
        for input in dofs {
            for omega in [1.0, 20.0, 5000.0, 1e6] {
                let (a, b) = (exact.receptance(output, input, omega), exact.receptance(input, output, omega));
                assert!((a - b).norm() < 1e-12 * a.norm() + 1e-18, "{output:?} {input:?} {omega}: {a} {b}");
                assert!(a.norm().is_finite());
            }
            assert!(exact.receptance(output, output, 20.0).im < 0.0, "a passive structure lags its load");
            // The difference to the static limit is of order ω²; rounding at small βL is 1e-16/(βL)³.
            let (near, at) =
                (undamped.receptance(output, input, 0.01), undamped.receptance(output, input, 0.0));
            assert!((near - at).norm() < 1e-4 * at.norm().max(1e-2), "{output:?} {input:?}: {near} {at}");
        }
    }
}

#[test]
fn no_growth_at_high_frequency() {
    // A damped beam far above its modes is half of an endless one, hinged at its end: w = C (e^{-βr} − e^{-iβr}),
    // EI w'' = M gives C = M/(2β²EI) and θ/M = (1 − i)/(2βEI), with the complex β of the loss factor.
    for wavenumber in [100.0_f64, 1000.0] {
        let exact = ExactBeam::new(&UNIT, &Boundary::pinned(), 0.3).unwrap();
        let end = Dof::rotation(1.0);
        let stiffness = Complex64::new(1.0, 0.3);
        let beta = wavenumber * stiffness.powf(-0.25);
        let oracle = Complex64::new(1.0, -1.0) / (2.0 * beta * stiffness);
        let found = exact.receptance(end, end, wavenumber * wavenumber);
        // What comes back from the clamp has decayed by e^{-2·0.073·100} = 5e-7.
        assert!((found / oracle - 1.0).norm() < 1e-6, "{found} {oracle}");
    }
}
