//! `friction.position-periodic`.
//!
//! *Adds*: a friction coefficient periodic in slip, `μ(1 + Σ_k c_k cos kqu + s_k sin kqu)`, up to the third harmonic and as sharp as a triangle, or as
//! steep as a square, where the data ask for it; or a force `N(c cos qu + s sin qu)`, whichever way the contact moves.
//!
//! *Shows as*: ripples of the sliding branches at fixed positions.
//!
//! *Mistaken for*: `friction.position`; told apart by strokes of several lengths over the same track: the wave length stays, the harmonics move.

use super::{Change, ContactForm, Effect, EffectPlace, Reach, Simpler, known};
use crate::Scales;
use frettrace_friction::effects::{Hook, ModifiedLaw};

pub(super) struct FrictionPositionPeriodic;

impl Effect for FrictionPositionPeriodic {
    fn id(&self) -> &'static str {
        "friction.position-periodic"
    }

    fn place(&self) -> EffectPlace {
        EffectPlace::Contact
    }

    fn rivals(&self) -> &'static [&'static str] {
        &["friction.position"]
    }

    fn experiment(&self) -> &'static str {
        "strokes of several lengths over the same track: the wave length stays, the harmonics move"
    }

    fn contact_forms(&self, _law: &ModifiedLaw<f64>, scales: &Scales) -> Vec<ContactForm> {
        // Waves in the largest slip: neighbours are half a wave apart there, so that one of them is in the valley of the right one.
        let coefficient = [Hook::PeriodicCosine, Hook::PeriodicSine];
        // A force that holds in the valleys and pushes out of the hills, whichever way the contact moves.
        let lattice = [Hook::LatticeCosine, Hook::LatticeSine];
        let form = |shares: [Hook; 2], waves: f64| {
            let number =
                Change::positive(Hook::PeriodicNumber, std::f64::consts::TAU * waves / scales.slip, 0.02);
            let shares = shares.map(|hook| Change::linear(hook, 0.03, 0.05, (-0.9, 0.9)));
            ContactForm::new(shares.into_iter().chain([number]).collect())
        };
        let friction =
            [0.3, 0.6, 1.0, 1.5, 2.0, 2.5, 3.0, 3.5, 4.0].into_iter().map(|waves| form(coefficient, waves));
        friction.chain([0.6, 1.0, 2.0, 3.0].into_iter().map(|waves| form(lattice, waves))).collect()
    }

    fn shape(&self, _law: &ModifiedLaw<f64>, _scales: &Scales) -> Vec<Change> {
        [Hook::PeriodicCosine2, Hook::PeriodicSine2, Hook::PeriodicCosine3, Hook::PeriodicSine3]
            .map(|hook| Change::linear(hook, 0.0, 0.05, (-0.9, 0.9)))
            .into_iter()
            .chain([Change::between(Hook::PeriodicSharpness, 0.3, (0.01, 0.999))])
            .collect()
    }

    /// A wave that jumps from one level to the other, as grooves make it.
    fn other_shape(&self, law: &ModifiedLaw<f64>, _scales: &Scales) -> Vec<Change> {
        if !known(law, &[Hook::PeriodicCosine]) {
            return Vec::new();
        }
        // Between an arc tangent's corner and a sharp one.
        vec![
            Change::between(Hook::PeriodicSteepness, 1.5, (0.05, 50.0)),
            Change::between(Hook::PeriodicCorner, 2.0, (0.7, 8.0)),
        ]
    }

    /// A part of a wave of the friction coefficient, `c cos qu + s sin qu`, is a change along the path: its series up to `(qu)³`, or a change that ends
    /// at `1/q`. A part of a wave of the force is a spring beside the contact, `Ns sin qu = Nsq u − …`, where it pulls back.
    fn simpler(&self, law: &ModifiedLaw<f64>, scales: &Scales) -> Vec<Simpler> {
        if known(law, &[Hook::LatticeSine]) {
            let [s, q] =
                [Hook::LatticeSine, Hook::PeriodicNumber].map(|hook| law.get(hook).unwrap_or_default());
            let stiffness = s * q * scales.preload;
            let mut plain = *law;
            LATTICE.iter().for_each(|&hook| plain.clear(hook));
            let changes = vec![Change::from_zero(Hook::ParallelStiffness, stiffness)];
            let spring = Simpler { id: "contact.tangential-stiffness", law: plain, changes };
            return Some(spring).filter(|_| stiffness > 0.0).into_iter().collect();
        }
        if law.get(Hook::PeriodicCosine).is_none() {
            return Vec::new();
        }
        let value = |hook| law.get(hook).unwrap_or_default();
        let [c, s, q] = [Hook::PeriodicCosine, Hook::PeriodicSine, Hook::PeriodicNumber].map(value);
        let mean = (1.0 + c).max(0.1);
        let mut plain = *law;
        OWN.iter().for_each(|&hook| plain.clear(hook));
        plain.set(Hook::MuKinetic, value(Hook::MuKinetic) * mean);
        let signed = |hook, start: f64, size: f64| Change { start, ..Change::signed(hook, size) };
        let slope = s * q / mean;
        let along = signed(Hook::Position, slope, 0.1 * q);
        let square = signed(Hook::PositionSquare, -0.5 * c * q * q / mean, 0.1 * q * q);
        let cube = signed(Hook::PositionCube, -slope * q * q / 6.0, 0.1 * q.powi(3));
        let ending = Change::positive(Hook::PositionScale, 1.0 / q, 0.02);
        [vec![along.clone(), square, cube], vec![along, ending]]
            .map(|changes| Simpler { id: "friction.position", law: plain, changes })
            .into()
    }

    /// Of a wave of which less than a whole one is travelled nobody has seen that it comes again.
    fn is_idle(&self, law: &ModifiedLaw<f64>, reach: Reach) -> bool {
        law.get(Hook::PeriodicNumber).is_some_and(|q| q * reach.stroke < std::f64::consts::TAU)
    }
}

/// What a force along the path brings to a law.
const LATTICE: [Hook; 3] = [Hook::LatticeCosine, Hook::LatticeSine, Hook::PeriodicNumber];

/// What a wave along the path brings to a law.
const OWN: [Hook; 10] = [
    Hook::PeriodicCosine,
    Hook::PeriodicSine,
    Hook::PeriodicNumber,
    Hook::PeriodicCosine2,
    Hook::PeriodicSine2,
    Hook::PeriodicCosine3,
    Hook::PeriodicSine3,
    Hook::PeriodicSharpness,
    Hook::PeriodicSteepness,
    Hook::PeriodicCorner,
];

#[cfg(test)]
mod tests {
    use super::*;
    use frettrace_friction::Step;
    use frettrace_friction::effects::Circumstance;

    /// Sliding from the middle to a place, normal force 1, with a presliding range far below a wave.
    fn sliding(law: &ModifiedLaw<f64>, place: f64) -> f64 {
        let circumstance = Circumstance { preload: 1.0, ..Circumstance::default() };
        let (mut state, mut force) = (law.rest_at(0.0), 0.0);
        for k in 0..400 {
            let slip = [k, k + 1].map(|k| place * f64::from(k) / 400.0);
            let step = Step { slip, velocity: [place; 2], normal: [1.0; 2], dt: 1.0 / 400.0 };
            (state, force) = law.advance(state, &step, &circumstance);
        }
        force
    }

    /// Near the middle a wave is its own series: at `qu = ±0.2` its next term is `μc(qu)⁴/24` = 4e-6. The change that ends is near only.
    #[test]
    fn a_part_of_a_wave_is_a_change_along_the_path() {
        let q = 1e4;
        let mut wave = ModifiedLaw::dahl(1e9, 0.3);
        let values = [(Hook::PeriodicCosine, 0.2), (Hook::PeriodicSine, 0.3), (Hook::PeriodicNumber, q)];
        values.into_iter().for_each(|(hook, value)| wave.set(hook, value));
        let simpler = FrictionPositionPeriodic.simpler(&wave, &Scales::default());
        for (simpler, bound) in simpler.iter().zip([1e-5, 2e-3]) {
            let mut plain = simpler.law;
            simpler.changes.iter().for_each(|change| plain.set(change.hook, change.start));
            for place in [-0.2, 0.2] {
                let [wave, plain] = [&wave, &plain].map(|law| sliding(law, place / q));
                assert!((wave - plain).abs() < bound, "{place}: {wave} against {plain}");
            }
        }
        assert_eq!(simpler.len(), 2);
        let reach = |waves| Reach { step: 1e-5, stroke: waves * std::f64::consts::TAU / q };
        assert!(FrictionPositionPeriodic.is_idle(&wave, reach(0.9)));
        assert!(!FrictionPositionPeriodic.is_idle(&wave, reach(1.1)));
    }

    /// Near the middle a wave of the force is a spring: at `qu = ±0.1` its next term is `s(qu)³/6` = 5e-5. One that pushes further what has moved is none.
    #[test]
    fn a_part_of_a_wave_of_the_force_is_a_spring() {
        let (q, scales) = (1e4, Scales { preload: 1.0, ..Scales::default() });
        let mut wave = ModifiedLaw::dahl(1e9, 0.3);
        let values = [(Hook::LatticeCosine, 0.0), (Hook::LatticeSine, 0.3), (Hook::PeriodicNumber, q)];
        values.into_iter().for_each(|(hook, value)| wave.set(hook, value));
        let simpler = FrictionPositionPeriodic.simpler(&wave, &scales);
        let [simpler] = &simpler[..] else { panic!("one spring") };
        let mut spring = simpler.law;
        simpler.changes.iter().for_each(|change| spring.set(change.hook, change.start));
        for place in [-0.1, 0.1] {
            let [wave, spring] = [&wave, &spring].map(|law| sliding(law, place / q));
            assert!((wave - spring).abs() < 6e-5, "{place}: {wave} against {spring}");
        }
        wave.set(Hook::LatticeSine, -0.3);
        assert!(FrictionPositionPeriodic.simpler(&wave, &scales).is_empty());
    }
}
