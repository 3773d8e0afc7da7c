use super::*;

/// A rig that is right, for the tests of this crate.
pub(crate) const RIG: &str = r#"
title = "test rig"
seed = 5

[beam]
length_m = 0.5
width_m = 0.03
thickness_m = 0.0075
youngs_modulus_pa = 2.0e11
density_kg_per_m3 = 7850.0

[modes]
damping_ratio = [0.02]

[support]
slip = "rotation"
lever_arm_m = 0.0037
normal_stiffness_n_per_m = 5.0e6
law = "dahl"

[support.parameters]
sigma0_per_m = 5.0e5
mu_k = 0.25
exponent = 1.0

[exciter]
position_m = 0.23

[sensors]
position_m = [0.1, 0.31, 0.46]
noise_std_m_per_s2 = 0.05

[sampling]
rate_hz = 8192.0
samples = 1024

[[run]]
frequency_hz = 104.0
preload_n = 70.0
force_amplitude_n = [1.0, 8.0]
"#;

fn parse(text: &str) -> Result<Rig, StudyError> {
    parse_rig(text, Path::new("RIG.toml"))
}

#[test]
fn a_right_rig_is_read() {
    let rig = parse(RIG).unwrap();
    assert_eq!(rig.runs[0].force_amplitude_n, [1.0, 8.0]);
    assert_eq!(rig.modes.declared, 6);
    assert_eq!(rig.clamp.rotational_stiffness_n_m_per_rad, f64::INFINITY);
}

#[test]
fn bare_mistakes_are_refused_in_one_line() {
    let cases = [
        ("length_m = 0.5", "length = 0.5", "RIG.toml: line 6: unknown field `length`"),
        ("length_m = 0.5", "length_m = 500.0", "RIG.toml: beam.length_m is 500; allowed: 0.01 to 100"),
        ("exponent = 1.0", "exponent = -1.0", "support.parameters.exponent is -1; allowed: in [0, 20)"),
        (
            "mu_k = 0.25",
            "mu = 0.25",
            "support.parameters.mu is unknown; allowed: dahl has sigma0_per_m, mu_k, exponent",
        ),
        ("mu_k = 0.25\n", "", "support.parameters.mu_k is missing; allowed: > 0 and finite"),
        ("mu_k = 0.25", "mu_k = nan", "support.parameters.mu_k is NaN; allowed: > 0 and finite"),
        ("law = \"dahl\"", "law = \"dhal\"", "support.law is dhal; allowed: coulomb, stribeck, dahl"),
        ("length_m = 0.5", "length_mm = 500.0", "line 6: unknown field `length_mm`"),
        ("length_m = 0.5", "length_m = \"500 mm\"", "line 6: invalid type: string"),
        ("length_m = 0.5", "length_m = nan", "beam.length_m is NaN; allowed: 0.01 to 100"),
        ("thickness_m = 0.0075", "thickness_m = 0.0", "beam.thickness_m is 0; allowed: 0.0001 to 1"),
        ("youngs_modulus_pa = 2.0e11", "youngs_modulus_pa = 200.0", "allowed: 1000000 to 2000000000000"),
        ("[exciter]\nposition_m = 0.23\n", "", "missing field `exciter`"),
        ("[[run]]", "[run]", "expected a list in [ ]"),
        ("[beam]", "[beam", "line 5:"),
        ("width_m = 0.03", "width_m = 0.03\nwidth_m = 0.04", "duplicate key"),
        ("[0.02]", "[2.0]", "modes.damping_ratio is 2; allowed: 0.000001 to 0.3"),
        ("[0.02]", "[]", "modes.damping_ratio, number of values is 0; allowed: 1 to 40"),
        ("slip = \"rotation\"", "slip = \"rolling\"", "expected `rotation` or `transverse`"),
        ("5.0e6", "nan", "support.normal_stiffness_n_per_m is NaN; allowed: 1 to inf"),
        ("0.46]", "0.64]", "sensors.position_m is 0.64; allowed: 0 to 0.5"),
        ("noise_std_m_per_s2 = 0.05", "noise_std_m_per_s2 = -1.0", "allowed: 0 to 10000"),
        ("samples = 1024", "samples = 1024.5", "line 35: invalid type: floating point"),
        (
            "samples = 1024",
            "samples = 10000000000",
            "sampling.samples is 10000000000; allowed: 64 to 1000000",
        ),
        (
            "samples = 1024",
            "samples = 1024\nmarch_rate_hz = 1e4",
            "sampling.march_rate_hz is 10000; allowed: 65536 to 16777216",
        ),
        ("samples = 1024", "samples = 1024\nmarch_rate = 1e5", "unknown field `march_rate`"),
        (
            "frequency_hz = 104.0",
            "frequency_hz = 4000.0",
            "run 1: frequency_hz is 4000; allowed: 8 to 1638.4",
        ),
        ("[1.0, 8.0]", "[]", "run 1: force_amplitude_n, number of values is 0; allowed: 1 to 999"),
        ("[1.0, 8.0]", "[0.0]", "run 1: force_amplitude_n is 0; allowed: 0.000001 to 1000000"),
        ("lever_arm_m = 0.0037\n", "", "support.lever_arm_m is missing"),
        ("position_m = 0.23", "position_m = 0.53", "exciter.position_m is 0.53; allowed: 0.0005 to 0.5"),
        ("preload_n = 70.0", "preload_n = -70.0", "run 1: preload_n is -70; allowed: 0.001 to 1000000"),
        ("title = \"test rig\"", "title = test rig", "RIG.toml: line 2:"),
        ("position_m = 0.23", "position_m = 0.0", "exciter.position_m is 0; allowed: 0.0005 to 0.5"),
        ("position_m = 0.23", "position_m = nan", "exciter.position_m is NaN; allowed: 0.0005 to 0.5"),
        (
            "slip = \"rotation\"",
            "slip = \"transverse\"",
            "support.normal_stiffness_n_per_m is 5000000; allowed: none with slip = \"transverse\"",
        ),
        (
            "frequency_hz = 104.0",
            "frequency_hz = \"104 Hz\"",
            "invalid type: string \"104 Hz\", expected a number",
        ),
        (
            "samples = 1024",
            "samples = -5",
            "line 35: invalid value: integer `-5`, expected a whole number, 0 or more",
        ),
        ("[0.1, 0.31, 0.46]", "0.1", "invalid type: floating point `0.1`, expected a list in [ ]"),
    ];
    for (right, wrong, expected) in cases {
        let message = parse(&RIG.replace(right, wrong)).unwrap_err().to_string();
        assert!(message.contains(expected), "{message}");
        assert_eq!(message.lines().count(), 1, "{message}");
    }
}

/// A pinned end is a support of infinite stiffness; it is marched as a spring so stiff that its frequencies are the pinned
/// beam's to a part in a thousand, and has a reaction.
#[test]
fn a_pinned_end_is_allowed() {
    let rig =
        parse(&RIG.replace("normal_stiffness_n_per_m = 5.0e6", "normal_stiffness_n_per_m = inf")).unwrap();
    assert_eq!(rig.support.normal_stiffness_n_per_m, Some(f64::INFINITY));
    let beam = frettrace_beam::UniformBeam { length: 0.5, bending_stiffness: 100.0, mass_per_length: 1.0 };
    let stiff = frettrace_beam::Boundary::spring(crate::reconstruct::told_apart(f64::INFINITY, &beam));
    let first = |boundary| frettrace_beam::mode_shapes(&beam, &boundary, 1).unwrap()[0].natural_frequency();
    let (sprung, pinned) = (first(stiff), first(frettrace_beam::Boundary::pinned()));
    assert!((sprung / pinned - 1.0).abs() < 1e-3, "{sprung} {pinned}");
}

#[test]
fn effects_are_read_by_id_with_their_own_keys() {
    let with = |effect: &str| parse(&format!("{RIG}\n[[effect]]\n{effect}"));
    let rig = with("id = \"structure.added-mass\"\nposition_m = 0.2\nmass_kg = 0.01").unwrap();
    assert_eq!(rig.effects, [Effect::AddedMass { position_m: 0.2, mass_kg: 0.01 }]);
    assert_eq!(rig.effects[0].id(), "structure.added-mass");
    assert_eq!(with("id = \"contact.lift-off\"").unwrap().effects, [Effect::LiftOff]);
    let wrong = [
        (
            "id = \"structure.added-mass\"\nposition_m = 0.7\nmass_kg = 0.01",
            "effect 1 (structure.added-mass): position_m",
        ),
        (
            "id = \"measurement.gain\"\nsensor = 3\nfactor = 1.1",
            "effect 1 (measurement.gain): sensor is 3; allowed: 0 to 2",
        ),
        ("id = \"friction.magic\"", "unknown name `friction.magic`"),
        ("id = \"measurement.gain\"\nsensor = 1\nfactor = 1.1\nphase = 2", "unknown field `phase`"),
    ];
    for (text, expected) in wrong {
        let message = with(text).unwrap_err().to_string();
        assert!(message.contains(expected), "{message}");
    }
}
