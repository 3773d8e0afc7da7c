//! A beam that turns over a support which does not give: the reaction there loads and relieves the contact all the same.
#![expect(clippy::unwrap_used, reason = "helpers of tests may unwrap")]

use frettrace::Progress;
use frettrace::explain::{ExplainOptions, explain};
use frettrace::results::{Explanation, Verdict};
use frettrace::rig::parse_rig;
use frettrace::simulate::simulate;
use frettrace_measurement::Recording;
use std::path::Path;

const RIG: &str = include_str!("../../../data/demo/rig.toml");

/// The demonstration rig on a pin, at half its forces, with other effects. In the largest run its normal force swings from −31 to 163 N about 65 N.
fn explained(effects: &str) -> Explanation {
    let pinned = RIG
        .split("[[effect]]")
        .next()
        .unwrap()
        .replace("normal_stiffness_n_per_m = 4.0e6", "normal_stiffness_n_per_m = inf")
        .replace("[0.6, 0.8, 1.1, 1.5, 2.1, 3.0, 4.2, 6.0]", "[0.3, 0.4, 0.55, 0.75, 1.05, 1.5, 2.1, 3.0]");
    let quiet = Progress::silent();
    let made = simulate(&parse_rig(&(pinned + effects), Path::new("rig.toml")).unwrap(), &quiet).unwrap();
    assert!(made.measurement.support.normal_stiffness.is_infinite());
    explain(&Recording::Measurement(made.measurement), &ExplainOptions::default(), &quiet).unwrap()
}

/// Nothing is missing where the rig lacks nothing. With the normal force held at its preload the declared model missed it by eight times the noise.
#[test]
fn a_pinned_rig_lacks_nothing() {
    let found = explained("");
    assert_eq!(found.verdict, Verdict::NothingMissing);
    let held_out = found.held_out.unwrap();
    assert!(held_out.after < 1.03 * held_out.noise_floor, "{held_out:?}");
}

/// A spring in series with the bristle, of which the pressure of the contact decides how much it gives.
#[test]
fn a_spring_is_found_on_a_pinned_rig() {
    let found = explained(
        "[[effect]]\nid = \"contact.tangential-stiffness/series\"\nseries_stiffness_n_per_m = 3e7\n",
    );
    let named: Vec<&str> = found.effects.iter().map(|effect| effect.id.as_str()).collect();
    assert_eq!(named, ["contact.tangential-stiffness"]);
    let estimate = &found.effects[0].parameters["series_compliance"];
    let [low, high] = estimate.interval95;
    assert!(low < 1.0 / 3e7 && 1.0 / 3e7 < high && high - low < 0.2 / 3e7, "{low} {high}");
}
