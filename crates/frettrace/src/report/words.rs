//! Findings in words: the verdict in one sentence, effects by what they do.

use crate::results::{Control, Effect, Explanation, Place, Question, Verdict};

/// What an effect id means, for a person who does not know the ids.
#[must_use]
pub fn meaning(id: &str) -> &'static str {
    match id {
        "friction.stribeck" => "friction that falls as the slip gets faster (Stribeck effect)",
        "friction.viscous" => "viscous friction, which grows with slip velocity",
        "friction.lag" => "friction that follows the slip velocity late",
        "friction.film" => "a lubricant film with dynamics of its own",
        "friction.ageing" => "a contact that strengthens while it sticks",
        "friction.asymmetry" => "friction that differs between the two directions of slip",
        "friction.breakaway" => "an elastic share of the displacement before sliding",
        "friction.exponent" => "another transition from sticking to sliding",
        "friction.presliding-damping" => "damping before sliding",
        "friction.position" => "friction that depends on the position of the contact",
        "friction.position-periodic" => "friction that is periodic in the position of the contact",
        "friction.normal-dependence" => "friction that is not proportional to the normal force",
        "friction.wear" => "friction that changes as work is done in the contact",
        "contact.lift-off" => "a contact that lifts off",
        "contact.normal-stiffening" => "a contact that stiffens as it is pressed",
        "contact.tangential-stiffness" => "a tangential spring in the contact",
        "contact.backlash" => "play in the contact",
        "structure.cubic-stiffness" => "a stiffness that grows with the square of the displacement",
        "structure.quadratic-damping" => "damping that grows with the square of the velocity",
        "structure.clamp-compliance" => "a clamp that gives way",
        "structure.added-mass" => "a mass on the beam",
        "structure.second-support" => "a second contact along the beam",
        "structure.modal-frequency" => "natural frequencies other than declared",
        "structure.modal-damping" => "damping other than declared",
        "structure.frequency-drift" => "natural frequencies that drift from run to run",
        "excitation.preload-modulation" => "a preload that the exciter modulates",
        "excitation.base-motion" => "a clamp that moves",
        "measurement.gain" => "a sensor with another gain",
        "measurement.delay" => "a sensor that is late",
        "measurement.hum" => "mains hum in a sensor",
        "measurement.clipping" => "a sensor that clips",
        "measurement.position" => "a sensor at another place than declared",
        "measurement.dropout" => "a sensor that drops out",
        "measurement.offset" => "a sensor with an offset",
        _ => "an effect outside the standard list",
    }
}

/// A relative error as a percentage with three digits.
#[must_use]
pub fn percent(value: f64) -> String {
    let value = 100.0 * value;
    if !value.is_finite() {
        return "unknown".into();
    }
    let decimals = if value.abs() >= 10.0 { 1 } else { 2 };
    format!("{value:.decimals$} %")
}

/// A number with four significant digits.
#[must_use]
pub fn number(value: f64) -> String {
    if !value.is_finite() {
        return if value == f64::INFINITY {
            "∞".into()
        } else if value == f64::NEG_INFINITY {
            "−∞".into()
        } else {
            "?".into()
        };
    }
    let size = value.abs();
    if size == 0.0 {
        "0".into()
    } else if (1e-2..1e5).contains(&size) {
        let decimals = (3.0 - size.log10().floor()).clamp(0.0, 6.0) as usize;
        format!("{value:.decimals$}")
    } else {
        format!("{value:.3e}")
    }
}

/// What a control asks.
#[must_use]
pub fn question(control: &Control) -> String {
    match control.question {
        Question::Surrogate => "declared model and new noise".into(),
        Question::LeftOut => "these data, without that name in the list".into(),
        Question::Injection => {
            let share = percent(control.share.unwrap_or(1.0));
            format!("the effect at {share} of its size and new noise")
        }
    }
}

/// What a control answered, and whether that is right.
#[must_use]
pub fn answer(control: &Control) -> String {
    let found = match control.verdict {
        Verdict::NothingMissing => "nothing missing".to_owned(),
        Verdict::Explained => control.named.join(", "),
        Verdict::Unexplained => format!("something {} in no list", place(control.place)),
    };
    format!("{found}: {}", if control.right { "right" } else { "not right" })
}

/// The verdict in one sentence.
#[must_use]
pub fn verdict(found: &Explanation) -> String {
    match found.verdict {
        Verdict::NothingMissing => {
            format!("Nothing is missing from the declared model ({}): {}.", found.baseline.law, fall(found))
        }
        Verdict::Explained => {
            let effects: Vec<_> = found.effects.iter().map(effect).collect();
            format!(
                "The declared model ({}) lacks {}: {}.",
                found.baseline.law,
                effects.join(", and "),
                fall(found)
            )
        }
        Verdict::Unexplained => {
            let effects: Vec<_> = found.effects.iter().map(effect).collect();
            let known =
                if effects.is_empty() { String::new() } else { format!("{}, and ", effects.join(", and ")) };
            let more = if effects.is_empty() { "something" } else { "something more" };
            format!(
                "The declared model ({}) lacks {known}{more} {} that is in no list: {}.",
                found.baseline.law,
                place(found.place),
                fall(found)
            )
        }
    }
}

fn effect(effect: &Effect) -> String {
    let mut text = format!("{}, {}", effect.id, meaning(&effect.id));
    if let Some(position) = effect.position_m {
        text += &format!(", at {position:.4} m");
    }
    if let Some(sensor) = effect.sensor {
        text += &format!(", in sensor {sensor}");
    }
    if !effect.indistinguishable_from.is_empty() {
        text += &format!(" (these data cannot tell it from {})", effect.indistinguishable_from.join(" or "));
    }
    text
}

fn place(place: Option<Place>) -> &'static str {
    match place {
        Some(Place::Contact) => "in the contact",
        Some(Place::Structure) => "in the structure",
        Some(Place::Excitation) => "in the excitation",
        Some(Place::Measurement) => "in the measurement chain",
        None => "at an unknown place",
    }
}

/// Whether motion and force were measured in the contact itself, so that nothing had to be recovered.
pub(super) fn is_contact_record(found: &Explanation) -> bool {
    found.exhibits.contact_is_measured
}

/// Error before over error after up to which runs show nothing of an effect.
const UNMOVED: f64 = 1.001;

/// How the error falls, on held-out runs where there are some.
fn fall(found: &Explanation) -> String {
    let (error, runs) = match &found.held_out {
        Some(held_out) => (held_out, "runs that nothing was fitted to"),
        None => (&found.error, "the fitted runs (too few to hold any out)"),
    };
    let floor = percent(error.noise_floor);
    let named = !found.effects.is_empty() || found.verdict == Verdict::Explained;
    if named && error.before <= UNMOVED * error.after {
        // Runs without a period, of which no waveform is predicted, may be the only ones that show an effect.
        format!(
            "the error on {runs} stays at {} (noise {floor}), for they show nothing of it",
            percent(error.after)
        )
    } else if named {
        format!(
            "the error on {runs} falls from {} to {} (noise {floor})",
            percent(error.before),
            percent(error.after)
        )
    } else {
        format!("the error on {runs} is {} (noise {floor})", percent(error.after))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::results::BeforeAfter;

    fn found(verdict: Verdict) -> Explanation {
        let held_out =
            BeforeAfter { before: 0.08, after: 0.0123, noise_floor: 0.012, ..BeforeAfter::default() };
        let mut found = Explanation { verdict, held_out: Some(held_out), ..Explanation::default() };
        found.baseline.law = "dahl".into();
        found
    }

    /// Every verdict says what it is about and gives the figures it rests on.
    #[test]
    fn the_sentence_carries_the_figures() {
        let mut explained = found(Verdict::Explained);
        explained.effects.push(Effect {
            id: "structure.added-mass".into(),
            position_m: Some(0.25),
            ..Effect::default()
        });
        assert_eq!(
            verdict(&explained),
            "The declared model (dahl) lacks structure.added-mass, a mass on the beam, at 0.2500 m: the error on \
             runs that nothing was fitted to falls from 8.00 % to 1.23 % (noise 1.20 %)."
        );
        assert!(verdict(&found(Verdict::NothingMissing)).contains("is 1.23 % (noise 1.20 %)"));
        let mut open = Explanation { place: Some(Place::Contact), ..found(Verdict::Unexplained) };
        assert!(verdict(&open).contains("something in the contact that is in no list"));
        open.effects = vec![Effect { id: "contact.backlash".into(), ..Effect::default() }];
        let partly = verdict(&open);
        assert!(partly.contains("contact.backlash") && partly.contains("something more in the contact"));
        assert!(partly.contains("8.00 %") && partly.contains("1.23 %"), "{partly}");
    }

    /// An undefined error is never printed as a number.
    #[test]
    fn an_undefined_error_is_unknown() {
        assert_eq!(percent(f64::NAN), "unknown");
        assert_eq!(percent(0.1234), "12.3 %");
    }
}
