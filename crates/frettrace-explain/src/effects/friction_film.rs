//! `friction.film`.
//!
//! *Adds*: a film that builds up with speed and breaks down at rest, with its own times, and lowers friction while it stands.
//!
//! *Shows as*: friction that depends on how long the contact has been sliding within the cycle.
//!
//! *Mistaken for*: `friction.lag`, `friction.stribeck`; told apart by a pause before each run: a film that has collapsed gives the first cycles more friction.

use super::{Change, ContactForm, Effect, EffectPlace, Simpler, known};
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

    /// Without its memory the film `h = 1 − w` is a Stribeck curve, `μ(1 − βh) = μ(1 − β) + μβw`. Where the film needs as long to build up as to break
    /// down, that curve, or one that the law has of its own and that the film has made idle, lags behind as much.
    fn simpler(&self, law: &ModifiedLaw<f64>, _scales: &Scales) -> Vec<Simpler> {
        let value = |hook| law.get(hook).unwrap_or_default();
        let (mu, loss) = (value(Hook::MuKinetic), value(Hook::FilmLoss).clamp(1e-3, 0.95));
        // `1 − x^{2/3}` falls to 1/e at half the velocity of a whole film.
        let (share, exponent) = law.get(Hook::FilmExponent).map_or((0.5, 0.8), |exponent| (1.0, exponent));
        let rise = value(Hook::FilmRise);
        let time = (rise * law.get(Hook::FilmFall).unwrap_or(rise)).sqrt();
        let lag = Change::positive(Hook::LagTime, time, 1e-3);
        let mut plain = *law;
        OWN.iter().for_each(|&hook| plain.clear(hook));
        if known(law, &[Hook::StribeckRise]) {
            let rest = mu + value(Hook::StribeckRise);
            let curve = [
                (Hook::MuKinetic, rest * (1.0 - loss)),
                (Hook::StribeckRise, rest * loss),
                (Hook::StribeckVelocity, share * value(Hook::FilmVelocity)),
                (Hook::StribeckExponent, exponent),
            ];
            curve.into_iter().for_each(|(hook, value)| plain.set(hook, value));
            let changes = vec![lag];
            return vec![Simpler { id: "friction.lag", law: plain, changes }];
        }
        plain.set(Hook::MuKinetic, mu * (1.0 - loss));
        let curve = vec![
            Change::positive(Hook::StribeckRise, mu * loss, 1e-3),
            Change::positive(Hook::StribeckVelocity, share * value(Hook::FilmVelocity), 1e-3),
            Change::between(Hook::StribeckExponent, exponent, (0.4, 6.0)),
            Change::between(Hook::RationalShare, 0.5, (0.0, 1.0)),
        ];
        let lagging = curve.iter().cloned().chain([lag]).collect();
        vec![
            Simpler { id: "friction.stribeck", law: plain, changes: curve },
            Simpler { id: "friction.lag", law: plain, changes: lagging },
        ]
    }

    fn memories(&self) -> &'static [Hook] {
        &[Hook::FilmRise, Hook::FilmFall]
    }
}

/// What a film brings to a law.
const OWN: [Hook; 6] = [
    Hook::FilmLoss,
    Hook::FilmVelocity,
    Hook::FilmRise,
    Hook::FilmFall,
    Hook::FilmExponent,
    Hook::FilmRational,
];

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effects::Reach;
    use frettrace_friction::Step;
    use frettrace_friction::effects::Circumstance;

    /// Friction force at a steady speed, normal force 1: a way of 10⁴ times the presliding range from rest.
    fn steady(law: &ModifiedLaw<f64>, speed: f64) -> f64 {
        let circumstance = Circumstance { preload: 1.0, ..Circumstance::default() };
        let (mut state, mut force) = (law.rest_at(0.0), 0.0);
        for k in 0..1000 {
            let slip = [k, k + 1].map(|k| 1e-3 * f64::from(k));
            let step = Step { slip, velocity: [speed; 2], normal: [1.0; 2], dt: 1e-3 / speed };
            (state, force) = law.advance(state, &step, &circumstance);
        }
        force
    }

    /// At steady speeds a film is the Stribeck curve that it stands for, when that is not blended yet.
    #[test]
    fn a_film_without_memory_is_a_stribeck_curve() {
        let mut film = ModifiedLaw::dahl(1e5, 0.3);
        let values = [
            (Hook::FilmLoss, 0.4),
            (Hook::FilmVelocity, 0.02),
            (Hook::FilmRise, 1e-6),
            (Hook::FilmExponent, 1.3),
        ];
        values.into_iter().for_each(|(hook, value)| film.set(hook, value));
        let simpler = FrictionFilm.simpler(&film, &Scales::default());
        let [simpler, _] = &simpler[..] else { panic!("a curve, and one that lags") };
        assert_eq!(simpler.id, "friction.stribeck");
        let mut curve = simpler.law;
        simpler.changes.iter().for_each(|change| curve.set(change.hook, change.start));
        curve.set(Hook::RationalShare, 0.0);
        for speed in [2e-3, 0.02, 0.1] {
            let [film, curve] = [&film, &curve].map(|law| steady(law, speed));
            assert!((film - curve).abs() < 1e-8, "{speed}: {film} against {curve}");
        }
        let reach = |step| Reach { step, stroke: 1e-3 };
        assert!(FrictionFilm.is_idle(&film, reach(1e-5)) && !FrictionFilm.is_idle(&film, reach(1e-7)));
    }

    /// Friction force along `u = sin(t)/10`, normal force 1, in steps of 1/200.
    fn swinging(law: &ModifiedLaw<f64>) -> Vec<f64> {
        let circumstance = Circumstance { preload: 1.0, ..Circumstance::default() };
        let mut state = law.rest_at(0.0);
        let at = |k: u32| 5e-3 * f64::from(k);
        let mut advance = |k| {
            let [slip, velocity] = [f64::sin, f64::cos].map(|of| [k, k + 1].map(|k| 0.1 * of(at(k))));
            let step = Step { slip, velocity, normal: [1.0; 2], dt: 5e-3 };
            let (next, force) = law.advance(state, &step, &circumstance);
            state = next;
            force
        };
        (0..4000).map(&mut advance).collect()
    }

    /// A film that breaks down as fast as it builds up, in a law whose own Stribeck curve does nothing or that has none, is the lag of such a curve, once
    /// the states have forgotten where they began: ten seconds, twenty of their times.
    #[test]
    fn a_film_of_one_time_is_a_lag() {
        let mut film = ModifiedLaw::dahl(1e3, 0.2);
        let values = [
            (Hook::StribeckRise, 0.1),
            (Hook::StribeckVelocity, 1e9),
            (Hook::StribeckExponent, 2.0),
            (Hook::FilmLoss, 0.4),
            (Hook::FilmVelocity, 0.05),
            (Hook::FilmExponent, 1.3),
            (Hook::FilmRise, 0.5),
            (Hook::FilmFall, 0.5),
        ];
        values.into_iter().for_each(|(hook, value)| film.set(hook, value));
        let mut bare = film;
        let own = [Hook::StribeckRise, Hook::StribeckVelocity, Hook::StribeckExponent];
        own.iter().for_each(|&hook| bare.clear(hook));
        // A law without a curve of its own had no friction beside the film's: its level is that of the film and the idle curve together.
        bare.set(Hook::MuKinetic, 0.3);
        for film in [film, bare] {
            let simpler = FrictionFilm.simpler(&film, &Scales::default());
            let simpler = simpler.iter().find(|simpler| simpler.id == "friction.lag").unwrap();
            let mut lag = simpler.law;
            simpler.changes.iter().for_each(|change| lag.set(change.hook, change.start));
            if lag.get(Hook::RationalShare).is_some() {
                lag.set(Hook::RationalShare, 0.0);
            }
            for (film, lag) in swinging(&film).into_iter().zip(swinging(&lag)).skip(2000) {
                assert!((film - lag).abs() < 1e-6, "{film} against {lag}");
            }
        }
    }
}
