//! Two effects at once on the demonstration rig.

use frettrace::Progress;
use frettrace::explain::{ExplainOptions, explain};
use frettrace::rig::parse_rig;
use frettrace::simulate::simulate;
use frettrace_measurement::Recording;
use std::path::Path;

const RIG: &str = include_str!("../../../data/demo/rig.toml");

/// A channel with a slow amplifier beside a spring in the contact that leaves the model at three hundred times the noise: the channel is told by the
/// balance, which no law takes part in, and brings the whole model no nearer by itself. The simulator marches, with other formulas of both.
#[test]
fn an_effect_outside_the_contact_is_told_beside_a_stronger_one_in_it() {
    let rig = RIG.split("[[effect]]").next().unwrap().to_owned()
        + "[[effect]]\nid = \"contact.tangential-stiffness/parallel\"\nstiffness_n_per_m = 1.6e6\n"
        + "[[effect]]\nid = \"measurement.delay/low-pass\"\nsensor = 2\ntime_s = 1.3e-4\n";
    let quiet = Progress::silent();
    let made = simulate(&parse_rig(&rig, Path::new("rig.toml")).unwrap(), &quiet).unwrap();
    let recording = Recording::Measurement(made.measurement);
    let found = explain(&recording, &ExplainOptions::default(), &quiet).unwrap();
    let named: Vec<(&str, Option<usize>)> =
        found.effects.iter().map(|effect| (effect.id.as_str(), effect.sensor)).collect();
    assert_eq!(named, [("measurement.delay", Some(2)), ("contact.tangential-stiffness", None)]);
    let held_out = found.held_out.unwrap();
    let [before, after] = [held_out.before, held_out.after].map(|error| error / held_out.noise_floor);
    assert!(before > 100.0 && after < 1.1, "{before} {after}");
}
