//! Effects in formulas that the model that explains does not have, on the demonstration rig.

mod answers;
mod demonstration;

use answers::{explained, named, over_noise};
use demonstration::measured;

/// The name is the claim, and not the formula: a viscous force that follows the inverse hyperbolic sine of the speed (Eyring), a channel with two slow stages,
/// a stop along the beam that touches softly, a curve with an exponent of its own that lags on a law without one.
#[test]
fn another_laboratorys_formula_has_the_effects_name() {
    for effect in [
        "friction.viscous/eyring\"\nforce_n = 4.0\nvelocity_m_per_s = 0.004",
        "measurement.delay/two-low-passes\"\nsensor = 2\ntime_s = 1.3e-4",
        "structure.second-support/smooth\"\nposition_m = 0.3\nstiffness_n_per_m = 4e4\ngap_m = 2e-5\nsmoothness_m = 1e-5",
        "friction.lag\"\ntime_s = 2e-3\nmu_s = 0.36\nv_s_m_per_s = 2e-3\ndelta = 1.0",
    ] {
        let found = explained(measured(&("[[effect]]\nid = \"".to_owned() + effect), 1.0, |_| {}));
        assert_eq!(named(&found), [effect.split(['/', '"']).next().unwrap()], "{effect}");
        let [before, after] = over_noise(&found);
        assert!(before > 1.5 && after < 1.1, "{effect}: {before} {after}");
    }
}

/// A spring beside the contact, 270 times as soft as its bristles: the recovered contacts take it for another frequency, within what is declared of
/// the modes. It had been named a mass of −0.2 g on the beam.
#[test]
fn a_weak_spring_beside_the_contact_is_no_mass() {
    let spring = "[[effect]]\nid = \"contact.tangential-stiffness/parallel\"\nstiffness_n_per_m = 1e5\n";
    let found = explained(measured(spring, 1.0, |_| {}));
    assert_eq!(named(&found), ["contact.tangential-stiffness"]);
    let [low, high] = found.effects[0].parameters["parallel_stiffness"].interval95;
    assert!(low < 1e5 && 1e5 < high && high - low < 5e4, "{low} {high}");
}
