//! Two effects at once on the demonstration rig.
#![expect(clippy::unwrap_used, reason = "helpers of tests may unwrap")]

use frettrace::Progress;
use frettrace::explain::{ExplainOptions, explain};
use frettrace::results::Explanation;
use frettrace::rig::parse_rig;
use frettrace::simulate::simulate;
use frettrace_measurement::Recording;
use std::path::Path;

const RIG: &str = include_str!("../../../data/demo/rig.toml");

/// The demonstration rig at half its forces, so that its contact stays closed, with other effects.
fn explained(effects: &str) -> Explanation {
    let levels = ["[0.6, 0.8, 1.1, 1.5, 2.1, 3.0, 4.2, 6.0]", "[0.3, 0.4, 0.55, 0.75, 1.05, 1.5, 2.1, 3.0]"];
    let rig = RIG.split("[[effect]]").next().unwrap().replace(levels[0], levels[1]) + effects;
    let quiet = Progress::silent();
    let made = simulate(&parse_rig(&rig, Path::new("rig.toml")).unwrap(), &quiet).unwrap();
    explain(&Recording::Measurement(made.measurement), &ExplainOptions::default(), &quiet).unwrap()
}

fn named(found: &Explanation) -> Vec<&str> {
    found.effects.iter().map(|effect| effect.id.as_str()).collect()
}

const RUBBING: &str = "[[effect]]\nid = \"structure.second-support/rubbing\"\nposition_m = 0.28\nlevel_n = 0.4\nvelocity_m_per_s = 5e-3\n";

/// A support that rubs, `0.4 N tanh(v/5 mm/s)`, alone and beside a contact that stiffens. In the largest run the beam is a hundred times as fast
/// there as the friction turns in, and in the smallest about as fast: the values are those of the simulator to three deviations, and no second name
/// stands for what they are not.
#[test]
fn a_support_that_rubs_is_all_that_is_named_for_it() {
    let stiffening = "[[effect]]\nid = \"contact.normal-stiffening\"\ncubic_n_per_m3 = 1e16\n";
    let both = ["structure.second-support", "contact.normal-stiffening"];
    for (effects, names) in [(RUBBING.to_owned(), &both[..1]), (RUBBING.to_owned() + stiffening, &both[..])] {
        let found = explained(&effects);
        assert_eq!(named(&found), names);
        let values = &found.effects[0].parameters;
        for (name, truth) in [("friction_force", 0.4), ("position", 0.28), ("transition_velocity", 5e-3)] {
            let estimate = &values[name];
            let off = (estimate.value - truth).abs();
            assert!(off < 3.0 * estimate.std && off < 0.01 * truth, "{name} {}", estimate.value);
        }
        let held_out = found.held_out.unwrap();
        assert!(held_out.after < 1.03 * held_out.noise_floor, "{held_out:?}");
    }
}

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
