//! Two effects at once on the demonstration rig, and one that two had been named for.

mod answers;
mod demonstration;

use answers::{explained, named, over_noise};
use demonstration::measured;

const RUBBING: &str = "[[effect]]\nid = \"structure.second-support/rubbing\"\nposition_m = 0.28\nlevel_n = 0.4\nvelocity_m_per_s = 5e-3\n";

/// A support that rubs, `0.4 N tanh(v/5 mm/s)`, alone and beside a contact that stiffens. In the largest run the beam is a hundred times as fast
/// there as the friction turns in, and in the smallest about as fast: the values are those of the simulator to three deviations, and no second name
/// stands for what they are not.
#[test]
fn a_support_that_rubs_is_all_that_is_named_for_it() {
    let stiffening = "[[effect]]\nid = \"contact.normal-stiffening\"\ncubic_n_per_m3 = 1e16\n";
    let both = ["structure.second-support", "contact.normal-stiffening"];
    for (effects, names) in [(RUBBING.to_owned(), &both[..1]), (RUBBING.to_owned() + stiffening, &both[..])] {
        let found = explained(measured(&effects, 0.5, |_| {}));
        assert_eq!(named(&found), names);
        let values = &found.effects[0].parameters;
        for (name, truth) in [("friction_force", 0.4), ("position", 0.28), ("transition_velocity", 5e-3)] {
            let estimate = &values[name];
            let off = (estimate.value - truth).abs();
            assert!(off < 3.0 * estimate.std && off < 0.01 * truth, "{name} {}", estimate.value);
        }
        let [_, after] = over_noise(&found);
        assert!(after < 1.03, "{after}");
    }
}

/// A channel with a slow amplifier beside a spring in the contact that leaves the model at three hundred times the noise: the channel is told by the
/// balance, which no law takes part in, and brings the whole model no nearer by itself. The simulator marches, with other formulas of both.
#[test]
fn an_effect_outside_the_contact_is_told_beside_a_stronger_one_in_it() {
    let effects = "[[effect]]\nid = \"contact.tangential-stiffness/parallel\"\nstiffness_n_per_m = 1.6e6\n[[effect]]\nid = \"measurement.delay/low-pass\"\nsensor = 2\ntime_s = 1.3e-4\n";
    let found = explained(measured(effects, 1.0, |_| {}));
    assert_eq!(named(&found), ["measurement.delay", "contact.tangential-stiffness"]);
    let sensors: Vec<Option<usize>> = found.effects.iter().map(|effect| effect.sensor).collect();
    assert_eq!(sensors, [Some(2), None]);
    let [before, after] = over_noise(&found);
    assert!(before > 100.0 && after < 1.1, "{before} {after}");
}
