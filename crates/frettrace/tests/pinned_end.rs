//! A beam that turns over a support which does not give: the reaction there loads and relieves the contact all the same.

mod answers;
mod demonstration;

use answers::{explained, named, over_noise};
use demonstration::measured;
use frettrace::results::{Explanation, Verdict};

/// The demonstration rig on a pin. In the largest run its normal force swings from −31 to 163 N about 65 N.
fn on_a_pin(effects: &str) -> Explanation {
    let made = measured(effects, 0.5, |rig| rig.support.normal_stiffness_n_per_m = Some(f64::INFINITY));
    assert!(made.support.normal_stiffness.is_infinite());
    explained(made)
}

/// Nothing is missing where the rig lacks nothing. With the normal force held at its preload the declared model missed it by eight times the noise.
#[test]
fn a_pinned_rig_lacks_nothing() {
    let found = on_a_pin("");
    assert_eq!(found.verdict, Verdict::NothingMissing);
    let [_, after] = over_noise(&found);
    assert!(after < 1.03, "{after}");
}

/// A spring in series with the bristle, of which the pressure of the contact decides how much it gives.
#[test]
fn a_spring_is_found_on_a_pinned_rig() {
    let found = on_a_pin(
        "[[effect]]\nid = \"contact.tangential-stiffness/series\"\nseries_stiffness_n_per_m = 3e7\n",
    );
    assert_eq!(named(&found), ["contact.tangential-stiffness"]);
    let estimate = &found.effects[0].parameters["series_compliance"];
    let [low, high] = estimate.interval95;
    assert!(low < 1.0 / 3e7 && 1.0 / 3e7 < high && high - low < 0.2 / 3e7, "{low} {high}");
}
