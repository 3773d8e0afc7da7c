//! The form in which a name is taken, where the recovered contacts are far from every form of it.

mod answers;

use answers::{explained, measured, named, over_noise};

/// A tube whose end slides across its support, excited below and above the frequency of the first mode, with a film that needs 4 % of a period
/// to build up and 6 % to break down.
const RIG: &str = r#"
title = "a tube with a film in its support"
seed = 427852
[beam]
length_m = 0.609
width_m = 0.0148
thickness_m = 0.0148
area_m2 = 3.89e-5
second_moment_m4 = 9.49e-10
youngs_modulus_pa = 1.9e11
density_kg_per_m3 = 8400.0
[modes]
damping_ratio = [0.0088, 0.0071, 0.0079]
declared = 6
frequency_relative_std = 2.3e-4
damping_relative_std = 1.6e-3
[support]
slip = "transverse"
law = "dahl"
[support.parameters]
mu_k = 0.406
sigma0_per_m = 1123.0
exponent = 1.0
[exciter]
position_m = 0.395
[sensors]
position_m = [0.065, 0.109, 0.163, 0.279, 0.299, 0.381, 0.424, 0.528]
noise_std_m_per_s2 = 0.755
[sampling]
rate_hz = 1024.0
samples = 2048
[[run]]
frequency_hz = 26.575
preload_n = 58.68
force_amplitude_n = [14.81, 20.93, 29.6, 41.84, 59.16, 83.64, 118.2]
[[run]]
frequency_hz = 21.26
preload_n = 58.68
force_amplitude_n = [29.6, 41.84, 59.16, 83.64, 118.2]
[[effect]]
id = "friction.film"
loss = 0.1176
rise_time_s = 1.6e-3
fall_time_s = 2.364e-3
velocity_m_per_s = 4.747
"#;

/// With the structure as it is declared the recovered contacts leave every form of the film 230 times the noise, and one with an exponent of its own a
/// hundredth less than the true one: what tells the forms apart there is no evidence. The whole model tells them: in the other form it left 1.5
/// times the noise in the fitted runs and seven times in those held out, and the film had no name.
#[test]
fn forms_that_the_contacts_do_not_tell_apart_are_asked_of_the_whole_model() {
    let found = explained(measured(RIG, |_| {}));
    assert_eq!(named(&found), ["friction.film"], "{:?}", found.notes);
    for (name, value) in [("film_loss", 0.1176), ("film_rise_time", 1.6e-3), ("film_fall_time", 2.364e-3)] {
        let [low, high] = found.effects[0].parameters[name].interval95;
        assert!(low < value && value < high && high - low < 0.05 * value, "{name}: {low} {high}");
    }
    let [_, after] = over_noise(&found);
    assert!(after < 1.03, "{after}");
}
