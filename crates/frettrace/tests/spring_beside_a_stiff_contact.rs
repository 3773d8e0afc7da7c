//! A spring beside a contact that hardly gives way.

mod answers;

use answers::{explained, measured, named, over_noise};

/// A steel beam of which no mode was measured, whose other end turns on a contact of 4.6e7 N/m with a spring of 2.7e6 N/m beside it. Driven close above its second mode it moves
/// the contact by micrometres, and the frequencies of its modes, known to a thousandth, take most of what the spring does.
const RIG: &str = r#"
title = "a spring beside a contact that hardly gives way"
seed = 3
[beam]
length_m = 0.83
width_m = 0.03
thickness_m = 0.0113
youngs_modulus_pa = 2.1e11
density_kg_per_m3 = 7830.0
[modes]
damping_ratio = [0.006, 0.005, 0.006, 0.005, 0.006]
declared = 0
[support]
slip = "rotation"
lever_arm_m = 0.0049
normal_stiffness_n_per_m = 7.2e6
law = "lugre"
[support.parameters]
sigma0_per_m = 2.9e5
mu_k = 0.054
mu_s = 0.071
v_s_m_per_s = 8.8e-4
delta = 2.0
sigma1_s_per_m = 20.0
sigma2_n_s_per_m = 270.0
v_d_m_per_s = 1.4e-3
[exciter]
position_m = 0.21
[sensors]
position_m = [0.095, 0.339, 0.576, 0.783]
noise_std_m_per_s2 = 0.0187
[sampling]
rate_hz = 8192.0
samples = 2048
[[run]]
frequency_hz = 196.9
preload_n = 158.0
force_amplitude_n = [0.14, 0.29, 0.59, 1.21, 2.48, 5.1, 10.5]
[[effect]]
id = "contact.tangential-stiffness/parallel"
stiffness_n_per_m = 2.7e6
"#;

/// On the contacts recovered with what the frequencies leave open a compliance in series does as well, and the whole model was asked with that alone: a support near
/// the end was named.
#[test]
fn every_form_of_a_spring_that_hides_is_asked() {
    let found = explained(measured(RIG, |_| {}));
    assert_eq!(named(&found), ["contact.tangential-stiffness"], "{:?}", found.notes);
    let stiffness = found.effects[0].parameters["parallel_stiffness"].value;
    // Three deviations of what the fit states.
    assert!((stiffness / 2.7e6 - 1.0).abs() < 0.02, "{stiffness}");
    let [before, after] = over_noise(&found);
    assert!(before > 2.0 && after < 1.05, "{before} {after}");
}
