//! Candidate effects of a contact record and their forms.
//!
//! A record shows the force itself, so forms that accelerations cannot tell are tried too: play in series with the
//! contact, a static peak that wears off with slip, an offset that grows with the load.

use super::setting::{RecordQuantity, RecordSetting, RecordUnknown, mass};
use super::{RecordCase, RecordScales};
use crate::Place;
use frettrace_friction::effects::Hook;
use frettrace_identify::{Parameter, Transform};

/// A way in which an effect enters the model: unknowns that are added, hooks that are held.
#[derive(Clone, Debug, Default)]
pub(super) struct Form {
    pub unknowns: Vec<RecordUnknown>,
    pub held: Vec<(Hook, f64)>,
}

/// A candidate with its forms.
#[derive(Clone, Debug)]
pub(super) struct Candidate {
    pub id: &'static str,
    pub place: Place,
    pub experiment: &'static str,
    pub forms: Vec<Form>,
}

impl Form {
    fn of(unknowns: Vec<RecordUnknown>) -> Self {
        Self { unknowns, held: Vec::new() }
    }

    fn one(unknown: RecordUnknown) -> Self {
        Self::of(vec![unknown])
    }
}

fn unknown(
    quantity: RecordQuantity,
    (name, unit): (&str, &str),
    value: f64,
    shape: (Transform, (f64, f64)),
) -> RecordUnknown {
    let parameter = Parameter { transform: shape.0, ..Parameter::positive(name, unit, shape.1) };
    RecordUnknown { quantity, parameter, value }
}

fn hook(hook: Hook, value: f64, shape: (Transform, (f64, f64))) -> RecordUnknown {
    unknown(RecordQuantity::Law(hook), hook.name_and_unit(), value, shape)
}

/// A positive value of unknown size.
fn positive(of: Hook, value: f64) -> RecordUnknown {
    hook(of, value, (Transform::Log, (1e-3 * value, 1e3 * value)))
}

/// A value in a range, zero or a typical one to begin with.
fn ranged(of: Hook, value: f64, scale: f64, bounds: (f64, f64)) -> RecordUnknown {
    hook(of, value, (Transform::Linear { scale }, bounds))
}

/// A value of either sign that is zero without the effect.
fn signed(of: Hook, scale: f64) -> RecordUnknown {
    ranged(of, 0.1 * scale, scale, (-1e3 * scale, 1e3 * scale))
}

/// A value that is zero without the effect and not negative.
fn rising(of: Hook, scale: f64) -> RecordUnknown {
    ranged(of, scale, scale, (0.0, 1e4 * scale))
}

/// All candidates that make sense for the record and that the setting does not have already.
pub(super) fn candidates(
    case: &RecordCase,
    setting: &RecordSetting,
    scales: &RecordScales,
) -> Vec<Candidate> {
    let mut list = velocity(setting, scales);
    list.extend(memory(setting, scales));
    list.extend(presliding(setting, scales));
    list.extend(places(setting, scales));
    list.extend(loads(setting, scales));
    list.extend(beside(case, setting, scales));
    list.retain(|candidate| !candidate.forms.is_empty());
    list
}

fn contact(id: &'static str, experiment: &'static str, forms: Vec<Form>) -> Candidate {
    Candidate { id, place: Place::Contact, experiment, forms }
}

fn mu(setting: &RecordSetting) -> f64 {
    setting.law.get(Hook::MuKinetic).unwrap_or(1.0)
}

fn has(setting: &RecordSetting, hook: Hook) -> bool {
    setting.law.get(hook).is_some()
}

/// Stribeck's curve around a share of the top speed, exponential or rational.
fn stribeck(setting: &RecordSetting, scales: &RecordScales, (share, rational): (f64, bool)) -> Form {
    let mut form = Form::of(vec![
        rising(Hook::StribeckRise, 0.2 * mu(setting)),
        positive(Hook::StribeckVelocity, share * scales.velocity),
        ranged(Hook::StribeckExponent, 1.5, 0.3, (0.3, 6.0)),
    ]);
    if rational {
        form.held.push((Hook::RationalShare, 1.0));
    }
    form
}

fn velocity(setting: &RecordSetting, scales: &RecordScales) -> Vec<Candidate> {
    let drag = 0.1 * mu(setting) * scales.normal / scales.velocity;
    let mut falls = Vec::new();
    if !has(setting, Hook::StribeckRise) {
        for share in [0.04, 0.2, 0.6] {
            falls.extend([false, true].map(|rational| stribeck(setting, scales, (share, rational))));
        }
    }
    let mut drags = Vec::new();
    if !has(setting, Hook::Viscous) {
        drags.push(Form::one(rising(Hook::Viscous, drag)));
        drags.push(Form::of(vec![
            ranged(Hook::Viscous, drag, drag, (-1e4 * drag, 1e4 * drag)),
            signed(Hook::ViscousSquare, drag / scales.velocity),
        ]));
    } else if !has(setting, Hook::ViscousSquare) {
        drags.push(Form::one(signed(Hook::ViscousSquare, drag / scales.velocity)));
    }
    vec![
        contact(
            "friction.stribeck",
            "strokes at speeds from a tenth to ten times the present one, in both orders",
            falls,
        ),
        contact("friction.viscous", "strokes at speeds above the present ones", drags),
    ]
}

fn memory(setting: &RecordSetting, scales: &RecordScales) -> Vec<Candidate> {
    let known = [Hook::LagTime, Hook::SpeedLag, Hook::VelocityLag, Hook::FilmLoss, Hook::AgeingGain];
    if known.into_iter().any(|hook| has(setting, hook)) {
        return Vec::new();
    }
    let (mut lags, mut films, mut ages) = (Vec::new(), Vec::new(), Vec::new());
    for share in [0.01, 0.06] {
        let time = share * scales.period;
        for lag in [Hook::LagTime, Hook::VelocityLag] {
            let mut form = if has(setting, Hook::StribeckRise) {
                Form::default()
            } else {
                stribeck(setting, scales, (0.2, false))
            };
            form.unknowns.push(positive(lag, time));
            lags.push(form);
        }
        lags.push(Form::one(positive(Hook::ForceLag, 0.3 * time)));
        films.extend([0.2, 0.7].map(|speed| {
            Form::of(vec![
                ranged(Hook::FilmLoss, 0.2, 0.1, (0.0, 0.95)),
                positive(Hook::FilmVelocity, speed * scales.velocity),
                positive(Hook::FilmRise, time),
                positive(Hook::FilmFall, time),
            ])
        }));
    }
    for distance in [0.03, 0.15, 0.6] {
        ages.push(Form::of(vec![
            ranged(Hook::AgeingGain, 0.05, 0.03, (0.0, 3.0)),
            positive(Hook::AgeingDistance, distance * scales.slip),
            positive(Hook::AgeingTime, 0.02 * scales.period),
        ]));
    }
    vec![
        contact("friction.lag", "the same strokes at half and at double the frequency", lags),
        contact("friction.film", "a pause before the first stroke, and strokes of other speeds", films),
        contact("friction.ageing", "holds of different length before a stroke", ages),
    ]
}

fn presliding(setting: &RecordSetting, scales: &RecordScales) -> Vec<Candidate> {
    let friction = mu(setting) * scales.normal;
    let sigma0 = setting.law.get(Hook::Sigma0).unwrap_or(1.0);
    let mut shapes = Vec::new();
    if !has(setting, Hook::Exponent) && !has(setting, Hook::Breakaway) {
        shapes.push(Form::one(ranged(Hook::Exponent, 0.8, 0.2, (0.02, 8.0))));
    }
    let mut elastic = Vec::new();
    if !has(setting, Hook::Breakaway) {
        elastic.extend([0.2, 0.6].map(|share| Form::one(ranged(Hook::Breakaway, share, 0.2, (0.0, 0.95)))));
    }
    let mut damped = Vec::new();
    if !has(setting, Hook::Sigma1) {
        let damping = 0.3 * mu(setting) / scales.velocity;
        damped.push(Form::one(rising(Hook::Sigma1, damping)));
        damped.push(Form::of(vec![
            rising(Hook::Sigma1, damping),
            positive(Hook::DampingVelocity, 0.2 * scales.velocity),
        ]));
    }
    let mut springs = Vec::new();
    if !has(setting, Hook::ParallelStiffness) {
        let stiffness = 0.05 * friction / scales.slip;
        springs.push(Form::one(signed(Hook::ParallelStiffness, stiffness)));
        springs.push(Form::of(vec![
            signed(Hook::ParallelStiffness, stiffness),
            signed(Hook::ParallelCubic, stiffness / scales.slip.powi(2)),
        ]));
    }
    if !has(setting, Hook::SeriesCompliance) {
        springs.push(Form::one(rising(Hook::SeriesCompliance, 0.1 / (sigma0 * scales.normal))));
    }
    vec![
        contact("friction.exponent", "loops that just slide, in small steps of amplitude", shapes),
        contact("friction.breakaway", "loops below and just above sliding, in small steps", elastic),
        contact("friction.presliding-damping", "small loops at two frequencies", damped),
        contact("contact.tangential-stiffness", "the contact opened: a spring beside it stays", springs),
        contact(
            "contact.backlash",
            "a slow reversal: with play the force rests while it is crossed",
            play(setting, scales),
        ),
    ]
}

/// Play before the contact (the force is held while it is crossed) or in series with it (the force rests at zero).
fn play(setting: &RecordSetting, scales: &RecordScales) -> Vec<Form> {
    let mut forms = Vec::new();
    for share in [0.01, 0.06, 0.2] {
        let half = share * scales.slip;
        if !has(setting, Hook::Backlash) {
            forms.push(Form::one(positive(Hook::Backlash, half)));
        }
        if setting.get(RecordQuantity::Gap).is_none() {
            let shape = (Transform::Linear { scale: half }, (0.0, scales.slip));
            forms.push(Form::one(unknown(RecordQuantity::Gap, ("half_gap", "m"), half, shape)));
        }
    }
    forms
}

fn places(setting: &RecordSetting, scales: &RecordScales) -> Vec<Candidate> {
    let size = 0.1 / scales.slip;
    let (mut along, mut waves) = (Vec::new(), Vec::new());
    if !has(setting, Hook::Position) {
        along.push(Form::one(signed(Hook::Position, size)));
        along.push(Form::of(vec![
            signed(Hook::Position, size),
            signed(Hook::PositionSquare, size / scales.slip),
        ]));
    }
    if !has(setting, Hook::PeriodicNumber) {
        // Up to sixteen waves over the range of the slip; fewer than five quarters are a dependence on position.
        let waves_of = |count: f64| std::f64::consts::PI * count / scales.slip;
        for count in [1.5, 2.0, 3.0, 4.0, 5.5, 8.0, 11.0, 16.0] {
            let number = waves_of(count);
            let shape = (Transform::Linear { scale: 0.3 / scales.slip }, (waves_of(1.25), waves_of(40.0)));
            waves.push(Form::of(vec![
                signed(Hook::PeriodicCosine, 0.05),
                signed(Hook::PeriodicSine, 0.05),
                hook(Hook::PeriodicNumber, number, shape),
            ]));
        }
    }
    let mut sides = Vec::new();
    if !has(setting, Hook::Asymmetry) {
        sides.push(Form::one(ranged(Hook::Asymmetry, 0.01, 0.1, (-0.95, 0.95))));
    }
    vec![
        contact("friction.position", "strokes about another middle: the change moves with the place", along),
        contact("friction.position-periodic", "strokes about another middle and of other lengths", waves),
        contact("friction.asymmetry", "the specimen turned round: friction turns, an offset does not", sides),
    ]
}

fn loads(setting: &RecordSetting, scales: &RecordScales) -> Vec<Candidate> {
    let mut exponents = Vec::new();
    if scales.loads_differ && !has(setting, Hook::NormalExponent) {
        exponents.push(Form::one(ranged(Hook::NormalExponent, 0.1, 0.1, (-2.0, 2.0))));
        // Friction that is affine in the load: a contact that is pressed together without any.
        let shape = (Transform::Linear { scale: 0.1 * scales.normal }, (0.0, 100.0 * scales.normal));
        let quantity = RecordQuantity::Squeeze;
        exponents.push(Form::one(unknown(quantity, ("squeeze", "N"), 0.2 * scales.normal, shape)));
    }
    let mut worn = Vec::new();
    if !has(setting, Hook::Wear) {
        worn.push(Form::one(ranged(Hook::Wear, 0.02, 0.05, (-0.9, 5.0))));
    }
    vec![
        contact("friction.normal-dependence", "the same strokes at three loads", exponents),
        contact("friction.wear", "the first run repeated at the end", worn),
    ]
}

fn beside(case: &RecordCase, setting: &RecordSetting, scales: &RecordScales) -> Vec<Candidate> {
    let mut masses = Vec::new();
    if case.mass == super::MovingMass::None && scales.acceleration > 0.0 {
        masses.push(Form::one(mass(scales.force / scales.acceleration)));
    }
    masses.retain(|_| setting.get(RecordQuantity::Mass).is_none());
    let free = |value| (Transform::Linear { scale: value }, (-1e3 * value, 1e3 * value));
    let constant = || {
        let now = setting.get(RecordQuantity::Offset).unwrap_or(0.0);
        // Beyond half the force it would be no offset any more: the force would hardly change its sign.
        let shape =
            (Transform::Linear { scale: 0.1 * scales.force }, (-0.5 * scales.force, 0.5 * scales.force));
        unknown(RecordQuantity::Offset, ("force_offset", "N"), now, shape)
    };
    let bounded =
        setting.unknowns.iter().any(|u| u.quantity == RecordQuantity::Offset && u.parameter.prior.is_some());
    let mut offsets = Vec::new();
    if bounded {
        offsets.push(Form::one(constant()));
    }
    if scales.loads_differ && setting.get(RecordQuantity::LoadOffset).is_none() {
        let share = unknown(RecordQuantity::LoadOffset, ("load_offset", "1"), 0.01, free(0.05));
        offsets.push(Form::of(vec![constant(), share]));
    }
    let mut late = Vec::new();
    if setting.get(RecordQuantity::Delay).is_none() {
        let time = 1e-3 * scales.period;
        let shape = (Transform::Linear { scale: time }, (-20.0 * time, 20.0 * time));
        late.push(Form::one(unknown(RecordQuantity::Delay, ("force_delay", "s"), 0.1 * time, shape)));
    }
    let turned = "the specimen turned round: friction turns, an offset does not";
    vec![
        Candidate {
            id: "structure.added-mass",
            place: Place::Structure,
            experiment: "the same strokes at double the frequency: inertia grows fourfold",
            forms: masses,
        },
        Candidate { id: "measurement.offset", place: Place::Measurement, experiment: turned, forms: offsets },
        Candidate {
            id: "measurement.delay",
            place: Place::Measurement,
            experiment: "the same strokes at half and at double the frequency",
            forms: late,
        },
    ]
}
