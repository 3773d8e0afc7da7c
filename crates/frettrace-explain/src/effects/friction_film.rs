//! `friction.film`.
//!
//! *Adds*: a film that builds up with speed and breaks down at rest, with its own times, and lowers friction while it stands.
//!
//! *Shows as*: friction that depends on how long the contact has been sliding within the cycle.
//!
//! *Mistaken for*: `friction.lag`, `friction.stribeck`; told apart by a pause before each run: a film that has collapsed gives the first cycles more friction.

use super::{Change, ContactForm, Effect, EffectPlace};
use crate::Scales;
use frettrace_friction::effects::{Hook, ModifiedLaw};

pub(super) struct FrictionFilm;

impl Effect for FrictionFilm {
    fn id(&self) -> &'static str {
        "friction.film"
    }

    fn place(&self) -> EffectPlace {
        EffectPlace::Contact
    }

    fn rivals(&self) -> &'static [&'static str] {
        &["friction.lag", "friction.stribeck"]
    }

    fn experiment(&self) -> &'static str {
        "a pause before each run: a film that has collapsed gives the first cycles more friction"
    }

    fn contact_forms(&self, _law: &ModifiedLaw<f64>, scales: &Scales) -> Vec<ContactForm> {
        let mut forms = Vec::new();
        for speed in [0.2, 0.7] {
            for share in [0.03, 0.2] {
                let film = |shapes: &[(Hook, f64, (f64, f64))], falls: bool| {
                    let mut changes = vec![
                        Change::between(Hook::FilmLoss, 0.2, (0.0, 0.95)),
                        Change::positive(Hook::FilmVelocity, speed * scales.velocity, 1e-2),
                        Change::positive(Hook::FilmRise, share * scales.period, 1e-4),
                    ];
                    if falls {
                        changes.push(Change::positive(Hook::FilmFall, share * scales.period, 1e-4));
                    }
                    let shape = |&(hook, start, bounds)| Change::between(hook, start, bounds);
                    changes.extend(shapes.iter().map(shape));
                    ContactForm::new(changes)
                };
                let [smooth, blended] =
                    [(Hook::FilmExponent, 1.0, (0.3, 4.0)), (Hook::FilmRational, 0.5, (0.0, 1.0))];
                forms.extend([film(&[], true), film(&[smooth], true)]);
                if share > 0.1 {
                    forms.extend([film(&[], false), film(&[smooth, blended], true)]);
                }
            }
        }
        forms
    }
}
