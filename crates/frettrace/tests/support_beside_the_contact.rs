//! A further support with no sensor between it and the contact.

mod answers;

use answers::{explained, measured, named, over_noise};

/// A steel beam clamped at one end, whose other end sticks and slides; it rubs on a further support at 0.8 of its length, while the last sensor stands at 0.69. At 20 Hz it bends in
/// its first mode with up to nine lines: all that the sensors see of forces beyond them is a shear force and a moment, which a force at the contact and one at any place between make
/// in any size.
const RIG: &str = r#"
title = "a further support that rubs beside the contact"
seed = 11
[beam]
length_m = 0.66
width_m = 0.04
thickness_m = 0.02
youngs_modulus_pa = 2.1e11
density_kg_per_m3 = 7850.0
[modes]
damping_ratio = [0.006, 0.005, 0.006, 0.005, 0.006]
declared = 3
frequency_relative_std = 2e-5
damping_relative_std = 3e-3
[support]
slip = "transverse"
law = "dahl"
[support.parameters]
sigma0_per_m = 1e4
mu_k = 0.35
exponent = 1.0
[exciter]
position_m = 0.35
[sensors]
position_m = [0.1, 0.16, 0.23, 0.29, 0.36, 0.41, 0.456]
noise_std_m_per_s2 = 0.01
[sampling]
rate_hz = 2000.0
samples = 2000
[[run]]
frequency_hz = 21.37
preload_n = 60.0
force_amplitude_n = [30.0, 60.0, 120.0, 240.0]
[[run]]
frequency_hz = 21.37
preload_n = 120.0
force_amplitude_n = [45.0, 90.0, 180.0, 360.0]
[[effect]]
id = "structure.second-support/rubbing"
position_m = 0.527
level_n = 19.0
velocity_m_per_s = 0.2
"#;

/// The balance is as closed with the force at 0.6 m as at 0.53 m: its law tells, once it is asked at places all along.
#[test]
fn a_law_tells_the_place_that_no_sensor_does() {
    let found = explained(measured(RIG, |_| {}));
    assert_eq!(named(&found), ["structure.second-support"], "{:?}", found.notes);
    let values = &found.effects[0].parameters;
    for (name, truth, within) in [("position", 0.527, 0.01 * 0.66), ("friction_force", 19.0, 0.19)] {
        let value = values[name].value;
        assert!((value - truth).abs() < within, "{name} {value}");
    }
    let [before, after] = over_noise(&found);
    assert!(before > 10.0 && after < 1.05, "{before} {after}");
}
