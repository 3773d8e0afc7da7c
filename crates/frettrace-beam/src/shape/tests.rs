use super::*;

const UNIT: UniformBeam = UniformBeam { length: 1.0, bending_stiffness: 1.0, mass_per_length: 1.0 };

/// Roots of tan b = tanh b, slope φ'(L)L and shear φ'''(L)L³ of the clamped-pinned beam, from a 40-digit computation.
const PINNED: [(f64, f64, f64); 10] = [
    (3.926_602_312_047_919, -5.710_063_869_514_454, 83.263_890_899_8),
    (7.068_582_745_628_732, 9.984_455_890_358, -500.074_809_338),
    (10.210_176_122_813_03, -14.440_120_912_824, 1_505.192_689_53),
    (13.351_768_777_754_093, 18.882_210_028_263, -3_366.141_612_29),
    (16.493_361_431_346_41, -23.325_137_691_871, 6_345.158_629_01),
    (19.634_954_084_936_207, 27.768_018_246_887, -10_705.443_648_5),
    (22.776_546_738_526, -32.210_901_307_493, 16_710.084_095_9),
    (25.918_139_392_115_794, 36.653_784_239_519, -24_622.177_714_1),
    (29.059_732_045_705_586, -41.096_667_177_979, 34_704.821_430_3),
    (32.201_324_699_295_384, 45.539_550_116_123, -47_221.112_230_2),
];

/// Gauss-Legendre would be shorter, but Simpson's rule is the obvious oracle of the closed-form norm.
fn simpson(f: impl Fn(f64) -> f64, intervals: usize) -> f64 {
    let h = 1.0 / intervals as f64;
    let weight = |k: usize| if k == 0 || k == intervals { 1.0 } else { 2.0 + 2.0 * (k % 2) as f64 };
    (0..=intervals).map(|k| weight(k) * f(k as f64 * h)).sum::<f64>() * h / 3.0
}

#[test]
fn pinned_beam_meets_the_forty_digit_table() {
    let shapes = mode_shapes(&UNIT, &Boundary::pinned(), 10).unwrap();
    for (shape, (root, slope, shear)) in shapes.iter().zip(PINNED) {
        let [w, d1, _, d3] = shape.derivatives(1.0);
        // Rounding of the determinant: a few units in the last place of b.
        assert!((shape.wavenumber() / root - 1.0).abs() < 1e-14, "{} {root}", shape.wavenumber());
        assert!(w.abs() < 1e-13);
        // The table has 12 digits after the point.
        assert!((d1 / slope - 1.0).abs() < 1e-12, "{d1} {slope}");
        // The table has 12 significant digits.
        assert!((d3 / shear - 1.0).abs() < 1e-11, "{d3} {shear}");
    }
}

#[test]
fn nodes_of_the_pinned_beam() {
    // Ten digits from a 40-digit solution of sinh(b(1 − x))/sinh b = sin(b(1 − x))/sin b.
    let nodes: [(usize, &[f64]); 4] = [
        (2, &[0.557_495_970_7]),
        (3, &[0.385_961_323_1, 0.692_248_800_4]),
        (4, &[0.295_146_897_9, 0.529_366_645_7, 0.764_707_827_3]),
        (5, &[0.238_928_441_1, 0.428_534_903_5, 0.619_049_196_4, 0.809_523_741_5]),
    ];
    let shapes = mode_shapes(&UNIT, &Boundary::pinned(), 5).unwrap();
    for (mode, places) in nodes {
        for &x in places {
            let [w, slope, ..] = shapes[mode - 1].derivatives(x);
            assert!((w / slope).abs() < 1e-10, "mode {mode} at {x}: {}", w / slope);
        }
    }
}

#[test]
fn cantilever_and_clamped_roots_are_the_textbook_ones() {
    // Roots of cosh b cos b = −1 and +1.
    let cantilever =
        [1.875_104_068_711_961, 4.694_091_132_974_175, 7.854_757_438_237_613, 10.995_540_734_875_467];
    let clamped =
        [4.730_040_744_862_704, 7.853_204_624_095_838, 10.995_607_838_001_671, 14.137_165_491_257_464];
    let rigid = Boundary { support_rotational_stiffness: f64::INFINITY, ..Boundary::pinned() };
    for (boundary, roots) in [(Boundary::cantilever(), cantilever), (rigid, clamped)] {
        for (shape, root) in mode_shapes(&UNIT, &boundary, 4).unwrap().iter().zip(roots) {
            assert!((shape.wavenumber() / root - 1.0).abs() < 1e-14, "{} {root}", shape.wavenumber());
        }
    }
}

#[test]
fn frequencies_of_two_steel_beams() {
    // Closed form, L = 1 m, 50 × 50 mm, E = 200 GPa, ρ = 7850; 25 × 5 mm, E = 210 GPa.
    let cases = [
        (
            UniformBeam::rectangular(1.0, [0.05, 0.05], 200e9, 7_850.0),
            [178.777_771, 579.354_487, 1_208.776_894, 2_067.080_014, 3_154.263_966],
        ),
        (
            UniformBeam::rectangular(1.0, [0.025, 0.005], 210e9, 7_850.0),
            [18.319_27, 59.366_169, 123.862_773, 211.812_671, 323.215_876],
        ),
    ];
    for (beam, frequencies) in cases {
        for (shape, hertz) in mode_shapes(&beam, &Boundary::pinned(), 5).unwrap().iter().zip(frequencies) {
            let found = shape.natural_frequency() / std::f64::consts::TAU;
            // The last printed digit of the tables: 1e-6 of 178 Hz, 1e-5 of 18 Hz.
            assert!((found / hertz - 1.0).abs() < 3e-7, "{found} {hertz}");
        }
    }
}

#[test]
fn every_boundary_gives_orthonormal_modes_that_meet_it() {
    let springs = [0.0, 3.0, 200.0, 1e5, f64::INFINITY];
    for clamp in [0.5, 40.0, f64::INFINITY] {
        for support in springs {
            for turn in [0.0, 7.0, f64::INFINITY] {
                let boundary = Boundary {
                    clamp_rotational_stiffness: clamp,
                    support_stiffness: support,
                    support_rotational_stiffness: turn,
                };
                check_modes(&mode_shapes(&UNIT, &boundary, 12).unwrap(), &boundary);
            }
        }
    }
}

fn check_modes(shapes: &[ModeShape], boundary: &Boundary) {
    let finite = |k: f64| if k.is_finite() { k } else { 1e300 };
    for (i, a) in shapes.iter().enumerate() {
        let [w0, slope0, moment0, _] = a.derivatives(0.0);
        let [w, slope, moment, shear] = a.derivatives(1.0);
        let b = a.wavenumber();
        assert!(w0.abs() < 1e-13);
        // Conditions in units of the derivative they balance; 1e-9 covers the conditioning of soft springs at low modes.
        assert!(
            (moment0 / finite(boundary.clamp_rotational_stiffness) - slope0).abs() < 1e-9 * b,
            "{boundary:?}"
        );
        let (kr, ks) = (finite(boundary.support_rotational_stiffness), finite(boundary.support_stiffness));
        assert!((moment + kr * slope).abs() < 1e-9 * (b * b + kr * b), "{boundary:?}");
        assert!((shear - ks * w).abs() < 1e-9 * (b.powi(3) + ks), "{boundary:?}");
        // Simpson's error (b/2000)⁴ φ ~ 1e-7 at mode 12.
        let area = simpson(|x| a.derivatives(x)[0], 2000);
        assert!((a.integral() - area).abs() < 1e-6, "{boundary:?} {i}: {} {area}", a.integral());
        for (j, other) in shapes.iter().enumerate().take(i + 1) {
            let product = simpson(|x| a.derivatives(x)[0] * other.derivatives(x)[0], 2000);
            let expected = f64::from(u8::from(i == j));
            // Simpson's error (b/2000)⁴ ~ 1e-7 at mode 12.
            assert!((product - expected).abs() < 1e-6, "{boundary:?} {i} {j} {product}");
        }
    }
}

#[test]
fn high_modes_keep_their_digits() {
    let shapes = mode_shapes(&UNIT, &Boundary::pinned(), 160).unwrap();
    for (n, shape) in shapes.iter().enumerate().skip(9) {
        // b = (4n + 1)π/4 to double precision from the sixth mode on; φ'(L) = b(1/sin b − 1/sinh b) = ±√2 b.
        let asymptote = (4.0 * (n as f64 + 1.0) + 1.0) * std::f64::consts::FRAC_PI_4;
        assert!((shape.wavenumber() / asymptote - 1.0).abs() < 1e-14);
        let slope = shape.at(Dof::rotation(1.0)).abs();
        assert!((slope / (std::f64::consts::SQRT_2 * asymptote) - 1.0).abs() < 1e-11, "{n} {slope}");
    }
}

#[test]
fn a_mechanism_is_refused() {
    let boundary = Boundary { clamp_rotational_stiffness: 0.0, ..Boundary::pinned() };
    assert!(matches!(mode_shapes(&UNIT, &boundary, 3), Err(BeamError::Mechanism { .. })));
    let negative = Boundary { support_stiffness: -1.0, ..Boundary::default() };
    assert!(matches!(mode_shapes(&UNIT, &negative, 3), Err(BeamError::OutOfRange { .. })));
}
