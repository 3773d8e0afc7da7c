//! Rules of the evidence on plain numbers: what a name may leave, what held-out runs must say, and where something stays.

use super::{CONTRADICTED, FORETOLD, HELD_OUT, HELD_OUT_SHARE};
use crate::left::LeftLines;
use crate::search::{DOMINANT, OTHER_FORMULA, REST, RIVALS, excess};

/// Share of what a closed balance holds beside the noise that one more free value a line may leave, where it is the place of what is
/// missing.
const TAKEN: f64 = 0.5;

/// Standard deviations of χ² below which what two formulas leave is not told apart.
const CHANCES: f64 = 1.0;

/// Factor by which what is left at one sensor must exceed what is left at the others.
const ALONE: f64 = 10.0;

/// Whether a known rival may be what acts: the name's formula is in doubt, since it leaves more than the noise of the lines or does not
/// foretell the runs held out, and the rival leaves on the lines, beside their noise, less than ten times as much. Evidence between
/// two formulas that are both another laboratory's says nothing of the names.
pub(super) fn may_be(rival: f64, own: LeftLines, foretold: bool) -> bool {
    let exact = own.is_noise() && foretold;
    !exact && rival < RIVALS * own.excess().max(CHANCES * own.chance())
}

/// Whether runs that nothing was fitted to are better off: by standard errors of their improvement, and by a real share of what was missing
/// in them, told from their error over the noise before and after.
pub(super) fn helps(improvement: f64, [before, after]: [f64; 2]) -> bool {
    improvement > HELD_OUT && excess(after) <= HELD_OUT_SHARE * excess(before)
}

/// Whether a name, whose model follows the runs that it was fitted to, is not contradicted by those held out: their error over the noise
/// before and after. Beside the noise it may leave what the fitted values are uncertain by, more where that is a hundredth of what was
/// missing in them, and any where it is a trace of that.
pub(super) fn is_followed(before: f64, after: f64) -> bool {
    let left = excess(after) / excess(before);
    after <= FORETOLD || after <= CONTRADICTED && left <= REST || left <= DOMINANT
}

/// Whether one of two effects takes, in runs held out, what is missing there without it: all but a hundredth, from their error over the noise
/// without it and with both.
pub(super) fn takes_its_own(before: f64, after: f64) -> bool {
    excess(after) <= REST * excess(before)
}

/// Whether runs held out are as near to a name with another formula as those that it was fitted to must be: their error over the noise before
/// and after, within three times the noise and a hundredth of what was missing in them, or a thousandth of that.
pub(super) fn is_as_near(before: f64, after: f64) -> bool {
    let left = excess(after) / excess(before);
    after <= OTHER_FORMULA && left <= REST || left <= DOMINANT
}

/// Whether a mechanism that is there may leave that: on the lines, and as a share of what was missing in all samples, from the excess before
/// and after.
pub(super) fn takes_all(left: LeftLines, [before, after]: [f64; 2]) -> bool {
    left.is_near_noise() || after <= REST * before
}

/// Whether two effects that are told in the same way may both be there: nothing but what they leave speaks for both. The lines hold noise, or no more than that beside it
/// where they take all but a hundredth of what was missing in all samples, from the excess before and after.
pub(super) fn takes_both(left: LeftLines, [before, after]: [f64; 2]) -> bool {
    left.is_noise() || left.is_near_noise() && after <= REST * before
}

/// Whether what a closed balance holds beside the noise stays where one more value a line is free: χ² per degree of freedom without and
/// with it.
pub(super) fn stays_with_contact(reduced: f64, left: f64) -> bool {
    left - 1.0 > TAKEN * (reduced - 1.0)
}

/// Whether what is left is left at one sensor: more than chance brings, and far more than at the others, so that the model of the rig has no
/// part in it.
pub(super) fn stays_with_sensor([own, others]: [LeftLines; 2]) -> bool {
    !own.is_noise() && own.excess() > ALONE * others.excess().max(others.chance())
}

#[cfg(test)]
mod tests {
    use super::{
        is_as_near, is_followed, may_be, stays_with_contact, stays_with_sensor, takes_all, takes_both,
        takes_its_own,
    };
    use crate::left::LeftLines;

    /// χ² and residuals at the sensor with a named gain, and at the others, of three simulated rigs where that sensor hears another one;
    /// then of the noise alone, of a model that misses all sensors, and of what chance may leave at one.
    #[test]
    fn what_a_gain_leaves_at_its_sensor_alone_is_another_fault() {
        let left = |[own, others]: [[f64; 2]; 2]| {
            [own, others].map(|[chi_squared, count]| LeftLines { chi_squared, count })
        };
        for alone in [
            [[3692.0, 480.0], [2365.0, 2400.0]],
            [[518.0, 176.0], [1054.0, 1056.0]],
            [[3682.0, 296.0], [2780.0, 1480.0]],
        ] {
            assert!(stays_with_sensor(left(alone)), "{alone:?}");
        }
        for other in [
            [[480.0, 480.0], [2400.0, 2400.0]],
            [[900.0, 480.0], [3500.0, 2400.0]],
            [[530.0, 480.0], [2400.0, 2400.0]],
        ] {
            assert!(!stays_with_sensor(left(other)), "{other:?}");
        }
    }

    /// χ² over residuals, these, and the excess of all samples before and after, of simulated rigs: what two effects that were there leave in other laboratories' formulas
    /// (waves of straight lines with a spring, an asymmetry with a viscous power); what stands in for a clamp that gives (a mass and a sensor off its place), for a spring that
    /// stiffens one way (a support and a mass taken away) and for an ageing contact (a film on a Stribeck curve).
    #[test]
    fn two_effects_told_in_the_same_way_leave_nothing() {
        let left = |excess: f64, count: f64| LeftLines { chi_squared: (1.0 + excess) * count, count };
        assert!(takes_both(left(0.3995, 5512.0), [7424.8, 0.01998]));
        assert!(takes_both(left(0.1935, 7116.0), [29.5, 0.0]));
        assert!(!takes_both(left(0.8320, 990.0), [2.509, 0.03339]));
        assert!(!takes_both(left(1.4653, 1050.0), [3.832, 0.02634]));
        assert!(!takes_both(left(5.1697, 1568.0), [424.2, 0.04640]));
    }

    /// χ² and residuals of a film, and what a lag leaves beside the noise, on a simulated rig with a lag of bounded rate: both follow the
    /// fitted runs, and miss those held out by a tenth. A film that foretells them rules the lag out, and so does one
    /// that leaves a tenth as much.
    #[test]
    fn a_formula_in_doubt_does_not_rule_its_rivals_out() {
        let left = |chi_squared: f64| LeftLines { chi_squared, count: 1400.0 };
        assert!(may_be(0.175, left(1616.4), false));
        assert!(!may_be(0.175, left(1616.4), true));
        assert!(may_be(0.175, left(1700.0), true));
        assert!(!may_be(1.7, left(1616.4), false));
    }

    /// Held-out errors over the noise of simulated rigs: quadratic damping, taken from the list, leaves viscous friction as what is
    /// nearest to it (two rigs); presliding damping and asymmetry with another formula are what acts.
    #[test]
    fn a_name_that_misses_held_out_runs_took_all_but_a_trace() {
        assert!(!is_followed(8.154, 1.149));
        assert!(!is_followed(19.615, 1.290));
        assert!(is_followed(271.654, 1.145));
        assert!(is_followed(65.799, 1.058));
    }

    /// The same of the lesser of two effects, on simulated rigs: presliding damping beside a modulated preload, asymmetry beside a spring, a wave
    /// along the path in another formula beside a change there; and a tangential spring that stood in for one on the beam.
    #[test]
    fn the_lesser_of_two_effects_takes_its_own() {
        for [before, after] in [[12.80, 1.106], [20.23, 1.098], [39.29, 1.261]] {
            assert!(takes_its_own(before, after), "{before}");
        }
        assert!(!takes_its_own(4.21, 1.211));
    }

    /// The same with another formula: friction that changes along the path by a hyperbolic tangent, in a power law's place (a simulated rig), and the
    /// same error where a tenth as much was missing; a lag of bounded rate, and a spring beside the contact that took a drift's place.
    #[test]
    fn a_name_with_another_formula_leaves_a_trace_in_held_out_runs() {
        assert!(is_as_near(213.333, 3.86));
        assert!(!is_as_near(67.5, 3.86));
        assert!(is_as_near(47.884, 1.641));
        assert!(!is_as_near(6.496, 1.437));
    }

    /// The same of wear taken from the list, which a film stands in for, and of weak effects beside their own names: a cubic spring, a mode's
    /// damping.
    #[test]
    fn held_out_runs_leave_a_weak_name_no_more_than_its_values_are_uncertain_by() {
        assert!(!is_followed(1.522, 1.074));
        assert!(is_followed(1.321, 1.018));
        assert!(is_followed(1.126, 1.002));
    }

    /// χ² per residual and count of the lines, and share of the excess, of simulated rigs. Taken from the list: square damping twice (a second
    /// support), an even spring (a second support and a mode), a spring in series (an exponent). Named right: a mode's damping,
    /// a smooth asymmetry, ageing, Stribeck friction on the rig of another simulator.
    #[test]
    fn a_name_leaves_noise_or_a_trace() {
        let left = |per_residual: f64, count: f64| LeftLines { chi_squared: per_residual * count, count };
        for (per_residual, count, share) in [
            (2.440, 2304.0, 0.0575),
            (3.664, 10990.0, 0.593),
            (2.466, 5088.0, 0.2135),
            (3.188, 4040.0, 0.290),
        ] {
            assert!(!takes_all(left(per_residual, count), [1.0, share]), "{per_residual}");
        }
        for (per_residual, count, share) in
            [(0.944, 2304.0, 0.0), (1.300, 610.0, 0.0), (1.664, 1736.0, 0.0049), (2.976, 4928.0, 0.0)]
        {
            assert!(takes_all(left(per_residual, count), [1.0, share]), "{per_residual}");
        }
    }

    /// χ² per degree of freedom of the balance of two simulated rigs with an even spring on the beam, by itself and beside a force there; and
    /// a noise that is declared a tenth too small.
    #[test]
    fn a_balance_that_is_all_but_closed_may_still_tell_the_place() {
        assert!(!stays_with_contact(1.215, 0.969));
        assert!(!stays_with_contact(1.300, 0.875));
        assert!(stays_with_contact(1.21, 1.21));
    }
}
