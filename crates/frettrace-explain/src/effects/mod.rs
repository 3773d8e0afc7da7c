//! Candidate effects, one file each.
//!
//! An effect says what it adds to the model, in one or several forms (another laboratory's formula is another form of
//! the same effect), and what it may be mistaken for. To add one: a file here, a line in [`ALL`], a row in the book.

mod contact_backlash;
mod contact_lift_off;
mod contact_normal_stiffening;
mod contact_tangential_stiffness;
mod excitation_base_motion;
mod excitation_preload_modulation;
mod friction_ageing;
mod friction_asymmetry;
mod friction_breakaway;
mod friction_exponent;
mod friction_film;
mod friction_lag;
mod friction_normal_dependence;
mod friction_position;
mod friction_position_periodic;
mod friction_presliding_damping;
mod friction_stribeck;
mod friction_viscous;
mod friction_wear;
mod measurement_clipping;
mod measurement_delay;
mod measurement_dropout;
mod measurement_gain;
mod measurement_hum;
mod measurement_offset;
mod measurement_position;
mod structure_added_mass;
mod structure_clamp_compliance;
mod structure_cubic_stiffness;
mod structure_frequency_drift;
mod structure_modal_damping;
mod structure_modal_frequency;
mod structure_quadratic_damping;
mod structure_second_support;

use crate::{Case, Scales, Unknown, signed};
use frettrace_forward::accelerations::{
    COEFFICIENTS, FrequencyRatio, Port, PortLaw, PortPlace, Quantity, Setting,
};
use frettrace_friction::effects::{Hook, ModifiedLaw};
use frettrace_identify::{Parameter, Transform};

/// Where an effect lives.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum EffectPlace {
    /// In the friction contact.
    Contact,
    /// In the beam and its supports.
    Structure,
    /// In the excitation.
    Excitation,
    /// In the measurement chain.
    Measurement,
}

/// A change of one hook of the friction law.
#[derive(Clone, Debug)]
pub(crate) struct Change {
    pub hook: Hook,
    pub start: f64,
    /// How it is fitted; `None` where it is held.
    pub parameter: Option<Parameter>,
}

impl Change {
    fn new(hook: Hook, start: f64, transform: Transform, bounds: (f64, f64)) -> Self {
        let (name, unit) = hook.name_and_unit();
        let parameter = Parameter { transform, ..Parameter::positive(name, unit, bounds) };
        Self { hook, start, parameter: Some(parameter) }
    }

    /// A positive value, fitted in its logarithm down to `least` times the start and as far up.
    pub fn positive(hook: Hook, start: f64, least: f64) -> Self {
        Self::new(hook, start, Transform::Log, (least * start, start / least))
    }

    /// A positive value in a range, fitted linearly.
    pub fn between(hook: Hook, start: f64, bounds: (f64, f64)) -> Self {
        Self::new(hook, start, Transform::Linear { scale: 0.2 * start }, bounds)
    }

    /// A value that is zero without the effect and cannot be negative.
    pub fn from_zero(hook: Hook, size: f64) -> Self {
        Self::new(hook, size, Transform::Linear { scale: size }, (0.0, f64::INFINITY))
    }

    /// A value of either sign around a start.
    pub fn linear(hook: Hook, start: f64, scale: f64, bounds: (f64, f64)) -> Self {
        Self::new(hook, start, Transform::Linear { scale }, bounds)
    }

    /// A value of either sign without bounds.
    pub fn signed(hook: Hook, size: f64) -> Self {
        Self::new(hook, 0.1 * size, Transform::Linear { scale: size }, FREE)
    }

    /// A value that is held.
    pub fn fixed(hook: Hook, value: f64) -> Self {
        Self { hook, start: value, parameter: None }
    }
}

/// Puts changes into a law; the unknowns that they bring.
pub(crate) fn apply(changes: &[Change], law: &mut ModifiedLaw<f64>) -> Vec<Unknown> {
    changes.iter().for_each(|change| law.set(change.hook, change.start));
    let unknown = |change: &Change| {
        let quantity = Quantity::Law(change.hook);
        change.parameter.clone().map(|parameter| Unknown { quantity, parameter })
    };
    changes.iter().filter_map(unknown).collect()
}

/// Frees the further values of an effect's shape in a law, as far as they are not `known` to be free; what it has of them already stays.
pub(crate) fn shaped(
    effect: usize,
    law: &mut ModifiedLaw<f64>,
    known: &[Unknown],
    scales: &Scales,
) -> Vec<Unknown> {
    freed(ALL[effect].shape(law, scales), law, known)
}

/// The same of any values.
pub(crate) fn freed(mut changes: Vec<Change>, law: &mut ModifiedLaw<f64>, known: &[Unknown]) -> Vec<Unknown> {
    changes.retain(|change| known.iter().all(|u| u.quantity != Quantity::Law(change.hook)));
    for change in &mut changes {
        change.start = law.get(change.hook).unwrap_or(change.start);
    }
    apply(&changes, law)
}

/// Hooks that forms of an effect set and leave as they are: which formula it is.
pub(crate) fn set_by_forms(
    effect: usize,
    law: &ModifiedLaw<f64>,
    scales: &Scales,
) -> impl Iterator<Item = Hook> + use<> {
    let changes = ALL[effect].contact_forms(law, scales).into_iter().flat_map(|form| form.changes);
    changes.filter(|change| change.parameter.is_none()).map(|change| change.hook)
}

/// One form of an effect in the contact.
#[derive(Clone, Debug)]
pub(crate) struct ContactForm {
    pub changes: Vec<Change>,
    /// Frequency with which the preload is modulated, of a form that modulates it; beside any other it is as it was.
    pub modulation: Option<FrequencyRatio>,
}

impl ContactForm {
    pub fn new(changes: Vec<Change>) -> Self {
        Self { changes, modulation: None }
    }

    /// Which formula it is, whatever it begins from: the hooks that it changes.
    pub fn formula(&self) -> Vec<Hook> {
        self.changes.iter().map(|change| change.hook).collect()
    }
}

/// One form of an effect in the structure, the excitation or the measurement.
#[derive(Clone, Debug)]
pub(crate) struct StructureForm {
    pub setting: Setting,
    pub unknowns: Vec<Unknown>,
    pub sensor: Option<usize>,
}

impl StructureForm {
    /// Whether it puts one more force on the beam or on a mode than a setting has: such a force can be found without its law. One at the support is the contact's.
    pub fn adds_a_force(&self, to: &Setting) -> bool {
        let added = &self.setting.ports[to.ports.len().min(self.setting.ports.len())..];
        added.iter().any(|port| matches!(port.place, PortPlace::At(_) | PortPlace::Mode(_)))
    }
}

/// A simpler effect in the place of a richer one.
pub(crate) struct Simpler {
    /// Its id.
    pub id: &'static str,
    /// The law without the richer effect, with the values of its own that the simpler one asks for.
    pub law: ModifiedLaw<f64>,
    /// The simpler effect, from the values that come nearest to the richer one.
    pub changes: Vec<Change>,
}

/// How finely and how far the runs go through what an effect may tell.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Reach {
    /// Shortest step of the phase grids (s).
    pub step: f64,
    /// Longest way from one end of the slip to the other (m).
    pub stroke: f64,
}

/// A candidate effect.
pub(crate) trait Effect: Sync {
    /// Its id in the contract's list.
    fn id(&self) -> &'static str;

    /// Where it lives.
    fn place(&self) -> EffectPlace;

    /// Ids it may be mistaken for.
    fn rivals(&self) -> &'static [&'static str];

    /// The experiment that tells it from its rivals.
    fn experiment(&self) -> &'static str;

    /// Its forms in the contact; none where the law already has its mechanism.
    fn contact_forms(&self, _law: &ModifiedLaw<f64>, _scales: &Scales) -> Vec<ContactForm> {
        Vec::new()
    }

    /// Further values of the shape it has in a law, from those that add nothing, for data that its forms do not satisfy.
    fn shape(&self, _law: &ModifiedLaw<f64>, _scales: &Scales) -> Vec<Change> {
        Vec::new()
    }

    /// Values of another shape that it may have in a law, which could stand in for what a simpler effect or another law does: asked for where nothing
    /// else explains.
    fn other_shape(&self, _law: &ModifiedLaw<f64>, _scales: &Scales) -> Vec<Change> {
        Vec::new()
    }

    /// Further values of the shape of what it adds to the structure, which is in `setting` already.
    fn further_terms(&self, _case: &Case, _setting: &Setting, _scales: &Scales) -> Vec<Unknown> {
        Vec::new()
    }

    /// Simpler effects that come near to this one as it was fitted: what it found is where they may begin.
    fn simpler(&self, _law: &ModifiedLaw<f64>, _scales: &Scales) -> Vec<Simpler> {
        Vec::new()
    }

    /// Times of its memory: without one it is a simpler effect that it contains.
    fn memories(&self) -> &'static [Hook] {
        &[]
    }

    /// Whether a fitted law has this effect without what tells it from the simpler ones that it contains.
    fn is_idle(&self, law: &ModifiedLaw<f64>, reach: Reach) -> bool {
        forgets(law, self.memories(), reach.step)
    }

    /// Whether what it has brought to a law does nearly what a rival outside the contact does, so that it is asked against that however little it leaves.
    fn acts_like_one_outside(&self, _law: &ModifiedLaw<f64>) -> bool {
        false
    }

    /// Whether what it names is one formula: then what its forms leave is something else.
    fn is_exact(&self) -> bool {
        false
    }

    /// Its forms in structure, excitation or measurement.
    fn structure_forms(&self, _case: &Case, _setting: &Setting, _scales: &Scales) -> Vec<StructureForm> {
        Vec::new()
    }
}

/// Whether a law has memories of the motion, and all their times are below the step of the phase grid: none that could be seen.
fn forgets(law: &ModifiedLaw<f64>, times: &[Hook], step: f64) -> bool {
    let longest = times.iter().filter_map(|&hook| law.get(hook)).fold(0.0, f64::max);
    longest > 0.0 && longest < step
}

/// Ids of all effects.
pub fn effect_ids() -> impl Iterator<Item = &'static str> {
    ALL.iter().map(|effect| effect.id())
}

/// Place in [`ALL`] of the effect with an id.
pub(crate) fn listed(id: &str) -> Option<usize> {
    ALL.iter().position(|effect| effect.id() == id)
}

/// Every effect.
pub(crate) const ALL: [&dyn Effect; 34] = [
    &friction_stribeck::FrictionStribeck,
    &friction_viscous::FrictionViscous,
    &friction_lag::FrictionLag,
    &friction_film::FrictionFilm,
    &friction_ageing::FrictionAgeing,
    &friction_asymmetry::FrictionAsymmetry,
    &friction_breakaway::FrictionBreakaway,
    &friction_exponent::FrictionExponent,
    &friction_presliding_damping::FrictionPreslidingDamping,
    &friction_position::FrictionPosition,
    &friction_position_periodic::FrictionPositionPeriodic,
    &friction_normal_dependence::FrictionNormalDependence,
    &friction_wear::FrictionWear,
    &contact_lift_off::ContactLiftOff,
    &contact_normal_stiffening::ContactNormalStiffening,
    &contact_tangential_stiffness::ContactTangentialStiffness,
    &contact_backlash::ContactBacklash,
    &structure_cubic_stiffness::StructureCubicStiffness,
    &structure_quadratic_damping::StructureQuadraticDamping,
    &structure_clamp_compliance::StructureClampCompliance,
    &structure_added_mass::StructureAddedMass,
    &structure_second_support::StructureSecondSupport,
    &structure_modal_frequency::StructureModalFrequency,
    &structure_modal_damping::StructureModalDamping,
    &structure_frequency_drift::StructureFrequencyDrift,
    &excitation_preload_modulation::ExcitationPreloadModulation,
    &excitation_base_motion::ExcitationBaseMotion,
    &measurement_gain::MeasurementGain,
    &measurement_delay::MeasurementDelay,
    &measurement_position::MeasurementPosition,
    &measurement_offset::MeasurementOffset,
    &measurement_hum::MeasurementHum,
    &measurement_clipping::MeasurementClipping,
    &measurement_dropout::MeasurementDropout,
];

/// No bounds.
pub(crate) const FREE: (f64, f64) = (f64::NEG_INFINITY, f64::INFINITY);

fn known(law: &ModifiedLaw<f64>, hooks: &[Hook]) -> bool {
    hooks.iter().any(|hook| law.get(*hook).is_some())
}

fn with_port(setting: &Setting, port: Port) -> (Setting, usize) {
    let mut setting = setting.clone();
    setting.ports.push(port);
    let index = setting.ports.len() - 1;
    (setting, index)
}

/// Places along the beam (m) from which one is looked for: two neighbours are a quarter of a wave of its twelfth mode apart. Where many lines stand far
/// above the noise a place is told within such a part only.
fn along(scales: &Scales) -> impl Iterator<Item = f64> {
    const PARTS: u8 = 24;
    let length = scales.length;
    (2..PARTS).map(move |part| length * f64::from(part) / f64::from(PARTS))
}

/// A force without a law yet at a place of the beam, with what it brings, which depends on the index of its port.
fn force_at(
    setting: &Setting,
    place: PortPlace,
    brings: impl FnOnce(usize) -> Vec<Unknown>,
) -> StructureForm {
    let port = Port { place, law: PortLaw::Polynomial, coefficients: [0.0; COEFFICIENTS] };
    let (setting, index) = with_port(setting, port);
    StructureForm { setting, unknowns: brings(index), sensor: None }
}

/// Such a force on each of the first two modes.
fn forces_on_modes(setting: &Setting, brings: impl Fn(usize) -> Vec<Unknown>) -> Vec<StructureForm> {
    let modes = setting.frequency.len().min(2);
    (0..modes).map(|mode| force_at(setting, PortPlace::Mode(mode), &brings)).collect()
}

/// Such a force along the beam, whose place is an unknown as well.
fn forces_along(
    setting: &Setting,
    scales: &Scales,
    brings: impl Fn(usize) -> Vec<Unknown>,
) -> Vec<StructureForm> {
    let placed = |index| {
        let mut unknowns = brings(index);
        unknowns.push(place(Quantity::PortPosition(index), scales));
        unknowns
    };
    along(scales).map(|at| force_at(setting, PortPlace::At(at), placed)).collect()
}

/// Forms of which each is asked of the whole model: a few of those that differ by their place.
pub(crate) fn few_places(mut forms: Vec<StructureForm>) -> Vec<StructureForm> {
    const FEW: usize = 6;
    let is_placed = |form: &StructureForm| form.unknowns.iter().any(|u| u.quantity.is_place());
    let places = forms.iter().filter(|form| is_placed(form)).count();
    let mut place = (0..places).map(|k| k % places.div_ceil(FEW) == 0);
    forms.retain(|form| !is_placed(form) || place.next() == Some(true));
    forms
}

/// A position along the beam.
fn place(quantity: Quantity, scales: &Scales) -> Unknown {
    let bounds = (0.02 * scales.length, 0.98 * scales.length);
    signed(quantity, ("position", "m"), 0.03 * scales.length, bounds)
}

/// Static stiffness of a cantilever's tip, `3EI/L³`.
fn spring_scale(case: &Case) -> f64 {
    3.0 * case.rig.beam.bending_stiffness / case.rig.beam.length.powi(3)
}

/// A cubic coefficient that matters at a displacement of a hundredth of the beam's length.
fn cube_scale(case: &Case, scales: &Scales, modal: bool) -> f64 {
    let mass = if modal { scales.mass } else { 1.0 };
    spring_scale(case) / (1e-4 * scales.length.powi(2)) / (mass * mass)
}

/// A quadratic damping that matters at a velocity of a metre a second.
fn drag_scale(case: &Case, modal: bool) -> f64 {
    let mass = case.rig.beam.mass_per_length * case.rig.beam.length;
    if modal { 1.0 / mass.sqrt() } else { 0.1 * mass }
}
