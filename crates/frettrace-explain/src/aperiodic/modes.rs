//! Modes that the balance of runs without a period has calibrated, against those that were declared.

use super::WholeOutcome;
use crate::effects::EffectPlace;
use crate::verdict::{DEVIATES, Verdict};
use crate::{Case, DeclaredModes};

/// An outcome of runs whose balance closes with the modes of a case, where `declared` ones were stated: with a mode farther from these than
/// four standard deviations of both, the structure lacks what has no name.
#[must_use]
pub fn beside_declared(case: &Case, declared: &DeclaredModes, mut outcome: WholeOutcome) -> WholeOutcome {
    let found = &case.modes;
    let pairs = [
        (
            "natural frequency",
            &declared.frequency,
            &declared.frequency_std,
            &found.frequency,
            &found.frequency_std,
        ),
        ("damping ratio", &declared.damping, &declared.damping_std, &found.damping, &found.damping_std),
    ];
    let mut strained = Vec::new();
    for (name, stated, stated_std, told, told_std) in pairs {
        let values = stated.iter().zip(stated_std).zip(told.iter().zip(told_std)).take(declared.measured);
        for (mode, ((stated, about), (told, accuracy))) in values.enumerate() {
            let off = (told - stated).abs() / about.hypot(*accuracy).max(f64::MIN_POSITIVE);
            if off > DEVIATES {
                let percent = 100.0 * (told / stated - 1.0);
                strained
                    .push(format!("{name} of mode {} by {percent:+.2} % ({off:.0} deviations)", mode + 1));
            }
        }
    }
    if strained.is_empty() || outcome.verdict == Verdict::Unexplained {
        return outcome;
    }
    let note = format!("the balance closes with other modes than were declared: {}", strained.join(", "));
    outcome.left_open(EffectPlace::Structure, note);
    outcome
}
